"""Fins: sheets of no thickness that Booleans of skew bodies leave where two of their faces lie in one plane, or two of
their facets do on one curved surface.

Rounding puts one of the two faces a hair outside the other, and what is cut away leaves its side face standing, front
and back. Seen in the plane, front and back cancel: the face is what its outline encloses once both are summed.

        +-------+                              +-------+
        |  body |         outline of all       |  body |
        |       +----+    triangles in the  => |       |
        |       |fin |    plane, summed        |       |
        +-------+----+                         +-------+
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from manifold3d import Manifold, Mesh64, triangulate
from numpy.typing import NDArray

from kernel.pieces import connected_pieces
from kernel.solid.facets import Facets, edge_neighbours
from kernel.solid.solid import Solid
from kernel.solid.surfaces import Plane, PlaneFrame, Surface, plane_frame
from kernel.solid.tracked import NotSolidError, check_status

Indices = NDArray[np.int64]

ROUNDING = 0.01
"""Share of the surfaces' tolerance within which vertices are one, and lie on an edge."""

NO_VOLUME = 1e-9
"""Share of the solid's volume that its fins may have: a fold that has more is no fin."""

LEVEL = 1 - 1e-7
"""Facets of a curved surface lie in one plane when the cosine between their normals is more than this, or less than its
negative."""

MOST_ROUNDS = 12
"""Times that fins are looked for."""

MOST_PASSES = 50
"""Times that edges are divided: each pass divides every edge that needs it once."""


def without_fins(solid: Solid) -> Solid:
    """The solid less its fins; the very solid where it has none, or where none can be taken off cleanly."""
    for _ in range(MOST_ROUNDS):
        less = solid if solid.is_empty else _less_fins(solid)
        if less is solid:
            break
        solid = less
    return solid


def _less_fins(solid: Solid) -> Solid:
    """One round: vertices that rounding keeps apart become one only after it, so another may find more."""
    facets = solid.facets
    folded = _folded(solid)
    if not folded:
        return solid
    keep = np.ones(len(facets.triangles), dtype=bool)
    added: list[Indices] = []
    origin: list[Indices] = []
    for triangles, plane in folded:
        flat = _retriangulated(facets, triangles, plane)
        if flat is None:
            continue
        keep[triangles] = False
        added.append(flat)
        origin.append(np.full(len(flat), triangles[int(np.argmax(facets.areas[triangles]))]))
    if not added:
        return solid
    corners = np.concatenate([facets.triangles[keep], *added])
    rows = np.concatenate([np.flatnonzero(keep), *origin])
    fitted = _fitted(facets.vertices, corners, rows, ROUNDING * solid.surfaces.tolerance)
    rebuilt = None if fitted is None else _rebuilt(solid, *fitted)
    return rebuilt or solid


def _folded(solid: Solid) -> list[tuple[Indices, PlaneFrame]]:
    """Connected triangles of one plane that look both ways, with a frame of that plane.

    A curved surface is as many planes as it has facets.
    """
    facets, table = solid.facets, solid.surfaces
    found = []
    numbers, place = np.unique(facets.surface, return_inverse=True)
    surfaces = [table.surfaces[number] if 0 <= number < len(table.surfaces) else None for number in numbers.tolist()]
    is_two_sided = _two_sided(facets, surfaces, place)
    for rank, surface in enumerate(surfaces):
        if isinstance(surface, Plane) and not is_two_sided[rank]:
            continue
        own = np.flatnonzero(place == rank)
        if isinstance(surface, Plane):
            groups = _connected(facets.neighbours[own], own)
        elif surface is not None:
            groups = _level(facets, own)
        else:
            continue
        for group in groups:
            largest = facets.normals[group[int(np.argmax(facets.areas[group]))]]
            if not largest.any():
                continue  # facets without any area
            frame = plane_frame(surface.normal if isinstance(surface, Plane) else largest)
            side = facets.normals[group] @ frame.normal
            if (side > 0).any() and (side < 0).any():
                found.append((group, frame))
    return found


