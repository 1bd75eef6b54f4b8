"""A patch of a shell segment meshed anew about a place, so that the place becomes a node.

+--+--+--+--+        The elements about the place are taken out, their rim stays as it is, and the hole is meshed
|  |  |  |  |        again with the place as a hard point (kernel/mesh/planar.py), on the segment's own surface
+--+--+--+--+        rolled out flat. Rim, curves inside it and nodes that couplings hold keep their nodes, so that
|  |  | *|  |        the mesh stays conforming and nothing outside the patch changes. For triangles that is the
+--+--+--+--+        insertion in a constrained Delaunay triangulation, smoothed; a quad cannot be split round one
|  |  |  |  |        node without hanging ones, so that quads are laid out anew. Several widths of patch are tried
+--+--+--+--+        and the best is taken.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.edit.fitted import Fitted, FittedCylinder, fit_surface
from kernel.edit.surroundings import WIDTHS, Surroundings
from kernel.edit.workpiece import Edge, Workpiece
from kernel.errors import MeshError
from kernel.mesh.elements import ELEMENT_KINDS, SECOND_ORDER
from kernel.mesh.mesh import ElementBlock
from kernel.mesh.planar import mesh_region
from kernel.mesh.quality import element_quality
from kernel.mesh.region import Region, RegionError, RegionMesh
from kernel.places import place_text

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

GOOD = 0.65
"""A patch whose elements all have this scaled Jacobian is taken without looking further."""

LEAST = 0.3
"""Scaled Jacobian of the worst element with which a patch is still taken."""


@dataclass(frozen=True, slots=True, eq=False)
class Split:
    """An edge of a curve that is to pass through the new node."""

    a: int
    b: int
    node: int


@dataclass(frozen=True, slots=True, eq=False)
class _Cavity:
    """taken: elements by block. rim: edges (n, 2), the cavity on their left; inner: kept edges inside it (m, 2).

    hard: nodes inside it that stay. size: target edge length. is_triangles: there are no quads in it.
    """

    taken: list[tuple[int, Indices]]
    rim: list[Edge]
    inner: list[Edge]
    hard: list[int]
    size: float
    is_triangles: bool


@dataclass(frozen=True, slots=True, eq=False)
class _Candidate:
    """mesh: of the cavity; numbers: of its first nodes, in the model; quality: its worst scaled Jacobian."""

    cavity: _Cavity
    n_rim: int
    mesh: RegionMesh
    numbers: list[int]
    quality: float

    @property
    def odd_triangles(self) -> int:
        """Triangles among quads, beyond the one that an odd number of edges round the patch asks for."""
        count = 0 if self.cavity.is_triangles else len(self.mesh.triangles)
        return max(0, count - 1) if self.n_rim % 2 else count


def surface_of(work: Workpiece, segment: str, place: Array) -> Fitted:
    """The surface of a segment's shells, unrolled about a place. MeshError: neither a plane nor a cylinder."""
    fitted = fitted_surface(work, segment, place)
    if fitted is None:
        raise MeshError(f"{segment} is neither plane nor a cylinder, expected one of them to add a node in")
    return fitted


def fitted_surface(work: Workpiece, segment: str, place: Array) -> Fitted | None:
    """The surface of a segment's shells, unrolled about a place; None where it is neither a plane nor a cylinder."""
    rows, centres, normals = [], [], []
    for block in work.blocks:
        if block.segment == segment and ELEMENT_KINDS[block.kind].dimension == 2:
            corners = work.nodes[block.connectivity[:, : ELEMENT_KINDS[block.kind].n_corner]]
            last = corners.shape[1] - 1
            across = np.cross(corners[:, last - 1] - corners[:, 0], corners[:, last] - corners[:, last - 2])
            normals.append(across / np.linalg.norm(across, axis=1, keepdims=True))
            centres.append(corners.mean(axis=1))
            rows.append(block.connectivity.ravel())
    points = work.nodes[np.unique(np.concatenate(rows))]
    return fit_surface(points, np.concatenate(centres), np.concatenate(normals), place)


