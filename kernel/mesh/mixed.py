"""Quads with few triangles, on any valid division of a region's curves: what all quads cannot do, this can.

A square front at the size itself, a constrained triangulation, and triangles merged in pairs where that makes a good
quad. Triangles stay where curves have an odd number of edges, or lie nearer to each other than their edges are long;
their nodes stay where they are while the quads are smoothed.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.constrained import Triangulation, constrained, edges_of
from kernel.mesh.cross import dominant_cross, grow, growth_order
from kernel.mesh.region import Region, RegionMesh
from kernel.mesh.smoothing import smooth_and_mend
from kernel.mesh.triangles import compact
from kernel.numeric.match import match_triangles
from kernel.numeric.smooth_triangles import active_nodes, smooth_triangles

_LEAST_PAIR = 0.35
"""Scaled Jacobian of the worst quad that is still preferred to its two triangles."""
_PATH_DEPTH = 8
_SMOOTH_UNDER = 0.55
"""Half a square, a right isosceles triangle, has quality .866 and is left alone."""
_GOOD_ENOUGH = 0.7


def mixed_mesh(region: Region, size: float, growth: float) -> RegionMesh:
    """Quads and triangles; the region's edges kept. MeshError where edges cross or points coincide."""
    points = np.array(region.points, dtype=np.float64, order="C")
    n_point = len(points)
    edges = edges_of(region)
    order = growth_order(n_point, edges, region.is_curved)
    nodes = grow(points, edges, order, size, growth, dominant_cross(points, edges, region.is_curved))
    triangulation = constrained(nodes, n_point, edges, 0)
    is_fixed = (np.arange(len(nodes)) < n_point).astype(np.uint8)
    n_triangle = triangulation.n_triangle
    corner, _, _, leaving = triangulation.half_edges
    active = active_nodes(nodes, len(nodes), corner, leaving, n_triangle, is_fixed, _SMOOTH_UNDER)
    smooth_triangles(nodes, *triangulation.half_edges, active, 4, _GOOD_ENOUGH)
    quads, triangles = merged(nodes, triangulation)
    is_held = np.arange(len(nodes)) < n_point
    is_held[triangles] = True
    smooth_and_mend(nodes, quads, is_held)
    return compact(nodes, n_point, quads, triangles)


def merged(nodes: NDArray[np.float64], triangulation: Triangulation) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Quads of the triangles that pair well, and the triangles left."""
    corner, twin, lock, _ = triangulation.half_edges
    n_triangle = triangulation.n_triangle
    mate = match_triangles(nodes, corner, twin, lock, n_triangle, _LEAST_PAIR, _PATH_DEPTH)
    e = mate[mate >= 0].astype(np.int64)
    e = e[e < twin[e]]
    f = twin[e].astype(np.int64)
    following = np.array([1, 1, -2])
    quads = np.column_stack(
        [
            corner[e + following[e % 3]],
            corner[e - 1 + 3 * (e % 3 == 0)],
            corner[f + following[f % 3]],
            corner[f - 1 + 3 * (f % 3 == 0)],
        ]
    ).astype(np.int32)
    triangles = corner[: 3 * n_triangle].reshape(-1, 3)[mate < 0].astype(np.int64)
    return quads, triangles
