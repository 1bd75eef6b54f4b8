"""Constrained Delaunay triangulation of a region: the steps of this package put together.

Topology is decided on integer coordinates: the region fills 2^29 of the 2^30 units of a square, in its middle; the
square's four corners are the frame that insertion starts from. Returned points keep the doubles of the input.
"""

from __future__ import annotations

import numpy as np

from kernel.numeric.arrays import bounds
from kernel.numeric.carve import carve
from kernel.numeric.compiled import compiled
from kernel.numeric.constrain import QUEUE, recover_edge, restore_delaunay
from kernel.numeric.delaunay import insert_all
from kernel.numeric.hilbert import hilbert_order

GRID_BITS = 30
_MOST_HILBERT_BITS = 11


@compiled
def to_grid(value, low, scale):
    """Grid coordinate, int64, of a coordinate: the region's lower left corner is at 2^28."""
    return np.int64(np.rint((value - low) * scale)) + (1 << (GRID_BITS - 2))


@compiled
def _hilbert_bits(n):
    bits = 1
    while (1 << (2 * bits)) < n and bits < _MOST_HILBERT_BITS:
        bits += 1
    return bits


@compiled
def triangulate(points, n_seed, start, end, kind, n_spare):
    """Constrained Delaunay triangulation of a region.

    points: (n, 2) float64, the first n_seed inserted first. start, end: (n_edge,) int32; kind: (n_edge,) uint8.
    n_spare: nodes that a refinement may add afterwards (room in the arrays).
    Returns corner, twin, lock, leaving (see halfedge), n_triangle, x, y (grid), origin (2,), scale, double_of (n,)
    int32 (-1, or the node that a point coincides with) and failed (n_edge,) uint8: 1 where an edge was not recovered.
    """
    n = len(points)
    origin = np.empty(2)
    x_low, y_low, x_high, y_high = bounds(points)
    origin[0] = x_low
    origin[1] = y_low
    extent = max(x_high - x_low, y_high - y_low)
    scale = float(1 << (GRID_BITS - 1)) / extent
    n_room = n + 4 + n_spare
    x = np.empty(n_room, np.int64)
    y = np.empty(n_room, np.int64)
    for i in range(n):
        x[i] = to_grid(points[i, 0], origin[0], scale)
        y[i] = to_grid(points[i, 1], origin[1], scale)
    side = 1 << GRID_BITS
    for k in range(4):  # frame: lower left, lower right, upper right, upper left
        x[n + k] = side if k == 1 or k == 2 else 0
        y[n + k] = side if k >= 2 else 0
    most = 2 * n_room + 8
    corner = np.empty(3 * most, np.int32)
    twin = np.full(3 * most, -1, np.int32)
    lock = np.zeros(3 * most, np.uint8)
    leaving = np.full(n_room, -1, np.int32)
    corner[0] = n
    corner[1] = n + 1
    corner[2] = n + 2
    corner[3] = n
    corner[4] = n + 2
    corner[5] = n + 3
    twin[2] = 3
    twin[3] = 2
    for e in range(6):
        leaving[corner[e]] = e
    double_of = np.full(n, -1, np.int32)
    bits = _hilbert_bits(n_seed // 2 + 1)
    order = hilbert_order(x, y, np.int64(0), n_seed, GRID_BITS - bits, bits)
    n_triangle = insert_all(x, y, order, corner, twin, lock, leaving, np.int64(2), double_of)
    if n > n_seed:
        bits = _hilbert_bits(n - n_seed)
        order = hilbert_order(x, y, n_seed, n, GRID_BITS - bits, bits)
        n_triangle = insert_all(x, y, order, corner, twin, lock, leaving, n_triangle, double_of)
    counts = np.zeros(2, np.int64)
    queue_a = np.empty(QUEUE, np.int32)
    queue_b = np.empty(QUEUE, np.int32)
    failed = np.zeros(len(start), np.uint8)
    for i in range(len(start)):
        a = np.int64(start[i])
        b = np.int64(end[i])
        if double_of[a] >= 0 or double_of[b] >= 0:
            failed[i] = 1
            continue
        met = counts[1]
        ok = recover_edge(x, y, corner, twin, lock, leaving, a, b, kind[i], queue_a, queue_b, counts)
        if not ok or counts[1] > met:
            failed[i] = 1
    if counts[0] > 0:
        restore_delaunay(x, y, corner, twin, lock, leaving, n_triangle)
    n_triangle = carve(corner, twin, lock, leaving, n_triangle, start, end, kind, n)
    return corner, twin, lock, leaving, n_triangle, x, y, origin, scale, double_of, failed
