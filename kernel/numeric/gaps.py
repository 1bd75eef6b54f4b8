"""How near curves come to each other through the material.

        ___________
                    curve a        a gap counts where both curves face each other: the shortest way from a
           | gap                   sample to the other curve leaves each within 60 degrees of its normal, on
        ___v_______                the side of the material (imprints have material on both sides).
                    curve b
Neighbours at a corner do not face each other: there the way along the curves is short against the gap.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.arrays import bounds
from kernel.numeric.bins import bin_edges
from kernel.numeric.compiled import compiled
from kernel.numeric.size_grid import spread

_FACING = 0.5
"""Cosine of the widest angle from the normal."""
_CORNER = 6.0
"""Curves that meet within this many gaps are a corner, not a gap: corners under 19 degrees count as gaps."""
_MOST_CELLS = 1000000


@compiled
def gaps_between(points, start, end, curve, along, first, last, length, is_boundary, reach, period):
    """Least gap at each point, (n_point,), `reach` where none is smaller.

    points: (n_point, 2) samples of all curves, end to end; start, end: (n_segment,) int32 pieces between them.
    curve: (n_point,) int32; along: (n_point,) arc length from the curve's start. first, last: (n_curve,) int32 vertex
    numbers; length: (n_curve,); is_boundary: (n_curve,) uint8, such curves run with the material on their left.
    period: of x, 0 for none.
    """
    n_point = len(points)
    gap = np.full(n_point, reach)
    normal = np.zeros((n_point, 2))  # mean of the pieces at each sample, to the left
    for s in range(len(start)):
        dx = points[end[s], 0] - points[start[s], 0]
        dy = points[end[s], 1] - points[start[s], 1]
        piece = math.hypot(dx, dy) + 1e-300
        for v in (start[s], end[s]):
            normal[v, 0] -= dy / piece
            normal[v, 1] += dx / piece
    x_low, y_low, x1, y1 = bounds(points)
    x0 = x_low - reach
    y0 = y_low - reach
    n_x = int((x1 - x0) / reach) + 3
    n_y = int((y1 - y0) / reach) + 3
    offset, pieces = bin_edges(points, start, end, x0, y0, reach, n_x, n_y)
    n_turn = 1 if period > 0 else 0
    for i in range(n_point):
        own = curve[i]
        norm = math.hypot(normal[i, 0], normal[i, 1]) + 1e-300
        nx = normal[i, 0] / norm
        ny = normal[i, 1] / norm
        for turn in range(-n_turn, n_turn + 1):
            px = points[i, 0] + turn * period
            py = points[i, 1]
            column = int(math.floor((px - x0) / reach))
            row = int(math.floor((py - y0) / reach))
            for jj in range(max(0, row - 1), min(n_y, row + 2)):
                for ii in range(max(0, column - 1), min(n_x, column + 2)):
                    for w in range(offset[jj * n_x + ii], offset[jj * n_x + ii + 1]):
                        a = start[pieces[w]]
                        b = end[pieces[w]]
                        ax = points[a, 0]
                        ay = points[a, 1]
                        dx = points[b, 0] - ax
                        dy = points[b, 1] - ay
                        piece2 = dx * dx + dy * dy + 1e-300
                        t = min(1.0, max(0.0, ((px - ax) * dx + (py - ay) * dy) / piece2))
                        qx = ax + t * dx - px
                        qy = ay + t * dy - py
                        distance = math.hypot(qx, qy)
                        if distance >= gap[i] or distance <= 1e-9 * reach:
                            continue
                        facing = (qx * nx + qy * ny) / distance
                        if is_boundary[own] == 0:
                            facing = abs(facing)
                        other = curve[a]
                        is_tip = is_boundary[other] == 0 and (t == 0.0 or t == 1.0)
                        faced = (qx * dy - qy * dx) / (distance * math.sqrt(piece2))
                        if is_boundary[other] == 0:
                            faced = abs(faced)
                        if facing < _FACING or (faced < _FACING and not is_tip):
                            continue
                        there = along[a] + t * math.sqrt(piece2)
                        here = along[i]
                        way = 1e300
                        if other == own:
                            way = abs(there - here)
                            if first[own] == last[own]:
                                way = min(way, length[own] - way)
                        else:
                            if first[other] == first[own]:
                                way = min(way, there + here)
                            if first[other] == last[own]:
                                way = min(way, there + length[own] - here)
                            if last[other] == first[own]:
                                way = min(way, length[other] - there + here)
                            if last[other] == last[own]:
                                way = min(way, length[other] - there + length[own] - here)
                        if way > _CORNER * distance:
                            gap[i] = distance
    return gap


@compiled
def grade_across(points, sizes, reach, growth):
    """Limit the growth of sizes from curve to curve, whatever lies between them; in place."""
    x0, y0, x1, y1 = bounds(points)
    cell = max(reach, math.sqrt((x1 - x0) * (y1 - y0) / _MOST_CELLS))
    n_x = int((x1 - x0) / cell) + 1
    n_y = int((y1 - y0) / cell) + 1
    wanted = np.full(n_x * n_y, 1e300)
    for i in range(len(points)):
        q = int((points[i, 1] - y0) / cell) * n_x + int((points[i, 0] - x0) / cell)
        wanted[q] = min(wanted[q], sizes[i])
    spread(wanted, cell, n_x, n_y, growth)
    for i in range(len(points)):
        q = int((points[i, 1] - y0) / cell) * n_x + int((points[i, 0] - x0) / cell)
        sizes[i] = min(sizes[i], wanted[q] + growth * cell)


@compiled
def grade_along(sizes, along, curve, first, last, n_vertex, growth):
    """Limit the growth of sizes along curves and across the vertices that they share; in place."""
    n_point = len(sizes)
    at_vertex = np.full(n_vertex, 1e300)
    for _ in range(3):
        for i in range(n_point):
            is_first = i == 0 or curve[i - 1] != curve[i]
            if is_first:
                sizes[i] = min(sizes[i], at_vertex[first[curve[i]]])
            else:
                sizes[i] = min(sizes[i], sizes[i - 1] + growth * (along[i] - along[i - 1]))
            if i == n_point - 1 or curve[i + 1] != curve[i]:
                v = last[curve[i]]
                sizes[i] = min(sizes[i], at_vertex[v])
                at_vertex[v] = sizes[i]
        for i in range(n_point - 1, -1, -1):
            if i < n_point - 1 and curve[i + 1] == curve[i]:
                sizes[i] = min(sizes[i], sizes[i + 1] + growth * (along[i + 1] - along[i]))
            if i == 0 or curve[i - 1] != curve[i]:
                v = first[curve[i]]
                sizes[i] = min(sizes[i], at_vertex[v])
                at_vertex[v] = sizes[i]
