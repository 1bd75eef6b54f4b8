"""All quads on a planar region: a coarse mesh of twice the size, recombined, then every element split in four.

The region's edges are paired first (numeric.coarsen), so every chain between vertices needs an even number of them. A
coarse triangle that found no mate is split in three quads: the result is all quads whatever the matching.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh.constrained import Edges, constrained, edges_of
from kernel.mesh.cross import dominant_cross, grow, growth_order
from kernel.mesh.mixed import mixed_mesh
from kernel.mesh.region import OddCurveError, Region, RegionMesh
from kernel.mesh.repair import repaired
from kernel.mesh.smoothing import smooth_and_mend
from kernel.mesh.triangles import compact
from kernel.numeric.coarsen import pair_edges
from kernel.numeric.join_lone import join_lone
from kernel.numeric.match import match_triangles
from kernel.numeric.split import given_middles, midpoint_split

_LEAST_PAIR = 0.65
"""Scaled Jacobian under which a pair of triangles is left as two triangles, each cut in three quads."""
_PATH_DEPTH = 8
_SMALL_RING = 4
"""A hole of so few coarse edges is a square in the coarse mesh and is given a ring of quads of its own."""


def coarse_edges(
    points: NDArray[np.float64],
    edges: Edges,
    cross: tuple[float, float, float],
    is_vertex: NDArray[np.bool_] | None = None,
) -> NDArray[np.int32]:
    """The edges in pairs (see numeric.coarsen), MeshError where a chain has an odd number of edges.

    cross: see cross.dominant_cross. is_vertex: (n_point,) points to keep, beside those where curves meet.
    """
    given = np.zeros(len(points), np.uint8) if is_vertex is None else is_vertex.astype(np.uint8)
    coarse, odd = pair_edges(points, *edges.arrays, given, *cross[:2])
    if odd >= 0:
        raise OddCurveError(
            "the curve through {} is divided into an odd number of edges; all quads need an even one",
            points[edges.start[odd]],
        )
    return coarse


def quad_mesh(region: Region, size: float, growth: float, is_vertex: NDArray[np.bool_] | None = None) -> RegionMesh:
    """All quads; the region's edges kept. MeshError where edges cross or a chain has an odd number of edges.

    is_vertex: (n_point,) points that stay nodes of the coarse mesh, beside those where curves meet. Where curves
    nearly touch, or few edges close a loop, the coarse mesh cannot hold them all: then quads with few triangles.
    """
    points = np.array(region.points, dtype=np.float64, order="C")
    edges = edges_of(region)
    cross = dominant_cross(points, edges, region.is_curved)
    pairs = coarse_edges(points, edges, cross, is_vertex)
    mesh = _split_coarse(points, edges, region.is_curved, size, growth, cross, pairs)
    if mesh is None:
        mesh = mixed_mesh(region, size, growth)
    return repaired(mesh, region, size, growth)


def _split_coarse(
    points: NDArray[np.float64],
    edges: Edges,
    is_curved: NDArray[np.bool_],
    size: float,
    growth: float,
    cross: tuple[float, float, float],
    pairs: NDArray[np.int32],
) -> RegionMesh | None:
    """The coarse mesh split and smoothed, None where chords of the pairs cross or two pairs share their chord."""
    n_point = len(points)
    is_kept = np.ones(n_point, np.bool_)
    is_kept[pairs[:, 2]] = False
    kept = np.flatnonzero(is_kept).astype(np.int32)
    coarse_number = np.cumsum(is_kept, dtype=np.int32) - np.int32(1)
    coarse = Edges(
        np.ascontiguousarray(coarse_number[pairs[:, 0]]),
        np.ascontiguousarray(coarse_number[pairs[:, 1]]),
        edges.kind[pairs[:, 3]],
    )
    is_small_ring = (pairs[:, 5] > 0) & (pairs[:, 5] <= _SMALL_RING)
    order = growth_order(len(kept), coarse, is_curved[pairs[:, 3]], is_small_ring)
    nodes = grow(points[kept], coarse, order, 2 * size, growth, cross)
    try:
        triangulation = constrained(nodes, len(kept), coarse, 0)
    except MeshError:
        return None
    corner, twin, lock, leaving = triangulation.half_edges
    n_triangle = triangulation.n_triangle
    mate = match_triangles(nodes, corner, twin, lock, n_triangle, _LEAST_PAIR, _PATH_DEPTH)
    join_lone(nodes, corner, twin, lock, leaving, mate, n_triangle)
    middles = np.ascontiguousarray(pairs[:, 2])
    middle_of = given_middles(corner, twin, leaving, coarse.start, coarse.end, middles, n_triangle)
    is_used = is_kept.copy()
    is_used[middle_of[middle_of >= 0]] = True
    if not is_used.all():
        return None
    node_of = np.concatenate([kept, np.arange(n_point, n_point + len(nodes) - len(kept), dtype=np.int32)])
    nodes, quads = midpoint_split(nodes, points, node_of, corner, twin, mate, middle_of, n_triangle)
    smooth_and_mend(nodes, quads, np.arange(len(nodes)) < n_point)
    return compact(nodes, n_point, quads, np.empty((0, 3), np.int64))
