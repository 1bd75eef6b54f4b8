"""The arguments of one OpenSCAD statement, asked for by name and checked where they stand."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from kernel.csg.source import MAX_NUMBER, MAX_SLICES, either, wrong_number
from kernel.csg.statements import Argument, Statement, Value
from kernel.csg.tree import Matrix
from kernel.errors import Place, ReadError
from kernel.words import did_you_mean

EVERYWHERE = ("$fn", "$fa", "$fs", "convexity", "timestamp")
"""Parameters that OpenSCAD may write on any statement."""


class Parameters:
    """Arguments by name; positional ones take the names of `order`.

    ReadError: an unknown name, or one that stands twice.

    known: further names that are allowed.
    """

    def __init__(self, statement: Statement, source: str, order: Sequence[str], known: Sequence[str] = ()) -> None:
        self.statement = statement
        self.source = source
        self._arguments: dict[str, Argument] = {}
        position = 0
        for argument in statement.arguments:
            key = argument.key
            if key is None:
                if position == len(order):
                    raise self.error(f"{statement.name} has {position + 1} positional arguments, expected {len(order)}")
                key = order[position]
                position += 1
            elif key not in order and key not in known and key not in EVERYWHERE:
                names = either([*order, *known]) if order or known else "none"
                raise self.error(
                    f"{statement.name} has no parameter {key!r}, expected {names}{did_you_mean(key, [*order, *known])}",
                    argument,
                )
            if key in self._arguments:
                raise self.error(f"{statement.name} has its parameter {key!r} twice, expected it once", argument)
            self._arguments[key] = argument

    def error(self, message: str, argument: Argument | None = None) -> ReadError:
        """A ReadError with the place of `argument`, or of the statement."""
        if argument is not None and argument.line:
            return ReadError(message, place=Place(self.source, argument.line, argument.column))
        return ReadError(message, place=self.statement.place(self.source))

    def has(self, name: str) -> bool:
        """Given, and not undef."""
        return name in self._arguments and self._arguments[name].value is not None

    def value(self, name: str) -> Value:
        """As written; None where not given."""
        return self._arguments[name].value if name in self._arguments else None

    def wrong(self, name: str, expected: str) -> ReadError:
        """The error that says what `name` is and what it should be."""
        argument = self._arguments.get(name)
        found = f"is {shown(argument.value)}" if argument else "is not given"
        return self.error(f"{self.statement.name}'s {name} {found}, expected {expected}", argument)

    def number(self, name: str, default: float | None = None) -> float:
        """A finite number."""
        if not self.has(name) and default is not None:
            return default
        value = self.value(name)
        if type(value) is not float:
            raise self.wrong(name, "a finite number")
        self._check(name, value, positive=False)
        return value

    def _check(self, name: str, value: float, *, positive: bool) -> None:
        expected = wrong_number(value, positive=positive)
        if expected:
            raise self.wrong(name, expected)

    def positive(self, name: str, default: float | None = None) -> float:
        """A finite number over 0."""
        value = self.number(name, default)
        self._check(name, value, positive=True)
        return value

    def flag(self, name: str) -> bool:
        """True or false; false where not given."""
        value = self.value(name)
        if value is not None and type(value) is not bool:
            raise self.wrong(name, "true or false")
        return bool(value)

    def sizes(self, name: str, count: int) -> tuple[float, ...]:
        """`count` numbers over 0, given as a list or as one number for all; 1 where not given."""
        value: Any = self.value(name)
        if value is None:
            return (1.0,) * count
        if type(value) is float:
            value = [value] * count
        if not _is_numbers(value, count) or not all(entry > 0 for entry in value):
            raise self.wrong(name, f"{count} finite numbers over 0")
        for entry in value:
            self._check(name, entry, positive=True)
        return tuple(value)

    def points(self, name: str, dimension: int) -> Matrix:
        """(n, dimension) coordinates."""
        value = self.value(name)
        if not isinstance(value, list) or not value:
            raise self.wrong(name, f"a list of points [{', '.join('xyz'[:dimension])}]")
        for index, point in enumerate(value):
            if not _is_numbers(point, dimension) or any(map(wrong_number, point)):
                raise self.error(
                    f"{self.statement.name}'s point {index} is {shown(point)}, expected {dimension} finite numbers"
                    f"{_limit(point)}",
                    self._arguments[name],
                )
        return np.array(value, dtype=np.float64)

    def index_lists(self, name: str, n_point: int) -> list[list[int]]:
        """Lists of at least three indices of points."""
        value = self.value(name)
        if not isinstance(value, list) or not value:
            raise self.wrong(name, "a list of lists of point numbers")
        result = []
        for number, indices in enumerate(value):
            if not isinstance(indices, list) or len(indices) < 3:
                raise self.wrong_entry(name, number, indices, "a list of three point numbers or more")
            for index in indices:
                if type(index) is not float or not 0 <= index < n_point or index != int(index):
                    raise self.wrong_entry(name, number, index, f"point numbers from 0 to {n_point - 1}")
            result.append([int(index) for index in indices])
        return result

    def wrong_entry(self, name: str, number: int, found: Value, expected: str) -> ReadError:
        """An entry of a list that cannot be."""
        return self.error(
            f"entry {number} of {self.statement.name}'s {name} has {shown(found)}, expected {expected}",
            self._arguments[name],
        )

    def slices(self) -> int | None:
        """A whole number of layers, None where not given."""
        if not self.has("slices"):
            return None
        value = self.number("slices")
        if not 1 <= value <= MAX_SLICES:
            raise self.wrong("slices", f"a whole number from 1 to {MAX_SLICES}")
        return int(value)

    def matrix(self) -> list[list[float]]:
        """The (4, 4) of a multmatrix; its last row is 0 0 0 1."""
        value = self.value("m")
        if isinstance(value, list) and len(value) == 3:
            value = [*value, [0.0, 0.0, 0.0, 1.0]]
        if not isinstance(value, list) or len(value) != 4 or not all(_is_numbers(row, 4) for row in value):
            raise self.wrong("m", "four rows of four finite numbers")
        if any(wrong_number(entry) for row in value for entry in row):
            raise self.wrong("m", f"four rows of four finite numbers{_limit(value[0] + value[1] + value[2])}")
        if value[3] != [0.0, 0.0, 0.0, 1.0]:
            raise self.error(f"multmatrix's last row is {shown(value[3])}, expected [0, 0, 0, 1]")
        return value


def _is_numbers(value: Value, length: int) -> bool:
    return (
        isinstance(value, list)
        and len(value) == length
        and all(type(entry) is float and math.isfinite(entry) for entry in value)
    )


def _limit(value: Value) -> str:
    """` up to 1e12` where a finite entry is over that."""
    entries = value if isinstance(value, list) else [value]
    is_large = any(type(entry) is float and MAX_NUMBER < abs(entry) < math.inf for entry in entries)
    return f" up to {MAX_NUMBER:g}" if is_large else ""


def shown(value: Value) -> str:
    """A value as OpenSCAD writes it, cut where it is long."""
    if isinstance(value, list):
        text = f"[{', '.join(shown(entry) for entry in value[:5])}{', ...' if len(value) > 5 else ''}]"
        return text if len(text) <= 60 else "a long list"
    if value is None:
        return "undef"
    if isinstance(value, bool):
        return "true" if value else "false"
    return f'"{value}"' if isinstance(value, str) else f"{value:.6g}"
