"""Why the answer is what it is: in a conclusion's few lines, and in full.

Explanation.to_text() and .to_json() show every rule with the numbers that made it hold or fail, the rejected
alternatives, how near the nearest threshold is, and how conflicts were resolved.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from kernel.facts import SPECS, TIERS, Facts, Value
from kernel.plan import Conclusion, Need, Rejected
from rules.definition import BANDS, CONCLUSIONS, PREFERENCE, Rule
from rules.logic import MAY_BE_TRUE, TRUE
from rules.resolve import EQUAL_CERTAINTY, Candidate, Verdict
from rules.syntax import Expression
from rules.template import format_value
from rules.trace import Reading, Tracer, state_of
from rules.view import Unknown, View

if TYPE_CHECKING:
    from rules.engine import RuleBase

REVIEW_WITHIN = 0.05
"""A decision nearer than this share to a threshold is marked for review."""


@dataclass(frozen=True, slots=True)
class RuleReport:
    """One rule as it was found. concludes: a segment type or a word. state: holds, fails, missing or not measured."""

    id: str
    band: str
    concludes: str
    is_word: bool
    certainty: float
    state: str
    because: str
    readings: tuple[Reading, ...]
    place: str


@dataclass(frozen=True, slots=True, eq=False)
class Explanation:
    """A decision with everything that led to it.

    rules: all rules, those that hold first. nearest: what would change the decision first, or None.
    review: the decision is within REVIEW_WITHIN of a threshold.
    """

    rule_base: str
    version: str
    facts: Mapping[str, Value]
    tier: str
    answer: Conclusion | Need
    rules: tuple[RuleReport, ...]
    nearest: str | None

    @property
    def margin(self) -> float | None:
        """Distance to the nearest threshold that would change the decision, as a share of it."""
        return self.answer.margin if isinstance(self.answer, Conclusion) else None

    @property
    def review(self) -> bool:
        """Whether a person should look at it."""
        return needs_review(self.answer)

    def to_json(self) -> dict[str, Any]:
        """Plain values for JSON."""
        if isinstance(self.answer, Need):
            answer: dict[str, Any] = {"need": self.answer.tier}
        else:
            answer = {
                "type": self.answer.type,
                "rule": self.answer.rule,
                "certainty": self.answer.certainty,
                "because": self.answer.because,
                "rejected": [
                    {"type": item.type, "rule": item.rule, "because": item.because} for item in self.answer.rejected
                ],
                "conflicts": list(self.answer.conflicts),
            }
        return {
            "rule_base": {"name": self.rule_base, "version": self.version},
            "tier": self.tier,
            "facts": {name: self.facts[name] for name in SPECS if name in self.facts},
            "answer": answer,
            "margin": self.margin,
            "nearest": self.nearest,
            "review": self.review,
            "rules": [
                {
                    "id": report.id,
                    "priority": report.band,
                    "word" if report.is_word else "segment": report.concludes,
                    "certainty": report.certainty,
                    "state": report.state,
                    "because": report.because,
                    "place": report.place,
                    "conditions": [
                        {"condition": r.condition, "found": r.text, "state": r.state, "strength": r.strength}
                        for r in report.readings
                    ],
                }
                for report in self.rules
            ],
        }

    def to_text(self) -> str:
        """For a terminal."""
        lines = []
        if isinstance(self.answer, Need):
            lines.append(f"undecided: needs the facts of {self.answer.tier}")
        else:
            answer = self.answer
            lines.append(
                f"{answer.type}, certainty {answer.certainty:.2g}, by the rule {answer.rule}: {answer.because}"
            )
            if self.margin is not None:
                mark = "  REVIEW: within 5 % of it" if self.review else ""
                lines.append(f"nearest threshold: {self.margin:.1%} away, {self.nearest}{mark}")
            lines.extend(f"conflict: {conflict}" for conflict in answer.conflicts)
            if answer.rejected:
                lines.append("rejected:")
                lines.extend(f"  {item.type} ({item.rule}): {item.because}" for item in answer.rejected)
        lines.append(f"facts, measured up to {self.tier}:")
        lines.extend(f"  {name} = {format_value(self.facts[name], '.6g')}" for name in SPECS if name in self.facts)
        lines.append(f"rules of {self.rule_base} {self.version}:")
        for report in self.rules:
            what = f"word {report.concludes}" if report.is_word else f"{report.concludes} {report.certainty:.2g}"
            lines.append(f"  {report.state}: {report.id} ({report.band}, {what})")
            for reading in report.readings:
                by = "" if reading.strength is None else f", by {abs(reading.strength):.1%}"
                lines.append(f"    {reading.state}{by}: {reading.text}")
        return "\n".join(lines)


def needs_review(answer: Conclusion | Need) -> bool:
    """Whether a conclusion is within REVIEW_WITHIN of a threshold, or had a conflict."""
    if isinstance(answer, Need):
        return False
    return bool(answer.conflicts) or (answer.margin is not None and answer.margin < REVIEW_WITHIN)


def conclude(base: RuleBase, verdict: Verdict, view: View, outcomes: Mapping[int, int]) -> Conclusion:
    """The verdict as a conclusion, with its reason, margin and the best rejected rule of each other type."""
    winner = verdict.winner
    rule = winner.rules[0]
    strengths = _strengths(base, verdict, view, outcomes)
    return Conclusion(
        winner.type,
        rule.id,
        winner.certainty,
        because_of(base, rule, view),
        _rejected(base, verdict, view, strengths),
        _margin(base, verdict, strengths)[0],
        verdict.conflicts,
    )


def _strengths(base: RuleBase, verdict: Verdict, view: View, outcomes: Mapping[int, int]) -> dict[int, float | None]:
    """Strength by rule index, of the rules that made the winner and of those for other types that fail."""
    type_, made = verdict.winner.type, {rule.id for rule in verdict.winner.rules}
    return {
        index: base.strengths[index](view)
        for index, rule in enumerate(base.rules)
        if (
            rule.id in made if rule.segment == type_ else rule.segment is not None and not outcomes[index] & MAY_BE_TRUE
        )
    }


def because_of(base: RuleBase, rule: Rule, view: View) -> str:
    """The rule's reason with its numbers."""

    def value_of(expression: Expression) -> object:
        value = base.compiler.value(expression, view)
        return None if isinstance(value, Unknown) else value

    return rule.because.fill(value_of)


