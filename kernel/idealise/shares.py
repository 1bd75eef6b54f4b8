"""A number of elements shared out to stretches that lie end to end."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def shared_out(lengths: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """How many of `count` >= len(lengths) elements each stretch gets: at least one, and so that they are most alike.

    One after another goes to the stretch whose elements are longest; of equal ones to the first.
    """
    shares = np.ones(len(lengths), dtype=np.int64)
    ideal = np.floor(np.asarray(lengths) * (count / float(np.sum(lengths))) * (1 - 1e-9)).astype(np.int64)
    shares = np.maximum(shares, ideal)
    while shares.sum() > count:
        shares[int(np.argmin(np.where(shares > 1, lengths / np.maximum(shares - 1, 1), np.inf)))] -= 1
    while shares.sum() < count:
        shares[int(np.argmax(lengths / shares))] += 1
    return shares
