"""How many elements circles need, for what their chords cut off to stay within the limit on the mass.

roundness.py has the formulas. Bricks with a section of their own are held to the limit each. Walls, and bricks that
stand on them, share their circles with all that meets there: they are held to it only where the model as a whole
would exceed it, so that small discs on a large model keep the few elements that suit its size.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from kernel.idealise.carriers import Circle
from kernel.idealise.parts import Parts
from kernel.idealise.roundness import roundness
from kernel.idealise.sheets import CylinderSheet, PlaneSheet
from kernel.idealise.topology import Curve, Topology
from kernel.idealise.walls import Wall
from kernel.mesh.line import least_divisions

CHORD_LOSS = 4e-3
"""Share of an area, or of the model's volume, that the chords of linear elements may cut off: the mass is checked to
0.5 %."""


def least_on_circles(
    topology: Topology, curves: Sequence[Curve], shares: Mapping[int, float], loss: float
) -> dict[int, int]:
    """Fewest elements on each piece of a circle, by its place, for outlines to lose at most that share.

    shares: roundness by carrier.
    """
    least = {}
    for place, curve in enumerate(curves):
        circle = topology.carrier(curve.carrier)
        if isinstance(circle, Circle) and curve.carrier in shares:
            per_turn = 2 * math.pi * math.sqrt(shares[curve.carrier] / (12.0 * loss))
            least[place] = 2 * math.ceil(0.5 * per_turn * curve.length / circle.period - 1e-6)
    return least


def least_on_walls(parts: Parts, curves: Sequence[Curve], sizes: Mapping[str, float]) -> dict[int, int]:
    """Fewest elements on the circles of walls, by the curve's place; none where the usual ones lose little enough.

    curves: of the walls' topology. sizes: by segment id.
    """
    topology = parts.topology
    shares: dict[int, float] = {}
    lost = sum(_flattened(wall, sizes[name]) for name, wall in parts.walls.items())
    for rounds, volume, size in _outlines(parts, sizes):
        for carrier, share in rounds.items():
            circle = topology.carrier(carrier)
            assert isinstance(circle, Circle)
            around = max(least_divisions(circle, circle.period, size), 2 * math.ceil(0.5 * circle.period / size))
            lost += volume * share * (2 * math.pi / around) ** 2 / 12
            shares[carrier] = max(share, shares.get(carrier, 0.0))
    if lost <= CHORD_LOSS * sum(segment.volume for segment in parts.segments.values()):
        return {}
    return least_on_circles(topology, curves, shares, CHORD_LOSS)


def _flattened(wall: Wall, size: float) -> float:
    """Volume that flat elements of a size cut off a cylinder-plate: a chord is shorter than its arc by a^2 / 24."""
    if not isinstance(wall.sheet, CylinderSheet):
        return 0.0
    return wall.segment.volume * (size / wall.sheet.radius) ** 2 / 24


def _outlines(parts: Parts, sizes: Mapping[str, float]) -> list[tuple[dict[int, float], float, float]]:
    """Roundness by carrier, volume and size of every flat wall, and of all bricks on it."""
    found = []
    for name, wall in parts.walls.items():
        if isinstance(wall.sheet, PlaneSheet) and wall.region.area > 0.0:
            rounds = roundness(parts.topology, wall.sheet, [wall.outline], wall.region.area)
            found.append((rounds, wall.segment.volume, sizes[name]))
    for group in parts.sweeps:
        if group.host is not None:
            names = [brick.segment.id for brick in group.bricks]
            volume = sum(parts.segments[name].volume for name in names)
            found.append((group.roundness, volume, min(sizes[name] for name in (*names, group.host[0].segment.id))))
    return found
