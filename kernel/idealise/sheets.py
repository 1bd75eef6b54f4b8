"""Sheets: the mid-surfaces, each with a frame of its own in which it is flat."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.segment.segments import CylinderShape, PlateShape
from kernel.solid.surfaces import Axis, CylinderSurface, Plane, Surface
from kernel.solid.table import SurfaceTable

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class PlaneSheet:
    """The plane normal . x = offset, in coordinates (x.u, x.v). surface_id: in the surface table."""

    surface_id: int
    surface: Surface
    normal: Array
    offset: float
    u: Array
    v: Array
    turn = None
    period = None

    def flat(self, points: Array) -> Array:
        """Points (n, 3) in the sheet's coordinates (n, 2)."""
        flat = np.empty((len(points), 2))
        flat[:, 0], flat[:, 1] = points @ self.u, points @ self.v
        return flat

    def lift(self, flat: Array) -> Array:
        """Points (n, 2) of the sheet in space, (n, 3)."""
        return flat[:, :1] * self.u + flat[:, 1:] * self.v + self.normal * self.offset

    def normals(self, points: Array) -> Array:
        """Unit normals (n, 3) of the sheet at points (n, 3)."""
        return np.broadcast_to(self.normal, points.shape)


@dataclass(frozen=True, slots=True, eq=False)
class CylinderSheet:
    """The cylinder of `radius` unrolled: (radius * angle, distance along the axis), normal pointing away from it.

    start: the angle (radians, from axis.x) where x is 0. A closed one has the circumference as its period and
    0 <= x < period; an open one must leave the angle opposite `start` free, and has |x| < half the circumference.
    """

    surface_id: int
    surface: CylinderSurface
    axis: Axis
    radius: float
    start: float
    is_closed: bool

    @property
    def turn(self) -> float:
        """Circumference: x and x + turn are the same place."""
        return 2 * np.pi * self.radius

    @property
    def seam(self) -> float:
        """The smallest x; the sheet is cut open there."""
        return 0.0 if self.is_closed else -0.5 * self.turn

    @property
    def period(self) -> float | None:
        """Circumference of a closed sheet."""
        return self.turn if self.is_closed else None

    def flat(self, points: Array) -> Array:
        """Points (n, 3) in the sheet's coordinates (n, 2)."""
        relative = points - self.axis.point
        angle = np.arctan2(relative @ self.axis.y, relative @ self.axis.x) - self.start
        turn = 2 * np.pi
        angle = np.mod(angle, turn) if self.is_closed else np.mod(angle + np.pi, turn) - np.pi
        if self.is_closed:
            angle[angle > turn - 1e-12] = 0.0
        return np.stack([self.radius * angle, relative @ self.axis.direction], axis=1)

    def lift(self, flat: Array) -> Array:
        """Points (n, 2) of the sheet in space, (n, 3)."""
        angle = flat[:, 0] / self.radius + self.start
        around = np.cos(angle)[:, None] * self.axis.x + np.sin(angle)[:, None] * self.axis.y
        return self.axis.point + self.radius * around + flat[:, 1:] * self.axis.direction

    def normals(self, points: Array) -> Array:
        """Unit normals (n, 3) of the sheet at points (n, 3)."""
        relative = points - self.axis.point
        away = relative - np.outer(relative @ self.axis.direction, self.axis.direction)
        return away / np.linalg.norm(away, axis=1)[:, None]


Sheet = PlaneSheet | CylinderSheet


def plane_sheet(shape: PlateShape, table: SurfaceTable) -> PlaneSheet:
    """The mid-plane of a plate, on the table's canonical plane."""
    return plane_sheet_at(shape.normal, shape.mid_offset, shape.u, shape.v, table)


def plane_sheet_at(normal: Array, offset: float, u: Array, v: Array, table: SurfaceTable) -> PlaneSheet:
    """The sheet normal . x = offset with the axes u, v, on the table's canonical plane."""
    number = table.plane(normal, offset)
    plane = table.surfaces[number]
    assert isinstance(plane, Plane)
    sign = 1.0 if plane.normal @ normal > 0 else -1.0
    return PlaneSheet(number, plane, sign * plane.normal, sign * plane.offset, u, v)


def cylinder_sheet(shape: CylinderShape, table: SurfaceTable, start: float, is_closed: bool) -> CylinderSheet:
    """The mid-cylinder of a cylinder-plate; start: the angle (radians) at x = 0, amid the material of an open one."""
    number = table.cylinder(shape.axis_id, shape.mid_radius)
    surface = table.surfaces[number]
    assert isinstance(surface, CylinderSurface)
    return CylinderSheet(number, surface, surface.axis, surface.radius, start, is_closed)
