"""Put the boundary of a tetrahedral mesh exactly on the solid's faces, edges and corners.

The mesher keeps its surface only within an envelope of the facets. Every boundary triangle is given the face of the
solid that it lies along. Nodes between triangles of one face move onto that face's surface, nodes between two faces
onto the curve where the surfaces meet, nodes between more onto the corner. A move that would flatten a tet is taken
back part by part, and the number of nodes that stay off their surface is told.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.boundary import boundary_triangles, nearest_facets
from kernel.mesh.collapse import without_short_edges
from kernel.mesh.tets import tet_shapes
from kernel.solid.brep import Brep, brep_of
from kernel.solid.solid import Solid
from kernel.solid.surfaces import FacetedSurface, Surface, outward, signed_distance

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

REACH = 3.0
"""A node moves at most this many envelopes, and at most REACH_OF_EDGE of its shortest boundary edge where it can be put
on all of its faces, or on one, that way."""

REACH_OF_EDGE = 0.45

LEAST_SHAPE = 0.1
"""A tet's shape (1 for the regular one) may sink to this share of what it was, or to LEAST_SHAPE, not further."""

ROUNDS = 3
"""Times that short boundary edges are drawn together where nodes stay beside their surface."""

SHARES = (1.0, 0.75, 0.5, 0.25, 0.0)
"""Shares of a move that are tried in turn."""

ON_SURFACE = 1e-9
"""A node nearer to its surface than this share of the size is on it."""


@dataclass(frozen=True, slots=True, eq=False)
class FittedTets:
    """nodes (n, 3) and tets (k, 4); edges (e, 2): boundary edges as sorted node pairs, middles (e, 3) their mid-side
    nodes on the true surfaces. left: number of boundary nodes that stand on no surface of their faces, or not as
    near to where they belong as they should.
    face_areas: area of the boundary triangles on each face of the solid.
    """

    nodes: Array
    tets: Indices
    edges: Indices
    middles: Array
    left: int
    face_areas: Array


def fit(solid: Solid, nodes: Array, tets: Indices, envelope: float) -> FittedTets:
    """Boundary nodes onto the solid's true surfaces; envelope: how far from the facets the boundary may be."""
    brep = brep_of(solid)
    fitted, left = _fit(brep, solid.size, nodes, tets, envelope)
    for _ in range(ROUNDS):
        if not len(left):
            break
        fewer, kept = without_short_edges(nodes, tets, left, REACH * envelope, LEAST_SHAPE)
        if len(kept) == len(tets):
            break
        nodes, tets = fewer, kept
        again, still = _fit(brep, solid.size, nodes, tets, envelope)
        if len(still) >= len(left):
            break
        fitted, left = again, still
    return fitted


def _fit(brep: Brep, size: float, nodes: Array, tets: Indices, envelope: float) -> tuple[FittedTets, Indices]:
    """The mesh with its boundary moved, and the nodes that are left beside their surfaces."""
    triangles = boundary_triangles(tets)
    labels = _labels(brep, nodes, triangles)
    targets = _targets(brep, size, nodes, triangles, labels, envelope)
    fitted, held = _moved(nodes, tets, targets, ON_SURFACE * size)
    left = np.union1d(held, _astray(brep, size, targets, triangles, labels))
    edges, middles = _middles(brep, size, fitted, triangles, labels)
    areas = np.bincount(labels, _areas(fitted, triangles), minlength=len(brep.faces)).astype(np.float64)
    return FittedTets(fitted, tets, edges, middles, len(left), areas), left


def _areas(nodes: Array, triangles: Indices) -> Array:
    a, b, c = (nodes[triangles[:, k]] for k in range(3))
    areas: Array = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return areas


def _labels(brep: Brep, nodes: Array, triangles: Indices) -> Indices:
    """(m,) the solid's face that each boundary triangle lies along."""
    corners = nodes[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1)
    normal /= np.where(length > 0.0, length, 1.0)[:, None]
    size = float(np.mean(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1)))
    facet, _ = nearest_facets(brep.facets, corners.mean(axis=1), normal, size)
    return brep.face_of[facet]


