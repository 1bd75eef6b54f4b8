"""From the text of a condition to its syntax tree: our own grammar, names resolved, dimensions checked.

    scope = Scope(facts, parameters, quantities, words)
    condition = parse_condition(scalar, scope, problems)

Nothing here evaluates: what a tree means is said in compile.py (fast), trace.py (explaining) and reference.py (plain).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from kernel.facts import RELATED, SPECS, TIERS, FactSpec
from rules.document import Scalar
from rules.grammar import ExpressionError, offset_of, parse
from rules.problems import Collector, did_you_mean
from rules.syntax import (
    FUNCTIONS,
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
    QuantityRef,
    Text,
    Truth,
    WordRef,
    walk,
)

if TYPE_CHECKING:
    from typing import Any as Parsed  # a lark Tree, or a Token; lark's own types say less

    from lark import Token

MAX_EXPRESSION_DEPTH = 40

DIMENSIONS: Mapping[str, float | str] = {
    "ratio": 0.0,
    "count": 0.0,
    "length": 1.0,
    "area": 2.0,
    "volume": 3.0,
    "text": "text",
    "boolean": "boolean",
}
"""What a fact's dimension is to the type checker: the exponent of length, or the kind of value."""

_DIMENSION_NAMES = {0.0: "a ratio", 1.0: "a length", 2.0: "an area", 3.0: "a volume"}
_WORDS_OF_THE_LANGUAGE = ("and", "in", "is", "known", "not", "or", "proven", "unknown")


def dimension_name(dimension: float | str) -> str:
    """The dimension in words."""
    if isinstance(dimension, str):
        return {"text": "a text", "boolean": "a truth value"}[dimension]
    return _DIMENSION_NAMES.get(dimension, f"a length to the power {dimension:g}")


@dataclass(frozen=True, slots=True)
class Typed:
    """An expression and what the type checker knows of it. choices: the values that a text fact may take."""

    expression: Expression
    dimension: float | str
    choices: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Scope:
    """The names that an expression may use.

    parameters: name -> dimension. quantities: name -> typed expression. words: what rules conclude.
    item: the collection that a quantifier looks at, or None for the node itself.
    """

    parameters: Mapping[str, float]
    quantities: Mapping[str, Typed]
    words: frozenset[str]
    facts: Mapping[str, FactSpec] = field(default_factory=lambda: SPECS)
    item: str | None = None

    def inside(self, collection: str) -> Scope:
        """The scope within a quantifier over `collection`."""
        return Scope(self.parameters, self.quantities, self.words, self.facts, collection)

    def names(self) -> list[str]:
        """All of them, for did-you-mean."""
        return [*self.facts, *self.parameters, *self.quantities, *self.words]


def parse_condition(source: Scalar, scope: Scope, problems: Collector) -> Condition | None:
    """The condition that `source` says; None, with the problem noted, where it cannot be read."""
    try:
        return _Builder(source, scope).condition(parse(source.text))
    except ExpressionError as error:
        problems.error(source.at(error.offset), error.message)
        return None


def parse_quantity(source: Scalar, scope: Scope, problems: Collector) -> Typed | None:
    """The numeric expression that `source` says; None, with the problem noted, where it cannot be read."""
    try:
        typed = _Builder(source, scope).expression(parse(source.text))
        if isinstance(typed.dimension, str):
            raise ExpressionError(0, f"{dimension_name(typed.dimension)}, expected a number")
    except ExpressionError as error:
        problems.error(source.at(error.offset), error.message)
        return None
    return typed


