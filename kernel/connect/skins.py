"""The skin of a segment: its shells, or the outer faces of its solids, and which place of it stands opposite a point.

o  point, `away` from the skin along its normal
|
--+---x------+--      x: its foot, within a face; a round skin is met a little nearer or further than its chords
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.bricks import outer_faces
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock
from kernel.mesh.shapes import beyond_rim, doubled_normals, foot_on_face, shape_values

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

SMOOTH = np.cos(np.radians(50.0))
"""Faces that meet at less than this angle are chords of one round skin; solids have edges elsewhere."""

INSIDE = 1e-6
"""Local coordinates beyond a face's rim by less than this are on it."""


@dataclass(frozen=True, slots=True, eq=False)
class Foot:
    """Where a point stands opposite a face. nodes, weights: the face's corners; normal (3,) unit, outwards of a solid.

    height: of the point above it, along the normal.
    """

    nodes: Indices
    weights: Array
    normal: Array
    height: float


@dataclass(frozen=True, slots=True, eq=False)
class Edge:
    """Two neighbouring nodes of a shell's rim, its normal (3,) there, and the way out in its plane (3,)."""

    start: int
    end: int
    normal: Array
    out: Array


@dataclass(frozen=True, slots=True, eq=False)
class Faces:
    """Faces of one kind. corners (m, k); at (m, k, 3); low, high (m, 3) of their boxes.

    middle_normals (m, 3): the faces' own; normals (m, k, 3): the skin's at their corners. bulge, spread (m,): how far
    the skin rises above the face at most, and how much its normals differ over it.
    """

    kind: str
    corners: Indices
    at: Array
    low: Array
    high: Array
    middle_normals: Array
    normals: Array
    bulge: Array
    spread: Array


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """half: distance of the body's surface from its faces, half a thickness for shells and 0 for solids.

    blocks: the segment's. nodes: of its faces, shells' mid-side ones too, sorted. box: (2, 3) about them.
    """

    segment: str
    is_solid: bool
    half: float
    blocks: tuple[ElementBlock, ...]
    nodes: Indices
    box: Array
    faces: tuple[Faces, ...]
    _normals: dict[int, list[Array]]

    @classmethod
    def of(cls, segment: str, blocks: Sequence[ElementBlock], thickness: float | None, points: Array) -> Skin:
        """blocks: the segment's, all of shells or all of solids; points: (n_node, 3) of the mesh."""
        is_solid = ELEMENT_KINDS[blocks[0].kind].dimension == 3
        if is_solid:
            groups = [group for group in outer_faces(blocks) if len(group)]
        else:
            groups = [block.connectivity[:, : ELEMENT_KINDS[block.kind].n_corner] for block in blocks]
        rows = groups if is_solid else [block.connectivity for block in blocks]
        nodes = np.unique(np.concatenate([row.ravel() for row in rows]))
        faces = _with_normals(groups, points)
        normals: dict[int, list[Array]] = {}
        for part, connectivity in zip(faces, rows, strict=True):
            for row, normal in zip(connectivity.tolist(), part.middle_normals):
                for node in row:
                    normals.setdefault(node, []).append(normal)
        box = np.array([points[nodes].min(axis=0), points[nodes].max(axis=0)])
        half = 0.0 if thickness is None or is_solid else 0.5 * thickness
        return cls(segment, is_solid, half, tuple(blocks), nodes, box, faces, normals)

    @property
    def area(self) -> float:
        """Of all faces."""
        return float(sum(np.linalg.norm(doubled_normals(part.at), axis=1).sum() / 2 for part in self.faces))

    @property
    def bulge(self) -> float:
        """How far the skin rises above its faces anywhere."""
        return max(float(part.bulge.max()) for part in self.faces)

    @property
    def reach(self) -> float:
        """How far the body's surface may lie outside the box of its nodes."""
        return self.half + self.bulge

    def those_near(self, nodes: Indices, points: Array, reach: float) -> list[int]:
        """Those of the nodes (n,) that may be within `reach` of the skin, by its box. points: of the mesh."""
        margin = reach + self.bulge
        at = points[nodes]
        return nodes[((at >= self.box[0] - margin) & (at <= self.box[1] + margin)).all(axis=1)].tolist()

    def looks(self, node: int, direction: Array, cosine: float) -> bool:
        """Whether one of the faces at a node looks in a direction, or for shells against it, within an angle."""
        found = (float(normal @ direction) for normal in self._normals[node])
        return any(value >= cosine or (not self.is_solid and -value >= cosine) for value in found)

    def rim(self) -> list[Edge]:
        """Of shells the edges that one element has; of second order their halves."""
        ends, elements = [], []  # of every edge its two nodes, and whose it is
        for number, block in enumerate(self.blocks):
            kind = ELEMENT_KINDS[block.kind]
            for k, line in enumerate(kind.edges):
                nodes = list(line)
                if kind.order == 2:
                    nodes.insert(1, kind.n_corner + k)
                for pair in pairwise(nodes):
                    ends.append(block.connectivity[:, pair])
                    own = np.arange(len(block.connectivity))
                    elements.append(np.column_stack([np.full_like(own, number), own, np.full_like(own, k)]))
        every, owner = np.concatenate(ends), np.concatenate(elements)
        _, same, count = np.unique(np.sort(every, axis=1), axis=0, return_inverse=True, return_counts=True)
        lone = np.flatnonzero(count[same.reshape(-1)] == 1)
        lone = lone[np.lexsort(owner[lone].T[::-1])]
        return [self._edge(*every[row].tolist(), *owner[row].tolist()) for row in lone.tolist()]

    def _edge(self, start: int, end: int, block: int, element: int, number: int) -> Edge:
        """An edge of an element, or half of it, with the normal and the way out."""
        part = self.faces[block]
        first, last = ELEMENT_KINDS[self.blocks[block].kind].edges[number]
        normal = part.middle_normals[element]
        out = np.cross(part.at[element, last] - part.at[element, first], normal)
        return Edge(start, end, normal, out / np.linalg.norm(out))

    def foot(
        self, place: Array, reach: float, away: float, accept: Callable[[Array], bool], up_to: float | None = None
    ) -> Foot | None:
        """The foot of a point that stands `away` (or from there up to another distance) from the skin, within `reach`.

        None where it does not. Of a solid only from outside. accept: whether a face of a normal (3,) may be meant;
        shells' faces are asked with their normal towards the point.
        """
        most = away if up_to is None else up_to
        best: tuple[float, Foot] | None = None
        for part in self.faces:
            margin = (most + reach + part.bulge)[:, None]
            inside = ((place >= part.low - margin) & (place <= part.high + margin)).all(axis=1)
            for row in np.flatnonzero(inside).tolist():
                found = self._foot_on(part, row, place, reach, (away, most))
                if found is None or (best is not None and found[0] >= best[0]):
                    continue
                normal = part.middle_normals[row]
                if accept(normal if self.is_solid or found[1].height >= 0 else -normal):
                    best = found
        return None if best is None else best[1]

    def _foot_on(
        self, part: Faces, row: int, place: Array, reach: float, window: tuple[float, float]
    ) -> tuple[float, Foot] | None:
        """(how far beyond the face's rim, the foot)."""
        corners = part.at[row]
        local = foot_on_face(part.kind, corners, place)
        weights = shape_values(part.kind, local[None])[0]
        normal = weights @ part.normals[row]
        normal /= np.linalg.norm(normal)
        off = place - weights @ corners
        height = float(np.linalg.norm(off)) * (1.0 if off @ normal >= 0 else -1.0)
        spread = float(part.spread[row])
        slack = reach + float(part.bulge[row]) + window[1] * spread**2
        apart = height if self.is_solid else abs(height)
        if not window[0] - slack <= apart <= window[1] + slack:
            return None
        size = float(np.linalg.norm(np.roll(corners, -1, axis=0) - corners, axis=1).min())
        beyond = beyond_rim(part.kind, local)
        if beyond > INSIDE + 2 * (window[1] * spread + reach) / size:
            return None
        weights = np.where(np.abs(weights) > INSIDE, np.clip(weights, 0.0, None), 0.0)
        return beyond, Foot(part.corners[row], weights / weights.sum(), normal, height)


