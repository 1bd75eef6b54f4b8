"""Edges that hang from joint curves by rigid arms: their nodes are those of the curve, carried to the flange's face."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kernel.errors import DefectError
from kernel.idealise.arm_cuts import SAME, Hanging, Pair
from kernel.idealise.arms import Arm
from kernel.idealise.topology import Curve, Topology
from kernel.mesh.assembly import Tie
from kernel.mesh.mesh import Mesh
from kernel.mesh.order import middle_nodes

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

TAPER = 3.0
"""Where an edge ends before its joint curve does, its nodes are moved together over this many times the shortfall."""


@dataclass(frozen=True, slots=True, eq=False)
class HungCurve:
    """The curve of number `edge` hangs from that of number `along`, of which it is a parallel.

    is_forward: whether both run the same way. start, end: by how much the edge's ends lie further along the joint
    curve than the ends of `along` itself.
    """

    arm: Arm
    edge: int
    along: int
    is_forward: bool
    start: float
    end: float

    def grade(self, sizes: list[Array]) -> None:
        """Make the sizes at samples along `along`, evenly spaced, no larger than those along the edge."""
        mine, other = sizes[self.along], sizes[self.edge]
        if not self.is_forward:
            other = other[::-1]
        places = np.linspace(0.0, 1.0, len(mine))
        np.minimum(mine, np.interp(places, np.linspace(0.0, 1.0, len(other)), other), out=mine)

    def divided(self, topology: Topology, edge: Curve, along: Curve, parameters: Array) -> tuple[Array, Array]:
        """The edge's parameters (n,), ends included, and points (n - 2, 3), for those of the joint curve."""
        inner = parameters[1:-1]
        moved = inner.copy()
        for away, shift in ((inner - along.start, self.start), (along.end - inner, self.end)):
            zone = min(TAPER * abs(shift), 0.5 * along.length)
            if zone > 0:
                moved += shift * np.clip(1.0 - away / zone, 0.0, 1.0)
        points = self.arm.edge_points(topology.carrier(along.carrier).at(moved))
        if not self.is_forward:
            points = points[::-1]
        carrier = topology.carrier(edge.carrier)
        values = carrier.parameters(points)
        if carrier.period is not None:
            values = edge.start + np.mod(values - edge.start, carrier.period)
        return np.concatenate([[edge.start], values, [edge.end]]), points


def hung_curves(topology: Topology, curves: Sequence[Curve], hangings: Sequence[Hanging]) -> list[HungCurve]:
    """Which curve hangs from which. DefectError where an arm's vertices and the curves between them do not agree."""
    by_carrier: dict[int, list[int]] = {}
    for number, curve in enumerate(curves):
        by_carrier.setdefault(curve.carrier, []).append(number)

    def between(carrier: int, first: float, last: float, faces: set[int]) -> int | None:
        period = topology.carrier(carrier).period
        slack = 4 * topology.tolerance
        for number in by_carrier.get(carrier, []):
            curve = curves[number]
            ends = (curve.start, curve.end)
            if period is None:
                same = abs(ends[0] - first) <= slack and abs(ends[1] - last) <= slack
            else:
                same = _is_turn(ends[0] - first, period, slack) and _is_turn(ends[1] - last, period, slack)
            if same and faces.intersection(curve.uses):
                return number
        return None

    found = []
    for hanging in hangings:
        arm = hanging.arm
        pairs = [*hanging.pairs, hanging.pairs[0]] if hanging.is_closed else list(hanging.pairs)
        is_forward = _is_forward(topology, arm)
        for first, last in pairwise(pairs):
            along = between(arm.along.carrier, first[0], last[0], {wall.index for wall in arm.flanges})
            ends = (first[1], last[1]) if is_forward else (last[1], first[1])
            edge = between(arm.edge.carrier, *ends, {arm.web.index})
            if (along is None) != (edge is None):
                place = topology.place_text(topology.carrier(arm.along.carrier).at(np.array([first[0]]))[0])
                raise DefectError(
                    f"the edge of {arm.web.segment.id} and the joint curve in {arm.flanges[0].segment.id} are divided "
                    f"differently near {place}"
                )
            if along is not None and edge is not None:
                shifts = [_shift(topology, arm, pair) for pair in (first, last)]
                found.append(HungCurve(arm, edge, along, is_forward, *shifts))
    return found


def arm_rows(nodes: Sequence[Indices], hung: Sequence[HungCurve]) -> Indices:
    """(n, 4): the two nodes of each element edge that hangs, and the two of the joint curve from which they hang.

    nodes: of each curve, by its number. The rows of each hung curve follow those of the one before it.
    """
    rows = [np.empty((0, 4), np.int64)]
    for one in hung:
        edge = nodes[one.edge] if one.is_forward else nodes[one.edge][::-1]
        along = nodes[one.along]
        rows.append(np.stack([edge[:-1], edge[1:], along[:-1], along[1:]], axis=1))
    return np.concatenate(rows)


def arm_ties(mesh: Mesh, rows: Indices, hung: Sequence[HungCurve], nodes: Sequence[Indices]) -> list[Tie]:
    """A rigid tie for every node of every edge that hangs, mid-side nodes too. rows: of arm_rows."""
    joints = [one.arm.joint for one in hung for _ in nodes[one.edge][1:]]
    middles = middle_nodes(mesh) if len(rows) else {}
    ties: dict[tuple[int, int], Tie] = {}
    for (a, b, from_a, from_b), joint in zip(rows.tolist(), joints, strict=True):
        pairs = [(a, from_a), (b, from_b)]
        edge = (min(a, b), max(a, b))
        if edge in middles:
            pairs.append((middles[edge], middles[min(from_a, from_b), max(from_a, from_b)]))
        for dependent, independent in pairs:
            key = (dependent, independent)
            ties.setdefault(key, Tie("rigid", joint, np.array([dependent]), np.array([independent])))
    return list(ties.values())


def _is_turn(difference: float, period: float, slack: float) -> bool:
    return abs(difference - period * round(difference / period)) <= slack


def _is_forward(topology: Topology, arm: Arm) -> bool:
    """Whether the edge's carrier runs the same way as the joint curve's."""
    edge = topology.carrier(arm.edge.carrier)
    values = edge.parameters(arm.edge_points(_step(topology, arm, 0.5 * (arm.along.start + arm.along.end))))
    difference = float(values[1] - values[0])
    if edge.period is not None:
        difference -= edge.period * round(difference / edge.period)
    return difference > 0


def _shift(topology: Topology, arm: Arm, pair: Pair) -> float:
    """How much further along the joint curve the edge's vertex lies than its partner."""
    step = _step(topology, arm, pair[0])
    right = arm.edge_points(step[:1])[0]
    point = topology.carrier(arm.edge.carrier).at(np.array([pair[1]]))[0]
    shift = float((point - right) @ (step[1] - step[0]) / np.linalg.norm(step[1] - step[0]))
    return shift if abs(shift) > SAME * topology.tolerance else 0.0


def _step(topology: Topology, arm: Arm, parameter: float) -> Array:
    """A point of the joint curve and one a little further on, (2, 3)."""
    step = 1e-3 * (arm.along.end - arm.along.start)
    return topology.carrier(arm.along.carrier).at(np.array([parameter, parameter + step]))
