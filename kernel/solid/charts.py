"""Charts: points on a surface as points in a plane and back, so that areas can be cut and compared there.

Planes, cylinders and cones unroll without strain. Tori lie in their two arc lengths, spheres in Lambert's azimuthal
equal-area chart about POLE. Curved ones are cut along a seam (at angle +-pi), spheres at the point opposite POLE.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from kernel.solid.surfaces import (
    Axis,
    ConeSurface,
    CylinderSurface,
    FacetedSurface,
    Plane,
    SphereSurface,
    Surface,
    TorusSurface,
    plane_frame,
)

Array = NDArray[np.float64]

POLE = plane_frame(np.array([0.5377, -0.6219, -0.5694]))
"""The frame of every sphere's chart, in no direction that models are drawn in: its far end is where the chart tears."""

ROUNDING = 1e-9
"""Patches are joined on a grid of this share of their extent."""


def flatten(surface: Surface, points: Array) -> Array:
    """(n, 2) chart coordinates of points (n, 3) on the surface. ValueError: a FacetedSurface has no chart."""
    match surface:
        case Plane():
            flat = np.empty((len(points), 2))
            flat[:, 0], flat[:, 1] = points @ surface.u, points @ surface.v
            return flat
        case SphereSurface():
            arm = (points - surface.centre) / surface.radius
            scale = np.sqrt(2.0 / np.maximum(1.0 + arm @ POLE.normal, 1e-12)) * surface.radius
            return np.stack([arm @ POLE.u, arm @ POLE.v], axis=1) * scale[:, None]
        case FacetedSurface():
            raise ValueError("a faceted surface has no chart")
    return _spread(surface, _coordinates(surface, points))


def lift(surface: Surface, flat: Array) -> Array:
    """(n, 3) points on the surface of chart coordinates (n, 2). ValueError: a FacetedSurface has no chart."""
    x, y = flat[:, 0], flat[:, 1]
    match surface:
        case Plane():
            return np.outer(x, surface.u) + np.outer(y, surface.v) + surface.offset * surface.normal
        case CylinderSurface():
            around = _around(surface.axis, x / surface.radius)
            return surface.axis.point + surface.radius * around + np.outer(y, surface.axis.direction)
        case ConeSurface():
            sine = _sine(surface)
            slant, angle = np.hypot(x, y), np.arctan2(y, x) / sine
            radial = (sine * slant)[:, None] * _around(surface.axis, angle)
            along = np.sign(surface.slope) * np.sqrt(1.0 - sine**2) * slant
            return surface.apex + radial + np.outer(along, surface.axis.direction)
        case SphereSurface():
            square = np.minimum((x * x + y * y) / surface.radius**2, 4.0)
            scale = np.sqrt(1.0 - 0.25 * square)
            height = (1.0 - 0.5 * square) * surface.radius
            flat_part = np.outer(x * scale, POLE.u) + np.outer(y * scale, POLE.v)
            return surface.centre + flat_part + np.outer(height, POLE.normal)
        case TorusSurface():
            turn = y / surface.minor_radius
            distance = surface.major_radius + surface.minor_radius * np.cos(turn)
            ring = distance[:, None] * _around(surface.axis, x / surface.major_radius)
            return surface.centre + ring + np.outer(surface.minor_radius * np.sin(turn), surface.axis.direction)
    raise ValueError("a faceted surface has no chart")


