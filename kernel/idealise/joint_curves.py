"""Joint curves: those in which the mid-surfaces of joined walls meet, and how far each wall reaches along them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.errors import ConnectError
from kernel.idealise.carriers import Line, distance_to
from kernel.idealise.crossings import (
    FLAT_OVERLAP,
    Crossing,
    Interval,
    merged,
    reach_of,
    samples,
    whole_range,
    with_longer,
)
from kernel.idealise.implicit import project
from kernel.idealise.intersections import intersection
from kernel.idealise.sheets import CylinderSheet, PlaneSheet
from kernel.idealise.straight_contacts import Side, straight_contacts
from kernel.idealise.thirds import Thirds, lengthened
from kernel.idealise.topology import Topology
from kernel.idealise.tube_curve import TubeCurve, pinched
from kernel.idealise.walls import CROSSING_SINE, Wall, patch_points
from kernel.solid.surfaces import CylinderSurface, signed_distance

Array = NDArray[np.float64]

MOST_PINCH = 0.5
"""Tubes that meet are given a common radius when that moves one by no more than this share of the thinner wall."""


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
    _find_reaches(topology, list(found.values()))
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
                crossing.reach[wall.index] = reach_of(topology, crossing, wall)
    _lengthen(topology, list(found.values()), thirds)
    return [found[key] for key in sorted(found)]


def _find_reaches(topology: Topology, crossings: Sequence[Crossing]) -> None:
    """Set how far each wall reaches along each curve."""
    sides: list[Side] = []
    places: list[tuple[Crossing, Wall]] = []
    for crossing in crossings:
        _refuse_tangents(topology, crossing)
        carrier = topology.carrier(crossing.carrier)
        is_flat = all(isinstance(wall.sheet, PlaneSheet) for wall in crossing.walls)
        for wall in crossing.walls:
            if is_flat and isinstance(carrier, Line):
                sides.append(Side(carrier, wall, crossing.other(wall)))
                places.append((crossing, wall))
            else:
                crossing.reach[wall.index] = reach_of(topology, crossing, wall)
    margin = FLAT_OVERLAP * topology.tolerance
    touching = straight_contacts(topology, sides, margin)
    asked = [place for place, ends in enumerate(touching) if ends]
    within = dict(zip(asked, straight_contacts(topology, [sides[place] for place in asked], -margin)))
    for place, (crossing, wall) in enumerate(places):
        crossing.reach[wall.index] = with_longer(topology, touching[place], within.get(place, []), None)


def _lengthen(topology: Topology, crossings: Sequence[Crossing], thirds: Thirds) -> None:
    """Carry the reaches on through third walls; both walls of a crossing mostly reach equally far."""
    tasks = [
        (crossing, ends)
        for crossing in crossings
        for ends in dict.fromkeys(ends for wall in crossing.walls for ends in crossing.reach[wall.index])
    ]
    points = [topology.carrier(crossing.carrier).at(np.array(ends)) for crossing, ends in tasks]
    near = thirds.near([crossing for crossing, _ in tasks for _ in (0, 1)], np.array(points).reshape(-1, 3))
    known: dict[tuple[int, Interval], Interval] = {}
    for place, (crossing, ends) in enumerate(tasks):
        known[id(crossing), ends] = lengthened(topology, crossing, ends, near[2 * place : 2 * place + 2])
    for crossing in crossings:
        period = topology.carrier(crossing.carrier).period
        for wall in crossing.walls:
            intervals = [known[id(crossing), ends] for ends in crossing.reach[wall.index]]
            crossing.reach[wall.index] = merged(intervals, 10 * topology.tolerance, period)


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
        crossing.reach[wall.index] = reach_of(topology, crossing, wall)


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
