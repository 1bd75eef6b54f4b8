"""Relined regions: polygons put back onto carriers, edge by edge; edges that lie on none get carriers of their own."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString

from kernel.idealise.carriers import Line
from kernel.idealise.crossings import samples, whole_range
from kernel.idealise.outlines import (
    PolygonLike,
    Stretch,
    even_odd,
    meeting_point,
    ring_points,
    stretch_between,
    unwrapped,
    windowed,
)
from kernel.idealise.sheets import CylinderSheet, PlaneSheet, Sheet
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall
from kernel.segment.slices import parts_of

Array = NDArray[np.float64]

ON_CARRIER = 3e-6
"""An edge nearer than this share of the model's size to a carrier lies on it."""


def outline_of(
    topology: Topology, wall: Wall, region: PolygonLike, joint_carriers: set[int]
) -> tuple[list[Stretch], PolygonLike]:
    """The region's outline as stretches of carriers, the region on their left; and the region, exact again."""
    near = _near_carriers(topology, wall, region)
    outline: list[_Cut] = []
    rings: list[Array] = []
    for polygon in parts_of(region):
        polygon = shapely.geometry.polygon.orient(polygon)
        for ring in (polygon.exterior, *polygon.interiors):
            cuts = _ring_outline(topology, wall.sheet, np.asarray(ring.coords)[:, :2], near, joint_carriers)
            if cuts and isinstance(wall.sheet, PlaneSheet):
                rings.append(ring_points(topology, wall.sheet, [cut.stretch for cut in cuts]))
            outline += cuts
    return _joined_at_seam(topology, outline), even_odd(rings) if rings else region


def _joined_at_seam(topology: Topology, outline: list[_Cut]) -> list[Stretch]:
    """The stretches, those that only the seam of a sheet parted being one again."""
    whole = [cut.stretch for cut in outline if cut.first and cut.last]
    open_ended = [cut for cut in outline if not (cut.first and cut.last)]
    while open_ended:
        cut = open_ended.pop(0)
        if cut.first and cut.last:
            whole.append(cut.stretch)
            continue
        stretch = cut.stretch
        period = topology.carrier(stretch.carrier).period
        if period is not None and stretch.end - stretch.start >= period - 30 * topology.tolerance:
            first = topology.carrier(stretch.carrier).at(np.zeros(1))[0]
            whole.append(Stretch(stretch.carrier, 0.0, period, stretch.forward, first, first, whole=True))
            continue
        for place, other in enumerate(open_ended):
            pair = (cut, other) if not cut.last and not other.first else (other, cut)
            if pair[0].last or pair[1].first or other.stretch.carrier != stretch.carrier:
                continue
            if np.linalg.norm(pair[0].stretch.last - pair[1].stretch.first) <= 30 * topology.tolerance:
                del open_ended[place]
                open_ended.insert(0, _Cut(_chained(pair[0].stretch, pair[1].stretch), pair[0].first, pair[1].last))
                break
        else:
            whole.append(stretch)
    return whole


def _chained(one: Stretch, other: Stretch) -> Stretch:
    """Two stretches of a carrier, the second beginning where the first ends."""
    length = (one.end - one.start) + (other.end - other.start)
    if one.forward:
        return Stretch(one.carrier, one.start, one.start + length, True, one.first, other.last)
    return Stretch(one.carrier, one.end - length, one.end, False, one.first, other.last)


@dataclass(frozen=True, slots=True, eq=False)
class _Near:
    """The carriers near a region, in their sheet's frame: numbers (n,), ascending.

    foot, along: (n, 2) a point and the unit direction of each straight one in a plane; lines: the others, by place.
    """

    numbers: NDArray[np.int64]
    foot: Array
    along: Array
    lines: dict[int, shapely.Geometry]

    def distances(self, points: Array) -> Array:
        """Distances (n, m) of points (m, 2) from each."""
        x, y = (points[None, :, k] - self.foot[:, k, None] for k in (0, 1))
        found = np.abs(x * self.along[:, 1:] - y * self.along[:, :1])
        for place, line in self.lines.items():
            found[place] = shapely.distance(shapely.points(points), line)
        return found


