"""What the authors of rules ask for, over whole models: cases in CSG, and the difference that a rule base makes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from kernel.plan import Decide, Plan
    from rules.analysis import DiffReport
    from rules.engine import RuleBase


def plan_of(text: str, decide: Decide, name: str = "model") -> Plan:
    """Read a model's text and let `decide` break it into segments; gives every question and answer."""
    from kernel.csg.reader import read_model
    from kernel.segment.partition import partition
    from kernel.solid.evaluate import evaluate

    return partition(evaluate(read_model(text, name)), decide, {}).plan


def compare(before: RuleBase, after: RuleBase, models: Mapping[str, str]) -> DiffReport:
    """Which nodes of the models (name -> text) the two bases decide differently; without models, of their cases."""
    from rules.analysis import diff, diff_plans
    from rules.analysis.cases import facts_of

    if models:
        plans = {
            name: (plan_of(text, before.decide, name), plan_of(text, after.decide, name))
            for name, text in models.items()
        }
        return diff_plans(before, after, plans)
    cases = [case for base in (before, after) for case in base.definition.cases if case.facts is not None]
    return diff(before, after, {f"{case.rule} {case.name}": facts_of(case) for case in cases})
