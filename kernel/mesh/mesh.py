"""The mesh of the whole model, before couplings: one table of nodes, blocks of elements by segment and kind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True, eq=False)
class ElementBlock:
    """Elements of one kind in one segment.

    segment: the segment's id. kind: a name in elements.ELEMENT_KINDS. connectivity: (n_element, n_node) int64 into
    the mesh's nodes. orientation: for lines, (n_element, 3) the section's local y axis (`u` of the beam), else None.
    """

    segment: str
    kind: str
    connectivity: NDArray[np.int64]
    orientation: NDArray[np.float64] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Mesh:
    """nodes: (n_node, 3) float64; blocks in the order of the segments."""

    nodes: NDArray[np.float64]
    blocks: tuple[ElementBlock, ...]

    @property
    def n_node(self) -> int:
        """Number of nodes."""
        return len(self.nodes)

    def count(self) -> dict[str, int]:
        """Number of elements by kind."""
        counts: dict[str, int] = {}
        for block in self.blocks:
            counts[block.kind] = counts.get(block.kind, 0) + len(block.connectivity)
        return counts
