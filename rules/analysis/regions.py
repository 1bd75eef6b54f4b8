"""Where a condition holds, as boxes: for each quantity an interval, for each text or truth value a set.

Exact for comparisons with a limit (parameters at their present values). A comparison of two facts becomes an interval
of their difference; what is known of one box is only what it says itself, so an absent fact is never assumed.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace

from kernel.facts import SPECS
from rules.compile import Compiler
from rules.syntax import (
    All,
    Any,
    Compare,
    Condition,
    Expression,
    FactRef,
    Known,
    Member,
    Not,
    Proven,
    Truth,
    WordRef,
    is_limit,
    number_text,
    text_of,
)
from rules.trace import NEGATED
from rules.view import Unknown, View

MAX_BOXES = 400
"""A condition of more boxes is not analysed."""


class TooManyBoxes(Exception):
    """The condition has more alternatives than are worth analysing."""


@dataclass(frozen=True, slots=True)
class Interval:
    """low to high; an end is open where it does not belong to it."""

    low: float = -math.inf
    high: float = math.inf
    low_open: bool = False
    high_open: bool = False

    @property
    def is_empty(self) -> bool:
        """Whether no number is in it."""
        return self.low > self.high or (self.low == self.high and (self.low_open or self.high_open))

    def meet(self, other: Interval) -> Interval:
        """What is in both."""
        low, low_open = max((self.low, self.low_open), (other.low, other.low_open))
        high, high_closed = min((self.high, not self.high_open), (other.high, not other.high_open))
        return Interval(low, high, low_open, not high_closed)

    def contains(self, other: Interval) -> bool:
        """Whether all of `other` is in it."""
        return self.meet(other) == other

    def outside(self) -> list[Interval]:
        """The rest of the line, in up to two parts."""
        parts = [
            Interval(high=self.low, high_open=not self.low_open),
            Interval(low=self.high, low_open=not self.high_open),
        ]
        return [part for part in parts if not part.is_empty]

    def sample(self) -> float:
        """A number in it, for examples."""
        if math.isinf(self.low) and math.isinf(self.high):
            return 0.0
        if math.isinf(self.high):
            return self.low + (1.0 if self.low_open else 0.0)
        if math.isinf(self.low):
            return self.high - (1.0 if self.high_open else 0.0)
        return self.low if not self.low_open else self.high if not self.high_open else 0.5 * (self.low + self.high)

    def text(self, name: str) -> str:
        """As comparisons."""
        if self.low == self.high:
            return f"{name} == {number_text(self.low)}"
        parts = []
        if not math.isinf(self.low):
            parts.append(f"{name} {'>' if self.low_open else '>='} {number_text(self.low)}")
        if not math.isinf(self.high):
            parts.append(f"{name} {'<' if self.high_open else '<='} {number_text(self.high)}")
        return " and ".join(parts) or f"{name} is known"


@dataclass(frozen=True, slots=True)
class Choice:
    """Some of the values that a text, or a truth value, may take."""

    values: frozenset[object]
    all_values: frozenset[object]

    @property
    def is_empty(self) -> bool:
        """Whether none is left."""
        return not self.values

    def meet(self, other: Choice) -> Choice:
        """What is in both."""
        return replace(self, values=self.values & other.values)

    def contains(self, other: Choice) -> bool:
        """Whether all of `other` is in it."""
        return self.values >= other.values

    def outside(self) -> list[Choice]:
        """The other values."""
        rest = self.all_values - self.values
        return [replace(self, values=rest)] if rest else []

    def sample(self) -> object:
        """One of them."""
        return min(self.values, key=str)

    def text(self, name: str) -> str:
        """As a condition."""
        if self.all_values == frozenset((True, False)):
            if len(self.values) == 2:
                return f"{name} is known"
            return name if True in self.values else f"not {name}"
        values = ", ".join(sorted(map(str, self.values)))
        return f"{name} == {values}" if len(self.values) == 1 else f"{name} in [{values}]"


Extent = Interval | Choice


@dataclass(frozen=True, slots=True)
class Box:
    """All of the extents at once. is_part: the condition also holds outside, where a fact is missing."""

    extents: Mapping[str, Extent] = field(default_factory=dict)
    is_part: bool = False

    def meet(self, other: Box) -> Box | None:
        """What is in both, None where nothing is."""
        extents = dict(self.extents)
        for key, extent in other.extents.items():
            mine = extents.get(key)
            met = extent if mine is None else mine.meet(extent)  # type: ignore[arg-type]
            if met.is_empty:
                return None
            extents[key] = met
        return Box(extents, self.is_part or other.is_part)

    def contains(self, other: Box) -> bool:
        """Whether all of `other` is in it; what `other` does not speak of may be missing there."""
        return all(
            key in other.extents and extent.contains(other.extents[key])  # type: ignore[arg-type]
            for key, extent in self.extents.items()
        )

    def less(self, other: Box) -> list[Box]:
        """What is left of it without `other`, where every fact is known; disjoint boxes."""
        if self.meet(other) is None:
            return [self]
        left, rest = [], dict(self.extents)
        for key, extent in sorted(other.extents.items()):
            mine = rest.get(key, _everything(extent))
            for part in extent.outside():
                met = _whole_if_counted(key, mine.meet(part))  # type: ignore[arg-type]
                if not met.is_empty and _is_possible(key, met):
                    left.append(Box({**rest, key: met}, self.is_part))
            rest[key] = mine.meet(extent)  # type: ignore[arg-type]
        return left

    def text(self) -> str:
        """As one condition."""
        return " and ".join(extent.text(key) for key, extent in sorted(self.extents.items())) or "always"

    def example(self) -> str:
        """Values that are in it."""
        parts = []
        for key, extent in sorted(self.extents.items()):
            value = extent.sample()
            shown = number_text(value) if isinstance(value, float) else str(value).lower()
            parts.append(f"{key} = {shown}")
        return ", ".join(parts) or "anything"


def _everything(like: Extent) -> Extent:
    return Interval() if isinstance(like, Interval) else replace(like, values=like.all_values)


def _is_possible(key: str, extent: Extent) -> bool:
    """Whether a fact can have such a value at all: none is negative, no share is above 1, counts are whole."""
    spec = SPECS.get(key)
    if spec is None or not isinstance(extent, Interval):
        return True
    return not _natural(key).meet(extent).is_empty


def _natural(key: str) -> Interval:
    return Interval(0.0, 1.0) if key.endswith("_share") or key == "fill" else Interval(0.0)


class Regions:
    """The boxes of the conditions of one rule base."""

    def __init__(self, compiler: Compiler) -> None:
        self._compiler = compiler
        self._of_words: dict[tuple[str, bool], list[Box]] = {}

    def boxes(self, condition: Condition) -> list[Box]:
        """Where the condition holds; TooManyBoxes where that has too many alternatives."""
        return list(self._boxes(condition, False))

    def _boxes(self, condition: Condition, negated: bool) -> list[Box]:
        match condition:
            case All(conditions=parts):
                return self._any(parts, True) if negated else self._all(parts, False)
            case Any(conditions=parts):
                return self._all(parts, True) if negated else self._any(parts, False)
            case Not(condition=inner):
                return self._boxes(inner, not negated)
            case Proven(condition=inner):
                boxes = self._boxes(inner, negated)
                return [replace(box, is_part=True) for box in boxes] if negated else boxes
            case WordRef(name=name):
                if (name, negated) not in self._of_words:
                    makers = self._compiler.words[name]
                    self._of_words[name, negated] = self._all(makers, True) if negated else self._any(makers, False)
                return self._of_words[name, negated]
            case Compare():
                return self._compare(condition, negated)
            case Member(expression=expression, choices=choices):
                return self._choice(text_of(expression), expression, frozenset(choices), negated)
            case Truth(expression=expression):
                return self._truth(text_of(expression), negated)
            case Known(expression=expression):
                return self._truth(f"{text_of(expression)} is known", negated)
            case _:
                return self._truth(text_of(condition), negated)

    def _all(self, parts: tuple[Condition, ...], negated: bool) -> list[Box]:
        boxes = [Box()]
        for part in parts:
            others = self._boxes(part, negated)
            boxes = [met for box in boxes for other in others if (met := box.meet(other)) is not None]
            _check_size(boxes)
        return boxes

    def _any(self, parts: tuple[Condition, ...], negated: bool) -> list[Box]:
        boxes = [box for part in parts for box in self._boxes(part, negated)]
        _check_size(boxes)
        return boxes

    def _truth(self, key: str, negated: bool) -> list[Box]:
        both: frozenset[object] = frozenset((True, False))
        return [Box({key: Choice(frozenset((not negated,)), both)})]

    def _choice(self, key: str, expression: Expression, values: frozenset, negated: bool) -> list[Box]:
        spec = SPECS.get(expression.name) if isinstance(expression, FactRef) else None
        known = frozenset(spec.choices) if spec is not None else values
        chosen = known - values if negated else values
        return [Box({key: Choice(frozenset(chosen), frozenset(known))})] if chosen else []

    def _compare(self, condition: Compare, negated: bool) -> list[Box]:
        operator = NEGATED[condition.operator] if negated else condition.operator
        left, right = condition.left, condition.right
        if is_limit(left) and not is_limit(right):
            left, right = right, left
            operator = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}.get(operator, operator)
        if not is_limit(right):
            return [Box({f"{text_of(left)} - {text_of(right)}": part}) for part in _intervals(operator, 0.0)]
        limit = self._compiler.value(right, View.NOWHERE)
        if isinstance(limit, Unknown | str):
            return []
        key = text_of(left)
        boxes = []
        for part in _intervals(operator, float(limit)):
            whole = _whole_if_counted(key, part)
            if not whole.is_empty and _is_possible(key, whole):
                boxes.append(Box({key: whole}))
        return boxes


def _intervals(operator: str, limit: float) -> Iterator[Interval]:
    match operator:
        case ">=":
            yield Interval(low=limit)
        case ">":
            yield Interval(low=limit, low_open=True)
        case "<=":
            yield Interval(high=limit)
        case "<":
            yield Interval(high=limit, high_open=True)
        case "==":
            yield Interval(limit, limit)
        case _:
            yield Interval(high=limit, high_open=True)
            yield Interval(low=limit, low_open=True)


def _whole_if_counted(key: str, extent: Extent) -> Extent:
    counts = key in SPECS and SPECS[key].dimension == "count"
    return _whole(extent) if counts and isinstance(extent, Interval) else extent


def _whole(part: Interval) -> Interval:
    """The whole numbers of an interval, as a closed one."""
    low, high = part.low, part.high
    if math.isfinite(low):
        low = math.floor(low) + 1.0 if part.low_open else float(math.ceil(low))
    if math.isfinite(high):
        high = math.ceil(high) - 1.0 if part.high_open else float(math.floor(high))
    return Interval(low, high)


def _check_size(boxes: list[Box]) -> None:
    if len(boxes) > MAX_BOXES:
        raise TooManyBoxes
