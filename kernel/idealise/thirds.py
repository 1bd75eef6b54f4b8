"""Third walls: a curve in which two walls meet, and which ends within a third one, goes on through that."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.idealise.carriers import Carrier, Line
from kernel.idealise.topology import Topology
from kernel.idealise.tube_curve import TubeCurve
from kernel.idealise.walls import Wall
from kernel.solid.boxes import BoxIndex
from kernel.solid.surfaces import Plane, signed_distance

if TYPE_CHECKING:
    from kernel.idealise.crossings import Crossing

Array = NDArray[np.float64]
Interval = tuple[float, float]

NEARLY_INSIDE = 0.2
"""A joint curve that ends this share of a third wall's thickness before that wall goes on through it."""

LONGEST_WITHIN = 20.0
"""A joint curve that stays within a third wall for this many of its thicknesses runs along it, not through it."""


class Thirds:
    """The walls that two crossing ones touch, found by place: a floor touches thousands, and few stand at one end."""

    def __init__(self, walls: Sequence[Wall], joints: Sequence[Joint]) -> None:
        self._walls = walls
        self._index = BoxIndex([wall.segment.solid.bounds for wall in walls])
        names = {wall.segment.id for wall in walls}
        self._touching: dict[str, set[str]] = {name: set() for name in names}
        for joint in joints:
            one, two = joint.segments
            if one in names and two in names:
                self._touching[one].add(two)
                self._touching[two].add(one)
        self._thickest = max((wall.thickness for wall in walls), default=0.0)

    def near(self, crossings: Sequence[Crossing], points: Array) -> list[list[Wall]]:
        """For each crossing and a point (n, 3) of its curve, walls other than its two that touch one and come near."""
        if not crossings:
            return []
        reach = [2 * (one.thickness + other.thickness + self._thickest) for one, other in (c.walls for c in crossings)]
        margin = np.array(reach)[:, None]
        found: list[dict[str, Wall]] = [{} for _ in crossings]
        for place, number in self._index.pairs(np.stack([points - margin, points + margin], axis=1)):
            wall, (a, b) = self._walls[number], crossings[place].walls
            name = wall.segment.id
            if name in self._touching[a.segment.id] or name in self._touching[b.segment.id]:
                if wall is not a and wall is not b:
                    found[place][name] = wall
        return [[walls[name] for name in sorted(walls)] for walls in found]


def lengthened(topology: Topology, crossing: Crossing, ends: Interval, thirds: Sequence[Sequence[Wall]]) -> Interval:
    """The interval, carried on at each end through the slabs of third walls (by end) within which it ends."""
    carrier = topology.carrier(crossing.carrier)
    if carrier.period is not None and ends[1] - ends[0] >= carrier.period - topology.tolerance:
        return ends
    result = []
    for end, sign, beside in zip(ends, (-1.0, 1.0), thirds):
        if isinstance(carrier, TubeCurve) and carrier.is_bend(end, topology.tolerance):
            result.append(end)
            continue
        for third in beside:
            end = _carried_on(carrier, end, sign, third, topology.tolerance)
        result.append(end)
    return result[0], result[1]


def _carried_on(carrier: Carrier, end: float, sign: float, third: Wall, tolerance: float) -> float:
    """The end of a curve, carried on in the direction `sign` to the face of a third wall where it lies within that."""
    surface = third.sheet.surface
    if isinstance(carrier, Line) and isinstance(surface, Plane):
        return _carried_straight(carrier, end, sign, surface, third.thickness, tolerance)
    half = 0.5 * third.thickness
    step = sign * NEARLY_INSIDE * third.thickness

    def outside(value: float) -> float:
        point = carrier.at(np.array([value]))
        return float(abs(signed_distance(surface, point)[0])) - half

    if outside(end) >= -tolerance and outside(end + step) >= 0:
        return end
    inner = end
    for _ in range(round(LONGEST_WITHIN / NEARLY_INSIDE)):
        if outside(inner + step) > 0:
            break
        inner += step
    else:
        return end  # the curve runs within the third wall: it ends where the walls do
    low, high = (inner, inner + step) if outside(inner) <= 0 else (inner, inner)
    for _ in range(80):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if outside(middle) <= 0 else (low, middle)
    return low


def _carried_straight(line: Line, end: float, sign: float, plane: Plane, thickness: float, tolerance: float) -> float:
    """The same for a line and a flat wall, without a search."""
    half = 0.5 * thickness
    start = line.at(np.array([end]))[0]
    across = sign * float(line.direction @ plane.normal)
    place = float(start @ plane.normal) - plane.offset
    step = NEARLY_INSIDE * thickness
    if abs(place) - half >= -tolerance and abs(place + across * step) - half >= 0:
        return end
    if across < 0:
        across, place = -across, -place
    if half - place > across * LONGEST_WITHIN * thickness:
        return end
    return end + sign * (half - place) / across
