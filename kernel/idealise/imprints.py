"""Imprints: curves that a face must have inside it because something else meets it there.

A candidate is a stretch of a carrier in a face. It is cut where it crosses the face's outline, other candidates, and
the outline of whatever it comes from; then only the pieces that lie in both regions stay.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.idealise.carriers import Carrier, Line
from kernel.idealise.crossings import Crossing, merged
from kernel.idealise.outlines import LINES_CROSS, Stretch, meeting_point, polyline, unwrapped, windowed
from kernel.idealise.sheets import PlaneSheet, Sheet
from kernel.idealise.topology import BOUNDARY, IMPRINT, Span, Topology
from kernel.idealise.trims import trimmed
from kernel.idealise.walls import Wall
from kernel.solid.surfaces import cross, signed_distance

Array = NDArray[np.float64]

INSIDE = 25.0
"""A piece lies in a region when its middle is no further outside than this many tolerances."""


COMMON_END = 10.0
"""Stretches that cross within this many tolerances of an end that they share do not cross, but meet there."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidate:
    """A stretch that may be imprinted in the face of `wall`; partner: the wall that it must lie in too, if any."""

    wall: Wall
    stretch: Stretch
    partner: Wall | None = None


def lay_outlines(topology: Topology, walls: Sequence[Wall]) -> None:
    """Every wall's outline as boundary spans."""
    for wall in walls:
        for stretch in wall.outline:
            _lay(topology, wall.index, stretch, BOUNDARY)


def _lay(topology: Topology, face: int, stretch: Stretch, role: str) -> None:
    ends: tuple[Array | None, Array | None] = (None, None)
    if not stretch.whole:
        ends = (stretch.first, stretch.last) if stretch.forward else (stretch.last, stretch.first)
    span = Span(face, stretch.start, stretch.end, role, stretch.forward, stretch.whole)
    topology.add_span(stretch.carrier, span, ends)


def piece(topology: Topology, carrier: int, start: float, end: float) -> Stretch:
    """The stretch of a carrier from start to end; all of it where that is a full turn."""
    value = topology.carrier(carrier)
    if value.period is not None and end - start >= value.period - topology.tolerance:
        first = value.at(np.zeros(1))[0]
        return Stretch(carrier, 0.0, value.period, True, first, first, whole=True)
    first, last = value.at(np.array([start, end]))
    return Stretch(carrier, start, end, True, first, last)


def crossing_candidates(topology: Topology, crossings: Sequence[Crossing]) -> list[Candidate]:
    """The joint curves of walls, in both of them, as far as both may reach: one that went on would cut far edges."""
    beside: dict[tuple[int, int], list[Crossing]] = {}
    for crossing in crossings:
        for wall in crossing.walls:
            beside.setdefault((crossing.carrier, wall.index), []).append(crossing)
    found = []
    for crossing in crossings:
        period = topology.carrier(crossing.carrier).period
        intervals = [
            ends
            for wall in crossing.walls
            for ends in trimmed(topology, crossing, wall, beside[crossing.carrier, wall.index])
        ]
        for start, end in merged(intervals, topology.tolerance, period):
            stretch = piece(topology, crossing.carrier, start, end)
            a, b = crossing.walls
            found += [Candidate(a, stretch, b), Candidate(b, stretch, a)]
    return found


def outline_candidates(topology: Topology, walls: Sequence[Wall], joints: Sequence[Joint]) -> list[Candidate]:
    """Outlines of walls that lie in the sheet of a wall they touch."""
    by_id = {wall.segment.id: wall for wall in walls}
    pairs = {(a, b) for joint in joints for a, b in (joint.segments, joint.segments[::-1]) if a in by_id and b in by_id}
    found = []
    stations: dict[int, Array] = {}
    for a, b in sorted(pairs, key=lambda pair: (by_id[pair[0]].index, by_id[pair[1]].index)):
        wall, other = by_id[a], by_id[b]
        if wall.sheet.surface_id == other.sheet.surface_id or not wall.outline:
            continue
        if wall.index not in stations:
            stations[wall.index] = np.concatenate([_stations(topology, stretch) for stretch in wall.outline])
        away = np.abs(signed_distance(other.sheet.surface, stations[wall.index])).reshape(len(wall.outline), -1)
        within = np.flatnonzero(away.max(axis=1) <= topology.tolerance)
        found += [Candidate(other, wall.outline[place], wall) for place in within.tolist()]
    return found


