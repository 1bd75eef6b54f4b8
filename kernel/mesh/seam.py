r"""Where to cut a closed cylinder open: the region on it has two ends, and the seam runs from one to the other.

A straight seam between a seed of either end is taken where one keeps clear of holes and imprints, in the widest gap.
Where none does, the seam is a path from hole to hole: bridges are edges of a constrained Delaunay triangulation of
the seeds (so they see each other), and across a hole the seam costs nothing.

    ======o======  top                  ======o======
          |                               ___/
          |                              ( )      hole
          |  straight                      \___
          |                                   ( )
    ======o======  bottom               =======\o====
"""

from __future__ import annotations

import heapq
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh.period import shortest_way
from kernel.mesh.region import Region, RegionError
from kernel.numeric.clearance import clearance2
from kernel.numeric.triangulation import triangulate

BRIDGE, IMPRINT, BOUNDARY = "bridge", "imprint", "boundary"

_CLEAR = 3.0
"""A straight seam is good enough where it stays this many sizes away from everything."""
_MOST_STRAIGHT = 256
"""Straight seams tried: more do not find a wider gap that matters."""
_BRIDGE_COST = 4.0
"""A bridge costs its length and this many sizes: few bridges before short ones."""
_OBLIQUE_COST = 6.0
_NARROW_COST = 8.0
_ALONG_COST = 0.05


@dataclass(frozen=True, slots=True)
class Step:
    """One step of a seam, from point to point of the region. along: (dx, dy) on the unrolled surface."""

    start: int
    end: int
    along: tuple[float, float]
    kind: str


def follow_boundary(region: Region) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """The boundary point after and before each point, (n_point,) with -1 off the boundary; RegionError if not rings."""
    n_point = len(region.points)
    after = np.full(n_point, -1, np.int64)
    before = np.full(n_point, -1, np.int64)
    boundary = region.edges[region.is_boundary]
    after[boundary[:, 0]] = boundary[:, 1]
    before[boundary[:, 1]] = boundary[:, 0]
    leaving = np.bincount(boundary[:, 0], minlength=n_point)
    arriving = np.bincount(boundary[:, 1], minlength=n_point)
    bad = np.flatnonzero((leaving != arriving) | (leaving > 1))
    if len(bad):
        raise RegionError("the region's boundary is not a simple ring at {}", region.points[bad[0]])
    return after, before


def ring_windings(region: Region, after: NDArray[np.int64]) -> list[tuple[NDArray[np.int64], int]]:
    """Each boundary ring, as its points in order, and how often it goes round: +1 bottom end, -1 top end, 0 a hole."""
    assert region.period is not None
    is_seen = np.zeros(len(region.points), np.bool_)
    rings = []
    for first in np.flatnonzero(after >= 0):
        if is_seen[first]:
            continue
        ring = [int(first)]
        is_seen[first] = True
        v = int(after[first])
        while v != first:
            ring.append(v)
            is_seen[v] = True
            v = int(after[v])
        points = np.array(ring)
        x = region.points[points, 0]
        turns = shortest_way(np.roll(x, -1) - x, region.period).sum() / region.period
        rings.append((points, round(float(turns))))
    return rings


def free_ends(region: Region) -> NDArray[np.int64]:
    """The points of ends that nothing hangs on: a seam may begin at any of them, since it meets an end only once."""
    degree = np.bincount(region.edges.ravel(), minlength=len(region.points))
    after, _ = follow_boundary(region)
    free = [ring for ring, turns in ring_windings(region, after) if turns != 0 and (degree[ring] == 2).all()]
    return np.concatenate([np.empty(0, np.int64), *free])


