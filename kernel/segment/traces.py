"""Where one wall stands in the plane of another: footprints, traces of slabs, strips beside tubes."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from kernel.segment.faces import Region
from kernel.segment.walls import PlaneWall, TubeWall, Wall
from kernel.solid.lathe import SAGITTA

PARALLEL = 1.0 - 1e-9
"""Normals or axes with a greater cosine between them are parallel."""

ALONG = 1e-6
"""A wall lies along an axis when its normal is this near (cosine) to square to it."""

FACETS = 2.0 * SAGITTA
"""Of its radius: what a tube's trace is wider by than its true circles, for other faces end at its facets."""

TANGENT = 0.985
"""A plane this far from a tube's axis, of its mean radius, meets its mid-surface at less than 10 degrees."""


def is_parallel(wall: PlaneWall, other: Wall) -> bool:
    """Whether the other wall is flat and parallel to this one."""
    return isinstance(other, PlaneWall) and abs(float(other.normal @ wall.normal)) > PARALLEL


def trace_of(wall: PlaneWall, other: Wall, centre: NDArray[np.float64], reach: float) -> Region | None:
    """Where the other wall's slab passes between the faces of this one, in this one's coordinates.

    None where it does not come within `reach` of the centre.
    """
    if isinstance(other, TubeWall):
        along = abs(float(other.axis.direction @ wall.normal))
        if along < PARALLEL:
            return shapely.box(centre[0] - reach, centre[1] - reach, centre[0] + reach, centre[1] + reach)
        middle = shapely.Point(float(other.axis.point @ wall.u), float(other.axis.point @ wall.v))
        ring = middle.buffer(other.outer_radius * (1.0 + FACETS), quad_segs=64)
        return ring.difference(middle.buffer(other.inner_radius * (1.0 - FACETS), quad_segs=64))
    slope = np.array([other.normal @ wall.u, other.normal @ wall.v])
    sine = float(np.linalg.norm(slope))
    tilt = float(other.normal @ wall.normal)
    ends = [tilt * wall.bottom, tilt * wall.top]
    low, high = (other.bottom - max(ends)) / sine, (other.top - min(ends)) / sine
    across = slope / sine
    along_strip = np.array([-across[1], across[0]])
    at = float(centre @ across)
    if low > at + reach or high < at - reach:
        return None
    start = centre - across * at
    corners = [
        start + across * low - along_strip * reach,
        start + across * high - along_strip * reach,
        start + across * high + along_strip * reach,
        start + across * low + along_strip * reach,
    ]
    return Polygon(corners)


def is_tangent(wall: PlaneWall, other: TubeWall) -> bool:
    """Whether the mid-surfaces of a wall and of a tube along it meet at no angle, if they meet: none runs through."""
    away = abs(0.5 * (wall.bottom + wall.top) - float(wall.normal @ other.axis.point))
    return abs(float(wall.normal @ other.axis.direction)) <= ALONG and away >= TANGENT * other.mid_radius


def strips_beside(wall: PlaneWall, other: TubeWall) -> Region:
    """The strips, or the one, in which a tube's material may lie between the faces of a wall along its axis.

    Empty where the wall does not lie along the axis, or passes the tube by.
    """
    at = float(wall.normal @ other.axis.point)
    nearest = max(wall.bottom - at, at - wall.top, 0.0)
    farthest = max(abs(wall.bottom - at), abs(wall.top - at))
    outer, inner = other.outer_radius * (1.0 + FACETS), other.inner_radius * (1.0 - FACETS)
    if abs(float(wall.normal @ other.axis.direction)) > ALONG or nearest >= outer:
        return Polygon()
    high, low = float(np.sqrt(outer**2 - nearest**2)), float(np.sqrt(max(0.0, inner**2 - farthest**2)))
    axes = np.stack([wall.u, wall.v])
    along, foot = axes @ other.axis.direction, axes @ other.axis.point
    across = np.array([-along[1], along[0]])
    _, start, _, end = other.paired.bounds
    strips = []
    for a, b in ((-high, -low), (low, high)):
        strips.append(Polygon([foot + across * x + along * z for x, z in ((a, start), (b, start), (b, end), (a, end))]))
    return shapely.union_all(strips)


def footprint_of(wall: PlaneWall, other: PlaneWall) -> Region:
    """Where the other wall stands, in this one's coordinates; empty for one that lies above or below it."""
    if is_parallel(wall, other):
        return other.paired if other.bottom < wall.top and wall.bottom < other.top else Polygon()
    left, low, right, high = other.paired.bounds
    corners = np.array([(left, low), (right, low), (right, high), (left, high)])
    flat = corners[:, :1] * other.u + corners[:, 1:] * other.v
    points = np.concatenate([flat + other.normal * offset for offset in (other.bottom, other.top)])
    return shapely.multipoints(points @ np.stack([wall.u, wall.v], axis=1)).convex_hull.buffer(1e-6 * wall.thickness)
