"""Stubs: what of a brace lies in the bore of a chord, where braces were drawn to the chord's axis and only then united.

    ======+   +======  wall of the chord, which goes on across the brace: each tube has only its own bore
          |   |
    - - - |   | - - -  axis of the chord, to which the brace was drawn

That is material, and is meshed as such. But where stubs of two braces run into one another, they do so at all angles
and through one another's ends. Nobody builds that, nor looks for a stress in it. Such stubs are cut off where the
braces meet the chord's mid-surface; what is lost is a row of the ledger, and told.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from kernel.connect.bodies import Bodies
from kernel.connect.joints import Joint
from kernel.idealise.crossings import Crossing
from kernel.idealise.outlines import PolygonLike
from kernel.idealise.regions import GRID
from kernel.idealise.relined import drawn
from kernel.idealise.sheets import CylinderSheet
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall, patch_points
from kernel.segment.segments import CylinderShape
from kernel.segment.slices import parts_of

Array = NDArray[np.float64]

LEAST = 0.1
"""A part of a brace on either side of a chord's wall has more area than this times the thickness squared."""

RUNS = 0.1
"""Stubs run into one another when their joint curve lies in them over more than this times the thinner thickness."""


@dataclass(frozen=True, slots=True, eq=False)
class Stub:
    """The part of a brace's region that lies in the bore of a chord. left: the region without it, area: what it has."""

    brace: Wall
    chord: Wall
    inside: PolygonLike
    left: PolygonLike
    area: float


def colliding_stubs(
    topology: Topology, crossings: Sequence[Crossing], regions: Mapping[int, PolygonLike]
) -> list[Stub]:
    """The stubs that run into stubs of other braces of the same chord. regions: of walls that cross others, by index.

    A stub is the end of a tube; the chord's own wall within a brace is none.
    """
    between: dict[tuple[int, int], list[Crossing]] = {}
    for crossing in crossings:
        if all(isinstance(wall.sheet, CylinderSheet) for wall in crossing.walls):
            first, second = crossing.walls
            between.setdefault((first.index, second.index), []).append(crossing)
    stubs: dict[int, dict[int, Stub]] = {}
    if len(between) < 3:  # two braces that meet one another and their chord
        return []
    for pair in between.values():
        for brace in pair[0].walls:
            stub = _stub(topology, brace, pair[0].other(brace), pair, regions[brace.index])
            if stub is not None:
                stubs.setdefault(stub.chord.index, {})[brace.index] = stub
    found: dict[tuple[int, int], Stub] = {}
    for chord, of_chord in stubs.items():
        for (a, b), beside in between.items():
            if a not in of_chord or b not in of_chord:
                continue
            if any(_runs_in(topology, crossing, of_chord[a], of_chord[b]) for crossing in beside):
                found[chord, a], found[chord, b] = of_chord[a], of_chord[b]
    return [found[key] for key in sorted(found)]


def without_stubs(regions: Mapping[int, PolygonLike], stubs: Sequence[Stub]) -> dict[int, PolygonLike]:
    """The regions less those stubs."""
    left = dict(regions)
    for stub in stubs:
        known = left[stub.brace.index]
        left[stub.brace.index] = stub.left if known is regions[stub.brace.index] else known.intersection(stub.left)
    return left


def without_inner(joints: Sequence[Joint], stubs: Sequence[Stub]) -> tuple[Joint, ...]:
    """The joints but for those of two stubs within the bore where both are cut off."""
    return tuple(joint for joint in joints if not any(_lies_in(joint, chord) for chord in _chords(joint, stubs)))


def stub_notes(stubs: Sequence[Stub]) -> list[str]:
    """A line for each stub that is cut off."""
    return [
        f"{stub.brace.segment.id} goes on in the bore of {stub.chord.segment.id} and runs into another brace there: it "
        "is cut off at that wall"
        for stub in stubs
    ]


def _chords(joint: Joint, stubs: Sequence[Stub]) -> Iterator[Wall]:
    """The chords in whose bores both segments of a joint are cut off."""
    cut = [[stub.chord for stub in stubs if stub.brace.segment.id == name] for name in joint.segments]
    yield from (chord for chord in cut[0] if chord in cut[1])


def _lies_in(joint: Joint, chord: Wall) -> bool:
    surface = chord.segment.solid.surfaces.surfaces[joint.surface]
    return bool(_is_within(patch_points(surface, joint.patch), chord).all())


def _is_within(points: Array, chord: Wall) -> NDArray[np.bool_]:
    """Which points (n, 3) lie within a tube: nearer to its axis than its mid-surface, between its ends."""
    shape = chord.segment.shape
    assert isinstance(shape, CylinderShape)
    relative = points - shape.axis.point
    along = relative @ shape.axis.direction
    away = np.linalg.norm(relative - np.outer(along, shape.axis.direction), axis=1)
    return np.asarray((away < shape.mid_radius) & (along > shape.z_min) & (along < shape.z_max))


def _stub(topology: Topology, brace: Wall, chord: Wall, pair: Sequence[Crossing], region: PolygonLike) -> Stub | None:
    """The stub of a brace within a chord; None where it has none, or goes right through."""
    grid = GRID * topology.carriers.reach
    lines = [drawn(topology, brace.sheet, crossing.carrier, region) for crossing in pair]
    cut = shapely.union_all([region.boundary, *(line for line in lines if line is not None)], grid_size=grid)
    inside = []
    for cell in parts_of(shapely.polygonize(list(shapely.get_parts(cut)))):
        middle = cell.representative_point()
        if region.contains(middle) and _is_within(brace.sheet.lift(np.array([[middle.x, middle.y]])), chord)[0]:
            inside.append(cell)
    stub = shapely.union_all(inside, grid_size=grid)
    left = shapely.difference(region, stub, grid_size=grid)
    least = LEAST * brace.thickness**2
    if stub.area <= least or not _winds(brace, stub, grid):
        return None
    if _count(brace, [part for part in parts_of(left) if part.area > least]) != 1:
        return None
    return Stub(brace, chord, stub, shapely.union_all(parts_of(left)), float(stub.area))


def _winds(wall: Wall, region: PolygonLike, slack: float) -> bool:
    """Whether a region goes all round its wall, as the end of a tube does."""
    sheet = wall.sheet
    if sheet.turn is None:
        return False
    covered = sheet.seam
    for low, high in sorted((part.bounds[0], part.bounds[2]) for part in parts_of(region)):
        if low > covered + 10 * slack:
            return False
        covered = max(covered, high)
    return bool(covered >= sheet.seam + sheet.turn - 10 * slack)


def _count(wall: Wall, parts: Sequence[Polygon]) -> int:
    """How many parts of a wall's sheet there are, those that only its seam divides being one."""
    bodies = Bodies()
    slack = GRID * wall.segment.solid.surfaces.size
    for a, part in enumerate(parts):
        bodies.join(a, a)
        if wall.sheet.turn is not None:
            turned = shapely.transform(part, lambda at: at + (wall.sheet.turn, 0.0))
            for b, other in enumerate(parts):
                if turned.distance(other) <= slack:
                    bodies.join(a, b)
    return len({bodies.find(a) for a in range(len(parts))})


def _runs_in(topology: Topology, crossing: Crossing, one: Stub, other: Stub) -> bool:
    """Whether a joint curve of two braces lies in the stubs of both."""
    least = RUNS * min(one.brace.thickness, other.brace.thickness)
    for stub in (one, other):
        line = drawn(topology, stub.brace.sheet, crossing.carrier, stub.inside)
        if line is None or line.intersection(stub.inside).length <= least:
            return False
    return True
