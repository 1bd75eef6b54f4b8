"""A cross field on a grid of square cells: along the region's edges where there are any, smooth in between.

A cross (four directions, 90 degrees apart) at angle a is kept as cos 4a, sin 4a. Cells that edges pass hold the mean
of their directions; the others relax to a screened Laplace equation that pulls towards the dominant direction, so
that a plate far from its holes is meshed straight.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.compiled import compiled
from kernel.numeric.size_grid import bilinear

_SWEEPS = 60
_OVER_RELAXATION = 1.7
_COHERENT = 0.5
"""A cell whose edges run every way (a hole no larger than the cell) does not steer the field: the mean direction's
length, of 1 for straight edges, must reach this."""


@compiled
def cross_field(points, start, end, cell, x0, y0, n_x, n_y, dominant_cos, dominant_sin, screen):
    """cos 4a and sin 4a by cell, (n_x n_y,) each; see bins for the cells.

    screen: weight of the dominant direction against a neighbour cell, 0 for none.
    """
    n = n_x * n_y
    field_cos = np.zeros(n)
    field_sin = np.zeros(n)
    total = np.zeros(n)
    is_given = np.zeros(n, np.uint8)
    for i in range(len(start)):
        ax = points[start[i], 0]
        ay = points[start[i], 1]
        dx = points[end[i], 0] - ax
        dy = points[end[i], 1] - ay
        length = math.hypot(dx, dy)
        angle = 4 * math.atan2(dy, dx)
        n_sample = max(2, int(4 * length / cell) + 1)
        for j in range(n_sample):
            t = (j + 0.5) / n_sample
            q = int((ay + t * dy - y0) / cell) * n_x + int((ax + t * dx - x0) / cell)
            field_cos[q] += math.cos(angle) * length / n_sample
            field_sin[q] += math.sin(angle) * length / n_sample
            total[q] += length / n_sample
            is_given[q] = 1
    for q in range(n):
        if is_given[q] != 0:
            norm = math.hypot(field_cos[q], field_sin[q])
            if norm > _COHERENT * total[q]:
                field_cos[q] /= norm
                field_sin[q] /= norm
            else:
                is_given[q] = 0
    # first guess: the nearest given cell, by four sweeps
    nearest = np.full(n, -1, np.int32)
    distance2 = np.full(n, 1e18)
    for q in range(n):
        if is_given[q] != 0:
            nearest[q] = q
            distance2[q] = 0.0
    for sweep in range(4):
        for row in range(n_y):
            j = row if sweep % 2 == 0 else n_y - 1 - row
            for column in range(n_x):
                i = column if sweep < 2 else n_x - 1 - column
                q = j * n_x + i
                for dj in range(-1, 2):
                    for di in range(-1, 2):
                        if 0 <= i + di < n_x and 0 <= j + dj < n_y:
                            other = nearest[q + dj * n_x + di]
                            if other >= 0:
                                d2 = (other // n_x - j) ** 2 + (other % n_x - i) ** 2
                                if d2 < distance2[q]:
                                    distance2[q] = d2
                                    nearest[q] = other
    for q in range(n):
        if nearest[q] >= 0 and is_given[q] == 0:
            share = math.exp(-math.sqrt(distance2[q] * screen))
            field_cos[q] = share * field_cos[nearest[q]] + (1 - share) * dominant_cos
            field_sin[q] = share * field_sin[nearest[q]] + (1 - share) * dominant_sin
    weight = 1 / (4 + screen)
    for _ in range(_SWEEPS):
        for j in range(1, n_y - 1):
            for i in range(1, n_x - 1):
                q = j * n_x + i
                if is_given[q] != 0:
                    continue
                around_cos = field_cos[q - 1] + field_cos[q + 1] + field_cos[q - n_x] + field_cos[q + n_x]
                around_sin = field_sin[q - 1] + field_sin[q + 1] + field_sin[q - n_x] + field_sin[q + n_x]
                field_cos[q] += _OVER_RELAXATION * ((around_cos + screen * dominant_cos) * weight - field_cos[q])
                field_sin[q] += _OVER_RELAXATION * ((around_sin + screen * dominant_sin) * weight - field_sin[q])
    return field_cos, field_sin


@compiled
def cross_angle(px, py, field_cos, field_sin, cell, x0, y0, n_x, n_y):
    """Angle of the cross at p, radians within +-45 degrees."""
    c = bilinear(px, py, field_cos, cell, x0, y0, n_x, n_y)
    s = bilinear(px, py, field_sin, cell, x0, y0, n_x, n_y)
    return math.atan2(s, c) / 4
