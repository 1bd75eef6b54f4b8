"""Short edges in the boundary of a tetrahedral mesh, each drawn together into one node.

Within its envelope the mesher may leave two boundary nodes one above the other: they cannot both be moved onto the
surface. One of them goes, if the tets around allow it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.boundary import boundary_triangles
from kernel.mesh.tets import tet_shapes

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


def without_short_edges(
    nodes: Array, tets: Indices, crowded: Indices, shortest: float, least_shape: float
) -> tuple[Array, Indices]:
    """Nodes and tets in which boundary edges at crowded nodes (k,), shorter than `shortest`, are drawn together.

    An edge stays where a tet would get a shape below least_shape and below what the worst tet around had, or where
    the boundary would no longer be a surface.
    """
    for node in crowded.tolist():
        triangles = boundary_triangles(tets)
        around = np.setdiff1d(triangles[(triangles == node).any(axis=1)], [node])
        length = np.linalg.norm(nodes[around] - nodes[node], axis=1)
        for row in np.argsort(length, kind="stable"):
            if length[row] > shortest:
                break
            drawn = _drawn_together(nodes, tets, node, int(around[row]), least_shape)
            if drawn is not None:
                tets = drawn
                break
    used = np.unique(tets)
    number = np.full(len(nodes), -1, np.int64)
    number[used] = np.arange(len(used))
    return nodes[used], number[tets]


def _drawn_together(nodes: Array, tets: Indices, node: int, other: int, least_shape: float) -> Indices | None:
    """The tets with `other` in the place of `node`, None where they would not do."""
    touches = (tets == node).any(axis=1)
    gone = touches & (tets == other).any(axis=1)
    changed = tets.copy()
    changed[tets == node] = other
    moved = touches & ~gone
    if not moved.any():
        return None
    worst = float(tet_shapes(nodes, tets[touches]).min())
    if tet_shapes(nodes, changed[moved]).min() < min(least_shape, worst):
        return None
    changed = changed[~gone]
    if len(np.unique(np.sort(changed, axis=1), axis=0)) < len(changed):
        return None
    return changed if is_bounded_by_surface(changed) else None


def is_bounded_by_surface(tets: Indices) -> bool:
    """Whether no face is shared by three tets, and each edge of the boundary by just two of its triangles."""
    faces = np.sort(tets[:, [[0, 1, 2], [0, 1, 3], [0, 2, 3], [1, 2, 3]]].reshape(-1, 3), axis=1)
    unique, count = np.unique(faces, axis=0, return_counts=True)
    if count.max() > 2:
        return False
    outer = unique[count == 1]
    edges = outer[:, [[0, 1], [0, 2], [1, 2]]].reshape(-1, 2)
    _, times = np.unique(edges, axis=0, return_counts=True)
    return bool((times == 2).all())
