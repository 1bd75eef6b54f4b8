"""A rule base as it was read and checked: values only, in an order that is not the files'."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from kernel.errors import Place
from kernel.facts import Value
from kernel.plan import DIVISIONS, SEGMENT_TYPES
from rules.syntax import Condition, Expression, number_text, text_of
from rules.template import Template

BANDS = ("default", "general", "specific", "override")
"""Priority bands, weakest first: a rule of a stronger band wins whatever its certainty."""

PREFERENCE = ("beam", "plate", "cylinder_plate", "plates", "split", "cut", "brick")
"""Who wins where band and certainty are equal: the idealisation with the fewest unknowns first. Never file order."""

CONCLUSIONS = (*SEGMENT_TYPES, *DIVISIONS)
"""What a rule may conclude of a node."""

LENGTH_UNITS: Mapping[str, float] = {"mm": 1e-3, "cm": 1e-2, "m": 1.0, "in": 0.0254, "ft": 0.3048}
"""Metres in each unit that a length parameter may have; with ^2 and ^3 for areas and volumes."""


@dataclass(frozen=True, slots=True)
class Parameter:
    """A number that analysts tune.

    value: in its own unit. unit: "1" for ratios and counts, else a length unit, perhaps with ^2 or ^3.
    dimension: exponent of length. range: smallest and largest value that makes sense, or None.
    """

    name: str
    value: float
    unit: str
    dimension: float
    range: tuple[float, float] | None
    meaning: str
    source: str
    place: Place

    def in_model_units(self, metre: float) -> float:
        """The value where the model's length unit is `metre` metres."""
        if self.dimension == 0.0:
            return self.value
        return self.value * (LENGTH_UNITS[self.unit.split("^")[0]] / metre) ** self.dimension


@dataclass(frozen=True, slots=True)
class Quantity:
    """A named expression."""

    name: str
    expression: Expression
    dimension: float
    meaning: str
    place: Place


@dataclass(frozen=True, slots=True, eq=False)
class Case:
    """One example with its expected answer, kept beside the rule that it is about.

    facts or csg: what it is about. expect: a conclusion, "need TIER", or for csg a conclusion by node path.
    tier: the dearest tier that counts as measured. rule: id of the rule it is written at, or None.
    """

    name: str
    expect: Mapping[str, str]
    facts: Mapping[str, Value] | None
    related: Mapping[str, tuple[Mapping[str, Value], ...]]
    csg: str | None
    tier: str
    rule: str | None
    place: Place


@dataclass(frozen=True, slots=True, eq=False)
class Rule:
    """When the condition holds, then the segment type (or the word) is concluded.

    band: one of BANDS. segment: one of CONCLUSIONS, or None for a rule that concludes `word`.
    evidence: rules of one group count once, the most certain of them. level: words that it needs are decided before.
    """

    id: str
    band: str
    condition: Condition
    segment: str | None
    word: str | None
    certainty: float
    because: Template
    evidence: str
    source: str
    level: int
    place: Place

    @property
    def concludes(self) -> str:
        """The segment type or the word."""
        return self.segment or self.word or ""

    def canonical(self) -> str:
        """All that matters for decisions, in one line."""
        return (
            f"rule {self.id} | {self.band} | {text_of(self.condition)} | {self.segment} | {self.word} | "
            f"{number_text(self.certainty)} | {self.evidence} | {self.because.source}"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Definition:
    """A whole rule base. rules: by id. words: word -> level, the number of words that must be decided before."""

    name: str
    about: str
    parameters: Mapping[str, Parameter]
    quantities: Mapping[str, Quantity]
    words: Mapping[str, int]
    rules: tuple[Rule, ...]
    cases: tuple[Case, ...]
    files: tuple[str, ...]

    def canonical(self) -> Iterator[str]:
        """All that matters for decisions, line by line, the same for every order of files, rules and keys."""
        for name, parameter in sorted(self.parameters.items()):
            yield f"parameter {name} = {number_text(parameter.value)} {parameter.unit}"
        for name, quantity in sorted(self.quantities.items()):
            yield f"quantity {name} = {text_of(quantity.expression)}"
        for rule in self.rules:
            yield rule.canonical()

    @property
    def levels(self) -> int:
        """How many rounds the rules take: one more than the longest chain of words."""
        return 1 + max((rule.level for rule in self.rules), default=0)