def insert_in_patch(
    work: Workpiece,
    segment: str,
    fitted: Fitted,
    node: int,
    around: Surroundings,
    kept: set[Edge],
    split: Split | None = None,
) -> float:
    """Mesh the patch about a new node again; gives its worst scaled Jacobian. split: the kept edge that it lies on.

    around: the segment's shells about the node; kept: of their edges those that must stay.

    MeshError: no patch gives elements that are good enough.
    """
    place = work.nodes[node]
    best: _Candidate | None = None
    complaint = ""
    for width in WIDTHS:
        cavity = _cavity(work, segment, fitted, place, width, around, kept)
        if cavity is None:
            continue
        for faces in ("tri",) if cavity.is_triangles else ("mixed", "quad"):
            try:
                found = _meshed(work, cavity, fitted, node, faces, split)
            except RegionError as error:
                complaint = error.told(place_text(fitted.lift(error.at[None])[0]))
                continue
            except MeshError as error:
                complaint = error.message
                continue
            if best is None or _rank(found) > _rank(best):
                best = found
        if best is not None and best.quality >= GOOD and best.odd_triangles == 0:
            break
    if best is None or best.quality < LEAST:
        why = complaint if best is None else f"the worst element would have a scaled Jacobian of {best.quality:.2f}"
        raise MeshError(
            f"{segment} cannot have a node at {place_text(place)}: {why or 'its elements there are too few'}"
        )
    _put(work, segment, fitted, best, split)
    return best.quality


def _rank(candidate: _Candidate) -> tuple[bool, int, float]:
    """Good enough first, then as few triangles among quads as can be, then quality."""
    return candidate.quality >= LEAST, -candidate.odd_triangles, min(candidate.quality, GOOD)


def _cavity(
    work: Workpiece, segment: str, fitted: Fitted, place: Array, width: float, around: Surroundings, kept: set[Edge]
) -> _Cavity | None:
    """None where the patch would go too far round a cylinder."""
    rows = around.rows
    near = (around.distance <= width * around.size) | around.is_split
    near[int(np.argmin(around.distance))] = True
    start = np.flatnonzero(around.is_split).tolist()
    chosen = _connected(rows, near, start or [_containing(work, rows, near, fitted, place)])
    taken = [
        (index, np.array(sorted(rows[k][1] for k in chosen if rows[k][0] == index), dtype=np.int64))
        for index in sorted({rows[k][0] for k in chosen})
    ]
    loops = [rows[k][2] for k in sorted(chosen)]
    directed = [(loop[k], loop[(k + 1) % len(loop)]) for loop in loops for k in range(len(loop))]
    count = Counter((min(a, b), max(a, b)) for a, b in directed)
    rim = [(a, b) for a, b in directed if count[(min(a, b), max(a, b))] == 1]
    inner = sorted(pair for pair, times in count.items() if times == 2 and pair in kept)
    on_edges = {node for pair in (*rim, *inner) for node in pair}
    inside = {node for loop in loops for node in loop} - on_edges
    flat = fitted.flat(work.nodes[sorted({node for loop in loops for node in loop})])
    if isinstance(fitted, FittedCylinder) and fitted.is_wide(flat):
        return None
    outside = _used_elsewhere(work, segment, np.array(sorted(inside), dtype=np.int64))
    hard = sorted(node for node in inside if node in work.held or node in outside)
    own_size = float(np.mean(around.edge[sorted(chosen)]))
    return _Cavity(taken, rim, inner, hard, own_size, all(len(loop) == 3 for loop in loops))


def _containing(
    work: Workpiece,
    rows: Sequence[tuple[int, int, tuple[int, ...]]],
    near: NDArray[np.bool_],
    fitted: Fitted,
    place: Array,
) -> int:
    """The element in which the place lies, on the flat surface: the one that it is deepest in."""
    at = fitted.flat(place[None])[0]
    best, depth = -1, -np.inf
    for k in np.flatnonzero(near).tolist():
        corners = fitted.flat(work.nodes[list(rows[k][2])])
        along = np.roll(corners, -1, axis=0) - corners
        off = at - corners
        inward = (along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]) / np.linalg.norm(along, axis=1)
        if inward.min() > depth:
            best, depth = k, float(inward.min())
    return best


