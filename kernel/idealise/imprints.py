"""Imprints: curves that a face must have inside it because something else meets it there.

A candidate is a stretch of a carrier in a face. It is cut where it crosses the face's outline, other candidates, and
the outline of whatever it comes from; then only the pieces that lie in both regions stay.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.idealise.crossings import Crossing, merged
from kernel.idealise.outlines import Stretch, meeting_point, polyline, unwrapped, windowed
from kernel.idealise.sheets import Sheet
from kernel.idealise.topology import BOUNDARY, IMPRINT, Span, Topology
from kernel.idealise.trims import trimmed
from kernel.idealise.walls import Wall
from kernel.solid.surfaces import signed_distance

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
    for a, b in sorted(pairs, key=lambda pair: (by_id[pair[0]].index, by_id[pair[1]].index)):
        wall, other = by_id[a], by_id[b]
        if wall.sheet.surface_id == other.sheet.surface_id:
            continue
        for stretch in wall.outline:
            carrier = topology.carrier(stretch.carrier)
            points = carrier.at(np.linspace(stretch.start, stretch.end, 4))
            if np.abs(signed_distance(other.sheet.surface, points)).max() <= topology.tolerance:
                found.append(Candidate(other, stretch, wall))
    return found


def imprint(topology: Topology, candidates: Sequence[Candidate]) -> None:
    """Cut the candidates, and lay those pieces that lie in their regions."""
    by_wall: dict[int, list[Candidate]] = {}
    for candidate in candidates:
        by_wall.setdefault(candidate.wall.index, []).append(candidate)
    for index in sorted(by_wall):
        _imprint_face(topology, by_wall[index])


def _imprint_face(topology: Topology, candidates: list[Candidate]) -> None:
    wall = candidates[0].wall
    own = [_Drawn(topology, wall.sheet, stretch) for stretch in wall.outline]
    drawn = [_Drawn(topology, wall.sheet, candidate.stretch) for candidate in candidates]
    cuts: list[list[tuple[float, Array]]] = [[] for _ in drawn]
    lines = [*drawn, *own]
    meetings = _meetings([one.stretch.carrier for one in lines], [one.line for one in lines], len(drawn))
    for number, here in enumerate(drawn):
        for other, met in meetings.get(number, ()):
            there = lines[other]
            for point in _crossings(topology, wall.sheet, here, there, met):
                if _is_common_end(topology, here.stretch, there.stretch, point):
                    continue
                _cut(topology, here.stretch, point, cuts[number])
                _cut(topology, there.stretch, point, cuts[other] if other < len(drawn) else None)
        partner = candidates[number].partner
        if partner is not None:
            for stretch in partner.outline:
                if stretch.carrier == here.stretch.carrier and not stretch.whole:
                    for point in (stretch.first, stretch.last):
                        _cut(topology, here.stretch, point, cuts[number])
    regions = {id(c.partner): _slightly_grown(topology, c.partner) for c in candidates if c.partner is not None}
    inside = _slightly_grown(topology, wall)
    for candidate, at in zip(candidates, cuts):
        for part in _pieces(topology, candidate.stretch, at):
            carrier = topology.carrier(part.carrier)
            middle = carrier.at(np.array([0.5 * (part.start + part.end)]))
            if not _holds(wall.sheet, inside, middle):
                continue
            if candidate.partner is not None:
                if not _holds(candidate.partner.sheet, regions[id(candidate.partner)], middle):
                    continue
            _lay(topology, wall.index, part, IMPRINT)


class _Drawn:
    """A stretch as a line in a sheet's frame, a hair longer than it is."""

    def __init__(self, topology: Topology, sheet: Sheet, stretch: Stretch) -> None:
        self.stretch = stretch
        flat = unwrapped(sheet, polyline(topology, stretch))
        hair = 3 * topology.tolerance
        for end, inner in ((0, 1), (-1, -2)):
            along = flat[end] - flat[inner]
            flat[end] += along * (hair / max(float(np.linalg.norm(along)), hair))
        self.line = windowed(sheet, shapely.LineString(flat))


def _meetings(
    carriers: Sequence[int], lines: Sequence[shapely.Geometry], n_drawn: int
) -> dict[int, list[tuple[int, shapely.Geometry]]]:
    """By number of each of the first n_drawn lines: the later ones of other carriers that it meets, and where."""
    first, second = (
        np.array(sorted(shapely.STRtree(lines).query(lines[:n_drawn]).T.tolist()), np.int64).reshape(-1, 2).T
    )
    carrier = np.array(carriers)
    wanted = (second > first) & (carrier[first] != carrier[second])
    first, second = first[wanted], second[wanted]
    held = np.array(lines, dtype=object)
    common = shapely.intersection(held[first], held[second])
    found: dict[int, list[tuple[int, shapely.Geometry]]] = {}
    for one, other, met in zip(first.tolist(), second.tolist(), common):
        if not met.is_empty:
            found.setdefault(one, []).append((other, met))
    return found


def _crossings(topology: Topology, sheet: Sheet, one: _Drawn, other: _Drawn, met: shapely.Geometry) -> list[Array]:
    """Exact common points of two stretches on different carriers. met: what their lines have in common."""
    points = []
    for part in shapely.get_parts(met):
        if part.geom_type == "Point":
            near = sheet.lift(np.array([[part.x, part.y]]))[0]
            carriers = [topology.carrier(drawn.stretch.carrier) for drawn in (one, other)]
            points.append(meeting_point(sheet, carriers[0], carriers[1], near))
    return points


def _is_common_end(topology: Topology, one: Stretch, other: Stretch, point: Array) -> bool:
    """Whether the point is where both end: a cut there already, and found only roughly where they are tangent."""
    if one.whole or other.whole:
        return False
    reach = COMMON_END * topology.tolerance
    ends = [end for end in (one.first, one.last) if np.linalg.norm(point - end) <= reach]
    return any(np.linalg.norm(end - own) <= reach for end in ends for own in (other.first, other.last))


def _cut(topology: Topology, stretch: Stretch, point: Array, cuts: list[tuple[float, Array]] | None) -> None:
    """A vertex on the stretch's carrier at `point`, held within the stretch."""
    carrier = topology.carrier(stretch.carrier)
    value = float(carrier.parameters(point[None])[0])
    slack = 8 * topology.tolerance
    if carrier.period is not None:
        value = stretch.start + (value - stretch.start + slack) % carrier.period - slack
    if not stretch.whole and not stretch.start - slack <= value <= stretch.end + slack:
        return
    topology.cut(stretch.carrier, value, point)
    if cuts is not None:
        cuts.append((value, point))


def _pieces(topology: Topology, stretch: Stretch, cuts: list[tuple[float, Array]]) -> list[Stretch]:
    """The stretch between neighbouring cuts."""
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


def _slightly_grown(topology: Topology, wall: Wall) -> shapely.Geometry:
    return wall.region.buffer(INSIDE * topology.tolerance, quad_segs=2)


def _holds(sheet: Sheet, region: shapely.Geometry, point: Array) -> bool:
    flat = sheet.flat(point)[0]
    return bool(shapely.contains_xy(region, flat[0], flat[1]))
