"""Plane slices of a solid's facets, straight from the triangles: for measuring, many and cheap.

For the boundary that meshing needs (with the surfaces that trim each edge) see solid/section.py.
A vertex exactly in the plane counts as above it, so a plane through a face gives the section just above the plane.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from kernel.solid.section import area_within

if TYPE_CHECKING:
    from kernel.solid.solid import Facets

Vector = NDArray[np.float64]

SNAP = 1e-9
"""Slice vertices are rounded to this share of the slice's extent, so that boundaries chain."""


def slice_polygon(facets: Facets, direction: Vector, offset: float, u: Vector, v: Vector) -> Polygon | MultiPolygon:
    """The section at direction . x = offset, in coordinates (x.u, x.v); empty where the plane misses."""
    height = facets.vertices @ direction - offset
    above = height >= 0.0
    triangles = facets.triangles
    above_count = above[triangles].sum(axis=1)
    crossing = triangles[(above_count == 1) | (above_count == 2)]
    if len(crossing) == 0:
        return Polygon()
    edges = crossing[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    edges = np.sort(edges[above[edges[:, 0]] != above[edges[:, 1]]], axis=1)  # two to a triangle, in its order
    start, end = edges[:, 0], edges[:, 1]
    share = height[start] / (height[start] - height[end])
    plane = facets.vertices @ np.stack([u, v], axis=1)
    points = plane[start] + share[:, None] * (plane[end] - plane[start])
    grid = SNAP * max(float(np.ptp(points, axis=0).max()), 1e-300)
    return area_within(points.reshape(-1, 2, 2), grid)


def smallest_rectangle(polygon: shapely.Geometry) -> tuple[float, float]:
    """Sides (long, short) of the smallest rectangle, turned any way, around a geometry."""
    rectangle = polygon.minimum_rotated_rectangle
    if rectangle.geom_type != "Polygon":
        return 0.0, 0.0
    corners = np.array(rectangle.exterior.coords)[:3]
    sides = np.linalg.norm(np.diff(corners, axis=0), axis=1)
    return float(sides.max()), float(sides.min())


def parts_of(geometry: shapely.Geometry) -> list[Polygon]:
    """The polygons of positive area in any geometry."""
    return [part for part in shapely.get_parts(geometry) if part.geom_type == "Polygon" and part.area > 0.0]
