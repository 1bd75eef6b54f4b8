r"""Recovery of constraint edges in a Delaunay triangulation by flipping what crosses them.

Sloan 1993, A fast algorithm for generating constrained Delaunay triangulations: the edges that cross a-b wait in a
queue; one whose two triangles form a convex quadrilateral is flipped, any other waits again.

            c
          / | \
        a --+-- b      the edge c-d crosses a-b: flipped if a, d, b, c is convex
          \ | /
            d
Degenerate cases: a node on the constraint divides it, both parts are recovered; a crossing constraint fails.
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import find_edge, flip, following, preceding
from kernel.numeric.predicates import incircle, orient

QUEUE = 65536
_TURN_LIMIT = 1000000


@compiled
def recover_edge(x, y, corner, twin, lock, leaving, a, b, kind, queue_a, queue_b, counts):
    """Make a-b an edge and lock it as `kind`. False where another constraint crosses, or the queue overflows.

    queue_a, queue_b: (QUEUE,) int32 scratch. counts[0] += edges that had to be flipped in; counts[1] += nodes met.
    """
    while a != b:
        start = np.int64(leaving[a])
        e = start
        found = np.int64(-1)
        crossing = np.int64(-1)
        while True:
            p = np.int64(corner[following(e)])
            q = np.int64(corner[preceding(e)])
            if p == b:
                found = e
                break
            side = orient(x, y, a, p, b)
            if side == 0 and (x[p] - x[a]) * (x[b] - x[a]) + (y[p] - y[a]) * (y[b] - y[a]) > 0:
                found = e
                counts[1] += 1
                break
            if side > 0 and orient(x, y, a, q, b) < 0:
                crossing = following(e)
                break
            e = np.int64(twin[preceding(e)])
            if e == start or e < 0:
                return False
        if found >= 0:
            lock[found] = kind
            if twin[found] >= 0:
                lock[twin[found]] = kind
            a = np.int64(corner[following(found)])
            continue
        counts[0] += 1
        target = b
        n = 0
        e = crossing
        while True:  # the edges that a-b crosses, up to b or a node on it
            if lock[e] != 0 or twin[e] < 0:
                return False
            queue_a[n] = corner[e]
            queue_b[n] = corner[following(e)]
            n += 1
            if n >= QUEUE - 2:
                return False
            f = np.int64(twin[e])
            apex = np.int64(corner[preceding(f)])
            if apex == b:
                break
            side = orient(x, y, a, b, apex)
            if side == 0:
                target = apex
                break
            e = following(f) if side > 0 else preceding(f)
        head = 0
        tail = n
        for _ in range(_TURN_LIMIT):
            if head == tail:
                break
            u = np.int64(queue_a[head])
            v = np.int64(queue_b[head])
            head = (head + 1) % QUEUE
            e = np.int64(find_edge(corner, twin, leaving, u, v))
            if e < 0:
                return False
            f = np.int64(twin[e])
            c = np.int64(corner[preceding(e)])
            d = np.int64(corner[preceding(f)])
            if float(orient(x, y, c, d, u)) * float(orient(x, y, c, d, v)) < 0:
                flip(corner, twin, lock, leaving, e)
                u = c
                v = d
                touches = u in (a, target) or v in (a, target)
                if touches or float(orient(x, y, a, target, u)) * float(orient(x, y, a, target, v)) >= 0:
                    continue
            queue_a[tail] = u
            queue_b[tail] = v
            tail = (tail + 1) % QUEUE
        e = np.int64(find_edge(corner, twin, leaving, a, target))
        if e < 0:
            return False
        lock[e] = kind
        if twin[e] >= 0:
            lock[twin[e]] = kind
        a = target
    return True


@compiled
def restore_delaunay(x, y, corner, twin, lock, leaving, n_triangle):
    """Lawson's flips over the whole triangulation until every edge is locked or locally Delaunay."""
    n_half = 3 * n_triangle
    stack = np.empty(n_half + 64, np.int32)
    is_waiting = np.zeros(n_half, np.uint8)
    n = 0
    for e in range(n_half):
        if twin[e] > e and lock[e] == 0:
            stack[n] = e
            n += 1
            is_waiting[e] = 1
    while n > 0:
        n -= 1
        e = np.int64(stack[n])
        is_waiting[e] = 0
        f = np.int64(twin[e])
        if f < 0 or lock[e] != 0:
            continue
        if incircle(x, y, corner[e], corner[f], corner[preceding(e)], corner[preceding(f)]) > 0:
            flip(corner, twin, lock, leaving, e)
            for g in (following(e), preceding(e), following(f), preceding(f)):
                h = g
                if twin[g] >= 0 and twin[g] < g:
                    h = np.int64(twin[g])
                if is_waiting[h] == 0 and lock[h] == 0 and n < len(stack):
                    stack[n] = h
                    n += 1
                    is_waiting[h] = 1
