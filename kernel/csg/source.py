"""What the three readers share: bounds on the text, places in it, and errors in words a person understands."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Mapping
from typing import NoReturn

from lark import Lark
from lark.exceptions import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from kernel.errors import Place, ReadError

MAX_INPUT_BYTES = 50_000_000
"""A file of this size or more is refused before it is read."""

MAX_NESTING = 1000
"""Brackets inside brackets in a text."""

MAX_TREE_DEPTH = 250
"""Booleans inside Booleans in the tree: every later stage may walk the tree recursively."""

MAX_NODES = 200_000
"""Nodes in a tree, every use of a re-used name counted."""

MAX_NUMBER = 1e12
"""Of any length, angle or factor: products of a few such numbers still are finite."""

MIN_SIZE = 1e-12
"""Of any length that must be over 0."""

MAX_SLICES = 10_000
"""Layers of a twisted extrusion."""

_CLOSING = {"{": "}", "(": ")", "[": "]"}
_NEVER_CLOSED = {"/*": ("comment", "*/"), '"': ("string", '"')}
_MAX_EXPECTED = 4


def place_at(text: str, offset: int, source: str) -> Place:
    """The place of the character at `offset` (from 0)."""
    line_start = text.rfind("\n", 0, offset) + 1
    return Place(source, text.count("\n", 0, offset) + 1, offset - line_start + 1)


def check_brackets(text: str, source: str, blanks: re.Pattern[str], max_nesting: int = MAX_NESTING) -> None:
    """Refuse brackets that are nested too deeply, never closed, or closed by the wrong one.

    blanks: matches what may hold brackets that mean nothing (comments, strings), a bracket, or the mark of a comment
    or string that is never closed.
    Done before parsing: the place is then that of the bracket at fault, and a bomb costs one linear scan.
    """
    opened: list[tuple[str, int]] = []
    for match in blanks.finditer(text):
        bracket = match.group()
        if bracket in _NEVER_CLOSED:
            what, closing = _NEVER_CLOSED[bracket]
            raise ReadError(
                f"a {what} is never closed, expected '{closing}'", place=place_at(text, match.start(), source)
            )
        if len(bracket) > 1:
            continue
        if bracket in _CLOSING:
            opened.append((bracket, match.start()))
            if len(opened) > max_nesting:
                raise ReadError(
                    f"nested too deeply, expected at most {max_nesting} brackets inside each other",
                    place=place_at(text, match.start(), source),
                )
        elif bracket in "})]":
            if not opened:
                raise ReadError(
                    f"{bracket!r} closes nothing, expected its opening bracket before it",
                    place=place_at(text, match.start(), source),
                )
            last, offset = opened.pop()
            if _CLOSING[last] != bracket:
                raise ReadError(
                    f"found {bracket!r}, expected {_CLOSING[last]!r} for the {last!r} of line "
                    f"{place_at(text, offset, source).line}",
                    place=place_at(text, match.start(), source),
                )
    if opened:
        last, offset = opened[-1]
        raise ReadError(f"{last!r} is never closed, expected {_CLOSING[last]!r}", place=place_at(text, offset, source))


def wrong_number(value: float, *, positive: bool = False) -> str | None:
    """What a number should have been, None where it can be one: finite, not too large, over 0 where that is asked."""
    if not math.isfinite(value):
        return "a finite number"
    if abs(value) > MAX_NUMBER:
        return f"a number up to {MAX_NUMBER:g}"
    if positive and value <= 0:
        return "a number over 0"
    if positive and value < MIN_SIZE:
        return f"a number of {MIN_SIZE:g} or more"
    return None


def either(words: list[str]) -> str:
    """`a`, `a or b`, `a, b or c`."""
    return words[0] if len(words) == 1 else f"{', '.join(words[:-1])} or {words[-1]}"


def raise_syntax_error(
    error: UnexpectedInput,
    parser: Lark,
    text: str,
    source: str,
    words: Mapping[str, str],
    found_words: Mapping[str, str],
) -> NoReturn:
    """A lark error as a ReadError.

    words: what each terminal of the grammar is called, in the order in which expected ones are to be named.
    found_words: what a terminal, or a character, is called where it is found and should not stand.
    """
    if isinstance(error, UnexpectedToken):
        expected = error.accepts or error.expected
        at_end = error.token.type == "$END"
        place = place_at(text, len(text.rstrip()), source) if at_end else Place(source, error.line, error.column)
        found = "the file ends here" if at_end else f"found {_shown(error.token.type, str(error.token), found_words)}"
    elif isinstance(error, UnexpectedCharacters):
        expected = _accepted(parser, text)
        place = Place(source, error.line, error.column)
        found = f"found {found_words.get(error.char, repr(error.char))}"
    else:
        expected = set()
        place = place_at(text, len(text.rstrip()), source)
        found = "the file ends here"
    named = list(dict.fromkeys(word for terminal, word in words.items() if terminal in expected))
    wanted = f", expected {either(named[:_MAX_EXPECTED])}" if named else ""
    raise ReadError(f"{found}{wanted}", place=place) from None


def _accepted(parser: Lark, text: str) -> set[str]:
    """The terminals that could have stood where lexing stopped."""
    interactive = parser.parse_interactive(text)
    with contextlib.suppress(UnexpectedInput):
        interactive.exhaust_lexer()
    return interactive.accepts()


def _shown(terminal: str, value: str, words: Mapping[str, str]) -> str:
    if terminal in words:
        return words[terminal]
    value = value.strip()
    return repr(value if len(value) <= 30 else value[:27] + "...")