def _near_carriers(topology: Topology, wall: Wall, region: PolygonLike) -> _Near:
    """The carriers that the outline of a wall's region may lie on."""
    straight: dict[int, Line] = {}
    others: dict[int, shapely.Geometry] = {}
    for number in wall.known:
        carrier = topology.carrier(number)
        if isinstance(carrier, Line) and isinstance(wall.sheet, PlaneSheet):
            straight[number] = carrier
            continue
        line = drawn(topology, wall.sheet, number, region)
        if line is not None:
            others[number] = line
    numbers = sorted({*straight, *others})
    foot, along = np.zeros((2, len(numbers), 2))
    if straight and isinstance(wall.sheet, PlaneSheet):
        rows = [place for place, number in enumerate(numbers) if number in straight]
        carriers = [straight[numbers[row]] for row in rows]
        foot[rows] = wall.sheet.flat(np.array([line.point for line in carriers]))
        along[rows] = wall.sheet.flat(np.array([line.direction for line in carriers]))
    lines = {place: others[number] for place, number in enumerate(numbers) if number in others}
    return _Near(np.array(numbers, dtype=np.int64), foot, along, lines)


def drawn(topology: Topology, sheet: Sheet, number: int, region: PolygonLike) -> shapely.Geometry | None:
    """A carrier as a line in the sheet's frame, near the region; None where it stays away from it."""
    carrier = topology.carrier(number)
    left, low, right, high = region.bounds
    corners = sheet.lift(np.array([[left, low], [right, low], [left, high], [right, high]]))
    start, end = whole_range(topology, carrier, corners)
    points = samples(topology, carrier, start, end)
    line = windowed(sheet, LineString(unwrapped(sheet, points)))
    reach = ON_CARRIER * topology.carriers.reach
    return line if line.intersects(shapely.box(left - reach, low - reach, right + reach, high + reach)) else None


@dataclass(frozen=True, slots=True, eq=False)
class _Cut:
    """A stretch, and whether it really begins and ends there (not only at the seam of a sheet)."""

    stretch: Stretch
    first: bool
    last: bool


def _ring_outline(topology: Topology, sheet: Sheet, points: Array, near: _Near, preferred: set[int]) -> list[_Cut]:
    size = topology.carriers.reach
    points = _without_specks(points, 3 * topology.tolerance)
    if len(points) < 4:
        return []
    labels = _labels(topology, sheet, points, near, preferred, ON_CARRIER * size)
    n = len(labels)
    begins = [k for k in range(n) if labels[k] != labels[k - 1]]
    if not begins:
        begins = [0]
    runs = [(begin, (begins[(k + 1) % len(begins)] - begin) % n or n) for k, begin in enumerate(begins)]
    space = sheet.lift(points[:-1])
    if len(runs) == 1 and labels[0] is not None and topology.carrier(labels[0]).period is not None:
        return [_Cut(_full_turn(topology, labels[0], space), True, True)]
    corners = []
    for begin, _ in runs:
        before, after = labels[begin - 1], labels[begin]
        here = space[begin]
        if before is not None and after is not None and before != after:
            found = meeting_point(sheet, topology.carrier(before), topology.carrier(after), here)
            on_sheet = sheet.lift(sheet.flat(found[None]))[0]  # a pinched tube's curve lies beside the sheet
            here = found if np.linalg.norm(on_sheet - here) <= 30 * topology.tolerance else here
        corners.append(here)
    stretches = []
    for position, (begin, count) in enumerate(runs):
        label = labels[begin]
        if label is None:
            continue  # the seam
        first, last = corners[position], corners[(position + 1) % len(corners)]
        inner = 0.5 * (space[(begin + np.arange(count)) % n] + space[(begin + np.arange(1, count + 1)) % n])
        stretch = stretch_between(topology, label, first, last, inner)
        is_real = (labels[begin - 1] is not None, labels[(begin + count) % n] is not None)
        stretches.append(_Cut(stretch, *is_real))
    return stretches


