"""Partition: the walk from the root that asks about each piece, and carries out what is concluded.

    piece -> facts, tier by tier -> conclusion (or the user's override) -> beam plate cylinder_plate brick: a draft
                                                                        -> plates: its walls, and what they leave
                                                                        -> split: its operands (or components)
                                                                        -> cut: its pieces after cuts at necks
    drafts of a split -> overlaps settled -> clusters tried as one -> segments

The walk judges nothing: `decide` does (see plan.py). It records every question and answer.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import count
from typing import TYPE_CHECKING

import numpy as np
import shapely
from shapely import STRtree

from kernel import describe
from kernel.csg.source import MAX_TREE_DEPTH
from kernel.errors import RuleError
from kernel.facts import TIERS, Facts
from kernel.plan import Conclusion, Decide, Decision, Need, Override, Plan
from kernel.segment.assign import UnfitError, drafts_as_one, drafts_of_walls
from kernel.segment.clusters import Cluster, find_clusters
from kernel.segment.necks import cut_at_neck
from kernel.segment.numbering import check_volume, named, numbered
from kernel.segment.operands import Operand, likeness_key, operand_at, operands_of, solid_of
from kernel.segment.ownership import settle_overlaps
from kernel.segment.pieces import Likeness, Piece
from kernel.segment.pinned import Pins, pin
from kernel.segment.remains import is_another
from kernel.segment.segments import Segment
from kernel.segment.shapes import Draft
from kernel.units import VOLUME_TOLERANCE

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated
    from kernel.solid.solid import Solid

CALLS_PER_LEVEL = 12
"""Python calls in one another for each level of the tree, which may be 250 deep: more than Python allows by itself."""

NECK_DEPTH = 12
"""Cuts at necks within cuts at necks: what a frame of a dozen bars needs; deeper is no assembly of members."""


@dataclass(frozen=True, slots=True, eq=False)
class Partition:
    """The segments of a model, and the plan that they come from."""

    segments: tuple[Segment, ...]
    plan: Plan


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What became of a piece: drafts, and the decisions that were taken on the way."""

    drafts: tuple[Draft, ...]
    decisions: tuple[Decision, ...]


def partition(
    evaluated: Evaluated, decide: Decide, overrides: Mapping[str, Override] | None = None, *, use_tree: bool = True
) -> Partition:
    """The model as disjoint segments that fill it.

    overrides: by canonical path. use_tree: False decides the evaluated solid as if it were one leaf (for comparison).
    OverrideError: an override that cannot be; RuleError: a conclusion of the rules that cannot be; DefectError: the
    segments do not fill the solid.
    """
    overrides = dict(overrides or {})
    root = operand_at("/", evaluated.model.root)
    pins = pin(evaluated.model.root, overrides)
    walker = _Walk(evaluated, decide, pins)
    piece = Piece(evaluated.solid, root.path, root.path, "root", 0, root.node.name, operand=root if use_tree else None)
    with _room_for_depth():
        outcome = walker.settle(piece)
    check_volume(outcome.drafts, evaluated.solid)
    segments = numbered(outcome.drafts, evaluated)
    return Partition(segments, Plan(outcome.decisions, overrides))


@contextmanager
def _room_for_depth() -> Iterator[None]:
    """As many calls in one another as the deepest tree takes; the caller's own limit holds again afterwards."""
    before = sys.getrecursionlimit()
    sys.setrecursionlimit(before + CALLS_PER_LEVEL * MAX_TREE_DEPTH)
    try:
        yield
    finally:
        sys.setrecursionlimit(before)


