"""Crossings: the curves in which the mid-surfaces of joined walls meet, and how far each wall reaches along them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.errors import ConnectError
from kernel.idealise.carriers import Carrier, Line, Traced, distance_to
from kernel.idealise.implicit import project
from kernel.idealise.intersections import intersection
from kernel.idealise.outlines import unwrapped, windowed
from kernel.idealise.sheets import CylinderSheet, PlaneSheet
from kernel.idealise.thirds import Thirds, lengthened
from kernel.idealise.topology import Topology
from kernel.idealise.tube_curve import TubeCurve, pinched, slab_sides
from kernel.idealise.walls import CROSSING_SINE, Wall, patch_points
from kernel.solid.surfaces import CylinderSurface, Plane, Surface, cross, signed_distance

Array = NDArray[np.float64]
Interval = tuple[float, float]

CURVED_OVERLAP = 0.02
"""Share of the thinner wall by which strips beside curved joints overlap the walls: more than chords deviate."""

CORNER_REACH = 3.0
"""A contact with a curved wall, found this overlap deep within the other, ends off its corner by the overlap times the
cotangent of the angle there: at 25 degrees 2.1 of it."""

MOST_PINCH = 0.5
"""Tubes that meet are given a common radius when that moves one by no more than this share of the thinner wall."""

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


def find_crossings(topology: Topology, walls: Sequence[Wall], joints: Sequence[Joint]) -> list[Crossing]:
    """Every curve in which the mid-surfaces of two joined walls meet at an angle."""
    by_id = {wall.segment.id: wall for wall in walls}
    thirds = Thirds(walls, joints)
    found: dict[tuple[int, int, int], Crossing] = {}
    for joint in joints:
        if joint.gap or not all(name in by_id for name in joint.segments):
            continue  # mid-surfaces are not carried on through a gap
        pair = (by_id[joint.segments[0]], by_id[joint.segments[1]])
        for number in _joint_carriers(topology, pair, joint):
            key = (pair[0].index, pair[1].index, number)
            if key not in found:
                found[key] = Crossing(pair, number, {})
                for wall in pair:
                    wall.known.append(number)
            found[key].joints.append(joint)
    for crossing in found.values():
        _refuse_tangents(topology, crossing)
        for wall in crossing.walls:
            crossing.reach[wall.index] = _reach(topology, crossing, wall)
    _pinch_tubes(topology, list(found.values()))
    reached = {
        (crossing.carrier, wall.sheet.surface_id)
        for crossing in found.values()
        for wall in crossing.walls
        if crossing.reach[wall.index]
    }
    for crossing in found.values():
        is_of_tubes = isinstance(topology.carrier(crossing.carrier), TubeCurve)
        for wall in crossing.walls:
            # Where a coplanar neighbour reaches the curve, this wall is the part beyond it, not one cut askew.
            bare = not crossing.reach[wall.index] and (crossing.carrier, wall.sheet.surface_id) not in reached
            if bare and not is_of_tubes:
                crossing.gap[wall.index] = _askew_gap(topology, crossing, wall)
                crossing.reach[wall.index] = _reach(topology, crossing, wall)
            intervals = [lengthened(topology, crossing, ends, thirds) for ends in crossing.reach[wall.index]]
            crossing.reach[wall.index] = merged(
                intervals, 10 * topology.tolerance, topology.carrier(crossing.carrier).period
            )
    return [found[key] for key in sorted(found)]


def _joint_carriers(topology: Topology, pair: tuple[Wall, Wall], joint: Joint) -> list[int]:
    """The carriers of the curves in which two mid-surfaces meet next to the joint's patch."""
    a, b = pair
    surfaces = a.segment.solid.surfaces.surfaces
    met = (a.sheet.surface, b.sheet.surface)
    if a.sheet.surface_id == b.sheet.surface_id:
        return []
    seeds = patch_points(surfaces[joint.surface], joint.patch)
    if isinstance(a.sheet, PlaneSheet) and isinstance(b.sheet, PlaneSheet):
        away = _distances_from_line(a.sheet, b.sheet, seeds)
        near = np.flatnonzero(away <= 3 * (a.thickness + b.thickness))
        first = seeds[near[:1]]
        ids = (a.sheet.surface_id, b.sheet.surface_id)
        return [intersection(topology.carriers, surfaces, *ids, first)] if len(near) else []
    points = project(seeds, met)
    is_near = np.linalg.norm(points - seeds, axis=1) <= 3 * (a.thickness + b.thickness)
    on_both = np.max([np.abs(signed_distance(surface, points)) for surface in met], axis=0) <= topology.tolerance
    sine = np.linalg.norm(np.cross(a.sheet.normals(points), b.sheet.normals(points)), axis=1)
    points = points[is_near & on_both & (sine > CROSSING_SINE)]
    numbers: list[int] = []
    while len(points):
        number = intersection(topology.carriers, surfaces, a.sheet.surface_id, b.sheet.surface_id, points[:1])
        numbers.append(number)
        points = points[1:][distance_to(topology.carrier(number), points[1:]) > 4 * topology.tolerance]
    return numbers


