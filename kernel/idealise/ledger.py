"""The ledger: where the idealised model counts volume more often, or less often, than the solid has it.

Regions times thickness, and sections times length, against the segments' own volumes: these are measured, with true
curves, so that the sum of all rows is exact. What walls count more where they meet stands there in closed form
(closed_forms.py); what is measured beyond that, in walls that touch one another, is a row of its own: unexplained.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.bodies import Bodies
from kernel.idealise.askew import is_filled, own_edge
from kernel.idealise.carriers import Circle, Line
from kernel.idealise.closed_forms import PIPES, Row, closed_forms, strip_area
from kernel.idealise.crossings import Crossing
from kernel.idealise.ledger_row import BALANCE, JOINT, SHAPE, UNEXPLAINED, LedgerRow
from kernel.idealise.outlines import Stretch, unwrapped
from kernel.idealise.parts import Parts
from kernel.idealise.sheets import PlaneSheet, Sheet
from kernel.idealise.topology import BOUNDARY, Curve, Topology
from kernel.idealise.tube_curve import TubeCurve
from kernel.idealise.walls import Wall
from kernel.segment.segments import Segment

NEGLIGIBLE = 1e-12
"""Rows smaller than this share of the model's volume are rounding."""

CLOSES = 1e-9
"""Measured and closed forms agree when they differ by less than this share of the model's volume."""

NOTABLE = 1e-3
"""Rows without a closed form are warned of from this share of the model's volume on; the mass may differ by five times
as much."""

MISFIT = 0.05
"""A wall whose middle times its thickness differs from its own volume by more than this share has another thickness
than its material. Counterbores and bevels of the labelled models come to 0.8 %."""

FACETED = 2e-7
"""Share of its volume to which a solid is known whose curved faces meet at hardly any angle somewhere."""

_STEPS = 32
"""Parts into which a curved stretch is divided for its area, before Richardson's extrapolation."""


def outline_area(topology: Topology, sheet: Sheet, outline: Sequence[Stretch]) -> float:
    """Area that an outline encloses on its sheet, true curves: the integral of (x dy - y dx) / 2 along it.

    On a closed cylinder ends that wind round count with their height, so the area is that between them.
    """
    return float(sum(_swept_area(topology, sheet, stretch) for stretch in outline))


def _swept_area(topology: Topology, sheet: Sheet, stretch: Stretch) -> float:
    """The integral along one stretch; -y dx on a closed cylinder, where x has no beginning."""
    carrier = topology.carrier(stretch.carrier)
    sign = 1.0 if stretch.forward else -1.0
    if isinstance(carrier, Circle) and isinstance(sheet, PlaneSheet):
        turned = 1.0 if carrier.normal @ sheet.normal > 0 else -1.0
        centre = sheet.flat(carrier.centre[None])[0]
        ends = sheet.flat(carrier.at(np.array([stretch.start, stretch.end])))
        chord = ends[1] - ends[0]
        moment = 0.5 * float(centre[0] * chord[1] - centre[1] * chord[0])
        return sign * (moment + turned * 0.5 * carrier.radius * (stretch.end - stretch.start))
    if isinstance(carrier, TubeCurve):
        parts = itertools.pairwise([stretch.start, *_bends_within(carrier, stretch), stretch.end])
        pieces = [replace(stretch, start=start, end=end) for start, end in parts]
        return sign * sum(_extrapolated(topology, sheet, piece, _STEPS) for piece in pieces)
    return sign * _extrapolated(topology, sheet, stretch, 1 if isinstance(carrier, Line) else _STEPS)


def _bends_within(carrier: TubeCurve, stretch: Stretch) -> list[float]:
    """Parameters of the sharp bends within a stretch: sums on both sides of one do not converge together."""
    turns = [bend + turn * carrier.period for turn in (-1, 0, 1) for bend in carrier.bends]
    return [value for value in turns if stretch.start < value < stretch.end]


