"""Vertices for arms: the web's edge and the joint curve from which it hangs get theirs in pairs.

    joint curve  v0------v1------------v2----v3       v3 is a corner with a third wall; the edge ends at its face,
    edge         u0------u1------------u2--u3         half a thickness before, and u3 hangs from v3 all the same

A vertex without a partner near its place gets one. What is left over beyond the last pair hangs from nothing: there
the flange, or the web, goes on alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.errors import ConnectError, DefectError
from kernel.idealise.arms import Arm
from kernel.idealise.carriers import Carrier, Line
from kernel.idealise.implicit import project
from kernel.idealise.topology import Topology

Array = NDArray[np.float64]
Pair = tuple[float, float]
"""Parameters on the joint curve's carrier and on the edge's carrier."""

SKEW = 0.75
"""Vertices are partners when they are nearer than this share of the thickest wall that either wall meets."""

SAME = 10.0
"""Vertices are at one place when they are nearer than this many tolerances."""

CLOSE = 1e-3
"""A foot is found when what hangs from it is nearer to its vertex than this share of the tolerance."""

MOST_STEPS = 50
"""Steps of the secant method before a foot is given up."""

MOST_ROUNDS = 20
"""Rounds in which vertices may be added: one for each wall that hangs from one that hangs itself."""


@dataclass(frozen=True, slots=True, eq=False)
class Hanging:
    """The pairs of vertices of an arm, in the direction of the joint curve. is_closed: the last is followed by the
    first.
    """

    arm: Arm
    pairs: tuple[Pair, ...]
    is_closed: bool


def pair_vertices(topology: Topology, arms: Sequence[Arm], reach: dict[int, float]) -> list[Hanging]:
    """Cut the carriers of edges and joint curves until every vertex of an arm has its partner.

    reach: by wall index, the greatest thickness of the wall and of those that it crosses.
    """
    skew = [SKEW * max(reach[wall.index] for wall in arm.walls) for arm in arms]
    for _ in range(MOST_ROUNDS):
        found, is_complete = [], True
        for arm, most in zip(arms, skew):
            pairing = _Pairing(topology, arm, most)
            is_complete &= not pairing.add_partners()
            found.append(Hanging(arm, tuple(pairing.pairs), pairing.is_closed))
        if is_complete:
            return found
    raise DefectError(f"the vertices of {len(arms)} arms find no partners, expected all to after {MOST_ROUNDS} rounds")


class _Pairing:
    """One look at the vertices of one arm. pairs: those that have found each other."""

    def __init__(self, topology: Topology, arm: Arm, skew: float) -> None:
        self.topology, self.arm, self.skew = topology, arm, skew
        self.same = SAME * topology.tolerance
        self.curve: Carrier = topology.carrier(arm.along.carrier)
        self.edge: Carrier = topology.carrier(arm.edge.carrier)
        self.is_closed = arm.along.whole and arm.edge.whole
        self.low, self.high = arm.along.start, arm.along.end
        self.on_curve = self._curve_vertices()
        self.on_edge = self._edge_vertices()
        self.pairs: list[Pair] = []
        self._matched: dict[int, int] = {}  # edge vertex -> curve vertex
        self._match()

    def _curve_vertices(self) -> list[float]:
        faces = {wall.index for wall in self.arm.flanges}
        spans = [span for span in self.topology.spans(self.arm.along.carrier) if span.face in faces]
        period = self.curve.period
        shifts = (0.0, period, -period) if period else (0.0,)
        found = []
        for value in self.topology.cuts(self.arm.along.carrier):
            for shift in shifts:
                place = value + shift
                last = self.high - self.same if self.is_closed else self.high + self.same
                if self.low - self.same <= place <= last and any(
                    span.whole or span.start - self.same <= place + back <= span.end + self.same
                    for span in spans
                    for back in shifts
                ):
                    found.append(place)
        return sorted(found)

    def _edge_vertices(self) -> list[Pair]:
        """Places on the joint curve, and parameters on the edge's carrier, of the edge's vertices."""
        edge, period = self.arm.edge, self.edge.period
        shifts = (0.0, period, -period) if period else (0.0,)
        last = edge.end - self.same if edge.whole else edge.end + self.same
        values = sorted(
            value + shift
            for value in self.topology.cuts(edge.carrier)
            for shift in shifts
            if edge.start - self.same <= value + shift <= last
        )
        return sorted((self._foot(value), value) for value in values)

    def _foot(self, value: float) -> float:
        """Where on the joint curve a place of the edge hangs from."""
        point = self.edge.at(np.array([value]))
        sheets = (self.arm.web.sheet.surface, self.arm.flanges[0].sheet.surface)
        foot = float(self.curve.parameters(project(point, sheets))[0])
        if not isinstance(self.curve, Line):
            foot = self._refined(foot, value)
        period = self.curve.period
        if period is None:
            return foot
        if self.is_closed:
            return self.low + (foot - self.low + self.same) % period - self.same
        middle = 0.5 * (self.low + self.high)
        return foot - period * round((foot - middle) / period)

    def _refined(self, foot: float, value: float) -> float:
        """The same, from a guess: the secant method on how far what hangs from it lies beside the place."""

        def beside(at: float) -> float:
            away = float(self.edge.parameters(self.arm.edge_points(self.curve.at(np.array([at]))))[0]) - value
            return away if self.edge.period is None else away - self.edge.period * round(away / self.edge.period)

        before, was = foot, beside(foot)
        step = 1e-3 * (self.high - self.low)
        foot = before + step
        for _ in range(MOST_STEPS):
            now = beside(foot)
            if abs(now) <= CLOSE * self.topology.tolerance or abs(now - was) <= np.finfo(float).eps * abs(value):
                return foot
            before, was, foot = foot, now, foot - now * (foot - before) / (now - was)
        place = self.topology.place_text(self.edge.at(np.array([value]))[0])
        raise ConnectError(f"{self.arm.web.segment.id} hangs from no place of its joint curve near {place}")

    def _place(self, foot: float) -> float:
        """The parameter on the edge of what hangs from a place on the joint curve."""
        point = self.arm.edge_points(self.curve.at(np.array([foot])))
        value = float(self.edge.parameters(point)[0])
        edge, period = self.arm.edge, self.edge.period
        if period is None:
            return value
        return edge.start + (value - edge.start + self.same) % period - self.same

    # ------------------------------------------------------------ partners

    def _match(self) -> None:
        """Those at one place first, then the ends, then whatever is near."""
        edge_ends = {} if self.is_closed else {0, len(self.on_edge) - 1}
        curve_ends = {} if self.is_closed else {0, len(self.on_curve) - 1}
        for reach, only_ends in ((self.same, False), (self.skew, True), (self.skew, False)):
            wanted = sorted(
                (abs(foot - place), e, c)
                for e, (foot, _) in enumerate(self.on_edge)
                for c, place in enumerate(self.on_curve)
                if abs(foot - place) <= reach and (not only_ends or e in edge_ends or c in curve_ends)
            )
            for _, e, c in wanted:
                if self._is_free(e, c):
                    self._matched[e] = c
        self.pairs = [(self.on_curve[c], self.on_edge[e][1]) for e, c in sorted(self._matched.items())]

    def _is_free(self, e: int, c: int) -> bool:
        if e in self._matched or c in self._matched.values():
            return False
        return all((e < other) == (c < at) for other, at in self._matched.items())

    def add_partners(self) -> bool:
        """Cut the one carrier where only the other has a vertex; False where nothing was missing."""
        if self.is_closed and not self.on_curve and not self.on_edge:
            for share in (0.0, 0.5):
                self._cut_curve(self.low + share * (self.high - self.low))
            return True
        if not self.is_closed and self._cut_ends():
            return True
        edge_range = (0.0, 0.0)
        if self.on_edge:
            edge_range = self.on_edge[0][0], self.on_edge[-1][0]
        inner = self._matched_range()
        added = False
        for e, (foot, _) in enumerate(self.on_edge):
            if e in self._matched:
                continue
            if self.is_closed or self.low + self.same < foot < self.high - self.same:
                # where the curve's own end has a partner further in, nothing is missing beyond it
                if self.is_closed or not inner or not self._is_beyond(e, inner, len(self.on_edge), 0):
                    self._cut_curve(foot)
                    added = True
        for c, place in enumerate(self.on_curve):
            if c in self._matched.values():
                continue
            if self.is_closed or edge_range[0] + self.same < place < edge_range[1] - self.same:
                if self.is_closed or not inner or not self._is_beyond(c, inner, len(self.on_curve), 1):
                    self._cut_edge(place, c)
                    added = True
        return added

    def _cut_ends(self) -> bool:
        """Vertices at the ends of an edge that is part of a ring, which has none of its own there."""
        ends = (self.arm.edge.start, self.arm.edge.end)
        bare = [end for end in ends if all(abs(value - end) > self.same for _, value in self.on_edge)]
        for end in bare:
            self.topology.cut(self.arm.edge.carrier, end, self.edge.at(np.array([end]))[0])
        return bool(bare)

    def _matched_range(self) -> tuple[tuple[int, int], tuple[int, int]] | None:
        """First and last pair, each as (edge vertex, curve vertex)."""
        if not self._matched:
            return None
        ordered = sorted(self._matched.items())
        return ordered[0], ordered[-1]

    def _is_beyond(self, item: int, inner: tuple[tuple[int, int], tuple[int, int]], count: int, side: int) -> bool:
        """Whether a vertex (side 0 of the edge, 1 of the curve) lies beyond a pair in which the other side ends."""
        first, last = inner
        other_last = (len(self.on_curve) if side == 0 else len(self.on_edge)) - 1
        other = 1 - side
        return (item < first[side] and first[other] == 0) or (item > last[side] and last[other] == other_last)

    def _cut_curve(self, place: float) -> None:
        self.topology.cut(self.arm.along.carrier, place, self.curve.at(np.array([place]))[0])

    def _cut_edge(self, place: float, c: int) -> None:
        """A vertex on the edge for that on the curve: where it belongs, or, between pairs askew, in proportion."""
        value = self._place(place)
        ordered = sorted(self._matched.items())
        below = [(self.on_curve[at], self.on_edge[e][1]) for e, at in ordered if at < c]
        above = [(self.on_curve[at], self.on_edge[e][1]) for e, at in ordered if at > c]
        if below and above and not self.is_closed:
            (first, low), (last, high) = below[-1], above[0]
            if not min(low, high) + self.same < value < max(low, high) - self.same:
                value = low + (place - first) / (last - first) * (high - low)
        self.topology.cut(self.arm.edge.carrier, value, self.edge.at(np.array([value]))[0])
