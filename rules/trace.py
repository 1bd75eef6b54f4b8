"""Reading a condition against the facts, so that a person can follow it: each comparison with its numbers.

for reading in readings(condition, view, compiler):  print(reading.text)      span_ratio 9.98, needs >= 10
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from kernel.facts import TIERS
from rules.compile import NOTHING, Compiler, Unknown, View, distance, is_limit
from rules.logic import FALSE, MISSING, TRUE, tier_of
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
    ParameterRef,
    Proven,
    Quantified,
    Truth,
    WordRef,
    text_of,
)
from rules.template import format_value

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


def readings(condition: Condition, view: View, compiler: Compiler, negated: bool = False) -> Iterator[Reading]:
    """The readings of all comparisons in the condition, in its order; `not` is taken into the comparison."""
    match condition:
        case All(conditions=parts) | Any(conditions=parts):
            for part in parts:
                yield from readings(part, view, compiler, negated)
        case Not(condition=inner):
            yield from readings(inner, view, compiler, not negated)
        case Proven(condition=inner):
            yield from readings(inner, view, compiler, negated)
        case Compare():
            yield _compare(condition, view, compiler, negated)
        case _:
            yield _crisp(condition, view, compiler, negated)


def failing(condition: Condition, view: View, compiler: Compiler, negated: bool = False) -> Iterator[Reading]:
    """The readings that keep the condition from holding: false ones, or missing ones where none is false."""
    match condition:
        case All(conditions=parts) if not negated:
            yield from _failing_of_all(parts, view, compiler, negated)
        case Any(conditions=parts) if negated:
            yield from _failing_of_all(parts, view, compiler, negated)
        case All(conditions=parts) | Any(conditions=parts):
            for part in parts:
                yield from failing(part, view, compiler, negated)
        case Not(condition=inner):
            yield from failing(inner, view, compiler, not negated)
        case Proven(condition=inner):
            yield from failing(inner, view, compiler, negated)
        case _:
            yield from (reading for reading in readings(condition, view, compiler, negated) if reading.state != "holds")


def _failing_of_all(parts: tuple[Condition, ...], view: View, compiler: Compiler, negated: bool) -> Iterator[Reading]:
    wanted = TRUE if negated else FALSE
    outcomes = [compiler.outcome(part, view) for part in parts]
    guilty = [part for part, outcome in zip(parts, outcomes, strict=True) if outcome == wanted]
    if not guilty:
        guilty = [part for part, outcome in zip(parts, outcomes, strict=True) if outcome not in (TRUE, FALSE)]
    for part in guilty:
        yield from failing(part, view, compiler, negated)


def _outcome(condition: Condition, view: View, compiler: Compiler, negated: bool) -> str:
    outcome = compiler.outcome(condition, view)
    if negated:
        outcome = {TRUE: FALSE, FALSE: TRUE}.get(outcome, outcome)
    return state_of(outcome)


def _compare(condition: Compare, view: View, compiler: Compiler, negated: bool) -> Reading:
    operator = NEGATED[condition.operator] if negated else condition.operator
    left = compiler.value(condition.left, view)
    right = compiler.value(condition.right, view)
    shown = Compare(operator, condition.left, condition.right, condition.measured)
    state = _outcome(condition, view, compiler, negated)
    text = f"{_with_value(condition.left, left)}, needs {operator} {_limit(condition.right, right)}"
    strength = None
    if condition.measured and not isinstance(left, Unknown | str) and not isinstance(right, Unknown | str):
        if operator not in ("==", "!="):
            sign = 1.0 if operator in (">", ">=") else -1.0
            share = sign * distance(left, right, is_limit(condition.left), is_limit(condition.right))
            strength = share if math.isfinite(share) else None
    return Reading(text_of(shown), text, state, strength)


def _crisp(condition: Condition, view: View, compiler: Compiler, negated: bool) -> Reading:
    """A reading of a condition that no number decides."""
    outcome = compiler.outcome(condition, view)
    if negated:
        outcome = {TRUE: FALSE, FALSE: TRUE}.get(outcome, outcome)
    sign = "not " if negated else ""
    written = text_of(Not(condition)) if negated else text_of(condition)
    match condition:
        case Member(expression=expression, choices=choices):
            found = _value_text(compiler.value(expression, view))
            text = f"{text_of(expression)} {found}, needs {sign}{' or '.join(choices)}"
        case Truth(expression=expression):
            found = _value_text(compiler.value(expression, view))
            text = f"{text_of(expression)} {found}, needs {'no' if negated else 'yes'}"
        case WordRef(name=name):
            text = f"{name} {_word_text(view.words.get(name, MISSING))}, needs {'no' if negated else 'yes'}"
        case Known(expression=expression):
            found = _value_text(compiler.value(expression, view))
            text = f"{text_of(expression)} {found}, needs {'no' if negated else 'some'} value"
        case Quantified(collection=collection, least=least, condition=inner):
            things = view.things(collection)
            if isinstance(things, Unknown):
                text = f"{collection} {_value_text(things)}, needs {sign}at least {least}: {text_of(inner)}"
            else:
                count = sum(compiler.outcome(inner, thing) == TRUE for thing in things)
                text = f"{count} of {len(things)} {collection}, needs {sign}at least {least}: {text_of(inner)}"
        case _:
            text = written
    return Reading(written, text, state_of(outcome))


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
    if isinstance(expression, ParameterRef):
        return f"{_value_text(value)} ({text_of(expression)})"
    return f"{_value_text(value)} ({text_of(expression)})"