class _Builder:
    """Turns one parse tree into syntax; every method raises ExpressionError with the offset of what is wrong."""

    def __init__(self, source: Scalar, scope: Scope) -> None:
        self._source = source
        self._scope = scope
        self._depth = 0

    # ---- conditions

    def condition(self, tree: Parsed) -> Condition:
        """The condition that `tree` is."""
        self._depth += 1
        if self._depth > MAX_EXPRESSION_DEPTH:
            raise ExpressionError(offset_of(tree), f"nested deeper than {MAX_EXPRESSION_DEPTH} levels")
        try:
            return self._condition(tree)
        finally:
            self._depth -= 1

    def _condition(self, tree: Parsed) -> Condition:
        place = self._source.at(offset_of(tree))
        parts = tree.children
        match tree.data:
            case "any_of":
                return Any(tuple(self.condition(part) for part in parts), place=place)
            case "all_of":
                return All(tuple(self.condition(part) for part in parts), place=place)
            case "negated":
                return Not(self.condition(parts[0]), place=place)
            case "compared":
                comparisons = [self._compare(*parts[k : k + 3]) for k in range(0, len(parts) - 2, 2)]
                return comparisons[0] if len(comparisons) == 1 else All(tuple(comparisons), place=place)
            case "member":
                return self._member(parts)
            case "not_member":
                return Not(self._member(parts), place=place)
            case "is_known":
                return Known(self._fact_based(parts[0]), place=place)
            case "is_unknown":
                return Not(Known(self._fact_based(parts[0]), place=place), place=place)
            case "call" if str(parts[0]) == "proven":
                if len(parts) != 2:
                    raise ExpressionError(offset_of(tree), f"proven takes one condition, found {len(parts) - 1}")
                return Proven(self.condition(parts[1]), place=place)
            case "name":
                return self._truth(parts[0])
        typed = self.expression(tree)
        raise ExpressionError(
            offset_of(tree), f"{dimension_name(typed.dimension)} alone, expected a comparison such as slenderness >= 10"
        )

    def _truth(self, token: Token) -> Condition:
        name, place = str(token), self._source.at(token.start_pos or 0)
        if name in self._scope.words and self._scope.item is None:
            return WordRef(name, place=place)
        typed = self._name(token)
        if typed.dimension == "boolean" and isinstance(typed.expression, FactRef):
            return Truth(typed.expression, place=place)
        what = dimension_name(typed.dimension)
        raise ExpressionError(token.start_pos or 0, f"{name} is {what}, expected a comparison such as {name} >= 10")

    def _fact_based(self, tree: Parsed) -> Expression:
        return self.expression(tree).expression

    def _compare(self, left_tree: Parsed, sign: Token, right_tree: Parsed) -> Condition:
        left, right = self._sides(left_tree, right_tree)
        operator, offset = str(sign), sign.start_pos or 0
        place = self._source.at(offset_of(left_tree))
        if "text" in (left.dimension, right.dimension):
            if left.dimension != right.dimension:
                a, b = dimension_name(left.dimension), dimension_name(right.dimension)
                raise ExpressionError(offset, f"{a} compared with {b}")
            if operator not in ("==", "!="):
                raise ExpressionError(offset, f"texts compared by {operator}, expected == or !=")
            if isinstance(right.expression, Text) and isinstance(left.expression, FactRef):
                member = Member(left.expression, (right.expression.value,), place=place)
                return member if operator == "==" else Not(member, place=place)
            raise ExpressionError(offset, "expected a text fact on the left and one of its values on the right")
        if "boolean" in (left.dimension, right.dimension):
            name = self._source.text[offset_of(left_tree) : offset].strip()
            raise ExpressionError(offset, f"a truth value compared, write {name} or not {name}")
        has_zero = Number(0.0) in (left.expression, right.expression)
        if left.dimension != right.dimension and not has_zero:
            a, b = dimension_name(left.dimension), dimension_name(right.dimension)
            raise ExpressionError(offset, f"{a} compared with {b}")
        measured = _is_measured(left.expression) or _is_measured(right.expression)
        return Compare(operator, left.expression, right.expression, measured, place=place)

    def _sides(self, left_tree: Parsed, right_tree: Parsed) -> tuple[Typed, Typed]:
        """Both sides of a comparison; a bare word opposite a text fact is one of its values."""
        left_fact, right_fact = self._text_fact(left_tree), self._text_fact(right_tree)
        if left_fact is not None and right_fact is None and _is_word(right_tree):
            return left_fact, self._choice(right_tree.children[0], left_fact.choices)
        return self.expression(left_tree), self.expression(right_tree)

    def _text_fact(self, tree: Parsed) -> Typed | None:
        if not _is_word(tree) or tree.data != "name":
            return None
        name = str(tree.children[0])
        spec = self._scope.facts.get(name.removeprefix("node."))
        return self._name(tree.children[0]) if spec is not None and spec.dimension == "text" else None

    def _choice(self, token: Token, choices: tuple[str, ...]) -> Typed:
        value = str(token).strip("\"'")
        if choices and value not in choices:
            hint = did_you_mean(value, choices) or f", expected one of {', '.join(choices)}"
            raise ExpressionError(token.start_pos or 0, f"unknown value {value!r}{hint}")
        return Typed(Text(value, place=self._source.at(token.start_pos or 0)), "text")

    def _member(self, parts: list) -> Condition:
        fact = self._text_fact(parts[0])
        if fact is None:
            raise ExpressionError(offset_of(parts[0]), "`in` asks whether a text fact has one of several values")
        values = []
        for part in parts[1:]:
            choice = self._choice(part.children[0], fact.choices).expression
            assert isinstance(choice, Text)
            values.append(choice.value)
        return Member(fact.expression, tuple(sorted(set(values))), place=self._source.at(offset_of(parts[0])))

    # ---- expressions

    def expression(self, tree: Parsed) -> Typed:
        """The value that `tree` is, with its dimension."""
        self._depth += 1
        if self._depth > MAX_EXPRESSION_DEPTH:
            raise ExpressionError(offset_of(tree), f"nested deeper than {MAX_EXPRESSION_DEPTH} levels")
        try:
            return self._expression(tree)
        finally:
            self._depth -= 1

    def _expression(self, tree: Parsed) -> Typed:
        offset = offset_of(tree)
        place = self._source.at(offset)
        parts = tree.children
        match tree.data:
            case "number":
                value = float(parts[0])
                if value in (float("inf"), float("-inf")):
                    raise ExpressionError(offset, f"the number {parts[0]} is too large")
                return Typed(Number(value, place=place), 0.0)
            case "text":
                return Typed(Text(str(parts[0])[1:-1], place=place), "text")
            case "name":
                return self._name(parts[0])
            case "negative":
                inner = self._number(parts[0])
                if isinstance(inner.expression, Number):
                    return Typed(Number(-inner.expression.value, place=place), 0.0)
                minus_one = Number(-1.0, place=place)
                product = Arithmetic("*", minus_one, inner.expression, place=place)
                return Typed(product, inner.dimension)
            case "arithmetic":
                return self._arithmetic(parts[0], parts[1], parts[2])
            case "power":
                return self._power(parts[0], parts[1])
            case "call":
                return self._call(parts[0], parts[1:])
        raise ExpressionError(offset, "a condition, expected a number")

    def _number(self, tree: Parsed) -> Typed:
        typed = self.expression(tree)
        if isinstance(typed.dimension, str):
            raise ExpressionError(offset_of(tree), f"{dimension_name(typed.dimension)}, expected a number")
        return typed

    def _arithmetic(self, left_tree: Parsed, sign: Token, right_tree: Parsed) -> Typed:
        left, right = self._number(left_tree), self._number(right_tree)
        operator, offset = str(sign), sign.start_pos or 0
        assert not isinstance(left.dimension, str) and not isinstance(right.dimension, str)
        expression = Arithmetic(
            operator, left.expression, right.expression, place=self._source.at(offset_of(left_tree))
        )
        if operator in "+-":
            if left.dimension != right.dimension:
                a, b = dimension_name(left.dimension), dimension_name(right.dimension)
                raise ExpressionError(offset, f"{a} {operator} {b}, expected the same dimension on both sides")
            return Typed(expression, left.dimension)
        change = right.dimension if operator == "*" else -right.dimension
        return Typed(expression, left.dimension + change)

    def _power(self, base_tree: Parsed, exponent_tree: Parsed) -> Typed:
        base, exponent = self._number(base_tree), self._number(exponent_tree)
        assert not isinstance(base.dimension, str)
        if not isinstance(exponent.expression, Number) or abs(exponent.expression.value) > 6:
            raise ExpressionError(offset_of(exponent_tree), "a power, expected a plain number from -6 to 6")
        expression = Arithmetic("**", base.expression, exponent.expression, place=self._source.at(offset_of(base_tree)))
        return Typed(expression, base.dimension * exponent.expression.value)

    def _call(self, token: Token, argument_trees: list) -> Typed:
        name, offset = str(token), token.start_pos or 0
        if name not in FUNCTIONS:
            hint = did_you_mean(name, [*FUNCTIONS, "proven"]) or f", expected one of {', '.join(FUNCTIONS)}"
            raise ExpressionError(offset, f"unknown function {name!r}{hint}")
        arguments = [self._number(tree) for tree in argument_trees]
        if name in ("abs", "cbrt", "sqrt") and len(arguments) != 1:
            raise ExpressionError(offset, f"{name} takes one value, found {len(arguments)}")
        if name in ("first", "max", "min") and len(arguments) < 2:
            raise ExpressionError(offset, f"{name} takes two or more values, found {len(arguments)}")
        dimension = arguments[0].dimension
        for tree, argument in zip(argument_trees, arguments, strict=True):
            if argument.dimension != dimension:
                a, b = dimension_name(dimension), dimension_name(argument.dimension)
                raise ExpressionError(offset_of(tree), f"{name} of {a} and {b}, expected the same dimension")
        assert not isinstance(dimension, str)
        call = Call(name, tuple(argument.expression for argument in arguments), place=self._source.at(offset))
        return Typed(call, dimension * {"sqrt": 0.5, "cbrt": 1.0 / 3.0}.get(name, 1.0))

    def _name(self, token: Token) -> Typed:
        name, offset = str(token), token.start_pos or 0
        scope, place = self._scope, self._source.at(offset)
        outer = name.startswith("node.")
        if "." in name and not (outer and scope.item is not None):
            raise ExpressionError(offset, f"unknown name {name!r}: node. is for conditions inside a quantifier")
        spec = scope.facts.get(name.removeprefix("node."))
        if spec is not None:
            tier = TIERS.index(spec.tier)
            if scope.item is not None and not outer:
                tier = max(tier, TIERS.index(RELATED[scope.item].tier))
            return Typed(
                FactRef(spec.name, tier, outer, place=place),
                DIMENSIONS[spec.dimension],
                spec.choices,
            )
        if name in scope.parameters:
            return Typed(ParameterRef(name, place=place), scope.parameters[name])
        if name in scope.quantities:
            if scope.item is not None:
                raise ExpressionError(
                    offset, f"the quantity {name!r} is of the node, not of what a quantifier looks at"
                )
            typed = scope.quantities[name]
            return Typed(QuantityRef(name, typed.expression, place=place), typed.dimension)
        if name in scope.words:
            why = "is of the node" if scope.item is not None else "is a condition, not a value"
            raise ExpressionError(offset, f"the word {name!r} {why}")
        if name in ("true", "false"):
            raise ExpressionError(offset, f"{name!r} is not needed: write the truth value alone, or `not` before it")
        if name in _WORDS_OF_THE_LANGUAGE:
            raise ExpressionError(offset, f"{name!r} is a word of the language, expected a name")
        raise ExpressionError(offset, f"unknown name {name!r}{did_you_mean(name, scope.names())}")


def _is_measured(expression: Expression) -> bool:
    """Whether a measured number is in it: a length, an area, a volume or a ratio, not only counts."""
    return any(isinstance(part, FactRef) and SPECS[part.name].dimension != "count" for part in walk(expression))


def _is_word(tree: Parsed) -> bool:
    return getattr(tree, "data", None) in ("name", "text")
