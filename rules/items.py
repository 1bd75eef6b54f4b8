"""What every reader of YAML items needs: texts, numbers, names, keys, and a note of the problem where one is wrong."""

from __future__ import annotations

import re

from kernel.errors import Place
from kernel.facts import SPECS
from rules.document import Item, Mapping, Scalar, Sequence, number_of
from rules.problems import Collector, did_you_mean
from rules.syntax import FUNCTIONS

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
RESERVED = frozenset(
    ("and", "or", "not", "in", "is", "known", "unknown", "proven", "node", "true", "false", *SPECS, *FUNCTIONS)
)


class ItemReader:
    """Reads items, and gathers what is wrong with them."""

    def __init__(self, problems: Collector) -> None:
        self.problems = problems
        self.error = problems.error

    def listed(self, item: Mapping, key: str) -> tuple[Item, ...]:
        """The items of a list under `key`, none where it is not there."""
        found = item.entries.get(key)
        if found is None:
            return ()
        if isinstance(found, Sequence):
            return found.items
        self.error(found.place, f"`{key}` needs a list")
        return ()

    def check_name(self, name: str, place: Place) -> None:
        """Note a name that a parameter, quantity or word cannot have."""
        if not NAME.match(name):
            self.error(place, f"the name {name!r}, expected letters, digits and _")
        elif name in RESERVED:
            what = "a fact" if name in SPECS else "a word of the language"
            self.error(place, f"the name {name!r} is {what}, expected another")

    def check_keys(self, item: Mapping, known: tuple[str, ...]) -> None:
        """Note keys that mean nothing here."""
        for key, place in item.keys.items():
            if key not in known:
                hint = did_you_mean(key, known) or f", expected one of {', '.join(known)}"
                self.error(place, f"unknown key {key!r}{hint}")

    def text(self, item: Item | None) -> str:
        """A text on one line, empty where there is none."""
        if item is None:
            return ""
        if isinstance(item, Scalar):
            return " ".join(item.text.split())
        self.error(item.place, "expected a text")
        return ""

    def number(self, item: Item | None, place: Place, what: str) -> float | None:
        """A finite number; None, with the problem noted, where it is none."""
        if item is None:
            self.error(place, f"{what} is missing, expected a number")
            return None
        value = number_of(item) if isinstance(item, Scalar) else None
        if value is None or value in (float("inf"), float("-inf")):
            self.error(item.place, f"{what} is no number")
            return None
        return value

    def choice(self, item: Mapping, key: str, known: tuple[str, ...], default: str) -> str:
        """One of the `known` words."""
        found = item.entries.get(key)
        if found is None:
            return default
        text = found.text if isinstance(found, Scalar) else ""
        if text not in known:
            hint = did_you_mean(text, known) or f", expected one of {', '.join(known)}"
            self.error(found.place, f"unknown {key} {text!r}{hint}")
        return text
