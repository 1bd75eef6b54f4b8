"""Boxes in space, asked which of them come near a place."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import STRtree

Array = NDArray[np.float64]


class BoxIndex:
    """Axis-parallel boxes (n, 2, 3), lowest and highest corner, searched by a tree over their two widest axes."""

    def __init__(self, boxes: Array | Sequence[Array]) -> None:
        self.boxes = np.asarray(boxes, dtype=np.float64).reshape(-1, 2, 3)
        spread = np.ptp(self.boxes.reshape(-1, 3), axis=0) if len(self.boxes) else np.zeros(3)
        self._x, self._y = sorted(np.argsort(spread)[1:].tolist())
        self._tree = STRtree(self._flat(self.boxes))

    def _flat(self, boxes: Array) -> NDArray[np.object_]:
        x, y = self._x, self._y
        return shapely.box(boxes[:, 0, x], boxes[:, 0, y], boxes[:, 1, x], boxes[:, 1, y])

    def near(self, low: Array, high: Array) -> list[int]:
        """Numbers of the boxes that touch the box from `low` to `high` (3,), in order."""
        return [found for _, found in self.pairs(np.array([[low, high]]))]

    def pairs(self, boxes: Array) -> list[tuple[int, int]]:
        """(number in `boxes` (m, 2, 3), number here) of all that touch, in order."""
        asked, found = self._tree.query(self._flat(boxes))
        low = np.maximum(boxes[asked, 0], self.boxes[found, 0])
        high = np.minimum(boxes[asked, 1], self.boxes[found, 1])
        touching = (low <= high).all(axis=1)
        return sorted(zip(asked[touching].tolist(), found[touching].tolist()))