def _extrapolated(topology: Topology, sheet: Sheet, stretch: Stretch, steps: int) -> float:
    """The integral forwards, from sums of 1, 2, 4 and 8 times as many steps; of one step as it is."""
    counts = (1,) if steps == 1 else (steps, 2 * steps, 4 * steps, 8 * steps)
    values = [_polyline_area(sheet, _line(topology, sheet, stretch, count)) for count in counts]
    factor = 4.0
    while len(values) > 1:
        values = [(factor * fine - coarse) / (factor - 1) for coarse, fine in itertools.pairwise(values)]
        factor *= 4.0
    return values[0]


def _line(topology: Topology, sheet: Sheet, stretch: Stretch, count: int) -> NDArray[np.float64]:
    points = topology.carrier(stretch.carrier).at(np.linspace(stretch.start, stretch.end, count + 1))
    return unwrapped(sheet, points)


def _polyline_area(sheet: Sheet, flat: NDArray[np.float64]) -> float:
    x, y = flat[:, 0], flat[:, 1]
    if sheet.turn is not None:
        return float(-np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))
    return 0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))


def volume_ledger(parts: Parts, curves: Sequence[Curve], solid: float) -> tuple[LedgerRow, ...]:
    """The rows of all joints of walls, and of every segment whose own shape is not its idealised one.

    curves: of the topology. solid: the volume of the solid. Rows that cancel out are left out.
    """
    total = sum(segment.volume for segment in parts.segments.values())
    order = {name: place for place, name in enumerate(parts.segments)}
    rows = _Rows(order, NEGLIGIBLE * total)
    rows.add((), "the segments' volumes against the solid's", SHAPE, {}, total - solid)
    for name, beam in parts.beams.items():
        own = beam.section.area * (beam.end - beam.start) - beam.segment.volume
        rows.add((name,), "section times length against the beam's own shape", SHAPE, {name: own})
    shapes = {name: _shape(parts, wall) for name, wall in parts.walls.items()}
    shapes.update({name: -parts.segments[name].volume for name in parts.absorbed})
    groups = _groups(parts)
    closed: dict[int, list[Row]] = {}
    for row in closed_forms(parts.topology, curves, list(parts.walls.values())):
        closed.setdefault(groups[row[0][0]], []).append(row)
    by_carrier: dict[int, list[Curve]] = {}
    for curve in curves:
        by_carrier.setdefault(curve.carrier, []).append(curve)
    for row in (*_filled_wedges(parts, by_carrier), *_trimmed_edges(parts, by_carrier), *_cut_stubs(parts)):
        closed.setdefault(groups[row[0][0]], []).append(row)
    members: dict[int, list[str]] = {}
    for name in shapes:
        members.setdefault(groups[name], []).append(name)
    for group, names in members.items():
        # by segment: what it counts more than its own mid-section, less the joints' rows
        left = {name: _gained(parts, parts.walls[name]) if name in parts.walls else 0.0 for name in names}
        for segments, cause, volume in closed.get(group, []):
            shares = dict.fromkeys(segments, volume / len(segments))
            rows.add(segments, cause, JOINT, shares)
            for name, share in shares.items():
                left[name] -= share
        whole = {name: left[name] + shapes[name] for name in names}
        if abs(sum(whole.values())) <= CLOSES * total:
            # what faces askew gained or lost is what the walls that meet there lost or gained
            rows.add(tuple(names), MATERIAL, BALANCE, whole)
            continue
        if abs(sum(whole.values())) <= FACETED * total and any(cause == PIPES for _, cause, _ in closed.get(group, [])):
            rest = sum(whole.values()) / len(whole)
            rows.add(tuple(names), MATERIAL, BALANCE, {name: volume - rest for name, volume in whole.items()})
            rows.add(tuple(names), "facets where curved faces meet flat", UNEXPLAINED, dict.fromkeys(names, rest))
            continue
        for name in names:
            cause = "material of a corner, counted by the walls that meet there"
            if name in parts.walls:
                cause = "its own faces are not square to the mid-surface"
            rows.add((name,), cause, SHAPE, {name: shapes[name]})
        is_closed = abs(sum(left.values())) <= CLOSES * total
        cause = MATERIAL if is_closed else NO_FORM
        rows.add(tuple(names), cause, BALANCE if is_closed else UNEXPLAINED, left)
    return rows.result()


