"""`because` texts with numbers in them: `{slenderness:.1f}`. Our own, since str.format would reach into objects."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass

from rules.document import Scalar
from rules.problems import Collector, did_you_mean
from rules.syntax import Expression

_FIELD = re.compile(r"\{\{|\}\}|\{([^{}]*)\}|[{}]")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*\Z")
_FORMAT = re.compile(r"\+?,?(\.\d{1,2})?[dfge%]?\Z")
DEFAULT_FORMAT = ".4g"
UNKNOWN = "unknown"
"""Stands where a value does not exist."""


@dataclass(frozen=True, slots=True)
class Field:
    """A value to be put in, with its format."""

    name: str
    expression: Expression
    format: str


@dataclass(frozen=True, slots=True)
class Template:
    """Texts and fields in turn."""

    parts: tuple[str | Field, ...]

    @property
    def source(self) -> str:
        """The text as the author wrote it, in its canonical form."""
        return "".join(
            part.replace("{", "{{").replace("}", "}}")
            if isinstance(part, str)
            else f"{{{part.name}{':' + part.format if part.format else ''}}}"
            for part in self.parts
        )

    def fill(self, value_of: Callable[[Expression], object]) -> str:
        """The text with its values; `value_of` gives a number, a text, or None for what does not exist."""
        return "".join(
            part if isinstance(part, str) else format_value(value_of(part.expression), part.format)
            for part in self.parts
        )


def format_value(value: object, format_: str = "") -> str:
    """One value as text."""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, str):
        return value
    if isinstance(value, int | float):
        if format_.endswith("d"):
            return format(round(value), format_)
        return format(float(value), format_ or DEFAULT_FORMAT)
    return UNKNOWN


def parse_template(source: Scalar, names: dict[str, Expression], problems: Collector) -> Template:
    """The template that `source` is; names: what a field may say."""
    parts: list[str | Field] = []
    text, end = source.text, 0
    for match in _FIELD.finditer(text):
        parts.append(text[end : match.start()])
        end = match.end()
        if match.group() in ("{{", "}}"):
            parts.append(match.group()[0])
            continue
        place = source.at(match.start())
        if match.group(1) is None:
            problems.error(
                place, f"a single {match.group()!r}, write {{name}} for a value or {match.group() * 2} for a brace"
            )
            continue
        name, _, format_ = match.group(1).partition(":")
        if not _NAME.match(name):
            problems.error(place, f"the field {match.group()!r}, expected a name such as {{slenderness:.1f}}")
        elif name not in names:
            problems.error(place, f"unknown name {name!r}{did_you_mean(name, names)}")
        elif not _FORMAT.match(format_):
            problems.error(place, f"the format {format_!r}, expected one such as .1f, .3g, .0% or d")
        else:
            parts.append(Field(name, names[name], format_))
    parts.append(text[end:])
    return Template(_joined(parts))


def _joined(parts: list[str | Field]) -> tuple[str | Field, ...]:
    """Neighbouring texts made one, empty ones left out."""
    joined: list[str | Field] = []
    for part in parts:
        if isinstance(part, str) and joined and isinstance(joined[-1], str):
            joined[-1] += part
        elif part != "":
            joined.append(part)
    return tuple(joined)
