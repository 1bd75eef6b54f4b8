"""The thinnest wall of a body, by rays from all over its surface straight into it.

    +--.-----.-----.-----.--+     A facet may be as large as a side of the body: what stands opposite a part of it
    |        +-----+        |     is not met by a ray from its middle. Large facets are halved across their longest
    +--------+     +--------+     edge, the longest first, until they are of one size; every part sends a ray.

There is one ray for each facet, and a bounded number more.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kernel.solid.solid import Solid

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

OPPOSITE = math.cos(math.radians(20.0))
"""Faces whose normals point apart within this angle are two sides of a wall, not of an edge."""

PARALLEL = 1.0 - 1e-6
"""Faces whose normals have this cosine, or one nearer to -1, do not run together."""

HAIR = 1e-7
"""Rays start this share of the body's size within it, and hits nearer than twice that are of the face they leave."""

SLIVER = 1e-7
"""Facets of less than this share of the body's surface tell nothing of its walls."""

MOST_RAYS = 16000
"""Rays beside one for each facet: 0.3 s; they stand some fiftieth of the body's size apart, or nearer."""

MEETING = 0.99
"""Two faces that run together meet where the body reaches this share of the way to the line of both planes."""


def thinnest_wall(solid: Solid, along: Array | None = None) -> tuple[float, Array]:
    """(thickness, a point (3,) amid it) of the thinnest place between two faces that look away from each other.

    Infinite where there are none (a cone). Walls narrower than the distance of the rays may be missed: see MOST_RAYS.
    A wedge that runs out to an edge has no thinnest place: there only the middles of the facets count.
    along: a direction; walls across it do not count.
    """
    facets = solid.facets
    least, place = math.inf, facets.centroids[0]
    is_seen = facets.areas > SLIVER * solid.area
    if along is not None:
        is_seen &= np.abs(facets.normals @ along) < 0.5
    rows = np.flatnonzero(is_seen)
    parts, of_row = halved(facets.vertices[facets.triangles[rows]], MOST_RAYS)
    is_part = np.bincount(of_row, minlength=len(rows))[of_row] > 1
    parts, of_row = parts[is_part], of_row[is_part]
    starts = np.concatenate([facets.centroids[rows], parts.mean(axis=1)])
    for place_of, row in enumerate(np.concatenate([rows, rows[of_row]]).tolist()):
        normal, centre = facets.normals[row], starts[place_of]
        hit = _first_hit(solid, centre, -normal, min(least, solid.size) * 1.001)
        if hit is None:
            continue
        thickness, other = hit
        if float(other @ normal) >= -OPPOSITE or thickness >= least:
            continue
        middle = centre - 0.5 * thickness * normal
        if place_of < len(rows) or not _runs_out(solid, middle, thickness, normal, other):
            least, place = thickness, middle
    return least, place


def halved(triangles: Array, most: int) -> tuple[Array, Indices]:
    """Parts (m, 3, 3) of triangles (n, 3, 3), and the triangle (m,) of which each is one: at most n + `most`.

    Triangles are halved across their longest edge until all edges are shorter than a length, the shortest of the
    lengths L / 2^(k/2) for which the parts are not too many; L is the longest edge of all. Deterministic.
    """
    parts, of_row = triangles, np.arange(len(triangles))
    limit = float(_edges(parts).max(initial=0.0))
    if not limit:
        return parts, of_row
    while True:
        limit *= math.sqrt(0.5)
        finer, of_finer = parts, of_row
        while True:
            edges = _edges(finer)
            is_long = edges.max(axis=1) > limit
            if not is_long.any():
                break
            if len(finer) + np.count_nonzero(is_long) > len(triangles) + most:
                return parts, of_row
            # corners a, b of the longest edge, and c
            first = edges[is_long].argmax(axis=1)
            turned = finer[is_long][np.arange(len(first))[:, None], (first[:, None] + np.arange(3)) % 3]
            a, b, c = turned.transpose(1, 0, 2)
            middle = 0.5 * (a + b)
            finer = np.concatenate([finer[~is_long], np.stack([a, middle, c], 1), np.stack([middle, b, c], 1)])
            of_finer = np.concatenate([of_finer[~is_long], of_finer[is_long], of_finer[is_long]])
        parts, of_row = finer, of_finer


def _edges(triangles: Array) -> Array:
    """(n, 3) lengths of the edges from corner k to corner k + 1."""
    return np.linalg.norm(triangles[:, [1, 2, 0]] - triangles, axis=2)


def _first_hit(solid: Solid, start: Array, direction: Array, reach: float) -> tuple[float, Array] | None:
    """How far (from the start) a ray into the body comes, and the normal (3,) of the face that it meets there."""
    inside = start + HAIR * solid.size * direction
    for hit in solid.manifold.ray_cast(tuple(inside), tuple(inside + reach * direction)):
        distance = float((np.array(hit.position) - start) @ direction)
        if distance > 2 * HAIR * solid.size:
            return distance, np.array(hit.normal)
    return None


def _runs_out(solid: Solid, middle: Array, thickness: float, normal: Array, other: Array) -> bool:
    """Whether the two faces of a wall, of these normals, run together up to the edge in which they meet."""
    cosine = -float(normal @ other)
    if cosine >= PARALLEL:
        return False
    # half of the wall on each side of the plane that halves it; down its steepest line the two faces meet
    mean = normal - other
    mean /= np.linalg.norm(mean)
    down = normal + other
    down -= (down @ mean) * mean
    down /= np.linalg.norm(down)
    distance = thickness / math.sqrt(1.0 / cosine**2 - 1.0)
    hit = _first_hit(solid, middle, down, distance)
    return hit is None or hit[0] >= MEETING * distance