def _distances_from_line(one: PlaneSheet, other: PlaneSheet, points: Array) -> Array:
    """Distance (n,) of points (n, 3) from the line in which two planes meet; infinite where they hardly cross."""
    cosine = float(one.normal @ other.normal)
    square = 1.0 - cosine * cosine
    if square <= CROSSING_SINE**2:
        return np.full(len(points), np.inf)
    a, b = points @ one.normal - one.offset, points @ other.normal - other.offset
    return np.asarray(np.sqrt(np.maximum(a * a + b * b - 2 * cosine * a * b, 0.0) / square))


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


def _reach(topology: Topology, crossing: Crossing, wall: Wall) -> list[Interval]:
    """Where the wall's own section touches either side of the other's slab, as stretches of the joint curve."""
    carrier = topology.carrier(crossing.carrier)
    other = crossing.other(wall)
    straight = isinstance(carrier, Line)
    margin = 0.3 * topology.tolerance if straight else CURVED_OVERLAP * min(wall.thickness, other.thickness)
    low, high = whole_range(topology, carrier, other.segment.solid.bounds)
    curve = samples(topology, carrier, low, high)
    margin += crossing.gap.get(wall.index, 0.0)
    if isinstance(carrier, TubeCurve):
        return _reach_of_lobes(topology, crossing, wall, carrier, margin)
    corners = None if straight else _corners_on_faces(topology, crossing, wall)
    touching = _along(topology, crossing, wall, slab_edges(wall, other, curve, margin), corners, CORNER_REACH * margin)
    within = _along(topology, crossing, wall, slab_edges(wall, other, curve, -margin)) if touching else []
    # A wall that owns a corner's material may have more of it than it touches the other's slab along.
    slack = 10 * topology.tolerance
    longer = [ends for ends in within if any(ends[0] <= b + slack and a <= ends[1] + slack for a, b in touching)]
    return merged([*touching, *longer], slack, carrier.period)


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


def _askew_gap(topology: Topology, crossing: Crossing, wall: Wall) -> float:
    """How far the mid-surface of a wall cut square ends before the face that it meets askew, or within a bore."""
    carrier = topology.carrier(crossing.carrier)
    other = crossing.other(wall)
    low, high = whole_range(topology, carrier, other.segment.solid.bounds)
    point = carrier.at(np.array([0.5 * (low + high)]))
    cosine = float(abs(wall.sheet.normals(point)[0] @ other.sheet.normals(point)[0]))
    gap = 0.5 * wall.thickness * cosine / float(np.sqrt(1 - cosine * cosine)) + topology.tolerance
    surface = other.sheet.surface
    if isinstance(surface, CylinderSurface):  # only the corners of a flat end touch a bore
        bore = surface.radius - 0.5 * other.thickness
        gap += bore - float(np.sqrt(max(0.0, bore**2 - (0.5 * wall.thickness) ** 2)))
    return gap


