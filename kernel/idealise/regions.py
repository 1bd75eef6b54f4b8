"""Regions: what of its sheet each wall covers once walls that cross are carried on, or cut back, to where they meet.

In the wall's own flat frame, with strips for the slabs of the walls that it crosses:

    +-----------+--:--+        own section, strip, and the joint curve ":" amid the strip
    |           |  :  |
    |    own    |  :  |        cells = own and strips, within the material, cut along the joint curves
    |           |  :  |        a cell that holds nothing of the wall outside the strips, and ends elsewhere
    +-----------+--:--+        than on joint curves, goes; so a corner ends on the curve, whoever owned it, as far as
                               the other wall stands there (trims.py)

Polygons are for combinatorics only: every edge of the result is put back on its carrier.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import LineString, Polygon

from kernel.idealise.carriers import Line
from kernel.idealise.crossings import CURVED_OVERLAP, Crossing, merged, samples, slab_edges, whole_range
from kernel.idealise.outlines import (
    PolygonLike,
    Stretch,
    domain,
    even_odd,
    meeting_point,
    ring_points,
    stretch_between,
    unwrapped,
    windowed,
)
from kernel.idealise.sheets import CylinderSheet, PlaneSheet, Sheet
from kernel.idealise.strips import slab, slabs_of_tube, strip
from kernel.idealise.topology import Topology
from kernel.idealise.trims import step_ends, trimmed
from kernel.idealise.tube_curve import TubeCurve
from kernel.idealise.walls import Wall, section_outline
from kernel.segment.segments import Segment
from kernel.segment.slices import parts_of

Array = NDArray[np.float64]

GRID = 1e-7
"""Polygons are rounded to this share of the model's size while they are combined."""

ON_CARRIER = 3e-6
"""An edge nearer than this share of the model's size to a carrier lies on it."""

CUT_BEYOND = 0.2
"""Joint curves cut the cells this share of half the slab beyond their ends, so that ends never fall short."""

HELD = 1e-3
"""A cell holds part of the wall when it has this share of its area (or of the thickness squared) outside strips."""

PINHOLE = 0.01
"""Holes beside a lump of two tubes are closed when smaller than this share of the thickness squared."""

FREE = 0.3
"""A cell that holds nothing goes when more than this share of its outline is no joint curve."""

CRUMB = 0.02
"""Islands smaller than this share of the region are joint material of others."""


def join_walls(
    topology: Topology, walls: Sequence[Wall], crossings: Sequence[Crossing], nearby: dict[int, list[Segment]]
) -> None:
    """Set region and outline of every wall that crosses others. nearby: by wall index, the segments around it."""
    by_wall: dict[int, list[Crossing]] = {}
    for crossing in crossings:
        for wall in crossing.walls:
            by_wall.setdefault(wall.index, []).append(crossing)
    sections = _Sections(topology)
    for wall in walls:
        if wall.index in by_wall:
            region = _region(topology, wall, by_wall[wall.index], nearby[wall.index], sections)
            joint_carriers = {crossing.carrier for crossing in by_wall[wall.index]}
            wall.outline, wall.region = outline_of(topology, wall, region, joint_carriers)


