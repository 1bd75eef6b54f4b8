"""No bad quad leaves: where smoothing did not help, the neighbourhood is meshed anew as quads with few triangles.

+---+---+---+        a patch: the bad quads and a ring of quads about them; its rim and the region's
| P | P | P |        own edges inside it are kept, its inner nodes are not. If the patch cannot be
+---+---+---+        meshed (its rim crosses itself) it grows by a ring, up to the whole region.
| P |bad| P |
+---+---+---+
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh.mixed import mixed_mesh
from kernel.mesh.region import Region, RegionMesh
from kernel.mesh.triangles import compact
from kernel.numeric.smooth_quads import quad_sines

LEAST_SCALED_JACOBIAN = 0.2
"""No quad under this leaves the mesher."""
_FIRST_RINGS = 1
_MOST_RINGS = 6


def scaled_jacobians(mesh: RegionMesh) -> NDArray[np.float64]:
    """Scaled Jacobian of each quad, (n_quad,)."""
    return quad_sines(np.ascontiguousarray(mesh.points), np.ascontiguousarray(mesh.quads, np.int32))


def repaired(mesh: RegionMesh, region: Region, size: float, growth: float) -> RegionMesh:
    """The mesh with every quad under LEAST_SCALED_JACOBIAN replaced, and the rest as it was where that is possible."""
    for n_ring in range(_FIRST_RINGS, _MOST_RINGS + 1):
        is_bad = scaled_jacobians(mesh) < LEAST_SCALED_JACOBIAN
        if not is_bad.any():
            return mesh
        mesh = _with_new_patches(mesh, region, size, growth, is_bad, n_ring)
    if (scaled_jacobians(mesh) < LEAST_SCALED_JACOBIAN).any():
        return mixed_mesh(region, size, growth)
    return mesh


def _with_new_patches(
    mesh: RegionMesh, region: Region, size: float, growth: float, is_bad: NDArray[np.bool_], n_ring: int
) -> RegionMesh:
    """Patches of n_ring rings about the bad quads meshed anew, those that can be."""
    n_quad = len(mesh.quads)
    in_patch = is_bad.copy()
    triangle_in_patch = np.zeros(len(mesh.triangles), np.bool_)
    is_near = np.zeros(len(mesh.points), np.bool_)
    for _ in range(n_ring):
        is_near[mesh.quads[in_patch].ravel()] = True
        is_near[mesh.triangles[triangle_in_patch].ravel()] = True
        in_patch = np.any(is_near[mesh.quads], axis=1)
        triangle_in_patch = np.any(is_near[mesh.triangles], axis=1)
    patch_of = _components(mesh, in_patch, triangle_in_patch)
    quads = [mesh.quads[~in_patch]]
    triangles = [mesh.triangles[~triangle_in_patch]]
    points = [mesh.points]
    n_point = len(mesh.points)
    for patch in range(int(patch_of.max()) + 1):
        of_quads = np.flatnonzero(patch_of[:n_quad] == patch)
        of_triangles = np.flatnonzero(patch_of[n_quad:] == patch)
        try:
            new = _patch_mesh(mesh, region, size, growth, of_quads, of_triangles)
        except MeshError:  # the rim crosses itself: left as it is for a wider patch
            quads.append(mesh.quads[of_quads])
            triangles.append(mesh.triangles[of_triangles])
            continue
        number, patch_points, patch_quads, patch_triangles = new
        numbers = np.concatenate([number, np.arange(n_point, n_point + len(patch_points) - len(number))])
        points.append(patch_points[len(number) :])
        n_point += len(patch_points) - len(number)
        quads.append(numbers[patch_quads])
        triangles.append(numbers[patch_triangles])
    return compact(np.concatenate(points), len(region.points), np.concatenate(quads), np.concatenate(triangles))


def _components(
    mesh: RegionMesh, in_patch: NDArray[np.bool_], triangle_in_patch: NDArray[np.bool_]
) -> NDArray[np.int64]:
    """Number of the patch that each element (quads, then triangles) belongs to, -1 for none; patches share no node."""
    label = np.arange(len(mesh.points))
    elements = [mesh.quads[in_patch], mesh.triangles[triangle_in_patch]]
    while True:
        before = label.copy()
        for nodes in elements:
            if len(nodes):
                least = label[nodes].min(axis=1)
                for k in range(nodes.shape[1]):
                    np.minimum.at(label, nodes[:, k], least)
        if np.array_equal(before, label):
            break
    found = np.full(len(mesh.quads) + len(mesh.triangles), -1, np.int64)
    found[: len(mesh.quads)][in_patch] = label[mesh.quads[in_patch][:, 0]]
    found[len(mesh.quads) :][triangle_in_patch] = label[mesh.triangles[triangle_in_patch][:, 0]]
    chosen = found >= 0
    found[chosen] = np.unique(found[chosen], return_inverse=True)[1]
    return found


def _patch_mesh(
    mesh: RegionMesh,
    region: Region,
    size: float,
    growth: float,
    of_quads: NDArray[np.int64],
    of_triangles: NDArray[np.int64],
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """Nodes kept (by number in the mesh), points (kept ones first), quads and triangles of a patch meshed anew."""
    n_point = len(region.points)
    sides = []
    for nodes in (mesh.quads[of_quads], mesh.triangles[of_triangles]):
        n_corner = nodes.shape[1]
        sides += [nodes[:, [k, (k + 1) % n_corner]] for k in range(n_corner)]
    side = np.concatenate(sides)
    n = len(mesh.points)
    key = np.minimum(side[:, 0], side[:, 1]) * n + np.maximum(side[:, 0], side[:, 1])
    _, first, count = np.unique(key, return_index=True, return_counts=True)
    rim = side[first[count == 1]]
    inner = np.unique(key[first[count == 2]])
    own = np.sort(region.edges, axis=1)
    own_key = own[:, 0] * n + own[:, 1]
    imprint = region.edges[np.isin(own_key, inner)]
    nodes_inside = np.unique(side)
    kept = np.unique(np.concatenate([rim.ravel(), imprint.ravel(), nodes_inside[nodes_inside < n_point]]))
    number = np.full(n, -1, np.int64)
    number[kept] = np.arange(len(kept))
    edges = number[np.concatenate([rim, imprint])]
    is_boundary = np.arange(len(edges)) < len(rim)
    patch = Region(mesh.points[kept], edges, is_boundary, np.zeros(len(edges), np.bool_))
    length = np.hypot(*(mesh.points[rim[:, 1]] - mesh.points[rim[:, 0]]).T)
    new = mixed_mesh(patch, min(size, float(np.median(length))), growth)
    return kept, new.points, new.quads, new.triangles