def _without_specks(points: Array, shortest: float) -> Array:
    """A closed line (n, 2) less points that are nearer than `shortest` to the one before."""
    first, *inner, _ = points.tolist()
    kept = [first]
    for point in inner:
        if math.dist(point, kept[-1]) > shortest:
            kept.append(point)
    if len(kept) > 1 and math.dist(kept[-1], first) <= shortest:
        kept.pop()
    return np.array([*kept, first])


def _labels(
    topology: Topology,
    sheet: Sheet,
    points: Array,
    near: _Near,
    preferred: set[int],
    reach: float,
) -> list[int | None]:
    """The carrier of each edge; None for edges on the seam of a closed sheet."""
    away = np.stack([near.distances(points[:-1]), near.distances(0.5 * (points[:-1] + points[1:]))])
    away = np.maximum(np.maximum(away[0], np.roll(away[0], -1, axis=1)), away[1])
    rank = away - np.where(np.isin(near.numbers, list(preferred)), 0.5 * reach, 0.0)[:, None]
    rank[away > reach] = np.inf
    best = rank.argmin(axis=0)
    is_free = np.isinf(np.take_along_axis(rank, best[None], axis=0)[0])
    labels: list[int | None] = [
        None if free else number for free, number in zip(is_free.tolist(), near.numbers[best].tolist())
    ]
    for first, end in _straight_runs(points, is_free, 3 * topology.tolerance):
        a, b = points[first], points[end]
        if isinstance(sheet, CylinderSheet) and abs(a[0] - b[0]) < reach:
            if min(abs(a[0] - sheet.seam), abs(a[0] - sheet.seam - sheet.turn)) < reach:
                continue
        labels[first:end] = [_own_carrier(topology, sheet, a, b)] * (end - first)
    return labels


def _straight_runs(points: Array, free: NDArray[np.bool_], tolerance: float) -> Iterator[tuple[int, int]]:
    """First and last point of the longest runs of free edges that are straight within the tolerance."""
    k = 0
    while k < len(free):
        end = k + 1
        while free[k] and end < len(free) and free[end]:
            inner = shapely.points(points[k + 1 : end + 1])
            if shapely.distance(inner, LineString(points[[k, end + 1]])).max() > tolerance:
                break
            end += 1
        if free[k]:
            yield k, end
        k = end


def _own_carrier(topology: Topology, sheet: Sheet, a: Array, b: Array) -> int:
    """A carrier for an edge that lies on none: straight in the sheet's frame."""
    if isinstance(sheet, PlaneSheet):
        ends = sheet.lift(np.array([a, b]))
        return topology.carriers.line(ends[0], ends[1] - ends[0])
    size = topology.carriers.reach
    ends = sheet.lift(np.array([a, b]))
    if abs(a[0] - b[0]) < ON_CARRIER * size:
        return topology.carriers.line(ends[0], sheet.axis.direction)
    if abs(a[1] - b[1]) < ON_CARRIER * size:
        height = sheet.axis.direction * (0.5 * (a[1] + b[1]))
        return topology.carriers.circle(sheet.axis.point + height, sheet.axis.direction, sheet.radius)
    guide = sheet.lift(a + np.linspace(0, 1, 17)[:, None] * (b - a))
    return topology.carriers.traced((sheet.surface_id,), (sheet.surface,), guide, is_closed=False)


def _full_turn(topology: Topology, number: int, points: Array) -> Stretch:
    carrier = topology.carrier(number)
    period = carrier.period
    assert period is not None
    values = carrier.parameters(points[:2])
    forward = bool((values[1] - values[0]) % period < (values[0] - values[1]) % period)
    first = carrier.at(np.zeros(1))[0]
    return Stretch(number, 0.0, period, forward, first, first, whole=True)
