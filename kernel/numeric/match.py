"""Triangles paired to quads: greedily by shape, then along augmenting paths.

A pair is taken only if its quad is good enough: a triangle left over and cut in three quads is better than a bad
quad cut in four. Augmenting: from a lone triangle over free-matched-free... edges to another lone one (breadth
first, bounded depth), all pairs along the path exchanged.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import preceding

_BUCKETS = 256


@compiled
def quad_scaled_jacobian(ax, ay, bx, by, cx, cy, dx, dy):
    """Smallest sine of the corners of quad a, b, c, d (counter-clockwise); negative where one is reflex."""
    xs = (ax, bx, cx, dx)
    ys = (ay, by, cy, dy)
    worst = 1.0
    for i in range(4):
        j = (i + 1) % 4
        k = (i + 3) % 4
        ux = xs[j] - xs[i]
        uy = ys[j] - ys[i]
        vx = xs[k] - xs[i]
        vy = ys[k] - ys[i]
        sine = (ux * vy - uy * vx) / math.sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy) + 1e-300)
        worst = min(worst, sine)
    return worst


@compiled
def match_triangles(points, corner, twin, lock, n_triangle, least, depth):
    """For each triangle the half-edge that it shares with its mate, -1 for none: (n_triangle,) int32.

    least: smallest scaled Jacobian of a pair. depth: longest augmenting path, in pairs.
    """
    n_half = 3 * n_triangle
    mate = np.full(n_triangle, -1, np.int32)
    quality = np.full(n_half, -1.0)
    count = np.zeros(_BUCKETS + 1, np.int32)
    for e in range(n_half):
        f = twin[e]
        if f < 0 or lock[e] != 0:
            continue
        if f < e:
            quality[e] = quality[f]
            continue
        a = corner[e]
        b = corner[f]
        c = corner[preceding(e)]
        d = corner[preceding(np.int64(f))]
        q = quad_scaled_jacobian(
            points[a, 0], points[a, 1], points[d, 0], points[d, 1],
            points[b, 0], points[b, 1], points[c, 0], points[c, 1],
        )  # fmt: skip
        quality[e] = q
        if q > least:
            count[_BUCKETS - 1 - int(q * (_BUCKETS - 1)) + 1] += 1
    for k in range(_BUCKETS):
        count[k + 1] += count[k]
    order = np.empty(count[_BUCKETS], np.int32)
    for e in range(n_half):
        if twin[e] > e and lock[e] == 0 and quality[e] > least:
            k = _BUCKETS - 1 - int(quality[e] * (_BUCKETS - 1))
            order[count[k]] = e
            count[k] += 1
    for i in range(len(order)):
        e = order[i]
        t = e // 3
        u = twin[e] // 3
        if mate[t] < 0 and mate[u] < 0:
            mate[t] = e
            mate[u] = twin[e]
    seen = np.full(n_triangle, -1, np.int32)
    reached_by = np.empty(n_triangle, np.int32)  # the half-edge, in a triangle's former mate, that led to it
    queue = np.empty(n_triangle, np.int32)
    steps = np.empty(n_triangle, np.int32)
    for root in range(n_triangle):
        if mate[root] >= 0:
            continue
        head = 0
        tail = 1
        queue[0] = root
        seen[root] = root
        steps[0] = 0
        reached_by[root] = -1
        is_found = False
        while head < tail and not is_found:
            t = np.int64(queue[head])
            n_step = steps[head]
            head += 1
            if n_step >= depth:
                continue
            for k in range(3):
                e = 3 * t + k
                if twin[e] < 0 or lock[e] != 0 or quality[e] < least:
                    continue
                u = np.int64(twin[e] // 3)
                if seen[u] == root:
                    continue
                if mate[u] < 0:
                    while True:  # exchange along the path back to the root
                        through = reached_by[t]
                        former = mate[t]
                        mate[u] = twin[e]
                        mate[t] = e
                        if through < 0:
                            break
                        u = np.int64(twin[former] // 3)
                        e = np.int64(through)
                        t = e // 3
                    is_found = True
                    break
                w = np.int64(twin[mate[u]] // 3)
                if seen[w] == root:
                    continue
                seen[u] = root
                seen[w] = root
                reached_by[w] = e
                queue[tail] = w
                steps[tail] = n_step + 1
                tail += 1
    return mate