def _faces_at(keys: Indices, labels: Indices) -> tuple[Indices, list[tuple[int, ...]]]:
    """Unique keys, and the sorted labels that occur with each."""
    pairs = np.unique(np.stack([keys, labels], axis=1), axis=0)
    unique, start = np.unique(pairs[:, 0], return_index=True)
    return unique, [tuple(group.tolist()) for group in np.split(pairs[:, 1], start[1:])]


def _by_faces(faces: list[tuple[int, ...]]) -> list[tuple[tuple[int, ...], list[int]]]:
    """The sets of faces that occur, in their order, each with the rows where it does."""
    found: dict[tuple[int, ...], list[int]] = {}
    for row, group in enumerate(faces):
        found.setdefault(group, []).append(row)
    return sorted(found.items())


def _targets(
    brep: Brep, size: float, nodes: Array, triangles: Indices, labels: Indices, envelope: float
) -> dict[int, Array]:
    """Where each boundary node belongs: node -> place."""
    unique, faces = _faces_at(triangles.ravel(), np.repeat(labels, 3))
    places = nodes[unique].copy()
    shortest = _shortest_edges(nodes, triangles)[unique]
    limit = np.minimum(REACH * envelope, REACH_OF_EDGE * shortest)
    for group, rows in _by_faces(faces):
        near = _settle(brep, size, nodes[unique[rows]], group, limit[rows])
        # beside a very short edge a way of an envelope is not short: the shape of the tets alone bounds it
        off = ~_stand_on(brep, size, near, group)
        near[off] = _settle(brep, size, near[off], group, np.full(int(off.sum()), REACH * envelope))
        places[rows] = near
    _take_corners(brep, nodes, unique, faces, places, limit)
    return dict(zip(unique.tolist(), places))


def _astray(brep: Brep, size: float, targets: dict[int, Array], triangles: Indices, labels: Indices) -> Indices:
    """The boundary nodes that have no place on any of their faces' surfaces."""
    unique, faces = _faces_at(triangles.ravel(), np.repeat(labels, 3))
    astray = [np.empty(0, np.int64)]
    for group, rows in _by_faces(faces):
        places = np.array([targets[node] for node in unique[rows].tolist()])
        astray.append(unique[rows][~_stand_on(brep, size, places, group)])
    return np.concatenate(astray)


def _settle(brep: Brep, size: float, points: Array, faces: tuple[int, ...], limit: Array) -> Array:
    """Points onto all of the faces' surfaces, or where that is too far or has no solution, onto the first that is near.

    limit (n,): how far each may move. Faces on one surface count once.
    """
    surfaces = {brep.faces[face].surface_id: brep.faces[face].surface for face in faces}
    wanted = [surfaces[number] for number in sorted(surfaces)]
    result = points.copy()
    open_rows = np.arange(len(points))
    choices = [wanted] if len(wanted) == 1 else [wanted, *([surface] for surface in wanted)]
    for choice in choices:
        place, is_on = onto(choice, points[open_rows], size, brep)
        good = is_on & (np.linalg.norm(place - points[open_rows], axis=1) <= limit[open_rows])
        result[open_rows[good]] = place[good]
        open_rows = open_rows[~good]
        if not len(open_rows):
            break
    return result


def onto(
    surfaces: list[Surface], points: Array, size: float, brep: Brep | None = None
) -> tuple[Array, NDArray[np.bool_]]:
    """Points moved onto all of the surfaces at once by Newton's method with least moves; and which of them got there.

    Faceted surfaces have no form: points count as on them where they are.
    """
    analytic = [surface for surface in surfaces if not isinstance(surface, FacetedSurface)]
    place = points.copy()
    if not analytic or not len(points):
        return place, np.ones(len(points), bool)
    for _ in range(12):
        distance = np.stack([signed_distance(surface, place) for surface in analytic], axis=1)
        if np.abs(distance).max() < 1e-3 * ON_SURFACE * size:
            break
        slope = np.stack([outward(surface, place) for surface in analytic], axis=1)
        place = place - np.einsum("nij,nj->ni", np.linalg.pinv(slope, rcond=1e-3), distance)
    distance = np.stack([signed_distance(surface, place) for surface in analytic], axis=1)
    return place, np.asarray(np.abs(distance).max(axis=1) < ON_SURFACE * size)


