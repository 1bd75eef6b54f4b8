"""A region on a closed cylinder cut open along a seam: every point gets its place in the plane, the seam's points two.

right copies |  the material  | left copies     The right copy of a seam point is where the seam is, its left
             |  between the   |                 copy one period further: the material on the seam's left hangs
  seam       |  two copies    |  seam + period  on to that one. An edge at a seam point leaves on the right where
             |                |                 it lies counter-clockwise between the seam's way back and its
                                                way on; at the seam's ends those are taken out of the material.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh.period import shortest_way
from kernel.mesh.region import Region, RegionError
from kernel.mesh.seam import BOUNDARY, Step, follow_boundary, gap_direction, ring_windings
from kernel.numeric.inside import inside_rings

_MOST_TURNS = 3
"""How often a piece of the region may lie round the cylinder from where its coordinates say."""


@dataclass(frozen=True, slots=True, eq=False)
class CutRegion:
    """region: in the plane, its points those of the cylinder (in order), then the left copies.

    left_of: (n_left,) the point that each left copy doubles. is_vertex: (n,) points where seam and curves meet.
    """

    region: Region
    left_of: NDArray[np.int64]
    is_vertex: NDArray[np.bool_]


@dataclass(frozen=True, slots=True)
class _SeamPoint:
    """Where a seam point lies in the plane, and the angles of the seam's way back and on."""

    x: float
    y: float
    back: float
    on: float

    def is_left(self, angle: float) -> bool:
        """Does an edge in this direction leave on the seam's left?"""
        return (angle - self.back) % (2 * math.pi) >= (self.on - self.back) % (2 * math.pi)


def _seam_points(region: Region, seam: list[Step]) -> dict[int, _SeamPoint]:
    """The points that the seam doubles: those with an edge of it (not those passed along a hole's boundary)."""
    after, before = follow_boundary(region)
    back: dict[int, float] = {}
    on: dict[int, float] = {}
    place: dict[int, tuple[float, float]] = {}
    if seam:
        x, y = region.points[seam[0].start]
        for step in seam:
            dx, dy = step.along
            if step.kind != BOUNDARY:
                place[step.start] = x, y
                place[step.end] = x + dx, y + dy
                on[step.start] = math.atan2(dy, dx)
                back[step.end] = math.atan2(-dy, -dx)
            x, y = x + dx, y + dy
    points = {}
    for v in sorted(place):
        gap = gap_direction(region, v, int(after[v]), int(before[v])) if v not in back or v not in on else 0.0
        points[v] = _SeamPoint(*place[v], back.get(v, gap), on.get(v, gap))
    return points


def cut_open(region: Region, seam: list[Step]) -> CutRegion:
    """Cut along the seam's edges (imprints of the region, or steps along a hole's boundary, which need no cut).

    Without a seam the region does not close round the cylinder and is only unrolled. RegionError where a piece of it
    lies outside.
    """
    assert region.period is not None
    n_point = len(region.points)
    doubled = _seam_points(region, seam)
    left_of = np.array(sorted(doubled), np.int64)
    left_number = {v: n_point + i for i, v in enumerate(left_of.tolist())}
    place = np.full((n_point + len(left_of), 2), np.nan)
    for v, point in doubled.items():
        place[v] = point.x, point.y
        place[left_number[v]] = point.x + region.period, point.y

    forward = {(step.start, step.end) for step in seam if step.kind != BOUNDARY}
    ends = region.edges.copy()
    is_seam = np.zeros(len(ends), np.bool_)
    along = region.points[ends[:, 1]] - region.points[ends[:, 0]]
    along[:, 0] = shortest_way(along[:, 0], region.period)
    touches = np.flatnonzero(np.isin(ends, left_of).any(axis=1)) if len(left_of) else np.empty(0, np.int64)
    for i in touches.tolist():
        u, v = region.edges[i].tolist()
        dx, dy = along[i]
        if (u, v) in forward or (v, u) in forward:
            is_seam[i] = True
            continue
        if u in doubled and doubled[u].is_left(math.atan2(dy, dx)):
            ends[i, 0] = left_number[u]
        if v in doubled and doubled[v].is_left(math.atan2(-dy, -dx)):
            ends[i, 1] = left_number[v]

    plain = ~is_seam
    way = np.array(sorted(forward), np.int64).reshape(-1, 2)
    number_left = np.full(n_point, -1, np.int64)
    number_left[left_of] = np.arange(n_point, n_point + len(left_of))
    edges = np.concatenate([ends[plain], way[:, ::-1], number_left[way]])  # the material is on their left
    is_boundary = np.concatenate([region.is_boundary[plain], np.ones(2 * len(way), np.bool_)])
    is_curved = np.concatenate([region.is_curved[plain], np.zeros(2 * len(way), np.bool_)])
    seeds = [*left_of.tolist(), *left_number.values()]
    if not seeds:
        seeds = [_outer_point(region)]
        place[seeds] = region.points[seeds]
    _unroll(place, ends[plain], along[plain], seeds)
    _place_islands(place, region, edges[is_boundary], ends[plain], along[plain])
    degree = np.bincount(region.edges.ravel(), minlength=n_point)
    is_vertex = np.zeros(n_point + len(left_of), np.bool_)
    is_vertex[left_of] = degree[left_of] > 2
    is_vertex[n_point:] = degree[left_of] > 2
    return CutRegion(Region(place, edges, is_boundary, is_curved), left_of, is_vertex)


