"""What lies about a place in a shell segment: its elements as far as any patch goes, and the edges that must stay.

Both look at the whole mesh in arrays once, and at single elements only near the place: an edit of a large mesh costs
little more than one of a small one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.edit.workpiece import Edge, Workpiece
from kernel.mesh.elements import ELEMENT_KINDS

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

WIDTHS = (1.8, 2.7, 2.2, 1.5, 3.5, 5.0)
"""Half widths of the patches that are tried, in element edges."""


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """The shells of a segment about a place, within the widest patch, in the order of their blocks.

    rows: (block, element, corners) of each. distance: (n,) of its middle from the place. edge: (n,) its mean edge.
    is_split: (n,) has both ends of the edge that is to be split. size: mean edge beside the place.
    """

    rows: list[tuple[int, int, tuple[int, ...]]]
    distance: Array
    edge: Array
    is_split: NDArray[np.bool_]
    size: float

    def nodes(self, n_node: int) -> NDArray[np.bool_]:
        """(n_node,) True for the corners of the elements."""
        about = np.zeros(n_node, dtype=bool)
        about[[node for _, _, corners in self.rows for node in corners]] = True
        return about


def shells_about(work: Workpiece, segment: str, place: Array, split: Edge | None = None) -> Surroundings:
    """The segment's shells about a place (3,), and those that have the edge that is to be split."""
    found: list[tuple[int, Indices]] = []
    middles, sizes, splits = [], [], []
    for index, block in enumerate(work.blocks):
        kind = ELEMENT_KINDS[block.kind]
        if block.segment != segment or kind.dimension != 2 or not len(block.connectivity):
            continue
        corners = block.connectivity[:, : kind.n_corner]
        places = work.nodes[corners]
        found.append((index, corners))
        middles.append(places.mean(axis=1))
        sizes.append(np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).mean(axis=1))
        has_both = (np.isin(corners, split).sum(axis=1) == 2) if split else np.zeros(len(corners), dtype=bool)
        splits.append(has_both)
    distance = np.linalg.norm(np.concatenate(middles) - place, axis=1)
    edge, is_split = np.concatenate(sizes), np.concatenate(splits)
    size = float(edge[np.argsort(distance, kind="stable")[:4]].mean())
    near = (distance <= max(WIDTHS) * size) | is_split
    near[int(np.argmin(distance))] = True
    rows, first = [], 0
    for index, corners in found:
        own = np.flatnonzero(near[first : first + len(corners)])
        rows += [(index, k, tuple(row)) for k, row in zip(own.tolist(), corners[own].tolist())]
        first += len(corners)
    return Surroundings(rows, distance[near], edge[near], is_split[near], size)


def kept_edges(work: Workpiece, segment: str, about: NDArray[np.bool_]) -> set[Edge]:
    """Edges (a < b) of the segment's shells that must stay: of its rim, of curves, of other segments, or held.

    about: (n_node,) only edges between two of these are looked for.
    """
    n_node = len(about)

    def codes(pairs: Indices) -> Indices:
        pairs = np.sort(pairs[about[pairs].all(axis=1)], axis=1)
        return pairs[:, 0] * n_node + pairs[:, 1]

    own, others = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for block in work.blocks:
        kind = ELEMENT_KINDS[block.kind]
        near = block.connectivity[about[block.connectivity[:, : kind.n_corner]].sum(axis=1) >= 2]
        side = own if block.segment == segment and kind.dimension == 2 else others
        side += [codes(near[:, list(edge)]) for edge in kind.edges]
    curves = codes(work.reference.curve_uses[:, :2].reshape(-1, 2))
    found, times = np.unique(np.concatenate(own), return_counts=True)
    is_kept = (times != 2) | np.isin(found, np.concatenate([*others, curves]))
    pairs = [divmod(code, n_node) for code in found.tolist()]
    return {pair for pair, is_sure in zip(pairs, is_kept.tolist()) if is_sure or work.middles.get(pair) in work.held}
