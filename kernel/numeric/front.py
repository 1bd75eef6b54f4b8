"""A square front: coarse nodes grow from the region's nodes along the four arms of the cross field.

            o           each node tries a step of one size along its four arms; a candidate stays
            |           if no node lies in the square about it (turned with the cross, half side
        o---p---o       _NODE_CLEARANCE sizes), no edge nearer than _EDGE_CLEARANCE, and it is inside.
            |
            o           Straight boundaries go first and curved ones last, so that the regular mesh of the
                        plate runs up to the holes and the irregular nodes gather at them. Holes
                        of four coarse edges fit in as squares: they grow a ring of their own before all.

Sizes come from a grid of their own (see size_grid): the front is graded between short and long edges.
Degenerate cases: a candidate across an edge is refused by an exact crossing test; inside or outside is told by the
side of the nearest boundary edge (of two equally near, the one whose line is farther: a corner's true side).
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.arrays import bounds, copy_points
from kernel.numeric.bins import bin_edges, segment_distance2
from kernel.numeric.compiled import compiled
from kernel.numeric.cross_field import cross_angle, cross_field
from kernel.numeric.halfedge import BOUNDARY
from kernel.numeric.size_grid import bilinear, size_grid

_NODE_CLEARANCE = 0.7
_EDGE_CLEARANCE = 0.6
_TAKEN = 0.45
"""A candidate this near to a node, before the field has turned it, is refused without further questions."""
_QUARTER = math.pi / 2
_FINEST_BIN = 3
_COARSEST_BIN = -3
"""Bins of graded fronts have sides of size / 2^k, k between these."""
EARLY = 0
LATE = 1
RING = 2
"""When a region's node grows. RING: before all others, one ring of nodes that then waits for the late ones."""


@compiled
def _is_inside_and_free(
    x, y, parent, angle, node2, edge2, nodes, head, successor, offset, edges, start, end, kind, i0, i1, j0, j1, n_x
):
    """True where the candidate (x, y), grown from `parent`, may stay. node2: half side of its square.

    i0 to i1, j0 to j1: columns and rows of the bins where it looks for nodes and edges.
    """
    cosine = math.cos(angle)
    sine = math.sin(angle)
    nearest2 = 1e300
    side = 1.0
    from_x = nodes[parent, 0]
    from_y = nodes[parent, 1]
    for jj in range(j0, j1 + 1):
        for ii in range(i0, i1 + 1):
            k = jj * n_x + ii
            m = head[k]
            while m >= 0:
                ux = nodes[m, 0] - x
                uy = nodes[m, 1] - y
                if max(abs(cosine * ux + sine * uy), abs(-sine * ux + cosine * uy)) < node2:
                    return False
                m = successor[m]
            for w in range(offset[k], offset[k + 1]):
                e = edges[w]
                a = start[e]
                b = end[e]
                ax = nodes[a, 0]
                ay = nodes[a, 1]
                bx = nodes[b, 0]
                by = nodes[b, 1]
                distance2 = segment_distance2(x, y, ax, ay, bx, by)
                if distance2 < edge2:
                    return False
                here = (bx - ax) * (y - ay) - (by - ay) * (x - ax)
                there = (bx - ax) * (from_y - ay) - (by - ay) * (from_x - ax)
                if parent != a and parent != b and here * there < 0:
                    left = (x - from_x) * (ay - from_y) - (y - from_y) * (ax - from_x)
                    right = (x - from_x) * (by - from_y) - (y - from_y) * (bx - from_x)
                    if left * right < 0:
                        return False
                if kind[e] == BOUNDARY:
                    off = here / (math.hypot(bx - ax, by - ay) + 1e-300)
                    if distance2 < nearest2 * (1 - 1e-9):
                        nearest2 = distance2
                        side = off
                    elif distance2 < nearest2 * (1 + 1e-9) and abs(off) > abs(side):
                        side = off
    return side > 0


@compiled
def _is_taken(x, y, reach, nodes, head, successor, x0, y0, side, n_x, n_y):
    """True where a node lies within `reach` of (x, y), inside the grid: most candidates are refused by this.

    Beside edges much longer than the size, `reach` goes past the grid's border.
    """
    j1 = min(n_y - 1, int((y + reach - y0) / side))
    i1 = min(n_x - 1, int((x + reach - x0) / side))
    for j in range(max(0, int((y - reach - y0) / side)), j1 + 1):
        for i in range(max(0, int((x - reach - x0) / side)), i1 + 1):
            m = head[j * n_x + i]
            while m >= 0:
                if (nodes[m, 0] - x) ** 2 + (nodes[m, 1] - y) ** 2 < reach * reach:
                    return True
                m = successor[m]
    return False


@compiled
def _bin_side(wanted, size):
    """The side of bins, size / 2^k, in which a graded front finds its neighbours with the least work."""
    best = size
    least = 1e300
    for k in range(_COARSEST_BIN, _FINEST_BIN + 1):
        side = size * 2.0**-k
        work = 0.0
        for q in range(len(wanted)):
            # nodes per cell of the field, times bins that each looks at, times 1 and the nodes in each
            share = side / wanted[q]
            work += (2 / share + 1) ** 2 * (1 + share * share) / (wanted[q] * wanted[q])
        if work < least:
            least = work
            best = side
    return best