def _rejected(
    base: RuleBase, verdict: Verdict, view: View, strengths: Mapping[int, float | None]
) -> tuple[Rejected, ...]:
    """For each type that was decided against, the rule that came nearest, and what spoke against it."""
    rejected = {}
    for candidate in verdict.candidates[1:]:
        if candidate.type != verdict.winner.type and candidate.type not in rejected:
            against = _outranked(candidate, verdict.winner)
            rejected[candidate.type] = Rejected(candidate.type, candidate.rules[0].id, against)
    nearest: dict[str, tuple[tuple, Rule]] = {}
    for index, strength in strengths.items():
        rule = base.rules[index]
        if rule.segment is None or rule.segment == verdict.winner.type or rule.segment in rejected:
            continue
        key = (strength if strength is not None else -math.inf, BANDS.index(rule.band), rule.certainty)
        if rule.segment not in nearest or key > nearest[rule.segment][0]:
            nearest[rule.segment] = (key, rule)
    tracer = Tracer(base.compiler, view)
    for type_, (_, rule) in nearest.items():
        against = "; ".join(dict.fromkeys(r.text for r in tracer.failing(rule.condition)))
        rejected[type_] = Rejected(type_, rule.id, against)
    return tuple(rejected[type_] for type_ in CONCLUSIONS if type_ in rejected)


def _outranked(candidate: Candidate, winner: Candidate) -> str:
    if candidate.band != winner.band:
        return f"holds, but its priority {candidate.band} is below {winner.band}"
    if abs(candidate.certainty - winner.certainty) <= EQUAL_CERTAINTY:
        return f"holds with the same certainty {winner.certainty:.3g}, but {winner.type} is preferred"
    return f"holds, but its certainty {candidate.certainty:.3g} is below {winner.certainty:.3g}"


def _margin(
    base: RuleBase, verdict: Verdict, strengths: Mapping[int, float | None]
) -> tuple[float | None, Rule | None]:
    """How far the facts may move before the decision changes, and the rule whose threshold that is.

    Either nothing of the winner holds any more, or a rule that would beat it begins to hold.
    """
    winner = verdict.winner
    holding, beginning = -math.inf, math.inf
    made_by: Rule | None = None
    beaten_by: Rule | None = None
    for index, strength in strengths.items():
        rule = base.rules[index]
        if strength is None:
            continue
        if rule.segment == winner.type:
            if strength > holding:
                holding, made_by = strength, rule
        elif -strength < beginning and _beats(rule, winner):
            beginning, beaten_by = -strength, rule
    nearest, deciding = (holding, made_by) if holding <= beginning else (beginning, beaten_by)
    return (max(nearest, 0.0), deciding) if math.isfinite(nearest) else (None, None)


def _beats(rule: Rule, winner: Candidate) -> bool:
    band, other = BANDS.index(rule.band), BANDS.index(winner.band)
    if band != other:
        return band > other
    if abs(rule.certainty - winner.certainty) <= EQUAL_CERTAINTY:
        return PREFERENCE.index(rule.concludes) < PREFERENCE.index(winner.type)
    return rule.certainty > winner.certainty


def explain(base: RuleBase, facts: Facts) -> Explanation:
    """The full explanation of what the rules say about `facts`."""
    verdict, view, outcomes = base.judge(facts)
    answer: Conclusion | Need
    nearest = None
    if isinstance(verdict, int):
        answer = Need(TIERS[verdict])
    else:
        answer = conclude(base, verdict, view, outcomes)
        margin, rule = _margin(base, verdict, _strengths(base, verdict, view, outcomes))
        if rule is not None and margin is not None:
            nearest = _nearest_text(base, rule, view, margin)
    reports = [_report(base, index, rule, view) for index, rule in enumerate(base.rules)]
    order = {"holds": 0, "fails": 1, "missing": 2, "not measured": 3}
    reports.sort(key=lambda r: (order[r.state], r.is_word, -BANDS.index(r.band), -r.certainty, r.id))
    return Explanation(base.name, base.version, dict(facts), facts.tier, answer, tuple(reports), nearest)


def _nearest_text(base: RuleBase, rule: Rule, view: View, margin: float) -> str:
    """The comparison whose distance the margin is, and its rule; the rule alone where a word stands between."""
    for reading in Tracer(base.compiler, view).readings(rule.condition):
        if reading.strength is not None and abs(abs(reading.strength) - margin) <= 1e-12:
            return f"{reading.text} (rule {rule.id})"
    return f"rule {rule.id}"


def _report(base: RuleBase, index: int, rule: Rule, view: View) -> RuleReport:
    outcome = base.matches[index](view)
    return RuleReport(
        rule.id,
        rule.band,
        rule.concludes,
        rule.segment is None,
        rule.certainty,
        state_of(outcome),
        because_of(base, rule, view) if outcome == TRUE else "",
        tuple(Tracer(base.compiler, view).readings(rule.condition)),
        str(rule.place),
    )
