"""Convex hull of solids: flat faces between them, and the members' own faces where the hull follows them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from kernel.solid.facets import edge_neighbours
from kernel.solid.flat import area_vectors
from kernel.solid.solid import Solid
from kernel.solid.surfaces import (
    Axis,
    ConeSurface,
    CylinderSurface,
    SphereSurface,
    Surface,
    Vector,
    outward,
    plane_frame,
    signed_distance,
)
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import NotSolidError, tracked_manifold

Curved = CylinderSurface | ConeSurface | SphereSurface

MAX_BALLS = 32
"""Cylinders are looked for between the pairs of this many balls."""

_FLUSH = 1e-9
"""Triangles whose planes differ by less than this share of the size are one flat face."""

_NO_AREA = 1e-14
"""A triangle with less than this share of the size's square has no area, and no normal to tell its plane by."""

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
    surface = np.full(len(triangles), -1, np.int64)
    for number in candidates:
        value = table.surfaces[number]
        if not isinstance(value, CylinderSurface | ConeSurface | SphereSurface):
            continue
        rows = _along(value, vertices, triangles, normal, np.nonzero(surface < 0)[0], table.size)
        surface[rows] = number
    for bridge, register in _bridges([table.surfaces[number] for number in candidates], table):
        rows = _along(bridge, vertices, triangles, normal, np.nonzero(surface < 0)[0], table.size)
        if len(rows):
            surface[rows] = register()
    flat = np.nonzero((surface < 0) & (size > _NO_AREA * table.size**2))[0]
    for rows in _flush_groups(vertices, triangles, normal, flat, table.size):
        surface[rows] = table.plane(area[rows].sum(axis=0), 0.0, through=vertices[np.unique(triangles[rows])])
    return _with_neighbours(vertices, triangles, surface)


def _with_neighbours(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], surface: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Triangles without area (three corners on one straight edge) take the surface across their longest side."""
    neighbours = edge_neighbours(triangles, len(vertices))
    corners = vertices[triangles]
    length = np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2)
    across = np.take_along_axis(neighbours, np.argsort(-length, axis=1, kind="stable"), axis=1)
    for _ in range(3 * len(triangles)):
        open_rows = np.flatnonzero(surface < 0)
        if not len(open_rows):
            return surface
        for column in across[open_rows].T:
            known = (surface[open_rows] < 0) & (surface[column] >= 0)
            surface[open_rows[known]] = surface[column[known]]
    raise NotSolidError("its surface has no area")


def _along(
    value: Curved,
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    normal: NDArray[np.float64],
    rows: NDArray[np.int64],
    size: float,
) -> NDArray[np.int64]:
    """Those of the triangles `rows` that are facets of the curved surface: corners on it, facing along it."""
    on = np.abs(signed_distance(value, vertices)) < _FLUSH * size
    rows = rows[on[triangles[rows]].all(axis=1)]
    if not len(rows):
        return rows
    facing = np.einsum("ij,ij->i", normal[rows], outward(value, vertices[triangles[rows]].mean(axis=1)))
    return rows[(facing > 1.0 - _FACET_TURN) & _spans_one_step(value, vertices, triangles[rows], normal[rows], size)]


def _bridges(surfaces: list[Surface], table: SurfaceTable) -> list[tuple[CylinderSurface, Callable[[], int]]]:
    """The cylinders that a hull spans between balls of one radius, and for each the call that registers it."""
    balls = [surface for surface in surfaces if isinstance(surface, SphereSurface)][:MAX_BALLS]
    bridges: list[tuple[CylinderSurface, Callable[[], int]]] = []
    for one, other in combinations(balls, 2):
        along = other.centre - one.centre
        length = float(np.linalg.norm(along))
        if length <= table.tolerance or abs(one.radius - other.radius) > _FLUSH * table.size:
            continue
        frame = plane_frame(along / length)
        axis = Axis(one.centre, frame.normal, frame.u, frame.v)

        def register(point: Vector = one.centre, along: Vector = along, radius: float = one.radius) -> int:
            return table.cylinder(table.axis(point, along), radius)

        bridges.append((CylinderSurface(axis, -1, one.radius), register))
    return bridges


def _spans_one_step(
    value: Curved,
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    normal: NDArray[np.float64],
    size: float,
) -> NDArray[np.bool_]:
    """(k,) True where the surface's normal turns by at most two facet steps within the triangle."""
    corners = vertices[triangles.ravel()]
    normals = outward(value, corners)
    if isinstance(value, ConeSurface):  # no normal at the tip: the facet's own
        at_tip = np.linalg.norm(corners - value.apex, axis=1) < _FLUSH * size
        normals[at_tip] = np.repeat(normal, 3, axis=0)[at_tip]
    normals = normals.reshape(-1, 3, 3)
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