@dataclass(eq=False)
class _Walk:
    """One way through the tree. What was done once is kept, by the piece that it was done to.

    answers: of the rules, by the facts' key. trials: cuts at necks. divided: operands decided. children: pieces of
    operands, which know nothing of overrides. unpinned: the same walk without overrides, once somebody has asked.
    """

    evaluated: Evaluated
    decide: Decide
    pins: Pins
    answers: dict[tuple, Conclusion | Need] = field(default_factory=dict)
    trials: dict[int, tuple[Piece, Outcome]] = field(default_factory=dict)
    divided: dict[int, tuple[Piece, Outcome]] = field(default_factory=dict)
    children: dict[int, tuple[Piece, list[Piece]]] = field(default_factory=dict)
    unpinned: _Walk | None = None
    neck_depth: int = 0

    # ---- asking

    def settle(self, piece: Piece) -> Outcome:
        """The piece decided, by override or by rule, and what follows from it carried out.

        MeshError: faces of it that are too finely interlocked for their areas to be joined or compared.
        """
        with named(piece.path):
            return self._settled(piece)

    def _settled(self, piece: Piece) -> Outcome:
        facts, by_rule = self.ask(piece)
        pinned, below = self.pins.of(piece.operand), self.pins.below(piece.operand)
        override = pinned[1] if pinned else None
        if below and override is None:
            override = Override("split", reason=f"so that the override of {', '.join(below)} can be carried out")
        origin = "override" if override is not None else "rule"
        decision = Decision(piece.label, facts, override.type if override else by_rule.type, origin, by_rule, override)
        try:
            outcome = self._carry_out(piece, decision)
        except UnfitError as unfit:
            if override is not None:
                raise unfit.as_override_error(pinned[0] if pinned else piece.path, override.type) from None
            raise RuleError(
                f"rule {by_rule.rule} concludes {by_rule.type} for {piece.label}, which cannot be: {unfit.reason}"
            ) from None
        return Outcome(outcome.drafts, (decision, *outcome.decisions))

    def ask(self, piece: Piece) -> tuple[Facts, Conclusion]:
        """The rules' conclusion, and the facts that it took."""
        facts = describe.intent(piece)
        while True:
            answer = self._answer(facts)
            if isinstance(answer, Conclusion):
                return facts, answer
            if answer.tier not in TIERS or TIERS.index(answer.tier) <= TIERS.index(facts.tier):
                raise RuleError(f"the rules ask for facts of {answer.tier!r} that {piece.label} already has")
            for tier in TIERS[TIERS.index(facts.tier) + 1 : TIERS.index(answer.tier) + 1]:
                facts = facts.with_tier(tier, self._measure(piece, tier), describe.related(piece, tier))

    def _answer(self, facts: Facts) -> Conclusion | Need:
        answer = self.answers.get(facts.key)
        if answer is None:
            answer = self.answers[facts.key] = self.decide(facts)
        return answer

    def _measure(self, piece: Piece, tier: str) -> dict:
        if tier == "members":
            return self._members(piece)
        if tier != "necks":
            return describe.measure(piece, tier)
        outcome = self._cut(piece)
        members = sum(draft.solid.volume for draft in outcome.drafts if draft.type != "brick")
        return describe.necks(len(outcome.drafts), members, piece.solid.volume)

    def _members(self, piece: Piece) -> dict:
        """What the operands would be without any override, each deciding for itself."""
        if piece.operand is None or not operands_of(piece.operand):
            return {}
        drafts = self._without_pins()._operands(piece, operands_of(piece.operand)).drafts
        beams = [draft for draft in drafts if draft.type == "beam"]
        pieces = Counter((draft.path, draft.sources) for draft in beams)
        cut_count = sum(count > 1 for count in pieces.values())
        held = [(draft.solid.volume, draft.prism) for draft in beams if draft.prism is not None]
        return describe.members(held, cut_count, piece.solid)

    def _without_pins(self) -> _Walk:
        """The walk as it would be without overrides, on the same pieces: one for all that ask."""
        if not self.pins.by_operand:
            return self
        if self.unpinned is None:
            self.unpinned = replace(self, pins=Pins({}, {}), trials={}, divided={})
        return self.unpinned

    # ---- carrying out

    def _carry_out(self, piece: Piece, decision: Decision) -> Outcome:
        match decision.type:
            case "split":
                return self._split(piece, decision)
            case "plates":
                drafts = drafts_of_walls(piece, decision)
                return self._with_rest(piece, drafts)
            case "cut":
                outcome = self._cut(piece)
                if not outcome.drafts:
                    raise UnfitError("it has no necks to cut at")
                return outcome
            case _:
                if decision.type in ("plate", "cylinder_plate") and decision.origin == "rule":
                    if len(piece.walls.parts) == 1 and piece.walls.remainder:
                        return self._with_rest(piece, drafts_of_walls(piece, decision))
                return Outcome(drafts_as_one(piece, decision), ())

    def _with_rest(self, piece: Piece, drafts: tuple[Draft, ...]) -> Outcome:
        """Wall drafts, and the remainder of their piece decided again."""
        outcomes = [
            self.settle(piece.part(rest, number, "remainder")) for number, rest in enumerate(piece.walls.remainder, 1)
        ]
        return _joined([Outcome(drafts, ()), *outcomes])

    def _split(self, piece: Piece, decision: Decision) -> Outcome:
        operands = operands_of(piece.operand) if piece.operand is not None else ()
        if operands:
            if decision.by_rule.type == "split" or decision.override is None or self.pins.of(piece.operand) is None:
                return self._operands(piece, operands)
            outcome = _joined([self.settle(child) for child in self._children(piece, operands)])
            return self._settled_overlaps(piece, outcome)
        if len(piece.components) < 2:
            raise UnfitError("it is one solid and has no operands")
        return _joined(
            [self.settle(piece.part(part, number, "piece")) for number, part in enumerate(piece.components, 1)]
        )

    def _operands(self, piece: Piece, operands: Sequence[Operand]) -> Outcome:
        """Every operand decided, what they share given to one of them, and clusters combined; done once."""
        if id(piece) not in self.divided:
            children = self._children(piece, operands)
            outcome = _joined([self.settle(child) for child in children])
            outcome = self._settled_overlaps(piece, outcome)
            asked = {child.path: child.solid.volume for child in children}
            self.divided[id(piece)] = (piece, self._cluster(piece, outcome, asked))
        return self.divided[id(piece)][1]

    def _settled_overlaps(self, piece: Piece, outcome: Outcome) -> Outcome:
        """What drafts share given to one of them, and what is then no longer what it was decided again by itself."""
        outcomes = []
        labels = {decision.node for decision in outcome.decisions}
        for draft in settle_overlaps(outcome.drafts, piece.solid.volume):
            if not is_another(draft):
                outcomes.append(Outcome((draft,), ()))
                continue
            numbered = (f"{draft.decision.node}#{number}" for number in count(1))
            label = next(label for label in numbered if label not in labels)
            labels.add(label)
            rest = Piece(draft.solid, draft.path, label, "remainder", piece.depth, draft.name)
            outcomes.append(self.settle(rest))
        settled = _joined(outcomes)
        return Outcome(settled.drafts, (*outcome.decisions, *settled.decisions))

    def _children(self, piece: Piece, operands: Sequence[Operand]) -> list[Piece]:
        """Pieces for the operands that have material, each knowing the others whose boxes touch its own; made once."""
        if id(piece) not in self.children:
            self.children[id(piece)] = (piece, self._made_children(piece, operands))
        return self.children[id(piece)][1]

    def _made_children(self, piece: Piece, operands: Sequence[Operand]) -> list[Piece]:
        solids = [(operand, solid_of(self.evaluated, operand)) for operand in operands]
        solids = [(operand, solid) for operand, solid in solids if not solid.is_empty]
        beside = _touching_boxes([solid for _, solid in solids])
        pieces = [
            Piece(
                solid=solid,
                path=operand.path,
                label=operand.path,
                role="operand",
                depth=operand.depth,
                name=operand.node.name,
                operand=operand,
            )
            for operand, solid in solids
        ]
        first: dict[tuple, Piece] = {}
        for index, child in enumerate(pieces):
            key = likeness_key(solids[index][0])
            if key is not None and child is not (like := first.setdefault(key, child)):
                shift = child.solid.bounds.mean(axis=0) - like.solid.bounds.mean(axis=0)
                child.likeness = Likeness(like, shift)
            child.neighbours = (*piece.neighbours, *(pieces[other] for other in beside[index]))
        return pieces

    def _cut(self, piece: Piece) -> Outcome:
        """The piece cut at its smallest neck and its parts decided, done once; no drafts where there is no neck."""
        if id(piece) in self.trials:
            return self.trials[id(piece)][1]
        outcome = Outcome((), ())
        if self.neck_depth < NECK_DEPTH:
            self.neck_depth += 1
            parts = cut_at_neck(piece.solid)
            outcome = _joined([self.settle(piece.part(part, number, "piece")) for number, part in enumerate(parts, 1)])
            self.neck_depth -= 1
        self.trials[id(piece)] = (piece, outcome)
        return outcome

    # ---- clusters

    def _cluster(self, piece: Piece, outcome: Outcome, asked: Mapping[str, float]) -> Outcome:
        """Drafts that the rules see as one member combined.

        asked: volumes of the operands by path. What is but one of them was asked about already, and beside its
        neighbours: walls of a short tube between two others are not put together again.
        """
        drafts = list(outcome.drafts)
        decisions = list(outcome.decisions)
        gone: set[int] = set()
        made: list[Draft] = []
        number = 0
        for cluster in find_clusters(drafts):
            if gone.intersection(cluster.members) or _is_operand(cluster, drafts, asked):
                continue
            number += 1
            combined = self._try_cluster(piece, drafts, cluster, number)
            if combined is not None:
                gone.update(cluster.members)
                made.append(combined.drafts[0])
                decisions += combined.decisions
        kept = [draft for index, draft in enumerate(drafts) if index not in gone]
        return Outcome((*kept, *made), tuple(decisions))

    def _try_cluster(self, piece: Piece, drafts: list[Draft], cluster: Cluster, number: int) -> Outcome | None:
        members = [drafts[index] for index in cluster.members]
        whole = Piece(cluster.solid, piece.path, f"{piece.label}#{number}", "cluster", piece.depth, piece.name)
        facts, by_rule = self.ask(whole)
        if by_rule.type not in ("plate", "plates") if cluster.kind == "sheet" else by_rule.type != "beam":
            return None
        type_ = "plate" if cluster.kind == "sheet" else "beam"
        decision = Decision(whole.label, facts, type_, "rule", by_rule)
        try:
            draft = drafts_as_one(whole, decision)[0]
        except UnfitError:
            return None
        if draft.solid.volume < (1.0 - VOLUME_TOLERANCE) * cluster.solid.volume:
            return None
        sources = tuple(sorted({path for member in members for path in (member.sources or (member.path,))}))
        return Outcome((replace(draft, sources=sources),), (decision,))


