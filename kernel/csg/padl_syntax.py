"""The text of a PADL-2-like `.csg` as statements and expressions with places, nothing evaluated yet."""

from __future__ import annotations

import functools
import re
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedInput

from kernel.csg.source import check_brackets, raise_syntax_error

MAX_PARENTHESES = 50
"""Parentheses inside parentheses: evaluating recurses some twelve calls for each."""

_BRACKETS = re.compile(r"![^\n]*|[{}()\[\]]")

TERMINALS = {
    "EQUAL": "'='",
    "_NEWLINE": "the end of the line",
    "RPAR": "')'",
    "COMMA": "','",
    "LPAR": "'('",
    "UN": "UN",
    "DIF": "DIF",
    "INT": "INT",
    "AT": "AT",
    "NUMBER": "a number",
    "NAME": "a name",
    "UNITS": "UNITS",
    "MATERIAL": "MATERIAL",
    "OUT": "OUT",
}

FOUND = {"_NEWLINE": "the end of the line (& there goes on in the next)"}


class Here(NamedTuple):
    """Line and column, from 1."""

    line: int
    column: int


class Number(NamedTuple):
    """A literal."""

    here: Here
    value: float


class Name(NamedTuple):
    """A use of a name."""

    here: Here
    name: str


class Argument(NamedTuple):
    """`key = value`, or `value` alone."""

    here: Here
    key: str | None
    value: Expression


class Call(NamedTuple):
    """A primitive or a function: `name(arguments)`."""

    here: Here
    name: str
    arguments: tuple[Argument, ...]


class Chain(NamedTuple):
    """Operands with an operator between each two, all of one precedence; operators: (upper-case text, where)."""

    here: Here
    operands: tuple[Expression, ...]
    operators: tuple[tuple[str, Here], ...]


class Signed(NamedTuple):
    """-operand (a + says nothing)."""

    here: Here
    operand: Expression


class Placed(NamedTuple):
    """`operand AT (...) AT (...)`: the moves in written order."""

    here: Here
    operand: Expression
    moves: tuple[Argument, ...]


Expression: TypeAlias = "Number | Name | Call | Chain | Signed | Placed"


class Statement(NamedTuple):
    """kind: `units`, `material`, `definition` or `out`; value: arguments of a material, expression of a definition."""

    here: Here
    kind: str
    name: str
    value: Any = None


def parse_padl(text: str, source: str) -> tuple[Statement, ...]:
    """The file's statements in order. ReadError: brackets or syntax, with the place."""
    check_brackets(text, source, _BRACKETS, MAX_PARENTHESES)
    parser = _parser()
    try:
        return parser.parse(text)  # type: ignore[return-value]
    except UnexpectedInput as error:
        raise_syntax_error(error, parser, text, source, TERMINALS, FOUND)


@functools.cache
def _parser() -> Lark:
    grammar = (Path(__file__).parent / "padl.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", lexer="contextual", maybe_placeholders=False, transformer=_ToStatements())


def _here(token: Token) -> Here:
    return Here(token.line, token.column)  # type: ignore[arg-type]


def _expression(item: Any) -> Expression:
    return Number(_here(item), float(item)) if type(item) is Token else item


class _ToStatements(Transformer):
    """Called by the parser at every reduction, so no syntax tree is ever built."""

    def start(self, items: list[Any]) -> tuple[Statement, ...]:
        return tuple(item for item in items if type(item) is Statement)

    def units(self, items: list[Token]) -> Statement:
        return Statement(_here(items[1]), "units", str(items[1]))

    def material(self, items: list[Any]) -> Statement:
        return Statement(_here(items[1]), "material", str(items[1]), items[2] if len(items) > 2 else ())

    def definition(self, items: list[Any]) -> Statement:
        return Statement(_here(items[0]), "definition", str(items[0]), _expression(items[1]))

    def out(self, items: list[Token]) -> Statement:
        return Statement(_here(items[1]), "out", str(items[1]))

    def name(self, items: list[Token]) -> Name:
        return Name(_here(items[0]), str(items[0]))

    def call(self, items: list[Any]) -> Call:
        return Call(_here(items[0]), str(items[0]), items[1])

    def args(self, items: list[Argument]) -> tuple[Argument, ...]:
        return tuple(items)

    def arg(self, items: list[Any]) -> Argument:
        value = _expression(items[-1])
        if len(items) == 1:
            return Argument(value.here, None, value)
        return Argument(_here(items[0]), str(items[0]).upper(), value)

    def placed(self, items: list[Any]) -> Placed:
        operand = _expression(items[0])
        moves = [move for item in items[1:] if type(item) is tuple for move in item]
        return Placed(operand.here, operand, tuple(moves))

    def minus(self, items: list[Any]) -> Expression:
        operand = _expression(items[-1])
        n_minus = sum(item.type == "MINUS" for item in items[:-1])
        return Signed(_here(items[0]), operand) if n_minus % 2 else operand

    def chain(self, items: list[Any]) -> Chain:
        operands = tuple(_expression(item) for item in items[::2])
        operators = tuple((str(token).upper(), _here(token)) for token in items[1::2])
        return Chain(operands[0].here, operands, operators)