def _stand_on(brep: Brep, size: float, points: Array, faces: tuple[int, ...]) -> NDArray[np.bool_]:
    """(n,) which points stand on the surface of one of the faces; on a faceted one they count as standing."""
    on = np.zeros(len(points), bool)
    for face in faces:
        surface = brep.faces[face].surface
        on |= isinstance(surface, FacetedSurface) or np.abs(signed_distance(surface, points)) < 10.0 * ON_SURFACE * size
    return on


def _take_corners(
    brep: Brep, nodes: Array, unique: Indices, faces: list[tuple[int, ...]], places: Array, limit: Array
) -> None:
    """Every corner of the solid gets the nearest boundary node of its faces, if one is within reach; in place."""
    vertices, corner_faces = _faces_at(brep.facets.triangles.ravel(), np.repeat(brep.face_of, 3))
    is_corner = np.array([len(group) > 2 for group in corner_faces], bool)
    sets = [set(group) for group in faces]
    taken: set[int] = set()
    for vertex, group in zip(vertices[is_corner], (g for g in corner_faces if len(g) > 2)):
        corner = brep.facets.vertices[vertex]
        distance = np.linalg.norm(nodes[unique] - corner, axis=1)
        for row in np.argsort(distance, kind="stable")[:8]:
            if distance[row] > limit[row]:
                break
            if int(row) not in taken and len(sets[row] & set(group)) >= 2:
                places[row] = corner
                taken.add(int(row))
                break


def _shortest_edges(nodes: Array, triangles: Indices) -> Array:
    """(n_node,) shortest boundary edge at each node; infinite inside."""
    shortest = np.full(len(nodes), np.inf)
    for k in range(3):
        a, b = triangles[:, k], triangles[:, (k + 1) % 3]
        length = np.linalg.norm(nodes[a] - nodes[b], axis=1)
        np.minimum.at(shortest, a, length)
        np.minimum.at(shortest, b, length)
    return shortest


def _moved(nodes: Array, tets: Indices, targets: dict[int, Array], near: float) -> tuple[Array, Indices]:
    """Nodes at their targets as far as the tets allow, and those that are not there."""
    rows = np.fromiter(targets.keys(), np.int64, len(targets))
    move = np.array(list(targets.values())).reshape(-1, 3) - nodes[rows]
    before = tet_shapes(nodes, tets)
    floor = np.minimum(before, np.maximum(LEAST_SHAPE, LEAST_SHAPE * before))
    level = np.zeros(len(nodes), np.int64)
    shares = np.array(SHARES)
    for _ in range(4 * len(SHARES)):
        now = nodes.copy()
        now[rows] += shares[level[rows]][:, None] * move
        bad = tet_shapes(now, tets) < floor * (1.0 - 1e-9)
        if not bad.any():
            break
        again = np.unique(tets[bad])
        level[again] = np.minimum(level[again] + 1, len(SHARES) - 1)
    else:
        now = nodes.copy()
    held = (level[rows] > 0) & (np.linalg.norm(move, axis=1) > near)
    return now, rows[held]


def _middles(brep: Brep, size: float, nodes: Array, triangles: Indices, labels: Indices) -> tuple[Indices, Array]:
    """Boundary edges (e, 2) and where their mid-side nodes stand on the true surfaces."""
    pairs = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    keys, faces = _faces_at(pairs[:, 0] * len(nodes) + pairs[:, 1], np.repeat(labels, 3))
    edges = np.stack([keys // len(nodes), keys % len(nodes)], axis=1)
    straight = 0.5 * (nodes[edges[:, 0]] + nodes[edges[:, 1]])
    middles = straight.copy()
    length = np.linalg.norm(nodes[edges[:, 1]] - nodes[edges[:, 0]], axis=1)
    for group, rows in _by_faces(faces):
        surfaces = [brep.faces[face].surface for face in group]
        ends_on = np.ones(len(rows), bool)
        for surface in surfaces:
            if not isinstance(surface, FacetedSurface):
                for side in (0, 1):
                    ends_on &= np.abs(signed_distance(surface, nodes[edges[rows, side]])) < 10.0 * ON_SURFACE * size
        # an edge whose ends are off the surface (a move held back) stays straight
        middles[rows] = np.where(
            ends_on[:, None], _settle(brep, size, straight[rows], group, 0.3 * length[rows]), straight[rows]
        )
    return edges, middles
