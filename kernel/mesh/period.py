"""Differences on a closed cylinder."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def shortest_way(dx: NDArray[np.float64], period: float) -> NDArray[np.float64]:
    """x differences taken the shorter way round."""
    return dx - period * np.round(dx / period)