def _straight_seam(
    region: Region, bottom: NDArray[np.int64], top: NDArray[np.int64], size: float, is_candidate: NDArray[np.bool_]
) -> Step | None:
    """The straight seam with the widest clearance from everything but the two ends, None where that is narrow."""
    assert region.period is not None
    period = region.period
    points = region.points
    is_end = np.zeros(len(points), np.bool_)
    is_end[bottom] = True
    is_end[top] = True
    edges = region.edges
    dx = shortest_way(points[edges[:, 1], 0] - points[edges[:, 0], 0], period)
    of_end = is_end[edges[:, 0]] & region.is_boundary
    from_x, from_y = points[edges[:, 0], 0], points[edges[:, 0], 1]
    to_x, to_y = from_x + dx, points[edges[:, 1], 1].copy()
    lower, upper = bottom[is_candidate[bottom]], top[is_candidate[top]]
    if len(lower) == 0 or len(upper) == 0:
        return None
    lower = lower[np.unique(np.linspace(0, len(lower) - 1, min(len(lower), _MOST_STRAIGHT)).astype(np.int64))]
    best: Step | None = None
    best_clearance = _CLEAR * size
    for u in lower:
        away = shortest_way(points[upper, 0] - points[u, 0], period)
        nearest = int(np.abs(away).argmin())
        v = upper[nearest]
        ax, ay, bx, by = points[u, 0], points[u, 1], points[u, 0] + away[nearest], points[v, 1]
        inner = ~of_end
        clear2 = clearance2(ax, ay, bx, by, from_x[inner], from_y[inner], to_x[inner], to_y[inner], period)
        hits = clearance2(ax, ay, bx, by, from_x[of_end], from_y[of_end], to_x[of_end], to_y[of_end], period)
        lean = abs(float(away[nearest])) / (by - ay) if by > ay else 1.0
        clearance = min(math.sqrt(clear2), period) * (1 - lean)
        if hits > 0 and clearance > best_clearance * (1 + 1e-9):
            best_clearance = clearance
            best = Step(int(u), int(v), (float(away[nearest]), float(by - ay)), BRIDGE)
    return best


def _bridges(
    region: Region,
    after: NDArray[np.int64],
    before: NDArray[np.int64],
    size: float,
    is_candidate: NDArray[np.bool_],
) -> list[tuple[int, int, float, float, float]]:
    """Point, point, dx, dy and cost of every edge that a seam may take through the material."""
    assert region.period is not None
    period = region.period
    n_point = len(region.points)
    turns = (0, -1, 1)  # three copies of the seeds, the middle one first
    block = np.array([1, 0, 2])  # by turn + 1
    copies = np.concatenate([region.points + [turn * period, 0.0] for turn in turns])
    a, b = region.edges[:, 0], region.edges[:, 1]
    jump = np.round((region.points[a, 0] - region.points[b, 0]) / period).astype(np.int64)  # turn of b against a's
    start, end = [], []
    for turn in turns:
        is_kept = np.abs(turn + jump) <= 1
        start.append(a[is_kept] + n_point * block[turn + 1])
        end.append(b[is_kept] + n_point * block[turn + jump[is_kept] + 1])
    starts = np.concatenate(start).astype(np.int32)
    ends = np.concatenate(end).astype(np.int32)
    kind = np.full(len(starts), 2, np.uint8)
    corner, twin, lock, _, n_triangle, *_ = triangulate(copies, len(copies), starts, ends, kind, 0)
    half = np.flatnonzero((lock[: 3 * n_triangle] == 0) & (twin[: 3 * n_triangle] > np.arange(3 * n_triangle)))
    following = np.where(half % 3 == 2, half - 2, half + 1)
    u, v = corner[half].astype(np.int64), corner[following].astype(np.int64)
    other = twin[half].astype(np.int64)
    apex = corner[np.where(half % 3 == 0, half + 2, half - 1)], corner[np.where(other % 3 == 0, other + 2, other - 1)]
    along = copies[v] - copies[u]
    length = np.hypot(along[:, 0], along[:, 1])
    narrow = np.zeros(len(u))
    for node in apex:
        off = copies[node] - copies[u]
        height = np.abs(along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]) / length
        narrow = np.maximum(narrow, 1 - np.minimum(1, height / size))
    chosen = (u < n_point) | (v < n_point)
    u_point, v_point = u % n_point, v % n_point
    chosen &= is_candidate[u_point] & is_candidate[v_point] & (u_point != v_point)
    direction = np.arctan2(along[:, 1], along[:, 0])
    found = []
    for i in np.flatnonzero(chosen):
        oblique = 0.0
        is_inside = True
        for point, angle in ((u_point[i], direction[i]), (v_point[i], direction[i] + math.pi)):
            if after[point] < 0:
                continue
            first, last = _wedge(region, int(point), int(after[point]), int(before[point]))
            opening = (last - first) % (2 * math.pi)
            turn = (angle - first) % (2 * math.pi)
            is_inside &= 0 < turn < opening
            oblique = max(oblique, 1 - min(1.0, min(turn, opening - turn) / (math.pi / 3)))
        if is_inside:
            extra = _BRIDGE_COST + _OBLIQUE_COST * oblique + _NARROW_COST * narrow[i]
            short = max(0.0, 2 * size - length[i]) * 4
            cost = float(length[i] + extra * size + short)
            found.append((int(u_point[i]), int(v_point[i]), float(along[i, 0]), float(along[i, 1]), cost))
    return found


