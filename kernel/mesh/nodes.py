"""The table of nodes while the mesh grows, block by block."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class NodeTable:
    """Nodes are only ever added, never searched for: what shall be shared is shared by number."""

    def __init__(self) -> None:
        self._held = np.empty((1024, 3))
        self.count = 0

    def add(self, points: Array) -> NDArray[np.int64]:
        """Numbers (n,) of new nodes at points (n, 3)."""
        points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
        end = self.count + len(points)
        if end > len(self._held):  # half as much again, so that all copies together cost no more than the nodes
            grown = np.empty((max(end, len(self._held) + len(self._held) // 2), 3))
            grown[: self.count] = self._held[: self.count]
            self._held = grown
        self._held[self.count : end] = points
        numbers = np.arange(self.count, end, dtype=np.int64)
        self.count = end
        return numbers

    @property
    def points(self) -> Array:
        """All nodes so far, (n, 3)."""
        return self._held[: self.count]
