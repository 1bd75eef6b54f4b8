"""SAP IV cards (Bathe, Wilson, Peterson, EERC 73-11), the ancestor of Algor's SUPERSAP: beams, shells, bricks.

The cards follow the manual from memory and have not been run in SAP IV itself. What is not certain is a named choice:
BRICK_ORDER (which face comes first), TRIANGLE_FOURTH_NODE (what a triangular shell has in the fourth node's place).

SAP IV knows neither rigid nor averaging couplings: both become stiff beams from the independent (the averaged) node to
each of the others, which is stiffer than an average; the heading says how many. Equations, quadratic elements, wedges
and tetrahedra are refused. Nodes of solids alone have their rotations fixed, as the format asks.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.couplings import nodes_with_rotations
from kernel.connect.mass import section_axes
from kernel.connect.model import Mpc, Rbe2
from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import ascii_text
from kernel.deck.numbers import fixed_field
from kernel.errors import DeckError
from kernel.idealise.section import principal_section
from kernel.units import UNIT_SETS

if TYPE_CHECKING:
    from kernel.connect.model import Coupling, Model, Property
    from kernel.materials import Material
    from kernel.mesh.mesh import ElementBlock

Array = NDArray[np.float64]

BRICK_ORDER = (0, 1, 2, 3, 4, 5, 6, 7)
"""Bottom face, counter-clockwise seen from the top, then the top face above it: VTK's order."""

TRIANGLE_FOURTH_NODE = 0
"""A triangular shell leaves its fourth node blank."""

SPOKE_SIDE = 0.1
"""A stiff beam is a square bar of the first material with this share of the model's size as its side."""

MAX_NODES = 9_999
"""What the four columns of a node's number hold."""

_LINE_PARTS = {"line2": ((0, 1),), "line3": ((0, 2), (2, 1))}
_NO_LOAD = "".join(["        0."] * 4)


def write(model: Model) -> bytes:
    """The deck with one load case and no loads; DeckError for what SAP IV cannot carry."""
    _refuse(model)
    deck = _Deck(model)
    groups = [*deck.beams(), *deck.bricks(), *deck.shells()]
    n_group = sum(1 for block in (deck.has_beams, deck.has_bricks, deck.has_shells) if block)
    heading = f"CSGMESH {ascii_text(model.title).upper()} {UNIT_SETS[model.units]}"[:52]
    if model.couplings:
        heading += f" {len(deck.spokes)} STIFF BEAMS"[:20]
    control = _ints([len(deck.places), n_group, 1, 0, 0, 0, 0, 0], 5)
    lines = [heading[:72], control, *deck.nodes(), *groups]
    lines += ["", _NO_LOAD, "", ""]  # no nodal loads, multipliers of the load case, end
    return ("\n".join(lines) + "\n").encode("ascii")


def _refuse(model: Model) -> None:
    for block in model.mesh.blocks:
        if block.kind not in (*_LINE_PARTS, "tri3", "quad4", "hex8"):
            raise DeckError(
                f"segment {block.segment}: SAP IV has no {block.kind} elements, expected order 1 with quads, "
                "triangles or swept bricks"
            )
    if any(isinstance(coupling, Mpc) for coupling in model.couplings):
        raise DeckError("SAP IV cannot carry constraint equations (laps, work couplings), expected another format")


