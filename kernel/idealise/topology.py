"""One topology for the model: vertices, carriers, and curves that know the faces they bound or are imprinted on.

Faces lay spans on carriers. All spans of a carrier are cut at all of its cuts, and what lies between two neighbouring
cuts is one curve for every face that covers it; where a face has a boundary and an imprint on the same piece, the
boundary counts.

    carrier   ----+--------+-----+------------+----
    face a        |<---- boundary span ------>|
    face b                 |<-- imprint ----------->
    curves        |   a    | a,b |    a,b     | b
"""

from __future__ import annotations

import itertools
from bisect import bisect_left, bisect_right
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.carriers import Carrier, CarrierTable, VertexTable
from kernel.places import place_text

Array = NDArray[np.float64]

BOUNDARY = "boundary"
IMPRINT = "imprint"


@dataclass(frozen=True, slots=True)
class Span:
    """A stretch start < end (lengths on the carrier) that a face covers.

    forward: whether the face lies on the left when walking it towards `end`. In a `whole` span the carrier closes
    and all of it is covered.
    """

    face: int
    start: float
    end: float
    role: str
    forward: bool
    whole: bool = False


@dataclass(frozen=True, slots=True)
class Use:
    """How a face uses a curve."""

    role: str
    forward: bool


@dataclass(frozen=True, slots=True, eq=False)
class Curve:
    """Piece of a carrier between two vertices. start < end; on a closed carrier `end` may exceed the period."""

    carrier: int
    start: float
    end: float
    vertices: tuple[int, int]
    uses: dict[int, Use]

    @property
    def length(self) -> float:
        """Length (of the guide, for a traced carrier)."""
        return self.end - self.start


class Topology:
    """Collects spans and cuts; `curves` then gives the curves."""

    def __init__(self, tolerance: float, reach: float, frame: Array | None = None, chord: float = float("inf")) -> None:
        """tolerance, reach, chord: lengths, as in CarrierTable.

        frame: (3, 3), user's point = frame @ working point; None where they are one.
        """
        self.tolerance = tolerance
        self.frame: Array = np.eye(3) if frame is None else frame
        self.carriers = CarrierTable(tolerance, reach, chord)
        self.vertices = VertexTable(tolerance)
        self._spans: dict[int, list[Span]] = {}
        self._cuts: dict[int, list[tuple[float, Array]]] = {}

    def place_text(self, point: Array) -> str:
        """A working point (3,) as messages show it, in the user's frame."""
        return place_text(self.frame @ point)

    def carrier(self, index: int) -> Carrier:
        """The carrier of that index."""
        return self.carriers[index]

    def spans(self, carrier: int) -> list[Span]:
        """What lies on the carrier so far."""
        return self._spans.get(carrier, [])

    def add_span(self, carrier: int, span: Span, ends: tuple[Array | None, Array | None] = (None, None)) -> None:
        """Lay a span. ends: the exact points of its start and end, which become cuts; None for no cut there."""
        self._spans.setdefault(carrier, []).append(span)
        for value, point in zip((span.start, span.end), ends):
            if point is not None:
                self.cut(carrier, value, point)

    def cut(self, carrier: int, parameter: float, point: Array) -> None:
        """A vertex on the carrier."""
        period = self.carriers[carrier].period
        self._cuts.setdefault(carrier, []).append((parameter % period if period else parameter, point))

    def cuts(self, carrier: int) -> list[float]:
        """Parameters of the vertices on the carrier so far, in their order; those at one place as one."""
        return [value for value, _ in self._distinct_cuts(carrier)]

    def curves(self) -> list[Curve]:
        """All curves that some face uses, in the order of the carriers and along each."""
        found: list[Curve] = []
        for carrier in sorted(self._spans):
            found += self._curves_on(carrier)
        return found

    def _curves_on(self, index: int) -> list[Curve]:
        carrier = self.carriers[index]
        spans = self._spans[index]
        period = carrier.period
        cuts = self._distinct_cuts(index)
        if period:
            # A closed carrier needs two vertices, or its curve would be a loop without ends.
            if not cuts:
                cuts = [(0.0, carrier.at(np.zeros(1))[0])]
            if len(cuts) == 1:
                opposite = cuts[0][0] + period / 2
                cuts.append((opposite, carrier.at(np.array([opposite]))[0]))
            cuts.append((cuts[0][0] + period, cuts[0][1]))
        found = []
        covered = _covered(spans, [value for value, _ in cuts], period)
        for ((start, first), (end, second)), uses in zip(itertools.pairwise(cuts), covered, strict=True):
            if uses:
                ends = (self.vertices.add(first), self.vertices.add(second))
                if ends[0] != ends[1]:
                    found.append(Curve(index, start, end, ends, uses))
        return found

    def _distinct_cuts(self, index: int) -> list[tuple[float, Array]]:
        """Parameter and point of each vertex; the first one of those within the tolerance."""
        period = self.carriers[index].period
        cuts: list[tuple[float, Array]] = []
        for value, point in sorted(self._cuts.get(index, []), key=lambda cut: cut[0]):
            if not cuts or value - cuts[-1][0] > self.tolerance:
                cuts.append((value, point))
        if period and len(cuts) > 1 and cuts[0][0] + period - cuts[-1][0] <= self.tolerance:
            cuts.pop()
        return cuts


def _covered(spans: list[Span], cuts: list[float], period: float | None) -> list[dict[int, Use]]:
    """By piece between neighbouring cuts, in ascending order: the faces whose spans cover its middle, and how.

    Each span is asked for its pieces, not each piece for its spans: a long line has thousands of both.
    """
    middles = [0.5 * (start + end) for start, end in itertools.pairwise(cuts)]
    shifts = (0.0, period, -period) if period else (0.0,)
    uses: list[dict[int, Use]] = [{} for _ in middles]
    for span in spans:
        use = Use(span.role, span.forward)
        ranges = [(0, len(middles))] if span.whole else [_between(middles, span, shift) for shift in shifts]
        for place in itertools.chain.from_iterable(range(*ends) for ends in ranges):
            known = uses[place].get(span.face)
            if known is None or (known.role == IMPRINT and span.role == BOUNDARY):
                uses[place][span.face] = use
    return uses


def _between(middles: list[float], span: Span, shift: float) -> tuple[int, int]:
    """First and last place, exclusive, of the ascending middles that the span covers when they are moved by `shift`."""

    def moved(middle: float) -> float:
        return middle + shift

    return bisect_left(middles, span.start, key=moved), bisect_right(middles, span.end, key=moved)
