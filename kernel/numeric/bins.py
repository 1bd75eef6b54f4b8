"""A grid of square cells over the region, that says which edges come near a place.

Cell (i, j) covers x0 + i cell .. x0 + (i+1) cell; its number is j * n_x + i.
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled


@compiled
def segment_distance2(px, py, ax, ay, bx, by):
    """Squared distance of p from the segment a-b."""
    dx = bx - ax
    dy = by - ay
    t = ((px - ax) * dx + (py - ay) * dy) / (dx * dx + dy * dy + 1e-300)
    t = min(1.0, max(0.0, t))
    qx = ax + t * dx - px
    qy = ay + t * dy - py
    return qx * qx + qy * qy


@compiled
def bin_edges(points, start, end, x0, y0, cell, n_x, n_y):
    """Edges by the cells that their bounding boxes touch: offset (n_cell + 1,) and edge lists, int32."""
    offset = np.zeros(n_x * n_y + 1, np.int32)
    fill = offset
    edges = np.empty(0, np.int32)
    for is_filling in range(2):
        if is_filling == 1:
            for k in range(n_x * n_y):
                offset[k + 1] += offset[k]
            edges = np.empty(offset[n_x * n_y], np.int32)
            fill = offset.copy()
        for i in range(len(start)):
            a = start[i]
            b = end[i]
            i0 = int((min(points[a, 0], points[b, 0]) - x0) / cell)
            i1 = int((max(points[a, 0], points[b, 0]) - x0) / cell)
            j0 = int((min(points[a, 1], points[b, 1]) - y0) / cell)
            j1 = int((max(points[a, 1], points[b, 1]) - y0) / cell)
            for j in range(j0, j1 + 1):
                for c in range(i0, i1 + 1):
                    k = j * n_x + c
                    if is_filling == 0:
                        offset[k + 1] += 1
                    else:
                        edges[fill[k]] = i
                        fill[k] += 1
    return offset, edges
