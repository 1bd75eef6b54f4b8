"""Parameters and quantities: the numbers of a rule base, and the names that it gives to expressions."""

from __future__ import annotations

import re
from itertools import islice

from kernel.errors import Place
from rules.definition import LENGTH_UNITS, Parameter, Quantity
from rules.document import Item, Mapping, Scalar, Sequence, number_of
from rules.items import ItemReader
from rules.language import Scope, Typed, parse_quantity
from rules.layers import Merged
from rules.syntax import FactRef, QuantityRef, walk

MAX_QUANTITY_PARTS = 500
"""Parts of a quantity when the quantities that it uses are put in: each may double the one before."""

PARAMETER_KEYS = ("meaning", "range", "source", "unit", "value")
QUANTITY_KEYS = ("meaning", "value")


class NumberReader(ItemReader):
    """Reads both, from all layers of a rule base."""

    def parameters(self, merged: Merged) -> dict[str, Parameter]:
        """All parameters that are right."""
        read = {name: self.parameter(name, layers) for name, layers in merged.parameters.items()}
        return {name: parameter for name, parameter in read.items() if parameter is not None}

    def parameter(self, name: str, layers: list[tuple[Place, Item]]) -> Parameter | None:
        """One parameter; a later layer says only what it changes."""
        entries: dict[str, Item] = {}
        place = layers[-1][0]
        self.check_name(name, layers[0][0])
        for layer_place, item in layers:
            if isinstance(item, Mapping):
                self.check_keys(item, PARAMETER_KEYS)
                entries |= item.entries
            elif isinstance(item, Scalar):
                entries["value"] = item
            else:
                self.error(layer_place, f"the parameter {name!r} is a list, expected a value")
        value = self.number(entries.get("value"), place, f"the parameter {name!r}")
        unit, dimension = self._unit(entries.get("unit"))
        limits = self._range(entries.get("range"))
        if value is None:
            return None
        if limits is not None and not limits[0] <= value <= limits[1]:
            value_place = entries["value"].place
            self.error(value_place, f"{name} = {value:g} is outside its range {limits[0]:g} to {limits[1]:g}")
        return Parameter(
            name,
            value,
            unit,
            dimension,
            limits,
            self.text(entries.get("meaning")),
            self.text(entries.get("source")),
            place,
        )

    def _unit(self, item: Item | None) -> tuple[str, float]:
        text = self.text(item) or "1"
        if text == "1":
            return text, 0.0
        base, _, power = text.partition("^")
        if base in LENGTH_UNITS and power in ("", "2", "3"):
            return text, float(power or 1)
        assert item is not None
        self.error(
            item.place, f"unknown unit {text!r}, expected 1 or one of {', '.join(LENGTH_UNITS)}, also with ^2 or ^3"
        )
        return "1", 0.0

    def _range(self, item: Item | None) -> tuple[float, float] | None:
        if item is None:
            return None
        if isinstance(item, Sequence) and len(item.items) == 2:
            low, high = (number_of(part) if isinstance(part, Scalar) else None for part in item.items)
            if low is not None and high is not None and low < high:
                return low, high
        self.error(item.place, "a range, expected two numbers such as [5, 30], the smaller first")
        return None

    def quantities(
        self, merged: Merged, dimensions: dict[str, float], words: frozenset[str]
    ) -> tuple[dict, dict[str, Typed]]:
        """Quantities may use one another; each is read when those it names have been."""
        waiting = dict(sorted(merged.quantities.items()))
        sources: dict[str, tuple[Scalar, str]] = {}
        for name, (place, item) in list(waiting.items()):
            self.check_name(name, place)
            if name in dimensions:
                self.error(place, f"{name!r} is a parameter already, expected another name for the quantity")
            value: Item | None = item
            if isinstance(item, Mapping):
                self.check_keys(item, QUANTITY_KEYS)
                value = item.entries.get("value")
            if not isinstance(value, Scalar):
                self.error(place, f"the quantity {name!r} has no value, expected an expression")
                del waiting[name]
                continue
            meaning = self.text(item.entries.get("meaning")) if isinstance(item, Mapping) else ""
            sources[name] = (value, meaning)
        typed: dict[str, Typed] = {}
        quantities: dict[str, Quantity] = {}
        while waiting:
            ready = [name for name in waiting if not _mentions(sources[name][0].text, waiting.keys() - {name})]
            if not ready:
                name = next(iter(waiting))
                self.error(waiting[name][0], f"quantities define one another in a circle: {', '.join(waiting)}")
                break
            for name in ready:
                place, _ = waiting.pop(name)
                source, meaning = sources[name]
                read = parse_quantity(source, Scope(dimensions, dict(typed), words), self.problems)
                if read is None:
                    typed[name] = Typed(QuantityRef(name, FactRef("fill", 1)), 0.0)
                    continue
                if len(list(islice(walk(read.expression), MAX_QUANTITY_PARTS + 1))) > MAX_QUANTITY_PARTS:
                    self.error(place, f"the quantity {name!r} has more than {MAX_QUANTITY_PARTS} parts")
                    read = Typed(FactRef("fill", 1), 0.0)
                typed[name] = read
                assert not isinstance(read.dimension, str)
                quantities[name] = Quantity(name, read.expression, read.dimension, meaning, place)
        return quantities, typed


def _mentions(text: str, names: set[str]) -> bool:
    return any(word in names for word in re.findall(r"[A-Za-z_][A-Za-z0-9_]*", text))
