r"""Lone triangles near to each other joined: they and the quads between them are cut anew, into quads alone.

        b---c              b---c          Two lone triangles (a b f and c d e) with one quad between fill a
       /|   |\            /     \         hexagon. Two quads fill it as well, in three ways; with two quads
      a |   | d    ->    a-------d        between it is an octagon, which three quads fill in twelve ways.
       \|   |/            \     /
        f---e              f---e
A way counts if its quads are good enough, and is taken if it costs less than what was there: where the elements about
a node share its angle evenly, each corner costs 1 - sin of its share; a triangle, which will be cut in three, has such
a node in its middle.

Works on a triangulation and the mates found by match; polygons whose rim passes a node twice are left.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import following, preceding
from kernel.numeric.match import quad_scaled_jacobian

_LEAST = 0.45
"""Scaled Jacobian from which a quad is taken: smoothing makes it better."""
_FLAT = math.cos(math.radians(135.0))
"""No quad has a corner of more than this between two sides that stay, such as two chords of one arc: split in four it
would have one of nearly 180 degrees, which no smoothing makes better."""
_SHAPE_WEIGHT = 0.5
"""Of two ways that cost alike the one with the better worst quad is taken."""
_CENTRE = 3 * (1 - math.sin(2 * math.pi / 3))
"""The cost of a lone triangle's middle."""
_MOST_BETWEEN = 2
_MOST_SIDES = 2 * _MOST_BETWEEN + 4
_MOST_TRIANGLES = 2 * _MOST_BETWEEN + 2


def _ways(sides: list[int]) -> list[list[tuple[int, int, int, int]]]:
    """All ways to cut a polygon of an even number of sides into quads."""
    if len(sides) == 2:
        return [[]]
    found = []
    for i in range(1, len(sides) - 2, 2):  # the quad that has the last side
        for j in range(i + 1, len(sides) - 1, 2):
            own = (sides[0], sides[i], sides[j], sides[-1])
            for before in _ways(sides[: i + 1]):
                for amid in _ways(sides[i : j + 1]):
                    found += [[own, *before, *amid, *after] for after in _ways(sides[j:])]
    return found


_WAYS = np.zeros((_MOST_BETWEEN + 1, 12, _MOST_BETWEEN + 1, 4), np.int64)
_N_WAY = np.array([len(_ways(list(range(2 * k + 4)))) for k in range(_MOST_BETWEEN + 1)])
for _k in range(_MOST_BETWEEN + 1):
    _WAYS[_k, : _N_WAY[_k], : _k + 1] = _ways(list(range(2 * _k + 4)))


@compiled
def _corner_cost(corners, angle):
    """Cost of a node where `corners` elements meet (a triangle counts 2/3) in `angle` right angles."""
    return corners * (1 - math.sin(0.5 * math.pi * min(2.0, angle / max(corners, 1e-9))))


@compiled
def _shares(points, corner, twin, mate, n_triangle):
    """By node: the corners that meet there (a triangle's count 2/3), and the right angles that they fill."""
    corners = np.zeros(len(points))
    angle = np.zeros(len(points))
    for t in range(n_triangle):
        for k in range(3):
            e = 3 * t + k
            v = corner[e]
            a = corner[following(e)]
            b = corner[preceding(e)]
            ax = points[a, 0] - points[v, 0]
            ay = points[a, 1] - points[v, 1]
            bx = points[b, 0] - points[v, 0]
            by = points[b, 1] - points[v, 1]
            angle[v] += math.atan2(ax * by - ay * bx, ax * bx + ay * by) / (0.5 * math.pi)
            if mate[t] < 0:
                corners[v] += 2 / 3
            else:  # the ends of the edge between mates are corners of one quad, seen from both
                corners[v] += 1.0 if e == preceding(np.int64(mate[t])) else 0.5
    return corners, angle


