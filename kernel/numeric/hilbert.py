"""Order of points along Hilbert's curve: neighbours in the order are neighbours in the plane.

Delaunay insertion in this order walks a triangle or two from one point to the next (Delage and Devillers, CGAL's
spatial sorting).
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled


@compiled
def hilbert_key(x, y, bits):
    """Place of cell (x, y) along the curve through 2^bits by 2^bits cells."""
    key = 0
    half = 1 << (bits - 1)
    while half > 0:
        right = 1 if (x & half) else 0
        upper = 1 if (y & half) else 0
        key += half * half * ((3 * right) ^ upper)
        x = x & (half - 1)
        y = y & (half - 1)
        if upper == 0:
            if right == 1:
                x = half - 1 - x
                y = half - 1 - y
            x, y = y, x
        half >>= 1
    return key


@compiled
def hilbert_order(x, y, first, last, shift, bits):
    """Nodes first..last-1 along the curve, (last - first,) int32, by counting sort. x, y: int64, cell = x >> shift.

    Nodes of one cell keep their order, so the result is the same on every machine.
    """
    n = last - first
    n_cell = 1 << (2 * bits)
    count = np.zeros(n_cell + 1, np.int32)
    key = np.empty(n, np.int32)
    for i in range(n):
        k = hilbert_key(x[first + i] >> shift, y[first + i] >> shift, bits)
        key[i] = k
        count[k + 1] += 1
    for k in range(n_cell):
        count[k + 1] += count[k]
    order = np.empty(n, np.int32)
    for i in range(n):
        k = key[i]
        order[count[k]] = first + i
        count[k] += 1
    return order
