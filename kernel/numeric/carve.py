"""Removal of the triangles outside the region: flooded from the frame and from the right of each boundary edge."""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import BOUNDARY, find_edge


@compiled
def carve(corner, twin, lock, leaving, n_triangle, start, end, kind, n_node):
    """Drop the outside in place, renumber what stays; returns the number of triangles inside.

    start, end, kind: (n_edge,) constraints, BOUNDARY ones with the region on their left. Nodes from n_node on are
    the frame's. Where no edge is a BOUNDARY only the frame's own triangles go. Afterwards leaving[node] of a hull
    node is the hull's half-edge.
    """
    is_outside = np.zeros(n_triangle, np.uint8)
    stack = np.empty(n_triangle, np.int32)
    n = 0
    for t in range(n_triangle):
        if corner[3 * t] >= n_node or corner[3 * t + 1] >= n_node or corner[3 * t + 2] >= n_node:
            is_outside[t] = 1
            stack[n] = t
            n += 1
    is_bounded = False
    for i in range(len(start)):
        if kind[i] != BOUNDARY:
            continue
        is_bounded = True
        e = np.int64(find_edge(corner, twin, leaving, np.int64(end[i]), np.int64(start[i])))
        if e >= 0 and is_outside[e // 3] == 0:
            is_outside[e // 3] = 1
            stack[n] = e // 3
            n += 1
    while n > 0 and is_bounded:
        n -= 1
        t = stack[n]
        for k in range(3):
            e = 3 * t + k
            if lock[e] == BOUNDARY:
                continue
            f = twin[e]
            if f >= 0 and is_outside[f // 3] == 0:
                is_outside[f // 3] = 1
                stack[n] = f // 3
                n += 1
    new_number = np.full(n_triangle, -1, np.int32)
    n_inside = 0
    for t in range(n_triangle):
        if is_outside[t] == 0:
            new_number[t] = n_inside
            n_inside += 1
    for t in range(n_triangle):
        if is_outside[t] != 0:
            continue
        for k in range(3):
            e = 3 * t + k
            f = twin[e]
            new = 3 * new_number[t] + k
            corner[new] = corner[e]
            lock[new] = lock[e]
            twin[new] = -1 if f < 0 or is_outside[f // 3] != 0 else 3 * new_number[f // 3] + f % 3
    for node in range(len(leaving)):
        leaving[node] = -1
    for e in range(3 * n_inside):
        node = corner[e]
        if leaving[node] < 0 or twin[e] < 0:
            leaving[node] = e
    return n_inside
