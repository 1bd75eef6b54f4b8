"""Triangles on a planar region: an equilateral lattice, refined and smoothed where it meets the boundary."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh.region import Region, RegionMesh
from kernel.numeric.lattice import place_lattice
from kernel.numeric.refine import refine
from kernel.numeric.smooth_triangles import active_nodes, raise_smallest_angles, smooth_triangles
from kernel.numeric.triangulation import triangulate
from kernel.numeric.valence import even_valences, lock_sharp_corners, remove_low_valence

_SHARP_CORNER = math.radians(75)
_SMOOTH_UNDER = 0.93
_GOOD_ENOUGH = 0.8
_SMALL_SINE = 0.62
"""Pattern search lifts triangles whose smallest angle is under asin(.62) = 38 degrees."""


def edge_arrays(region: Region) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.uint8]]:
    """Start, end (n_edge,) int32 and kind (n_edge,) uint8 of the edges, as the kernels take them."""
    start = np.ascontiguousarray(region.edges[:, 0], dtype=np.int32)
    end = np.ascontiguousarray(region.edges[:, 1], dtype=np.int32)
    kind = np.where(region.is_boundary, np.uint8(1), np.uint8(2))
    return start, end, kind


def refuse_lost_edges(points: NDArray[np.float64], start: NDArray[np.int32], end: NDArray[np.int32],
                      failed: NDArray[np.uint8]) -> None:  # fmt: skip
    """MeshError with the place of the first edge that another edge or point stands in the way of."""
    lost = np.flatnonzero(failed)
    if len(lost):
        a, b = points[start[lost[0]]], points[end[lost[0]]]
        raise MeshError(
            f"the region's edges cross or touch near ({(a[0] + b[0]) / 2:.6g}, {(a[1] + b[1]) / 2:.6g}): "
            f"{len(lost)} of {len(start)} edges cannot be kept"
        )


def _lattice_frame(points: NDArray[np.float64], start: NDArray[np.int32], end: NDArray[np.int32],
                   size: float) -> tuple[float, float, float]:  # fmt: skip
    """Direction of the lattice's rows, that of most of the boundary (by length, modulo 60 degrees), and its origin."""
    along = points[end] - points[start]
    length = np.hypot(along[:, 0], along[:, 1])
    angle = np.arctan2(along[:, 1], along[:, 0])
    sixth = np.round(np.mod(angle, np.pi / 3) / (np.pi / 3) * 360).astype(np.int64) % 360
    weight = np.bincount(sixth, weights=length * (length > 0.5 * size), minlength=360)
    candidates = np.flatnonzero(sixth == weight.argmax())
    edge = candidates[length[candidates].argmax()]
    middle = 0.5 * (points[start[edge]] + points[end[edge]])
    apex = length[edge] * math.sqrt(3) / 2
    return float(angle[edge]), middle[0] - apex * math.sin(angle[edge]), middle[1] + apex * math.cos(angle[edge])


def triangle_mesh(region: Region, size: float) -> RegionMesh:
    """All triangles; the region's edges kept. MeshError where edges cross."""
    points = np.ascontiguousarray(region.points, dtype=np.float64)
    start, end, kind = edge_arrays(region)
    n_point = len(points)
    placed = place_lattice(points, start, end, kind, float(size), *_lattice_frame(points, start, end, size))
    n_node = len(placed)
    n_spare = n_node // 2 + 4 * n_point + 100
    corner, twin, lock, leaving, n_triangle, x, y, origin, scale, _, failed = triangulate(
        placed, n_point, start, end, kind, n_spare
    )
    refuse_lost_edges(points, start, end, failed)
    nodes = np.empty((n_node + n_spare, 2))
    nodes[:n_node] = placed
    n_node, n_triangle = refine(
        nodes, n_node, x, y, origin, scale, corner, twin, lock, leaving, n_triangle, float(size)
    )
    is_fixed = np.zeros(n_node, np.uint8)
    is_fixed[:n_point] = 1
    lock_sharp_corners(nodes, corner, twin, lock, leaving, n_node, _SHARP_CORNER)
    active = active_nodes(nodes, n_node, corner, leaving, n_triangle, is_fixed, _SMOOTH_UNDER)
    smooth_triangles(nodes, corner, twin, lock, leaving, active, 4, _GOOD_ENOUGH)
    n_triangle = remove_low_valence(nodes, corner, twin, lock, leaving, n_triangle, is_fixed, n_node)
    even_valences(nodes, corner, twin, lock, leaving, n_triangle, n_node)
    active = active_nodes(nodes, n_node, corner, leaving, n_triangle, is_fixed, _SMOOTH_UNDER)
    smooth_triangles(nodes, corner, twin, lock, leaving, active, 4, _GOOD_ENOUGH)
    raise_smallest_angles(nodes, corner, twin, leaving, active, _SMALL_SINE, 3)
    return compact(nodes[:n_node], n_point, np.empty((0, 4), np.int64), corner[: 3 * n_triangle].reshape(-1, 3))


def compact(
    nodes: NDArray[np.float64], n_point: int, quads: NDArray[np.integer], triangles: NDArray[np.integer]
) -> RegionMesh:
    """The mesh without the nodes that no element uses; the region's own n_point stay whatever uses them."""
    is_used = np.zeros(len(nodes), np.bool_)
    is_used[:n_point] = True
    is_used[quads.ravel()] = True
    is_used[triangles.ravel()] = True
    new_number = np.cumsum(is_used) - 1
    return RegionMesh(nodes[is_used], new_number[quads], new_number[triangles])
