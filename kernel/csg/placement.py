"""Placements: matrices of six digits made exact again, and primitives that take scale and mirror into themselves.

A placement that only scales a primitive within its own family (a block along its axes, a cylinder along and across
its axis, anything uniformly) becomes a bigger primitive placed rigidly; a mirror becomes a rotation of the mirrored
primitive, which is of the same family always. What is left (an ellipsoid, a sheared block) keeps its affine matrix,
whose determinant is positive then.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TypeVar

import numpy as np

from kernel.csg.source import MAX_NUMBER, MIN_SIZE
from kernel.csg.tree import (
    Block,
    Cone,
    Cylinder,
    Extrusion,
    Matrix,
    Polyhedron,
    Primitive,
    Revolution,
    Sphere,
    Torus,
    Wedge,
    frozen_array,
)
from kernel.errors import ReadError
from kernel.units import RIGID_TOLERANCE

AnyPrimitive = TypeVar("AnyPrimitive", bound=Primitive)
Factors = tuple[float, float, float]

EXACT_TOLERANCE = 1e-9
"""Relative. Mended matrices are orthogonal to rounding; their products stay within this."""

ANGLE_STEP = 1e-3
"""Degrees. Rotations of whole steps are recognised behind their six digits."""

_I3 = np.eye(3)


def sine(degrees: float) -> float:
    """Sine of an angle in degrees, exact at multiples of 30."""
    turn = math.fmod(degrees, 360.0)
    half = {0: 0.0, 30: 0.5, 90: 1.0, 150: 0.5, 180: 0.0, 210: -0.5, 270: -1.0, 330: -0.5}
    if turn == int(turn):
        exact = half.get(int(turn) % 360)
        if exact is not None:
            return exact
    return math.sin(math.radians(turn))


def cosine(degrees: float) -> float:
    """Cosine of an angle in degrees, exact at multiples of 60 and 90."""
    return sine(math.fmod(degrees, 360.0) + 90.0)


def rotation(axis: str, degrees: float) -> Matrix:
    """(4, 4) rotation about the global axis "x", "y" or "z"."""
    c, s = cosine(degrees), sine(degrees)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    matrix = np.eye(4)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def translation(x: float, y: float, z: float) -> Matrix:
    """(4, 4) shift."""
    matrix = np.eye(4)
    matrix[:3, 3] = x, y, z
    return matrix


def mended(matrix: Sequence[Sequence[float]]) -> Matrix:
    """`matrix` ((4, 4), six digits) with its rotation made exact: rigid, mirrored, or a rotation times axis factors."""
    result = np.array(matrix, dtype=np.float64)
    result[:3, :3] = _mended_linear(tuple(result[:3, :3].ravel().tolist()))
    return result


def mended_rigid(matrix: Matrix) -> Matrix:
    """`matrix` (4, 4) made exactly rigid where it is so within RIGID_TOLERANCE and not exactly; else unchanged."""
    linear = matrix[:3, :3]
    off = np.abs(linear.T @ linear - _I3).max()
    if not EXACT_TOLERANCE < off <= RIGID_TOLERANCE:
        return matrix
    left, _, right = np.linalg.svd(linear)
    result = matrix.copy()
    result[:3, :3] = left @ right
    return result


@lru_cache(maxsize=4096)
def _mended_linear(entries: tuple[float, ...]) -> Matrix:
    """(3, 3) whose nine entries are given; unchanged where it is neither R diag(s) nor diag(s) R."""
    if all(entry in (0.0, 1.0, -1.0) for entry in entries):
        return np.array(entries).reshape(3, 3)
    linear = np.array(entries).reshape(3, 3)
    by_columns = _unit_columns(linear)
    if by_columns is not None:
        unit, factors = by_columns
        if (factors == 1.0).all():
            return _recognised(unit, entries)
        return unit * factors
    by_rows = _unit_columns(linear.T)
    if by_rows is not None:
        unit, factors = by_rows
        return (unit * factors).T
    return linear


def _unit_columns(linear: Matrix) -> tuple[Matrix, Matrix] | None:
    """(rotation, factors) with linear = rotation * factors within RIGID_TOLERANCE, or None."""
    factors = np.linalg.norm(linear, axis=0)
    if not (factors > 0).all():
        return None
    unit = linear / factors
    if np.abs(unit.T @ unit - _I3).max() > RIGID_TOLERANCE:
        return None
    if np.abs(factors - 1).max() <= RIGID_TOLERANCE:
        factors = np.ones(3)
    elif np.abs(factors / factors.mean() - 1).max() <= RIGID_TOLERANCE:
        factors = np.full(3, float(f"{factors.mean():.6g}"))
    else:
        factors = np.array([float(f"{factor:.6g}") for factor in factors])
    if not np.isin(unit, (0.0, 1.0, -1.0)).all():
        left, _, right = np.linalg.svd(unit)
        unit = left @ right
        unit[np.abs(unit) < 1e-15] = 0.0
    return unit, factors


def _recognised(unit: Matrix, entries: tuple[float, ...]) -> Matrix:
    """The rotation Rz Ry Rx of whole ANGLE_STEPs that prints as `entries`, else `unit` itself."""
    if np.linalg.det(unit) < 0:
        return unit
    angles = (
        math.degrees(math.atan2(unit[2, 1], unit[2, 2])),
        math.degrees(math.asin(max(-1.0, min(1.0, -unit[2, 0])))),
        math.degrees(math.atan2(unit[1, 0], unit[0, 0])),
    )
    x, y, z = (round(angle / ANGLE_STEP) * ANGLE_STEP for angle in angles)
    x, y, z = (float(f"{angle:.12g}") for angle in (x, y, z))
    candidate: Matrix = (rotation("z", z) @ rotation("y", y) @ rotation("x", x))[:3, :3]
    for exact, printed in zip(candidate.ravel().tolist(), entries):
        half_digit = 0.501 * 10.0 ** (math.floor(math.log10(abs(printed))) - 5) if printed else 1e-12
        if abs(exact - printed) > half_digit:
            return unit
    return candidate


def place(primitive: AnyPrimitive, matrix: Matrix) -> Primitive:
    """`primitive` moved by `matrix` on top of its own placement, scale and mirror taken into it where they can be.

    matrix: (4, 4), affine, its determinant not 0. ReadError: it is too large or too small to compute with.
    """
    placement = np.array(matrix @ primitive.placement)
    size = np.abs(placement).max()
    if not size <= MAX_NUMBER or np.linalg.norm(placement[:3, :3], axis=0).min() < MIN_SIZE:
        raise ReadError(
            f"placements scale or move the {primitive.kind} out of all bounds, "
            f"expected factors of {MIN_SIZE:g} to {MAX_NUMBER:g} and shifts up to {MAX_NUMBER:g} in all",
            place=primitive.place,
        )
    factors, mirrored = _shape_of(placement[:3, :3].tobytes())
    moved: Primitive = primitive
    if factors is not None:
        scaled = _SCALED[type(primitive)](primitive, factors) if type(primitive) in _SCALED else None
        if scaled is not None:
            moved = scaled
            placement[:3, :3] /= factors
    if mirrored:
        moved, flip = _MIRRORED[type(primitive)](moved)
        placement = placement @ flip
    return replace(moved, placement=frozen_array(placement + 0.0))


@lru_cache(maxsize=4096)
def _shape_of(linear: bytes) -> tuple[Factors | None, bool]:
    """(factors or None, mirrored) of a (3, 3): factors where its columns are orthogonal and not all of length 1."""
    columns = np.frombuffer(linear, dtype=np.float64).reshape(3, 3)
    mirrored = bool(np.linalg.det(columns) < 0)
    lengths = np.linalg.norm(columns, axis=0)
    unit = columns / lengths
    if np.abs(unit.T @ unit - _I3).max() > EXACT_TOLERANCE or np.abs(lengths - 1).max() <= EXACT_TOLERANCE:
        return None, mirrored
    if lengths.max() / lengths.min() - 1 <= EXACT_TOLERANCE:
        lengths[:] = lengths.mean()
    x, y, z = (float(f"{length:.12g}") for length in lengths)
    return (x, y, z), mirrored


def _scaled_block(block: Block, s: Factors) -> Block:
    x, y, z = block.size
    return replace(block, size=(x * s[0], y * s[1], z * s[2]))


def _scaled_wedge(wedge: Wedge, s: Factors) -> Wedge:
    x, y, z = wedge.size
    return replace(wedge, size=(x * s[0], y * s[1], z * s[2]))


def _scaled_cylinder(cylinder: Cylinder, s: Factors) -> Cylinder | None:
    if s[0] != s[1]:
        return None
    return replace(cylinder, radius=cylinder.radius * s[0], height=cylinder.height * s[2])


def _scaled_cone(cone: Cone, s: Factors) -> Cone | None:
    if s[0] != s[1]:
        return None
    return replace(
        cone, bottom_radius=cone.bottom_radius * s[0], top_radius=cone.top_radius * s[0], height=cone.height * s[2]
    )


def _scaled_sphere(sphere: Sphere, s: Factors) -> Sphere | None:
    return replace(sphere, radius=sphere.radius * s[0]) if s[0] == s[1] == s[2] else None


def _scaled_torus(torus: Torus, s: Factors) -> Torus | None:
    if not s[0] == s[1] == s[2]:
        return None
    return replace(torus, major_radius=torus.major_radius * s[0], minor_radius=torus.minor_radius * s[0])


def _scaled_extrusion(extrusion: Extrusion, s: Factors) -> Extrusion | None:
    if extrusion.twist and s[0] != s[1]:
        return None
    loops = tuple(frozen_array(loop * s[:2]) for loop in extrusion.loops)
    return replace(extrusion, loops=loops, height=extrusion.height * s[2])


def _scaled_revolution(revolution: Revolution, s: Factors) -> Revolution | None:
    if s[0] != s[1]:
        return None
    return replace(revolution, loops=tuple(frozen_array(loop * (s[0], s[2])) for loop in revolution.loops))


def _scaled_polyhedron(polyhedron: Polyhedron, s: Factors) -> Polyhedron:
    return replace(polyhedron, points=frozen_array(polyhedron.points * s))


_SCALED: dict[type[Primitive], Callable] = {
    Block: _scaled_block,
    Wedge: _scaled_wedge,
    Cylinder: _scaled_cylinder,
    Cone: _scaled_cone,
    Sphere: _scaled_sphere,
    Torus: _scaled_torus,
    Extrusion: _scaled_extrusion,
    Revolution: _scaled_revolution,
    Polyhedron: _scaled_polyhedron,
}
"""(primitive, factors along its own axes) -> the scaled primitive, or None where that leaves the family."""


def _flip(axis: int, shift: float = 0.0) -> Matrix:
    matrix = np.eye(4)
    matrix[axis, axis] = -1.0
    matrix[axis, 3] = shift
    return matrix


def _same_mirrored(primitive: Primitive) -> tuple[Primitive, Matrix]:
    return primitive, _flip(1)


def _block_mirrored(block: Block) -> tuple[Block, Matrix]:
    return block, _flip(2, block.size[2])


def _wedge_mirrored(wedge: Wedge) -> tuple[Wedge, Matrix]:
    return wedge, _flip(2, wedge.size[2])


def _extrusion_mirrored(extrusion: Extrusion) -> tuple[Extrusion, Matrix]:
    if not extrusion.twist and extrusion.scale == (1.0, 1.0):
        return extrusion, _flip(2, extrusion.height)
    loops = tuple(frozen_array((loop * (1.0, -1.0))[::-1] + 0.0) for loop in extrusion.loops)
    return replace(extrusion, loops=loops, twist=-extrusion.twist + 0.0), _flip(1)


def _revolution_mirrored(revolution: Revolution) -> tuple[Revolution, Matrix]:
    turn = 0.0 if revolution.angle == 360.0 else -revolution.angle
    return revolution, _flip(1) @ rotation("z", turn)


def _polyhedron_mirrored(polyhedron: Polyhedron) -> tuple[Polyhedron, Matrix]:
    points = frozen_array(polyhedron.points * (1.0, -1.0, 1.0) + 0.0)
    return replace(polyhedron, points=points, faces=tuple(face[::-1] for face in polyhedron.faces)), _flip(1)


_MIRRORED: dict[type[Primitive], Callable] = {
    Block: _block_mirrored,
    Wedge: _wedge_mirrored,
    Cylinder: _same_mirrored,
    Cone: _same_mirrored,
    Sphere: _same_mirrored,
    Torus: _same_mirrored,
    Extrusion: _extrusion_mirrored,
    Revolution: _revolution_mirrored,
    Polyhedron: _polyhedron_mirrored,
}
"""primitive -> (mirror image in its own frame, the flip): placement @ flip puts the image where the primitive stood."""