def _is_operand(cluster: Cluster, drafts: Sequence[Draft], asked: Mapping[str, float]) -> bool:
    """Whether a cluster is all of one operand. asked: volumes of the operands by path."""
    first, *others = {drafts[index].path for index in cluster.members}
    return not others and first in asked and cluster.solid.volume >= (1.0 - VOLUME_TOLERANCE) * asked[first]


def _joined(outcomes: Sequence[Outcome]) -> Outcome:
    return Outcome(
        tuple(draft for outcome in outcomes for draft in outcome.drafts),
        tuple(decision for outcome in outcomes for decision in outcome.decisions),
    )


def _touching_boxes(solids: Sequence[Solid]) -> list[list[int]]:
    """For each solid, the others whose boxes touch its own."""
    if len(solids) < 2:
        return [[] for _ in solids]
    boxes = np.array([solid.bounds for solid in solids])
    slack = 10.0 * solids[0].surfaces.tolerance
    flat = shapely.box(boxes[:, 0, 0] - slack, boxes[:, 0, 1] - slack, boxes[:, 1, 0] + slack, boxes[:, 1, 1] + slack)
    first, second = STRtree(flat).query(flat)
    depth = np.minimum(boxes[first, 1], boxes[second, 1]) - np.maximum(boxes[first, 0], boxes[second, 0])
    touch = (depth > -slack).all(axis=1) & (first != second)
    beside: list[list[int]] = [[] for _ in solids]
    for one, other in zip(first[touch], second[touch]):
        beside[int(one)].append(int(other))
    return [sorted(others) for others in beside]