def _region(
    topology: Topology, wall: Wall, crossings: list[Crossing], nearby: list[Segment], sections: _Sections
) -> PolygonLike:
    size = topology.carriers.reach
    grid = GRID * size
    strips, gaps, lumps, cuts, cutting = [], [], [], [], []
    on_carrier: dict[int, list[Crossing]] = {}
    for crossing in crossings:
        on_carrier.setdefault(crossing.carrier, []).append(crossing)
    for crossing in crossings:
        carrier = topology.carrier(crossing.carrier)
        other = crossing.other(wall)
        strips += [strip(topology, wall, crossing, *ends) for ends in crossing.reach[wall.index]]
        gap = crossing.gap.get(wall.index, 0.0)
        if gap:
            gaps += [strip(topology, wall, crossing, *ends, gap) for ends in crossing.reach[wall.index]]
        trims = trimmed(topology, crossing, wall, on_carrier[crossing.carrier])
        cutting += [strip(topology, wall, crossing, *ends, gap) for ends in trims]
        if isinstance(carrier, TubeCurve) and crossing.reach[wall.index]:
            around, whole = slabs_of_tube(topology, wall, other, carrier)
            lumps += around
            cutting += whole
        beyond = CUT_BEYOND * 0.5 * other.thickness
        along = [*trims, *crossing.reach[other.index]]
        for start, end in merged(along, 10 * topology.tolerance, carrier.period):  # chords that differ leave slivers
            is_all = carrier.period is not None and end - start >= carrier.period - topology.tolerance
            more = 0.0 if is_all else beyond
            curve = samples(topology, carrier, start - more, end + more)
            cuts.append(windowed(wall.sheet, LineString(unwrapped(wall.sheet, curve))))
        for value in step_ends(crossing, wall, trims, 10 * topology.tolerance):
            ends = slab_edges(wall, other, carrier.at(np.array([value])), gap + beyond, carrier)
            cuts.append(windowed(wall.sheet, LineString(unwrapped(wall.sheet, np.vstack(ends)))))
    own = _without_dust(topology, wall, crossings)
    held = own.difference(shapely.union_all(cutting)) if cutting else own
    bridged = [part for crossing in crossings for part in _bridges(topology, wall, crossing)]
    material = shapely.union_all([wall.own, *bridged, *_material(wall, nearby, sections)], grid_size=grid)
    grown = shapely.intersection(shapely.union_all([own, *strips, *lumps], grid_size=grid), material, grid_size=grid)
    grown = shapely.union_all(parts_of(shapely.union_all([grown, *gaps], grid_size=grid)))
    if lumps:
        grown = _without_pinholes(grown, shapely.union_all(lumps), PINHOLE * wall.thickness**2)
    curves = shapely.union_all(cuts)
    lines = shapely.union_all([grown.boundary, curves], grid_size=grid)
    near_curves: shapely.Geometry | None = None
    kept = []
    for cell in parts_of(shapely.polygonize(list(shapely.get_parts(lines)))):
        if not grown.contains(cell.representative_point()):
            continue
        if cell.intersection(held).area > HELD * min(cell.area, wall.thickness**2):
            kept.append(cell)
            continue
        near_curves = curves.buffer(20 * grid) if near_curves is None else near_curves
        if cell.boundary.difference(near_curves).length < FREE * cell.boundary.length:
            kept.append(cell)
    region = shapely.union_all(kept, grid_size=grid)
    return shapely.union_all([part for part in parts_of(region) if part.area >= CRUMB * region.area])


def _bridges(topology: Topology, wall: Wall, crossing: Crossing) -> list[PolygonLike]:
    """What closes the slivers between the wall's own section and that of a curved wall on which it ends.

    Both are polylines there, whose chords differ where the wall ends between two points of the other's.
    """
    other, carrier = crossing.other(wall), topology.carrier(crossing.carrier)
    if isinstance(carrier, Line | TubeCurve):
        return []
    fringe = wall.own.buffer(CURVED_OVERLAP * min(wall.thickness, other.thickness), join_style="mitre")
    return [strip(topology, wall, crossing, *ends).intersection(fringe) for ends in crossing.reach[wall.index]]


def _without_dust(topology: Topology, wall: Wall, crossings: list[Crossing]) -> PolygonLike:
    """The wall's section less its islands within other walls' slabs: corner posts that this wall happened to win."""
    parts = parts_of(wall.own)
    if len(parts) < 2:
        return wall.own
    slabs = shapely.union_all([slab(topology, wall, crossing) for crossing in crossings])
    kept = [part for part in parts if part.difference(slabs).area > 0.2 * part.area]
    return shapely.union_all(kept) if kept else wall.own


def _without_pinholes(region: PolygonLike, lumps: PolygonLike, least: float) -> PolygonLike:
    """The region less its holes where two tubes merge, or which are smaller than `least` (an area) and reach out of it.

    Sections that end there at hardly any angle leave some.
    """
    holes = [Polygon(ring) for part in parts_of(region) for ring in part.interiors]
    pinholes = [hole for hole in holes if lumps.contains(hole) or (hole.area < least and lumps.intersects(hole))]
    return shapely.union_all([region, *pinholes])