def _pinch_tubes(topology: Topology, crossings: Sequence[Crossing]) -> None:
    """Give tubes that go on from one of their two curves to the other a common radius; vertices at all bends.

    So do those of a mitre, or a branch a little wider than its run: with different radii the two curves do not meet.
    ConnectError where the mid-surface of one lies outside the other's wall.
    """
    pairs: dict[tuple[int, int], list[Crossing]] = {}
    for crossing in crossings:
        if isinstance(topology.carrier(crossing.carrier), TubeCurve):
            pairs.setdefault((crossing.walls[0].index, crossing.walls[1].index), []).append(crossing)
    for beside in pairs.values():
        if any(_is_of_one_lobe(topology, crossing) for crossing in beside):
            for crossing in beside:
                _pinch(topology, crossing)
        for crossing in beside:
            carrier = topology.carrier(crossing.carrier)
            assert isinstance(carrier, TubeCurve)
            for value, point in zip(carrier.bends, carrier.at(np.array(carrier.bends))):
                topology.cut(crossing.carrier, value, point)


def _is_of_one_lobe(topology: Topology, crossing: Crossing) -> bool:
    """Whether both walls reach the curve of two tubes of different radii, but not all round."""
    carrier = topology.carrier(crossing.carrier)
    assert isinstance(carrier, TubeCurve)
    a, b = crossing.walls
    if not crossing.reach[a.index] or not crossing.reach[b.index] or not max(carrier.frame.gaps):
        return False
    whole = [(0.0, carrier.period)]
    ends = [end for wall in (a, b) if crossing.reach[wall.index] != whole for end in crossing.reach[wall.index]]
    return any(carrier.is_bend(value, topology.tolerance) for end in ends for value in end)


def _pinch(topology: Topology, crossing: Crossing) -> None:
    carrier = topology.carrier(crossing.carrier)
    assert isinstance(carrier, TubeCurve)
    a, b = crossing.walls
    frame = pinched(carrier.frame)
    radii = [wall.sheet.radius for wall in (a, b) if isinstance(wall.sheet, CylinderSheet)]
    if frame.pinch > MOST_PINCH * min(a.thickness, b.thickness):
        raise ConnectError(
            f"the mid-surfaces of {a.segment.id} (radius {radii[0]:.6g}) and {b.segment.id} (radius "
            f"{radii[1]:.6g}) come within {frame.pinch:.6g} of one another near "
            f"{topology.place_text(carrier.at(np.zeros(1))[0])} without meeting there, expected less than half the "
            "thinner wall: one of them may be made a brick"
        )
    crossing.carrier = topology.carriers.tube((a.sheet.surface_id, b.sheet.surface_id), frame, carrier.side)
    for wall in (a, b):
        wall.known.append(crossing.carrier)
        crossing.reach[wall.index] = _reach(topology, crossing, wall)


def pinch_notes(topology: Topology, crossings: Sequence[Crossing]) -> list[str]:
    """A line for each two tubes that were given a common radius where they meet."""
    notes = {}
    for crossing in crossings:
        carrier = topology.carrier(crossing.carrier)
        if isinstance(carrier, TubeCurve) and carrier.frame.pinch:
            a, b = (wall.segment.id for wall in crossing.walls)
            notes[a, b] = (
                f"the mid-surfaces of {a} and {b} miss one another by {carrier.frame.pinch:.4g} where they run side by "
                f"side: they meet as if both had the radius {carrier.frame.small.radius:.6g}"
            )
    return list(notes.values())


def _refuse_tangents(topology: Topology, crossing: Crossing) -> None:
    """ConnectError where two mid-surfaces touch somewhere on the curve in which they meet."""
    carrier = topology.carrier(crossing.carrier)
    if isinstance(carrier, Line | TubeCurve):
        return  # tubes whose axes cross at an angle, however flat they meet at the bends of their curve
    a, b = crossing.walls
    points = samples(topology, carrier, *whole_range(topology, carrier, a.segment.solid.bounds))
    sine = np.linalg.norm(np.cross(a.sheet.normals(points), b.sheet.normals(points)), axis=1)
    worst = int(np.argmin(sine))
    if sine[worst] < CROSSING_SINE:
        raise ConnectError(
            f"the mid-surfaces of {a.segment.id} and {b.segment.id} meet at no angle near "
            f"{topology.place_text(points[worst])} "
            "(walls of nearly equal radius), expected 10 degrees or more: one of them may be made a brick"
        )


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
