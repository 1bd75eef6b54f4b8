"""The registry of formats. A format is one file that registers itself, and one line in `_FORMAT_MODULES`."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from kernel.errors import OptionError

if TYPE_CHECKING:
    from kernel.connect.model import Model

_FORMAT_MODULES = ("nastran", "ansys", "ansys5", "calculix", "abaqus", "sapiv", "gmsh", "vtu", "json")


@dataclass(frozen=True, slots=True)
class DeckFormat:
    """write: a model to the bytes of its deck (DeckError where the format cannot carry it). endings: with the dot."""

    name: str
    title: str
    endings: tuple[str, ...]
    media_type: str
    write: Callable[[Model], bytes]


_FORMATS: dict[str, DeckFormat] = {}


def register(deck_format: DeckFormat) -> None:
    """Make a format known under its name; the first to claim an ending is that ending's default."""
    _FORMATS[deck_format.name] = deck_format


def formats() -> tuple[DeckFormat, ...]:
    """All formats, in the order of `_FORMAT_MODULES`."""
    for module in _FORMAT_MODULES:
        importlib.import_module(f"kernel.deck.{module}")
    return tuple(_FORMATS[name] for name in sorted(_FORMATS, key=_FORMAT_MODULES.index))


def format_for(path: str, name: str | None = None) -> DeckFormat:
    """The format called `name`, or the one whose ending `path` has; OptionError where there is none."""
    known = formats()
    for deck_format in known:
        if deck_format.name == name or (name is None and path.lower().endswith(deck_format.endings)):
            return deck_format
    expected = ", ".join(f"{f.name} ({' '.join(f.endings) or 'only by --format'})" for f in known)
    what = f"unknown format {name!r}" if name else f"no format for the ending of {path!r}"
    raise OptionError(f"{what}, expected one of {expected}")
