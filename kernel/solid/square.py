"""Primitives with flat faces: block, wedge, extrusion, polyhedron. Any affine placement keeps them so.

Coordinates of faces that stand square in the placement's family are snapped to those of other primitives.
"""

from __future__ import annotations

import math

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from kernel.csg.tree import Block, Extrusion, Polyhedron, Wedge
from kernel.solid.flat import flat_faces, polyhedron_mesh
from kernel.solid.lathe import Loop, layer
from kernel.solid.setting import FLAT, Setting, positive, still_thick
from kernel.solid.tracked import NotSolidError

TWIST_DIVISIONS = 16
"""A twisted side is no plane: its two triangles leave it by an amount that goes with the square of the edge."""

BLOCK_TRIANGLES = np.array(
    [[0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 2, 3], [0, 3, 1],
     [4, 5, 7], [4, 7, 6]]
)  # fmt: skip
"""Corner k of a block stands at x: k & 1, y: k & 2, z: k & 4; two triangles a side in the order -x +x -y +y -z +z."""


def build_block(block: Block, setting: Setting) -> Manifold:
    """Block; a parallelepiped where the placement shears it."""
    positive(x_size=block.size[0], y_size=block.size[1], z_size=block.size[2])
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)]) * np.array(block.size)
    group = np.repeat(np.arange(6), 2)
    placed = setting.placed
    points = corners @ placed.linear.T + placed.origin
    if placed.is_square and placed.family is not None:
        points = _snap_columns(setting, points, corners)
        if placed.family.is_main:
            return _square_block(points, setting)
    return setting.flat(points, BLOCK_TRIANGLES, group)


def _square_block(points: NDArray[np.float64], setting: Setting) -> Manifold:
    """A block along the working frame's axes: the planes are known without measuring the faces."""
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.where([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], high, low)
    ids = [setting.table.plane(np.eye(3)[axis], float(value[axis])) for axis in range(3) for value in (low, high)]
    return setting.solid(corners, BLOCK_TRIANGLES, np.repeat(ids, 2))


