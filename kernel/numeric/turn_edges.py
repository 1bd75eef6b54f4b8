r"""The worst quads mended by turning an edge: tried, smoothed about, and kept only if the worst there got better.

c--b--f      quad a, b, c, d and its neighbour b, a, e, f share the edge a-b. Their hexagon a e f b c d is cut
|  |  |      along a-b, and can be cut along c-e or along d-f as well. That moves the excess of edges at a and b
d--a--e      to nodes that have too few, which smoothing alone cannot.
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.smooth_quads import MOST_ABOUT, corner_shape, gather_quad, quad_sine, quads_about, search_place

_GAIN = 0.01
"""Least gain of the worst corner shape for which a turned edge is kept."""
_ROUNDS = 3
_MOST_LOCAL = 64


@compiled
def _worst_local(nodes, quads, local, n_local):
    """Worst corner shape of the local quads."""
    worst = 2.0
    for m in range(n_local):
        i = local[m]
        for j in range(4):
            a = quads[i, (j + 3) % 4]
            b = quads[i, j]
            c = quads[i, (j + 1) % 4]
            worst = min(
                worst,
                corner_shape(nodes[a, 0], nodes[a, 1], nodes[b, 0], nodes[b, 1], nodes[c, 0], nodes[c, 1]),
            )
    return worst


@compiled
def _relax(nodes, quads, local, n_local, hexagon, is_fixed, star):
    """Pattern search of the hexagon's free nodes on the worst corner shape about each, in place. star: scratch."""
    for _ in range(_ROUNDS):
        for k in range(6):
            v = np.int64(hexagon[k])
            if is_fixed[v] != 0:
                continue
            n = 0
            for m in range(n_local):
                for j in range(4):
                    if quads[local[m], j] == v and n < len(star):
                        gather_quad(nodes, quads, local[m], j, star, n)
                        n += 1
            search_place(nodes, star, n, v, 2.0)


@compiled
def turn_edges(nodes, quads, is_fixed, under, most):
    """Mend quads whose scaled Jacobian is below `under`, `most` of them at most; in place. Returns edges turned.

    Edges between two fixed nodes stay, since they may be the region's own.
    """
    n_quad = len(quads)
    offset, incidence = quads_about(quads, len(nodes))
    is_stale = np.zeros(n_quad, np.uint8)  # near a turned edge: offset and incidence are out of date there
    local = np.empty(_MOST_LOCAL, np.int32)
    hexagon = np.empty(6, np.int32)
    star = np.empty((MOST_ABOUT, 6))
    places = np.empty((6, 2))
    found = np.empty((6, 2))
    n_turned = 0
    n_tried = 0
    for i in range(n_quad):
        if is_stale[i] != 0 or n_tried >= most or quad_sine(nodes, quads, i) >= under:
            continue
        n_tried += 1
        gain = _GAIN
        kept_k = -1
        kept = np.zeros(8, np.int32)
        kept_hexagon = np.zeros(6, np.int32)
        for j in range(4):
            a = quads[i, j]
            b = quads[i, (j + 1) % 4]
            if is_fixed[a] != 0 and is_fixed[b] != 0:
                continue
            k = -1
            at = 0
            for w in range(offset[b], offset[b + 1]):
                if quads[incidence[w] // 4, (incidence[w] % 4 + 1) % 4] == a:
                    k = incidence[w] // 4
                    at = incidence[w] % 4
            if k < 0 or is_stale[k] != 0:
                continue
            c = quads[i, (j + 2) % 4]
            d = quads[i, (j + 3) % 4]
            e = quads[k, (at + 2) % 4]
            f = quads[k, (at + 3) % 4]
            hexagon[0] = a
            hexagon[1] = e
            hexagon[2] = f
            hexagon[3] = b
            hexagon[4] = c
            hexagon[5] = d
            n_local = np.int64(0)
            is_free = True
            for m in range(6):
                v = hexagon[m]
                places[m, 0] = nodes[v, 0]
                places[m, 1] = nodes[v, 1]
                for w in range(offset[v], offset[v + 1]):
                    q = incidence[w] // 4
                    is_new = True
                    for p in range(n_local):
                        if local[p] == q:
                            is_new = False
                    if is_new:
                        if n_local == _MOST_LOCAL or is_stale[q] != 0:
                            is_free = False
                            break
                        local[n_local] = q
                        n_local += 1
            if not is_free:
                continue
            before = _worst_local(nodes, quads, local, n_local)
            for way in range(2):
                turned = (a, e, c, d, e, f, b, c) if way == 0 else (f, b, c, d, a, e, f, d)
                for m in range(4):
                    quads[i, m] = turned[m]
                    quads[k, m] = turned[m + 4]
                _relax(nodes, quads, local, n_local, hexagon, is_fixed, star)
                after = _worst_local(nodes, quads, local, n_local)
                if after > before + gain:
                    gain = after - before
                    kept_k = k
                    for m in range(8):
                        kept[m] = turned[m]
                    for m in range(6):
                        kept_hexagon[m] = hexagon[m]
                        found[m, 0] = nodes[hexagon[m], 0]
                        found[m, 1] = nodes[hexagon[m], 1]
                for m in range(6):
                    nodes[hexagon[m], 0] = places[m, 0]
                    nodes[hexagon[m], 1] = places[m, 1]
            own = (a, b, c, d, b, a, e, f)
            for m in range(4):
                quads[i, (j + m) % 4] = own[m]
                quads[k, (at + m) % 4] = own[m + 4]
        if kept_k < 0:
            continue
        for m in range(4):
            quads[i, m] = kept[m]
            quads[kept_k, m] = kept[m + 4]
        for m in range(6):
            v = kept_hexagon[m]
            nodes[v, 0] = found[m, 0]
            nodes[v, 1] = found[m, 1]
            for w in range(offset[v], offset[v + 1]):
                is_stale[incidence[w] // 4] = 1
        n_turned += 1
    return n_turned
