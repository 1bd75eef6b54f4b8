"""The boundary representation: faces with their analytic surface and outside sense, and the edges between them.

A face is a connected set of triangles on one surface with one side out; an edge is a chain of triangle edges between
the same two faces. Both are numbered by what they are (surface, place), not by the order of triangles.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.solid.facets import Facets
from kernel.solid.slivers import true_areas
from kernel.solid.solid import Solid
from kernel.solid.surfaces import FacetedSurface, Plane, SphereSurface, Surface, outward
from kernel.solid.table import CLEAN, SurfaceTable


@dataclass(frozen=True, slots=True, eq=False)
class BrepFace:
    """side: +1 where the outside is where the surface's own normal points (away from axis or centre), -1 where the
    material is there, 0 on a faceted surface. area: of the true surface within true edges
    (where those are straight or circles). triangles: (n,) into the facets.
    """

    id: int
    surface_id: int
    surface: Surface
    side: int
    area: float
    centroid: NDArray[np.float64]
    triangles: NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class BrepEdge:
    """A chain of vertices between two faces, walked with faces[0] on its left as seen from outside.

    vertices: (n,) into the facets' vertices, the first not repeated at the end of a closed chain. turn: mean angle
    from one face's outward normal to the other's, in radians; positive where the edge is convex.
    """

    id: int
    faces: tuple[int, int]
    vertices: NDArray[np.int64]
    is_closed: bool
    length: float
    turn: float


@dataclass(frozen=True, slots=True, eq=False)
class Brep:
    """face_of: (m,) the face of every triangle."""

    facets: Facets
    faces: tuple[BrepFace, ...]
    edges: tuple[BrepEdge, ...]
    face_of: NDArray[np.int64]


def brep_of(solid: Solid) -> Brep:
    """Faces and edges of the solid's boundary."""
    facets, table = solid.facets, solid.surfaces
    face_of = face_labels(facets, table)
    faces = _faces(facets, table, face_of)
    return Brep(facets, faces, _edges(facets, face_of), face_of)


def outside_sense(facets: Facets, table: SurfaceTable) -> NDArray[np.int64]:
    """(m,) +1 where a triangle faces along its surface's own normal, -1 against it, 0 where that has none."""
    sense = np.zeros(len(facets.triangles), np.int64)
    for number in np.unique(facets.surface):
        surface = table.surfaces[number]
        if not isinstance(surface, FacetedSurface):
            rows = facets.surface == number
            along = np.einsum("ij,ij->i", outward(surface, facets.centroids[rows]), facets.normals[rows])
            sense[rows] = np.where(along > 0.0, 1, -1)
    return sense


def face_labels(facets: Facets, table: SurfaceTable) -> NDArray[np.int64]:
    """(m,) face number of every triangle: by surface id, then by side, then by the faces' centroids."""
    sense = outside_sense(facets, table)
    neighbours = facets.neighbours
    joined = (neighbours >= 0) & (facets.surface[neighbours] == facets.surface[:, None])
    joined &= sense[neighbours] == sense[:, None]
    label = connected_labels(neighbours, joined)
    number = np.unique(label)
    weight = np.bincount(label, facets.areas)[number]
    weight = np.where(weight > 0.0, weight, 1.0)
    centre = np.stack(
        [np.bincount(label, facets.areas * facets.centroids[:, k])[number] / weight for k in range(3)], axis=1
    )
    grid = 1e-6 * float(np.ptp(facets.vertices, axis=0).max()) if len(number) else 1.0
    keys = np.round(centre / grid)
    order = np.lexsort((weight, keys[:, 2], keys[:, 1], keys[:, 0], sense[number], facets.surface[number]))
    rank = np.full(len(label) + 1, -1, np.int64)
    rank[number[order]] = np.arange(len(order))
    return rank[label]


def connected_labels(neighbours: NDArray[np.int64], joined: NDArray[np.bool_]) -> NDArray[np.int64]:
    """(m,) lowest index in each connected set; neighbours, joined: (m, k) whom a row touches, and whether it counts."""
    label = np.arange(len(neighbours))
    row, column = np.nonzero(joined)
    other = neighbours[row, column]
    while len(row):
        lowest = np.minimum(label[row], label[other])
        before = label.copy()
        np.minimum.at(label, label[row], lowest)
        np.minimum.at(label, row, lowest)
        label = label[label]
        if (label == before).all():
            break
    return label


def _faces(facets: Facets, table: SurfaceTable, face_of: NDArray[np.int64]) -> tuple[BrepFace, ...]:
    areas = true_areas(facets, table) + arc_areas(facets, table)
    sense = outside_sense(facets, table)
    order = np.argsort(face_of, kind="stable")
    faces = []
    for number, rows in enumerate(np.split(order, np.nonzero(np.diff(face_of[order]))[0] + 1)):
        weight = facets.areas[rows]
        centroid = (weight @ facets.centroids[rows]) / max(float(weight.sum()), np.finfo(float).tiny)
        surface_id = int(facets.surface[rows[0]])
        faces.append(
            BrepFace(
                number,
                surface_id,
                table.surfaces[surface_id],
                int(sense[rows[0]]),
                float(areas[rows].sum()),
                centroid,
                rows,
            )
        )
    return tuple(faces)


