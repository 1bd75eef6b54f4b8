r"""Changes of connectivity: nodes of three or four triangles removed, valences evened, sharp corners kept.

A free inner node of valence 3 is taken out by merging its triangles; one of valence 4 after a flip:

         c                  c
        /|\                / \
       / v \      ->       /   \
      a--|--b             a-----b
       \ | /               \   /
         d                   d
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import CORNER, flip, following, preceding, rewind_to_hull
from kernel.numeric.smooth_triangles import quality_of

_LEAST_QUALITY = 0.25
_LEAST_FLIP_QUALITY = 0.35


@compiled
def lock_sharp_corners(points, corner, twin, lock, leaving, n_node, most_angle):
    """Where two triangles share a sharp corner, turn their edge so that one triangle fills it, and lock it.

    most_angle: radians; wider corners are left.
    """
    for v in range(n_node):
        start = np.int64(leaving[v])
        if start < 0 or twin[start] >= 0:
            continue
        e = np.int64(twin[preceding(start)])
        if e < 0 or lock[e] != 0 or twin[preceding(e)] >= 0:
            continue  # not exactly two triangles
        a = corner[following(start)]
        c = corner[following(e)]
        b = corner[preceding(e)]
        ux = points[a, 0] - points[v, 0]
        uy = points[a, 1] - points[v, 1]
        wx = points[b, 0] - points[v, 0]
        wy = points[b, 1] - points[v, 1]
        cross = ux * wy - uy * wx
        if cross <= 0 or math.atan2(cross, ux * wx + uy * wy) > most_angle:
            continue
        abx = points[b, 0] - points[a, 0]
        aby = points[b, 1] - points[a, 1]
        if abx * (points[c, 1] - points[a, 1]) - aby * (points[c, 0] - points[a, 0]) >= 0:
            continue  # c must lie beyond the line a-b
        flip(corner, twin, lock, leaving, e)
        lock[e] = CORNER
        lock[twin[e]] = CORNER
        rewind_to_hull(corner, twin, leaving, np.int64(v))
        rewind_to_hull(corner, twin, leaving, np.int64(a))
        rewind_to_hull(corner, twin, leaving, np.int64(b))


@compiled
def _merge_three(corner, twin, lock, leaving, v):
    """Merge the three triangles about v into the first; the other two get corner -1."""
    e0 = np.int64(leaving[v])
    e1 = np.int64(twin[preceding(e0)])
    e2 = np.int64(twin[preceding(e1)])
    t = e0 // 3
    outer = (following(e0), following(e1), following(e2))
    nodes = (corner[outer[0]], corner[outer[1]], corner[outer[2]])
    twins = (twin[outer[0]], twin[outer[1]], twin[outer[2]])
    locks = (lock[outer[0]], lock[outer[1]], lock[outer[2]])
    for k in range(3):
        corner[3 * t + k] = nodes[k]
        twin[3 * t + k] = twins[k]
        lock[3 * t + k] = locks[k]
        if twins[k] >= 0:
            twin[twins[k]] = 3 * t + k
    for dead in (e1 // 3, e2 // 3):
        for k in range(3):
            corner[3 * dead + k] = -1
            twin[3 * dead + k] = -1
            lock[3 * dead + k] = 1
    for k in range(3):
        leaving[nodes[k]] = 3 * t + k
        rewind_to_hull(corner, twin, leaving, np.int64(nodes[k]))
    leaving[v] = -1


@compiled
def remove_low_valence(points, corner, twin, lock, leaving, n_triangle, is_fixed, n_node):
    """Remove free inner nodes of valence 3 and 4; returns the new number of triangles (renumbered)."""
    n_removed = 0
    for v in range(n_node):
        start = np.int64(leaving[v])
        if is_fixed[v] != 0 or start < 0:
            continue
        valence = 0
        is_bound = False
        e = start
        while True:
            valence += 1
            if lock[e] != 0:
                is_bound = True
            e = np.int64(twin[preceding(e)])
            if e < 0:
                is_bound = True
                break
            if e == start or valence > 4:
                break
        if is_bound or valence > 4:
            continue
        if valence == 4:
            best = np.int64(-1)
            best_quality = _LEAST_QUALITY
            e = start
            for _ in range(4):
                f = np.int64(twin[e])
                b = corner[following(e)]
                c = corner[preceding(e)]
                d = corner[preceding(f)]
                opposite = corner[following(np.int64(twin[preceding(np.int64(twin[preceding(e)]))]))]
                quality = min(quality_of(points, d, b, c), quality_of(points, c, opposite, d))
                if quality > best_quality:
                    best_quality = quality
                    best = e
                e = np.int64(twin[preceding(e)])
            if best < 0:
                continue
            flip(corner, twin, lock, leaving, best)
            rewind = np.int64(leaving[v])
            if corner[rewind] != v:
                continue
        _merge_three(corner, twin, lock, leaving, np.int64(v))
        n_removed += 1
    if n_removed == 0:
        return n_triangle
    new_number = np.full(n_triangle, -1, np.int32)
    n = 0
    for t in range(n_triangle):
        if corner[3 * t] >= 0:
            new_number[t] = n
            n += 1
    for t in range(n_triangle):
        if new_number[t] < 0:
            continue
        for k in range(3):
            e = 3 * t + k
            new = 3 * new_number[t] + k
            f = twin[e]
            corner[new] = corner[e]
            lock[new] = lock[e]
            twin[new] = -1 if f < 0 else 3 * new_number[f // 3] + f % 3
    for v in range(n_node):
        if leaving[v] >= 0:
            leaving[v] = 3 * new_number[leaving[v] // 3] + leaving[v] % 3
    return n


@compiled
def even_valences(points, corner, twin, lock, leaving, n_triangle, n_node):
    """Flip inner edges where that brings valences nearer to six and spoils no triangle."""
    valence = np.zeros(n_node, np.int32)
    is_hull = np.zeros(n_node, np.uint8)
    for e in range(3 * n_triangle):
        valence[corner[e]] += 1
        if twin[e] < 0:
            is_hull[corner[e]] = 1
            is_hull[corner[following(e)]] = 1
    for e in range(3 * n_triangle):
        f = np.int64(twin[e])
        if f < e or lock[e] != 0:
            continue
        a = corner[e]
        b = corner[f]
        c = corner[preceding(e)]
        d = corner[preceding(f)]
        if is_hull[a] != 0 or is_hull[b] != 0 or is_hull[c] != 0 or is_hull[d] != 0:
            continue
        # sum of (valence - 6)^2 before minus after, a and b losing one, c and d gaining one
        gain = 2 * (valence[a] + valence[b] - valence[c] - valence[d]) - 4
        if gain <= 0:
            continue
        if min(quality_of(points, d, c, a), quality_of(points, c, d, b)) > _LEAST_FLIP_QUALITY:
            flip(corner, twin, lock, leaving, e)
            valence[a] -= 1
            valence[b] -= 1
            valence[c] += 1
            valence[d] += 1