def _stations(topology: Topology, stretch: Stretch) -> Array:
    """Four points (4, 3) along a stretch: its ends, and two between."""
    return topology.carrier(stretch.carrier).at(np.linspace(stretch.start, stretch.end, 4))


def imprint(topology: Topology, candidates: Sequence[Candidate]) -> None:
    """Cut the candidates, and lay those pieces that lie in their regions."""
    by_wall: dict[int, list[Candidate]] = {}
    for candidate in candidates:
        by_wall.setdefault(candidate.wall.index, []).append(candidate)
    grown = _Grown(topology)
    for index in sorted(by_wall):
        _imprint_face(topology, by_wall[index], grown)


class _Grown:
    """Walls' regions, slightly grown; each is asked for in its own face and in those of all that it meets."""

    def __init__(self, topology: Topology) -> None:
        self._topology = topology
        self._known: dict[int, shapely.Geometry] = {}

    def holds(self, wall: Wall, points: Array) -> NDArray[np.bool_]:
        """Which of the points (n, 3) lie in the wall's region."""
        if wall.index not in self._known:
            region = wall.region.buffer(INSIDE * self._topology.tolerance, quad_segs=2)
            shapely.prepare(region)
            self._known[wall.index] = region
        flat = wall.sheet.flat(points)
        return np.asarray(shapely.contains_xy(self._known[wall.index], flat[:, 0], flat[:, 1]))


def _imprint_face(topology: Topology, candidates: list[Candidate], grown: _Grown) -> None:
    wall = candidates[0].wall
    # Walls in line on both sides of this one are drawn as one: the same stretch with two partners.
    places: dict[tuple[int, float, float, bool, bool], int] = {}
    drawn: list[Stretch] = []
    place_of = []
    for candidate in candidates:
        stretch = candidate.stretch
        key = (stretch.carrier, stretch.start, stretch.end, stretch.forward, stretch.whole)
        if key not in places:
            places[key] = len(drawn)
            drawn.append(stretch)
        place_of.append(places[key])
    cuts = _cuts(topology, wall, drawn)
    parts: list[tuple[Candidate, Stretch]] = []
    ends: dict[int, dict[int, list[_Cut]]] = {}
    for candidate, place in zip(candidates, place_of):
        partner, here, at = candidate.partner, candidate.stretch, list(cuts[place])
        if partner is not None:
            if partner.index not in ends:
                ends[partner.index] = _ends_of(topology, partner)
            for value, point in ends[partner.index].get(here.carrier, ()):
                _cut(topology, here, point, value, at)
        parts += [(candidate, part) for part in _pieces(topology, candidate, at)]
    if not parts:
        return
    middles = _middles(topology, [part for _, part in parts])
    is_held = grown.holds(wall, middles)
    by_partner: dict[int, list[int]] = {}
    for place, (candidate, _) in enumerate(parts):
        if candidate.partner is not None and is_held[place]:
            by_partner.setdefault(candidate.partner.index, []).append(place)
    for rows in by_partner.values():
        other_wall = parts[rows[0]][0].partner
        assert other_wall is not None
        is_held[rows] = grown.holds(other_wall, middles[rows])
    for (_, part), is_kept in zip(parts, is_held.tolist()):
        if is_kept:
            _lay(topology, wall.index, part, IMPRINT)


_Cut = tuple[float, Array]
"""The parameter of a cut, and the point (3,)."""


def _cuts(topology: Topology, wall: Wall, drawn: list[Stretch]) -> list[list[_Cut]]:
    """Where each stretch drawn in a wall crosses others and the outline; all are cut there."""
    stretches = [*drawn, *wall.outline]
    ends = [None if one.whole else (one.first.tolist(), one.last.tolist()) for one in stretches]
    cuts: list[list[_Cut]] = [[] for _ in drawn]
    meeting = _MeetingPoints(topology, wall.sheet)
    reach = COMMON_END * topology.tolerance
    for number, other, near in _meetings(topology, wall.sheet, stretches, len(drawn)):
        here, there = stretches[number], stretches[other]
        met = meeting.of(here.carrier, there.carrier, near)
        if not _is_common_end(ends[number], ends[other], met.at, reach):
            _cut(topology, here, met.point, met.values[0], cuts[number])
            _cut(topology, there, met.point, met.values[1], cuts[other] if other < len(drawn) else None)
    return cuts


