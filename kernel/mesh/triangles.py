"""Triangles on a planar region: an equilateral lattice, refined and smoothed where it meets the boundary."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.constrained import Edges, constrained, edges_of
from kernel.mesh.region import Region, RegionMesh
from kernel.numeric.lattice import place_lattice
from kernel.numeric.refine import refine
from kernel.numeric.size_grid import base_grid
from kernel.numeric.smooth_triangles import active_nodes, raise_smallest_angles, smooth_triangles
from kernel.numeric.valence import even_valences, lock_sharp_corners, remove_low_valence

_SHARP_CORNER = math.radians(75)
_SMOOTH_UNDER = 0.93
_GOOD_ENOUGH = 0.8
_FIRST_PASSES = 2
_LAST_PASSES = 3
_SMALL_SINE = 0.62
"""Pattern search lifts triangles whose smallest angle is under asin(.62) = 38 degrees."""


def _lattice_frame(points: NDArray[np.float64], edges: Edges, size: float) -> tuple[float, float, float]:
    """Direction of the lattice's rows, that of most of the boundary (by length, modulo 60 degrees), and its origin."""
    along = points[edges.end] - points[edges.start]
    length = np.hypot(along[:, 0], along[:, 1])
    angle = np.arctan2(along[:, 1], along[:, 0])
    sixth = np.round(np.mod(angle, np.pi / 3) / (np.pi / 3) * 360).astype(np.int64) % 360
    counts = length > 0.5 * size  # short edges are those of curves, which show no direction
    weight = np.bincount(sixth, weights=length * counts if counts.any() else length, minlength=360)
    candidates = np.flatnonzero(sixth == weight.argmax())
    edge = candidates[length[candidates].argmax()]
    middle = 0.5 * (points[edges.start[edge]] + points[edges.end[edge]])
    apex = length[edge] * math.sqrt(3) / 2
    return float(angle[edge]), middle[0] - apex * math.sin(angle[edge]), middle[1] + apex * math.cos(angle[edge])


def triangle_mesh(region: Region, size: float, growth: float) -> RegionMesh:
    """All triangles; the region's edges kept. MeshError where edges cross or points coincide."""
    points = np.array(region.points, dtype=np.float64, order="C")
    n_point = len(points)
    edges = edges_of(region)
    base, is_graded, *base_place = base_grid(points, edges.start, edges.end, float(size), growth)
    frame = _lattice_frame(points, edges, size)
    placed = place_lattice(points, *edges.arrays, float(size), *frame, is_graded, base, *base_place)
    n_spare = len(placed) // 2 + 4 * n_point + 100
    while True:
        mesh = constrained(placed, n_point, edges, n_spare)
        nodes = np.empty((len(placed) + n_spare, 2))
        nodes[: len(placed)] = placed
        grid = (mesh.x, mesh.y, mesh.origin, mesh.scale)
        n_node, n_triangle = refine(
            nodes, len(placed), *grid, *mesh.half_edges, mesh.n_triangle, base, *base_place, growth
        )
        if n_node < len(nodes) - 1:
            break
        n_spare *= 4  # the room is used up
    corner, _, _, leaving = half_edges = mesh.half_edges
    is_fixed = np.zeros(n_node, np.uint8)
    is_fixed[:n_point] = 1
    lock_sharp_corners(nodes, *half_edges, n_node, _SHARP_CORNER)
    active = active_nodes(nodes, n_node, corner, leaving, n_triangle, is_fixed, _SMOOTH_UNDER)
    smooth_triangles(nodes, *half_edges, active, _FIRST_PASSES, _GOOD_ENOUGH)
    n_triangle = remove_low_valence(nodes, *half_edges, n_triangle, is_fixed, n_node)
    even_valences(nodes, *half_edges, n_triangle, n_node)
    active = active_nodes(nodes, n_node, corner, leaving, n_triangle, is_fixed, _SMOOTH_UNDER)
    smooth_triangles(nodes, *half_edges, active, _LAST_PASSES, _GOOD_ENOUGH)
    raise_smallest_angles(nodes, corner, mesh.twin, leaving, active, _SMALL_SINE, 3)
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
