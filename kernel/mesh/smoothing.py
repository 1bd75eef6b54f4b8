"""Smoothing and mending of quads, as all quad meshers here finish."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.numeric.smooth_quads import smooth_quads
from kernel.numeric.turn_edges import turn_edges

_SMOOTHING = (4, 3, 4, 0.97, 0.85, 0.9, 0.92, 2)
_AFTER_MENDING = (2, 3, 4, 0.8, 0.85, 0.9, 0.8, 1)
"""n_pass, n_bisect, n_search, active_under, good_enough, bisect_under, search_under and n_ring of smooth_quads, found
by trial on plates with holes."""
_MENDINGS = 3
_MEND_UNDER = 0.77
"""Quads under this are mended by turning edges, which helps where too many meet in a node."""
_MOST_MENDED = 100
"""Tried in one go, so that a region full of narrow gaps does not cost minutes."""


def smooth(nodes: NDArray[np.float64], quads: NDArray[np.integer], is_fixed: NDArray[np.bool_]) -> None:
    """Smooth the free nodes (n, 2), in place. is_fixed: (n,)."""
    smooth_quads(nodes, np.ascontiguousarray(quads, np.int32), is_fixed.astype(np.uint8), *_SMOOTHING)


def smooth_and_mend(nodes: NDArray[np.float64], quads: NDArray[np.int32], is_fixed: NDArray[np.bool_]) -> None:
    """Smooth the free nodes and turn edges of the worst quads, in place. Edges between fixed nodes stay."""
    fixed = is_fixed.astype(np.uint8)
    smooth_quads(nodes, quads, fixed, *_SMOOTHING)
    for _ in range(_MENDINGS):
        if turn_edges(nodes, quads, fixed, _MEND_UNDER, _MOST_MENDED) == 0:
            break
        smooth_quads(nodes, quads, fixed, *_AFTER_MENDING)