def _connected(
    rows: Sequence[tuple[int, int, tuple[int, ...]]], near: NDArray[np.bool_], start: Sequence[int]
) -> set[int]:
    """Elements that are reached from the first ones over edges, by elements that are near."""
    by_edge: dict[frozenset[int], list[int]] = {}
    for k in np.flatnonzero(near).tolist():
        loop = rows[k][2]
        for place in range(len(loop)):
            by_edge.setdefault(frozenset((loop[place], loop[(place + 1) % len(loop)])), []).append(k)
    found, waiting = set(start), list(start)
    while waiting:
        loop = rows[waiting.pop()][2]
        for place in range(len(loop)):
            for k in by_edge.get(frozenset((loop[place], loop[(place + 1) % len(loop)])), []):
                if k not in found:
                    found.add(k)
                    waiting.append(k)
    return found


def _used_elsewhere(work: Workpiece, segment: str, nodes: Indices) -> set[int]:
    """Those of the nodes that other segments have, or what is no shell."""
    found: set[int] = set()
    for block in work.blocks:
        if block.segment != segment or ELEMENT_KINDS[block.kind].dimension != 2:
            found.update(nodes[np.isin(nodes, block.connectivity)].tolist())
    return found


def _meshed(work: Workpiece, cavity: _Cavity, fitted: Fitted, node: int, faces: str, split: Split | None) -> _Candidate:
    def through(edges: Sequence[Edge]) -> list[Edge]:
        if split is None:
            return list(edges)
        ends = {split.a, split.b}
        return [pair for a, b in edges for pair in ([(a, split.node), (split.node, b)] if {a, b} == ends else [(a, b)])]

    rim, inner = through(cavity.rim), through(cavity.inner)
    on_edges = dict.fromkeys(n for pair in (*rim, *inner) for n in pair)
    numbers = [*on_edges, *(n for n in (*cavity.hard, node) if n not in on_edges)]
    local = {number: place for place, number in enumerate(numbers)}
    region = Region(
        points=fitted.flat(work.nodes[numbers]),
        edges=np.array([(local[a], local[b]) for a, b in (*rim, *inner)], dtype=np.int64),
        is_boundary=np.array([True] * len(rim) + [False] * len(inner)),
        is_curved=np.zeros(len(rim) + len(inner), dtype=bool),
    )
    mesh = mesh_region(region, cavity.size, faces)
    used = np.zeros(len(mesh.points), dtype=bool)
    for elements in (mesh.quads, mesh.triangles):
        used[elements.ravel()] = True
    if not used[: len(numbers)].all():
        raise MeshError("a node that must stay would be lost")
    places = fitted.lift(mesh.points)
    measured = [
        element_quality(ElementBlock("", kind, elements), places)["scaled_jacobian"].min()
        for kind, elements in (("quad4", mesh.quads), ("tri3", mesh.triangles))
        if len(elements)
    ]
    return _Candidate(cavity, len(rim), mesh, numbers, float(min(measured)))


def _put(work: Workpiece, segment: str, fitted: Fitted, found: _Candidate, split: Split | None) -> None:
    numbers = np.array(found.numbers, dtype=np.int64)
    added = work.add_nodes(fitted.lift(found.mesh.points[len(numbers) :]))
    numbers = np.concatenate([numbers, added])
    order = ELEMENT_KINDS[work.blocks[found.cavity.taken[0][0]].kind].order
    new: list[tuple[str, Indices, Array | None]] = []
    for kind, elements in (("quad4", found.mesh.quads), ("tri3", found.mesh.triangles)):
        if len(elements):
            corners = numbers[elements]
            new.append((SECOND_ORDER[kind], _with_middles(work, kind, corners, fitted), None) if order == 2
                       else (kind, corners, None))  # fmt: skip
    work.replace_elements(segment, found.cavity.taken, new)


def _with_middles(work: Workpiece, kind: str, corners: Indices, fitted: Fitted) -> Indices:
    """Mid-side nodes behind the corners: those that the edges have, else new ones on the surface."""
    columns = []
    for a, b in ELEMENT_KINDS[kind].edges:
        column = []
        for pair in np.sort(corners[:, [a, b]], axis=1).tolist():
            edge = (pair[0], pair[1])
            if edge not in work.middles:
                middle = fitted.flat(work.nodes[pair]).mean(axis=0)
                work.middles[edge] = int(work.add_nodes(fitted.lift(middle[None]))[0])
            column.append(work.middles[edge])
        columns.append(column)
    return np.hstack([corners, np.array(columns, dtype=np.int64).T])
