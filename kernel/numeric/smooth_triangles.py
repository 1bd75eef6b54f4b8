"""Smoothing of a triangulation where it is bad, and only there.

Active are the free nodes of triangles under a quality, and two rings around them. They move to the mean of their
neighbours if the worst triangle about them does not get worse than it was (or stays good enough); between passes
edges are flipped towards Delaunay if that raises the worse of the two. What stays bad is moved by pattern search.

Quality of a triangle: 4 sqrt(3) area / sum of squared edges: 1 equilateral, 0 flat.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import flip, following, preceding

_RINGS = 2
_MOST_TURNS = 20
_MOST_ABOUT = 24


@compiled
def triangle_quality(ax, ay, bx, by, cx, cy):
    """4 sqrt(3) area / sum of squared edges; negative where inverted."""
    area2 = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
    sum2 = (bx - ax) ** 2 + (by - ay) ** 2 + (cx - bx) ** 2 + (cy - by) ** 2 + (ax - cx) ** 2 + (ay - cy) ** 2
    return 3.4641016151377544 * area2 / (sum2 + 1e-300)


@compiled
def quality_of(points, a, b, c):
    """triangle_quality of three nodes."""
    return triangle_quality(points[a, 0], points[a, 1], points[b, 0], points[b, 1], points[c, 0], points[c, 1])


@compiled
def active_nodes(points, n_node, corner, leaving, n_triangle, is_fixed, threshold):
    """Free nodes within _RINGS of a triangle under `threshold`: int32."""
    is_active = np.zeros(n_node, np.uint8)
    for t in range(n_triangle):
        if quality_of(points, corner[3 * t], corner[3 * t + 1], corner[3 * t + 2]) < threshold:
            for k in range(3):
                is_active[corner[3 * t + k]] = 1
    for _ in range(_RINGS):
        before = is_active.copy()
        for e in range(3 * n_triangle):
            if before[corner[e]] != 0:
                is_active[corner[following(e)]] = 1
    active = np.empty(n_node, np.int32)
    n = 0
    for v in range(n_node):
        if is_active[v] != 0 and is_fixed[v] == 0 and leaving[v] >= 0:
            active[n] = v
            n += 1
    return active[:n].copy()


@compiled
def _worst_about(points, corner, twin, start, x, y):
    """Worst quality of the triangles about a node if it stood at x, y."""
    worst = 2.0
    e = start
    while True:
        a = corner[following(e)]
        b = corner[preceding(e)]
        worst = min(worst, triangle_quality(x, y, points[a, 0], points[a, 1], points[b, 0], points[b, 1]))
        e = np.int64(twin[preceding(e)])
        if e == start or e < 0:
            return worst


@compiled
def _flip_if_better(points, corner, twin, lock, leaving, e):
    """Flip e if the angles against it sum to more than 180 degrees and the worse triangle gets better."""
    f = np.int64(twin[e])
    if f < 0 or lock[e] != 0:
        return False
    a = corner[e]
    b = corner[f]
    c = corner[preceding(e)]
    d = corner[preceding(f)]
    ca_x = points[a, 0] - points[c, 0]
    ca_y = points[a, 1] - points[c, 1]
    cb_x = points[b, 0] - points[c, 0]
    cb_y = points[b, 1] - points[c, 1]
    da_x = points[a, 0] - points[d, 0]
    da_y = points[a, 1] - points[d, 1]
    db_x = points[b, 0] - points[d, 0]
    db_y = points[b, 1] - points[d, 1]
    cos_c = ca_x * cb_x + ca_y * cb_y
    sin_c = ca_x * cb_y - ca_y * cb_x
    cos_d = da_x * db_x + da_y * db_y
    sin_d = -(da_x * db_y - da_y * db_x)
    if sin_c * cos_d + cos_c * sin_d >= -1e-9 * (abs(sin_c * cos_d) + abs(cos_c * sin_d)):
        return False
    before = min(quality_of(points, a, b, c), quality_of(points, b, a, d))
    after = min(quality_of(points, d, c, a), quality_of(points, c, d, b))
    if after <= before:
        return False
    flip(corner, twin, lock, leaving, e)
    return True


@compiled
def smooth_triangles(points, corner, twin, lock, leaving, active, n_pass, good_enough):
    """Guarded Laplacian moves of the active nodes, and flips after every second pass; in place."""
    for number in range(n_pass):
        for i in range(len(active)):
            v = active[i]
            start = np.int64(leaving[v])
            if start < 0:
                continue
            e = start
            total_x = 0.0
            total_y = 0.0
            n_neighbour = 0
            while True:
                a = corner[following(e)]
                total_x += points[a, 0]
                total_y += points[a, 1]
                n_neighbour += 1
                e = np.int64(twin[preceding(e)])
                if e == start or e < 0:
                    break
            if e < 0:
                continue
            x = points[v, 0]
            y = points[v, 1]
            before = 2.0  # not known yet: a move that is good enough needs no comparison
            to_x = total_x / n_neighbour
            to_y = total_y / n_neighbour
            for _attempt in range(3):
                worst = _worst_about(points, corner, twin, start, to_x, to_y)
                if worst < good_enough and before == 2.0:
                    before = _worst_about(points, corner, twin, start, x, y)
                if worst >= min(before, good_enough):
                    points[v, 0] = to_x
                    points[v, 1] = to_y
                    break
                to_x = 0.5 * (to_x + x)
                to_y = 0.5 * (to_y + y)
        if number % 2 == 0:
            continue
        for i in range(len(active)):
            v = active[i]
            e = np.int64(leaving[v])
            for _turn in range(_MOST_TURNS):
                if e < 0:
                    break
                if _flip_if_better(points, corner, twin, lock, leaving, e):
                    e = np.int64(leaving[v])
                    continue
                e = np.int64(twin[preceding(e)])
                if e == leaving[v]:
                    break


@compiled
def _gather(points, corner, twin, start, ring):
    """The edges a-b against a node, as rows ax ay bx by |ab|^2 of ring; their number, 0 for too many or a hull."""
    n = 0
    e = start
    while n < len(ring):
        a = corner[following(e)]
        b = corner[preceding(e)]
        ring[n, 0] = points[a, 0]
        ring[n, 1] = points[a, 1]
        ring[n, 2] = points[b, 0]
        ring[n, 3] = points[b, 1]
        ring[n, 4] = (points[b, 0] - points[a, 0]) ** 2 + (points[b, 1] - points[a, 1]) ** 2
        n += 1
        e = np.int64(twin[preceding(e)])
        if e == start:
            return n
        if e < 0:
            return 0
    return 0


@compiled
def _smallest_sine2(ring, n, first, x, y, floor):
    """Squared sine, with its sign, of the smallest angle about a node if it stood at x, y; and its row of ring.

    Rows from `first` on are looked at; one at or under `floor` is returned as it is: such a place is of no use.
    """
    worst = 2.0
    worst_row = first
    for k in range(n):
        row = first + k if first + k < n else first + k - n
        ux = ring[row, 0] - x
        uy = ring[row, 1] - y
        vx = ring[row, 2] - x
        vy = ring[row, 3] - y
        u2 = ux * ux + uy * uy
        v2 = vx * vx + vy * vy
        w2 = ring[row, 4]
        cross = ux * vy - uy * vx
        sine2 = cross * abs(cross) / (max(u2 * v2, max(v2 * w2, w2 * u2)) + 1e-300)
        if sine2 < worst:
            worst = sine2
            worst_row = row
            if worst <= floor:
                break
    return worst, worst_row


@compiled
def _is_settled(corner, twin, start, moved_in, number):
    """True where neither the node that half-edge `start` leaves nor a neighbour has moved since its last turn."""
    if moved_in[corner[start]] >= number - 1:
        return False
    e = start
    while True:
        if moved_in[corner[following(e)]] >= number - 1:
            return False
        e = np.int64(twin[preceding(e)])
        if e == start or e < 0:
            return True


@compiled
def raise_smallest_angles(points, corner, twin, leaving, active, threshold, n_pass):
    """Pattern search on nodes whose smallest angle has a sine under `threshold`; in place."""
    ring = np.empty((_MOST_ABOUT, 5))
    moved_in = np.full(len(points), -1, np.int32)  # the last pass that moved a node
    for number in range(n_pass):
        for i in range(len(active)):
            v = active[i]
            start = np.int64(leaving[v])
            if start < 0 or (number > 0 and _is_settled(corner, twin, start, moved_in, number)):
                continue
            x = points[v, 0]
            y = points[v, 1]
            n = _gather(points, corner, twin, start, ring)
            if n == 0:
                continue
            best, worst_row = _smallest_sine2(ring, n, 0, x, y, -9.0)
            if best >= threshold * threshold:
                continue
            a = corner[following(start)]
            step = 0.2 * math.hypot(points[a, 0] - x, points[a, 1] - y)
            for attempt in range(6):
                best_x = x
                best_y = y
                improved = False
                for d in range(8):
                    direction = d * math.pi / 4 + 0.3 * attempt
                    to_x = x + step * math.cos(direction)
                    to_y = y + step * math.sin(direction)
                    sine, row = _smallest_sine2(ring, n, worst_row, to_x, to_y, best)
                    if sine > best:
                        best = sine
                        worst_row = row
                        best_x = to_x
                        best_y = to_y
                        improved = True
                x = best_x
                y = best_y
                if not improved:
                    step *= 0.5
            if x != points[v, 0] or y != points[v, 1]:
                moved_in[v] = number
            points[v, 0] = x
            points[v, 1] = y
