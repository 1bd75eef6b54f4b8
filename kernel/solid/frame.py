"""The working frame: coordinates in which most of the model stands square, and faces that should meet do.

Placements that agree up to a turn by right angles are one rotation family. The family that holds most volume gives
the working frame. In every family, axes that are parallel within the tolerance are made so, and coordinates of faces
and centres that agree within the tolerance become one number: slivers and gaps from six-digit input vanish.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kernel.csg.tree import Matrix
from kernel.solid.table import snap_to

SQUARE = 1e-9
"""Columns whose cosines are below this are perpendicular (placements were made rigid when they were read)."""

_EXACT = 1e-11
"""A scale within this of 1 is 1."""


def signed_permutations() -> NDArray[np.float64]:
    """The 24 rotations (24, 3, 3) that map the axes onto themselves."""
    found = []
    for i, j in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2)):
        for a in (1.0, -1.0):
            for b in (1.0, -1.0):
                matrix = np.zeros((3, 3))
                matrix[i, 0], matrix[j, 1] = a, b
                matrix[:, 2] = np.cross(matrix[:, 0], matrix[:, 1])
                found.append(matrix)
    return np.array(found)


_TURNS = signed_permutations()


@dataclass(slots=True, eq=False)
class Family:
    """Placements that agree up to right angles. rotation: (3, 3), columns are the family's axes in the working frame.

    coordinates: for each of the three axes the sorted numbers that faces and centres stand on.
    """

    rotation: NDArray[np.float64]
    tolerance: float
    coordinates: tuple[list[float], list[float], list[float]] = field(default_factory=lambda: ([], [], []))

    def snap(self, axis: int, value: float) -> float:
        """The number that `value` along the axis is known by."""
        return snap_to(self.coordinates[axis], value, self.tolerance)

    def snap_point(self, point: NDArray[np.float64]) -> NDArray[np.float64]:
        """`point` (3,), in the family's coordinates, each of them snapped."""
        return np.array([self.snap(axis, float(value)) for axis, value in enumerate(point)])

    def to_working(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) or (3,) of the family in the working frame."""
        return points if self.is_main else points @ self.rotation.T

    is_main: bool = field(init=False)
    """The family of the working frame itself."""

    def __post_init__(self) -> None:
        """Compare once."""
        self.is_main = bool((self.rotation == np.eye(3)).all())


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """A placement in the coordinates of its family (of the working frame itself where it is in none).

    linear: (3, 3); origin: (3,). family: None where no axis of the placement is parallel to any family's.
    is_square: every column of `linear` is parallel to an axis. axis_of_z: the axis that the third column is parallel
    to, or -1.
    """

    linear: NDArray[np.float64]
    origin: NDArray[np.float64]
    family: Family | None
    is_square: bool
    axis_of_z: int


@dataclass(frozen=True, slots=True, eq=False)
class PlacedLeaf:
    """What the choice of a frame looks at. weight: volume it counts with; turns: only its z axis matters."""

    placement: Matrix
    weight: float
    turns: bool


class WorkingFrame:
    """rotation: (3, 3), world = rotation @ working. families[0] is the frame's own."""

    def __init__(self, rotation: NDArray[np.float64], relative: list[NDArray[np.float64]], tolerance: float) -> None:
        self.rotation = rotation
        self.tolerance = tolerance
        self.families = [Family(matrix, tolerance) for matrix in relative]
        self._known: dict[bytes, tuple[NDArray[np.float64], int, bool, int]] = {}

    def place(self, placement: Matrix, angle_tolerance: float) -> Placed:
        """The placement (4, 4) in its family's coordinates, axes made parallel where they nearly are."""
        key = placement[:3, :3].tobytes()
        if key not in self._known:
            self._known[key] = self._clean(placement[:3, :3], angle_tolerance)
        linear, number, is_square, axis_of_z = self._known[key]
        origin = self.rotation.T @ placement[:3, 3]
        if number < 0:
            return Placed(linear, origin, None, False, -1)
        family = self.families[number]
        return Placed(linear, family.rotation.T @ origin, family, is_square, axis_of_z)

    def _clean(self, linear: NDArray[np.float64], angle_tolerance: float) -> tuple[NDArray[np.float64], int, bool, int]:
        in_frame = self.rotation.T @ linear
        scale = np.linalg.norm(in_frame, axis=0)
        scale = np.where(np.abs(scale - 1.0) < _EXACT, 1.0, scale)
        unit = in_frame / scale
        best: tuple[NDArray[np.float64], int, bool, int] | None = None
        for number, family in enumerate(self.families):
            columns = family.rotation.T @ unit
            snapped = np.where(np.abs(columns) > 0.5, np.sign(columns), 0.0)
            close = np.abs(columns - snapped).max(axis=0) < angle_tolerance
            if close.all():
                return snapped * scale, number, True, int(np.argmax(np.abs(snapped[:, 2])))
            if close[2] and best is None:
                columns = _square_about_z(columns, snapped[:, 2])
                best = columns * scale, number, False, int(np.argmax(np.abs(snapped[:, 2])))
        return best if best is not None else (in_frame, -1, False, -1)


