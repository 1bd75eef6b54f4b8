"""A mesh being changed: elements taken out and put in by block, nodes appended; then made a model again."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.audit import coupling_nodes
from kernel.connect.build import clean_coordinates
from kernel.connect.model import Model, NamedSet
from kernel.connect.reference import Reference, renumbered, renumbered_arms
from kernel.edit.edited import renumbered_coupling
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Edge = tuple[int, int]


class Workpiece:
    """blocks: as they stand now, node numbers in a table that only grows. middles: mid-side node by edge (a < b)."""

    def __init__(self, model: Model, reference: Reference) -> None:
        self.model = model
        self.reference = reference
        self.blocks = list(model.mesh.blocks)
        self.middles = _middles(self.blocks)
        self.held = {int(n) for c in model.couplings for n in coupling_nodes(c)}
        self._nodes = [model.mesh.nodes]
        self._n_node = model.mesh.n_node
        self._inside = [_split(named, self.blocks) for named in model.sets]
        self._nodes_of = [set(named.nodes.tolist()) for named in model.sets]
        self._splits: list[tuple[int, int, int]] = []

    @property
    def nodes(self) -> Array:
        """All nodes, old and new."""
        if len(self._nodes) > 1:
            self._nodes = [np.vstack(self._nodes)]
        return self._nodes[0]

    def add_nodes(self, places: Array) -> Indices:
        """Numbers of new nodes at places (n, 3)."""
        places = np.asarray(places, dtype=np.float64).reshape(-1, 3)
        self._nodes.append(places)
        self._n_node += len(places)
        return np.arange(self._n_node - len(places), self._n_node)

    def split_edge(self, a: int, b: int, node: int) -> None:
        """Note that the curve's edge from a to b now passes through the node."""
        self._splits.append((a, b, node))

    def replace_elements(
        self, segment: str, taken: Sequence[tuple[int, Indices]], new: Sequence[tuple[str, Indices, Array | None]]
    ) -> None:
        """Take elements (block, indices) of a segment out and put others (kind, connectivity, orientation) in.

        They join the sets that all those taken belong to, and go where the first of their kind stood.
        """
        joined = [all(bool(inside[block][rows].all()) for block, rows in taken) for inside in self._inside]
        old = np.unique(np.concatenate([self.blocks[block].connectivity[rows].ravel() for block, rows in taken]))
        first = {self.blocks[block].kind: int(rows.min()) for block, rows in taken}
        for block, rows in taken:
            stays = np.ones(len(self.blocks[block].connectivity), dtype=bool)
            stays[rows] = False
            self._put(block, stays, np.empty((0, self.blocks[block].connectivity.shape[1]), np.int64), None, 0, joined)
        for kind, connectivity, orientation in new:
            block = self._block_of(segment, kind, taken[0][0])
            stays = np.ones(len(self.blocks[block].connectivity), dtype=bool)
            self._put(block, stays, connectivity, orientation, first.get(kind, int(stays.sum())), joined)
            self._note_middles(kind, connectivity)
        fresh = {int(node) for _, connectivity, _ in new for node in connectivity.ravel()}
        for nodes, inside in zip(self._nodes_of, joined):
            if inside and nodes.issuperset(old.tolist()):
                nodes |= fresh

    def finished(self) -> tuple[Model, Reference]:
        """The model without the nodes that lost their last element, and its reference."""
        was_there = self.model.mesh.n_node
        was_used = _used(self.model.mesh.blocks, self._n_node)
        is_used = _used(self.blocks, self._n_node)
        is_used[sorted(self.held)] = True
        is_gone = was_used & ~is_used
        numbers = np.where(is_gone, -1, np.cumsum(~is_gone) - 1)
        nodes = np.array(self.nodes)
        nodes[was_there:] = clean_coordinates(nodes[was_there:], self.reference.size)
        nodes = nodes[~is_gone]
        nodes.flags.writeable = False
        blocks = tuple(replace(b, connectivity=numbers[b.connectivity]) for b in self.blocks if len(b.connectivity) > 0)
        full = [index for index, block in enumerate(self.blocks) if len(block.connectivity) > 0]
        sets = tuple(
            NamedSet(
                named.name,
                np.sort(numbers[[node for node in sorted(of_nodes) if not is_gone[node]]]),
                np.flatnonzero(np.concatenate([inside[index] for index in full])),
            )
            for named, of_nodes, inside in zip(self.model.sets, self._nodes_of, self._inside)
        )
        couplings = [renumbered_coupling(coupling, numbers) for coupling in self.model.couplings]
        model = replace(
            self.model,
            mesh=Mesh(nodes, blocks),
            couplings=tuple(coupling for coupling in couplings if coupling is not None),
            sets=sets,
        )
        arms = renumbered_arms(self.reference.arms, numbers)
        return model, replace(self.reference, curve_uses=renumbered(self._split_curves(), numbers), arms=arms)

    def _put(
        self,
        block: int,
        stays: NDArray[np.bool_],
        connectivity: Indices,
        orientation: Array | None,
        at: int,
        joined: Sequence[bool],
    ) -> None:
        """Keep some elements of a block and insert others before the one that is number `at` among those kept."""
        before = self.blocks[block]
        kept = before.connectivity[stays]
        turned = before.orientation
        if turned is not None:
            added = np.empty((0, 3)) if orientation is None else orientation
            turned = np.insert(turned[stays], min(at, len(kept)), added, axis=0)
        rows = np.insert(kept, min(at, len(kept)), connectivity, axis=0)
        self.blocks[block] = replace(before, connectivity=rows, orientation=turned)
        for inside, is_joined in zip(self._inside, joined):
            inside[block] = np.insert(inside[block][stays], min(at, len(kept)), np.full(len(connectivity), is_joined))

    def _block_of(self, segment: str, kind: str, beside: int) -> int:
        """The segment's block of a kind; a new one behind the block `beside` where there is none."""
        for index, block in enumerate(self.blocks):
            if (block.segment, block.kind) == (segment, kind):
                return index
        self.blocks.append(ElementBlock(segment, kind, np.empty((0, ELEMENT_KINDS[kind].n_node), np.int64)))
        for inside in self._inside:
            inside.append(np.empty(0, dtype=bool))
        order = [*range(beside + 1), len(self.blocks) - 1, *range(beside + 1, len(self.blocks) - 1)]
        self.blocks = [self.blocks[index] for index in order]
        self._inside = [[inside[index] for index in order] for inside in self._inside]
        return beside + 1

    def _note_middles(self, kind: str, connectivity: Indices) -> None:
        self.middles.update(_middles([ElementBlock("", kind, connectivity)]))

    def _split_curves(self) -> Indices:
        rows = {(min(a, b), max(a, b)): count for a, b, count in self.reference.curve_uses.tolist()}
        for a, b, node in self._splits:
            count = rows.pop((min(a, b), max(a, b)), None)
            if count is not None:
                rows.update({(min(a, node), max(a, node)): count, (min(b, node), max(b, node)): count})
        return np.array([(a, b, count) for (a, b), count in rows.items()], dtype=np.int64).reshape(-1, 3)


def _middles(blocks: Sequence[ElementBlock]) -> dict[Edge, int]:
    found: dict[Edge, int] = {}
    for block in blocks:
        kind = ELEMENT_KINDS[block.kind]
        if kind.order == 2:
            for place, (a, b) in enumerate(kind.edges):
                pairs = np.sort(block.connectivity[:, [a, b]], axis=1).tolist()
                middles = block.connectivity[:, kind.n_corner + place].tolist()
                found.update({(one, other): middle for (one, other), middle in zip(pairs, middles)})
    return found


def _split(named: NamedSet, blocks: Sequence[ElementBlock]) -> list[NDArray[np.bool_]]:
    """Of each block, which elements are in the set."""
    counts = [len(block.connectivity) for block in blocks]
    inside = np.zeros(sum(counts), dtype=bool)
    inside[named.elements] = True
    return np.split(inside, np.cumsum(counts)[:-1])


def _used(blocks: Sequence[ElementBlock], n_node: int) -> NDArray[np.bool_]:
    used = np.zeros(n_node, dtype=bool)
    for block in blocks:
        used[block.connectivity.ravel()] = True
    return used