class _Deck:
    """Numbers of nodes, materials and sections, shared by the cards."""

    def __init__(self, model: Model) -> None:
        self.model = model
        self.by_segment = {element.segment: element for element in model.properties}
        self.materials = list(dict.fromkeys((p.material, p.density_factor) for p in model.properties))
        self._material_numbers = {key: number for number, key in enumerate(self.materials, start=1)}
        self.spokes = [
            (centre, other)
            for coupling in model.couplings
            for centre, others in [_spokes(coupling)]
            for other in others
            if not np.array_equal(model.mesh.nodes[centre], model.mesh.nodes[other])
        ]
        self.turning = nodes_with_rotations(model.mesh)
        for pair in self.spokes:
            self.turning[list(pair)] = True
        self.size = float(np.linalg.norm(np.ptp(model.mesh.nodes, axis=0)))
        self.lines = [block for block in model.mesh.blocks if block.kind in _LINE_PARTS]
        self.has_beams = bool(self.lines or self.spokes)
        self.has_bricks = any(block.kind == "hex8" for block in model.mesh.blocks)
        self.has_shells = any(block.kind in ("tri3", "quad4") for block in model.mesh.blocks)
        self.principal = {
            element.segment: principal_section(element.section)
            for element in model.properties
            if element.section is not None
        }
        self.places = [tuple(place) for place in model.mesh.nodes.tolist()]
        self._orientation: list[int] = []  # first of the nodes that turn the elements of each block of lines
        for block in self.lines:
            self._orientation.append(len(self.places) + 1)
            self.places += map(tuple, self._orientation_places(block).tolist())
        self._spoke_nodes: list[int] = []
        for a, b in self.spokes:
            start, end = model.mesh.nodes[a], model.mesh.nodes[b]
            self._spoke_nodes.append(len(self.places) + 1)
            self.places.append(tuple((start + self.size * _across(end - start)).tolist()))
        if len(self.places) > MAX_NODES:
            raise DeckError(
                f"SAP IV counts {MAX_NODES} nodes at most, the model needs {len(self.places)} (with those that turn "
                "beams); expected larger elements or another format"
            )

    def _orientation_places(self, block: ElementBlock) -> Array:
        """The K node lies along the principal y axis, the element's local axis 2."""
        assert block.orientation is not None
        nodes = self.model.mesh.nodes
        start, end = nodes[block.connectivity[:, 0]], nodes[block.connectivity[:, 1]]
        y, z = section_axes(start, end, block.orientation)
        angle = self.principal[block.segment][1]
        axis = np.cos(angle) * y + np.sin(angle) * z
        places: Array = start + axis * np.linalg.norm(end - start, axis=1, keepdims=True)
        return places

    def nodes(self) -> Iterator[str]:
        """CT, N, six codes (1 = fixed), X, Y, Z, KN, T: A1,I4,6I5,3F10,I5,F10."""
        for number, place in enumerate(self.places, start=1):
            if number > self.model.mesh.n_node:
                codes = [1] * 6
            else:
                codes = [0] * 6 if self.turning[number - 1] else [0, 0, 0, 1, 1, 1]
            yield f" {number:4d}{_ints(codes, 5)}{_reals(place)}{0:5d}{'0.':>10}"

    def beams(self) -> Iterator[str]:
        """Type 2."""
        if not self.has_beams:
            return
        beams = [element for element in self.model.properties if element.kind == "beam"]
        count = sum(len(block.connectivity) * len(_LINE_PARTS[block.kind]) for block in self.lines) + len(self.spokes)
        n_stiff = 1 if self.spokes else 0
        yield _ints([2, count, len(beams) + n_stiff, 0, len(self.materials) + n_stiff], 5)
        for number, key in enumerate(self.materials, start=1):
            material = self.model.materials[key[0]]
            yield f"{number:5d}{_reals([*_elastic(material), *_densities(material, key[1], self.model)])}"
        if self.spokes:  # couplings have no weight
            stiff = self.model.materials[self.materials[0][0]]
            yield f"{len(self.materials) + 1:5d}{_reals([*_elastic(stiff), 0.0, 0.0])}"
        for number, element in enumerate(beams, start=1):
            section = self.principal[element.segment][0]
            values = [section.area, section.shear_area_y, section.shear_area_z, section.j, section.iyy, section.izz]
            yield f"{number:5d}{_reals(values)}"
        if self.spokes:
            side = SPOKE_SIDE * self.size
            bar = [side**2, 0.0, 0.0, 0.141 * side**4, side**4 / 12, side**4 / 12]
            yield f"{len(beams) + 1:5d}{_reals(bar)}"
        yield from [_NO_LOAD] * 3
        yield from self._beam_elements(beams)

    def _beam_elements(self, beams: Sequence[Property]) -> Iterator[str]:
        sections = {element.segment: number for number, element in enumerate(beams, start=1)}
        number = 1
        for block, first in zip(self.lines, self._orientation):
            material = self._material(self.by_segment[block.segment])
            for third, row in enumerate((block.connectivity + 1).tolist(), start=first):
                for a, b in _LINE_PARTS[block.kind]:
                    yield _beam(number, row[a], row[b], third, material, sections[block.segment])
                    number += 1
        for (centre, other), third in zip(self.spokes, self._spoke_nodes):
            yield _beam(number, centre + 1, other + 1, third, len(self.materials) + 1, len(beams) + 1)
            number += 1

    def bricks(self) -> Iterator[str]:
        """Type 5, integration order 2."""
        if not self.has_bricks:
            return
        blocks = [block for block in self.model.mesh.blocks if block.kind == "hex8"]
        yield _ints([5, sum(len(block.connectivity) for block in blocks), len(self.materials), 0], 5)
        for number, (name, factor) in enumerate(self.materials, start=1):
            material = self.model.materials[name]
            weight = _densities(material, factor, self.model)[1]
            yield f"{number:5d}{_reals([*_elastic(material), weight, 0.0])}"
        yield f"{'0.':>10}"  # acceleration of gravity: no added masses
        yield from [_NO_LOAD] * 5
        number = 1
        for block in blocks:
            material_number = self._material(self.by_segment[block.segment])
            for row in (block.connectivity[:, list(BRICK_ORDER)] + 1).tolist():
                yield f"{_ints([number, *row, 2, material_number, 0], 5)} 0 0 0 000{'0.':>10}"
                number += 1

    def shells(self) -> Iterator[str]:
        """Type 6."""
        if not self.has_shells:
            return
        blocks = [block for block in self.model.mesh.blocks if block.kind in ("tri3", "quad4")]
        yield _ints([6, sum(len(block.connectivity) for block in blocks), len(self.materials)], 5)
        for number, (name, factor) in enumerate(self.materials, start=1):
            material = self.model.materials[name]
            c = material.elastic_modulus / (1 - material.poisson_ratio**2)
            yield f"{number:10d}{'':20}{_reals([material.density * factor, 0.0, 0.0, 0.0])}"
            yield _reals([c, material.poisson_ratio * c, 0.0, c, 0.0, material.shear_modulus])
        yield from [_NO_LOAD] * 5
        number = 1
        for block in blocks:
            element = self.by_segment[block.segment]
            assert element.thickness is not None
            material_number, reals = self._material(element), _reals([element.thickness, 0.0, 0.0, 0.0])
            for row in (block.connectivity + 1).tolist():
                four = row if len(row) == 4 else [*row, TRIANGLE_FOURTH_NODE]
                yield f"{_ints([number, *four, 0, material_number, 0], 5)}{reals}"
                number += 1

    def _material(self, element: Property) -> int:
        return self._material_numbers[(element.material, element.density_factor)]