def _two_sided(facets: Facets, surfaces: Sequence[Surface | None], place: Indices) -> list[bool]:
    """Of each surface, whether it is a plane with triangles that look both ways. place: (m,) of each triangle's."""
    normals = np.array([surface.normal if isinstance(surface, Plane) else np.zeros(3) for surface in surfaces])
    side = np.einsum("ij,ij->i", facets.normals, normals.reshape(-1, 3)[place])
    up, down = (np.bincount(place, each, len(surfaces)) > 0 for each in (side > 0, side < 0))
    return [bool(each) for each in (up & down).tolist()]


def _level(facets: Facets, own: Indices) -> list[Indices]:
    """The triangles `own` of a curved surface in groups that share edges and lie in one plane; none without a fold."""
    across = facets.neighbours[own]
    is_own = np.zeros(len(facets.triangles) + 1, dtype=bool)
    is_own[own] = True
    turned = np.einsum("nkc,nc->nk", facets.normals[across], facets.normals[own])
    if not (is_own[across] & (across >= 0) & (turned < -LEVEL)).any():
        return []
    return _connected(np.where(np.abs(turned) > LEVEL, across, -1), own)


def _connected(neighbours: Indices, own: Indices) -> list[Indices]:
    """The triangles `own` in groups that share edges."""
    place = {triangle: index for index, triangle in enumerate(own.tolist())}
    pairs = [(index, place[other]) for index, row in enumerate(neighbours.tolist()) for other in row if other in place]
    rows, columns = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
    labels = connected_pieces(len(own), rows, columns)
    return [own[labels == label] for label in np.unique(labels)]


def _retriangulated(facets: Facets, triangles: Indices, plane: PlaneFrame) -> Indices | None:
    """Triangles (k, 3) within the outline of the sum of `triangles`; None where that outline does not close."""
    inside = np.zeros(len(facets.triangles), dtype=bool)
    inside[triangles] = True
    corners = facets.triangles[triangles]
    across = facets.neighbours[triangles]
    is_rim = ~inside[across] | (across < 0)
    starts, ends = corners[is_rim], corners[:, [1, 2, 0]][is_rim]
    if not len(starts):
        return np.empty((0, 3), np.int64)  # front and back of a sheet on its own
    loops = _chained(starts.tolist(), ends.tolist())
    if loops is None:
        return None
    net = float(facets.areas[triangles] @ np.sign(facets.normals[triangles] @ plane.normal))
    axes = np.stack([plane.u, plane.v] if net > 0 else [plane.v, plane.u], axis=1)
    numbers = np.concatenate([np.array(loop) for loop in loops])
    flat = triangulate([facets.vertices[loop] @ axes for loop in loops])
    return numbers[np.asarray(flat, dtype=np.int64)]


def _chained(starts: list[int], ends: list[int]) -> list[list[int]] | None:
    """Closed loops of the edges start -> end; None where one of them ends nowhere."""
    following: dict[int, list[int]] = {}
    for start, end in zip(starts, ends):
        following.setdefault(start, []).append(end)
    loops = []
    for start in starts:
        while following.get(start):
            loop = [start]
            here = following[start].pop()
            while here != start:
                if not following.get(here):
                    return None
                loop.append(here)
                here = following[here].pop()
            if len(loop) > 2:
                loops.append(loop)
    return loops


