"""Crossings: two walls and the curve in which their mid-surfaces meet, and how far each reaches along it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.idealise.carriers import Carrier, Line, Traced
from kernel.idealise.implicit import project
from kernel.idealise.outlines import unwrapped, windowed
from kernel.idealise.sheets import PlaneSheet
from kernel.idealise.topology import Topology
from kernel.idealise.tube_curve import TubeCurve, slab_sides
from kernel.idealise.walls import Wall
from kernel.solid.surfaces import CylinderSurface, Plane, Surface, cross, signed_distance

Array = NDArray[np.float64]
Interval = tuple[float, float]

CURVED_OVERLAP = 0.02
"""Share of the thinner wall by which strips beside curved joints overlap the walls: more than chords deviate."""

FLAT_OVERLAP = 0.3
"""Share of the tolerance by which a wall's section is to overlap a line beside a straight joint to touch it."""

CORNER_REACH = 3.0
"""A contact with a curved wall, found this overlap deep within the other, ends off its corner by the overlap times the
cotangent of the angle there: at 25 degrees 2.1 of it."""

NEAR_BEND = 0.05
"""What ends within this share of the curve between two bends from where the walls merge goes on to the bend."""


@dataclass(slots=True, eq=False)
class Crossing:
    """The curve `carrier` in which the mid-surfaces of two walls meet, and where each wall's material reaches it.

    gap: by wall, how far its mid-surface may end before the other's face: a wall that stands askew and is cut square
    touches with one corner only. joints: those of the two walls that lie along the curve.
    """

    walls: tuple[Wall, Wall]
    carrier: int
    reach: dict[int, list[Interval]]
    gap: dict[int, float] = field(default_factory=dict)
    joints: list[Joint] = field(default_factory=list)

    def other(self, wall: Wall) -> Wall:
        """The wall on the far side."""
        return self.walls[1] if wall is self.walls[0] else self.walls[0]


def offset_surface(surface: Surface, distance: float) -> Surface:
    """The plane or cylinder parallel to one, `distance` further along its normals."""
    if isinstance(surface, Plane):
        return Plane(surface.normal, surface.offset + distance, surface.u, surface.v)
    assert isinstance(surface, CylinderSurface)
    return CylinderSurface(surface.axis, surface.axis_id, surface.radius + distance)


def slab_edges(
    wall: Wall, other: Wall, points: Array, margin: float, carrier: Carrier | None = None
) -> tuple[Array, Array]:
    """Where `wall`'s sheet leaves the slab of `other`, on its two sides, for points (n, 3) of the joint curve.

    margin: by how much the slab is taken thicker on each side. carrier: that of the points; may be left out where it
    is no curve of two tubes.
    """
    half = 0.5 * other.thickness + margin
    if isinstance(carrier, TubeCurve):
        return slab_sides(carrier, wall.sheet.surface, points, half)
    if isinstance(wall.sheet, PlaneSheet) and isinstance(other.sheet, PlaneSheet):
        aside = cross(wall.sheet.normal, cross(wall.sheet.normal, other.sheet.normal))
        shift = aside * (half / float(aside @ aside))
        return points - shift, points + shift
    across = np.cross(wall.sheet.normals(points), np.cross(wall.sheet.normals(points), other.sheet.normals(points)))
    sine = np.linalg.norm(across, axis=1)[:, None]
    sides = []
    for sign in (1.0, -1.0):
        guess = points - sign * across / sine * (half / sine)
        sides.append(project(guess, (wall.sheet.surface, offset_surface(other.sheet.surface, sign * half))))
    return sides[0], sides[1]


def samples(topology: Topology, carrier: Carrier, start: float, end: float) -> Array:
    """Points (n, 3) along a carrier from start to end, dense enough to show its curve."""
    if isinstance(carrier, Line):
        return carrier.at(np.array([start, end]))
    return carrier.at(np.concatenate([[start], carrier.breaks(start, end), [end]]))


def whole_range(topology: Topology, carrier: Carrier, near: Array) -> Interval:
    """All of a carrier, or of a line what the model's size can hold about the points `near`."""
    if carrier.period is not None:
        return 0.0, carrier.period
    if isinstance(carrier, Traced):
        return 0.0, float(carrier.lengths[-1])
    values = carrier.parameters(near)
    return float(values.min()) - topology.carriers.reach, float(values.max()) + topology.carriers.reach


def reach_of(topology: Topology, crossing: Crossing, wall: Wall) -> list[Interval]:
    """Where the wall's own section touches either side of the other's slab, as stretches of the joint curve."""
    carrier = topology.carrier(crossing.carrier)
    other = crossing.other(wall)
    straight = isinstance(carrier, Line)
    margin = FLAT_OVERLAP * topology.tolerance if straight else CURVED_OVERLAP * min(wall.thickness, other.thickness)
    low, high = whole_range(topology, carrier, other.segment.solid.bounds)
    curve = samples(topology, carrier, low, high)
    margin += crossing.gap.get(wall.index, 0.0)
    if isinstance(carrier, TubeCurve):
        return _reach_of_lobes(topology, crossing, wall, carrier, margin)
    corners = None if straight else _corners_on_faces(topology, crossing, wall)
    touching = _along(topology, crossing, wall, slab_edges(wall, other, curve, margin), corners, CORNER_REACH * margin)
    within = _along(topology, crossing, wall, slab_edges(wall, other, curve, -margin)) if touching else []
    return with_longer(topology, touching, within, carrier.period)


