"""By how much a condition holds or fails: its strength, as a share of the threshold that decides.

Positive where it holds, negative where it fails, infinite where no measured number decides, None where a fact does not
exist. `all` is the weakest part, `any` the strongest: the robustness of signal temporal logic (A. Donze, O. Maler,
Robust satisfaction of temporal logic over real-valued signals, FORMATS 2010).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from rules.compile import compile_condition, compile_expression
from rules.logic import FALSE, TRUE
from rules.syntax import All, Any, Compare, Condition, FactRef, Not, Proven, Quantified, WordRef, is_limit
from rules.view import NOTHING, Strength, Unknown, View


def compile_strength(
    condition: Condition, parameters: Mapping[str, float], words: Mapping[str, Sequence[Strength]]
) -> Strength:
    """A function of the view that gives the condition's strength.

    words: the strengths of the rules that conclude each word.
    """
    match condition:
        case Compare(measured=True, operator=operator) if operator not in ("==", "!="):
            return _compare_strength(condition, parameters)
        case Not(condition=inner):
            negated = compile_strength(inner, parameters, words)
            return lambda view: None if (value := negated(view)) is None else -value
        case All(conditions=conditions):
            return _extreme_strength([compile_strength(part, parameters, words) for part in conditions], 1.0)
        case Any(conditions=conditions):
            return _extreme_strength([compile_strength(part, parameters, words) for part in conditions], -1.0)
        case Proven(condition=inner):
            proven = compile_strength(inner, parameters, words)
            return lambda view: -math.inf if (value := proven(view)) is None else value
        case Quantified(collection=collection, least=least, condition=inner):
            return _quantified_strength(collection, least, compile_strength(inner, parameters, words))
        case WordRef(name=name):
            return _word_strength(name, _extreme_strength(list(words[name]), -1.0))
    crisp = compile_condition(condition, parameters)
    return lambda view: _CRISP_STRENGTH.get(crisp(view))


def _word_strength(name: str, of_makers: Strength) -> Strength:
    """Once for each node, however many rules use the word."""

    def strength(view: View) -> float | None:
        if name not in view.strengths:
            view.strengths[name] = of_makers(view)
        return view.strengths[name]

    return strength


_CRISP_STRENGTH = {TRUE: math.inf, FALSE: -math.inf}


def distance(a: float, b: float, left_is_limit: bool, right_is_limit: bool) -> float:
    """(a - b) as a share of the limit of the two, of the larger where neither or both are limits, or where it is 0."""
    limit = abs(b) if right_is_limit and not left_is_limit else abs(a) if left_is_limit and not right_is_limit else 0.0
    scale = limit or max(abs(a), abs(b))
    return (a - b) / scale if scale else 0.0


def _compare_strength(condition: Compare, parameters: Mapping[str, float]) -> Strength:
    left = compile_expression(condition.left, parameters)
    right = compile_expression(condition.right, parameters)
    sign = 1.0 if condition.operator in (">", ">=") else -1.0
    limits = is_limit(condition.left), is_limit(condition.right)
    limit = right(View.NOWHERE) if limits[1] else NOTHING
    if (
        isinstance(condition.left, FactRef)
        and not condition.left.outer
        and not isinstance(limit, Unknown | str)
        and limit
    ):
        name, scale = condition.left.name, sign / abs(limit)

        def fact_strength(view: View) -> float | None:
            value = view.values.get(name)
            return None if value is None else (value - limit) * scale  # type: ignore[operator]

        return fact_strength

    def strength(view: View) -> float | None:
        a, b = left(view), right(view)
        if a.__class__ is Unknown or b.__class__ is Unknown:
            return None
        return sign * distance(a, b, *limits)  # type: ignore[arg-type]

    return strength


def _extreme_strength(parts: list[Strength], sign: float) -> Strength:
    """Smallest of all (sign 1) or largest of any (-1); None where a missing part leaves it open."""

    def strength(view: View) -> float | None:
        least, missing = math.inf, False
        for part in parts:
            value = part(view)
            if value is None:
                missing = True
            elif sign * value < least:
                least = sign * value
        return None if missing and least > 0.0 else sign * least

    return strength


def _quantified_strength(collection: str, least: int, inner: Strength) -> Strength:
    def strength(view: View) -> float | None:
        things = view.things(collection)
        if isinstance(things, Unknown):
            return None
        values = sorted((value for thing in things if (value := inner(thing)) is not None), reverse=True)
        return values[least - 1] if len(values) >= least else -math.inf

    return strength
