"""All quads on a planar region: a coarse mesh of twice the size, recombined, then every element split in four.

The region's edges are paired first (coarsen), so every chain between vertices needs an even number of them. A coarse
triangle that found no mate is split in three quads: the result is all quads whatever the matching.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh.region import Region, RegionMesh
from kernel.mesh.triangles import compact, edge_arrays, refuse_lost_edges
from kernel.numeric.coarsen import pair_edges
from kernel.numeric.front import grow_front
from kernel.numeric.match import match_triangles
from kernel.numeric.smooth_quads import smooth_quads
from kernel.numeric.split import given_middles, midpoint_split
from kernel.numeric.triangulation import triangulate

_LEAST_PAIR = 0.65
"""Scaled Jacobian under which a pair of triangles is left as two triangles, each cut in three quads."""
_PATH_DEPTH = 8
_SCREEN = 0.2
_DOMINANT_SHARE = 0.08
"""The field is pulled to the dominant direction if this share of all edge length runs along it."""
_GROWTH = 0.3


def _dominant_cross(points: NDArray[np.float64], start: NDArray[np.int32], end: NDArray[np.int32],
                    is_boundary: NDArray[np.bool_]) -> tuple[float, float, float]:  # fmt: skip
    """cos 4a and sin 4a of the direction that most of the boundary runs along, and its share of all edge length."""
    along = points[end] - points[start]
    length = np.hypot(along[:, 0], along[:, 1])
    angle4 = 4 * np.arctan2(along[:, 1], along[:, 0])
    bucket = np.round(np.mod(angle4, 2 * np.pi) / (2 * np.pi) * 90).astype(np.int64) % 90
    weight = np.bincount(bucket, weights=length * is_boundary, minlength=90)
    chosen = bucket == weight.argmax()
    angle = math.atan2((length * np.sin(angle4))[chosen].sum(), (length * np.cos(angle4))[chosen].sum())
    return math.cos(angle), math.sin(angle), float(weight.max() / length.sum())


def coarse_edges(points: NDArray[np.float64], start: NDArray[np.int32], end: NDArray[np.int32],
                 kind: NDArray[np.uint8], is_vertex: NDArray[np.bool_] | None) -> NDArray[np.int32]:  # fmt: skip
    """The edges in pairs (see numeric.coarsen), MeshError where a chain has an odd number of edges."""
    given = np.zeros(len(points), np.uint8) if is_vertex is None else is_vertex.astype(np.uint8)
    coarse, odd = pair_edges(points, start, end, kind, given)
    if odd >= 0:
        x, y = points[start[odd]]
        raise MeshError(
            f"the curve through ({x:.6g}, {y:.6g}) is divided into an odd number of edges; all quads need an even one"
        )
    return coarse


def quad_mesh(region: Region, size: float, is_vertex: NDArray[np.bool_] | None = None) -> RegionMesh:
    """All quads; the region's edges kept. MeshError where edges cross or a chain has an odd number of edges.

    is_vertex: (n_point,) points that stay nodes of the coarse mesh, beside those where curves meet.
    """
    points = np.ascontiguousarray(region.points, dtype=np.float64)
    n_point = len(points)
    start, end, kind = edge_arrays(region)
    coarse = coarse_edges(points, start, end, kind, is_vertex)
    is_kept = np.ones(n_point, np.bool_)
    is_kept[coarse[:, 2]] = False
    kept = np.flatnonzero(is_kept).astype(np.int32)
    coarse_number = np.cumsum(is_kept, dtype=np.int32) - np.int32(1)
    coarse_points = points[kept]
    n_coarse_point = len(kept)
    coarse_start = np.ascontiguousarray(coarse_number[coarse[:, 0]])
    coarse_end = np.ascontiguousarray(coarse_number[coarse[:, 1]])
    middle = np.ascontiguousarray(coarse[:, 2])
    coarse_kind = kind[coarse[:, 3]]
    is_straight = ~region.is_curved[coarse[:, 3]]
    is_curved_point = np.zeros(n_coarse_point, np.uint8)
    is_curved_point[coarse_start[~is_straight]] = 1
    is_curved_point[coarse_end[~is_straight]] = 1
    is_curved_point[coarse_start[is_straight]] = 0
    is_curved_point[coarse_end[is_straight]] = 0
    cosine, sine, share = _dominant_cross(coarse_points, coarse_start, coarse_end, coarse_kind == 1)
    screen = _SCREEN if share > _DOMINANT_SHARE else 0.0
    nodes = grow_front(
        coarse_points, coarse_start, coarse_end, coarse_kind, is_curved_point, 2.0 * size, cosine, sine, screen, _GROWTH
    )
    corner, twin, lock, leaving, n_triangle, *_, failed = triangulate(
        nodes, n_coarse_point, coarse_start, coarse_end, coarse_kind, 0
    )
    refuse_lost_edges(coarse_points, coarse_start, coarse_end, failed)
    mate = match_triangles(nodes, corner, twin, lock, n_triangle, _LEAST_PAIR, _PATH_DEPTH)
    middle_of = given_middles(corner, twin, leaving, coarse_start, coarse_end, middle, n_triangle)
    grown = np.arange(n_point, n_point + len(nodes) - n_coarse_point, dtype=np.int32)
    node_of = np.concatenate([kept, grown])
    nodes, quads = midpoint_split(nodes, points, node_of, corner, twin, mate, middle_of, n_triangle)
    smooth(nodes, quads, np.arange(len(nodes)) < n_point)
    return compact(nodes, n_point, quads, np.empty((0, 3), np.int64))


def smooth(nodes: NDArray[np.float64], quads: NDArray[np.integer], is_fixed: NDArray[np.bool_]) -> None:
    """Smooth the free nodes, in place."""
    smooth_quads(nodes, np.ascontiguousarray(quads, np.int32), is_fixed.astype(np.uint8), 6, 4, 0.97, 0.8, 0.85, 2)
