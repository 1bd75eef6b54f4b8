r"""Refinement of a constrained Delaunay triangulation by off-centres, no constraint ever divided.

A triangle whose circumradius is too long, against its shortest edge or against the size wanted there, gets a new
node: not its circumcentre but a point nearer to the shortest edge (Ungor 2004, Off-centers: a new type of Steiner
points), so that the new triangle on that edge is just good enough and the mesh stays coarse.

              * circumcentre
              |
              x off-centre: at .87 to 1.4 shortest edges
             / \
            o---o shortest edge

A node that would lie too near a constraint or another node is not made; no constraint is split for its sake.
"""

from __future__ import annotations

import math

import numpy as np

from kernel.numeric.bins import segment_distance2
from kernel.numeric.compiled import compiled
from kernel.numeric.delaunay import STACK, insert_in_triangle, locate
from kernel.numeric.halfedge import following, preceding
from kernel.numeric.size_grid import bilinear
from kernel.numeric.triangulation import to_grid

_RADIUS_TO_EDGE = 1.25
"""Circumradius over shortest edge that starts a refinement (1.25: about 24 degrees; smoothing does the rest)."""
_RADIUS_TO_SIZE = 0.95
_SIZE_SWEEPS = 30


@compiled
def wanted_sizes(points, n_node, corner, twin, lock, n_triangle, base, cell, x0, y0, n_x, n_y, growth):
    """Size at each node, (len(points),): the mean of its constraint edges, at most the base there, growing likewise.

    base: sizes by cell (see size_grid).
    """
    wanted = np.empty(len(points))
    for i in range(n_node):
        wanted[i] = bilinear(points[i, 0], points[i, 1], base, cell, x0, y0, n_x, n_y)
    total = np.zeros(n_node)
    count = np.zeros(n_node)
    for e in range(3 * n_triangle):
        if lock[e] != 0 or twin[e] < 0:
            a = corner[e]
            b = corner[following(e)]
            length = math.hypot(points[a, 0] - points[b, 0], points[a, 1] - points[b, 1])
            total[a] += length
            count[a] += 1
            total[b] += length
            count[b] += 1
    for i in range(n_node):
        if count[i] > 0:
            wanted[i] = min(wanted[i], total[i] / count[i])
    for _ in range(_SIZE_SWEEPS):
        changed = False
        for e in range(3 * n_triangle):
            a = corner[e]
            b = corner[following(e)]
            step = math.hypot(points[a, 0] - points[b, 0], points[a, 1] - points[b, 1]) * growth
            if wanted[a] > (wanted[b] + step) * (1 + 1e-9):
                wanted[a] = wanted[b] + step
                changed = True
            elif wanted[b] > (wanted[a] + step) * (1 + 1e-9):
                wanted[b] = wanted[a] + step
                changed = True
        if not changed:
            break
    return wanted


@compiled
def refine(
    points, n_node, x, y, origin, scale, corner, twin, lock, leaving, n_triangle,
    base, cell, x0, y0, n_x, n_y, growth,
):  # fmt: skip
    """Insert off-centres until no triangle asks for one. points has room for more. Returns n_node, n_triangle.

    base, cell, x0, y0, n_x, n_y: the size where no short edge is near, by cell (see size_grid.long_edge_sizes).
    """
    wanted = wanted_sizes(points, n_node, corner, twin, lock, n_triangle, base, cell, x0, y0, n_x, n_y, growth)
    most_triangle = len(corner) // 3
    waiting = np.empty(4 * most_triangle + 16, np.int32)
    stack = np.empty(STACK, np.int32)
    n_waiting = n_triangle
    for t in range(n_triangle):
        waiting[t] = t
    while n_waiting > 0 and n_node < len(points) - 1 and n_triangle + 2 < most_triangle:
        n_waiting -= 1
        t = np.int64(waiting[n_waiting])
        a = corner[3 * t]
        b = corner[3 * t + 1]
        c = corner[3 * t + 2]
        bx = points[b, 0] - points[a, 0]
        by = points[b, 1] - points[a, 1]
        cx = points[c, 0] - points[a, 0]
        cy = points[c, 1] - points[a, 1]
        area4 = 2 * (bx * cy - by * cx)
        if area4 <= 0:
            continue
        ab2 = bx * bx + by * by
        ca2 = cx * cx + cy * cy
        bc2 = (cx - bx) ** 2 + (cy - by) ** 2
        ux = (cy * ab2 - by * ca2) / area4  # circumcentre from a
        uy = (bx * ca2 - cx * ab2) / area4
        radius = math.sqrt(ux * ux + uy * uy)
        shortest = math.sqrt(min(ab2, min(ca2, bc2)))
        here = (wanted[a] + wanted[b] + wanted[c]) / 3
        if radius <= _RADIUS_TO_SIZE * here and (radius <= _RADIUS_TO_EDGE * shortest or shortest < 0.35 * here):
            continue
        if ab2 <= ca2 and ab2 <= bc2:
            p = a
            q = b
        elif ca2 <= bc2:
            p = c
            q = a
        else:
            p = b
            q = c
        px = points[a, 0] + ux
        py = points[a, 1] + uy
        mx = 0.5 * (points[p, 0] + points[q, 0])
        my = 0.5 * (points[p, 1] + points[q, 1])
        distance = math.hypot(px - mx, py - my)
        wish = max(0.87 * shortest, min(here * 0.95, 1.4 * shortest))
        if distance > wish:
            px = mx + (px - mx) * wish / distance
            py = my + (py - my) * wish / distance
        node = np.int64(n_node)
        x[node] = to_grid(px, origin[0], scale)
        y[node] = to_grid(py, origin[1], scale)
        home = np.int64(locate(x, y, corner, twin, lock, node, t, np.int64(1)))
        if home < 0:
            continue
        is_free = True
        total = 0.0
        for k in range(3):
            e = 3 * home + k
            u = corner[e]
            v = corner[following(e)]
            total += wanted[u]
            if lock[e] != 0 or twin[e] < 0:
                length2 = (points[u, 0] - points[v, 0]) ** 2 + (points[u, 1] - points[v, 1]) ** 2
                off2 = segment_distance2(px, py, points[u, 0], points[u, 1], points[v, 0], points[v, 1])
                if off2 < 0.2 * length2:
                    is_free = False
            if (points[u, 0] - px) ** 2 + (points[u, 1] - py) ** 2 < (0.55 * min(shortest, wanted[u])) ** 2:
                is_free = False
        if not is_free:
            continue
        points[node, 0] = px
        points[node, 1] = py
        wanted[node] = min(bilinear(px, py, base, cell, x0, y0, n_x, n_y), total / 3)
        n_triangle = insert_in_triangle(x, y, corner, twin, lock, leaving, home, node, n_triangle, stack)
        e = np.int64(leaving[node])
        first = e
        while True:
            u = corner[following(e)]
            step = math.hypot(points[u, 0] - px, points[u, 1] - py) * growth
            if wanted[u] + step < wanted[node]:
                wanted[node] = wanted[u] + step
            if n_waiting < len(waiting) - 1:
                waiting[n_waiting] = e // 3
                n_waiting += 1
            e = np.int64(twin[preceding(e)])
            if e == first or e < 0:
                break
        n_node += 1
    return n_node, n_triangle
