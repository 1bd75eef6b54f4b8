"""What every deck says of itself: title, units, rule base, counts, notes. No date: equal input, equal bytes."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from kernel.units import UNIT_SETS

if TYPE_CHECKING:
    from kernel.connect.model import Model


def header_lines(model: Model, format_title: str) -> list[str]:
    """Plain lines, to be written as the format's comments. ASCII only."""
    units = UNIT_SETS[model.units]
    counts = ", ".join(f"{count} {kind}" for kind, count in sorted(model.mesh.count().items()))
    lines = [
        f"csgmesh: {format_title}",
        f"model: {model.title}",
        f"units: {units} (length {units.length}, mass {units.mass}, force {units.force}, stress {units.stress})",
        f"rule base: {model.rule_base}",
        f"{model.mesh.n_node} nodes; {counts}; {len(model.couplings)} couplings",
    ]
    lines += [f"material {m.name}: {m.source}" for m in model.materials.values()]
    lines += [f"note: {note}" for note in model.notes]
    return [ascii_text(line) for line in lines]


def ascii_text(text: str) -> str:
    """One line of printable ASCII; other characters become `?`."""
    return printable(text.encode("ascii", "replace").decode("ascii"))


def printable(text: str) -> str:
    """One line: characters that cannot be printed become spaces."""
    return "".join(c if c.isprintable() else " " for c in text)


def set_name(name: str, limit: int) -> str:
    """A name that every solver takes: letters, digits and `_`, a letter first, upper case, at most `limit` long."""
    clean = "".join(c if c.isascii() and c.isalnum() else "_" for c in name).upper()
    if not clean or not clean[0].isalpha():
        clean = "N" + clean
    return clean[:limit]


def set_names(names: list[str], limit: int, reserved: Iterable[str] = ()) -> list[str]:
    """set_name for each, made unique: repeats, and names that the deck uses itself, get a number at their end."""
    taken: set[str] = set(reserved)
    following: dict[str, int] = {}  # the number that the next repeat of a name tries first: those below are taken
    result = []
    for name in names:
        base = candidate = set_name(name, limit)
        number = following.get(base, 2)
        while candidate in taken:
            ending = f"_{number}"
            candidate = base[: limit - len(ending)] + ending
            number += 1
        following[base] = number
        taken.add(candidate)
        result.append(candidate)
    return result
