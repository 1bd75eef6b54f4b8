"""The triangles of an evaluated solid, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from manifold3d import Manifold, Mesh64
from numpy.typing import NDArray

from kernel.csg.tree import frozen_array
from kernel.pieces import connected_pieces
from kernel.solid.surfaces import crosses
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import CUTTER


@dataclass(frozen=True, eq=False)
class Facets:
    """Triangles counter-clockwise from outside; arrays are read-only.

    vertices: (n, 3); triangles: (m, 3) int64. surface: (m,) int64 ids in the surface table. source: (m,) int64 index
    of the primitive that a triangle comes from, tracked.CUTTER for cuts. normals (m, 3) unit, areas (m,),
    centroids (m, 3).
    """

    vertices: NDArray[np.float64]
    triangles: NDArray[np.int64]
    surface: NDArray[np.int64]
    source: NDArray[np.int64]
    normals: NDArray[np.float64]
    areas: NDArray[np.float64]
    centroids: NDArray[np.float64]

    @cached_property
    def neighbours(self) -> NDArray[np.int64]:
        """(m, 3) the triangle across edge k, from corner k to corner k + 1."""
        return frozen_array(edge_neighbours(self.triangles, len(self.vertices)), np.int64)


def edge_neighbours(triangles: NDArray[np.int64], n_vertex: int) -> NDArray[np.int64]:
    """(m, 3) the triangle that has edge k, corner k to k + 1, the other way round; -1 where none has."""
    start = triangles.ravel()
    end = triangles[:, [1, 2, 0]].ravel()
    own = start * n_vertex + end
    order = np.argsort(own, kind="stable")
    wanted = end * n_vertex + start
    place = np.minimum(np.searchsorted(own[order], wanted), len(own) - 1)
    found = order[place] if len(own) else order
    return np.where(own[found] == wanted, found // 3, -1).reshape(-1, 3)


def shells_of(facets: Facets) -> NDArray[np.int64]:
    """(m,) number of the connected surface that each triangle belongs to: its smallest vertex."""
    start, end = facets.triangles.ravel(), facets.triangles[:, [1, 2, 0]].ravel()
    return connected_pieces(len(facets.vertices), start, end)[facets.triangles[:, 0]]


def facets_of(manifold: Manifold, table: SurfaceTable) -> Facets:
    """The triangles of an evaluated manifold; vertices that manifold keeps apart for its properties are one."""
    mesh = manifold.to_mesh64()
    vertices = np.array(mesh.vert_properties, dtype=np.float64).reshape(-1, mesh.vert_properties.shape[-1] or 3)[:, :3]
    triangles = np.array(mesh.tri_verts, dtype=np.int64).reshape(-1, 3)
    merge_from, merge_to = np.asarray(mesh.merge_from_vert, np.int64), np.asarray(mesh.merge_to_vert, np.int64)
    if len(merge_from):
        same = np.arange(len(vertices))
        same[merge_from] = merge_to
        triangles = same[triangles]
    run = np.asarray(mesh.run_index, np.int64) // 3
    source = np.full(len(triangles), CUTTER, np.int64)
    for original, start, end in zip(mesh.run_original_id, run[:-1], run[1:]):
        source[start:end] = table.sources.get(int(original), CUTTER)
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    cross = crosses(b - a, c - a)
    double = np.linalg.norm(cross, axis=1)
    return Facets(
        frozen_array(vertices),
        frozen_array(triangles, np.int64),
        frozen_array(mesh.face_id, np.int64),
        frozen_array(source, np.int64),
        frozen_array(cross / np.where(double > 0.0, double, 1.0)[:, None]),
        frozen_array(0.5 * double),
        frozen_array((a + b + c) / 3.0),
    )


def joined(manifolds: Sequence[Manifold]) -> Manifold:
    """Disjoint surfaces as one manifold, triangle by triangle: a shell and the voids in it, which are inside out."""
    meshes = [manifold.to_mesh64() for manifold in manifolds]
    first_vertex = np.cumsum([0, *(len(mesh.vert_properties) for mesh in meshes)]).tolist()
    first_triangle = np.cumsum([0, *(len(mesh.tri_verts) for mesh in meshes)]).tolist()
    return Manifold(
        Mesh64(
            np.concatenate([np.asarray(mesh.vert_properties, np.float64)[:, :3] for mesh in meshes]),
            np.concatenate(
                [np.asarray(mesh.tri_verts, np.uint64) + np.uint64(n) for mesh, n in zip(meshes, first_vertex)]
            ),
            merge_from_vert=_shifted([mesh.merge_from_vert for mesh in meshes], first_vertex),
            merge_to_vert=_shifted([mesh.merge_to_vert for mesh in meshes], first_vertex),
            run_index=np.concatenate(
                [
                    *(
                        np.asarray(mesh.run_index, np.uint64)[:-1] + np.uint64(3 * n)
                        for mesh, n in zip(meshes, first_triangle)
                    ),
                    np.array([3 * first_triangle[-1]], np.uint64),
                ]
            ),
            run_original_id=np.concatenate([np.asarray(mesh.run_original_id, np.uint32) for mesh in meshes]),
            face_id=np.concatenate([np.asarray(mesh.face_id, np.uint64) for mesh in meshes]),
        )
    )


def _shifted(indices: Sequence[NDArray], starts: Sequence[int]) -> NDArray[np.uint64]:
    return np.concatenate([np.asarray(index, np.uint64) + np.uint64(n) for index, n in zip(indices, starts)])


def solid_angle(facets: Facets, point: NDArray[np.float64]) -> float:
    """Solid angle of the facets seen from `point`, over 4 pi: 1 inside, 0 outside (van Oosterom and Strackee 1983)."""
    arms = facets.vertices - point
    length = np.linalg.norm(arms, axis=1)
    a, b, c = (arms[facets.triangles[:, k]] for k in range(3))
    la, lb, lc = (length[facets.triangles[:, k]] for k in range(3))
    triple = np.einsum("ij,ij->i", a, np.cross(b, c))
    dots = np.einsum("ij,ij->i", a, b) * lc + np.einsum("ij,ij->i", b, c) * la + np.einsum("ij,ij->i", c, a) * lb
    return float(2.0 * np.arctan2(triple, la * lb * lc + dots).sum() / (4.0 * np.pi))
