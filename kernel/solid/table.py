"""The table that gives each analytic surface one id, however many primitives lie on it.

Planes that differ by less than the tolerance are one plane, cylinders about one line share one axis; whoever comes
first says where it is, and everyone after stands exactly there. Ids become manifold's face ids, so every triangle of
a Boolean's result names its surface.
"""

from __future__ import annotations

import itertools
import math
from bisect import bisect_left

import numpy as np
from numpy.typing import NDArray

from kernel.solid.surfaces import (
    Axis,
    ConeSurface,
    CylinderSurface,
    FacetedSurface,
    Plane,
    PlaneFrame,
    SphereSurface,
    Surface,
    TorusSurface,
    Vector,
    cross,
    plane_frame,
)
from kernel.units import ANGLE_TOLERANCE

CLEAN = 1e-9
"""Components of a unit vector below this are zero."""

SHARP = 1e-2
"""Share of the tolerance within which two cones are one: their facets are not moved onto the first one's."""


class PointIndex:
    """Points found again within a tolerance (largest difference of a component), by a grid of cells."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self._cell = 4.0 * tolerance
        self._cells: dict[tuple[int, ...], list[tuple[tuple[float, ...], int]]] = {}

    def find(self, point: tuple[float, ...]) -> int | None:
        """The value stored at the nearest point within the tolerance, or None."""
        best, nearest = None, self.tolerance
        spans = [
            range(math.floor((c - self.tolerance) / self._cell), math.floor((c + self.tolerance) / self._cell) + 1)
            for c in point
        ]
        for cell in itertools.product(*spans):
            for other, value in self._cells.get(cell, ()):
                distance = max(abs(a - b) for a, b in zip(point, other))
                if distance <= nearest:
                    best, nearest = value, distance
        return best

    def add(self, point: tuple[float, ...], value: int) -> None:
        """Store `value` at `point`."""
        cell = tuple(math.floor(c / self._cell) for c in point)
        self._cells.setdefault(cell, []).append((point, value))


class SurfaceTable:
    """Surfaces and axes by id. tolerance: length below which two are one; size: the model's, both in model units."""

    def __init__(self, tolerance: float, size: float = 1.0) -> None:
        self.tolerance = tolerance
        self.size = size
        self.angle_tolerance = min(ANGLE_TOLERANCE, max(2.0 * tolerance / size, CLEAN))
        self.surfaces: list[Surface] = []
        self.axes: list[Axis] = []
        self.sources: dict[int, int] = {}
        """Index of the primitive by manifold's original id; cutters are not in it."""
        self._directions: list[Vector] = []
        self._frames: list[PlaneFrame] = []
        self._direction_index = PointIndex(self.angle_tolerance)
        self._planes: dict[int, tuple[list[float], list[int]]] = {}
        self._axis_index: dict[int, PointIndex] = {}
        self._cylinders: dict[int, tuple[list[float], list[int]]] = {}
        self._cones: dict[int, PointIndex] = {}
        self._spheres = PointIndex(tolerance)
        self._tori: dict[int, PointIndex] = {}

    # ---- directions

    def direction(self, vector: Vector) -> tuple[int, float]:
        """(index of the canonical direction parallel to `vector`, +1.0 or -1.0 where it points the other way)."""
        unit = np.asarray(vector, dtype=np.float64)
        unit = unit / math.sqrt(float(unit @ unit))
        unit = np.where(np.abs(unit) < CLEAN, 0.0, unit)
        unit /= math.sqrt(float(unit @ unit))
        key = (float(unit[0]), float(unit[1]), float(unit[2]))
        found = self._direction_index.find(key)
        if found is not None:
            return found, 1.0
        found = self._direction_index.find((-key[0], -key[1], -key[2]))
        if found is not None:
            return found, -1.0
        sign = 1.0 if next(c for c in key if c != 0.0) > 0.0 else -1.0
        unit = sign * unit + 0.0
        unit.flags.writeable = False
        self._directions.append(unit)
        self._frames.append(plane_frame(unit))
        self._direction_index.add((float(unit[0]), float(unit[1]), float(unit[2])), len(self._directions) - 1)
        return len(self._directions) - 1, sign

    # ---- planes

    def plane(self, normal: Vector, offset: float, through: NDArray[np.float64] | None = None) -> int:
        """Id of the plane normal . x = offset. through: points (n, 3) of it, which then say the offset."""
        index, at = self._plane_key(normal, offset, through)
        offsets, ids = self._planes.setdefault(index, ([], []))
        found = _nearest(offsets, at, self.tolerance)
        if found is not None:
            return ids[found]
        position = bisect_left(offsets, at)
        unit = self._directions[index]
        frame = self._frames[index]
        offsets.insert(position, at)
        ids.insert(position, self._append(Plane(unit, at, frame.u, frame.v)))
        return ids[position]

    def find_plane(self, normal: Vector, offset: float) -> int | None:
        """Id of the plane normal . x = offset where the table has it; nothing is added."""
        index, at = self._plane_key(normal, offset, None)
        offsets, ids = self._planes.get(index, ([], []))
        found = _nearest(offsets, at, self.tolerance)
        return None if found is None else ids[found]

    def _plane_key(self, normal: Vector, offset: float, through: NDArray[np.float64] | None) -> tuple[int, float]:
        length = math.sqrt(float(np.dot(normal, normal)))
        index, sign = self.direction(normal)
        if through is not None:
            return index, float(np.mean(through @ self._directions[index])) + 0.0
        return index, sign * float(offset) / length + 0.0

    # ---- axes and what turns about them

    def axis(self, point: Vector, direction: Vector, x: Vector | None = None) -> int:
        """Id of the line through `point` along `direction` (either way).

        The angle 0 of an axis depends on its direction alone, so that coaxial facets match whoever comes first;
        x: a preferred direction of angle 0, used where the line is new.
        """
        index, _ = self.direction(direction)
        unit = self._directions[index]
        point = np.asarray(point, dtype=np.float64)
        foot = point - unit * float(point @ unit)
        feet = self._axis_index.setdefault(index, PointIndex(self.tolerance))
        key = (float(foot[0]), float(foot[1]), float(foot[2]))
        found = feet.find(key)
        if found is not None:
            return found
        if x is None:
            first = self._frames[index].u
        else:
            first = x - unit * float(x @ unit)
            first = first / np.linalg.norm(first)
        foot = foot + 0.0
        self.axes.append(Axis(foot, unit, first, cross(unit, first) + 0.0))
        feet.add(key, len(self.axes) - 1)
        return len(self.axes) - 1

    def cylinder(self, axis_id: int, radius: float) -> int:
        """Id of the cylinder of `radius` about the axis."""
        radii, ids = self._cylinders.setdefault(axis_id, ([], []))
        found = _nearest(radii, radius, self.tolerance)
        if found is not None:
            return ids[found]
        position = bisect_left(radii, radius)
        radii.insert(position, float(radius))
        ids.insert(position, self._append(CylinderSurface(self.axes[axis_id], axis_id, float(radius))))
        return ids[position]

    def find_cylinder(self, axis_id: int, radius: float) -> float | None:
        """Radius of the axis's cylinder that is within the tolerance of `radius`, or None; nothing is added."""
        radii, _ = self._cylinders.get(axis_id, ([], []))
        found = _nearest(radii, radius, self.tolerance)
        return None if found is None else radii[found]

    def cone(self, axis_id: int, apex_at: float, slope: float) -> int:
        """Id of the cone about the axis with its apex at the axial distance `apex_at`; slope as in ConeSurface."""
        cones = self._cones.setdefault(axis_id, PointIndex(SHARP * self.tolerance))
        key = (apex_at, slope * self.size)
        found = cones.find(key)
        if found is not None:
            return found
        axis = self.axes[axis_id]
        number = self._append(ConeSurface(axis, axis_id, axis.point + axis.direction * apex_at, slope))
        cones.add(key, number)
        return number

    def sphere(self, centre: Vector, radius: float) -> int:
        """Id of the sphere."""
        key = (float(centre[0]), float(centre[1]), float(centre[2]), float(radius))
        found = self._spheres.find(key)
        if found is not None:
            return found
        number = self._append(SphereSurface(np.array(centre, dtype=np.float64), float(radius)))
        self._spheres.add(key, number)
        return number

    def torus(self, axis_id: int, centre_at: float, major_radius: float, minor_radius: float) -> int:
        """Id of the torus about the axis with its centre at the axial distance `centre_at`."""
        tori = self._tori.setdefault(axis_id, PointIndex(self.tolerance))
        key = (centre_at, major_radius, minor_radius)
        found = tori.find(key)
        if found is not None:
            return found
        axis = self.axes[axis_id]
        centre = axis.point + axis.direction * centre_at
        number = self._append(TorusSurface(axis, axis_id, centre, float(major_radius), float(minor_radius)))
        tori.add(key, number)
        return number

    def other(self, reason: str) -> int:
        """Id of a new surface without analytic form."""
        return self._append(FacetedSurface(reason))

    def _append(self, surface: Surface) -> int:
        self.surfaces.append(surface)
        return len(self.surfaces) - 1


def _nearest(values: list[float], value: float, tolerance: float) -> int | None:
    """Index of the entry of the sorted list nearest to `value`, or None where none is within the tolerance."""
    position = bisect_left(values, value)
    best, nearest = None, tolerance
    for index in (position - 1, position):
        if 0 <= index < len(values) and abs(values[index] - value) <= nearest:
            best, nearest = index, abs(values[index] - value)
    return best


def snap_to(values: list[float], value: float, tolerance: float) -> float:
    """The entry of the sorted list within the tolerance of `value`; where there is none, `value`, now in the list."""
    found = _nearest(values, value, tolerance)
    if found is not None:
        return values[found]
    values.insert(bisect_left(values, value), float(value) + 0.0)
    return float(value) + 0.0