def _snap_columns(setting: Setting, points: NDArray[np.float64], local: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of a square placement, every coordinate snapped; equal local coordinates stay equal."""
    placed = setting.placed
    assert placed.family is not None
    snapped = points.copy()
    for column in range(3):
        axis = int(np.argmax(np.abs(placed.linear[:, column])))
        for value in np.unique(local[:, column]):
            rows = local[:, column] == value
            snapped[rows, axis] = placed.family.snap(axis, float(points[rows, axis][0]))
    still_thick(points, snapped)
    return snapped


def build_wedge(wedge: Wedge, setting: Setting) -> Manifold:
    """Right triangle, extruded."""
    x, y, z = wedge.size
    positive(x_size=x, y_size=y, z_size=z)
    return _extrude([np.array([[0.0, 0.0], [x, 0.0], [0.0, y]])], z, setting)


def _extrude(loops: list[Loop], height: float, setting: Setting) -> Manifold:
    """A right prism: loops in z=0, swept to z=height."""
    flat = np.concatenate(loops)
    local = np.concatenate([np.insert(flat, 2, 0.0, axis=1), np.insert(flat, 2, height, axis=1)])
    triangles, group = layer(loops, 1)
    placed = setting.placed
    points = local @ placed.linear.T + placed.origin
    if placed.family is not None:
        columns = [2, *(_straight_columns(loops) if placed.is_square else [])]
        points = _snap_faces(setting, points, local, columns, loops)
    return setting.flat(points, triangles, group)


def _straight_columns(loops: list[Loop]) -> list[int]:
    """Columns (0: x, 1: y) along which some edge of the loops stands square, so that it makes a square face."""
    return [column for column in (0, 1) if any(len(_square_points(loop, column)) for loop in loops)]


def _square_points(loop: Loop, column: int) -> NDArray[np.int64]:
    """Indices of the loop's points at an end of an edge along which the column does not change."""
    same = loop[:, column] == np.roll(loop[:, column], -1)
    return np.nonzero(same | np.roll(same, 1))[0]


def _snap_faces(
    setting: Setting,
    points: NDArray[np.float64],
    local: NDArray[np.float64],
    columns: list[int],
    loops: list[Loop],
) -> NDArray[np.float64]:
    """Points of a prism with the coordinates of its square faces snapped, other points left where they are."""
    placed = setting.placed
    assert placed.family is not None
    snapped = points.copy()
    for column in columns:
        axis = int(np.argmax(np.abs(placed.linear[:, column])))
        if column == 2:
            values = np.unique(local[:, 2])
        else:
            values = np.unique(np.concatenate([loop[_square_points(loop, column), column] for loop in loops]))
        for value in values:
            rows = local[:, column] == value
            snapped[rows, axis] = placed.family.snap(axis, float(points[rows, axis][0]))
    still_thick(points, snapped)
    return snapped


def build_extrusion(extrusion: Extrusion, setting: Setting) -> Manifold:
    """Loops extruded; sides are planes unless the extrusion twists (facets) or its scale is uneven (triangles)."""
    positive(height=extrusion.height)
    loops = [np.asarray(loop, dtype=np.float64) for loop in extrusion.loops]
    if extrusion.twist == 0.0 and extrusion.scale == (1.0, 1.0):
        return _extrude(loops, extrusion.height, setting)
    sx, sy = extrusion.scale
    if min(sx, sy) < 0.0 or (min(sx, sy) == 0.0 and max(sx, sy) > 0.0):
        raise NotSolidError(f"its scale is ({sx:g}, {sy:g}), expected two positive factors or two zeros")
    layers = max(int(extrusion.slices), 1)
    if extrusion.twist != 0.0:
        loops = [_divided(loop) for loop in loops]
    to_point = sx == 0.0 and sy == 0.0
    if to_point:
        layers = 1 if extrusion.twist == 0.0 else layers
    flat = np.concatenate(loops)
    levels = []
    for level in range(layers + 1):
        share = level / layers
        if to_point and level == layers:
            levels.append(np.array([[0.0, 0.0, extrusion.height]]))
            continue
        turned = -math.radians(extrusion.twist) * share
        turn_matrix = np.array([[math.cos(turned), -math.sin(turned)], [math.sin(turned), math.cos(turned)]])
        factors = np.array([1.0 + (sx - 1.0) * share, 1.0 + (sy - 1.0) * share])
        levels.append(np.insert((flat @ turn_matrix.T) * factors, 2, extrusion.height * share, axis=1))
    local = np.concatenate(levels)
    triangles, group = layer(loops, layers, to_point=to_point)
    points = local @ setting.placed.linear.T + setting.placed.origin
    if extrusion.twist != 0.0:
        return _twisted(setting, points, triangles, group)
    if sx == sy:
        group = np.where(group > 1, 2 + (group - 2) % len(flat), group)  # one plane through all layers
    else:
        group = np.where(group > 1, 2 + np.arange(len(group)), group)  # sides are not flat: triangle by triangle
    return setting.flat(points, triangles, group)


def _divided(loop: Loop) -> Loop:
    """The loop with its edges divided evenly, none longer than 1 / TWIST_DIVISIONS of the loop's extent."""
    longest = float(np.ptp(loop, axis=0).max()) / TWIST_DIVISIONS
    pieces = []
    for start, end in zip(loop, np.roll(loop, -1, axis=0)):
        count = max(1, math.ceil(float(np.linalg.norm(end - start)) / longest - FLAT))
        share = np.arange(count)[:, None] / count
        pieces.append(start * (1.0 - share) + end * share)
    return np.concatenate(pieces)


def _twisted(
    setting: Setting, points: NDArray[np.float64], triangles: NDArray[np.int64], group: NDArray[np.int64]
) -> Manifold:
    """Flat ends, and one faceted surface for all sides."""
    working = setting.to_working(points)
    surface = np.full(len(triangles), setting.table.other("side of a twisted extrusion"))
    ends = group < 2
    surface[ends] = flat_faces(setting.table, working, triangles[ends], group[ends])
    return setting.solid(working, triangles, surface, inside_out=setting.mirrors)


def build_polyhedron(polyhedron: Polyhedron, setting: Setting) -> Manifold:
    """Polygons in the order of the input, each a plane where it is flat."""
    placed = setting.placed
    points, triangles, group = polyhedron_mesh(
        np.asarray(polyhedron.points, dtype=np.float64), polyhedron.faces, setting.table.size
    )
    return setting.flat(points @ placed.linear.T + placed.origin, triangles, group)
