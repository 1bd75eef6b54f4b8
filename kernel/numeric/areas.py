"""Areas of triangles and quads: the last look at a mesh before it leaves."""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled


@compiled
def least_area(points, elements, period):
    """Number of the element with the least area, and twice that area (negative where it runs clockwise).

    elements: (n, 3) or (n, 4) int64, n > 0. period: of x, 0 for none; elements are narrower than half of it.
    """
    n_corner = elements.shape[1]
    worst = 0
    least = 1e300
    for i in range(len(elements)):
        a = elements[i, 0]
        b = elements[i, 1]
        c = elements[i, 2]
        d = elements[i, n_corner - 1]
        if n_corner == 3:
            ux = points[b, 0] - points[a, 0]
            uy = points[b, 1] - points[a, 1]
            vx = points[c, 0] - points[a, 0]
            vy = points[c, 1] - points[a, 1]
        else:  # the diagonals
            ux = points[c, 0] - points[a, 0]
            uy = points[c, 1] - points[a, 1]
            vx = points[d, 0] - points[b, 0]
            vy = points[d, 1] - points[b, 1]
        if period > 0:
            ux -= period * np.rint(ux / period)
            vx -= period * np.rint(vx / period)
        area = ux * vy - uy * vx
        if not area >= least:
            least = area
            worst = i
    return worst, least
