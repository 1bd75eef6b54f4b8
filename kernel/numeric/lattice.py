r"""Inner nodes for triangles: one apex over each edge, then a hexagonal lattice wherever there is room.

        *     *     *        the lattice's rows run along the dominant direction of the boundary, and its
           *     *           first row is the apex row of the longest straight side, so that a plate's bulk
        *     *     *        is all equilateral triangles.
       /\    /\             apexes: height sqrt(3)/2 of their edge
    --o----o----o--

Degenerate cases: a boundary edge along a row (half-open crossings: each row-edge crossing counted once); an edge
longer than a cell (binned by its box); a region narrower than the clearance gets no lattice node.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.arrays import bounds, copy_points, sort_range
from kernel.numeric.bins import bin_edges, segment_distance2
from kernel.numeric.compiled import compiled
from kernel.numeric.halfedge import BOUNDARY, IMPRINT
from kernel.numeric.size_grid import bilinear

_ROW = math.sqrt(3.0) / 2.0
_EDGE_CLEARANCE = 0.62
"""Lattice nodes keep this times the size from edges, and _NODE_CLEARANCE from nodes: found by trial on plates with
holes, the smallest that leaves no sliver after smoothing."""
_NODE_CLEARANCE = 0.72
_LATTICE_LONGEST = 1.1
"""Beside long edges the lattice ends where this times the size is wanted: refinement fills the rest."""
_APEX_CLEARANCE = 0.72
"""An apex keeps this times its edge's length from other nodes, and _APEX_EDGE_CLEARANCE from other edges."""
_APEX_EDGE_CLEARANCE = 0.6


@compiled
def _is_free(px, py, nodes, head, successor, offset, edges, points, start, end, i, j, n_x, node2, edge2):
    """True where no node is nearer than sqrt(node2) and no edge nearer than sqrt(edge2), in the 3 x 3 cells about."""
    for jj in range(j - 1, j + 2):
        for ii in range(i - 1, i + 2):
            k = jj * n_x + ii
            m = head[k]
            while m >= 0:
                if (nodes[m, 0] - px) ** 2 + (nodes[m, 1] - py) ** 2 < node2:
                    return False
                m = successor[m]
            for w in range(offset[k], offset[k + 1]):
                a = start[edges[w]]
                b = end[edges[w]]
                if segment_distance2(px, py, points[a, 0], points[a, 1], points[b, 0], points[b, 1]) < edge2:
                    return False
    return True