def _fitted(
    points: NDArray[np.float64], corners: Indices, rows: Indices, tolerance: float
) -> tuple[Indices, Indices] | None:
    """The triangles (n, 3), and what `rows` holds for each, less those without width, and divided where a corner of
    one lies on an edge of another; None where edges are left without a partner.

    A fin may have been all that two pieces hung together by: its outline is then a line there and back, along an edge
    that spans the gap between them.
    """
    corners = _welded(points, tolerance)[corners]
    a, b, c = (points[corners[:, k]] for k in range(3))
    longest = np.max(
        [np.linalg.norm(b - a, axis=1), np.linalg.norm(c - b, axis=1), np.linalg.norm(a - c, axis=1)], axis=0
    )
    wide = np.linalg.norm(np.cross(b - a, c - a), axis=1) > tolerance * longest
    triangles = [tuple(row) for row in corners[wide].tolist()]
    owners = rows[wide].tolist()
    for _ in range(MOST_PASSES):
        lone = _lone_edges(triangles)
        if not triangles:
            return None  # all of it is fins
        if not lone:
            return np.array(triangles, dtype=np.int64), np.array(owners, dtype=np.int64)
        known = np.array(sorted({vertex for edge in lone for vertex in edge}))
        for index in range(len(triangles)):
            triangle = triangles[index]
            for k in range(3):
                start, end, far = triangle[k], triangle[(k + 1) % 3], triangle[(k + 2) % 3]
                if (start, end) in lone:
                    middle = _between(points, known, start, end, tolerance)
                    if middle is not None:
                        triangles[index] = (start, middle, far)
                        triangles.append((middle, end, far))
                        owners.append(owners[index])
                        break
    return None


def _welded(points: NDArray[np.float64], tolerance: float) -> Indices:
    """(n,) the first vertex at the place of each vertex."""
    from scipy.spatial import cKDTree

    first = np.arange(len(points))
    for one, other in sorted(cKDTree(points).query_pairs(tolerance)):
        first[other] = min(first[other], first[one])
    return first


def _lone_edges(triangles: list[tuple[int, ...]]) -> set[tuple[int, int]]:
    """Directed edges that do not occur as often as their opposites."""
    count: dict[tuple[int, int], int] = {}
    for p, q, r in triangles:
        for edge in ((p, q), (q, r), (r, p)):
            count[edge] = count.get(edge, 0) + 1
    return {edge for edge, times in count.items() if count.get(edge[::-1], 0) != times}


def _between(points: NDArray[np.float64], known: Indices, start: int, end: int, tolerance: float) -> int | None:
    """The vertex of `known` within the edge that is nearest to its start."""
    along = points[end] - points[start]
    length = float(np.linalg.norm(along))
    arms = points[known] - points[start]
    share = arms @ along / length
    away = np.linalg.norm(arms - np.outer(share, along / length), axis=1)
    inside = np.flatnonzero((away <= tolerance) & (share > tolerance) & (share < length - tolerance))
    return int(known[inside[int(np.argmin(share[inside]))]]) if len(inside) else None


def _rebuilt(solid: Solid, corners: Indices, rows: Indices) -> Solid | None:
    """A solid of triangles `corners` (n, 3), each with the surface and the primitive of the old triangle in `rows`.

    None where they bound no solid, or another one than before.
    """
    if (edge_neighbours(corners, len(solid.facets.vertices)) < 0).any():
        return None
    mesh = solid.manifold.to_mesh64()
    run = np.searchsorted(np.asarray(mesh.run_index, np.int64) // 3, rows, side="right") - 1
    order = np.argsort(run, kind="stable")
    counts = np.bincount(run, minlength=len(mesh.run_original_id))
    used = counts > 0
    manifold = Manifold(
        Mesh64(
            np.array(solid.facets.vertices),
            np.ascontiguousarray(corners[order], dtype=np.uint64),
            run_index=np.concatenate([[0], 3 * np.cumsum(counts[used])]).astype(np.uint64),
            run_original_id=np.asarray(mesh.run_original_id, np.uint32)[used],
            face_id=solid.facets.surface[rows[order]].astype(np.uint64),
        )
    )
    try:
        check_status(manifold)
    except NotSolidError:
        return None
    rebuilt = Solid(manifold, solid.surfaces)
    return rebuilt if abs(rebuilt.volume - solid.volume) <= NO_VOLUME * solid.volume else None