def arc_areas(facets: Facets, table: SurfaceTable) -> NDArray[np.float64]:
    """(m,) area between a flat triangle's sides and the circles that they are chords of, positive outside the sides.

    A side is such a chord where the surface across it turns about an axis square to the plane (or is a sphere).
    """
    gained = np.zeros(len(facets.triangles))
    is_flat = np.array([isinstance(surface, Plane) for surface in table.surfaces], bool)[facets.surface]
    across = facets.surface[facets.neighbours]
    rows, corners = np.nonzero(is_flat[:, None] & (across != facets.surface[:, None]))
    for number in np.unique(across[rows, corners]):
        surface = table.surfaces[number]
        if isinstance(surface, Plane | FacetedSurface):
            continue
        own = across[rows, corners] == number
        row, corner = rows[own], corners[own]
        a = facets.vertices[facets.triangles[row, corner]]
        b = facets.vertices[facets.triangles[row, (corner + 1) % 3]]
        normal = facets.normals[row]
        if isinstance(surface, SphereSurface):
            arm_a, arm_b = a - surface.centre, b - surface.centre
            square = np.ones(len(row), bool)
        else:
            arm_a, arm_b = a - surface.axis.point, b - surface.axis.point
            square = np.abs(normal @ surface.axis.direction) > 1.0 - CLEAN
        arm_a = arm_a - np.einsum("ij,ij->i", arm_a, normal)[:, None] * normal
        arm_b = arm_b - np.einsum("ij,ij->i", arm_b, normal)[:, None] * normal
        sine = np.einsum("ij,ij->i", np.cross(arm_a, arm_b), normal)
        cosine = np.einsum("ij,ij->i", arm_a, arm_b)
        segment = 0.5 * np.hypot(sine, cosine) * np.arctan2(sine, cosine) - 0.5 * sine
        np.add.at(gained, row[square], segment[square])
    return gained


def _edges(facets: Facets, face_of: NDArray[np.int64]) -> tuple[BrepEdge, ...]:
    neighbours, triangles = facets.neighbours, facets.triangles
    row, corner = np.nonzero(face_of[neighbours] > face_of[:, None])
    left, right = face_of[row], face_of[neighbours[row, corner]]
    start, end = triangles[row, corner], triangles[row, (corner + 1) % 3]
    turn = _turns(facets, row, neighbours[row, corner])
    length = np.linalg.norm(facets.vertices[end] - facets.vertices[start], axis=1)
    order = np.lexsort((start, right, left))
    pair = left[order] * (len(facets.triangles) + 1) + right[order]
    edges: list[BrepEdge] = []
    for rows in np.split(order, np.nonzero(np.diff(pair))[0] + 1) if len(order) else []:
        for chain, is_closed in _chains(start[rows], end[rows]):
            own = rows[chain]
            vertices = start[own] if is_closed else np.append(start[own], end[own[-1]])
            total = float(length[own].sum())
            bend = float(turn[own] @ length[own]) / total if total > 0.0 else 0.0
            faces = (int(left[own[0]]), int(right[own[0]]))
            edges.append(BrepEdge(len(edges), faces, vertices, is_closed, total, bend))
    return tuple(edges)


def _turns(facets: Facets, one: NDArray[np.int64], other: NDArray[np.int64]) -> NDArray[np.float64]:
    """(k,) angle between the outward normals of two neighbouring triangles, positive where their edge is convex."""
    a, b = facets.normals[one], facets.normals[other]
    angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("ij,ij->i", a, b))
    ahead = np.einsum("ij,ij->i", facets.centroids[other] - facets.centroids[one], a)
    return np.where(ahead > 0.0, -angle, angle)


def _chains(start: NDArray[np.int64], end: NDArray[np.int64]) -> list[tuple[NDArray[np.int64], bool]]:
    """Directed pieces joined end to start: (rows, is_closed). Chains part where several pieces leave a vertex."""
    leaving: dict[int, list[int]] = {}
    arriving: dict[int, int] = {}
    for row, (a, b) in enumerate(zip(start.tolist(), end.tolist())):
        leaving.setdefault(a, []).append(row)
        arriving[b] = arriving.get(b, 0) + 1
    plain = {vertex for vertex, rows in leaving.items() if len(rows) == 1 and arriving.get(vertex, 0) == 1}
    free = np.ones(len(start), bool)
    chains = []
    firsts = [row for row, vertex in enumerate(start.tolist()) if vertex not in plain]
    for first in [*firsts, *range(len(start))]:
        if not free[first]:
            continue
        chain, here = [], first
        while free[here]:
            free[here] = False
            chain.append(here)
            vertex = int(end[here])
            if vertex not in plain:
                break
            here = leaving[vertex][0]
        is_closed = end[chain[-1]] == start[chain[0]]
        chains.append((np.array(chain, np.int64), bool(is_closed)))
    return chains
