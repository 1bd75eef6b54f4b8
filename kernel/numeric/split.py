r"""Midpoint split: a coarse quad becomes four quads, a coarse triangle three.

    d---s---c         c
    |   |   |        / \
    t---m---r       t   s
    |   |   |      / \ / \
    a---q---b     a---m---b     (m also joins the middle of a-b)

The middle of a region's edge is the region's own node between its ends, so arcs stay exact.
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.arrays import copy_points
from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import find_edge, following, preceding


@compiled
def given_middles(corner, twin, leaving, start, end, middle, n_triangle):
    """The given middle node of each half-edge, -1 for none: (3 n_triangle,) int32."""
    of_half = np.full(3 * n_triangle, -1, np.int32)
    for i in range(len(start)):
        if leaving[start[i]] < 0:
            continue
        e = np.int64(find_edge(corner, twin, leaving, np.int64(start[i]), np.int64(end[i])))
        if e < 0:
            e = np.int64(find_edge(corner, twin, leaving, np.int64(end[i]), np.int64(start[i])))
        if e < 0:
            continue
        of_half[e] = middle[i]
        if twin[e] >= 0:
            of_half[twin[e]] = middle[i]
    return of_half


@compiled
def midpoint_split(points, given, node_of, corner, twin, mate, middle_of, n_triangle):
    """Nodes (n, 2) and quads (n_quad, 4) int32.

    given: (n_given, 2) the region's points, first nodes of the result. node_of: (n_coarse,) int32, the result's node
    of each coarse node, below n_given for the region's own. points: (n_coarse, 2). mate, middle_of: see match_triangles
    and given_middles (middle_of in numbers of `given`).
    """
    n_given = len(given)
    n_coarse = len(points)
    n_half = 3 * n_triangle
    nodes = np.empty((n_given + n_coarse + n_half + n_triangle, 2))
    copy_points(given, nodes)
    n = n_given
    for v in range(n_coarse):
        if node_of[v] >= n_given:
            nodes[node_of[v], 0] = points[v, 0]
            nodes[node_of[v], 1] = points[v, 1]
            n = max(n, node_of[v] + 1)
    middle = np.full(n_half, -1, np.int32)
    for e in range(n_half):
        f = twin[e]
        if mate[e // 3] == e or middle[e] >= 0:
            continue
        if middle_of[e] >= 0:
            m = np.int64(middle_of[e])
        else:
            a = corner[e]
            b = corner[following(e)]
            nodes[n, 0] = 0.5 * (points[a, 0] + points[b, 0])
            nodes[n, 1] = 0.5 * (points[a, 1] + points[b, 1])
            m = np.int64(n)
            n += 1
        middle[e] = m
        if f >= 0:
            middle[f] = m
    quads = np.empty((4 * n_triangle, 4), np.int32)
    n_quad = 0
    around = np.empty(4, np.int64)
    for t in range(n_triangle):
        if mate[t] < 0:
            n_side = 3
            for k in range(3):
                around[k] = 3 * t + k
        else:
            e = np.int64(mate[t])
            f = np.int64(twin[e])
            if f // 3 < t:
                continue
            n_side = 4
            around[0] = following(e)
            around[1] = preceding(e)
            around[2] = following(f)
            around[3] = preceding(f)
        total_x = 0.0
        total_y = 0.0
        for k in range(n_side):
            total_x += points[corner[around[k]], 0]
            total_y += points[corner[around[k]], 1]
        nodes[n, 0] = total_x / n_side
        nodes[n, 1] = total_y / n_side
        for k in range(n_side):
            quads[n_quad, 0] = node_of[corner[around[k]]]
            quads[n_quad, 1] = middle[around[k]]
            quads[n_quad, 2] = n
            quads[n_quad, 3] = middle[around[(k + n_side - 1) % n_side]]
            n_quad += 1
        n += 1
    return nodes[:n].copy(), quads[:n_quad].copy()
