"""What a user can name as a curve: pieces of the topology, of bricks' sections, axes of beams, edges along a sweep.

A closed curve that at most one thing meets stands in the topology as two halves (topology.py), and edges have vertices
where a joint that ends short of them points at them; here such pieces are one item.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.idealise.brick import SweepGroup
from kernel.idealise.carriers import Carrier
from kernel.idealise.parts import Parts
from kernel.idealise.topology import BOUNDARY, Curve, Topology
from kernel.solid.solid import Solid
from kernel.solid.surfaces import FacetedSurface, signed_distance

Array = NDArray[np.float64]

ON_SURFACE = 1e-6
"""Points nearer than this share of the model's size to a surface lie on it."""

SAMPLES = np.array([0.5, 0.06, 0.28, 0.72, 0.94])
"""Shares of a curve's length at which it is looked at, its middle first."""

SAGITTA = 1.5
"""Centroids of facets lie within a curved surface by less than its chords do, by about this factor."""

CLOSED = 1e-6
"""Share of a full turn that may be missing in a closed curve."""

WALLS = -1
"""The topology of the walls, where sections of groups of bricks are numbered from 0."""


@dataclass(frozen=True, slots=True, eq=False)
class Item:
    """Something that can be divided. segments: ids of those that have it; outline_of: of those that end at it.

    kind: "curve", "axis" or "rise" (an edge along a sweep). samples: (m, n, 3) points of it, amid it first, at each of
    the m places where a section's curve bounds a brick. slack: how far from it the surfaces may end that it lies on.
    """

    kind: str
    segments: frozenset[str]
    outline_of: frozenset[str]
    samples: Array
    slack: float = 0.0

    @property
    def middle(self) -> Array:
        """A point (3,) amid it."""
        middle: Array = self.samples[0, 0]
        return middle


@dataclass(frozen=True, slots=True, eq=False)
class CurveItem(Item):
    """A curve, by its places in its topology's list of curves: one, or several that lie end to end.

    topology: WALLS, or the number of a group of bricks. shifts: (m, 3) from the curve to where it can be seen.
    """

    topology: int = WALLS
    places: tuple[int, ...] = ()
    carrier: Carrier | None = None
    ends: tuple[tuple[float, float], ...] = ()
    shifts: Array = field(default_factory=lambda: np.zeros((1, 3)))

    @property
    def lengths(self) -> Array:
        """Of its pieces, (k,)."""
        return np.array([end - start for start, end in self.ends])

    @property
    def length(self) -> float:
        """All round, where it is closed."""
        return float(self.lengths.sum())

    @property
    def is_closed(self) -> bool:
        """It has no ends."""
        assert self.carrier is not None
        period = self.carrier.period
        return period is not None and self.length > (1 - CLOSED) * period

    def distance(self, point: Array) -> float:
        """From a point (3,)."""
        assert self.carrier is not None
        least = np.inf
        for shift in self.shifts:
            target = point - shift
            value = float(self.carrier.parameters(target[None])[0])
            period = self.carrier.period
            tries = (value, value + period, value - period) if period else (value,)
            near = np.array([np.clip(tried, start, end) for start, end in self.ends for tried in tries])
            least = min(least, float(np.linalg.norm(self.carrier.at(near) - target, axis=1).min()))
        return float(least)


@dataclass(frozen=True, slots=True, eq=False)
class StraightItem(Item):
    """A beam's axis (by its segment), or the edges (k lines) along which a piece of a group of bricks is swept.

    group: of the bricks; span: where the piece starts and ends along the sweep. lines: (k, 2, 3).
    """

    name: str = ""
    group: int = 0
    span: tuple[float, float] = (0.0, 0.0)
    lines: Array = field(default_factory=lambda: np.empty((0, 2, 3)))

    @property
    def length(self) -> float:
        """Of one of the lines."""
        return float(np.linalg.norm(self.lines[0, 1] - self.lines[0, 0]))

    def distance(self, point: Array) -> float:
        """From a point (3,)."""
        start, along = self.lines[:, 0], self.lines[:, 1] - self.lines[:, 0]
        share = np.einsum("ij,ij->i", point - start, along) / np.einsum("ij,ij->i", along, along)
        nearest = start + np.clip(share, 0, 1)[:, None] * along
        return float(np.linalg.norm(nearest - point, axis=1).min())