class _Sections:
    """Sections of segments in sheets; walls in one plane, as those on both sides of a third, ask for the same ones."""

    def __init__(self, topology: Topology) -> None:
        self._topology = topology
        self._known: dict[tuple[str, int, bytes, bytes], tuple[PolygonLike, set[int]] | None] = {}

    def of(self, segment: Segment, sheet: Sheet) -> tuple[PolygonLike, set[int]] | None:
        """The section in the sheet's coordinates and the carriers of its outline; None where they do not meet."""
        if not isinstance(sheet, PlaneSheet):
            return self._made(segment, sheet)
        key = (segment.id, sheet.surface_id, sheet.u.tobytes(), sheet.v.tobytes())
        if key not in self._known:
            self._known[key] = self._made(segment, sheet)
        return self._known[key]

    def _made(self, segment: Segment, sheet: Sheet) -> tuple[PolygonLike, set[int]] | None:
        rings = section_outline(self._topology, segment.solid, sheet)
        if not rings:
            return None
        return domain(self._topology, sheet, rings), {stretch.carrier for ring in rings for stretch in ring}


def _material(wall: Wall, nearby: list[Segment], sections: _Sections) -> list[PolygonLike]:
    """Sections of the segments around the wall in its sheet; their carriers become known to it."""
    found: list[PolygonLike] = []
    known = set(wall.known)
    for segment in nearby:
        section = sections.of(segment, wall.sheet)
        if section is not None:
            found.append(section[0])
            known |= section[1]
    wall.known = sorted(known)
    return found


# ---------------------------------------------------------------- polygons back onto carriers


def outline_of(
    topology: Topology, wall: Wall, region: PolygonLike, joint_carriers: set[int]
) -> tuple[list[Stretch], PolygonLike]:
    """The region's outline as stretches of carriers, the region on their left; and the region, exact again."""
    lines = {number: drawn(topology, wall.sheet, number, region) for number in sorted(set(wall.known))}
    lines = {number: line for number, line in lines.items() if line is not None}
    outline: list[_Cut] = []
    rings: list[Array] = []
    for polygon in parts_of(region):
        polygon = shapely.geometry.polygon.orient(polygon)
        for ring in (polygon.exterior, *polygon.interiors):
            cuts = _ring_outline(topology, wall.sheet, np.asarray(ring.coords)[:, :2], lines, joint_carriers)
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


def _ring_outline(
    topology: Topology, sheet: Sheet, points: Array, lines: dict[int, shapely.Geometry], preferred: set[int]
) -> list[_Cut]:
    size = topology.carriers.reach
    points = _without_specks(points, 3 * topology.tolerance)
    if len(points) < 4:
        return []
    labels = _labels(topology, sheet, points, lines, preferred, ON_CARRIER * size)
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
    kept = [points[0]]
    for point in points[1:-1]:
        if np.linalg.norm(point - kept[-1]) > shortest:
            kept.append(point)
    if len(kept) > 1 and np.linalg.norm(kept[-1] - kept[0]) <= shortest:
        kept.pop()
    return np.array([*kept, kept[0]])


def _labels(
    topology: Topology,
    sheet: Sheet,
    points: Array,
    lines: dict[int, shapely.Geometry],
    preferred: set[int],
    reach: float,
) -> list[int | None]:
    """The carrier of each edge; None for edges on the seam of a closed sheet."""
    corner, middle = shapely.points(points[:-1]), shapely.points(0.5 * (points[:-1] + points[1:]))
    best = np.full(len(points) - 1, np.inf)
    labels: list[int | None] = [None] * len(best)
    for number, line in lines.items():
        at_corner = shapely.distance(corner, line)
        away = np.maximum(np.maximum(at_corner, np.roll(at_corner, -1)), shapely.distance(middle, line))
        rank = away - (0.5 * reach if number in preferred else 0.0)
        for k in np.nonzero((away <= reach) & (rank < best))[0]:
            best[k], labels[k] = rank[k], number
    for first, end in _straight_runs(points, np.isinf(best), 3 * topology.tolerance):
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
