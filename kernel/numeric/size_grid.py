r"""A wanted size on a grid of square cells: that of the edges beside them, elsewhere the size asked for.

long edge ____
              \______________         beside long edges as long, then shrinking to the size by `growth` per unit of
                    size     \____    distance; beside short ones as short, then growing likewise. Where both meet
                       short edge     the short ones win.

Cell (i, j) covers x0 + i cell .. x0 + (i+1) cell; its number is j n_x + i.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.arrays import bounds
from kernel.numeric.compiled import compiled

_SHORT = 0.8
_LONG = 1.25
"""Edges under and over these shares of the size are meant: the mesh is graded towards them."""
_FLOOR = 0.7
"""Beside an edge at least this times its length is wanted, however short the edges at its ends: it cannot be divided,
and what is much smaller than it would stand on it in a fan."""
_MOST_FINER = 16
_MOST_CELLS = 1000000

_DIAGONAL = 1.4142135623730951


@compiled
def spread(wanted, cell, n_x, n_y, growth):
    """Limit the growth from cell to cell, in place: four sweeps in every direction, as for a distance map.

    wanted: (n_x n_y,), cell (i, j) at j n_x + i.
    """
    straight = growth * cell
    slanted = straight * _DIAGONAL
    for sweep in range(4):
        step_j = 1 if sweep % 2 == 0 else -1
        step_i = 1 if sweep < 2 else -1
        for row in range(n_y):
            j = row if step_j > 0 else n_y - 1 - row
            for column in range(n_x):
                i = column if step_i > 0 else n_x - 1 - column
                q = j * n_x + i
                least = wanted[q]
                has_i = 0 <= i - step_i < n_x
                has_j = 0 <= j - step_j < n_y
                if has_i:
                    least = min(least, wanted[q - step_i] + straight)
                if has_j:
                    least = min(least, wanted[q - step_j * n_x] + straight)
                    if has_i:
                        least = min(least, wanted[q - step_j * n_x - step_i] + slanted)
                    if 0 <= i + step_i < n_x:
                        least = min(least, wanted[q - step_j * n_x + step_i] + slanted)
                wanted[q] = least


@compiled
def bilinear(px, py, values, cell, x0, y0, n_x, n_y):
    """Cell values, taken at cell centres, interpolated at p."""
    u = (px - x0) / cell - 0.5
    v = (py - y0) / cell - 0.5
    i = min(max(int(math.floor(u)), 0), n_x - 2)
    j = min(max(int(math.floor(v)), 0), n_y - 2)
    u -= i
    v -= j
    q = j * n_x + i
    lower = (1 - u) * values[q] + u * values[q + 1]
    upper = (1 - u) * values[q + n_x] + u * values[q + n_x + 1]
    return (1 - v) * lower + v * upper


@compiled
def _mark(wanted, points, start, end, i, value, is_most, cell, x0, y0, n_x):
    """Give the cells along edge i at most `value`, or at least that where is_most is 0; in place."""
    ax = points[start[i], 0]
    ay = points[start[i], 1]
    dx = points[end[i], 0] - ax
    dy = points[end[i], 1] - ay
    n_sample = int(math.hypot(dx, dy) / cell) + 1
    for k in range(n_sample):
        t = (k + 0.5) / n_sample
        q = int((ay + t * dy - y0) / cell) * n_x + int((ax + t * dx - x0) / cell)
        wanted[q] = min(wanted[q], value) if is_most != 0 else max(wanted[q], value)


@compiled
def long_edge_sizes(points, start, end, size, growth, x0, y0, cell, n_x, n_y):
    """Sizes by cell, (n_x n_y,): beside edges longer than the size theirs, shrinking to the size away from them."""
    wanted = np.full(n_x * n_y, size)
    is_graded = False
    for i in range(len(start)):
        length = math.hypot(points[end[i], 0] - points[start[i], 0], points[end[i], 1] - points[start[i], 1])
        if length > _LONG * size:
            _mark(wanted, points, start, end, i, length, 0, cell, x0, y0, n_x)
            is_graded = True
    if is_graded:  # limits from above are limits from below of what is negative
        for q in range(n_x * n_y):
            wanted[q] = -wanted[q]
        spread(wanted, cell, n_x, n_y, growth)
        for q in range(n_x * n_y):
            wanted[q] = -wanted[q]
    return wanted, is_graded


@compiled
def base_grid(points, start, end, size, growth):
    """long_edge_sizes of a region on a grid of its own: sizes, is_graded, cell, x0, y0, n_x, n_y."""
    x0, y0, x1, y1 = bounds(points)
    cell = max(size, math.sqrt((x1 - x0) * (y1 - y0) / _MOST_CELLS))
    n_x = int((x1 - x0) / cell) + 2
    n_y = int((y1 - y0) / cell) + 2
    wanted, is_graded = long_edge_sizes(points, start, end, size, growth, x0, y0, cell, n_x, n_y)
    return wanted, is_graded, cell, x0, y0, n_x, n_y


@compiled
def size_grid(points, start, end, size, x0, y0, x1, y1, growth):
    """Sizes by cell, (n_x n_y,), the cells' side and numbers, and False where all are `size`.

    growth: bounds the change from cell to cell, but for the cells that edges pass (see _FLOOR). Cells as small as short
    edges ask for, but not so many that the grid costs more than the mesh.
    """
    smallest = size
    for i in range(len(start)):
        a = start[i]
        b = end[i]
        smallest = min(smallest, math.hypot(points[b, 0] - points[a, 0], points[b, 1] - points[a, 1]))
    finer = 1
    if smallest < _SHORT * size:
        n_coarse = (x1 - x0) * (y1 - y0) / (size * size)
        most = _MOST_CELLS + 4 * n_coarse
        while finer < _MOST_FINER and size / finer > 2 * smallest and n_coarse * (2 * finer) ** 2 < most:
            finer *= 2
    cell = size / finer
    n_x = int((x1 - x0) / cell) + 1
    n_y = int((y1 - y0) / cell) + 1
    wanted, is_graded = long_edge_sizes(points, start, end, size, growth, x0, y0, cell, n_x, n_y)
    if is_graded or smallest < _SHORT * size:
        for i in range(len(start)):
            length = math.hypot(points[end[i], 0] - points[start[i], 0], points[end[i], 1] - points[start[i], 1])
            if is_graded or length < _SHORT * size:
                _mark(wanted, points, start, end, i, length, 1, cell, x0, y0, n_x)
        spread(wanted, cell, n_x, n_y, growth)
        is_graded = True
        for i in range(len(start)):
            length = math.hypot(points[end[i], 0] - points[start[i], 0], points[end[i], 1] - points[start[i], 1])
            _mark(wanted, points, start, end, i, _FLOOR * length, 0, cell, x0, y0, n_x)
    return wanted, cell, n_x, n_y, is_graded