def _ends_of(topology: Topology, wall: Wall) -> dict[int, list[_Cut]]:
    """By carrier, where the stretches of a wall's outline begin and end."""
    found: dict[int, list[_Cut]] = {}
    for stretch in wall.outline:
        if not stretch.whole:
            points = np.array([stretch.first, stretch.last])
            values = topology.carrier(stretch.carrier).parameters(points).tolist()
            found.setdefault(stretch.carrier, []).extend(zip(values, points))
    return found


def _middles(topology: Topology, stretches: Sequence[Stretch]) -> Array:
    """Points (n, 3) amid the stretches."""
    found = np.empty((len(stretches), 3))
    by_carrier: dict[int, list[int]] = {}
    for place, stretch in enumerate(stretches):
        by_carrier.setdefault(stretch.carrier, []).append(place)
    for carrier, places in by_carrier.items():
        middles = np.array([0.5 * (stretches[place].start + stretches[place].end) for place in places])
        found[places] = topology.carrier(carrier).at(middles)
    return found


def _line_of(topology: Topology, sheet: Sheet, stretch: Stretch) -> shapely.Geometry:
    """A stretch as a line in a sheet's frame, a hair longer than it is."""
    flat = unwrapped(sheet, polyline(topology, stretch))
    hair = 3 * topology.tolerance
    for end, inner in ((0, 1), (-1, -2)):
        along = flat[end] - flat[inner]
        flat[end] += along * (hair / max(math.hypot(*along.tolist()), hair))
    return windowed(sheet, shapely.LineString(flat))


def _meetings(
    topology: Topology, sheet: Sheet, stretches: Sequence[Stretch], n_drawn: int
) -> Iterator[tuple[int, int, Array]]:
    """Where each of the first n_drawn stretches meets a later one of another carrier: both, and a point (3,) near."""
    held, ends = _lines_of(topology, sheet, stretches)
    asked, found = shapely.STRtree(held).query(held[:n_drawn])
    carrier = np.array([stretch.carrier for stretch in stretches])
    wanted = (found > asked) & (carrier[asked] != carrier[found])
    asked, found = asked[wanted], found[wanted]
    order = np.lexsort((found, asked))
    asked, found = asked[order], found[order]
    is_straight = np.isfinite(ends[:, 0, 0])
    both = is_straight[asked] & is_straight[found]
    (straight,), (bent,) = np.nonzero(both), np.nonzero(~both)
    points, meet = _straight_meetings(ends[asked[straight]], ends[found[straight]])
    common, pair = shapely.get_parts(shapely.intersection(held[asked[bent]], held[found[bent]]), return_index=True)
    is_point = (shapely.get_type_id(common) == shapely.GeometryType.POINT) & ~shapely.is_empty(common)
    pair = np.concatenate([straight[meet], bent[pair[is_point]]])
    near = sheet.lift(np.concatenate([points[meet], shapely.get_coordinates(common[is_point])]))
    order = np.argsort(pair, kind="stable")
    pair = pair[order]
    yield from zip(asked[pair].tolist(), found[pair].tolist(), near[order])


def _lines_of(topology: Topology, sheet: Sheet, stretches: Sequence[Stretch]) -> tuple[NDArray[np.object_], Array]:
    """The stretches as lines in a sheet's frame, and the ends (n, 2, 2) of those that are straight there, else nan."""
    ends = np.full((len(stretches), 2, 2), np.nan)
    is_straight = np.zeros(len(stretches), dtype=bool)
    if isinstance(sheet, PlaneSheet):
        is_straight[:] = [isinstance(topology.carrier(stretch.carrier), Line) for stretch in stretches]
    rows = np.flatnonzero(is_straight)
    if len(rows):
        points = np.array([(stretches[row].first, stretches[row].last) for row in rows.tolist()])
        flat = sheet.flat(points.reshape(-1, 3)).reshape(-1, 2, 2)
        along = flat[:, 1] - flat[:, 0]
        hair = 3 * topology.tolerance
        along *= (hair / np.maximum(np.hypot(along[:, 0], along[:, 1]), hair))[:, None]
        ends[rows] = flat + np.stack([-along, along], axis=1)
    held = np.empty(len(stretches), dtype=object)
    held[rows] = shapely.linestrings(ends[rows])
    for row in np.flatnonzero(~is_straight).tolist():
        held[row] = _line_of(topology, sheet, stretches[row])
    return held, ends


