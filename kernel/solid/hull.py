"""Convex hull of solids: flat faces between them, and the members' own faces where the hull follows them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from kernel.solid.facets import edge_neighbours
from kernel.solid.flat import area_vectors
from kernel.solid.solid import Solid
from kernel.solid.surfaces import ConeSurface, CylinderSurface, SphereSurface, Surface, outward, signed_distance
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import NotSolidError, tracked_manifold

_FLUSH = 1e-9
"""Triangles whose planes differ by less than this share of the size are one flat face."""

_FACET_TURN = 0.08
"""Sine of the largest angle between a facet and its true surface: a step is 2 pi / 96 round, more across two steps."""


def hull_manifold(members: Sequence[Solid], table: SurfaceTable, source: int) -> Manifold:
    """The tracked hull. NotSolidError: the members are empty or lie in one plane."""
    solids = [solid for solid in members if not solid.is_empty]
    if not solids:
        raise NotSolidError("its members are empty")
    points = np.concatenate([solid.facets.vertices for solid in solids])
    mesh = Manifold.hull_points(np.unique(points, axis=0)).to_mesh64()
    vertices = np.asarray(mesh.vert_properties, np.float64)[:, :3]
    triangles = np.asarray(mesh.tri_verts, np.int64)
    if len(triangles) == 0:
        raise NotSolidError("its members lie in one plane")
    vertices, triangles = _in_fixed_order(vertices, triangles)
    curved = sorted({int(number) for solid in solids for number in np.unique(solid.facets.surface)})
    surface = _surfaces(vertices, triangles, curved, table)
    return tracked_manifold(table, vertices, triangles, surface, source)


def _in_fixed_order(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    order = np.lexsort(vertices.T[::-1])
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    turned = place[triangles]
    first = np.argmin(turned, axis=1)
    turned = np.take_along_axis(turned, (first[:, None] + np.arange(3)) % 3, axis=1)
    return vertices[order], turned[np.lexsort(turned.T[::-1])]


def _surfaces(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], candidates: list[int], table: SurfaceTable
) -> NDArray[np.int64]:
    """(m,) ids: a member's curved surface where a triangle's corners lie on it and it faces along it, else planes."""
    area = area_vectors(vertices, triangles)
    size = np.linalg.norm(area, axis=1)
    normal = area / np.where(size > 0.0, size, 1.0)[:, None]
    centroid = vertices[triangles].mean(axis=1)
    surface = np.full(len(triangles), -1, np.int64)
    for number in candidates:
        value = table.surfaces[number]
        if not isinstance(value, CylinderSurface | ConeSurface | SphereSurface):
            continue
        on = np.abs(signed_distance(value, vertices)) < _FLUSH * table.size
        rows = np.nonzero(on[triangles].all(axis=1) & (surface < 0))[0]
        if len(rows):
            facing = np.einsum("ij,ij->i", normal[rows], outward(value, centroid[rows]))
            near = _spans_one_step(value, vertices, triangles[rows])
            surface[rows[(facing > 1.0 - _FACET_TURN) & near]] = number
    flat = np.nonzero(surface < 0)[0]
    for rows in _flush_groups(vertices, triangles, normal, flat, table.size):
        surface[rows] = table.plane(area[rows].sum(axis=0), 0.0, through=vertices[np.unique(triangles[rows])])
    return surface


def _spans_one_step(value: Surface, vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.bool_]:
    """(k,) True where the surface's normal turns by at most two facet steps within the triangle."""
    normals = outward(value, vertices[triangles.ravel()]).reshape(-1, 3, 3)
    cosine = np.einsum("mid,mid->mi", normals, np.roll(normals, 1, axis=1)).min(axis=1)
    return cosine > np.cos(2.0 * 2.0 * np.pi / 96.0)


def _flush_groups(
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    normal: NDArray[np.float64],
    rows: NDArray[np.int64],
    size: float,
) -> list[NDArray[np.int64]]:
    """Triangles `rows` in groups that lie in one plane, each grown from its largest triangle; in a fixed order."""
    neighbours = edge_neighbours(triangles, len(vertices))
    free = np.zeros(len(triangles), bool)
    free[rows] = True
    size_of = np.linalg.norm(area_vectors(vertices, triangles), axis=1)
    groups = []
    for seed in rows[np.lexsort((rows, -size_of[rows]))]:
        if not free[seed]:
            continue
        offset = float(normal[seed] @ vertices[triangles[seed, 0]])
        found, queue = [], [int(seed)]
        free[seed] = False
        while queue:
            here = queue.pop()
            found.append(here)
            for other in neighbours[here]:
                if free[other] and np.abs(vertices[triangles[other]] @ normal[seed] - offset).max() < _FLUSH * size:
                    free[other] = False
                    queue.append(int(other))
        groups.append(np.sort(np.array(found)))
    return groups
