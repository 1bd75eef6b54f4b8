"""Reading a condition against the facts, so that a person can follow it: each comparison with its numbers.

for reading in Tracer(compiler, view).readings(condition):  print(reading.text)      span_ratio 9.98, needs >= 10
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from kernel.facts import TIERS
from rules.compile import Compiler
from rules.logic import FALSE, MISSING, TRUE, tier_of
from rules.strength import distance
from rules.syntax import (
    All,
    Any,
    Compare,
    Condition,
    Expression,
    Known,
    Member,
    Not,
    Number,
    Proven,
    Quantified,
    Truth,
    WordRef,
    is_limit,
    text_of,
)
from rules.template import format_value
from rules.view import NOTHING, Unknown, View

NEGATED = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}

STATES = {TRUE: "holds", FALSE: "fails", MISSING: "missing"}


def state_of(outcome: int) -> str:
    """`holds`, `fails`, `missing` (a fact does not exist), or `not measured`."""
    return STATES.get(outcome, "not measured")


@dataclass(frozen=True, slots=True)
class Reading:
    """One comparison as it was found.

    condition: as written, in canonical form. text: with the numbers. state: as state_of, with its `not`.
    strength: by which share of the limit it holds (> 0) or fails (< 0), None where that means nothing.
    """

    condition: str
    text: str
    state: str
    strength: float | None = None


class Tracer:
    """Reads the conditions of one rule base against one node."""

    def __init__(self, compiler: Compiler, view: View, *, into_words: bool = True) -> None:
        """into_words: say of a word that fails what keeps its own rules from holding."""
        self._compiler = compiler
        self._view = view
        self._into_words = into_words

    def readings(self, condition: Condition, negated: bool = False) -> Iterator[Reading]:
        """The readings of all comparisons in the condition, in its order; `not` is taken into the comparison."""
        match condition:
            case All(conditions=parts) | Any(conditions=parts):
                for part in parts:
                    yield from self.readings(part, negated)
            case Not(condition=inner):
                yield from self.readings(inner, not negated)
            case Proven(condition=inner):
                yield from self.readings(inner, negated)
            case Compare():
                yield self._compare(condition, negated)
            case _:
                yield self._crisp(condition, negated)

    def failing(self, condition: Condition, negated: bool = False) -> Iterator[Reading]:
        """The readings that keep the condition from holding: false ones, or missing ones where none is false."""
        match condition:
            case All(conditions=parts) if not negated:
                yield from self._failing_of_all(parts, negated)
            case Any(conditions=parts) if negated:
                yield from self._failing_of_all(parts, negated)
            case All(conditions=parts) | Any(conditions=parts):
                for part in parts:
                    yield from self.failing(part, negated)
            case Not(condition=inner):
                yield from self.failing(inner, not negated)
            case Proven(condition=inner):
                yield from self.failing(inner, negated)
            case _:
                yield from (reading for reading in self.readings(condition, negated) if reading.state != "holds")

    def _failing_of_all(self, parts: tuple[Condition, ...], negated: bool) -> Iterator[Reading]:
        wanted = TRUE if negated else FALSE
        outcomes = [self._compiler.outcome(part, self._view) for part in parts]
        guilty = [part for part, outcome in zip(parts, outcomes, strict=True) if outcome == wanted]
        if not guilty:
            guilty = [part for part, outcome in zip(parts, outcomes, strict=True) if outcome not in (TRUE, FALSE)]
        for part in guilty:
            yield from self.failing(part, negated)

    def _outcome(self, condition: Condition, negated: bool) -> str:
        outcome = self._compiler.outcome(condition, self._view)
        if negated:
            outcome = {TRUE: FALSE, FALSE: TRUE}.get(outcome, outcome)
        return state_of(outcome)

    def _compare(self, condition: Compare, negated: bool) -> Reading:
        operator = NEGATED[condition.operator] if negated else condition.operator
        left = self._compiler.value(condition.left, self._view)
        right = self._compiler.value(condition.right, self._view)
        shown = Compare(operator, condition.left, condition.right, condition.measured)
        state = self._outcome(condition, negated)
        text = f"{_with_value(condition.left, left)}, needs {operator} {_limit(condition.right, right)}"
        strength = None
        if condition.measured and not isinstance(left, Unknown | str) and not isinstance(right, Unknown | str):
            if operator not in ("==", "!="):
                sign = 1.0 if operator in (">", ">=") else -1.0
                share = sign * distance(left, right, is_limit(condition.left), is_limit(condition.right))
                strength = share if math.isfinite(share) else None
        return Reading(text_of(shown), text, state, strength)

    def _crisp(self, condition: Condition, negated: bool) -> Reading:
        """A reading of a condition that no number decides."""
        outcome = self._compiler.outcome(condition, self._view)
        if negated:
            outcome = {TRUE: FALSE, FALSE: TRUE}.get(outcome, outcome)
        sign = "not " if negated else ""
        written = text_of(Not(condition)) if negated else text_of(condition)
        match condition:
            case Member(expression=expression, choices=choices):
                found = _value_text(self._compiler.value(expression, self._view))
                text = f"{text_of(expression)} {found}, needs {sign}{' or '.join(choices)}"
            case Truth(expression=expression):
                found = _value_text(self._compiler.value(expression, self._view))
                text = f"{text_of(expression)} {found}, needs {'no' if negated else 'yes'}"
            case WordRef(name=name):
                text = f"{name} {_word_text(self._view.words.get(name, MISSING))}, needs {'no' if negated else 'yes'}"
                if self._into_words and state_of(outcome) == "fails" and not negated:
                    text += f" ({self._why_not(name)})"
            case Known(expression=expression):
                found = _value_text(self._compiler.value(expression, self._view))
                text = f"{text_of(expression)} {found}, needs {'no' if negated else 'some'} value"
            case Quantified(collection=collection, least=least, condition=inner):
                things = self._view.things(collection)
                if isinstance(things, Unknown):
                    text = f"{collection} {_value_text(things)}, needs {sign}at least {least}: {text_of(inner)}"
                else:
                    count = sum(self._compiler.outcome(inner, thing) == TRUE for thing in things)
                    text = f"{count} of {len(things)} {collection}, needs {sign}at least {least}: {text_of(inner)}"
            case _:
                text = written
        return Reading(written, text, state_of(outcome))

    def _why_not(self, word: str) -> str:
        """What keeps each of the rules that would conclude the word from holding."""
        plain = Tracer(self._compiler, self._view, into_words=False)
        reasons = [
            " and ".join(dict.fromkeys(reading.text for reading in plain.failing(maker)))
            for maker in self._compiler.words[word]
        ]
        return "; ".join(reasons)


def _word_text(outcome: int) -> str:
    return {TRUE: "yes", FALSE: "no", MISSING: "unknown"}.get(outcome, f"not measured ({_tier(outcome)})")


def _tier(outcome: int) -> str:
    tier = tier_of(outcome)
    return TIERS[tier] if tier < len(TIERS) else "never"


def _value_text(value: object) -> str:
    if isinstance(value, Unknown):
        return "does not exist" if value is NOTHING else f"not measured ({TIERS[value.tier]})"
    return format_value(value)


def _with_value(expression: Expression, value: object) -> str:
    text = text_of(expression)
    return text if isinstance(expression, Number) else f"{text} {_value_text(value)}"


def _limit(expression: Expression, value: object) -> str:
    if isinstance(expression, Number):
        return text_of(expression)
    return f"{_value_text(value)} ({text_of(expression)})"
