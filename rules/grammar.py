"""The grammar of expressions (expression.lark): text to parse tree, and what to say where that fails."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from typing import Any as Parsed  # a lark Tree, or a Token; lark's own types say less

    from lark import Lark

MAX_EXPRESSION_CHARACTERS = 1_000


class ExpressionError(Exception):
    """One thing that is wrong in an expression, at an offset into its text."""

    def __init__(self, offset: int, message: str) -> None:
        super().__init__(message)
        self.offset = offset
        self.message = message


@lru_cache(maxsize=1)
def _grammar() -> Lark:
    from lark import Lark

    text = Path(__file__).with_name("expression.lark").read_text(encoding="utf-8")
    return Lark(text, parser="lalr", propagate_positions=True, maybe_placeholders=False)


def parse(text: str) -> Parsed:
    """The parse tree; ExpressionError for text that the grammar does not know."""
    from lark import Tree
    from lark.exceptions import UnexpectedCharacters, UnexpectedEOF, UnexpectedToken

    if not text.strip():
        raise ExpressionError(0, "an empty condition, expected a comparison such as slenderness >= 10")
    if len(text) > MAX_EXPRESSION_CHARACTERS:
        raise ExpressionError(
            0, f"an expression of {len(text)} characters, expected at most {MAX_EXPRESSION_CHARACTERS}"
        )
    try:
        start = _grammar().parse(text)
    except UnexpectedCharacters as error:
        offset = error.pos_in_stream or 0
        raise ExpressionError(offset, f"unexpected {text[offset]!r}{_advice(text, offset)}") from None
    except UnexpectedEOF:
        raise ExpressionError(len(text), "the expression ends too early, expected a value") from None
    except UnexpectedToken as error:
        if error.token.type == "$END":
            raise ExpressionError(len(text), "the expression ends too early, expected a value") from None
        offset = error.token.start_pos or 0
        raise ExpressionError(offset, f"unexpected {str(error.token)!r}{_advice(text, offset)}") from None
    assert isinstance(start, Tree)
    return start.children[0]


def _advice(text: str, offset: int) -> str:
    """What was probably meant, for signs that other languages use."""
    around = text[max(offset - 1, 0) : offset + 2]
    for sign, meant in (("=>", ">="), ("=<", "<="), ("<>", "!="), ("&&", "and"), ("||", "or"), ("^", "**")):
        if sign in around:
            return f", write {meant}"
    if text[offset] == "=":
        return ", write == to compare"
    if text[offset] == "!":
        return ", write not"
    if text[offset] == "%":
        return ", write a share such as 0.05"
    return ", expected an operator (and, or, <, <=, ==, >, >=, !=, +, -, *, /)"


def offset_of(tree: Parsed) -> int:
    """Where the text of `tree` begins."""
    meta = getattr(tree, "meta", None)
    if meta is not None:
        return int(getattr(meta, "start_pos", 0) or 0)
    return int(tree.start_pos or 0)
