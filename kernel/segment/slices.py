"""Plane slices of a solid's facets, straight from the triangles: for measuring, many and cheap.

For the boundary that meshing needs (with the surfaces that trim each edge) see solid/section.py.
A vertex exactly in the plane counts as above it, so a plane through a face gives the section just above the plane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from kernel.solid.section import area_within

if TYPE_CHECKING:
    from kernel.solid.solid import Facets, Solid

Vector = NDArray[np.float64]

SNAP = 1e-9
"""Slice vertices are rounded to this share of the slice's extent, so that boundaries chain."""


def slice_polygon(facets: Facets, direction: Vector, offset: float, u: Vector, v: Vector) -> Polygon | MultiPolygon:
    """The section at direction . x = offset, in coordinates (x.u, x.v); empty where the plane misses."""
    points, _ = _segments(facets, direction, offset, u, v)
    if len(points) == 0:
        return Polygon()
    extent = float(np.ptp(points.reshape(-1, 2), axis=0).max())
    if extent <= SNAP * float(np.abs(points).max()):
        return Polygon()  # the plane touches a vertex
    return area_within(points, SNAP * extent)


def slice_loops(facets: Facets, direction: Vector, offset: float, u: Vector, v: Vector) -> NDArray[np.float64]:
    """Signed areas of the section's boundary loops: outer ones positive, holes negative. No polygon is made."""
    points, edges = _segments(facets, direction, offset, u, v)
    if len(points) == 0:
        return np.empty(0)
    start, end = points[:, 0], points[:, 1]
    swept = 0.5 * (start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0])
    _, inverse = np.unique(edges, return_inverse=True)
    links = inverse.reshape(-1, 2)
    following = np.empty(len(links), np.int64)
    following[links[:, 0]] = links[:, 1]  # every crossed edge begins one segment and ends one
    label = np.arange(len(links))
    for _ in range(int(len(links)).bit_length()):
        label = np.minimum(label, label[following])  # after k rounds, the least of the next 2^k edges of the loop
        following = following[following]
    areas = np.zeros(len(links))
    np.add.at(areas, label[links[:, 0]], swept)
    areas = areas[np.unique(label)]
    return areas if areas.sum() > 0.0 else -areas


def _segments(
    facets: Facets, direction: Vector, offset: float, u: Vector, v: Vector
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Where triangles cross the plane: segments (n, 2, 2), all running round the material the same way, and for
    each end the mesh edge that it lies on (n, 2), as one number.
    """
    height = facets.vertices @ direction - offset
    above = height >= 0.0
    triangles = facets.triangles
    above_count = above[triangles].sum(axis=1)
    crossing = triangles[(above_count == 1) | (above_count == 2)]
    if len(crossing) == 0:
        return np.empty((0, 2, 2)), np.empty((0, 2), np.int64)
    up = above[crossing]
    following = np.roll(up, -1, axis=1)
    rows = np.arange(len(crossing))
    leaving, entering = np.argmax(up & ~following, axis=1), np.argmax(~up & following, axis=1)
    ends = []
    edges = []
    plane = facets.vertices @ np.stack([u, v], axis=1)
    for corner in (leaving, entering):
        pair = np.sort(np.stack([crossing[rows, corner], crossing[rows, (corner + 1) % 3]], axis=1), axis=1)
        start, end = pair[:, 0], pair[:, 1]
        share = height[start] / (height[start] - height[end])
        ends.append(plane[start] + share[:, None] * (plane[end] - plane[start]))
        edges.append(start * len(facets.vertices) + end)
    return np.stack(ends, axis=1), np.stack(edges, axis=1)


def smallest_rectangle(geometry: shapely.Geometry) -> tuple[float, float]:
    """Sides (long, short) of the smallest rectangle, turned any way, around a geometry; nought of one without area.

    It stands on a side of the convex hull (Freeman and Shapira 1975). GEOS's own gives a line for some hulls that have
    sides nearly in line.
    """
    hull = geometry.convex_hull
    if hull.geom_type != "Polygon" or hull.is_empty:
        return 0.0, 0.0
    corners = np.array(hull.exterior.coords)[:-1]
    sides = np.roll(corners, -1, axis=0) - corners
    lengths = np.linalg.norm(sides, axis=1)
    long_enough = lengths > SHORTEST_SIDE * lengths.max()
    along = sides[long_enough] / lengths[long_enough, None]
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    extents = np.stack([np.ptp(corners @ directions.T, axis=0) for directions in (along, across)], axis=1)
    best = extents[np.argmin(extents.prod(axis=1))]
    return float(best.max()), float(best.min())


def parts_of(geometry: shapely.Geometry) -> list[Polygon]:
    """The polygons of positive area in any geometry."""
    parts = shapely.get_parts(geometry)
    is_wide = (shapely.get_type_id(parts) == shapely.GeometryType.POLYGON) & (shapely.area(parts) > 0.0)
    return list(parts[is_wide])


def outline_points(solid: Solid) -> NDArray[np.float64]:
    """(n, 3) vertices of the solid's convex hull: all that extents in any direction need."""
    known = _HULLS.get(solid)
    if known is None:
        vertices = solid.facets.vertices
        if len(vertices) > MANY_VERTICES:
            vertices = np.asarray(solid.manifold.hull().to_mesh64().vert_properties, dtype=np.float64)[:, :3]
        known = _HULLS[solid] = vertices
    return known


_HULLS: WeakKeyDictionary[Solid, NDArray[np.float64]] = WeakKeyDictionary()

SHORTEST_SIDE = 1e-9
"""A side of a hull shorter than this share of its longest one has no direction."""

MANY_VERTICES = 500
"""Solids with more vertices are worth a convex hull before their extents are measured."""
