"""Small loops that numba compiles in a tenth of the time that numpy's general forms take."""

from __future__ import annotations

from kernel.numeric.compiled import compiled


@compiled
def bounds(points):
    """Least x, least y, greatest x, greatest y of (n, 2) points."""
    x_low = points[0, 0]
    y_low = points[0, 1]
    x_high = x_low
    y_high = y_low
    for i in range(1, len(points)):
        x_low = min(x_low, points[i, 0])
        y_low = min(y_low, points[i, 1])
        x_high = max(x_high, points[i, 0])
        y_high = max(y_high, points[i, 1])
    return x_low, y_low, x_high, y_high


@compiled
def copy_points(source, target):
    """First rows of target from those of source, both (n, 2)."""
    for i in range(len(source)):
        target[i, 0] = source[i, 0]
        target[i, 1] = source[i, 1]


@compiled
def sort_range(values, first, last):
    """values[first:last] in increasing order, by insertion: a lattice's row has few crossings."""
    for i in range(first + 1, last):
        value = values[i]
        k = i - 1
        while k >= first and values[k] > value:
            values[k + 1] = values[k]
            k -= 1
        values[k + 1] = value