def flat_faces(surface: Surface, corners: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Faces (m, k, 3) on the surface as (m, k, 2), unbroken at seams, and which of them the chart can show (m,).

    All but those of a sphere through which its chart tears.
    """
    count, per_face, _ = corners.shape
    points = corners.reshape(-1, 3)
    if isinstance(surface, SphereSurface):
        flat = flatten(surface, points).reshape(count, per_face, 2)
        arm = corners - surface.centre
        around = np.cross(arm, np.roll(arm, -1, axis=1)) @ POLE.normal
        torn = ((around > 0).all(axis=1) | (around < 0).all(axis=1)) & (arm @ POLE.normal < 0).any(axis=1)
        return flat, np.logical_not(np.asarray(torn, dtype=bool))
    if isinstance(surface, Plane):
        return flatten(surface, points).reshape(count, per_face, 2), np.ones(count, dtype=bool)
    at = _coordinates(surface, points).reshape(count, per_face, 2)
    first = at[:, :1]
    if isinstance(surface, ConeSurface):  # the apex has no angle of its own
        first = np.take_along_axis(at, np.argmax(at[:, :, 1], axis=1)[:, None, None], axis=1)
    for column in range(2 if isinstance(surface, TorusSurface) else 1):
        at[:, :, column] -= 2 * np.pi * np.round((at[:, :, column] - first[:, :, column]) / (2 * np.pi))
    return _spread(surface, at.reshape(-1, 2)).reshape(count, per_face, 2), np.ones(count, dtype=bool)


def cover(surface: Surface, triangles: Array) -> Polygon | MultiPolygon:
    """What triangles (m, 3, 3) on a cone, sphere or torus cover, in its chart."""
    flat, shown = flat_faces(surface, triangles)
    flat = flat[shown]
    window = _window(surface, float(np.abs(flat).max()) if len(flat) else 1.0)
    rings = shapely.polygons(np.concatenate([flat, *_turned(surface, flat)]))
    rings = rings[shapely.is_valid(rings) & shapely.intersects(rings, window)]
    grid = ROUNDING * float(np.abs(window.bounds).max())
    whole = shapely.union_all(rings, grid_size=grid).intersection(window, grid_size=grid)
    return shapely.multipolygons([p for p in shapely.get_parts(whole) if p.geom_type == "Polygon" and p.area > 0.0])


def over_seams(surface: Surface, flat: Array) -> tuple[Array, NDArray[np.int64]]:
    """Copies (n, k, 2) of unbroken faces (m, k, 2) that reach over a seam, as the chart has them on its other side.

    With each its place (n,) among the faces.
    """
    copies = _turned(surface, flat)
    if not copies or not len(flat):
        return flat[:0], np.empty(0, np.int64)
    window = _window(surface, float(np.abs(flat).max()))
    found = np.concatenate(copies)
    rings = shapely.polygons(found)
    area = np.abs(shapely.area(rings))
    inside = np.zeros(len(found), dtype=bool)
    near = np.nonzero(shapely.is_valid(rings) & shapely.intersects(rings, window))[0]
    inside[near] = shapely.area(shapely.intersection(rings[near], window)) > ROUNDING * area[near]
    return found[inside], np.nonzero(inside)[0] % len(flat)


def _turned(surface: Surface, flat: Array) -> list[Array]:
    """Faces (m, k, 2) moved by a whole turn either way, on a torus about both circles."""
    if isinstance(surface, CylinderSurface):
        return [flat + (2 * np.pi * surface.radius * k, 0.0) for k in (-1, 1)]
    if isinstance(surface, ConeSurface):
        return [flat @ _rotation(2 * np.pi * _sine(surface) * k) for k in (-1, 1)]
    if isinstance(surface, TorusSurface):
        step = 2 * np.pi * np.array([surface.major_radius, surface.minor_radius])
        return [flat + step * (i, j) for i in (-1, 0, 1) for j in (-1, 0, 1) if i or j]
    return []


def _window(surface: Surface, reach: float) -> Polygon:
    """The part of the plane that a surface's chart fills, as far out as `reach`."""
    if isinstance(surface, TorusSurface):
        width, height = np.pi * surface.major_radius, np.pi * surface.minor_radius
        return shapely.box(-width, -height, width, height)
    if isinstance(surface, CylinderSurface):
        return shapely.box(-np.pi * surface.radius, -2 * reach, np.pi * surface.radius, 2 * reach)
    if isinstance(surface, ConeSurface):
        angle = np.linspace(-np.pi, np.pi, 25) * _sine(surface)
        return Polygon([(0.0, 0.0), *(2.0 * reach * np.stack([np.cos(angle), np.sin(angle)], axis=1)).tolist()])
    return shapely.box(-2 * reach, -2 * reach, 2 * reach, 2 * reach)


def _coordinates(surface: Surface, points: Array) -> Array:
    """(n, 2): angle about the axis, and height (cylinder), distance from the apex (cone), angle of the tube (torus)."""
    assert isinstance(surface, CylinderSurface | ConeSurface | TorusSurface)
    axis = surface.axis
    arm = points - axis.point
    angle = np.arctan2(arm @ axis.y, arm @ axis.x)
    if isinstance(surface, CylinderSurface):
        return np.stack([angle, arm @ axis.direction], axis=1)
    if isinstance(surface, ConeSurface):
        return np.stack([angle, np.linalg.norm(points - surface.apex, axis=1)], axis=1)
    distance = np.hypot(arm @ axis.x, arm @ axis.y) - surface.major_radius
    return np.stack([angle, np.arctan2((points - surface.centre) @ axis.direction, distance)], axis=1)


def _spread(surface: Surface, at: Array) -> Array:
    """Chart coordinates of what _coordinates gives."""
    if isinstance(surface, CylinderSurface):
        return at * (surface.radius, 1.0)
    if isinstance(surface, TorusSurface):
        return at * (surface.major_radius, surface.minor_radius)
    assert isinstance(surface, ConeSurface)
    angle = _sine(surface) * at[:, 0]
    return at[:, 1:] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def _sine(cone: ConeSurface) -> float:
    """Of the angle between the cone and its axis."""
    return abs(cone.slope) / float(np.hypot(1.0, cone.slope))


def _around(axis: Axis, angle: Array) -> Array:
    return np.outer(np.cos(angle), axis.x) + np.outer(np.sin(angle), axis.y)


def _rotation(angle: float) -> Array:
    """(2, 2): row vectors times this are turned by `angle`."""
    return np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