def _with_normals(groups: Sequence[Indices], points: Array) -> tuple[Faces, ...]:
    """The skin's normals at the corners: averages over the faces there that are chords of one round skin."""
    places = [points[group] for group in groups]
    own = [doubled_normals(at) for at in places]
    node = np.concatenate([group.ravel() for group in groups])
    long = np.concatenate([np.repeat(doubled, group.shape[1], axis=0) for doubled, group in zip(own, groups)])
    unit = long / np.linalg.norm(long, axis=1, keepdims=True)
    order = np.argsort(node, kind="stable")
    total = unit.copy()
    for apart in range(1, int(np.bincount(node).max(initial=1))):
        one, other = order[:-apart], order[apart:]
        cosine = np.einsum("ij,ij->i", unit[one], unit[other])
        near = (node[one] == node[other]) & (cosine > SMOOTH)
        total[one[near]] += unit[other[near]]
        total[other[near]] += unit[one[near]]
    total /= np.linalg.norm(total, axis=1, keepdims=True)
    found, start = [], 0
    for group, at, doubled in zip(groups, places, own):
        count, k = group.shape
        normals = total[start : start + count * k].reshape(count, k, 3)
        start += count * k
        sides = np.roll(at, -1, axis=1) - at
        turns = np.roll(normals, -1, axis=1) - normals
        # an arc whose normals turn by a small angle over a chord rises by an eighth of angle times chord
        rise = np.abs(np.einsum("ijk,ijk->ij", sides, turns)).max(axis=1) / 8
        middle = doubled / np.linalg.norm(doubled, axis=1, keepdims=True)
        flat = np.linalg.norm(turns, axis=2).max(axis=1)
        is_round = flat > INSIDE
        found.append(
            Faces(
                "tri3" if k == 3 else "quad4",
                group,
                at,
                at.min(axis=1),
                at.max(axis=1),
                middle,
                normals,
                np.where(is_round, 2 * rise, 0.0),
                np.where(is_round, flat, 0.0),
            )
        )
    return tuple(found)