def _straight_meetings(one: Array, other: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Common points (n, 2) of the lines through pairs of segments (n, 2, 2), and whether they lie within both."""
    along, across, apart = one[:, 1] - one[:, 0], other[:, 1] - other[:, 0], other[:, 0] - one[:, 0]

    def turned(a: Array, b: Array) -> Array:
        return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]

    span = turned(along, across)
    is_across = span != 0.0
    span = np.where(is_across, span, 1.0)
    share, its_share = turned(apart, across) / span, turned(apart, along) / span
    within = is_across & (share >= 0.0) & (share <= 1.0) & (its_share >= 0.0) & (its_share <= 1.0)
    return one[:, 0] + share[:, None] * along, within


@dataclass(frozen=True, slots=True, eq=False)
class _Meeting:
    """A common point (3,) of two carriers, as plain numbers too, and its parameter on each."""

    point: Array
    at: list[float]
    values: tuple[float, float]


class _MeetingPoints:
    """Exact common points of the carriers of one sheet; two lines have one, however many stretches lie on them."""

    def __init__(self, topology: Topology, sheet: Sheet) -> None:
        self._topology, self._sheet = topology, sheet
        self._known: dict[tuple[int, int], _Meeting] = {}

    def of(self, one: int, other: int, near: Array) -> _Meeting:
        """That of two carriers next to `near` (3,)."""
        known = self._known.get((one, other))
        if known is not None:
            return known
        carriers = self._topology.carrier(one), self._topology.carrier(other)
        point = meeting_point(self._sheet, carriers[0], carriers[1], near)
        values = [float(carrier.parameters(point[None])[0]) for carrier in carriers]
        met = _Meeting(point, point.tolist(), (values[0], values[1]))
        if _cross_once(*carriers):
            self._known[one, other] = met
        return met


def _cross_once(one: Carrier, other: Carrier) -> bool:
    """Whether two carriers have one common point, wherever it is looked for."""
    if not isinstance(one, Line) or not isinstance(other, Line):
        return False
    return bool(np.linalg.norm(cross(one.direction, other.direction)) > LINES_CROSS)


_Ends = tuple[list[float], list[float]]


def _is_common_end(one: _Ends | None, other: _Ends | None, at: list[float], reach: float) -> bool:
    """Whether the point is where both end: a cut there already, and found only roughly where they are tangent.

    one, other: the ends of two stretches, None of one that goes all round.
    """
    if one is None or other is None:
        return False
    ends = [end for end in one if math.dist(at, end) <= reach]
    return bool(ends) and any(math.dist(end, own) <= reach for end in ends for own in other)


def _cut(
    topology: Topology, stretch: Stretch, point: Array, value: float, cuts: list[tuple[float, Array]] | None
) -> None:
    """A vertex on the stretch's carrier at `point`, whose parameter is `value`, if it is within the stretch."""
    period = topology.carrier(stretch.carrier).period
    slack = 8 * topology.tolerance
    if period is not None:
        value = stretch.start + (value - stretch.start + slack) % period - slack
    if not stretch.whole and not stretch.start - slack <= value <= stretch.end + slack:
        return
    topology.cut(stretch.carrier, value, point)
    if cuts is not None:
        cuts.append((value, point))


def _pieces(topology: Topology, candidate: Candidate, cuts: list[tuple[float, Array]]) -> list[Stretch]:
    """The candidate's stretch between neighbouring cuts."""
    stretch = candidate.stretch
    carrier = topology.carrier(stretch.carrier)
    inner = sorted(cuts, key=lambda cut: cut[0])
    if stretch.whole:
        if not inner:
            return [stretch]
        period = carrier.period
        assert period is not None
        stations = [*inner, (inner[0][0] + period, inner[0][1])]
    else:
        ends = (stretch.first, stretch.last) if stretch.forward else (stretch.last, stretch.first)
        stations = [(stretch.start, ends[0]), *inner, (stretch.end, ends[1])]
        stations.sort(key=lambda station: station[0])
    return [
        Stretch(stretch.carrier, a, b, True, first, last)
        for (a, first), (b, last) in itertools.pairwise(stations)
        if b - a > 4 * topology.tolerance
    ]