def with_longer(
    topology: Topology, touching: Sequence[Interval], within: Sequence[Interval], period: float | None
) -> list[Interval]:
    """Where a wall touches a slab, with what it has within that, as far as the two meet.

    A wall that owns a corner's material may have more of it than it touches the other's slab along.
    """
    slack = 10 * topology.tolerance
    longer = [ends for ends in within if any(ends[0] <= b + slack and a <= ends[1] + slack for a, b in touching)]
    return merged([*touching, *longer], slack, period)


def _reach_of_lobes(
    topology: Topology, crossing: Crossing, wall: Wall, carrier: TubeCurve, margin: float
) -> list[Interval]:
    """The same on the curve of two tubes: what touches up to where the walls merge reaches to the bend beyond.

    Near a bend both walls lie within one another, whoever owns the material, and their sections say nothing there.
    """
    other = crossing.other(wall)
    slack = 10 * topology.tolerance
    found: list[Interval] = []
    bottom, top = carrier.bends
    clear_lobes = carrier.clear_of_bends(0.5 * max(wall.thickness, other.thickness) + margin)
    for (low, high), clear in zip(((bottom, top), (top, carrier.period)), clear_lobes):
        if clear[1] <= clear[0]:
            continue
        points = samples(topology, carrier, *clear)
        for start, end in merged(
            _along(topology, crossing, wall, slab_edges(wall, other, points, margin, carrier)), slack, carrier.period
        ):
            turns = carrier.period * np.floor((start + slack) / carrier.period)
            ends = [start - turns, end - turns]
            if ends[0] <= clear[0] + NEAR_BEND * (high - low):
                ends[0] = low
            if ends[1] >= clear[-1] - NEAR_BEND * (high - low):
                ends[1] = high
            found.append((ends[0], ends[1]))
    return merged(found, slack, carrier.period)


def _corners_on_faces(topology: Topology, crossing: Crossing, wall: Wall) -> list[Array]:
    """Where the wall's own section has points on either side of the other's slab: parameters of the joint curve."""
    other = crossing.other(wall)
    points = wall.sheet.lift(shapely.get_coordinates(wall.own))
    found = []
    for sign in (1.0, -1.0):
        face = offset_surface(other.sheet.surface, sign * 0.5 * other.thickness)
        on_face = np.abs(signed_distance(face, points)) <= topology.tolerance
        found.append(topology.carrier(crossing.carrier).parameters(points[on_face]))
    return found


def _to_corner(end: float, sense: float, corners: Array, limit: float, period: float | None) -> float:
    """The end of a contact, found a little within the wall, moved to the outermost of the corners next to it.

    sense: 1 for the contact's last end, -1 for its first. limit: how far a corner may lie from it.
    """
    away = sense * (corners - end)
    if period is not None:
        away -= period * np.round(away / period)
    near = away[np.abs(away) <= limit]
    return end + sense * float(near.max()) if len(near) else end


def _along(
    topology: Topology,
    crossing: Crossing,
    wall: Wall,
    edges: Sequence[Array],
    corners: Sequence[Array] | None = None,
    limit: float = 0.0,
) -> list[Interval]:
    """The stretches of the joint curve where the wall's own section lies under lines (n, 3) beside it.

    corners: for each line, parameters to which ends within `limit` of them belong.
    """
    period = topology.carrier(crossing.carrier).period
    intervals: list[Interval] = []
    for number, edge in enumerate(edges):
        line = windowed(wall.sheet, shapely.LineString(unwrapped(wall.sheet, edge)))
        common = line.intersection(wall.own)
        if common.is_empty:
            continue
        for piece in (common,) if common.geom_type == "LineString" else shapely.get_parts(shapely.line_merge(common)):
            if piece.geom_type != "LineString" or piece.length <= topology.tolerance:
                continue
            values = topology.carrier(crossing.carrier).parameters(wall.sheet.lift(np.asarray(piece.coords)))
            first, last = _unrolled_range(values, period)
            if corners is not None and (period is None or last - first < period - topology.tolerance):
                first = _to_corner(first, -1.0, corners[number], limit, period)
                last = _to_corner(last, 1.0, corners[number], limit, period)
            intervals.append((first, last))
    return intervals


def _unrolled_range(values: Array, period: float | None) -> Interval:
    """Smallest range that holds parameters which run along a curve, over the seam of a closed one where they do."""
    if period is None:
        return float(values.min()), float(values.max())
    steps = np.diff(values)
    steps -= period * np.round(steps / period)
    run = values[0] + np.concatenate([[0.0], np.cumsum(steps)])
    low, high = float(run.min()), float(run.max())
    shift = period * np.floor(low / period)
    return low - shift, high - shift


def merged(intervals: Sequence[Interval], slack: float, period: float | None = None) -> list[Interval]:
    """Intervals joined where they overlap or come nearer than `slack`; on a closed curve all of it is (0, period)."""
    result: list[list[float]] = []
    for start, end in sorted(intervals):
        if result and start <= result[-1][1] + slack:
            result[-1][1] = max(result[-1][1], end)
        else:
            result.append([start, end])
    if period is not None and result:
        while len(result) > 1 and result[-1][1] - period >= result[0][0] - slack:
            first = result.pop(0)
            result[-1][1] = max(result[-1][1], first[1] + period)
        if result[0][1] - result[0][0] >= period - slack:
            return [(0.0, period)]
    return [(start, end) for start, end in result]
