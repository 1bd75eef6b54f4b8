r"""A region parted by the imprints that run right through it, so that each cell can be meshed by itself.

    +-----------+-----------+      Every boundary edge is walked once, every imprint both ways, at each point by the
    |           |     .--.  |      leftmost turn. A walk that runs counter-clockwise is the outer ring of a cell, one
    |     0     |  1 ( 2  ) |      that runs clockwise a hole of the smallest cell around it; an imprint with one cell
    |    ---    |     '--'  |      on both sides stays an imprint of that cell.
    +-----------+-----------+

A stiffened plate falls into rectangles in this way, and a pipe with flanges into bands: simple enough for a structured
mesh. On a closed cylinder a walk may go round: it then bounds a band from below or from above. A cell that does not go
round is cut free of the cylinder and lies in the plane; points on both sides of such a cut are doubled in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.mesh.period import shortest_way
from kernel.mesh.region import Region, RegionError, RegionMesh

Points = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class RegionCell:
    """A part of a region. numbers: (n,) the whole region's number of each of the cell's points."""

    region: Region
    numbers: Indices


@dataclass(frozen=True, slots=True, eq=False)
class _Walk:
    """A closed walk. halves: (n,) in order; places: (n, 2) where each starts, unrolled. winding: turns round."""

    halves: Indices
    places: Points
    winding: int
    area: float
    height: float
    """Mean of y over x, which orders walks that go round."""


@dataclass(frozen=True, slots=True, eq=False)
class _Halves:
    """Edges as they are walked. edge: (n,) which; start, end: (n,) points."""

    edge: Indices
    start: Indices
    end: Indices


def cells_of_region(region: Region) -> list[RegionCell] | None:
    """The cells, in the order of their first edges; None where neither imprint nor pinch parts the region.

    RegionError, with the place, where two of its edges have the same ends.
    """
    if region.is_boundary.all() and np.bincount(region.edges[:, 0]).max() < 2:
        return None
    halves = _halves(region)
    walks = _walks(region, halves)
    outer = [walk for walk in walks if walk.winding == 0 and walk.area > 0]
    for walk in outer:
        if len(walk.halves) < 3:
            raise RegionError("two edges of the region have the same ends near {}", walk.places[0])
    bands = _bands(walks)
    if bands is None or (len(outer) + len(bands) < 2 and (region.period is None or not outer)):
        return None
    inner = [walk for walk in walks if walk.winding == 0 and walk.area <= 0]
    own: list[list[tuple[_Walk, int]]] = [[(walk, 0)] for walk in outer]
    own += [[(low, 0), (high, 0)] for low, high in bands]
    surroundings = _Surroundings(region, halves, outer, bands)
    for walk in inner:
        found = surroundings.of(walk.places[0], set(halves.start[walk.halves].tolist()))
        if found is None:
            return None
        own[found[0]].append((walk, found[1]))
    hard = np.setdiff1d(np.arange(len(region.points)), region.edges.ravel())
    held: list[list[tuple[int, int]]] = [[] for _ in own]
    for number in hard.tolist():
        found = surroundings.of(region.points[number], set())
        if found is None:
            return None
        held[found[0]].append((number, found[1]))
    order = sorted(range(len(own)), key=lambda place: min(int(walk.halves.min()) for walk, _ in own[place]))
    return [_cell(region, halves, own[place], held[place], place >= len(outer)) for place in order]


def joined(region: Region, cells: Sequence[RegionCell], meshes: Sequence[RegionMesh]) -> RegionMesh:
    """The cells' meshes as one mesh of the region."""
    points = [region.points]
    quads, triangles = [], []
    n_point = len(region.points)
    for cell, mesh in zip(cells, meshes, strict=True):
        new = mesh.points[len(cell.numbers) :].copy()
        if region.period is not None:
            new[:, 0] %= region.period
            new[new[:, 0] >= region.period, 0] = 0.0  # -1e-17 % period is period
        numbers = np.concatenate([cell.numbers, np.arange(n_point, n_point + len(new))])
        points.append(new)
        quads.append(numbers[mesh.quads.reshape(-1, 4)])
        triangles.append(numbers[mesh.triangles.reshape(-1, 3)])
        n_point += len(new)
    return RegionMesh(np.concatenate(points), np.concatenate(quads), np.concatenate(triangles))


