"""Smoothing of quads where they are bad, and only there.

Active are the free nodes of quads under a scaled Jacobian, and a few rings about them. First they move towards the
mean of their neighbours, blended with the corners that would complete parallelograms (which pulls towards squares);
a move stays if the worst corner about the node is not worse than before, or good enough. Then angles are bisected,
and a pattern search lifts what is still bad. Aspect enters both measures: with angles alone it reaches 16.

    c---b      node v of quad v, a, b, c: parallelogram completion a + c - b
    |   |
    v---a
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.compiled import compiled

MOST_ABOUT = 16
"""Nodes of more quads stay where they are."""
_FIRST_STEP = 0.2
_STEPS = 5
_DIRECTIONS = 8
_TURN = 0.3
"""The pattern search: first step as a share of an edge, tries, directions, and the turn of these from try to try."""
_ANGLES = np.arange(_DIRECTIONS) * math.pi / 4 + _TURN * np.arange(_STEPS)[:, None]
_COSINES = np.cos(_ANGLES)
_SINES = np.sin(_ANGLES)
_RATIO_WEIGHT = 1.5
"""The pattern search weighs aspect less than angles: a rectangle of 1 to 2.6 counts as a corner of 45 degrees."""


@compiled
def quads_about(quads, n_node):
    """Quads by node: offset (n_node + 1,) and incidence, 4 * quad + corner, int32."""
    offset = np.zeros(n_node + 1, np.int32)
    for i in range(len(quads)):
        for j in range(4):
            offset[quads[i, j] + 1] += 1
    for v in range(n_node):
        offset[v + 1] += offset[v]
    fill = offset.copy()
    incidence = np.empty(offset[n_node], np.int32)
    for i in range(len(quads)):
        for j in range(4):
            v = quads[i, j]
            incidence[fill[v]] = 4 * i + j
            fill[v] += 1
    return offset, incidence


@compiled
def corner_sine(ax, ay, bx, by, cx, cy):
    """Sine of the corner at b of a, b, c: its share of the scaled Jacobian."""
    ux = cx - bx
    uy = cy - by
    vx = ax - bx
    vy = ay - by
    return (ux * vy - uy * vx) / math.sqrt((ux * ux + uy * uy) * (vx * vx + vy * vy) + 1e-300)


@compiled
def _corner_ratio(ax, ay, bx, by, cx, cy):
    """Mean ratio of the corner at b, 2 u x v / (u^2 + v^2): 1 for a square's, never above the sine."""
    ux = cx - bx
    uy = cy - by
    vx = ax - bx
    vy = ay - by
    return 2 * (ux * vy - uy * vx) / (ux * ux + uy * uy + vx * vx + vy * vy + 1e-300)


@compiled
def corner_shape(ax, ay, bx, by, cx, cy):
    """The smaller of the corner's sine and _RATIO_WEIGHT times its mean ratio."""
    ux = cx - bx
    uy = cy - by
    vx = ax - bx
    vy = ay - by
    area = ux * vy - uy * vx
    u2 = ux * ux + uy * uy
    v2 = vx * vx + vy * vy
    return min(area / math.sqrt(u2 * v2 + 1e-300), 2 * _RATIO_WEIGHT * area / (u2 + v2 + 1e-300))


@compiled
def quad_sine(nodes, quads, i):
    """Scaled Jacobian of quad i."""
    worst = 2.0
    for j in range(4):
        a = quads[i, (j + 3) % 4]
        b = quads[i, j]
        c = quads[i, (j + 1) % 4]
        worst = min(worst, corner_sine(nodes[a, 0], nodes[a, 1], nodes[b, 0], nodes[b, 1], nodes[c, 0], nodes[c, 1]))
    return worst


@compiled
def quad_sines(nodes, quads):
    """Scaled Jacobian of every quad, (n_quad,)."""
    sines = np.empty(len(quads))
    for i in range(len(quads)):
        sines[i] = quad_sine(nodes, quads, i)
    return sines


@compiled
def gather_quad(nodes, quads, i, j, star, k):
    """Row k of star: ax ay bx by cx cy of quad i, which is v, a, b, c from its corner j on."""
    a = quads[i, (j + 1) % 4]
    b = quads[i, (j + 2) % 4]
    c = quads[i, (j + 3) % 4]
    star[k, 0] = nodes[a, 0]
    star[k, 1] = nodes[a, 1]
    star[k, 2] = nodes[b, 0]
    star[k, 3] = nodes[b, 1]
    star[k, 4] = nodes[c, 0]
    star[k, 5] = nodes[c, 1]


