"""The carrier on which two surfaces meet: a line or a circle where they do so in one, else a traced curve."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.idealise.carriers import CarrierTable
from kernel.idealise.implicit import project
from kernel.idealise.tube_curve import SHARP, tube_frame
from kernel.solid.surfaces import (
    ConeSurface,
    CylinderSurface,
    FacetedSurface,
    Plane,
    SphereSurface,
    Surface,
    TorusSurface,
    cross,
    outward,
)
from kernel.units import ANGLE_TOLERANCE

Array = NDArray[np.float64]

_STEPS_PER_TURN = 96
"""March steps around the smallest radius that takes part."""

_LONGEST_MARCH = 20_000


def _is_parallel(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(cross(a, b)) < 4 * ANGLE_TOLERANCE)


def _is_across(a: Array, b: Array) -> bool:
    return bool(abs(a @ b) < 4 * ANGLE_TOLERANCE)


def _axis_of(surface: Surface) -> tuple[Array, Array] | None:
    """A point and the direction of the axis of revolution, for surfaces that have just one."""
    if isinstance(surface, CylinderSurface | ConeSurface | TorusSurface):
        return surface.axis.point, surface.axis.direction
    return None


def common_axis(a: Surface, b: Surface, tolerance: float) -> tuple[Array, Array] | None:
    """A point and direction of the axis about which both surfaces turn into themselves, or None."""
    first, second = _axis_of(a), _axis_of(b)
    axis = first or second
    if axis is None:
        if isinstance(a, SphereSurface) and isinstance(b, Plane):
            return a.centre, b.normal
        if isinstance(b, SphereSurface) and isinstance(a, Plane):
            return b.centre, a.normal
        if isinstance(a, SphereSurface) and isinstance(b, SphereSurface):
            apart = b.centre - a.centre
            return (a.centre, apart / np.linalg.norm(apart)) if np.linalg.norm(apart) > tolerance else None
        return None
    point, direction = axis
    for surface in (a, b):
        own = _axis_of(surface)
        if isinstance(surface, Plane) and not _is_parallel(surface.normal, direction):
            return None
        if own is not None:
            apart = own[0] - point
            if not _is_parallel(own[1], direction) or np.linalg.norm(np.cross(apart, direction)) > tolerance:
                return None
        if isinstance(surface, SphereSurface):
            if np.linalg.norm(np.cross(surface.centre - point, direction)) > tolerance:
                return None
    return point, direction


def _straight_direction(a: Surface, b: Surface) -> Array | None:
    """Direction of the straight lines in which two surfaces meet that are not both planes, None where they do not."""
    if isinstance(b, Plane):
        a, b = b, a
    if isinstance(b, CylinderSurface):
        if isinstance(a, Plane) and _is_across(a.normal, b.axis.direction):
            return b.axis.direction
        if isinstance(a, CylinderSurface) and _is_parallel(a.axis.direction, b.axis.direction):
            return b.axis.direction
    return None


def _smallest_radius(a: Surface, b: Surface, reach: float) -> float:
    radii = [reach / 4]
    for surface in (a, b):
        if isinstance(surface, CylinderSurface | SphereSurface):
            radii.append(surface.radius)
        if isinstance(surface, TorusSurface):
            radii.append(surface.minor_radius)
    return min(radii)


def march(a: Surface, b: Surface, start: Array, reach: float) -> tuple[Array, bool]:
    """The curve a = b = 0 through (near) `start`: points (n, 3) and whether it closes.

    Steps along the common tangent and back onto both surfaces; an open curve is followed both ways up to `reach`
    from the start. MeshError where it neither closes nor ends.
    """
    step = 2 * np.pi * _smallest_radius(a, b, reach) / _STEPS_PER_TURN
    origin = project(start[None], (a, b))[0]
    walks: list[list[Array]] = []
    for sign in (1.0, -1.0):
        walk = [origin]
        heading: Array | None = None
        while np.linalg.norm(walk[-1] - origin) <= reach:
            here = walk[-1][None]
            tangent = np.cross(outward(a, here)[0], outward(b, here)[0])
            length = np.linalg.norm(tangent)
            if length > 1e-3:
                tangent = tangent / length
                if heading is None:
                    tangent = sign * tangent
                elif tangent @ heading < 0:
                    tangent = -tangent
            elif heading is None:
                raise MeshError(f"the surfaces touch at {np.round(origin, 6).tolist()} without crossing there")
            else:
                tangent = heading
            following = project((walk[-1] + step * tangent)[None], (a, b))[0]
            heading = following - walk[-1]
            heading = heading / np.linalg.norm(heading)
            if len(walk) > 2 and np.linalg.norm(following - origin) < 0.75 * step:
                return np.array(walk), True
            walk.append(following)
            if len(walk) > _LONGEST_MARCH:
                raise MeshError(f"an intersection curve near {np.round(origin, 6).tolist()} does not end")
        walks.append(walk)
    return np.array(walks[1][:0:-1] + walks[0]), False


def _meridian(table: CarrierTable, a: Surface, b: Surface, middle: Array) -> int | None:
    """Where a plane through its axis cuts a cone (a line) or a torus (a circle), next to `middle`; None elsewhere."""
    plane, other = (a, b) if isinstance(a, Plane) else (b, a)
    if not isinstance(plane, Plane) or not isinstance(other, ConeSurface | TorusSurface):
        return None
    point, direction = other.axis.point, other.axis.direction
    if not _is_across(plane.normal, direction) or abs(plane.normal @ point - plane.offset) > table.tolerance:
        return None
    if isinstance(other, ConeSurface):
        return table.line(middle, middle - other.apex)
    arm = middle - other.centre
    arm = arm - direction * (arm @ direction)
    return table.circle(other.centre + other.major_radius * arm / np.linalg.norm(arm), plane.normal, other.minor_radius)


def intersection(
    table: CarrierTable, surfaces: list[Surface], first: int, second: int, guide: Array, straight: bool = False
) -> int:
    """Index of the carrier on which the surfaces with ids `first` and `second` meet near the guide (n, 3).

    Where one of the two is faceted the guide itself is the curve, put onto the other surface; `straight` says that
    it is then a line (an edge of a facet in a plane).
    """
    a, b = surfaces[first], surfaces[second]
    if isinstance(a, Plane) and isinstance(b, Plane):
        pair = (min(first, second), max(first, second))
        if pair not in table.of_planes:
            middle = project(guide[len(guide) // 2 : len(guide) // 2 + 1], (a, b))[0]
            table.of_planes[pair] = table.line(middle, cross(a.normal, b.normal))
        return table.of_planes[pair]
    if isinstance(a, FacetedSurface) or isinstance(b, FacetedSurface):
        if straight:
            return table.line(guide[0], guide[-1] - guide[0])
        return table.traced((first, second), (a, b), guide, is_closed=False)
    middle = project(guide[len(guide) // 2 : len(guide) // 2 + 1], (a, b))[0]
    axis = common_axis(a, b, table.tolerance)
    if axis is not None:
        point, direction = axis
        foot = point + direction * ((middle - point) @ direction)
        return table.circle(foot, direction, float(np.linalg.norm(middle - foot)))
    meridian = _meridian(table, a, b, middle)
    if meridian is not None:
        return meridian
    along = _straight_direction(a, b)
    if along is not None:
        return table.line(middle, along)
    ordered = sorted((first, second))  # one frame, whichever is asked for first
    tubes = tube_frame(surfaces[ordered[0]], surfaces[ordered[1]], table.tolerance)
    if tubes is not None and tubes.least_sine < SHARP:
        return table.tube((first, second), tubes, tubes.sign(guide))
    known = table.find_traced((first, second), middle)
    if known is not None:
        return known
    points, is_closed = march(a, b, middle, 2 * table.reach)
    return table.traced((first, second), (a, b), points, is_closed)
