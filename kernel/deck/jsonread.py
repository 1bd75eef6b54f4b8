"""The JSON deck read back: every value that kernel/deck/json.py writes, to the last bit.

What is wrong is said with its place in the document: `blocks[2].connectivity`. Unknown members are left alone, so that
programs may add their own.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from kernel.connect.model import Coupling, Model, Mpc, NamedSet, Property, Rbe2, Rbe3
from kernel.deck.json import VERSION
from kernel.errors import CsgmeshError, ReadError
from kernel.idealise.section import SectionProperties
from kernel.materials import Material, checked_material
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.units import unit_set
from kernel.words import is_writable

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

PROPERTY_KINDS = {1: "beam", 2: "shell", 3: "solid"}
"""What the elements of a segment are, by their dimension."""

_POSITIVE_OF_SECTION = ("area", "iyy", "izz", "j", "shear_area_y", "shear_area_z")

_SIZES = {
    "rectangle": ("width", "height"),
    "circle": ("radius",),
    "tube": ("radius", "inner_radius"),
    "box": ("width", "height", "web", "flange"),
}
"""The dimensions without which a section of that shape cannot be written in every format."""

LARGEST = 1e99
"""What single numbers may be, and one over it the least: exponents of two digits fit the fields of every format."""

HELD = ("123", "123456")
"""What a coupling may hold: not every format can say less than all translations."""


def read_json_deck(data: str | bytes, name: str = "deck") -> Model:
    """The model in a JSON deck; name: of the file, for errors. ReadError: it is not JSON, or not such a deck."""
    try:
        document = json.loads(data)
    except (ValueError, RecursionError) as error:
        raise ReadError(f"{name}: is no JSON deck: {error}") from None
    try:
        return _model(_Value(document, ""))
    except _Wrong as wrong:
        raise ReadError(f"{name}: {wrong}") from None
    except CsgmeshError as error:
        raise ReadError(f"{name}: {error}") from None


class _Wrong(Exception):
    """What is wrong in the document, with its place there."""


class _Value:
    """A value of the document that knows where it stands."""

    def __init__(self, value: Any, place: str) -> None:
        self.value = value
        self.place = place

    def refuse(self, expected: str) -> _Wrong:
        """The complaint that this is not what was expected."""
        shown = json.dumps(self.value)
        return _Wrong(f"{self.place or 'the document'} is {shown[:40]}, expected {expected}")

    def __getitem__(self, key: str) -> _Value:
        if not isinstance(self.value, dict):
            raise self.refuse("an object")
        place = f"{self.place}.{key}" if self.place else key
        if key not in self.value:
            raise _Wrong(f"{place} is missing")
        return _Value(self.value[key], place)

    def get(self, key: str, default: Any) -> _Value:
        """A member, or the default where it is missing."""
        if isinstance(self.value, dict) and key not in self.value:
            return _Value(default, f"{self.place}.{key}" if self.place else key)
        return self[key]

    def items(self) -> list[_Value]:
        """The items of a list."""
        if not isinstance(self.value, list):
            raise self.refuse("a list")
        return [_Value(item, f"{self.place}[{index}]") for index, item in enumerate(self.value)]

    def members(self) -> dict[str, _Value]:
        """The members of an object."""
        if not isinstance(self.value, dict):
            raise self.refuse("an object")
        if not all(map(is_writable, self.value)):
            raise self.refuse("names of letters that can be written")
        return {key: self[key] for key in self.value}

    def text(self) -> str:
        if not isinstance(self.value, str) or not is_writable(self.value):
            raise self.refuse("a text")
        return self.value

    def number(self) -> float:
        if not isinstance(self.value, int | float) or isinstance(self.value, bool):
            raise self.refuse("a finite number")
        try:
            value = float(self.value)
        except OverflowError:  # of a whole number beyond all floats
            value = math.inf
        if not abs(value) <= LARGEST:
            raise self.refuse(f"a number up to {LARGEST:g}")
        return value

    def positive(self) -> float:
        """A number above 0."""
        value = self.number()
        if value < 1 / LARGEST:
            raise self.refuse(f"a number from {1 / LARGEST:g}" if value > 0 else "a number above 0")
        return value

    def index(self, count: int) -> int:
        """A whole number from 0 to count - 1."""
        if not isinstance(self.value, int) or isinstance(self.value, bool) or not 0 <= self.value < count:
            raise self.refuse(f"a whole number from 0 to {count - 1}")
        return self.value

    def numbers(self, width: int | None = None) -> NDArray[np.float64]:
        """(n,) or (n, width) finite numbers."""
        return self._array(np.float64, width, "finite numbers", lambda array: bool(np.isfinite(array).all()))

    def indices(self, count: int, width: int | None = None) -> NDArray[np.int64]:
        """(n,) or (n, width) whole numbers from 0 to count - 1."""
        what = f"whole numbers from 0 to {count - 1}"
        return self._array(np.int64, width, what, lambda array: bool(((array >= 0) & (array < count)).all()))

    def _array(self, kind: type, width: int | None, what: str, holds: Callable[[NDArray[Any]], bool]) -> NDArray[Any]:
        expected = f"a list of {what}" if width is None else f"a list of rows of {width} {what}"
        if not isinstance(self.value, list):
            raise self.refuse(expected)
        shape = (0,) if width is None else (0, width)
        try:
            array = np.array(self.value) if self.value else np.empty(shape, kind)
        except ValueError:
            raise self.refuse(expected) from None
        is_whole = kind is np.int64
        if array.ndim != len(shape) or array.dtype.kind not in ("iu" if is_whole else "iuf"):
            raise self.refuse(expected)
        if (width is not None and array.shape[1] != width) or not holds(array):
            raise self.refuse(expected)
        return array.astype(kind)


def _model(document: _Value) -> Model:
    version = document["csgmesh"]
    if version.value != VERSION:
        raise version.refuse(f"a deck of version {VERSION}")
    materials = {name: _material(name, value) for name, value in document["materials"].members().items()}
    nodes = document["nodes"].numbers(3)
    nodes.flags.writeable = False
    blocks = tuple(_block(item, len(nodes)) for item in document["blocks"].items())
    if not blocks:
        raise document["blocks"].refuse("one block of elements or more")
    properties = _properties(document["properties"], materials, blocks)
    n_element = sum(len(block.connectivity) for block in blocks)
    return Model(
        title=document["title"].text(),
        units=unit_set(document["units"].text()).name,
        rule_base=document["rule_base"].text(),
        mesh=Mesh(nodes, blocks),
        properties=properties,
        materials=materials,
        couplings=tuple(_coupling(item, len(nodes)) for item in document["couplings"].items()),
        sets=tuple(
            NamedSet(item["name"].text(), item["nodes"].indices(len(nodes)), item["elements"].indices(n_element))
            for item in document["sets"].items()
        ),
        notes=tuple(item.text() for item in document.get("notes", []).items()),
    )


def _material(name: str, value: _Value) -> Material:
    return checked_material(
        Material(
            name=name,
            elastic_modulus=value["elastic_modulus"].positive(),
            poisson_ratio=value["poisson_ratio"].number(),
            density=value["density"].number(),
            source=value["source"].text(),
        )
    )


def _block(value: _Value, n_node: int) -> ElementBlock:
    kind = value["kind"]
    if kind.text() not in ELEMENT_KINDS:
        raise kind.refuse(f"one of {', '.join(ELEMENT_KINDS)}")
    element = ELEMENT_KINDS[kind.text()]
    connectivity = value["connectivity"].indices(n_node, element.n_node)
    if not len(connectivity):
        raise value["connectivity"].refuse("one element or more")
    if (np.diff(np.sort(connectivity, axis=1), axis=1) == 0).any():
        raise value["connectivity"].refuse("elements that have each of their nodes once")
    orientation = None
    if element.dimension == 1:
        orientation = value["orientation"].numbers(3)
        if len(orientation) != len(connectivity):
            raise value["orientation"].refuse(f"a vector for each of {len(connectivity)} elements")
    return ElementBlock(value["segment"].text(), element.name, connectivity, orientation)


def _properties(
    value: _Value, materials: Mapping[str, Material], blocks: Sequence[ElementBlock]
) -> tuple[Property, ...]:
    kinds: dict[str, int] = {}
    for place, block in enumerate(blocks):
        dimension = ELEMENT_KINDS[block.kind].dimension
        if kinds.setdefault(block.segment, dimension) != dimension:
            raise _Wrong(f"blocks[{place}] has {block.kind} elements of {block.segment}, expected one kind of segment")
    properties = []
    for item in value.items():
        segment, kind, material = item["segment"].text(), item["kind"], item["material"]
        if material.text() not in materials:
            raise material.refuse(f"one of {', '.join(materials)}")
        expected = PROPERTY_KINDS.get(kinds.get(segment, 0))
        if kind.text() not in PROPERTY_KINDS.values() or expected not in (None, kind.text()):
            raise kind.refuse(expected or "beam, shell or solid")
        properties.append(
            Property(
                segment=segment,
                kind=kind.text(),
                material=material.text(),
                thickness=item["thickness"].positive() if kind.text() == "shell" else None,
                section=_section(item["section"]) if kind.text() == "beam" else None,
                density_factor=item["density_factor"].positive(),
            )
        )
    names = [element.segment for element in properties]
    if len(set(names)) < len(names) or set(kinds) != set(names):
        raise _Wrong(f"properties are of {', '.join(names)}, expected one for each of {', '.join(kinds)}")
    return tuple(properties)


def _section(value: _Value) -> SectionProperties:
    from shapely import MultiPolygon, Polygon

    parts = []
    for part in value["outline"].items():
        rings = [ring.numbers(2) for ring in part.items()]
        if not rings or min(map(len, rings)) < 4:
            raise part.refuse("closed rings of four points or more")
        parts.append(Polygon(rings[0], rings[1:]))
        if not parts[-1].is_valid:
            raise part.refuse("rings that do not cross themselves or one another")
    if not parts:
        raise value["outline"].refuse("one polygon or more")
    outline: Polygon | MultiPolygon = parts[0] if len(parts) == 1 else MultiPolygon(parts)
    shape, dimensions = value["shape"].text(), value["dimensions"]
    sizes = {name: size.number() for name, size in dimensions.members().items()}
    for name in _SIZES.get(shape, ()):
        dimensions[name].positive()
    numbers = {name: value[name].positive() for name in _POSITIVE_OF_SECTION}
    return SectionProperties(
        shape=shape,
        centroid=_pair(value["centroid"]),
        shear_centre=_pair(value["shear_centre"]),
        outline=outline,
        dimensions=sizes,
        iyz=value["iyz"].number(),
        **numbers,
    )


def _pair(value: _Value) -> tuple[float, float]:
    both = value.numbers()
    if len(both) != 2:
        raise value.refuse("two numbers")
    return float(both[0]), float(both[1])


def _coupling(value: _Value, n_node: int) -> Coupling:
    kind = value["kind"]
    match kind.text():
        case "rbe2":
            return Rbe2(
                value["independent"].index(n_node), value["dependent"].indices(n_node), _components(value["components"])
            )
        case "rbe3":
            independent, weights = value["independent"].indices(n_node), value["weights"].numbers()
            if len(independent) != len(weights):
                raise value["weights"].refuse(f"{len(independent)} weights")
            if weights.sum() <= 0:
                raise value["weights"].refuse("weights with a sum above 0")
            return Rbe3(
                value["dependent"].index(n_node),
                independent,
                weights,
                _components(value["components"]),
                _components(value["independent_components"], HELD[:1]),
            )
        case "mpc":
            nodes, coefficients = value["nodes"].indices(n_node), value["coefficients"].numbers()
            components = value["components"].indices(7)
            if not len(nodes) == len(components) == len(coefficients) > 0 or components.min() < 1:
                raise value.refuse("as many nodes as components (1 to 6) and coefficients")
            if coefficients[0] == 0:
                raise value["coefficients"].refuse("one above or below 0 first, of the freedom that depends")
            return Mpc(nodes, components, coefficients)
    raise kind.refuse("rbe2, rbe3 or mpc")


def _components(value: _Value, allowed: Sequence[str] = HELD) -> str:
    if value.text() not in allowed:
        raise value.refuse(" or ".join(allowed))
    return value.text()