@compiled
def _gather(nodes, quads, offset, incidence, v, star):
    """The quads about node v as rows of star; their number, 0 where they are too many."""
    n = offset[v + 1] - offset[v]
    if n > len(star):
        return 0
    for k in range(n):
        place = incidence[offset[v] + k]
        gather_quad(nodes, quads, place // 4, place % 4, star, k)
    return n


@compiled
def _worst_ratio(star, n, x, y, floor):
    """Worst mean ratio of the corners about a node if it stood at x, y (the ones opposite do not change).

    What is found first at or under `floor` is returned as it is: such a place is of no use.
    """
    worst = 2.0
    for k in range(n):
        worst = min(worst, _corner_ratio(star[k, 4], star[k, 5], x, y, star[k, 0], star[k, 1]))
        worst = min(worst, _corner_ratio(x, y, star[k, 0], star[k, 1], star[k, 2], star[k, 3]))
        worst = min(worst, _corner_ratio(star[k, 2], star[k, 3], star[k, 4], star[k, 5], x, y))
        if worst <= floor:
            return worst
    return worst


@compiled
def _worst_shape(star, n, x, y, floor):
    """Worst corner shape likewise."""
    worst = 2.0
    for k in range(n):
        worst = min(worst, corner_shape(star[k, 4], star[k, 5], x, y, star[k, 0], star[k, 1]))
        worst = min(worst, corner_shape(x, y, star[k, 0], star[k, 1], star[k, 2], star[k, 3]))
        worst = min(worst, corner_shape(star[k, 2], star[k, 3], star[k, 4], star[k, 5], x, y))
        if worst <= floor:
            return worst
    return worst


@compiled
def _average(nodes, star, n, v, good_enough):
    """Move node v towards the mean of its neighbours, parallelograms completed; in place, hardly for the worse."""
    total_x = 0.0
    total_y = 0.0
    for k in range(n):
        total_x += 0.85 * (star[k, 0] + star[k, 4]) - 0.35 * star[k, 2]
        total_y += 0.85 * (star[k, 1] + star[k, 5]) - 0.35 * star[k, 3]
    x = nodes[v, 0]
    y = nodes[v, 1]
    to_x = total_x / (1.35 * n)
    to_y = total_y / (1.35 * n)
    before = 2.0  # not known yet: a move that is good enough needs no comparison
    for _attempt in range(3):
        ratio = _worst_ratio(star, n, to_x, to_y, -1.0)
        if ratio < good_enough and before == 2.0:
            before = _worst_ratio(star, n, x, y, -1.0)
        if ratio >= min(before, good_enough):
            nodes[v, 0] = to_x
            nodes[v, 1] = to_y
            return
        to_x = 0.5 * (to_x + x)
        to_y = 0.5 * (to_y + y)


@compiled
def _bisect(nodes, star, n, v, under):
    r"""Move node v to where its spokes bisect the angles at their far ends; in place, never for the worse.

    Zhou and Shimada 2000, An angle-based approach to two-dimensional mesh smoothing. Only a node whose worst corner
    shape is below `under` is tried.

        left            the spoke from `end` to v should halve the angle at `end` between its
          \             neighbours in the two quads that share it; v goes to the mean of what
          end - - v     its spokes wish
          /
        right
    """
    x = nodes[v, 0]
    y = nodes[v, 1]
    before = _worst_shape(star, n, x, y, -1.0)
    if before >= under:
        return
    total_x = 0.0
    total_y = 0.0
    n_spoke = 0
    for k in range(n):
        end_x = star[k, 0]
        end_y = star[k, 1]
        other = -1  # the quad on the spoke's other side
        for m in range(n):
            if star[m, 4] == end_x and star[m, 5] == end_y:
                other = m
        if other < 0:
            continue
        left_x = star[k, 2] - end_x
        left_y = star[k, 3] - end_y
        right_x = star[other, 2] - end_x
        right_y = star[other, 3] - end_y
        left_length = math.sqrt(left_x * left_x + left_y * left_y)
        right_length = math.sqrt(right_x * right_x + right_y * right_y)
        # across the difference of the two unit vectors, on the side of v
        across_x = right_y / right_length - left_y / left_length
        across_y = left_x / left_length - right_x / right_length
        across = math.sqrt(across_x * across_x + across_y * across_y) + 1e-300
        spoke_x = x - end_x
        spoke_y = y - end_y
        spoke = math.sqrt(spoke_x * spoke_x + spoke_y * spoke_y)
        if across_x * spoke_x + across_y * spoke_y < 0:
            spoke = -spoke
        total_x += end_x + across_x / across * spoke
        total_y += end_y + across_y / across * spoke
        n_spoke += 1
    if n_spoke == 0:
        return
    to_x = total_x / n_spoke
    to_y = total_y / n_spoke
    for _attempt in range(2):
        if _worst_shape(star, n, to_x, to_y, -1.0) >= before:
            nodes[v, 0] = to_x
            nodes[v, 1] = to_y
            return
        to_x = 0.5 * (to_x + x)
        to_y = 0.5 * (to_y + y)


@compiled
def search_place(nodes, star, n, v, under):
    """Pattern search for the place where the worst corner shape about node v is best; in place. True if it moved.

    Only a node whose worst corner shape is below `under` is tried.
    """
    x = nodes[v, 0]
    y = nodes[v, 1]
    best = _worst_shape(star, n, x, y, -1.0)
    if best >= under:
        return False
    step = _FIRST_STEP * math.sqrt((star[0, 0] - x) ** 2 + (star[0, 1] - y) ** 2)
    for attempt in range(_STEPS):
        best_x = x
        best_y = y
        improved = False
        for d in range(_DIRECTIONS):
            to_x = x + step * _COSINES[attempt, d]
            to_y = y + step * _SINES[attempt, d]
            shape = _worst_shape(star, n, to_x, to_y, best)
            if shape > best:
                best = shape
                best_x = to_x
                best_y = to_y
                improved = True
        x = best_x
        y = best_y
        if not improved:
            step *= 0.5
    has_moved = nodes[v, 0] != x or nodes[v, 1] != y
    nodes[v, 0] = x
    nodes[v, 1] = y
    return has_moved


@compiled
def _is_settled(quads, offset, incidence, v, moved_in, number):
    """True where neither node v nor any node of its quads has moved since v was looked at last."""
    for w in range(offset[v], offset[v + 1]):
        for j in range(4):
            if moved_in[quads[incidence[w] // 4, j]] >= number - 1:
                return False
    return True


@compiled
def smooth_quads(
    nodes, quads, is_fixed, n_pass, n_bisect, n_search, active_under, good_enough, bisect_under, search_under, n_ring
):
    """Move the free nodes, in place: n_pass Laplacian, n_bisect angle-bisecting and n_search pattern-search passes.

    active_under: scaled Jacobian of the quads that wake their nodes, and n_ring rings about them; good_enough: mean
    ratio from which a Laplacian move needs no comparison; bisect_under, search_under: corner shapes to be raised.
    """
    n_node = len(nodes)
    offset, incidence = quads_about(quads, n_node)
    is_active = np.zeros(n_node, np.uint8)
    for i in range(len(quads)):
        if quad_sine(nodes, quads, i) < active_under:
            for j in range(4):
                is_active[quads[i, j]] = 1
    for _ in range(n_ring):
        before = is_active.copy()
        for i in range(len(quads)):
            if before[quads[i, 0]] + before[quads[i, 1]] + before[quads[i, 2]] + before[quads[i, 3]] > 0:
                for j in range(4):
                    is_active[quads[i, j]] = 1
    active = np.empty(n_node, np.int32)
    n_active = np.int64(0)
    for v in range(n_node):
        if is_active[v] != 0 and is_fixed[v] == 0 and offset[v + 1] > offset[v]:
            active[n_active] = v
            n_active += 1
    star = np.empty((MOST_ABOUT, 6))
    moved_in = np.full(n_node, -1, np.int32)  # the last pass of the search that moved a node
    first_search = n_pass + n_bisect
    for number in range(first_search + n_search):
        for z in range(n_active):
            v = active[z]
            if number > first_search and _is_settled(quads, offset, incidence, v, moved_in, number):
                continue
            n = _gather(nodes, quads, offset, incidence, v, star)
            if n == 0:
                continue
            if number < n_pass:
                _average(nodes, star, n, v, good_enough)
            elif number < first_search:
                _bisect(nodes, star, n, v, bisect_under)
            elif search_place(nodes, star, n, v, search_under):
                moved_in[v] = number