# ---------------------------------------------------------------- walks


def _halves(region: Region) -> _Halves:
    inside = np.flatnonzero(~region.is_boundary)
    edge = np.concatenate([np.arange(len(region.edges)), inside])
    start = np.concatenate([region.edges[:, 0], region.edges[inside, 1]])
    end = np.concatenate([region.edges[:, 1], region.edges[inside, 0]])
    return _Halves(edge, start, end)


def _steps(region: Region, start: Indices, end: Indices) -> Points:
    step = region.points[end] - region.points[start]
    if region.period is not None:
        step[:, 0] = shortest_way(step[:, 0], region.period)
    return step


def _following(region: Region, halves: _Halves) -> Indices:
    """The half that each is followed by: of those that leave its end, the first clockwise from the way back."""
    leaving = np.argsort(halves.start, kind="stable")
    first = np.searchsorted(halves.start[leaving], np.arange(len(region.points) + 1))
    count = np.diff(first)
    following = leaving[np.minimum(first[halves.end], len(leaving) - 1)]
    step = _steps(region, halves.start, halves.end)
    heading = np.arctan2(step[:, 1], step[:, 0])
    back = np.arctan2(-step[:, 1], -step[:, 0])
    branching = np.flatnonzero(count[halves.end] > 1)
    n_choice = count[halves.end[branching]]
    begin = np.cumsum(n_choice) - n_choice
    half = np.repeat(branching, n_choice)
    choices = leaving[np.arange(len(half)) - np.repeat(begin - first[halves.end[branching]], n_choice)]
    turn = np.mod(back[half] - heading[choices], 2 * np.pi)
    turn[turn <= 0.0] = 2 * np.pi  # the way back itself comes last
    best = np.lexsort((turn, half))[begin]
    following[branching] = choices[best]
    return following


def _walks(region: Region, halves: _Halves) -> list[_Walk]:
    following = _following(region, halves).tolist()
    is_open = np.ones(len(following), np.bool_)
    walks = []
    for first in range(len(following)):
        if not is_open[first]:
            continue
        walk, half = [], first
        while is_open[half]:
            is_open[half] = False
            walk.append(half)
            half = following[half]
        walks.append(_walk(region, halves, np.array(walk)))
    return walks


def _walk(region: Region, halves: _Halves, walk: Indices) -> _Walk:
    step = _steps(region, halves.start[walk], halves.end[walk])
    places = region.points[halves.start[walk[0]]] + np.concatenate([[[0.0, 0.0]], np.cumsum(step, axis=0)])
    winding = 0 if region.period is None else round(float(places[-1, 0] - places[0, 0]) / region.period)
    centre = places.mean(axis=0)
    middle = places[:-1, 1] - centre[1] + 0.5 * step[:, 1]
    under = float((middle * step[:, 0]).sum())
    is_slit = 2 * len(np.unique(halves.edge[walk])) == len(walk)
    height = float(centre[1]) + under / float(step[:, 0].sum()) if winding else 0.0
    return _Walk(walk, places[:-1], winding, 0.0 if winding or is_slit else -under, height)


def _bands(walks: Sequence[_Walk]) -> list[tuple[_Walk, _Walk]] | None:
    """Pairs of walks that bound a band from below and from above; None where they do not take turns."""
    by_height = sorted((walk for walk in walks if walk.winding), key=lambda walk: walk.height)
    low = [walk for walk in by_height if walk.winding == 1]
    high = [walk for walk in by_height if walk.winding == -1]
    if len(low) + len(high) < len(by_height) or len(low) != len(high):
        return None
    if any(below.height >= above.height for below, above in zip(low, high)):
        return None
    return list(zip(low, high))


