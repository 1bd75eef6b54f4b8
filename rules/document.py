"""Reading a rule file: the plain part of YAML, with places, and hostile files refused.

PyYAML only splits the text into events; what they mean is decided here. Aliases, tags, duplicate keys, deep nesting and
the words that YAML 1.1 quietly turns into something else (`no`, `010`, `1:30`) are refused, each with a clear text.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

import yaml

from kernel.errors import Place
from rules.problems import Problem, RuleProblems

MAX_FILE_CHARACTERS = 1_000_000
MAX_DEPTH = 20
MAX_NODES = 200_000
MAX_SCALAR_CHARACTERS = 20_000


@dataclass(frozen=True, slots=True, eq=False)
class Scalar:
    """A text or number. is_plain: written without quotes; is_one_line: columns inside it can be trusted."""

    text: str
    place: Place
    is_plain: bool
    is_one_line: bool

    def at(self, offset: int) -> Place:
        """Place of the character at `offset`."""
        if not self.is_one_line:
            return self.place
        return Place(self.place.file, self.place.line, self.place.column + offset + (not self.is_plain))


@dataclass(frozen=True, slots=True, eq=False)
class Sequence:
    """A list."""

    items: tuple[Item, ...]
    place: Place


@dataclass(frozen=True, slots=True, eq=False)
class Mapping:
    """Keys and values; keys are unique, and know their places."""

    entries: dict[str, Item]
    keys: dict[str, Place]
    place: Place


Item = Scalar | Sequence | Mapping

_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eE][+-]?\d+)?\Z")
_TRAPS = (
    (re.compile(r"(?i:yes|no|on|off|y|n)\Z"), "is a truth value in YAML 1.1 and a text in others"),
    (re.compile(r"(~|(?i:null))\Z"), "means nothing at all in YAML"),
    (re.compile(r"[-+]?0[0-9_]+\Z"), "is an octal number in YAML 1.1"),
    (re.compile(r"[-+]?0[xbo][0-9a-fA-F_]+\Z"), "is a number to another base"),
    (re.compile(r"[-+]?[0-9]+(:[0-5]?[0-9])+(\.\d*)?\Z"), "is a number to base 60 in YAML 1.1"),
    (re.compile(r"[-+]?[0-9]+(_[0-9]*)+(\.\d*)?\Z"), "is a number with underscores in YAML 1.1"),
    (re.compile(r"[-+]?\.(?i:inf|nan)\Z"), "is no number that a rule can use"),
)


def number_of(scalar: Scalar) -> float | None:
    """The number that an unquoted scalar is, or None."""
    return float(scalar.text) if scalar.is_plain and _NUMBER.match(scalar.text) else None


def read_document(text: str, file: str) -> Item | None:
    """The one document in `text`, None where it is empty; RuleProblems for what is wrong with it as YAML."""
    if len(text) > MAX_FILE_CHARACTERS:
        raise _refused(
            Place(file, 1, 1), f"a rule file of {len(text)} characters, expected at most {MAX_FILE_CHARACTERS}"
        )
    try:
        return _Reader(text, file).document()
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        place = Place(file, mark.line + 1, mark.column + 1) if mark else Place(file, 1, 1)
        if "nesting depth" in (error.problem or ""):  # libyaml looks ahead further than our reader, and has a limit
            raise _refused(place, f"nested deeper than {MAX_DEPTH} levels") from None
        what = " ".join(part for part in (error.context, error.problem) if part)
        raise _refused(place, f"not readable as YAML: {what}") from None
    except yaml.YAMLError as error:
        raise _refused(Place(file, 1, 1), f"not readable as YAML: {error}") from None


def _refused(place: Place, message: str) -> RuleProblems:
    return RuleProblems([Problem(place, message)])


class _Reader:
    """Builds items from the event stream; refuses at the first event that goes too far."""

    def __init__(self, text: str, file: str) -> None:
        self._file = file
        self._events = yaml.parse(text, Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        self._count = 0

    def document(self) -> Item | None:
        result: Item | None = None
        for event in self._events:
            if isinstance(event, yaml.DocumentStartEvent) and result is not None:
                raise _refused(self._place(event), "a second document, expected one rule base in a file")
            if isinstance(event, yaml.NodeEvent):
                result = self._item(event, 0)
        return result

    def _place(self, event: yaml.Event) -> Place:
        return Place(self._file, event.start_mark.line + 1, event.start_mark.column + 1)

    def _item(self, event: yaml.Event, depth: int) -> Item:
        place = self._place(event)
        self._count += 1
        if self._count > MAX_NODES:
            raise _refused(place, f"more than {MAX_NODES} items, expected a smaller rule file")
        if depth > MAX_DEPTH:
            raise _refused(place, f"nested deeper than {MAX_DEPTH} levels")
        if isinstance(event, yaml.AliasEvent):
            raise _refused(place, f"an alias (*{event.anchor}): aliases are refused, write the value out")
        if event.anchor is not None:
            raise _refused(
                place, f"an anchor (&{event.anchor}): anchors are refused, write the value out where it is needed"
            )
        if event.tag is not None and event.tag != "!":
            raise _refused(place, f"a tag ({event.tag}): tags are refused, write the plain value")
        if isinstance(event, yaml.ScalarEvent):
            return self._scalar(event, place)
        if isinstance(event, yaml.SequenceStartEvent):
            items = []
            while not isinstance(inner := next(self._events), yaml.SequenceEndEvent):
                items.append(self._item(inner, depth + 1))
            return Sequence(tuple(items), place)
        return self._mapping(place, depth)

    def _mapping(self, place: Place, depth: int) -> Mapping:
        entries: dict[str, Item] = {}
        keys: dict[str, Place] = {}
        while not isinstance(inner := next(self._events), yaml.MappingEndEvent):
            key = self._item(inner, depth + 1)
            if not isinstance(key, Scalar):
                raise _refused(key.place, "a key that is no plain word")
            if key.text in entries:
                raise _refused(key.place, f"the key {key.text!r} stands twice, first in line {keys[key.text].line}")
            if key.text == "<<":
                raise _refused(key.place, "a merge key (<<): write the values out")
            keys[key.text] = key.place
            entries[key.text] = self._item(next(self._events), depth + 1)
        return Mapping(entries, keys, place)

    def _scalar(self, event: yaml.ScalarEvent, place: Place) -> Scalar:
        text, is_plain = event.value, event.style is None or event.style == ""
        if len(text) > MAX_SCALAR_CHARACTERS:
            raise _refused(place, f"a text of {len(text)} characters, expected at most {MAX_SCALAR_CHARACTERS}")
        if is_plain:
            for trap, why in _TRAPS:
                if trap.match(text):
                    raise _refused(place, f"{text!r} {why}: write true, false or a plain number, or put it in quotes")
        one_line = event.start_mark.line == event.end_mark.line
        return Scalar(text, place, is_plain, one_line)
