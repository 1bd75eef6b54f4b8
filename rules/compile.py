"""From syntax trees to Python closures: what the engine's rules call to match, a hundred of them in well under 1 ms.

Two functions come of each condition: its outcome (logic.py), and its strength: by which share of a threshold it holds
(positive) or fails (negative), infinite where no measured number decides, None where a fact does not exist.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import ClassVar, TypeAlias

from kernel.facts import RELATED, TIERS, Facts, Value
from rules.logic import AND, FALSE, MISSING, NOT, OR, PROVEN, SETTLED, TRUE, at_least, pending
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
    walk,
)

EQUAL_WITHIN = 2e-6
"""Measured numbers within this share of the right side equal it: facts carry six digits. Counts must be exact."""


class Unknown:
    """Stands for the value of an absent fact: to be told by `tier`, or never where it is SETTLED."""

    __slots__ = ("outcome", "tier")

    def __init__(self, tier: int) -> None:
        """outcome: what a condition on the value comes to."""
        self.tier = tier
        self.outcome = MISSING if tier == SETTLED else pending(tier)


NOTHING = Unknown(SETTLED)
UNKNOWN = tuple(Unknown(tier) for tier in range(len(TIERS)))
ABSENT = tuple(
    tuple(NOTHING if tier <= measured else UNKNOWN[tier] for tier in range(len(TIERS)))
    for measured in range(len(TIERS))
)
"""ABSENT[tier measured][tier of the fact]: what an absent fact is worth."""

ALL_MEASURED = ABSENT[-1]

Evaluated: TypeAlias = "Value | Unknown"


class View:
    """Facts as the closures read them, and the words decided so far."""

    __slots__ = ("absent", "items", "outer", "related", "strengths", "values", "words")

    NOWHERE: ClassVar[View]
    """A view of no facts, for expressions that need none."""

    def __init__(self, facts: Facts) -> None:
        self.values: Mapping[str, Value] = dict(facts)
        self.absent = ABSENT[TIERS.index(facts.tier)]
        self.related = facts.related
        self.items: dict[str, tuple[View, ...]] = {}
        self.words: dict[str, int] = {}
        self.strengths: dict[str, float | None] = {}
        self.outer: View | None = None

    def things(self, collection: str) -> tuple[View, ...] | Unknown:
        """Views of the related things; what is absent of them does not exist."""
        found = self.items.get(collection)
        if found is not None:
            return found
        if collection not in self.related:
            return self.absent[TIERS.index(RELATED[collection].tier)]
        views = tuple(View(facts) for facts in self.related[collection])
        for view in views:
            view.outer, view.absent = self, ALL_MEASURED
        self.items[collection] = views
        return views


View.NOWHERE = View(Facts({}, TIERS[-1]))

Evaluate = Callable[[View], Evaluated]
Match = Callable[[View], int]
Strength = Callable[[View], float | None]


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


def compile_strength(
    condition: Condition, parameters: Mapping[str, float], words: Mapping[str, Sequence[Strength]]
) -> Strength:
    """A function of the view that gives the condition's strength (robustness as in signal temporal logic:

    A. Donze, O. Maler, Robust satisfaction of temporal logic over real-valued signals, FORMATS 2010).
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


def is_limit(expression: Expression) -> bool:
    """Whether an expression depends on no fact."""
    return not any(isinstance(part, FactRef) for part in walk(expression))


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