def _outer_point(region: Region) -> int:
    """A point of the outer ring of a region that does not close round the cylinder: the ring of positive area."""
    assert region.period is not None
    after, _ = follow_boundary(region)
    best, largest = -1, 0.0
    for ring, _ in ring_windings(region, after):
        dx = shortest_way(np.roll(region.points[ring, 0], -1) - region.points[ring, 0], region.period)
        x = np.concatenate([[0.0], np.cumsum(dx)[:-1]])
        y = region.points[ring, 1]
        area = 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
        if area > largest:
            best, largest = int(ring[0]), area
    if best < 0:
        raise MeshError("the region has no boundary with the material on its left")
    return best


def _unroll(place: NDArray[np.float64], ends: NDArray[np.int64], along: NDArray[np.float64], seeds: list[int]) -> None:
    """Carry places along edges from the seeds to all that hangs together with them; in place."""
    order = np.argsort(ends.ravel(), kind="stable")
    offset = np.searchsorted(ends.ravel()[order], np.arange(len(place) + 1))
    waiting = list(seeds)
    while waiting:
        u = waiting.pop()
        for slot in order[offset[u] : offset[u + 1]].tolist():
            edge, which = divmod(slot, 2)
            v = int(ends[edge, 1 - which])
            if np.isnan(place[v, 0]):
                sign = 1.0 if which == 0 else -1.0
                place[v] = place[u] + sign * along[edge]
                waiting.append(v)


def _place_islands(
    place: NDArray[np.float64],
    region: Region,
    rim: NDArray[np.int64],
    ends: NDArray[np.int64],
    along: NDArray[np.float64],
) -> None:
    """Holes, imprints and hard points that hang on nothing: the turn of each that lies inside the rim; in place."""
    assert region.period is not None
    rim = rim[~np.isnan(place[rim]).any(axis=(1, 2))]
    from_x, from_y, to_x, to_y = (np.ascontiguousarray(c) for c in (*place[rim[:, 0]].T, *place[rim[:, 1]].T))
    turns = np.array(sorted(range(-_MOST_TURNS, _MOST_TURNS + 1), key=abs))
    for v in range(len(region.points)):
        if not np.isnan(place[v, 0]):
            continue
        tries = np.column_stack([region.points[v, 0] + turns * region.period, np.full(len(turns), region.points[v, 1])])
        is_inside = inside_rings(tries, from_x, from_y, to_x, to_y)
        if not is_inside.any():
            raise RegionError("point {} lies outside the region on the cylinder", region.points[v])
        place[v] = tries[int(is_inside.argmax())]
        _unroll(place, ends, along, [v])