@compiled
def grow_front(points, start, end, kind, order, size, dominant_cos, dominant_sin, screen, growth):
    """The region's coarse points (n_point, 2), then the nodes grown: (n, 2).

    order: (n_point,) uint8, EARLY, LATE or RING. size: of coarse edges.
    """
    n_point = len(points)
    x_low, y_low, x_high, y_high = bounds(points)
    x0 = x_low - 2 * size
    y0 = y_low - 2 * size
    n_x = int((x_high - x0) / size) + 4
    n_y = int((y_high - y0) / size) + 4
    field_cos, field_sin = cross_field(points, start, end, size, x0, y0, n_x, n_y, dominant_cos, dominant_sin, screen)
    wanted, fine, fine_x, fine_y, is_graded = size_grid(
        points, start, end, size, x0, y0, x0 + n_x * size, y0 + n_y * size, growth
    )
    side = size
    bin_x = n_x
    bin_y = n_y
    if is_graded:
        side = _bin_side(wanted, size)
        bin_x = int(n_x * size / side) + 1
        bin_y = int(n_y * size / side) + 1
    offset, edges = bin_edges(points, start, end, x0, y0, side, bin_x, bin_y)
    most = 4 * n_point + 100
    room = 0.0
    for q in range(fine_x * fine_y):
        room += 3 * (fine / wanted[q]) ** 2
    most += int(room)
    nodes = np.empty((most, 2))
    angles = np.empty(most)
    successor = np.full(most, -1, np.int32)
    head = np.full(bin_x * bin_y, -1, np.int32)
    tangent_cos = np.zeros(n_point)
    tangent_sin = np.zeros(n_point)
    for i in range(len(start)):
        a = start[i]
        b = end[i]
        angle = 4 * math.atan2(points[b, 1] - points[a, 1], points[b, 0] - points[a, 0])
        for v in (a, b):
            tangent_cos[v] += math.cos(angle)
            tangent_sin[v] += math.sin(angle)
    queue = np.empty(2 * most, np.int32)
    late = np.empty(most, np.int32)
    of_ring = np.zeros(most, np.uint8)  # 1 grows a ring, 2 is part of one
    tail = 0
    n_late = 0
    copy_points(points, nodes)
    for i in range(n_point):
        if tangent_cos[i] ** 2 + tangent_sin[i] ** 2 > 0.1:
            angles[i] = math.atan2(tangent_sin[i], tangent_cos[i]) / 4
        else:
            angles[i] = cross_angle(points[i, 0], points[i, 1], field_cos, field_sin, size, x0, y0, n_x, n_y)
        k = int((points[i, 1] - y0) / side) * bin_x + int((points[i, 0] - x0) / side)
        successor[i] = head[k]
        head[k] = i
        if order[i] == RING:
            queue[tail] = i
            tail += 1
            of_ring[i] = 1
    for i in range(n_point):
        if order[i] == EARLY:
            queue[tail] = i
            tail += 1
        elif order[i] == LATE:
            late[n_late] = i
            n_late += 1
    n = n_point
    first = 0
    while n < most:
        if first == tail:
            if n_late == 0:
                break
            for i in range(n_late):
                queue[tail] = late[i]
                tail += 1
                of_ring[late[i]] = 0
            n_late = 0
        p = np.int64(queue[first])
        first += 1
        if of_ring[p] == 2:
            late[n_late] = p
            n_late += 1
            continue
        px = nodes[p, 0]
        py = nodes[p, 1]
        step = size
        if is_graded:
            step = bilinear(px, py, wanted, fine, x0, y0, fine_x, fine_y)
        along_x = step * math.cos(angles[p])
        along_y = step * math.sin(angles[p])
        for d in range(4):
            x = px + along_x
            y = py + along_y
            along_x, along_y = -along_y, along_x
            if x < x0 + size or y < y0 + size or x >= x0 + (n_x - 1) * size or y >= y0 + (n_y - 1) * size:
                continue
            if _is_taken(x, y, _TAKEN * step, nodes, head, successor, x0, y0, side, bin_x, bin_y):
                continue
            if p >= n_point:  # half way the field may have turned: take the arm from there
                middle = cross_angle(0.5 * (px + x), 0.5 * (py + y), field_cos, field_sin, size, x0, y0, n_x, n_y)
                arm = angles[p] + d * _QUARTER
                arm = middle + _QUARTER * np.rint((arm - middle) / _QUARTER)
                x = px + step * math.cos(arm)
                y = py + step * math.sin(arm)
            if x < x0 + size or y < y0 + size or x >= x0 + (n_x - 1) * size or y >= y0 + (n_y - 1) * size:
                continue
            angle = cross_angle(x, y, field_cos, field_sin, size, x0, y0, n_x, n_y)
            here = size
            if is_graded:
                here = bilinear(x, y, wanted, fine, x0, y0, fine_x, fine_y)
            node2 = _NODE_CLEARANCE * here
            edge2 = (_EDGE_CLEARANCE * here) ** 2
            reach = max(step, here)
            i0 = max(0, int((x - reach - x0) / side))
            i1 = min(bin_x - 1, int((x + reach - x0) / side))
            j0 = max(0, int((y - reach - y0) / side))
            j1 = min(bin_y - 1, int((y + reach - y0) / side))
            if not _is_inside_and_free(
                x, y, p, angle, node2, edge2, nodes, head, successor, offset, edges, start, end, kind, i0, i1, j0, j1,
                bin_x,
            ):  # fmt: skip
                continue
            if n >= most:
                break
            nodes[n, 0] = x
            nodes[n, 1] = y
            angles[n] = angle
            if of_ring[p] == 1:
                of_ring[n] = 2
            k = int((y - y0) / side) * bin_x + int((x - x0) / side)
            successor[n] = head[k]
            head[k] = n
            queue[tail] = n
            tail += 1
            n += 1
    return nodes[:n].copy()
