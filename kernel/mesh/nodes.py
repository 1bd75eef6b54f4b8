"""The table of nodes while the mesh grows, block by block."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class NodeTable:
    """Nodes are only ever added, never searched for: what shall be shared is shared by number."""

    def __init__(self) -> None:
        self._blocks: list[Array] = []
        self.count = 0

    def add(self, points: Array) -> NDArray[np.int64]:
        """Numbers (n,) of new nodes at points (n, 3)."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        numbers = np.arange(self.count, self.count + len(points), dtype=np.int64)
        if len(points):
            self._blocks.append(points)
        self.count += len(points)
        return numbers

    @property
    def points(self) -> Array:
        """All nodes, (n, 3)."""
        if len(self._blocks) > 1:
            self._blocks = [np.concatenate(self._blocks)]
        return self._blocks[0] if self._blocks else np.empty((0, 3))