MATERIAL = "material of joints, divided between their segments"
NO_FORM = "joints of walls without a closed form"
WEDGE = "a square end carried on to the face that it meets askew"
STUB = "a stub in the bore of a chord, cut off where it runs into another brace's"
TRIMMED = "an edge cut back to a joint also where nothing stands against it"


def _cut_stubs(parts: Parts) -> Iterator[Row]:
    """What braces lose whose stubs in a chord's bore are cut off."""
    for stub in parts.stubs:
        yield (stub.brace.segment.id,), STUB, -stub.area * stub.brace.thickness


def _trimmed_edges(parts: Parts, by_carrier: dict[int, list[Curve]]) -> Iterator[Row]:
    """What walls lose that are cut back all along an edge, where what stands against it leaves some of it bare."""
    on_carrier: dict[int, list[Crossing]] = {}
    for crossing in parts.crossings:
        on_carrier.setdefault(crossing.carrier, []).append(crossing)
    for carrier, beside in on_carrier.items():
        period = parts.topology.carrier(carrier).period
        for curve in by_carrier.get(carrier, []):
            if [use.role for use in curve.uses.values()] != [BOUNDARY]:
                continue
            middle = 0.5 * (curve.start + curve.end)
            reaching = [(one, wall) for one in beside for wall in one.walls if _reaches(one, wall, middle, period)]
            if {wall.index for _, wall in reaching} != set(curve.uses):
                continue
            crossing, wall = reaching[0]
            other = crossing.other(wall)
            normal = other.sheet.normals(parts.topology.carrier(carrier).at(np.array([middle])))[0]
            side = float(np.sign(_inward(wall, curve, parts.topology) @ normal))
            area = strip_area(parts.topology, curve, wall, other, -side)
            yield (wall.segment.id,), TRIMMED, -wall.thickness * area


def _reaches(crossing: Crossing, wall: Wall, value: float, period: float | None) -> bool:
    """Whether the wall's own material reaches the joint curve at a parameter of it."""
    turns = (0.0,) if period is None else (-period, 0.0, period)
    return any(start <= value + turn <= end for start, end in crossing.reach[wall.index] for turn in turns)


def _filled_wedges(parts: Parts, by_carrier: dict[int, list[Curve]]) -> Iterator[Row]:
    """What walls gain that are cut square, touch another with one corner only, and are carried on to it."""
    for crossing in parts.crossings:
        for number in crossing.gap:
            web = next(wall for wall in crossing.walls if wall.index == number)
            flange = crossing.other(web)
            on_carrier = by_carrier.get(crossing.carrier, [])
            shared = [curve for curve in on_carrier if {web.index, flange.index} <= set(curve.uses)]
            if not shared:
                continue
            ends = np.linspace(shared[0].start, shared[0].end, 7)[1:-1]
            points = parts.topology.carrier(crossing.carrier).at(ends)
            normal = flange.sheet.normals(points[:1])[0]
            side = float(np.sign(_inward(web, shared[0], parts.topology) @ normal))
            own = own_edge(parts.topology, crossing, web, flange, side)
            if own is not None and not is_filled(parts.topology, web, (flange,), points, side, own[0]):
                gap, edge = own
                length = sum(s.end - s.start for ring in web.rings for s in ring if s.carrier == edge)
                sine = float(np.linalg.norm(np.cross(web.sheet.normals(points[:1])[0], normal)))
                yield (web.segment.id, flange.segment.id), WEDGE, web.thickness * length * gap / sine


def _inward(wall: Wall, curve: Curve, topology: Topology) -> NDArray[np.float64]:
    """Unit vector (3,) from amid a curve into a wall that ends on it."""
    middle, ahead = 0.5 * (curve.start + curve.end), 1e-3 * curve.length
    before, amid, after = topology.carrier(curve.carrier).at(np.array([middle - ahead, middle, middle + ahead]))
    inward = np.cross(wall.sheet.normals(amid[None])[0], after - before) * (
        1.0 if curve.uses[wall.index].forward else -1.0
    )
    return np.asarray(inward / np.linalg.norm(inward))


