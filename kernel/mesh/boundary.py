"""The boundary of a tetrahedral mesh, and which face of the solid every piece of it belongs to."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.elements import ELEMENT_KINDS
from kernel.solid.facets import Facets

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SAMPLES_PER_SIZE = 3.0
"""Sample points on the facets stand this often per element edge: the nearest ones name candidate facets."""

CANDIDATES = 12
"""Nearest samples whose facets are looked at closely."""

FACING = 0.3
"""Least cosine between the normals of a boundary triangle and of a facet that it may belong to."""


def boundary_triangles(tets: Indices) -> Indices:
    """(m, 3) faces that only one tet has, counter-clockwise from outside, in the order of the tets."""
    faces = tets[:, np.array(ELEMENT_KINDS["tet4"].faces)].reshape(-1, 3)
    _, first, count = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
    return faces[np.sort(first[count == 1])]


def nearest_facets(facets: Facets, points: Array, normals: Array, size: float) -> tuple[Indices, Array]:
    """For every point (n, 3) with a normal (n, 3): the nearest facet that faces alike, and its nearest place (n, 3)."""
    from scipy.spatial import cKDTree

    samples, owner = _samples(facets, size / SAMPLES_PER_SIZE)
    _, rows = cKDTree(samples).query(points, k=min(CANDIDATES, len(samples)))
    candidates = owner[np.asarray(rows).reshape(len(points), -1)]
    best = np.full(len(points), np.inf)
    found = candidates[:, 0].copy()
    places = points.copy()
    for column in candidates.T:
        place = closest_on_triangles(facets.vertices[facets.triangles[column]], points)
        score = np.linalg.norm(place - points, axis=1)
        score += np.where(np.einsum("ij,ij->i", facets.normals[column], normals) > FACING, 0.0, 1e3 * size)
        better = score < best
        best[better], found[better], places[better] = score[better], column[better], place[better]
    return found, places


def _samples(facets: Facets, spacing: float) -> tuple[Array, Indices]:
    """Points spread over the facets, at most `spacing` apart, and the facet of each."""
    corners = facets.vertices[facets.triangles]
    longest = np.max([np.linalg.norm(corners[:, k] - corners[:, k - 1], axis=1) for k in range(3)], axis=0)
    height = 2.0 * facets.areas / np.where(longest > 0.0, longest, 1.0)
    points, owner = [], []
    along = np.clip(np.ceil(longest / spacing), 1, 400).astype(np.int64)
    across = np.clip(np.ceil(height / spacing), 1, 400).astype(np.int64)
    for n, m in sorted(set(zip(along.tolist(), across.tolist()))):
        rows = np.flatnonzero((along == n) & (across == m))
        grid = _barycentric(n, m)
        turned = _longest_first(corners[rows])
        points.append(np.einsum("kb,mbd->mkd", grid, turned).reshape(-1, 3))
        owner.append(np.repeat(rows, len(grid)))
    return np.concatenate(points), np.concatenate(owner)


def _longest_first(corners: Array) -> Array:
    """Corners (m, 3, 3) turned so that the longest side runs from corner 0 to corner 1."""
    sides = np.stack([np.linalg.norm(corners[:, (k + 1) % 3] - corners[:, k], axis=1) for k in range(3)], axis=1)
    turn = (np.argmax(sides, axis=1)[:, None] + np.arange(3)) % 3
    return np.take_along_axis(corners, turn[:, :, None], axis=1)


def _barycentric(along: int, across: int) -> Array:
    """Points of a triangle: `along` steps on the side 0 1, `across` rows towards corner 2, middles of the steps."""
    rows = (np.arange(across) + 0.5) / across
    steps = (np.arange(along) + 0.5) / along
    high, share = (grid.ravel() for grid in np.meshgrid(rows, steps, indexing="ij"))
    return np.stack([(1.0 - high) * (1.0 - share), (1.0 - high) * share, high], axis=1)


def closest_on_triangles(corners: Array, points: Array) -> Array:
    """(n, 3) nearest place of each triangle (n, 3, 3) to its point (n, 3); Ericson 2005, section 5.1.5."""
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    best = _closest_on_segments(a, b, points)
    least = np.linalg.norm(best - points, axis=1)
    for start, end in ((b, c), (c, a)):
        place = _closest_on_segments(start, end, points)
        distance = np.linalg.norm(place - points, axis=1)
        nearer = distance < least
        best[nearer], least[nearer] = place[nearer], distance[nearer]
    normal = np.cross(b - a, c - a)
    square = np.einsum("ij,ij->i", normal, normal)
    safe = np.where(square > 0.0, square, 1.0)
    foot = points - (np.einsum("ij,ij->i", points - a, normal) / safe)[:, None] * normal
    inside = square > 0.0
    for start, end in ((a, b), (b, c), (c, a)):
        inside &= np.einsum("ij,ij->i", np.cross(end - start, foot - start), normal) >= 0.0
    best[inside] = foot[inside]
    return best


def _closest_on_segments(start: Array, end: Array, points: Array) -> Array:
    along = end - start
    square = np.einsum("ij,ij->i", along, along)
    share = np.einsum("ij,ij->i", points - start, along) / np.where(square > 0.0, square, 1.0)
    return start + np.clip(share, 0.0, 1.0)[:, None] * along