@compiled
def _rim(corner, twin, lock, is_in, first, rim, most):
    """The half-edges about the triangles that is_in marks, counter-clockwise from `first`, in rim; their number.

    0 where there are more than `most`, a node comes twice, or an edge of the rim has marked triangles on both sides.
    """
    n = 0
    e = first
    while True:
        if n == most or (twin[e] >= 0 and is_in[twin[e] // 3] != 0):
            return 0
        for k in range(n):
            if corner[rim[k]] == corner[e]:
                return 0
        rim[n] = e
        n += 1
        e = following(e)
        while lock[e] == 0 and twin[e] >= 0 and is_in[twin[e] // 3] != 0:
            e = following(np.int64(twin[e]))
        if e == first:
            return n


@compiled
def _recut(corner, twin, lock, leaving, mate, triangles, rim, n_side, way):
    """Cut the polygon into the quads of `way`, two of its triangles each; in place."""
    nodes = np.empty(_MOST_SIDES, np.int32)
    twins = np.empty(_MOST_SIDES, np.int32)
    locks = np.empty(_MOST_SIDES, np.uint8)
    for k in range(n_side):
        nodes[k] = corner[rim[k]]
        twins[k] = twin[rim[k]]
        locks[k] = lock[rim[k]]
    inner_from = np.empty(3 * _MOST_TRIANGLES, np.int64)
    inner_to = np.empty(3 * _MOST_TRIANGLES, np.int64)
    inner = np.empty(3 * _MOST_TRIANGLES, np.int64)
    n_inner = 0
    for m in range(n_side // 2 - 1):
        for half in range(2):
            t = np.int64(triangles[2 * m + half])
            for k in range(3):
                e = 3 * t + k
                # corners 0 1 2 of the quad, then 0 2 3
                u = way[m, k if half == 0 or k == 0 else k + 1]
                v = way[m, (k + 1) % 3 if half == 0 or k == 2 else k + 2]
                corner[e] = nodes[u]
                if v == (u + 1) % n_side:
                    twin[e] = twins[u]
                    lock[e] = locks[u]
                    if twins[u] >= 0:
                        twin[twins[u]] = e
                    leaving[nodes[u]] = e
                    continue
                lock[e] = 0
                twin[e] = -1
                for w in range(n_inner):
                    if inner_from[w] == v and inner_to[w] == u:
                        twin[e] = inner[w]
                        twin[inner[w]] = e
                inner_from[n_inner] = u
                inner_to[n_inner] = v
                inner[n_inner] = e
                n_inner += 1
            mate[t] = 3 * t + (2 if half == 0 else 0)


@compiled
def _is_flat(points, corner, lock, rim, n_side, way):
    """Whether one of the quads (way: (n, 4) positions on the rim) has a flat corner between two locked sides."""
    for m in range(n_side // 2 - 1):
        for k in range(4):
            u = way[m, (k + 3) % 4]
            v = way[m, k]
            w = way[m, (k + 1) % 4]
            if v != (u + 1) % n_side or w != (v + 1) % n_side or lock[rim[u]] == 0 or lock[rim[v]] == 0:
                continue
            a = corner[rim[u]]
            b = corner[rim[v]]
            c = corner[rim[w]]
            ux = points[a, 0] - points[b, 0]
            uy = points[a, 1] - points[b, 1]
            vx = points[c, 0] - points[b, 0]
            vy = points[c, 1] - points[b, 1]
            if ux * vx + uy * vy < _FLAT * math.sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy)):
                return True
    return False


@compiled
def _join(points, corner, twin, lock, leaving, mate, triangles, n, rim, corners, angle, less, own):
    """Cut the polygon of n triangles in the best way, if that is better than what is there."""
    n_side = n + 2
    n_quad = n // 2
    before = 2 * _CENTRE
    for k in range(n_side):
        v = corner[rim[k]]
        mine = 0.0
        for m in range(n):
            t = np.int64(triangles[m])
            for c in range(3):
                e = 3 * t + c
                if corner[e] == v:
                    if mate[t] < 0:
                        mine += 2 / 3
                    else:
                        mine += 1.0 if e == preceding(np.int64(mate[t])) else 0.5
        less[k] = corners[v] - mine
        before += _corner_cost(corners[v], angle[v])
    best = -1
    least = before - 1e-9
    for w in range(_N_WAY[n_quad - 1]):
        worst = 1.0
        for k in range(n_side):
            own[k] = 0.0
        for m in range(n_quad):
            a = corner[rim[_WAYS[n_quad - 1, w, m, 0]]]
            b = corner[rim[_WAYS[n_quad - 1, w, m, 1]]]
            c = corner[rim[_WAYS[n_quad - 1, w, m, 2]]]
            d = corner[rim[_WAYS[n_quad - 1, w, m, 3]]]
            quality = quad_scaled_jacobian(
                points[a, 0], points[a, 1], points[b, 0], points[b, 1],
                points[c, 0], points[c, 1], points[d, 0], points[d, 1],
            )  # fmt: skip
            worst = min(worst, quality)
            for k in range(4):
                own[_WAYS[n_quad - 1, w, m, k]] += 1.0
        if worst < _LEAST or _is_flat(points, corner, lock, rim, n_side, _WAYS[n_quad - 1, w]):
            continue
        cost = _SHAPE_WEIGHT * (1 - worst)
        for k in range(n_side):
            cost += _corner_cost(less[k] + own[k], angle[corner[rim[k]]])
        if cost < least:
            least = cost
            best = w
    if best < 0:
        return False
    for k in range(n_side):
        v = corner[rim[k]]
        corners[v] = less[k]
    for m in range(n_quad):
        for k in range(4):
            corners[corner[rim[_WAYS[n_quad - 1, best, m, k]]]] += 1.0
    _recut(corner, twin, lock, leaving, mate, triangles, rim, n_side, _WAYS[n_quad - 1, best])
    return True


@compiled
def join_lone(points, corner, twin, lock, leaving, mate, n_triangle):
    """Join pairs of lone triangles where that is better; corner, twin, lock, leaving and mate in place.

    Returns the number of pairs joined. leaving keeps to what halfedge says of it only where nodes are not on the rim
    of the region.
    """
    corners, angle = _shares(points, corner, twin, mate, n_triangle)
    is_in = np.zeros(n_triangle, np.uint8)
    seen = np.full(n_triangle, -1, np.int32)
    reached_by = np.full(n_triangle, -1, np.int32)  # the half-edge of the cell before
    queue = np.empty(n_triangle, np.int32)
    steps = np.empty(n_triangle, np.int32)
    triangles = np.empty(_MOST_TRIANGLES, np.int64)
    rim = np.empty(_MOST_SIDES, np.int64)
    less = np.empty(_MOST_SIDES)  # corners at the polygon's nodes, without its own
    own = np.empty(_MOST_SIDES)
    n_joined = 0
    for root in range(n_triangle):
        if mate[root] >= 0:
            continue
        queue[0] = root
        seen[root] = root
        steps[0] = 0
        head = 0
        tail = 1
        is_joined = False
        while head < tail and not is_joined:
            t = np.int64(queue[head])
            n_step = steps[head]
            head += 1
            for half in range(2):
                if half == 1 and mate[t] < 0:
                    break
                from_t = t if half == 0 else np.int64(twin[mate[t]] // 3)
                for k in range(3):
                    e = 3 * from_t + k
                    if twin[e] < 0 or lock[e] != 0 or is_joined:
                        continue
                    u = np.int64(twin[e] // 3)
                    if seen[u] == root:
                        continue
                    if mate[u] >= 0:
                        if n_step < _MOST_BETWEEN:
                            seen[u] = root
                            seen[twin[mate[u]] // 3] = root
                            reached_by[u] = e
                            reached_by[twin[mate[u]] // 3] = e
                            queue[tail] = u
                            steps[tail] = n_step + 1
                            tail += 1
                        continue
                    n = 0  # another lone triangle: gather the polygon
                    triangles[n] = u
                    n += 1
                    through = e
                    while True:
                        w = np.int64(through // 3)
                        triangles[n] = w
                        n += 1
                        if mate[w] < 0:
                            break
                        triangles[n] = twin[mate[w]] // 3
                        n += 1
                        through = np.int64(reached_by[w])
                    for m in range(n):
                        is_in[triangles[m]] = 1
                    first = np.int64(-1)
                    for c in range(3):
                        g = 3 * u + c
                        if g != twin[e] and (twin[g] < 0 or lock[g] != 0 or is_in[twin[g] // 3] == 0):
                            first = g
                    n_side = 0
                    if first >= 0:
                        n_side = _rim(corner, twin, lock, is_in, first, rim, n + 2)
                    for m in range(n):
                        is_in[triangles[m]] = 0
                    if n_side != n + 2:
                        continue
                    is_joined = _join(
                        points, corner, twin, lock, leaving, mate, triangles, n, rim, corners, angle, less, own
                    )
                    if is_joined:
                        n_joined += 1
    return n_joined
