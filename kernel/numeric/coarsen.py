"""The region's edges in pairs, for a coarse mesh of twice the size whose elements are then split in four.

    o---x---o---x---o      o coarse node, x the middle of a coarse edge. Chains run between vertices: points where
                           other than two edges meet, where boundary turns into imprint, or given ones. A ring
                           without a vertex starts so that its middles lie where it turns least; a round one so
                           that its coarse edges lie best along the dominant cross (see cross_field).
A chain of an odd number of edges cannot be paired: no all-quad mesh has it on its boundary by this way.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.compiled import compiled

_AS_ROUND = 0.05
"""A ring whose turning is shared evenly, within this share of it, has no corners to hold on to."""


@compiled
def _turn(points, a, b, c):
    """Angle by which a-b-c turns at b, radians, not negative."""
    ux = points[b, 0] - points[a, 0]
    uy = points[b, 1] - points[a, 1]
    vx = points[c, 0] - points[b, 0]
    vy = points[c, 1] - points[b, 1]
    return abs(math.atan2(ux * vy - uy * vx, ux * vx + uy * vy))


@compiled
def pair_edges(points, start, end, kind, is_given_vertex, dominant_cos, dominant_sin):
    """Coarse edges, (n_coarse, 6) int32, and an edge of a chain of odd number, or -1.

    Columns: start, end, middle, first and second fine edge, coarse edges of the ring (0 for what is no ring of its
    own). Coarse edges run as their fine edges do (boundaries with the region on their left). is_given_vertex:
    (n_point,) uint8, points that stay coarse nodes whatever meets there.
    """
    n_point = len(points)
    n_edge = len(start)
    offset = np.zeros(n_point + 1, np.int32)
    for i in range(n_edge):
        offset[start[i] + 1] += 1
        offset[end[i] + 1] += 1
    for v in range(n_point):
        offset[v + 1] += offset[v]
    fill = offset.copy()
    around = np.empty(2 * n_edge, np.int32)
    for i in range(n_edge):
        for v in (start[i], end[i]):
            around[fill[v]] = i
            fill[v] += 1
    is_vertex = is_given_vertex.copy()
    for v in range(n_point):
        n = offset[v + 1] - offset[v]
        if n != 2 or kind[around[offset[v]]] != kind[around[offset[v] + 1]]:
            is_vertex[v] = 1
    is_done = np.zeros(n_edge, np.uint8)
    chain = np.empty(n_edge, np.int32)
    nodes = np.empty(n_edge + 1, np.int32)
    coarse = np.empty((n_edge // 2 + 1, 6), np.int32)
    n_coarse = 0
    odd = -1
    for sweep in range(2):  # chains from vertices first, then the rings that are left
        for first in range(n_edge):
            for which in range(2):
                if is_done[first] != 0:
                    break
                origin = start[first] if which == 0 else end[first]
                if sweep == 0 and is_vertex[origin] == 0:
                    continue
                n = 0
                v = origin
                e = np.int64(first)
                while True:
                    is_done[e] = 1
                    chain[n] = e
                    nodes[n] = v
                    n += 1
                    v = end[e] if start[e] == v else start[e]
                    if v == origin or is_vertex[v] != 0:
                        break
                    e = np.int64(around[offset[v]] if around[offset[v]] != e else around[offset[v] + 1])
                nodes[n] = v
                if n % 2 == 1:
                    odd = first
                    continue
                shift = 0
                if v == origin and is_vertex[v] == 0:
                    turns = np.zeros(2)  # at even and at odd places of the ring
                    fit = np.zeros(2)  # of the coarse edges to the dominant cross, if coarse nodes are even or odd
                    for i in range(n):
                        turn = _turn(points, nodes[(i - 1) % n], nodes[i], nodes[i + 1])
                        turns[i % 2] += turn * turn
                        dx = points[nodes[(i + 2) % n], 0] - points[nodes[i], 0]
                        dy = points[nodes[(i + 2) % n], 1] - points[nodes[i], 1]
                        angle = 4 * math.atan2(dy, dx)
                        cosine = dominant_cos * math.cos(angle) + dominant_sin * math.sin(angle)
                        fit[i % 2] += math.hypot(dx, dy) * cosine
                    if abs(turns[0] - turns[1]) > _AS_ROUND * (turns[0] + turns[1]):
                        shift = 1 if turns[0] < turns[1] else 0
                    else:
                        shift = 1 if fit[1] > fit[0] * (1 + 1e-9) + 1e-9 else 0
                for i in range(0, n, 2):
                    e = np.int64(chain[i + shift])
                    f = np.int64(chain[(i + shift + 1) % n])
                    a = nodes[i + shift]
                    middle = nodes[i + shift + 1]
                    if start[e] != a:
                        e, f = f, e
                        middle = start[f] if start[f] != a else end[f]
                    coarse[n_coarse, 0] = start[e] if start[e] != middle else end[e]
                    coarse[n_coarse, 1] = start[f] if start[f] != middle else end[f]
                    coarse[n_coarse, 2] = middle
                    coarse[n_coarse, 3] = e
                    coarse[n_coarse, 4] = f
                    coarse[n_coarse, 5] = n // 2 if v == origin else 0
                    n_coarse += 1
    return coarse[:n_coarse].copy(), odd
