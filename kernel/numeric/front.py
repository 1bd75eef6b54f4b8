"""A square front: coarse nodes grow from the region's nodes along the four arms of the cross field.

            o           each node tries a step of one size along its four arms; a candidate stays
            |           if no node lies in the square about it (turned with the cross, half side
        o---p---o       _NODE_CLEARANCE sizes), no edge nearer than _EDGE_CLEARANCE, and it is inside.
            |
            o           Straight boundaries go first and curved ones last, so that the regular mesh of the
                        plate runs up to the holes and the irregular nodes gather at them. Holes
                        of four coarse edges fit in as squares: they grow a ring of their own before all.

Sizes: the lengths of short edges, growing by `growth` per unit of distance from them, on a grid of their own.
Degenerate cases: a candidate across an edge is refused by an exact crossing test; inside or outside is told by the
side of the nearest boundary edge (of two equally near, the one whose line is farther: a corner's true side).
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.arrays import bounds, copy_points
from kernel.numeric.bins import bin_edges, segment_distance2
from kernel.numeric.compiled import compiled
from kernel.numeric.cross_field import bilinear, cross_angle, cross_field
from kernel.numeric.halfedge import BOUNDARY
from kernel.numeric.size_grid import spread

_NODE_CLEARANCE = 0.7
_EDGE_CLEARANCE = 0.6
_SHORT = 0.8
"""Edges under this share of the size are meant: the mesh is graded towards them."""
_MOST_FINER = 16
_MOST_CELLS = 1000000
_QUARTER = math.pi / 2
EARLY = 0
LATE = 1
RING = 2
"""When a region's node grows. RING: before all others, one ring of nodes that then waits for the late ones."""


@compiled
def size_grid(points, start, end, size, x0, y0, x1, y1, growth):
    """Wanted size by cell of a grid of its own, with its cells' side and numbers, and the smallest size.

    The lengths of short edges, growing by `growth` per unit of distance. Cells as small as short edges ask for, but
    not so many that the grid costs more than the mesh.
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
    wanted = np.full(n_x * n_y, size)
    if smallest < _SHORT * size:
        for i in range(len(start)):
            ax = points[start[i], 0]
            ay = points[start[i], 1]
            dx = points[end[i], 0] - ax
            dy = points[end[i], 1] - ay
            length = math.hypot(dx, dy)
            if length < _SHORT * size:
                n_sample = int(length / cell) + 1
                for k in range(n_sample):
                    t = (k + 0.5) / n_sample
                    q = int((ay + t * dy - y0) / cell) * n_x + int((ax + t * dx - x0) / cell)
                    wanted[q] = min(wanted[q], length)
        spread(wanted, cell, n_x, n_y, growth)
    return wanted, cell, n_x, n_y, smallest < _SHORT * size


@compiled
def _is_inside_and_free(
    x, y, parent, angle, node2, edge2, nodes, head, successor, offset, edges, start, end, kind, i, j, n_x
):
    """True where the candidate (x, y) in cell (i, j), grown from `parent`, may stay. node2: half side of its square."""
    cosine = math.cos(angle)
    sine = math.sin(angle)
    nearest2 = 1e300
    side = 1.0
    from_x = nodes[parent, 0]
    from_y = nodes[parent, 1]
    for jj in range(j - 1, j + 2):
        for ii in range(i - 1, i + 2):
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
    offset, edges = bin_edges(points, start, end, x0, y0, size, n_x, n_y)
    most = 4 * n_point + 100
    room = 0.0
    for q in range(fine_x * fine_y):
        room += 3 * (fine / wanted[q]) ** 2
    most += int(room)
    nodes = np.empty((most, 2))
    angles = np.empty(most)
    successor = np.full(most, -1, np.int32)
    head = np.full(n_x * n_y, -1, np.int32)
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
        k = int((points[i, 1] - y0) / size) * n_x + int((points[i, 0] - x0) / size)
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
        for d in range(4):
            arm = angles[p] + d * _QUARTER
            x = px + step * math.cos(arm)
            y = py + step * math.sin(arm)
            if p >= n_point:  # half way the field may have turned: take the arm from there
                middle = cross_angle(0.5 * (px + x), 0.5 * (py + y), field_cos, field_sin, size, x0, y0, n_x, n_y)
                arm = middle + _QUARTER * np.rint((arm - middle) / _QUARTER)
                x = px + step * math.cos(arm)
                y = py + step * math.sin(arm)
            i = int((x - x0) / size)
            j = int((y - y0) / size)
            if i < 1 or j < 1 or i >= n_x - 1 or j >= n_y - 1:
                continue
            angle = cross_angle(x, y, field_cos, field_sin, size, x0, y0, n_x, n_y)
            here = size
            if is_graded:
                here = bilinear(x, y, wanted, fine, x0, y0, fine_x, fine_y)
            node2 = _NODE_CLEARANCE * here
            edge2 = (_EDGE_CLEARANCE * here) ** 2
            if not _is_inside_and_free(
                x, y, p, angle, node2, edge2, nodes, head, successor, offset, edges, start, end, kind, i, j, n_x
            ):
                continue
            if n >= most:
                break
            nodes[n, 0] = x
            nodes[n, 1] = y
            angles[n] = angle
            if of_ring[p] == 1:
                of_ring[n] = 2
            k = j * n_x + i
            successor[n] = head[k]
            head[k] = n
            queue[tail] = n
            tail += 1
            n += 1
    return nodes[:n].copy()
