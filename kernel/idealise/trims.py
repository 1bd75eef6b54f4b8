"""Trims: along how much of a joint curve a wall may be cut back to it.

A wall that ends on the far face of another is cut back to their joint curve, for there the other goes on. It may be
only where the other stands: beyond, the wall keeps its own edge, and its outline has a step of half a thickness.

    +-----------------------------+                 contact over most of the edge: cut back all along, for a step or
    |            wall             |                 a sliver at a scallop costs the mesh more than it is worth
    |- - - - - +:::::::::::::::::::  own edge
    +----------+                                    ":" what a cut all along the curve would have lost
      contact                                       "-" the curve
"""

from __future__ import annotations

from collections.abc import Sequence

from kernel.idealise.crossings import Crossing, Interval, merged
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall

NEARLY_WHOLE = 0.9
"""An edge of which the walls that stand there touch more than this share is cut back all along."""

SHORTEST_BARE = 2.0
"""So is a stretch without contact that is shorter than this many thicknesses of the wall that stands there."""


def trimmed(topology: Topology, crossing: Crossing, wall: Wall, beside: Sequence[Crossing]) -> list[Interval]:
    """The stretches of the joint curve along which `wall` may be cut back to it.

    beside: all crossings of the wall on the same curve: what stands in line holds it together.
    """
    period = topology.carrier(crossing.carrier).period
    slack = 10 * topology.tolerance
    contact = merged([ends for one in beside for ends in one.reach[one.other(wall).index]], slack, period)
    held: list[Interval] = []
    for start, end in crossing.reach[wall.index]:
        inner = merged(_within(start, end, contact, period), slack)
        shortest = SHORTEST_BARE * crossing.other(wall).thickness
        if sum(b - a for a, b in inner) >= NEARLY_WHOLE * (end - start):
            inner = [(start, end)]
        held += _closed_up(start, end, inner, shortest)
    return merged(held, slack, period)


def step_ends(crossing: Crossing, wall: Wall, stretches: Sequence[Interval], slack: float) -> list[float]:
    """Where a trim ends within the wall's reach: parameters of the curve."""
    inside = []
    for value in (end for stretch in stretches for end in stretch):
        if any(start + slack < value < end - slack for start, end in crossing.reach[wall.index]):
            inside.append(value)
    return inside


def _within(start: float, end: float, contact: Sequence[Interval], period: float | None) -> list[Interval]:
    """The parts of some stretches that lie between start and end, on a closed curve in any turn."""
    shifts = (0.0,) if period is None else (-period, 0.0, period)
    found = []
    for a, b in contact:
        for shift in shifts:
            low, high = max(start, a + shift), min(end, b + shift)
            if high > low:
                found.append((low, high))
    return found


def _closed_up(start: float, end: float, inner: Sequence[Interval], shortest: float) -> list[Interval]:
    """Stretches between start and end, those joined, and carried on to the ends, that leave little between them."""
    found: list[Interval] = []
    for a, b in inner:
        if a - (found[-1][1] if found else start) <= shortest:
            a = found.pop()[0] if found else start
        found.append((a, b))
    if found and end - found[-1][1] <= shortest:
        found[-1] = (found[-1][0], end)
    return found
