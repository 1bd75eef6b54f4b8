"""`csgmesh rules diff A B`: which nodes two rule bases decide differently, and how."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from kernel.facts import Facts
from kernel.plan import Conclusion, Need, Plan
from rules.engine import RuleBase


@dataclass(frozen=True, slots=True)
class Change:
    """One node. before, after: a type, `need TIER`, or None where the base never asks about the node."""

    node: str
    before: str | None
    after: str | None
    rule_before: str
    rule_after: str
    because: str


@dataclass(frozen=True, slots=True)
class DiffReport:
    """All nodes that change from base `a` to base `b`, of n_node that were asked about."""

    a: str
    b: str
    n_node: int
    changes: tuple[Change, ...]

    @property
    def ok(self) -> bool:
        """Nothing changes."""
        return not self.changes

    def to_text(self) -> str:
        """For a terminal."""
        lines = [f"{self.a} -> {self.b}: {len(self.changes)} of {self.n_node} nodes change"]
        for change in self.changes:
            before = _told(change.before, change.rule_before)
            after = _told(change.after, change.rule_after, change.because)
            lines.append(f"  {change.node}: {before} -> {after}")
        return "\n".join(lines)

    def to_json(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "a": self.a,
            "b": self.b,
            "ok": self.ok,
            "nodes": self.n_node,
            "changes": [
                {
                    "node": change.node,
                    "before": change.before,
                    "after": change.after,
                    "rule_before": change.rule_before,
                    "rule_after": change.rule_after,
                    "because": change.because,
                }
                for change in self.changes
            ],
        }


def diff(a: RuleBase, b: RuleBase, nodes: Mapping[str, Facts]) -> DiffReport:
    """Ask both bases about the same facts."""
    changes = []
    for node, facts in sorted(nodes.items()):
        before, after = a.decide(facts), b.decide(facts)
        if _type(before) != _type(after):
            changes.append(_change(node, before, after))
    return DiffReport(_title(a), _title(b), len(nodes), tuple(changes))


def diff_plans(a: RuleBase, b: RuleBase, plans: Mapping[str, tuple[Plan, Plan]]) -> DiffReport:
    """Compare what became of whole models: model name -> (plan by a, plan by b).

    A node that only one of the two asks about is a change.
    """
    changes, count = [], 0
    for model, (before_plan, after_plan) in sorted(plans.items()):
        before = {decision.node: decision.by_rule for decision in before_plan.decisions}
        after = {decision.node: decision.by_rule for decision in after_plan.decisions}
        paths = list(dict.fromkeys([*before, *after]))
        count += len(paths)
        for path in paths:
            if _type(before.get(path)) != _type(after.get(path)):
                changes.append(_change(f"{model} {path}", before.get(path), after.get(path)))
    return DiffReport(_title(a), _title(b), count, tuple(changes))


def _told(answer: str | None, *by: str) -> str:
    """An answer with the rule, and its reason, in brackets; a tier that is needed has neither."""
    if answer is None:
        return "not asked"
    return f"{answer} ({': '.join(by)})" if by[0] else answer


def _title(base: RuleBase) -> str:
    return f"{base.name} {base.version}"


def _type(answer: Conclusion | Need | None) -> str | None:
    if answer is None:
        return None
    return f"need {answer.tier}" if isinstance(answer, Need) else answer.type


def _change(node: str, before: Conclusion | Need | None, after: Conclusion | Need | None) -> Change:
    return Change(
        node,
        _type(before),
        _type(after),
        before.rule if isinstance(before, Conclusion) else "",
        after.rule if isinstance(after, Conclusion) else "",
        after.because if isinstance(after, Conclusion) else "",
    )