def _wedge(region: Region, point: int, after: int, before: int) -> tuple[float, float]:
    """Angles between which, counter-clockwise, the material lies about a point of the boundary."""
    assert region.period is not None
    leave = region.points[after] - region.points[point]
    arrive = region.points[before] - region.points[point]
    leave_x = float(shortest_way(leave[0], region.period))
    arrive_x = float(shortest_way(arrive[0], region.period))
    return math.atan2(leave[1], leave_x), math.atan2(arrive[1], arrive_x)


def gap_direction(region: Region, point: int, after: int, before: int) -> float:
    """The direction from a point of the boundary out of the material, half way between its two edges."""
    first, last = _wedge(region, point, after, before)
    return last + ((first - last) % (2 * math.pi)) / 2


def find_seam(region: Region, size: float, is_candidate: NDArray[np.bool_]) -> list[Step]:
    """Steps from the bottom end to the top end; none where the region does not close round the cylinder.

    is_candidate: (n_point,) the points where a seam may meet a curve. MeshError where the ends are not two, or
    nothing joins them.
    """
    after, before = follow_boundary(region)
    rings = ring_windings(region, after)
    bottoms = [ring for ring, turns in rings if turns > 0]
    tops = [ring for ring, turns in rings if turns < 0]
    if not bottoms and not tops:
        return []
    if len(bottoms) != 1 or len(tops) != 1 or any(abs(turns) > 1 for _, turns in rings):
        raise MeshError(f"the region on the cylinder has {len(bottoms)} lower and {len(tops)} upper ends, not one each")
    bottom, top = bottoms[0], tops[0]
    straight = _straight_seam(region, bottom, top, size, is_candidate)
    if straight is not None:
        return [straight]
    return _cheapest_path(region, bottom, top, size, _bridges(region, after, before, size, is_candidate))


def _cheapest_path(
    region: Region,
    bottom: NDArray[np.int64],
    top: NDArray[np.int64],
    size: float,
    bridges: list[tuple[int, int, float, float, float]],
) -> list[Step]:
    """Dijkstra's path over bridges, imprints and hole boundaries from any bottom point to any top point."""
    assert region.period is not None
    ways: dict[int, list[tuple[float, Step]]] = {}

    def add(u: int, v: int, dx: float, dy: float, cost: float, kind: str) -> None:
        ways.setdefault(u, []).append((cost, Step(u, v, (dx, dy), kind)))
        ways.setdefault(v, []).append((cost, Step(v, u, (-dx, -dy), kind)))

    for u, v, dx, dy, cost in bridges:
        add(u, v, dx, dy, cost, BRIDGE)
    along = region.points[region.edges[:, 1]] - region.points[region.edges[:, 0]]
    along[:, 0] = shortest_way(along[:, 0], region.period)
    ends = set(bottom.tolist()) | set(top.tolist())
    for (u, v), (dx, dy), is_boundary in zip(region.edges.tolist(), along.tolist(), region.is_boundary.tolist()):
        length = math.hypot(dx, dy)
        if not is_boundary:
            add(u, v, dx, dy, length, IMPRINT)
        elif u not in ends:
            add(u, v, dx, dy, _ALONG_COST * length, BOUNDARY)
    reached: dict[int, tuple[float, Step | None]] = {int(v): (0.0, None) for v in bottom}
    heap = sorted((0.0, int(v)) for v in bottom)
    goals = set(top.tolist())
    while heap:
        cost, u = heapq.heappop(heap)
        if cost > reached[u][0]:
            continue
        if u in goals:
            steps: list[Step] = []
            step = reached[u][1]
            while step is not None:
                steps.append(step)
                step = reached[step.start][1]
            return steps[::-1]
        for price, way in ways.get(u, ()):
            total = cost + price
            if way.end not in reached or total < reached[way.end][0] - 1e-12 * size:
                reached[way.end] = (total, way)
                heapq.heappush(heap, (total, way.end))
    raise RegionError("no seam joins the two ends of the region on the cylinder, from {}", region.points[bottom[0]])