class _Surroundings:
    """Finds the smallest cell around a place."""

    def __init__(
        self, region: Region, halves: _Halves, outer: Sequence[_Walk], bands: Sequence[tuple[_Walk, _Walk]]
    ) -> None:
        self._period = region.period
        self._bands = bands
        self._polygons = [shapely.Polygon(walk.places) for walk in outer]
        self._points = [set(halves.start[walk.halves].tolist()) for walk in outer]
        self._tree = shapely.STRtree(self._polygons)

    def of(self, place: Points, own: set[int]) -> tuple[int, int] | None:
        """The cell, those bounded by one walk first, and by how many periods the place moves to lie in it.

        own: points of a walk that bounds other cells: cells on whose outer walk one of them lies are not meant.
        """
        found: list[tuple[float, int, int]] = []
        for shift in (0,) if self._period is None else (0, -1, 1, -2, 2):
            point = shapely.Point(place[0] + shift * (self._period or 0.0), place[1])
            for number in self._tree.query(point, predicate="within").tolist():
                if own.isdisjoint(self._points[number]):
                    found.append((self._polygons[number].area, number, shift))
        if found:
            return min(found)[1:]
        for number, (low, high) in enumerate(self._bands):
            if not _is_below(place, low, self._period) and _is_below(place, high, self._period):
                return len(self._polygons) + number, 0
        return None


def _is_below(place: Points, walk: _Walk, period: float | None) -> bool:
    """Whether a walk that goes round passes above a place."""
    assert period is not None
    x, y = walk.places.T
    step = np.roll(walk.places, -1, 0) - walk.places
    step[-1, 0] += walk.winding * period
    begin = x - place[0]
    turns = np.floor(begin / period)
    crossings = 0
    for turn in np.unique(np.concatenate([turns, np.floor((begin + step[:, 0]) / period)])):
        a, b = begin - turn * period, begin + step[:, 0] - turn * period
        crosses = (a <= 0) != (b <= 0)
        share = -a[crosses] / step[crosses, 0]
        crossings += int((y[crosses] + share * step[crosses, 1] > place[1]).sum())
    return crossings % 2 == 1


# ---------------------------------------------------------------- cells


def _cell(
    region: Region, halves: _Halves, walks: Sequence[tuple[_Walk, int]], hard: Sequence[tuple[int, int]], is_band: bool
) -> RegionCell:
    """The cell between walks. walks, hard: with the periods by which each is moved.

    A point of the cell is a point of the region and the periods by which it is moved: two of them where the walk passes
    on both sides of a cut.
    """
    period = None if is_band else region.period
    rings, moved, ends, n_walked = [], [], [], 0
    for walk, shift in walks:
        start = halves.start[walk.halves]
        turns = np.zeros(len(start)) if period is None else (walk.places[:, 0] - region.points[start, 0]) / period
        rings.append(start)
        moved.append(np.round(turns).astype(np.int64) + shift)
        ends.append(n_walked + np.roll(np.arange(len(start)), -1))
        n_walked += len(start)
    rings.append(np.array([number for number, _ in hard], np.int64))
    moved.append(np.array([shift for _, shift in hard], np.int64))
    named = np.stack([np.concatenate(rings), np.concatenate(moved)], axis=1)
    walked, local = np.unique(named[:n_walked], axis=0, return_inverse=True)
    named = np.concatenate([walked, named[n_walked:]])  # hard points last, as a region has them
    pairs = np.stack([local.ravel(), local.ravel()[np.concatenate(ends)]], axis=1)
    _, first, times = np.unique(np.sort(pairs, axis=1), axis=0, return_index=True, return_counts=True)
    in_order = np.argsort(first)
    kept, is_boundary = first[in_order], times[in_order] == 1
    points = region.points[named[:, 0]].copy()
    points[:, 0] += named[:, 1] * (period or 0.0)
    edge = np.concatenate([halves.edge[walk.halves] for walk, _ in walks])[kept]
    part = Region(points, pairs[kept], is_boundary, region.is_curved[edge], region.period if is_band else None)
    return RegionCell(part, named[:, 0])
