"""`csgmesh rules coverage`: which conditions the cases of a rule base exercise both ways."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from kernel.errors import CsgmeshError
from kernel.facts import Facts
from rules.analysis.cases import Describe, facts_of
from rules.engine import RuleBase
from rules.logic import TRUE
from rules.trace import Tracer
from rules.view import View


@dataclass(frozen=True, slots=True)
class ConditionCoverage:
    """One comparison of one rule, and in how many nodes of the cases it held and failed."""

    condition: str
    held: int
    failed: int

    @property
    def both(self) -> bool:
        """Whether it was seen both ways."""
        return self.held > 0 and self.failed > 0


@dataclass(frozen=True, slots=True)
class RuleCoverage:
    """One rule. held: in how many nodes it held; won: in how many it made the conclusion."""

    id: str
    place: str
    held: int
    won: int
    conditions: tuple[ConditionCoverage, ...]


@dataclass(frozen=True, slots=True)
class CoverageReport:
    """All rules of a base, over all nodes of its cases."""

    name: str
    version: str
    n_node: int
    rules: tuple[RuleCoverage, ...]

    @property
    def share(self) -> float:
        """Share of the conditions that were seen both ways; 1 where there are none."""
        conditions = [condition for rule in self.rules for condition in rule.conditions]
        return sum(condition.both for condition in conditions) / len(conditions) if conditions else 1.0

    @property
    def ok(self) -> bool:
        """Every rule held once, and every condition was seen both ways."""
        return self.share == 1.0 and all(rule.held for rule in self.rules)

    def to_text(self) -> str:
        """For a terminal: the share, and what is missing."""
        lines = [f"{self.name} {self.version}: {self.share:.0%} of the conditions both ways, in {self.n_node} nodes"]
        for rule in self.rules:
            missing = [condition for condition in rule.conditions if not condition.both]
            if missing or not rule.held:
                lines.append(f"{rule.place}: {rule.id} held {rule.held} times, won {rule.won}")
            for condition in missing:
                never = "never held" if not condition.held else "never failed"
                if not condition.held and not condition.failed:
                    never = "never measured"
                lines.append(f"  {never}: {condition.condition}")
        return "\n".join(lines)

    def to_json(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "name": self.name,
            "version": self.version,
            "ok": self.ok,
            "share": self.share,
            "nodes": self.n_node,
            "rules": [
                {
                    "id": rule.id,
                    "place": rule.place,
                    "held": rule.held,
                    "won": rule.won,
                    "conditions": [
                        {"condition": c.condition, "held": c.held, "failed": c.failed, "both": c.both}
                        for c in rule.conditions
                    ],
                }
                for rule in self.rules
            ],
        }


def coverage(base: RuleBase, describe: Describe | None = None) -> CoverageReport:
    """Run all cases, and count what each comparison of each rule came to."""
    nodes = list(_nodes(base, describe))
    held = {rule.id: 0 for rule in base.rules}
    won = {rule.id: 0 for rule in base.rules}
    states: dict[str, dict[str, list[int]]] = {rule.id: {} for rule in base.rules}
    for facts in nodes:
        verdict, view, _ = base.judge(facts)
        if not isinstance(verdict, int):
            won[verdict.winner.rules[0].id] += 1
        _count(base, view, held, states)
    rules = tuple(
        RuleCoverage(
            rule.id,
            str(rule.place),
            held[rule.id],
            won[rule.id],
            tuple(ConditionCoverage(text, *counts) for text, counts in states[rule.id].items()),
        )
        for rule in base.rules
    )
    return CoverageReport(base.name, base.version, len(nodes), rules)


def _count(base: RuleBase, view: View, held: dict[str, int], states: dict[str, dict[str, list[int]]]) -> None:
    tracer = Tracer(base.compiler, view)
    for index, rule in enumerate(base.rules):
        held[rule.id] += base.matches[index](view) == TRUE
        for reading in tracer.readings(rule.condition):
            counts = states[rule.id].setdefault(reading.condition, [0, 0])
            if reading.state == "holds":
                counts[0] += 1
            elif reading.state == "fails":
                counts[1] += 1


def _nodes(base: RuleBase, describe: Describe | None) -> list[Facts]:
    nodes = []
    for case in base.definition.cases:
        if case.facts is not None:
            nodes.append(facts_of(case))
        elif describe is not None:
            try:
                plan = describe(case.csg or "", base.decide)
            except CsgmeshError:
                continue  # reported by run_cases; it covers nothing here
            nodes.extend(decision.facts for decision in plan.decisions)
    return nodes