def unexplained(rows: Sequence[LedgerRow], volume: float) -> list[str]:
    """A warning where rows without a closed form come to more than NOTABLE of the model's volume."""
    odd = [row for row in rows if row.kind == UNEXPLAINED and abs(row.volume) > NOTABLE * volume]
    return [
        f"no closed form is known for what the joints of {' '.join(row.segments)} count twice: "
        f"{row.volume / volume:+.2%} of the volume, measured"
        for row in odd
    ]


def misfits(rows: Sequence[LedgerRow], segments: Sequence[Segment]) -> dict[str, str]:
    """By segment id, what is wrong with its thickness, to follow the id: plates and cylinder-plates off by MISFIT."""
    off: dict[str, float] = {}
    for row in rows:
        if row.kind == SHAPE:
            for name, share in row.shares.items():
                off[name] = off.get(name, 0.0) + share
    found = {}
    for segment in segments:
        share, thickness = off.get(segment.id, 0.0) / segment.volume, segment.thickness
        if thickness is not None and abs(share) > MISFIT:
            found[segment.id] = (
                f"({segment.node}) is {thickness:.4g} thick as a {segment.type}, and its material "
                f"{thickness / (1.0 + share):.4g} on average ({share:+.1%} of its volume), expected within "
                f"{MISFIT:.0%}: another type for it, or its parts by themselves"
            )
    return found


class _Rows:
    """Rows gathered by segments and cause."""

    def __init__(self, order: dict[str, int], least: float) -> None:
        self._order, self._least = order, least
        self._rows: dict[tuple[tuple[str, ...], str, str], tuple[dict[str, float], float]] = {}

    def add(
        self, names: tuple[str, ...], cause: str, kind: str, shares: dict[str, float], volume: float | None = None
    ) -> None:
        """More of a row. volume: where it is not the sum of the shares."""
        key = (tuple(sorted(set(names), key=self._order.__getitem__)), cause, kind)
        known, before = self._rows.get(key, ({}, 0.0))
        for name, share in shares.items():
            known[name] = known.get(name, 0.0) + share
        self._rows[key] = (known, before + (sum(shares.values()) if volume is None else volume))

    def result(self) -> tuple[LedgerRow, ...]:
        """All rows that are more than rounding, of balances those that any segment has a share in."""
        found = []
        for (names, cause, kind), (shares, volume) in self._rows.items():
            if kind == BALANCE:
                if max(map(abs, shares.values()), default=0.0) > self._least:
                    found.append(LedgerRow(names, cause, 0.0, shares, kind))
            elif abs(volume) > self._least:
                found.append(LedgerRow(names, cause, volume, shares, kind))
        return tuple(found)


def _shape(parts: Parts, wall: Wall) -> float:
    """The wall's own mid-section times its thickness, less its own volume."""
    rings = [stretch for ring in wall.rings for stretch in ring]
    return outline_area(parts.topology, wall.sheet, rings) * wall.thickness - wall.segment.volume


def _gained(parts: Parts, wall: Wall) -> float:
    """What the wall's region counts more than its own mid-section."""
    rings = [stretch for ring in wall.rings for stretch in ring]
    areas = (outline_area(parts.topology, wall.sheet, outline) for outline in (wall.outline, rings))
    return (next(areas) - next(areas)) * wall.thickness


def _groups(parts: Parts) -> dict[str, int]:
    """A number for each wall and each corner's material, the same for those that touch one another."""
    place = {name: number for number, name in enumerate([*parts.walls, *parts.absorbed])}
    bodies = Bodies()
    for joint in parts.contacts:
        if all(name in place for name in joint.segments):
            bodies.join(*(place[name] for name in joint.segments))
    return {name: bodies.find(number) for name, number in place.items()}
