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
def worst_ratio_about(nodes, quads, offset, incidence, v, x, y):
    """Worst mean ratio of the corners about node v if it stood at x, y (the corner opposite v does not change)."""
    worst = 2.0
    for w in range(offset[v], offset[v + 1]):
        i = incidence[w] // 4
        j = incidence[w] % 4
        a = quads[i, (j + 1) % 4]
        b = quads[i, (j + 2) % 4]
        c = quads[i, (j + 3) % 4]
        ax = nodes[a, 0]
        ay = nodes[a, 1]
        bx = nodes[b, 0]
        by = nodes[b, 1]
        cx = nodes[c, 0]
        cy = nodes[c, 1]
        worst = min(worst, _corner_ratio(cx, cy, x, y, ax, ay))
        worst = min(worst, _corner_ratio(x, y, ax, ay, bx, by))
        worst = min(worst, _corner_ratio(bx, by, cx, cy, x, y))
    return worst


@compiled
def worst_shape_about(nodes, quads, offset, incidence, v, x, y):
    """Worst corner shape of the quads about node v if it stood at x, y (the corner opposite v does not change)."""
    worst = 2.0
    for w in range(offset[v], offset[v + 1]):
        i = incidence[w] // 4
        j = incidence[w] % 4
        a = quads[i, (j + 1) % 4]
        b = quads[i, (j + 2) % 4]
        c = quads[i, (j + 3) % 4]
        ax = nodes[a, 0]
        ay = nodes[a, 1]
        bx = nodes[b, 0]
        by = nodes[b, 1]
        cx = nodes[c, 0]
        cy = nodes[c, 1]
        worst = min(worst, corner_shape(cx, cy, x, y, ax, ay))
        worst = min(worst, corner_shape(x, y, ax, ay, bx, by))
        worst = min(worst, corner_shape(bx, by, cx, cy, x, y))
    return worst


@compiled
def _far_corner(quads, offset, incidence, v, neighbour):
    """The node next to `neighbour`, other than v, in the quad that has v just after `neighbour`; -1 for none."""
    for w in range(offset[v], offset[v + 1]):
        i = incidence[w] // 4
        j = incidence[w] % 4
        if quads[i, (j + 3) % 4] == neighbour:
            return quads[i, (j + 2) % 4]
    return np.int32(-1)


@compiled
def bisect_angles(nodes, quads, offset, incidence, active, n_active, n_pass, under):
    r"""Move nodes to where their spokes bisect the angles at the far ends; in place, never for the worse.

    Zhou and Shimada 2000, An angle-based approach to two-dimensional mesh smoothing. Only nodes whose worst corner
    shape is below `under` are tried.

        left            the spoke from `end` to v should halve the angle at `end` between its
          \             neighbours in the two quads that share it; v goes to the mean of what
          end - - v     its spokes wish
          /
        right
    """
    for _ in range(n_pass):
        for z in range(n_active):
            v = active[z]
            x = nodes[v, 0]
            y = nodes[v, 1]
            before = worst_shape_about(nodes, quads, offset, incidence, v, x, y)
            if before >= under:
                continue
            total_x = 0.0
            total_y = 0.0
            n_spoke = 0
            for w in range(offset[v], offset[v + 1]):
                i = incidence[w] // 4
                j = incidence[w] % 4
                end = quads[i, (j + 1) % 4]
                left = quads[i, (j + 2) % 4]
                right = _far_corner(quads, offset, incidence, v, end)
                if right < 0:
                    continue
                left_x = nodes[left, 0] - nodes[end, 0]
                left_y = nodes[left, 1] - nodes[end, 1]
                right_x = nodes[right, 0] - nodes[end, 0]
                right_y = nodes[right, 1] - nodes[end, 1]
                left_length = math.sqrt(left_x * left_x + left_y * left_y)
                right_length = math.sqrt(right_x * right_x + right_y * right_y)
                # across the difference of the two unit vectors, on the side of v
                across_x = right_y / right_length - left_y / left_length
                across_y = left_x / left_length - right_x / right_length
                across = math.sqrt(across_x * across_x + across_y * across_y) + 1e-300
                spoke_x = x - nodes[end, 0]
                spoke_y = y - nodes[end, 1]
                spoke = math.sqrt(spoke_x * spoke_x + spoke_y * spoke_y)
                if across_x * spoke_x + across_y * spoke_y < 0:
                    spoke = -spoke
                total_x += nodes[end, 0] + across_x / across * spoke
                total_y += nodes[end, 1] + across_y / across * spoke
                n_spoke += 1
            if n_spoke == 0:
                continue
            to_x = total_x / n_spoke
            to_y = total_y / n_spoke
            for _attempt in range(2):
                if worst_shape_about(nodes, quads, offset, incidence, v, to_x, to_y) >= before:
                    nodes[v, 0] = to_x
                    nodes[v, 1] = to_y
                    break
                to_x = 0.5 * (to_x + x)
                to_y = 0.5 * (to_y + y)


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
    for _ in range(n_pass):
        for z in range(n_active):
            v = active[z]
            total_x = 0.0
            total_y = 0.0
            for w in range(offset[v], offset[v + 1]):
                i = incidence[w] // 4
                j = incidence[w] % 4
                a = quads[i, (j + 1) % 4]
                b = quads[i, (j + 2) % 4]
                c = quads[i, (j + 3) % 4]
                total_x += 0.85 * (nodes[a, 0] + nodes[c, 0]) - 0.35 * nodes[b, 0]
                total_y += 0.85 * (nodes[a, 1] + nodes[c, 1]) - 0.35 * nodes[b, 1]
            x = nodes[v, 0]
            y = nodes[v, 1]
            weight = 1.35 * (offset[v + 1] - offset[v])
            to_x = total_x / weight
            to_y = total_y / weight
            before_ratio = 2.0  # not known yet: a move that is good enough needs no comparison
            for _attempt in range(3):
                ratio = worst_ratio_about(nodes, quads, offset, incidence, v, to_x, to_y)
                if ratio < good_enough and before_ratio == 2.0:
                    before_ratio = worst_ratio_about(nodes, quads, offset, incidence, v, x, y)
                if ratio >= min(before_ratio, good_enough):
                    nodes[v, 0] = to_x
                    nodes[v, 1] = to_y
                    break
                to_x = 0.5 * (to_x + x)
                to_y = 0.5 * (to_y + y)
    bisect_angles(nodes, quads, offset, incidence, active, n_active, n_bisect, bisect_under)
    for _ in range(n_search):
        for z in range(n_active):
            v = active[z]
            x = nodes[v, 0]
            y = nodes[v, 1]
            best = worst_shape_about(nodes, quads, offset, incidence, v, x, y)
            if best >= search_under:
                continue
            w = offset[v]
            a = quads[incidence[w] // 4, (incidence[w] % 4 + 1) % 4]
            step = 0.2 * math.hypot(nodes[a, 0] - x, nodes[a, 1] - y)
            for attempt in range(5):
                best_x = x
                best_y = y
                improved = False
                for d in range(8):
                    direction = d * math.pi / 4 + 0.3 * attempt
                    to_x = x + step * math.cos(direction)
                    to_y = y + step * math.sin(direction)
                    shape = worst_shape_about(nodes, quads, offset, incidence, v, to_x, to_y)
                    if shape > best:
                        best = shape
                        best_x = to_x
                        best_y = to_y
                        improved = True
                x = best_x
                y = best_y
                if not improved:
                    step *= 0.5
            nodes[v, 0] = x
            nodes[v, 1] = y
