"""The plain evaluator: what a rule base means, said as simply as possible, without experta, tables or compiled code.

The oracle of the tests: it and the engine must give the same answer for every node. Slow, and meant to be read.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from kernel.facts import RELATED, SPECS, TIERS, Facts
from rules.definition import BANDS, PREFERENCE, Definition, Rule
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
)

NEVER = len(TIERS)
"""The tier of a fact that does not exist: no measuring will tell it."""

EQUAL_WITHIN = 2e-6
"""As compile.py's; said again, since an oracle does not borrow."""


@dataclass(frozen=True)
class Later:
    """A value that `tier` would tell; NEVER where nothing would."""

    tier: int


@dataclass(frozen=True)
class Possible:
    """What a condition may still become (True, False, None for missing), and the first tier that would tell."""

    values: frozenset[bool | None]
    tier: int

    @staticmethod
    def of(*values: bool | None, tier: int = NEVER) -> Possible:
        """What may become any of `values`."""
        return Possible(frozenset(values), tier if len(set(values)) > 1 else NEVER)


class Plain:
    """Evaluates the conditions of one rule base for one node."""

    def __init__(self, definition: Definition, facts: Facts, metre: float = 1e-3) -> None:
        self._definition = definition
        self._facts = facts
        self._metre = metre
        self._words: dict[str, Possible] = {}

    # ---- expressions

    def value(self, expression: Expression, item: Facts | None) -> object:
        """The expression's value, or Later. item: what a quantifier looks at, None for the node."""
        match expression:
            case Number(value=number):
                return number
            case Text(value=text):
                return text
            case ParameterRef(name=name):
                return self._definition.parameters[name].in_model_units(self._metre)
            case QuantityRef(expression=inner):
                return self.value(inner, None)
            case FactRef(name=name, outer=outer):
                if item is not None and not outer:
                    return item.get(name, Later(NEVER))
                if name in self._facts:
                    return self._facts[name]
                tier = TIERS.index(SPECS[name].tier)
                return Later(tier if tier > TIERS.index(self._facts.tier) else NEVER)
            case Call(function="first", arguments=arguments):
                for argument in arguments:
                    found = self.value(argument, item)
                    if found != Later(NEVER):
                        return found
                return Later(NEVER)
            case Call(function=function, arguments=arguments):
                return self._applied(function, [self.value(argument, item) for argument in arguments])
            case Arithmetic(operator=operator, left=left, right=right):
                return self._applied(operator, [self.value(left, item), self.value(right, item)])
        raise TypeError(type(expression).__name__)

    def _applied(self, function: str, arguments: list[object]) -> object:
        tiers = [argument.tier for argument in arguments if isinstance(argument, Later)]
        if tiers:
            return Later(NEVER if NEVER in tiers else min(tiers))
        functions: dict[str, Callable[..., float]] = {
            "+": lambda a, b: a + b,
            "-": lambda a, b: a - b,
            "*": lambda a, b: a * b,
            "/": lambda a, b: a / b,
            "**": lambda a, b: float(a) ** b,
            "min": min,
            "max": max,
            "abs": abs,
            "sqrt": math.sqrt,
            "cbrt": math.cbrt,
        }
        try:
            result = functions[function](*arguments)
        except (ArithmeticError, ValueError):
            return Later(NEVER)
        return result if not isinstance(result, complex) and math.isfinite(result) else Later(NEVER)

    # ---- conditions

    def possible(self, condition: Condition, item: Facts | None = None) -> Possible:
        """What the condition may become."""
        match condition:
            case All(conditions=parts):
                return self._joined([self.possible(part, item) for part in parts], decisive=False)
            case Any(conditions=parts):
                return self._joined([self.possible(part, item) for part in parts], decisive=True)
            case Not(condition=inner):
                found = self.possible(inner, item)
                return Possible(frozenset(None if v is None else not v for v in found.values), found.tier)
            case Proven(condition=inner):
                found = self.possible(inner, item)
                return Possible.of(*(v is True for v in found.values), tier=found.tier)
            case WordRef(name=name):
                return self.word(name)
            case Known(expression=expression):
                value = self.value(expression, item)
                if not isinstance(value, Later):
                    return Possible.of(True)
                return Possible.of(False) if value.tier == NEVER else Possible.of(True, False, tier=value.tier)
            case Quantified(collection=collection, least=least, condition=inner):
                return self._quantified(collection, least, inner)
            case Compare(left=left, right=right):
                values = [self.value(left, item), self.value(right, item)]
                return self._decided(values, lambda a, b: self._compared(condition, a, b))
            case Member(expression=expression, choices=choices):
                return self._decided([self.value(expression, item)], lambda a: a in choices)
            case Truth(expression=expression):
                return self._decided([self.value(expression, item)], bool)
        raise TypeError(type(condition).__name__)

    def word(self, name: str) -> Possible:
        """What a word may become: true when one of its rules is."""
        if name not in self._words:
            makers = [self.possible(rule.condition) for rule in self._definition.rules if rule.word == name]
            self._words[name] = self._joined(makers, decisive=True)
        return self._words[name]

    def _decided(self, values: list[object], test: Callable[..., object]) -> Possible:
        tiers = [value.tier for value in values if isinstance(value, Later)]
        if NEVER in tiers:
            return Possible.of(None)
        if tiers:
            return Possible.of(True, False, None, tier=min(tiers))
        return Possible.of(bool(test(*values)))

    def _compared(self, condition: Compare, a: float, b: float) -> bool:
        near = EQUAL_WITHIN * abs(b) if condition.measured else 0.0
        equal = abs(a - b) <= near
        if condition.operator in ("==", "!="):
            return equal == (condition.operator == "==")
        if condition.operator in (">=", "<="):
            return equal or (a > b if condition.operator == ">=" else a < b)
        return not equal and (a > b if condition.operator == ">" else a < b)

    def _joined(self, parts: list[Possible], *, decisive: bool) -> Possible:
        """`or` (decisive True) or `and` (decisive False), by Kleene's tables, over all that may become."""
        total, tier = {not decisive}, NEVER
        total_set: set[bool | None] = set(total)
        for part in parts:
            combined: set[bool | None] = set()
            for a in total_set:
                for b in part.values:
                    if decisive in (a, b):
                        combined.add(decisive)
                    else:
                        combined.add(None if None in (a, b) else not decisive)
            total_set, tier = combined, min(tier, part.tier)
            if len(total_set) == 1:
                tier = NEVER
        return Possible(frozenset(total_set), tier)

    def _quantified(self, collection: str, least: int, inner: Condition) -> Possible:
        if collection not in self._facts.related:
            tier = TIERS.index(RELATED[collection].tier)
            if tier > TIERS.index(self._facts.tier):
                return Possible.of(True, False, None, tier=tier)
            return Possible.of(None)
        found = [self.possible(inner, item) for item in self._facts.related[collection]]
        tier = min((part.tier for part in found), default=NEVER)
        totals: set[tuple[int, int]] = {(0, 0)}
        for part in found:
            totals = {(yes + (v is True), open_ + (v is None)) for yes, open_ in totals for v in part.values}
        values = {True if yes >= least else None if yes + open_ >= least else False for yes, open_ in totals}
        return Possible.of(*values, tier=tier)