@compiled
def place_lattice(
    points, start, end, kind, size, angle, origin_x, origin_y, is_graded, base, cell, base_x, base_y, n_base_x, n_base_y
):
    """The region's points, then the inner nodes: (n, 2) float64.

    angle: direction of the rows; origin: a node of the lattice. size: distance of its nodes. Where is_graded, the
    lattice stays out of places where more than the size is wanted. base, cell...: see size_grid.long_edge_sizes.
    """
    n_point = len(points)
    n_edge = len(start)
    cosine = math.cos(angle)
    sine = math.sin(angle)
    turned = np.empty((n_point, 2))  # the points in the lattice's own frame
    for i in range(n_point):
        dx = points[i, 0] - origin_x
        dy = points[i, 1] - origin_y
        turned[i, 0] = cosine * dx + sine * dy
        turned[i, 1] = -sine * dx + cosine * dy
    x_low, y_low, x1, y1 = bounds(turned)
    x0 = x_low - size
    y0 = y_low - size
    n_x = int((x1 - x0) / size) + 3
    n_y = int((y1 - y0) / size) + 3
    offset, edges = bin_edges(turned, start, end, x0, y0, size, n_x, n_y)

    most = n_point + 2 * n_edge
    head = np.full(n_x * n_y, -1, np.int32)  # nodes of a cell, as linked lists
    successor = np.full(most, -1, np.int32)
    nodes = np.empty((most, 2))
    copy_points(turned, nodes)
    n = 0
    for i in range(n_point):
        k = int((turned[i, 1] - y0) / size) * n_x + int((turned[i, 0] - x0) / size)
        successor[n] = head[k]
        head[k] = n
        n += 1

    for i in range(n_edge):
        for side in range(2 if kind[i] == IMPRINT else 1):
            a = start[i] if side == 0 else end[i]
            b = end[i] if side == 0 else start[i]
            dx = turned[b, 0] - turned[a, 0]
            dy = turned[b, 1] - turned[a, 1]
            length2 = dx * dx + dy * dy
            px = 0.5 * (turned[a, 0] + turned[b, 0]) - dy * _ROW
            py = 0.5 * (turned[a, 1] + turned[b, 1]) + dx * _ROW
            ci = int((px - x0) / size)
            cj = int((py - y0) / size)
            if px <= x0 + size or py <= y0 + size or ci >= n_x - 1 or cj >= n_y - 1:
                continue
            node2 = _APEX_CLEARANCE**2 * length2
            edge2 = _APEX_EDGE_CLEARANCE**2 * length2
            if _is_free(px, py, nodes, head, successor, offset, edges, turned, start, end, ci, cj, n_x, node2, edge2):
                nodes[n, 0] = px
                nodes[n, 1] = py
                k = cj * n_x + ci
                successor[n] = head[k]
                head[k] = n
                n += 1

    # where each row of the lattice enters and leaves the region
    row = size * _ROW
    first_row = int(math.floor(y0 / row))
    n_row = int(math.ceil(y1 / row)) - first_row + 1
    row_offset = np.zeros(n_row + 1, np.int32)
    crossings = np.empty(0)
    fill = row_offset
    for is_filling in range(2):
        if is_filling == 1:
            for r in range(n_row):
                row_offset[r + 1] += row_offset[r]
            crossings = np.empty(row_offset[n_row])
            fill = row_offset.copy()
        for i in range(n_edge):
            if kind[i] != BOUNDARY:
                continue
            xa = turned[start[i], 0]
            ya = turned[start[i], 1]
            xb = turned[end[i], 0]
            yb = turned[end[i], 1]
            low = min(ya, yb)
            high = max(ya, yb)
            for r in range(int(math.ceil(low / row)), int(math.ceil(high / row))):
                y = r * row
                if low <= y < high:
                    if is_filling == 0:
                        row_offset[r - first_row + 1] += 1
                    else:
                        crossings[fill[r - first_row]] = xa + (y - ya) / (yb - ya) * (xb - xa)
                        fill[r - first_row] += 1
    most_lattice = 0
    for r in range(n_row):
        sort_range(crossings, row_offset[r], row_offset[r + 1])
        for k in range(row_offset[r], row_offset[r + 1] - 1, 2):
            most_lattice += int((crossings[k + 1] - crossings[k]) / size) + 2

    n_apex = n - n_point
    inner = np.empty((n_apex + most_lattice, 2))
    m = 0
    for i in range(n_point, n):
        inner[m, 0] = nodes[i, 0]
        inner[m, 1] = nodes[i, 1]
        m += 1
    node2 = (_NODE_CLEARANCE * size) ** 2
    edge2 = (_EDGE_CLEARANCE * size) ** 2
    for r in range(n_row):
        y = (r + first_row) * row
        shift = 0.5 * size if (r + first_row) % 2 != 0 else 0.0
        for k in range(row_offset[r], row_offset[r + 1] - 1, 2):
            first = int(math.ceil((crossings[k] - shift) / size))
            last = int(math.floor((crossings[k + 1] - shift) / size))
            for q in range(first, last + 1):
                x = q * size + shift
                if is_graded:
                    here_x = origin_x + cosine * x - sine * y
                    here_y = origin_y + sine * x + cosine * y
                    here = bilinear(here_x, here_y, base, cell, base_x, base_y, n_base_x, n_base_y)
                    if here > _LATTICE_LONGEST * size:
                        continue
                ci = int((x - x0) / size)
                cj = int((y - y0) / size)
                if _is_free(x, y, nodes, head, successor, offset, edges, turned, start, end, ci, cj, n_x, node2, edge2):
                    inner[m, 0] = x
                    inner[m, 1] = y
                    m += 1
    placed = np.empty((n_point + m, 2))
    copy_points(points, placed)
    for i in range(m):
        placed[n_point + i, 0] = origin_x + cosine * inner[i, 0] - sine * inner[i, 1]
        placed[n_point + i, 1] = origin_y + sine * inner[i, 0] + cosine * inner[i, 1]
    return placed
