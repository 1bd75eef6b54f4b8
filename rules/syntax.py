"""The abstract syntax of rules: what a rule file means, free of YAML and of experta.

One tree serves matching, explanation, the reference evaluator, coverage and the analysis of gaps.

    Expression                      Condition
     +- Number                       +- Compare     a < b
     +- Text                         +- Member      kind in [block, wedge]
     +- FactRef                      +- Truth       is_prismatic
     +- ParameterRef                 +- WordRef     a word that rules conclude
     +- QuantityRef                  +- Known       free_length is known
     +- Arithmetic                   +- Proven      proven(...): missing counts as false
     +- Call                         +- All, Any, Not
                                     +- Quantified  some tool: [...]

A dimension is the exponent of length: 0 for ratios and counts, 1 length, 2 area, 3 volume.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from kernel.errors import Place


@dataclass(frozen=True, slots=True)
class Expression:
    """A value. place: where it stands; no part of its meaning."""

    place: Place | None = field(default=None, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Number(Expression):
    """A number as written."""

    value: float


@dataclass(frozen=True, slots=True)
class Text(Expression):
    """One of the values that a text fact may take."""

    value: str


@dataclass(frozen=True, slots=True)
class FactRef(Expression):
    """A fact of the node, or of the item that a quantifier looks at. outer: of the node, said inside a quantifier."""

    name: str
    tier: int
    outer: bool = False


@dataclass(frozen=True, slots=True)
class ParameterRef(Expression):
    """A parameter of the rule base; its value is put in when the base is compiled."""

    name: str


@dataclass(frozen=True, slots=True)
class QuantityRef(Expression):
    """A named expression of the rule base."""

    name: str
    expression: Expression


@dataclass(frozen=True, slots=True)
class Arithmetic(Expression):
    """left operator right; operator is one of + - * / **."""

    operator: str
    left: Expression
    right: Expression


@dataclass(frozen=True, slots=True)
class Call(Expression):
    """A function of FUNCTIONS."""

    function: str
    arguments: tuple[Expression, ...]


FUNCTIONS = ("abs", "cbrt", "first", "max", "min", "sqrt")
"""`first(a, b, ...)` is the first of its arguments that is known; the others are what they are called."""


@dataclass(frozen=True, slots=True)
class Condition:
    """True, false, or missing where a fact is."""

    place: Place | None = field(default=None, compare=False, repr=False, kw_only=True)


@dataclass(frozen=True, slots=True)
class Compare(Condition):
    """left operator right; operator is one of < <= > >= == !=.

    measured: not only counts are compared, so that equality has a tolerance and a margin has a meaning.
    """

    operator: str
    left: Expression
    right: Expression
    measured: bool


@dataclass(frozen=True, slots=True)
class Member(Condition):
    """A text is one of several."""

    expression: Expression
    choices: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Truth(Condition):
    """A boolean fact."""

    expression: FactRef


@dataclass(frozen=True, slots=True)
class WordRef(Condition):
    """A word that rules conclude: true when one of them holds."""

    name: str


@dataclass(frozen=True, slots=True)
class Known(Condition):
    """The expression has a value; never missing itself."""

    expression: Expression


@dataclass(frozen=True, slots=True)
class Proven(Condition):
    """True where the condition is true; false where it is false or a fact that it needs does not exist."""

    condition: Condition


@dataclass(frozen=True, slots=True)
class All(Condition):
    """All of them hold; true for none at all."""

    conditions: tuple[Condition, ...]


@dataclass(frozen=True, slots=True)
class Any(Condition):
    """At least one of them holds."""

    conditions: tuple[Condition, ...]


@dataclass(frozen=True, slots=True)
class Not(Condition):
    """The condition is false; missing stays missing."""

    condition: Condition


@dataclass(frozen=True, slots=True)
class Quantified(Condition):
    """At least `least` of the related items satisfy the condition (`every` and `no` are written with Not)."""

    collection: str
    tier: int
    least: int
    condition: Condition


def children(item: Expression | Condition) -> tuple[Expression | Condition, ...]:
    """The parts directly below `item`."""
    match item:
        case Arithmetic(left=left, right=right) | Compare(left=left, right=right):
            return (left, right)
        case Call(arguments=arguments):
            return arguments
        case (
            QuantityRef(expression=inner) | Member(expression=inner) | Truth(expression=inner) | Known(expression=inner)
        ):
            return (inner,)
        case Proven(condition=condition) | Not(condition=condition) | Quantified(condition=condition):
            return (condition,)
        case All(conditions=conditions) | Any(conditions=conditions):
            return conditions
        case _:
            return ()


def walk(item: Expression | Condition) -> Iterator[Expression | Condition]:
    """`item` and all below it, parents first."""
    yield item
    for child in children(item):
        yield from walk(child)


def is_limit(expression: Expression) -> bool:
    """Whether an expression depends on no fact."""
    return not any(isinstance(part, FactRef) for part in walk(expression))


def number_text(value: float) -> str:
    """A number as an analyst would write it."""
    return f"{value:.10g}"


def text_of(item: Expression | Condition, *, in_product: bool = False) -> str:
    """The canonical text of an expression or condition: equal meaning is written alike."""
    match item:
        case Number(value=value):
            return number_text(value)
        case Text(value=value):
            return value
        case FactRef(name=name, outer=outer):
            return f"node.{name}" if outer else name
        case ParameterRef(name=name) | QuantityRef(name=name) | WordRef(name=name):
            return name
        case Arithmetic(operator=operator, left=left, right=right):
            tight = operator not in "+-"
            text = f"{text_of(left, in_product=tight)} {operator} {text_of(right, in_product=tight or operator == '-')}"
            return f"({text})" if in_product else text
        case Call(function=function, arguments=arguments):
            return f"{function}({', '.join(text_of(argument) for argument in arguments)})"
        case Compare(operator=operator, left=left, right=right):
            return f"{text_of(left)} {operator} {text_of(right)}"
        case Member(expression=expression, choices=choices):
            return f"{text_of(expression)} in [{', '.join(choices)}]"
        case Truth(expression=expression):
            return text_of(expression)
        case Known(expression=expression):
            return f"{text_of(expression)} is known"
        case Proven(condition=condition):
            return f"proven({text_of(condition)})"
        case All(conditions=conditions):
            return " and ".join(_bracketed(condition) for condition in conditions) or "always"
        case Any(conditions=conditions):
            return " or ".join(_bracketed(condition) for condition in conditions) or "never"
        case Not(condition=condition):
            return f"not {_bracketed(condition, also_atoms=True)}"
        case Quantified(collection=collection, least=least, condition=condition):
            return f"at least {least} {collection}: ({text_of(condition)})"
        case _:
            raise TypeError(f"no text for {type(item).__name__}")


def _bracketed(condition: Condition, *, also_atoms: bool = False) -> str:
    text = text_of(condition)
    bracket = isinstance(condition, All | Any) or (also_atoms and isinstance(condition, Compare | Member | Known))
    return f"({text})" if bracket else text
