"""The ledger: where the idealised model counts volume more often, or less often, than the solid has it.

Regions times thickness, and sections times length, against the segments' own volumes. What a wall gained or lost
within the slab of another goes to the pair; for a tee of length L that comes to + t t' L / (2 sin angle), for a cross
to twice that, for a corner to 0.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.idealise.carriers import Circle, Line
from kernel.idealise.crossings import Crossing, whole_range
from kernel.idealise.members import LedgerRow
from kernel.idealise.outlines import PolygonLike, Stretch, unwrapped
from kernel.idealise.parts import Parts
from kernel.idealise.regions import strip
from kernel.idealise.sheets import PlaneSheet, Sheet
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall

NEGLIGIBLE = 1e-12
"""Rows smaller than this share of the model's volume are rounding."""

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
    counts = (1,) if isinstance(carrier, Line) else (_STEPS, 2 * _STEPS, 4 * _STEPS, 8 * _STEPS)
    values = [_polyline_area(sheet, _line(topology, sheet, stretch, count)) for count in counts]
    factor = 4.0
    while len(values) > 1:
        values = [(factor * fine - coarse) / (factor - 1) for coarse, fine in itertools.pairwise(values)]
        factor *= 4.0
    return sign * values[0]


def _line(topology: Topology, sheet: Sheet, stretch: Stretch, count: int) -> NDArray[np.float64]:
    points = topology.carrier(stretch.carrier).at(np.linspace(stretch.start, stretch.end, count + 1))
    return unwrapped(sheet, points)


def _polyline_area(sheet: Sheet, flat: NDArray[np.float64]) -> float:
    x, y = flat[:, 0], flat[:, 1]
    if sheet.turn is not None:
        return float(-np.sum(0.5 * (y[1:] + y[:-1]) * np.diff(x)))
    return 0.5 * float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))


def volume_ledger(parts: Parts) -> tuple[LedgerRow, ...]:
    """One row for each pair of walls that cross, and for each segment whose own shape is not its idealised one."""
    total = sum(segment.volume for segment in parts.segments.values())
    rows: dict[tuple[tuple[str, ...], str], dict[str, float]] = {}

    def add(names: tuple[str, ...], cause: str, volume: float, of: str) -> None:
        shares = rows.setdefault((names, cause), {})
        shares[of] = shares.get(of, 0.0) + volume

    order = {name: place for place, name in enumerate(parts.segments)}
    for name, wall in parts.walls.items():
        own = outline_area(parts.topology, wall.sheet, [stretch for ring in wall.rings for stretch in ring])
        askew = own * wall.thickness - wall.segment.volume
        add((name,), "its own faces are not square to the mid-surface", askew, name)
        moved = outline_area(parts.topology, wall.sheet, wall.outline) - own
        for names, area in _moved(parts.topology, wall, parts.crossings_of(wall), moved):
            add(tuple(sorted(names, key=order.__getitem__)), "mid-surfaces meet", area * wall.thickness, name)
    for name, beam in parts.beams.items():
        own = beam.section.area * (beam.end - beam.start)
        add((name,), "section times length against the beam's own shape", own - beam.segment.volume, name)
    for name in sorted(parts.absorbed):
        add((name,), "material of a corner, counted by the walls that meet there", -parts.segments[name].volume, name)
    return tuple(
        LedgerRow(names, cause, float(sum(shares.values())), {of: float(share) for of, share in shares.items()})
        for (names, cause), shares in rows.items()
        if abs(sum(shares.values())) > NEGLIGIBLE * total
    )


def _moved(
    topology: Topology, wall: Wall, crossings: Sequence[Crossing], moved: float
) -> list[tuple[tuple[str, ...], float]]:
    """What the wall's region gained less what it lost, by the walls in whose slabs: one in a joint, two in a corner.

    moved: the exact sum; what polygons round away goes to the largest item.
    """
    name = wall.segment.id
    if not crossings:
        return [((name,), moved)]
    changes = ((1.0, wall.region.difference(wall.own)), (-1.0, wall.own.difference(wall.region)))
    slabs: dict[str, PolygonLike] = {}
    for crossing in crossings:
        carrier = topology.carrier(crossing.carrier)
        other = crossing.other(wall).segment.id
        slab = strip(topology, wall, crossing, *whole_range(topology, carrier, wall.segment.solid.bounds))
        slabs[other] = shapely.union(slabs[other], slab) if other in slabs else slab
    items: dict[tuple[str, ...], float] = {}
    for sign, change in changes:
        near = {other: slab for other, slab in slabs.items() if slab.intersects(change)}
        for first, second in itertools.combinations(near, 2):
            corner = near[first].intersection(near[second])
            if not corner.is_empty:
                key = (name, first, second)
                items[key] = items.get(key, 0.0) + sign * float(change.intersection(corner).area)
                change = change.difference(corner)
        for other, slab in near.items():
            items[(name, other)] = items.get((name, other), 0.0) + sign * float(change.intersection(slab).area)
            change = change.difference(slab)
    if not items:
        return [((name,), moved)]
    largest = max(items, key=lambda key: abs(items[key]))
    items[largest] += moved - sum(items.values())
    return list(items.items())