def answer(definition: Definition, facts: Facts, metre: float = 1e-3) -> str:
    """The conclusion's type, or `need TIER`, as a case would expect it."""
    plain = Plain(definition, facts, metre)
    holding: list[Rule] = []
    undecided: dict[tuple[str, str], list[tuple[Rule, int]]] = {}
    for rule in definition.rules:
        if rule.segment is None:
            continue
        found = plain.possible(rule.condition)
        if found.values == {True}:
            holding.append(rule)
        elif True in found.values:
            undecided.setdefault((rule.band, rule.segment), []).append((rule, found.tier))
    best = _winner(holding)
    assert best is not None
    needed: list[int] = []
    for group, members in undecided.items():
        if group[1] != best[1] and _winner([*holding, *(rule for rule, _ in members)]) == group:
            needed.extend(tier for _, tier in members)
    return f"need {TIERS[min(needed)]}" if needed else best[1]


def _winner(holding: list[Rule]) -> tuple[str, str] | None:
    """Band and type that win if exactly these rules hold."""
    strongest: tuple[tuple[int, float, int], tuple[str, str]] | None = None
    for band, type_ in {(rule.band, rule.segment or "") for rule in holding}:
        rules = [rule for rule in holding if (rule.band, rule.segment) == (band, type_)]
        groups: Mapping[str, float] = {
            group: max(rule.certainty for rule in rules if rule.evidence == group)
            for group in {rule.evidence for rule in rules}
        }
        certainty = 1.0 - math.prod(1.0 - groups[group] for group in sorted(groups))
        rank = (BANDS.index(band), round(certainty / 1e-9), -PREFERENCE.index(type_))
        if strongest is None or rank > strongest[0]:
            strongest = (rank, (band, type_))
    return strongest[1] if strongest else None