AnyItem = CurveItem | StraightItem


def items_of(parts: Parts, curves: Sequence[Curve]) -> list[AnyItem]:
    """Everything that can be named. curves: of the walls' topology."""
    walls = {wall.index: wall for wall in parts.walls.values()}
    items: list[AnyItem] = []
    for places in _merged(curves, parts.topology):
        curve = curves[places[0]]
        seats = _seated(parts, curve)
        items.append(
            CurveItem(
                kind="curve",
                segments=frozenset(walls[face].segment.id for face in curve.uses) | seats,
                outline_of=frozenset(walls[face].segment.id for face, u in curve.uses.items() if u.role == BOUNDARY),
                samples=_samples(parts.topology, curve)[None],
                slack=0.5 * max(walls[face].thickness for face in curve.uses),
                places=places,
                carrier=parts.topology.carrier(curve.carrier),
                ends=tuple((curves[place].start, curves[place].end) for place in places),
            )
        )
    for name, beam in parts.beams.items():
        line = np.array([beam.at(beam.start), beam.at(beam.end)])
        own = frozenset([name])
        amid = line.mean(axis=0)[None, None]
        items.append(StraightItem(kind="axis", segments=own, outline_of=own, samples=amid, name=name, lines=line[None]))
    for number, group in enumerate(parts.sweeps):
        items += _section_items(number, group)
        items += _rises(number, group)
    return items


def on_surfaces(solid: Solid, items: Sequence[AnyItem], reach: float) -> list[int]:
    """Places of the curves that lie on the solid's own surfaces, no further from its facets than their slack.

    reach: the model's size.
    """
    facets = solid.facets
    places = np.array([k for k, item in enumerate(items) for _ in item.samples if item.kind == "curve"], np.int64)
    if not len(places) or not len(facets.triangles):
        return []
    samples = np.concatenate([item.samples for item in items if item.kind == "curve"])
    found: set[int] = set()
    for number in np.unique(facets.surface).tolist():
        surface = solid.surfaces.surfaces[number]
        if isinstance(surface, FacetedSurface):
            continue
        away = np.abs(signed_distance(surface, samples.reshape(-1, 3))).reshape(len(samples), -1).max(axis=1)
        rows = np.flatnonzero(away <= ON_SURFACE * reach)
        if not len(rows):
            continue
        own = facets.surface == number
        corners = facets.vertices[facets.triangles[own]]
        sagitta = SAGITTA * float(np.abs(signed_distance(surface, facets.centroids[own])).max())
        for row in rows.tolist():
            if _distance(corners, samples[row, 0]) <= items[places[row]].slack + sagitta + ON_SURFACE * reach:
                found.add(int(places[row]))
    return sorted(found)


def _distance(corners: Array, point: Array) -> float:
    from kernel.mesh.boundary import closest_on_triangles

    there = np.broadcast_to(point, (len(corners), 3))
    return float(np.linalg.norm(closest_on_triangles(corners, there) - there, axis=1).min())


def _samples(topology: Topology, curve: Curve) -> Array:
    return topology.carrier(curve.carrier).at(curve.start + SAMPLES * curve.length)


def _merged(curves: Sequence[Curve], topology: Topology) -> list[tuple[int, ...]]:
    """The places of all curves in order, those together that only a vertex parts at which nothing else meets.

    Such are the halves of a closed curve, and pieces of an edge that something would have reached, had it gone on.
    """
    meeting: dict[int, set[int]] = {}
    alike: dict[tuple[int, tuple[int, ...], int], list[int]] = {}  # meshed apart, each wall has curves of its own
    for place, curve in enumerate(curves):
        for vertex in curve.vertices:
            meeting.setdefault(vertex, set()).add(curve.carrier)
            alike.setdefault((curve.carrier, tuple(sorted(curve.uses)), vertex), []).append(place)
    root = list(range(len(curves)))

    def first_of(place: int) -> int:
        while root[place] != place:
            place = root[place]
        return place

    for (_, _, vertex), places in alike.items():
        if len(places) == 2 and len(meeting[vertex]) == 1:
            a, b = sorted(first_of(place) for place in places)
            root[b] = a
    chains: dict[int, list[int]] = {}
    for place in range(len(curves)):
        chains.setdefault(first_of(place), []).append(place)
    return [tuple(chain) for chain in chains.values()]


