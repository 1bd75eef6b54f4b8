"""From syntax trees to Python closures: what the engine's rules call to match, a hundred of them in well under 1 ms.

A condition becomes a function of a View that gives its outcome (logic.py); an expression one that gives its value.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from rules.logic import AND, FALSE, NOT, OR, PROVEN, SETTLED, TRUE, at_least, pending
from rules.syntax import (
    All,
    Any,
    Arithmetic,
    Call,
    Compare,
    Condition,
    Expression,
    FactRef,
    Known,
    Member,
    Not,
    Number,
    ParameterRef,
    Proven,
    Quantified,
    QuantityRef,
    Text,
    Truth,
    WordRef,
    is_limit,
)
from rules.view import NOTHING, UNKNOWN, Evaluate, Evaluated, Match, Unknown, View

EQUAL_WITHIN = 2e-6
"""Measured numbers within this share of the right side equal it: facts carry six digits. Counts must be exact."""


def unknown_of(a: Evaluated, b: Evaluated) -> Unknown:
    """What an operation is worth when at least one operand is unknown: nothing at all if one will never be known."""
    tiers = [value.tier for value in (a, b) if isinstance(value, Unknown)]
    if SETTLED in tiers:
        return NOTHING
    return UNKNOWN[min(tiers)]


def calculate(operator: str, a: float, b: float) -> Evaluated:
    """One operation; NOTHING where it has no finite result."""
    try:
        if operator == "+":
            result = a + b
        elif operator == "-":
            result = a - b
        elif operator == "*":
            result = a * b
        elif operator == "/":
            result = a / b
        else:
            result = float(a) ** b
    except (ArithmeticError, ValueError):
        return NOTHING
    return result if isinstance(result, int | float) and math.isfinite(result) else NOTHING


def call(function: str, arguments: list[float]) -> Evaluated:
    """One function of known values, all but `first`."""
    if function == "min":
        return min(arguments)
    if function == "max":
        return max(arguments)
    if function == "abs":
        return abs(arguments[0])
    if function == "sqrt":
        return math.sqrt(arguments[0]) if arguments[0] >= 0 else NOTHING
    return math.cbrt(arguments[0])


def holds(operator: str, a: float, b: float, measured: bool) -> bool:
    """Whether a comparison holds; measured numbers have a tolerance, so that a limit met exactly is met."""
    slack = EQUAL_WITHIN * abs(b) if measured else 0.0
    if operator == ">=":
        return a >= b - slack
    if operator == "<=":
        return a <= b + slack
    if operator == ">":
        return a > b + slack
    if operator == "<":
        return a < b - slack
    return (abs(a - b) <= slack) == (operator == "==")


class Compiler:
    """Compiles each expression and condition of a rule base once; told apart by identity, as the base keeps them."""

    def __init__(self, parameters: Mapping[str, float], words: Mapping[str, tuple[Condition, ...]]) -> None:
        """words: the conditions of the rules that conclude each word."""
        self.words = words
        self._parameters = parameters
        self._expressions: dict[int, tuple[Expression, Evaluate]] = {}
        self._conditions: dict[int, tuple[Condition, Match]] = {}

    def value(self, expression: Expression, view: View) -> Evaluated:
        """The expression's value."""
        entry = self._expressions.get(id(expression))
        if entry is None:
            entry = self._expressions[id(expression)] = (expression, compile_expression(expression, self._parameters))
        return entry[1](view)

    def outcome(self, condition: Condition, view: View) -> int:
        """The condition's outcome."""
        entry = self._conditions.get(id(condition))
        if entry is None:
            entry = self._conditions[id(condition)] = (condition, compile_condition(condition, self._parameters))
        return entry[1](view)


def compile_expression(expression: Expression, parameters: Mapping[str, float]) -> Evaluate:
    """A function of the view that gives the expression's value, or an Unknown."""
    match expression:
        case Number(value=constant):
            return lambda view: constant
        case ParameterRef(name=name):
            number = parameters[name]
            return lambda view: number
        case Text(value=text):
            return lambda view: text
        case FactRef(name=name, outer=True, tier=tier):
            return lambda view: _fact(view.outer or view, name, tier)
        case FactRef(name=name, tier=tier):
            return lambda view: _fact(view, name, tier)
        case QuantityRef(expression=inner):
            return compile_expression(inner, parameters)
        case Arithmetic(operator=operator, left=left, right=right):
            return _compile_arithmetic(operator, left, right, parameters)
        case Call(function=function, arguments=arguments):
            return _compile_call(function, [compile_expression(argument, parameters) for argument in arguments])
    raise TypeError(f"no way to compile {type(expression).__name__}")


def _fact(view: View, name: str, tier: int) -> Evaluated:
    value = view.values.get(name)
    return value if value is not None else view.absent[tier]


def _compile_arithmetic(
    operator: str, left: Expression, right: Expression, parameters: Mapping[str, float]
) -> Evaluate:
    first, second = compile_expression(left, parameters), compile_expression(right, parameters)

    def arithmetic(view: View) -> Evaluated:
        a, b = first(view), second(view)
        if a.__class__ is Unknown or b.__class__ is Unknown:
            return unknown_of(a, b)
        return calculate(operator, a, b)  # type: ignore[arg-type]

    return arithmetic


