"""The idealised parts of a model, while they are joined and meshed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kernel.connect.joints import Joint
from kernel.idealise.beam import Beam
from kernel.idealise.crossings import Crossing
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall
from kernel.segment.segments import Segment
from kernel.solid.boxes import BoxIndex

if TYPE_CHECKING:
    from kernel.idealise.arms import Arm
    from kernel.idealise.brick import SweepGroup
    from kernel.idealise.footprints import Seat
    from kernel.idealise.stubs import Stub


@dataclass(slots=True, eq=False)
class Parts:
    """walls, beams: by segment id, in the order of the segments. warnings: one line each.

    contacts: all joints; joints: those of segments that have elements. sweeps: groups of swept bricks. hosts: by
    brick, the wall whose elements it continues, and the joint there. seats: by beam, the walls that it lies along.
    absorbed: segments that are the material of walls' corners, and have no elements of their own. arms: webs' edges
    that hang from joint curves. stubs: what of braces in a chord's bore is cut off.
    only: the segments that are to be meshed, None for all.
    """

    topology: Topology
    segments: dict[str, Segment]
    contacts: tuple[Joint, ...]
    joints: tuple[Joint, ...] = ()
    walls: dict[str, Wall] = field(default_factory=dict)
    beams: dict[str, Beam] = field(default_factory=dict)
    crossings: list[Crossing] = field(default_factory=list)
    sweeps: list[SweepGroup] = field(default_factory=list)
    hosts: dict[str, tuple[Wall, Joint]] = field(default_factory=dict)
    seats: dict[str, list[Seat]] = field(default_factory=dict)
    absorbed: tuple[str, ...] = ()
    arms: list[Arm] = field(default_factory=list)
    stubs: list[Stub] = field(default_factory=list)
    only: frozenset[str] | None = None
    warnings: list[str] = field(default_factory=list)
    _by_wall: tuple[list[Crossing], dict[int, list[Crossing]]] | None = None

    def crossings_of(self, wall: Wall) -> list[Crossing]:
        """The crossings in which the wall takes part."""
        if self._by_wall is None or self._by_wall[0] is not self.crossings:
            by_wall: dict[int, list[Crossing]] = {}
            for crossing in self.crossings:
                for one in crossing.walls:
                    by_wall.setdefault(one.index, []).append(crossing)
            self._by_wall = (self.crossings, by_wall)
        return self._by_wall[1].get(wall.index, [])

    def thickest(self) -> dict[int, float]:
        """By wall index, the greatest thickness of the wall and of those that it crosses."""
        found = {wall.index: wall.thickness for wall in self.walls.values()}
        for crossing in self.crossings:
            most = max(wall.thickness for wall in crossing.walls)
            for wall in crossing.walls:
                found[wall.index] = max(found[wall.index], most)
        return found

    def neighbours(self) -> dict[str, set[str]]:
        """Ids of the segments that each segment touches."""
        found: dict[str, set[str]] = {name: set() for name in self.segments}
        for joint in self.contacts:
            a, b = joint.segments
            found[a].add(b)
            found[b].add(a)
        return found

    def surroundings(self, crossings: Sequence[Crossing]) -> dict[int, list[Segment]]:
        """By wall index: the segments around a wall and around those that it crosses, whose boxes reach its own."""
        neighbours = self.neighbours()
        segments = list(self.segments.values())
        boxes = BoxIndex([segment.solid.bounds for segment in segments])
        met: dict[int, set[str]] = {}
        reach: dict[int, float] = {}
        for crossing in crossings:
            for wall in crossing.walls:
                other = crossing.other(wall)
                met.setdefault(wall.index, {wall.segment.id}).add(other.segment.id)
                reach[wall.index] = max(reach.get(wall.index, 0.0), other.thickness)
        result: dict[int, list[Segment]] = {}
        for wall in self.walls.values():
            if wall.index in met:
                low, high = wall.segment.solid.bounds
                near = boxes.near(low - 2 * reach[wall.index], high + 2 * reach[wall.index])
                # What touches the wall or one that it crosses: asked this way round, a floor's thousands of
                # neighbours are not gone through for each of them.
                result[wall.index] = [
                    segments[number]
                    for number in near
                    if segments[number] is not wall.segment
                    and not neighbours[segments[number].id].isdisjoint(met[wall.index])
                ]
        return result