def _spokes(coupling: Coupling) -> tuple[int, list[int]]:
    """The node that the stiff beams start from, and those where they end."""
    if isinstance(coupling, Rbe2):
        return coupling.independent, coupling.dependent.tolist()
    assert not isinstance(coupling, Mpc)  # refused before
    return coupling.dependent, coupling.independent.tolist()


def _beam(number: int, start: int, end: int, third: int, material: int, section: int) -> str:
    """el, I, J, K, material, section, 4 loads, 2 releases, increment: 10I5,2I6,I8."""
    return f"{_ints([number, start, end, third, material, section, 0, 0, 0, 0], 5)}{0:6d}{0:6d}{0:8d}"


def _elastic(material: Material) -> list[float]:
    return [material.elastic_modulus, material.poisson_ratio]


def _densities(material: Material, factor: float, model: Model) -> list[float]:
    """Mass and weight density."""
    density = material.density * factor
    return [density, density * UNIT_SETS[model.units].gravity]


def _across(direction: Array) -> Array:
    axis = np.eye(3)[int(np.argmin(np.abs(direction)))]
    across = np.cross(direction, axis)
    return across / float(np.linalg.norm(across))


def _ints(values: Sequence[int], width: int) -> str:
    """DeckError where a number is wider than its columns: all that follow would shift."""
    texts = [f"{value:{width}d}" for value in values]
    for text in texts:
        if len(text) > width:
            raise DeckError(f"SAP IV has {width} columns for the number {text}, expected a smaller model")
    return "".join(texts)


def _reals(values: Sequence[float]) -> str:
    return "".join(f"{fixed_field(float(value), 10):>10}" for value in values)


register(DeckFormat("sapiv", "SAP IV", (".sap",), "text/plain", write))
