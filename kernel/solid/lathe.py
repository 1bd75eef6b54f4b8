"""Triangles of what turns about an axis, and of what is extruded: rings and loops joined by quads.

    profile (r, z)                 turned by n steps
    3 --- 2        edge 1-2        b_k --- b_k+1     edge k -> k+1 of the loop from ring a to ring b:
    |     |    ------------>        |   /   |        a_k a_k+1 b_k+1,  a_k b_k+1 b_k
    0 --- 1                        a_k --- a_k+1     a ring of radius 0 is one point, its triangles collapse

Outer loops run counter-clockwise in (r, z), holes clockwise: normals then point out of the material.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from manifold3d import triangulate
from numpy.typing import NDArray

Loop = NDArray[np.float64]

SEGMENTS_PER_TURN = 96
"""Facets of a full turn, of every radius: coaxial facets must match, or thin tubes cross themselves.

A chord's sagitta is then 5e-4 of the radius; surfaces are exact beside the facets, so more would only cost time.
"""

SAGITTA = 1.0 - float(np.cos(np.pi / SEGMENTS_PER_TURN))
"""Of a radius: so far may a chord of its circle lie within it."""


def unit_circle(count: int = SEGMENTS_PER_TURN) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(cos, sin) at `count` even angles from 0; exactly symmetric about both axes where 4 divides the count."""
    angles = 2.0 * np.pi * np.arange(count) / count
    if count % 4:
        return np.cos(angles), np.sin(angles)
    quarter = count // 4
    first = np.sin(angles[: quarter + 1])
    first[-1] = 1.0
    eighth = quarter // 2
    first[quarter - eighth :] = np.cos(angles[: eighth + 1])[::-1]
    sine = np.concatenate([first, first[-2::-1], -first[1:], -first[-2:0:-1]])
    return np.roll(sine, -quarter), sine


@dataclass(frozen=True, slots=True, eq=False)
class Turned:
    """vertices as (radius, angle index or angle, z) are left to the caller; here only what is joined to what.

    ring: (n_vertex,) index of the profile point; step: (n_vertex,) index of the angle (0 for a point on the axis).
    triangles: (m, 3); edge: (m,) index of the profile edge, or START_CAP, END_CAP.
    """

    ring: NDArray[np.int64]
    step: NDArray[np.int64]
    triangles: NDArray[np.int64]
    edge: NDArray[np.int64]


START_CAP = -1
END_CAP = -2


def turn(loops: list[Loop], steps: int, *, is_closed: bool) -> Turned:
    """Join the profile loops ((k, 2) of r >= 0 and z) turned through `steps` angles.

    is_closed: a full turn; else caps close the first and the last angle. Profile points and edges are numbered
    through all loops in order, edge i runs from point i to the next of its loop.
    """
    radius = np.concatenate([loop[:, 0] for loop in loops])
    on_axis = radius == 0.0
    count = np.where(on_axis, 1, steps)
    start = np.concatenate([[0], np.cumsum(count)])
    ring = np.repeat(np.arange(len(radius)), count)
    step = np.arange(start[-1]) - start[ring]

    k = np.arange(steps if is_closed else steps - 1)
    following = (k + 1) % steps
    triangles: list[NDArray[np.int64]] = []
    edge: list[NDArray[np.int64]] = []
    first = 0
    for loop in loops:
        for i in range(len(loop)):
            p, q = first + i, first + (i + 1) % len(loop)
            if on_axis[p] and on_axis[q]:
                continue
            a0, a1 = (start[p] + 0 * k, start[p] + 0 * k) if on_axis[p] else (start[p] + k, start[p] + following)
            b0, b1 = (start[q] + 0 * k, start[q] + 0 * k) if on_axis[q] else (start[q] + k, start[q] + following)
            parts = []
            if not on_axis[p]:
                parts.append(np.stack([a0, a1, b1], axis=1))
            if not on_axis[q]:
                parts.append(np.stack([a0, b1, b0], axis=1))
            block = np.stack(parts, axis=1).reshape(-1, 3)
            triangles.append(block)
            edge.append(np.full(len(block), p))
        first += len(loop)
    if not is_closed:
        flat = triangulate_loops(loops)
        triangles += [start[flat], (start[flat] + np.where(on_axis[flat], 0, steps - 1))[:, ::-1]]
        edge += [np.full(len(flat), START_CAP), np.full(len(flat), END_CAP)]
    return Turned(ring, step, np.concatenate(triangles), np.concatenate(edge))


def triangulate_loops(loops: list[Loop]) -> NDArray[np.int64]:
    """(m, 3) counter-clockwise triangles of the region inside the loops, indices through all loops in order."""
    return np.asarray(triangulate([np.ascontiguousarray(loop) for loop in loops]), dtype=np.int64).reshape(-1, 3)


def layer(loops: list[Loop], layers: int, *, to_point: bool = False) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Join copies of the loops in `layers` + 1 levels (the last one a single point if to_point).

    Vertices are level by level, in the order of the loops. Returns triangles (m, 3) and group (m,): 0 bottom, 1 top,
    2 + i + n_point * level for the side on loop edge i.
    """
    flat = triangulate_loops(loops)
    n_point = sum(len(loop) for loop in loops)
    here = np.arange(n_point)
    following = np.concatenate(
        [first + np.roll(np.arange(len(loop)), -1) for first, loop in zip(_starts(loops), loops, strict=True)]
    )
    triangles = [flat[:, ::-1]]
    group = [np.zeros(len(flat), np.int64)]
    for level in range(layers):
        low, high = level * n_point, (level + 1) * n_point
        if to_point and level == layers - 1:
            sides = np.stack([low + here, low + following, np.full(n_point, high)], axis=1)
            group.append(2 + here + low)
        else:
            one = np.stack([low + here, low + following, high + following], axis=1)
            two = np.stack([low + here, high + following, high + here], axis=1)
            sides = np.stack([one, two], axis=1).reshape(-1, 3)
            group.append(np.repeat(2 + here + low, 2))
        triangles.append(sides)
    if not to_point:
        triangles.append(flat + layers * n_point)
        group.append(np.ones(len(flat), np.int64))
    return np.concatenate(triangles), np.concatenate(group)


def _starts(loops: list[Loop]) -> list[int]:
    return [0, *np.cumsum([len(loop) for loop in loops])[:-1].tolist()]