def _seated(parts: Parts, curve: Curve) -> frozenset[str]:
    """The beams that lie along the curve."""
    found = set()
    point = _samples(parts.topology, curve)[0]
    for name, seats in parts.seats.items():
        for seat in seats:
            if seat.carrier == curve.carrier and seat.wall.index in curve.uses:
                if seat.start <= float(point @ parts.beams[name].direction) <= seat.end:
                    found.add(name)
    return frozenset(found)


def _section_items(number: int, group: SweepGroup) -> list[AnyItem]:
    """The curves of a group's own section, seen where they bound its pieces."""
    section = group.section
    if section is None:
        return []
    tolerance = ON_SURFACE * section.topology.carriers.reach
    pieces = [(brick.segment.id, piece) for brick in group.bricks for piece in brick.pieces]
    items: list[AnyItem] = []
    for places in _merged(section.curves, section.topology):
        curve = section.curves[places[0]]
        samples = _samples(section.topology, curve)
        middle = shapely.Point(group.sheet.flat(samples[:1])[0])
        reach = max(tolerance, 2e-3 * curve.length)  # outlines are polygons
        held = [(name, piece) for name, piece in pieces if piece.outline.distance(middle) <= reach]
        ends = [(name, piece) for name, piece in held if piece.outline.boundary.distance(middle) <= reach]
        seen = [piece for _, piece in (ends or held)]
        if not seen:
            continue
        normal, offset = group.sheet.normal, group.sheet.offset
        amid = [normal * (0.5 * (piece.start + piece.end) - offset) for piece in seen]
        levels = sorted({level for piece in seen for level in (piece.start, piece.end)})
        items.append(
            CurveItem(
                kind="curve",
                segments=frozenset(name for name, _ in held),
                outline_of=frozenset(name for name, _ in ends),
                samples=np.array([samples + shift for shift in amid]),
                topology=number,
                places=places,
                carrier=section.topology.carrier(curve.carrier),
                ends=tuple((section.curves[place].start, section.curves[place].end) for place in places),
                shifts=np.array([normal * (level - offset) for level in levels]),
            )
        )
    return items


def _rises(number: int, group: SweepGroup) -> list[AnyItem]:
    """For each piece of a group's bricks, its edges along the sweep: where its section has a corner."""
    items: list[AnyItem] = []
    normal = group.sheet.normal
    for brick in group.bricks:
        for piece in brick.pieces:
            corners = group.sheet.lift(_corners(piece.outline)) - normal * group.sheet.offset
            if len(corners):
                lines = np.stack([corners + normal * piece.start, corners + normal * piece.end], axis=1)
                own = frozenset([brick.segment.id])
                span = (piece.start, piece.end)
                amid = lines[:1].mean(axis=1)[None]
                rise = StraightItem("rise", own, frozenset(), amid, group=number, span=span, lines=lines)
                items.append(rise)
    return items


def _corners(outline: shapely.Geometry) -> Array:
    """Corners (n, 2) of a polygon that are sharper than those of a circle drawn as one."""
    found = [np.empty((0, 2))]
    for part in shapely.get_parts(outline):
        for ring in (part.exterior, *part.interiors):
            points = np.asarray(ring.coords)[:-1, :2]
            ahead = np.roll(points, -1, axis=0) - points
            behind = np.roll(ahead, 1, axis=0)
            turn = np.arctan2(behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0], (behind * ahead).sum(axis=1))
            found.append(points[np.abs(turn) > SHARP])
    return np.concatenate(found)


SHARP = np.radians(20.0)
"""Outlines turn by more than this at a corner; circles are drawn with much smaller turns."""
