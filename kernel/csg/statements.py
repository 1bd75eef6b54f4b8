"""The text of an OpenSCAD `.csg` as statements: names, arguments, children and places, nothing understood yet."""

from __future__ import annotations

import functools
import json
import re
from pathlib import Path
from typing import Any, NamedTuple, TypeAlias

from lark import Lark, Token, Transformer
from lark.exceptions import UnexpectedInput

from kernel.csg.source import check_brackets, raise_syntax_error
from kernel.errors import Place

Value: TypeAlias = "float | bool | str | list[Any] | None"

_BRACKETS = re.compile(r'//[^\n]*|/\*.*?\*/|/\*|"(?:\\.|[^"\\])*+"|"|[{}()\[\]]', re.DOTALL)
_WORDS = {"true": True, "false": False, "undef": None}

TERMINALS = {
    "_SEMICOLON": "';'",
    "_BEGIN": "'{'",
    "_END": "'}'",
    "_OPEN": "'('",
    "_CLOSE": "')'",
    "_COMMA": "','",
    "_LAST": "']'",
    "NUMBER": "a number",
    "VECTOR": "a list '[...]'",
    "_FIRST": "a list '[...]'",
    "KEY": "a parameter 'name ='",
    "WORD": "true, false or undef",
    "NAME": "a name such as cube or union",
}

FOUND = {"=": "an assignment, which belongs to OpenSCAD's source and not to what `openscad -o model.csg` writes"}


class Argument(NamedTuple):
    """One argument; key is None for a positional one."""

    key: str | None
    value: Value
    line: int
    column: int


class Statement(NamedTuple):
    """`modifier name(arguments) { children }`; modifier is a run of `%#*!`, mostly empty."""

    name: str
    line: int
    column: int
    modifier: str
    arguments: tuple[Argument, ...]
    children: tuple[Statement, ...]

    def place(self, source: str) -> Place:
        """Where its name stands."""
        return Place(source, self.line, self.column)


def parse_statements(text: str, source: str) -> tuple[Statement, ...]:
    """The file's top-level statements. ReadError: brackets or syntax, with the place."""
    check_brackets(text, source, _BRACKETS)
    parser = _parser()
    try:
        return parser.parse(text)  # type: ignore[return-value]
    except UnexpectedInput as error:
        raise_syntax_error(error, parser, text, source, TERMINALS, FOUND)


@functools.cache
def _parser() -> Lark:
    grammar = (Path(__file__).parent / "openscad.lark").read_text(encoding="utf-8")
    return Lark(grammar, parser="lalr", lexer="contextual", maybe_placeholders=False, transformer=_ToStatements())


class _ToStatements(Transformer):
    """Called by the parser at every reduction, so no syntax tree is ever built."""

    def start(self, items: list[Statement]) -> tuple[Statement, ...]:
        return tuple(item for item in items if type(item) is Statement)

    def leaf(self, items: list[Any]) -> Statement:
        first = items[0]
        if first.type == "MODIFIER":
            name = items[1]
            return Statement(str(name), name.line, name.column, str(first), items[2], ())
        return Statement(str(first), first.line, first.column, "", items[1], ())

    def branch(self, items: list[Any]) -> Statement:
        first, skip = items[0], 0
        modifier = ""
        if first.type == "MODIFIER":
            modifier, skip = str(first), 1
        name = items[skip]
        children = tuple(item for item in items[skip + 2 :] if type(item) is Statement)
        return Statement(str(name), name.line, name.column, modifier, items[skip + 1], children)

    def arguments(self, items: list[Argument]) -> tuple[Argument, ...]:
        return tuple(item for item in items if type(item) is Argument)

    def argument(self, items: list[Any]) -> Argument:
        first = items[0]
        if len(items) == 2:
            return Argument(first.rstrip()[:-1].rstrip(), _plain(items[1]), first.line or 0, first.column or 0)
        if type(first) is Token:
            return Argument(None, _plain(first), first.line or 0, first.column or 0)
        return Argument(None, first, 0, 0)

    def list(self, items: list[Any]) -> list[Any]:
        return [_plain(item) for item in items]


def _plain(item: Any) -> Value:
    """The value of a token; lists are values already."""
    if type(item) is not Token:
        return item  # type: ignore[no-any-return]
    kind = item.type
    if kind == "NUMBER":
        return float(item)
    if kind in ("VECTOR", "MATRIX"):
        return _numbers(item)
    if kind == "WORD":
        return _WORDS[item] if item in _WORDS else float(item)
    return str(item[1:-1])


def _numbers(token: Token) -> Value:
    return json.loads(token, parse_int=float)  # type: ignore[no-any-return]
