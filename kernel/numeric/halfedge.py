"""Triangles as half-edges in flat arrays.

Half-edges of triangle t are 3t, 3t+1, 3t+2, counter-clockwise; half-edge e runs from corner[e] to
corner[following(e)] and has its triangle e // 3 on its left.

corner  (3 n_triangle,) int32   node that the half-edge leaves
twin    (3 n_triangle,) int32   the half-edge the other way in the neighbour, -1 on the hull
lock    (3 n_triangle,) uint8   0 free, else a constraint: BOUNDARY, IMPRINT or CORNER (both twins carry it)
leaving (n_node,) int32         a half-edge that leaves the node, -1 for none. After carving, a node on the hull
                                has the hull's own half-edge here, so that turning counter-clockwise sees all.
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled

BOUNDARY = 1
IMPRINT = 2
CORNER = 4


@compiled
def following(e):
    """The next half-edge, counter-clockwise, of the same triangle."""
    return e - 2 if e % 3 == 2 else e + 1


@compiled
def preceding(e):
    """The half-edge before, of the same triangle."""
    return e + 2 if e % 3 == 0 else e - 1


@compiled
def flip(corner, twin, lock, leaving, e):
    r"""Turn the edge shared by two triangles.

    e runs from a to b with c on its left; afterwards from d to c with a on its left.

      b                b
    / ^ \            /   \
   c  |e d    ->    c <-e- d
    \ | /            \   /
      a                a
    """
    f = np.int64(twin[e])
    e_next = following(e)
    e_last = preceding(e)
    f_next = following(f)
    f_last = preceding(f)
    a = corner[e]
    b = corner[f]
    c = corner[e_last]
    d = corner[f_last]
    twin_bc = twin[e_next]
    twin_ca = twin[e_last]
    twin_ad = twin[f_next]
    twin_db = twin[f_last]
    lock_bc = lock[e_next]
    lock_ca = lock[e_last]
    lock_ad = lock[f_next]
    lock_db = lock[f_last]
    corner[e] = d
    corner[e_next] = c
    corner[e_last] = a
    corner[f] = c
    corner[f_next] = d
    corner[f_last] = b
    twin[e_next] = twin_ca
    twin[e_last] = twin_ad
    twin[f_next] = twin_db
    twin[f_last] = twin_bc
    if twin_ca >= 0:
        twin[twin_ca] = e_next
    if twin_ad >= 0:
        twin[twin_ad] = e_last
    if twin_db >= 0:
        twin[twin_db] = f_next
    if twin_bc >= 0:
        twin[twin_bc] = f_last
    lock[e_next] = lock_ca
    lock[e_last] = lock_ad
    lock[f_next] = lock_db
    lock[f_last] = lock_bc
    lock[e] = 0
    lock[f] = 0
    leaving[a] = e_last
    leaving[d] = e
    leaving[c] = e_next
    leaving[b] = f_last


@compiled
def find_edge(corner, twin, leaving, a, b):
    """The half-edge from node a to node b, -1 where there is none. Turns about a, both ways at a hull."""
    start = np.int64(leaving[a])
    e = start
    while True:
        if corner[following(e)] == b:
            return e
        e = np.int64(twin[preceding(e)])
        if e == start:
            return -1
        if e < 0:
            break
    e = start
    while True:
        f = np.int64(twin[e])
        if f < 0:
            return -1
        e = following(f)
        if corner[following(e)] == b:
            return e


@compiled
def rewind_to_hull(corner, twin, leaving, node):
    """Make leaving[node] the hull's half-edge again where the node lies on the hull."""
    start = np.int64(leaving[node])
    e = start
    while twin[e] >= 0:
        e = following(np.int64(twin[e]))
        if e == start:
            return
    leaving[node] = e
