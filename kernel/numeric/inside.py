"""Which points lie inside closed rings: the even-odd rule, every ring's edges in any order."""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled


@compiled
def inside_rings(points, from_x, from_y, to_x, to_y):
    """(n_point,) uint8: 1 inside. Edges as four (n_edge,) arrays; a point on an edge may fall either way."""
    is_inside = np.zeros(len(points), np.uint8)
    for i in range(len(points)):
        x = points[i, 0]
        y = points[i, 1]
        for e in range(len(from_x)):
            if (from_y[e] > y) != (to_y[e] > y):
                if x < from_x[e] + (y - from_y[e]) / (to_y[e] - from_y[e]) * (to_x[e] - from_x[e]):
                    is_inside[i] ^= 1
    return is_inside