def _compile_call(function: str, arguments: list[Evaluate]) -> Evaluate:
    def first(view: View) -> Evaluated:
        for argument in arguments:
            value = argument(view)
            if value is not NOTHING:
                return value
        return NOTHING

    def every(view: View) -> Evaluated:
        values = [argument(view) for argument in arguments]
        unknown = [value for value in values if isinstance(value, Unknown)]
        if unknown:
            return unknown_of(unknown[0], min(unknown, key=lambda value: -1 if value is NOTHING else value.tier))
        return call(function, values)  # type: ignore[arg-type]

    return first if function == "first" else every


def compile_condition(condition: Condition, parameters: Mapping[str, float]) -> Match:
    """A function of the view that gives the condition's outcome."""
    match condition:
        case Compare():
            return _compile_compare(condition, parameters)
        case Member(expression=expression, choices=choices):
            return _compile_member(compile_expression(expression, parameters), frozenset(choices))
        case Truth(expression=expression):
            return _compile_truth(compile_expression(expression, parameters))
        case WordRef(name=name):
            return lambda view: view.words[name]
        case Known(expression=expression):
            return _compile_known(compile_expression(expression, parameters))
        case Proven(condition=inner):
            proven = compile_condition(inner, parameters)
            return lambda view: PROVEN[proven(view)]
        case Not(condition=inner):
            negated = compile_condition(inner, parameters)
            return lambda view: NOT[negated(view)]
        case All(conditions=conditions):
            return _compile_all([compile_condition(part, parameters) for part in conditions])
        case Any(conditions=conditions):
            return _compile_any([compile_condition(part, parameters) for part in conditions])
        case Quantified(collection=collection, least=least, condition=inner):
            return _compile_quantified(collection, least, compile_condition(inner, parameters))
    raise TypeError(f"no way to compile {type(condition).__name__}")


def _compile_compare(condition: Compare, parameters: Mapping[str, float]) -> Match:
    left = compile_expression(condition.left, parameters)
    right = compile_expression(condition.right, parameters)
    operator, measured = condition.operator, condition.measured
    if isinstance(condition.left, FactRef) and not condition.left.outer and is_limit(condition.right):
        limit = right(View.NOWHERE)
        if not isinstance(limit, Unknown | str):
            return _compile_fact_and_limit(
                condition.left, operator, limit, EQUAL_WITHIN * abs(limit) if measured else 0.0
            )

    def compare(view: View) -> int:
        a, b = left(view), right(view)
        if a.__class__ is Unknown or b.__class__ is Unknown:
            return unknown_of(a, b).outcome
        return TRUE if holds(operator, a, b, measured) else FALSE  # type: ignore[arg-type]

    return compare


def _compile_fact_and_limit(fact: FactRef, operator: str, limit: float, slack: float) -> Match:
    """The commonest comparison: one fact inside, or outside, an interval that is known beforehand."""
    name, tier = fact.name, fact.tier
    low, high = -math.inf, math.inf
    if operator in (">=", "<", "==", "!="):
        low = limit - slack
    if operator in ("<=", ">", "==", "!="):
        high = limit + slack
    inside, outside = (FALSE, TRUE) if operator in ("<", ">", "!=") else (TRUE, FALSE)

    def compare(view: View) -> int:
        value = view.values.get(name)
        if value is None:
            return view.absent[tier].outcome
        return inside if low <= value <= high else outside  # type: ignore[operator]

    return compare


def _compile_member(value_of: Evaluate, choices: frozenset[str]) -> Match:
    def member(view: View) -> int:
        value = value_of(view)
        if isinstance(value, Unknown):
            return value.outcome
        return TRUE if value in choices else FALSE

    return member


def _compile_truth(value_of: Evaluate) -> Match:
    def truth(view: View) -> int:
        value = value_of(view)
        if isinstance(value, Unknown):
            return value.outcome
        return TRUE if value else FALSE

    return truth


def _compile_known(value_of: Evaluate) -> Match:
    def known(view: View) -> int:
        value = value_of(view)
        if not isinstance(value, Unknown):
            return TRUE
        return FALSE if value is NOTHING else PROVEN[pending(value.tier)]

    return known


def _compile_all(parts: list[Match]) -> Match:
    def every(view: View) -> int:
        result = TRUE
        for part in parts:
            result = AND[result << 6 | part(view)]
            if result == FALSE:
                return FALSE
        return result

    return every


def _compile_any(parts: list[Match]) -> Match:
    def some(view: View) -> int:
        result = FALSE
        for part in parts:
            result = OR[result << 6 | part(view)]
            if result == TRUE:
                return TRUE
        return result

    return some


def _compile_quantified(collection: str, least: int, inner: Match) -> Match:
    def quantified(view: View) -> int:
        things = view.things(collection)
        if isinstance(things, Unknown):
            return things.outcome
        return at_least(least, [inner(thing) for thing in things])

    return quantified