def _square_about_z(columns: NDArray[np.float64], z: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit columns with the third replaced by z; the others, where they were perpendicular, made so again."""
    x, y = columns[:, 0], columns[:, 1]
    if max(abs(x @ y), abs(x @ columns[:, 2]), abs(y @ columns[:, 2])) > SQUARE:
        return np.stack([x, y, z], axis=1)
    x = x - z * (x @ z)
    x /= np.linalg.norm(x)
    handed = 1.0 if np.linalg.det(columns) > 0 else -1.0
    return np.stack([x, handed * np.cross(z, x), z], axis=1)


def choose_frame(leaves: list[PlacedLeaf], tolerance: float, angle_tolerance: float) -> WorkingFrame:
    """The frame of the rotation family with most weight; ties go to the family nearest to the model's own axes."""
    rotations: list[NDArray[np.float64]] = []
    weights: list[float] = []
    known: dict[bytes, int] = {}
    rows = sorted(leaves, key=lambda leaf: (leaf.turns, -leaf.weight, leaf.placement.tobytes()))
    for leaf in rows:
        key = bytes([leaf.turns]) + leaf.placement[:3, :3].tobytes()
        if key not in known:
            known[key] = _family_of(leaf, rotations, weights, angle_tolerance)
        if known[key] >= 0:
            weights[known[key]] += leaf.weight
    if not rotations:
        return WorkingFrame(np.eye(3), [np.eye(3)], tolerance)
    trace = [float(np.trace(rotation)) for rotation in rotations]
    main = max(range(len(rotations)), key=lambda i: (round(weights[i] / max(max(weights), 1e-300), 9), trace[i]))
    order = [main, *(i for i in range(len(rotations)) if i != main)]
    frame = rotations[main]
    relative = [np.eye(3), *(nearest_turn(frame.T @ rotations[i]) for i in order[1:])]
    return WorkingFrame(frame, relative, tolerance)


def _family_of(
    leaf: PlacedLeaf, rotations: list[NDArray[np.float64]], weights: list[float], angle_tolerance: float
) -> int:
    """Number of the family that the leaf is in, added to the lists where it is new; -1 where it is in none."""
    linear = leaf.placement[:3, :3]
    unit = linear / np.linalg.norm(linear, axis=0)
    if np.abs(unit.T @ unit - np.eye(3)).max() > SQUARE:
        return -1
    if rotations:
        columns = np.einsum("fji,jk->fik", np.array(rotations), unit[:, 2:] if leaf.turns else unit)
        snapped = np.where(np.abs(columns) > 0.5, np.sign(columns), 0.0)
        close = np.nonzero(np.abs(columns - snapped).reshape(len(rotations), -1).max(axis=1) < angle_tolerance)[0]
        if len(close):
            return int(close[0])
    if np.linalg.det(unit) < 0:
        unit = unit * np.array([-1.0, 1.0, 1.0])
    rotations.append(nearest_turn(unit, angle_tolerance))
    weights.append(0.0)
    return len(rotations) - 1


def nearest_turn(rotation: NDArray[np.float64], exact_within: float = _EXACT) -> NDArray[np.float64]:
    """`rotation` with its axes renamed so that it is nearest to the identity, and the identity where it nearly is."""
    candidates = rotation @ _TURNS
    trace = np.round(np.trace(candidates, axis1=1, axis2=2), 9)
    best: NDArray[np.float64] = candidates[int(np.argmax(trace))]
    if np.abs(best - np.eye(3)).max() < exact_within:
        return np.eye(3)
    return best
