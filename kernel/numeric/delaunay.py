"""Incremental Delaunay triangulation: walk to the triangle, cut it in three, flip until Delaunay again.

Watson's insertion in Lawson's form: the cavity is found by flipping edges outwards from the new node, and it never
crosses a locked edge, so an insertion stays confined to its part of the region.
Degenerate cases: a point on an edge cuts off a flat triangle first, which the in-circle test flips away at once
(exactly, since the tests are exact); a point on a node is skipped and reported as that node's double.
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import flip, following, preceding
from kernel.numeric.predicates import incircle, orient

_WALK_LIMIT = 200000
STACK = 4096
"""Edges that wait for their test in one insertion; twice the degree of the new node at most."""


@compiled
def locate(x, y, corner, twin, lock, node, triangle, confined):
    """The triangle that holds `node`, walking from `triangle`; -1 at the hull, or at a lock if confined is 1."""
    came_through = -1
    for step in range(_WALK_LIMIT):
        moved = False
        turn = (step * 7) % 3  # another first edge at each step: a visibility walk that cannot circle for ever
        for k in range(3):
            e = 3 * triangle + (k + turn) % 3
            if e == came_through:
                continue
            if orient(x, y, np.int64(corner[e]), np.int64(corner[following(e)]), node) < 0:
                if twin[e] < 0 or (confined != 0 and lock[e] != 0):
                    return -1
                came_through = np.int64(twin[e])
                triangle = came_through // 3
                moved = True
                break
        if not moved:
            return triangle
    return -1


@compiled
def insert_in_triangle(x, y, corner, twin, lock, leaving, triangle, node, n_triangle, stack):
    """Cut `triangle` in three about `node` and flip until Delaunay. Returns the new number of triangles.

    stack: (STACK,) int32, scratch.
    """
    e0 = 3 * triangle
    e1 = e0 + 1
    e2 = e0 + 2
    a = corner[e0]
    b = corner[e1]
    c = corner[e2]
    twin_bc = twin[e1]
    twin_ca = twin[e2]
    lock_bc = lock[e1]
    lock_ca = lock[e2]
    f = 3 * n_triangle
    g = f + 3
    corner[e2] = node  # a, b, node
    corner[f] = b  # b, c, node
    corner[f + 1] = c
    corner[f + 2] = node
    corner[g] = c  # c, a, node
    corner[g + 1] = a
    corner[g + 2] = node
    twin[f] = twin_bc
    lock[f] = lock_bc
    if twin_bc >= 0:
        twin[twin_bc] = f
    twin[g] = twin_ca
    lock[g] = lock_ca
    if twin_ca >= 0:
        twin[twin_ca] = g
    lock[e1] = 0
    lock[e2] = 0
    lock[f + 1] = 0
    lock[f + 2] = 0
    lock[g + 1] = 0
    lock[g + 2] = 0
    twin[e1] = f + 2
    twin[f + 2] = e1
    twin[f + 1] = g + 2
    twin[g + 2] = f + 1
    twin[e2] = g + 1
    twin[g + 1] = e2
    leaving[a] = e0
    leaving[b] = f
    leaving[c] = g
    leaving[node] = e2
    stack[0] = e0
    stack[1] = f
    stack[2] = g
    n_waiting = 3
    while n_waiting > 0:
        n_waiting -= 1
        e = np.int64(stack[n_waiting])
        if lock[e] != 0 or twin[e] < 0:
            continue
        other = np.int64(twin[e])
        if incircle(x, y, corner[e], corner[other], corner[preceding(e)], corner[preceding(other)]) > 0:
            flip(corner, twin, lock, leaving, e)
            stack[n_waiting] = preceding(e)
            stack[n_waiting + 1] = following(other)
            n_waiting += 2
    return n_triangle + 2


@compiled
def insert_all(x, y, order, corner, twin, lock, leaving, n_triangle, double_of):
    """Insert the nodes of `order`; double_of[node] becomes the node that it coincides with. Returns n_triangle."""
    stack = np.empty(STACK, np.int32)
    triangle = np.int64(0)
    for i in range(len(order)):
        node = np.int64(order[i])
        triangle = locate(x, y, corner, twin, lock, node, triangle, np.int64(0))
        is_double = False
        for k in range(3):
            other = corner[3 * triangle + k]
            if x[other] == x[node] and y[other] == y[node]:
                double_of[node] = other
                is_double = True
        if is_double:
            continue
        n_triangle = insert_in_triangle(x, y, corner, twin, lock, leaving, triangle, node, n_triangle, stack)
        triangle = np.int64(leaving[node] // 3)
    return n_triangle
