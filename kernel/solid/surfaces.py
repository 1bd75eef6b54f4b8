"""Analytic surfaces, and the table that gives each one id however many primitives lie on it.

Every surface lives in the working frame (see solid.evaluate). The side of the material is not the surface's:
it comes from the triangles' outward normals.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Points = NDArray[np.float64]


def cross(a: Vector, b: Vector) -> Vector:
    """a x b of two vectors (3,): numpy's own takes ten times as long on single vectors."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def crosses(a: Points, b: Points) -> Points:
    """a x b of vectors (n, 3) and (n, 3): numpy's own takes three times as long on a few dozen."""
    ax, ay, az, bx, by, bz = *a.T, *b.T
    found = np.empty((len(a), 3))
    found[:, 0], found[:, 1], found[:, 2] = ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx
    return found


class PlaneFrame(NamedTuple):
    """Two unit vectors in a plane and its unit normal, u x v = normal."""

    u: Vector
    v: Vector
    normal: Vector


def plane_frame(normal: Vector) -> PlaneFrame:
    """The frame that every plane with this normal uses: u is the coordinate axis that leans least on the normal.

    normal: any length but 0. For +x: u, v = y, z; for +y: x, -z; for +z: x, y.
    """
    n = np.asarray(normal, dtype=np.float64)
    n = n / np.linalg.norm(n)
    axis = int(np.argmin(np.round(np.abs(n), 6)))
    u = -n * n[axis]
    u[axis] += 1.0
    u /= np.linalg.norm(u)
    return PlaneFrame(u + 0.0, cross(n, u) + 0.0, n + 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Points x with normal . x = offset. u, v: unit vectors with u x v = normal; `origin` = normal * offset."""

    normal: Vector
    offset: float
    u: Vector
    v: Vector


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """Canonical line that coaxial surfaces share. x, y: unit vectors with x cross y = direction; angle 0 is x."""

    point: Vector
    direction: Vector
    x: Vector
    y: Vector


@dataclass(frozen=True, slots=True, eq=False)
class CylinderSurface:
    """Points at `radius` from `axis`; axis_id: the axis's index in the table."""

    axis: Axis
    axis_id: int
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class ConeSurface:
    """Points at radius slope * ((x - apex) . direction) from `axis`, where that is positive.

    slope: positive where the cone opens along +direction, negative where it opens along -direction.
    """

    axis: Axis
    axis_id: int
    apex: Vector
    slope: float


@dataclass(frozen=True, slots=True, eq=False)
class SphereSurface:
    """Points at `radius` from `centre`."""

    centre: Vector
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class TorusSurface:
    """Tube of minor_radius about the circle of major_radius around `axis` through `centre`."""

    axis: Axis
    axis_id: int
    centre: Vector
    major_radius: float
    minor_radius: float


@dataclass(frozen=True, slots=True, eq=False)
class FacetedSurface:
    """No analytic form: the triangles are the surface (sheared cylinders, twisted extrusions, cuts)."""

    reason: str


Surface = Plane | CylinderSurface | ConeSurface | SphereSurface | TorusSurface | FacetedSurface


def distance_along_axis(axis: Axis, points: Points) -> Vector:
    """(n,) signed distance of points (n, 3) along the axis, from the axis's point."""
    return (points - axis.point) @ axis.direction


def radial(axis: Axis, points: Points) -> Points:
    """(n, 3) vectors from the axis straight out to points (n, 3)."""
    arm = points - axis.point
    return arm - np.outer(arm @ axis.direction, axis.direction)


def _unit(vectors: Points) -> Points:
    length = np.linalg.norm(vectors, axis=1)
    return vectors / np.where(length > 0.0, length, 1.0)[:, None]


def signed_distance(surface: Surface, points: Points) -> Vector:
    """(n,) distance of points (n, 3) from the surface; positive along a plane's normal, outside a curved surface.

    A FacetedSurface has no form to measure from: ValueError.
    """
    match surface:
        case Plane():
            return points @ surface.normal - surface.offset
        case CylinderSurface():
            return np.linalg.norm(radial(surface.axis, points), axis=1) - surface.radius
        case ConeSurface():
            axial = (points - surface.apex) @ surface.axis.direction
            distance = np.linalg.norm(radial(surface.axis, points), axis=1)
            return (distance - surface.slope * axial) / np.hypot(1.0, surface.slope)
        case SphereSurface():
            return np.linalg.norm(points - surface.centre, axis=1) - surface.radius
        case TorusSurface():
            return np.linalg.norm(points - _tube_centres(surface, points), axis=1) - surface.minor_radius
    raise ValueError("a faceted surface has no analytic distance")


def _tube_centres(surface: TorusSurface, points: Points) -> Points:
    return surface.centre + surface.major_radius * _unit(radial(surface.axis, points))


def outward(surface: Surface, points: Points) -> Points:
    """(n, 3) unit normals of the surface next to points (n, 3): the direction in which signed_distance grows."""
    match surface:
        case Plane():
            return np.broadcast_to(surface.normal, points.shape).copy()
        case CylinderSurface():
            return _unit(radial(surface.axis, points))
        case ConeSurface():
            slant = _unit(radial(surface.axis, points)) - surface.slope * surface.axis.direction
            return slant / np.hypot(1.0, surface.slope)
        case SphereSurface():
            return _unit(points - surface.centre)
        case TorusSurface():
            return _unit(points - _tube_centres(surface, points))
    raise ValueError("a faceted surface has no analytic normal")


def project(surface: Surface, points: Points) -> Points:
    """(n, 3) nearest points of the surface; points on a FacetedSurface stay where they are."""
    if isinstance(surface, FacetedSurface):
        return points
    return points - signed_distance(surface, points)[:, None] * outward(surface, points)
