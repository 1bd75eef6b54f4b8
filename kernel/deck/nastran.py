"""NASTRAN bulk data, for MYSTRAN, MSC, NX and Optistruct: reals in 16-character fields throughout.

Linear and quadratic shells and solids, CBAR for beams (a beam of three nodes becomes two), RBE2, RBE3 and MPC.
Named CSG nodes and segments are SETs in the case control, each after a comment with its name. The deck is complete
but for loads and supports: uncomment LOAD and SPC when they are there.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.model import Mpc, Property, Rbe2, Rbe3
from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import ascii_text, header_lines, set_names
from kernel.deck.numbers import fixed_field
from kernel.errors import DeckError

if TYPE_CHECKING:
    from kernel.connect.model import Coupling, Model
    from kernel.mesh.mesh import ElementBlock

DRILLING = 1.0
"""K6ROT: resistance of shells to turning about their normals, of 1e-6 of their shear stiffness each. Left at 0
(MYSTRAN's default) those freedoms are singular: askew to the axes nothing fixes them, and where something is coupled to
a shell, rounding leaks through them into the rest. 100 (MSC Nastran's default) stiffens webs in lap by 2 %, 1 by
less than .03 %.
"""

MPC_SET = 1

SHEAR_FACTOR = 5 / 6
"""Transverse shear thickness ratio of a homogeneous shell (Reissner)."""

# our place of each node that NASTRAN lists, in NASTRAN's order
_CARDS: dict[str, tuple[str, tuple[int, ...]]] = {
    "tri3": ("CTRIA3", (0, 1, 2)),
    "tri6": ("CTRIA6", (0, 1, 2, 3, 4, 5)),
    "quad4": ("CQUAD4", (0, 1, 2, 3)),
    "quad8": ("CQUAD8", (0, 1, 2, 3, 4, 5, 6, 7)),
    "tet4": ("CTETRA", (0, 1, 2, 3)),
    "tet10": ("CTETRA", (0, 1, 2, 3, 4, 5, 6, 7, 8, 9)),
    "wedge6": ("CPENTA", (0, 1, 2, 3, 4, 5)),
    "wedge15": ("CPENTA", (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11)),
    "hex8": ("CHEXA", (0, 1, 2, 3, 4, 5, 6, 7)),
    "hex20": ("CHEXA", (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15)),
}

_LINE_PARTS = {"line2": ((0, 1),), "line3": ((0, 2), (2, 1))}

_REDUCED = ("hex8", "wedge6")
"""Integrated 2 x 2 x 2 with reduced shear: bends without locking. Quadratic elements so treated have mechanisms."""

_SOLID_CLASSES = ("hex8", "hex20", "wedge6", "wedge15", "tet4", "tet10")


def write(model: Model) -> bytes:
    """The deck; DeckError where ids or numbers do not fit their fields."""
    return assemble_deck(model, case=["$ LOAD = 1", "$ SPC = 1"], bulk=[])


def nastran_self_weight(model: Model, supports: Sequence[int], direction: Sequence[float] = (0, 0, -1)) -> bytes:
    """The deck under its own weight, with all six freedoms held at the nodes `supports` (indices of the mesh)."""
    from kernel.units import UNIT_SETS

    gravity = UNIT_SETS[model.units].gravity
    held = [_card("SPC1", [1, 123456, *(node + 1 for node in chunk)]) for chunk in _chunks(sorted(supports), 6)]
    load = _wide("GRAV", [1, 0, gravity, *map(float, direction)])
    case = ["LOAD = 1", "SPC = 1", "DISPLACEMENT = ALL", "SPCFORCES = ALL"]
    return assemble_deck(model, case=case, bulk=["PARAM,GRDPNT,0", load, *held])


def assemble_deck(model: Model, case: Sequence[str], bulk: Sequence[str], solution: int = 101) -> bytes:
    """The deck with lines of one's own in the case control and at the head of the bulk data. Grid ids are index + 1."""
    numbering = _Numbering(model)
    lines = [f"$ {line}" for line in header_lines(model, "NASTRAN bulk data")]
    lines += [f"SOL {solution}", "CEND", f"TITLE = {ascii_text(model.title)[:60]}", "ECHO = NONE"]
    lines += _sets(model, numbering)
    lines += case
    if any(isinstance(coupling, Mpc) for coupling in model.couplings):
        lines.append(f"MPC = {MPC_SET}")
    lines += ["BEGIN BULK", "PARAM,POST,-1"]
    if any(element.kind == "shell" for element in model.properties):
        lines.append(f"PARAM,K6ROT,{DRILLING:.1f}")
    lines += bulk
    lines += _materials(model)
    lines += _properties(model, numbering)
    lines += _grids(model)
    lines += _elements(model, numbering)
    lines += _couplings(model, numbering)
    lines.append("ENDDATA")
    return ("\n".join(lines) + "\n").encode("ascii")


class _Numbering:
    """Element and property ids: properties by segment and, for solids, by kind (hexes and tets ask different rules)."""

    def __init__(self, model: Model) -> None:
        by_segment = {element.segment: element for element in model.properties}
        self.properties: dict[tuple[str, str], int] = {}
        self.element: dict[tuple[str, str], Property] = {}
        self.first: list[int] = []  # first element id of each block
        element = 1
        for block in model.mesh.blocks:
            key = self.key(block)
            self.properties.setdefault(key, len(self.properties) + 1)
            self.element[key] = by_segment[block.segment]
            self.first.append(element)
            element += len(block.connectivity) * self.parts(block.kind)
        self.next_element = element
        counts = [len(block.connectivity) for block in model.mesh.blocks]
        self._parts = np.repeat(np.array([self.parts(b.kind) for b in model.mesh.blocks], dtype=np.int64), counts)
        self._first = 1 + np.cumsum(self._parts) - self._parts
        if element + len(model.couplings) > 99_999_999 or model.mesh.n_node > 99_999_999:
            raise DeckError("NASTRAN ids end at 99,999,999, expected a smaller model")

    @staticmethod
    def key(block: ElementBlock) -> tuple[str, str]:
        """Segment and, for solids, the element kind."""
        return block.segment, block.kind if block.kind in _SOLID_CLASSES else ""

    @staticmethod
    def parts(kind: str) -> int:
        """How many NASTRAN elements one of ours becomes."""
        return len(_LINE_PARTS.get(kind, ((),)))

    def element_ids(self, indices: NDArray[np.int64]) -> NDArray[np.int64]:
        """Ids of elements numbered over all blocks."""
        first, parts = self._first[indices], self._parts[indices]
        return np.sort(np.concatenate([first, first[parts == 2] + 1]))


def _sets(model: Model, numbering: _Numbering) -> list[str]:
    lines: list[str] = []
    names = set_names([named.name for named in model.sets], 60)
    for number, (named, name) in enumerate(zip(model.sets, names)):
        lines.append(f"$ SET {2 * number + 1}: elements of {name}; SET {2 * number + 2}: its nodes")
        for offset, ids in ((1, numbering.element_ids(named.elements)), (2, named.nodes + 1)):
            lines += _set(2 * number + offset, ids) if len(ids) else []
    return lines


def _set(number: int, ids: NDArray[np.int64]) -> list[str]:
    """SET n = 1 THRU 5, 7, ... in lines of at most 72 characters."""
    breaks = np.flatnonzero(np.diff(ids) != 1) + 1
    items = [
        str(run[0]) if len(run) == 1 else f"{run[0]},{run[1]}" if len(run) == 2 else f"{run[0]} THRU {run[-1]}"
        for run in np.split(ids, breaks)
    ]
    lines, line = [], f"SET {number} = "
    for position, item in enumerate(items):
        last = position == len(items) - 1
        if len(line) + len(item) > 68:
            lines.append(line.rstrip())
            line = "   "
        line += item if last else f"{item},"
    return [*lines, line]


def _materials(model: Model) -> list[str]:
    """One MAT1 for each material, and for each density that a property scales."""
    lines = []
    for number, (name, factor) in _material_numbers(model):
        material = model.materials[name]
        lines.append(f"$ {ascii_text(name)}" + (f", density x {factor:.9g}" if factor != 1 else ""))
        lines.append(
            _wide("MAT1", [number, material.elastic_modulus, "", material.poisson_ratio, material.density * factor])
        )
    return lines


def _material_numbers(model: Model) -> list[tuple[int, tuple[str, float]]]:
    keys = dict.fromkeys((element.material, element.density_factor) for element in model.properties)
    return list(enumerate(keys, start=1))


def _properties(model: Model, numbering: _Numbering) -> list[str]:
    materials = {key: number for number, key in _material_numbers(model)}
    lines = []
    for key, number in numbering.properties.items():
        element = numbering.element[key]
        material = materials[(element.material, element.density_factor)]
        lines.append(f"$ {ascii_text(element.segment)}")
        if element.kind == "beam":
            lines += _beam_property(element, number, material)
        elif element.kind == "shell":
            assert element.thickness is not None
            lines.append(_wide("PSHELL", [number, material, element.thickness, material, "", material, SHEAR_FACTOR]))
        elif key[1] in _REDUCED:
            lines.append(_card("PSOLID", [number, material, "", "TWO", "", "REDUCED"]))
        else:
            lines.append(_card("PSOLID", [number, material]))
    return lines


def _beam_property(element: Property, number: int, material: int) -> list[str]:
    """PBAR: plane 1 holds the orientation vector (our y), so I1 = izz and K1 is for shear along y."""
    section = element.section
    assert section is not None
    shape = ", ".join(f"{key} {value:.6g}" for key, value in section.dimensions.items())
    lines = [ascii_text(f"$ section: {section.shape} {shape}".rstrip())]
    offset = max(abs(section.shear_centre[0]), abs(section.shear_centre[1]))
    if offset > 0:
        y, z = section.shear_centre
        lines.append(f"$ shear centre at y {y:.6g}, z {z:.6g} from the centroid: CBAR does not know it")
    recovery = [value for point in _recovery_points(element) for value in point]
    card = [number, material, section.area, section.izz, section.iyy, section.j, "", "", *recovery]
    card += [section.shear_area_y / section.area, section.shear_area_z / section.area, section.iyz]
    return [*lines, _wide("PBAR", card)]


def _recovery_points(element: Property) -> list[tuple[float, float]]:
    """The outline's outermost corner in each quadrant direction, (y, z) from the centroid."""
    section = element.section
    assert section is not None
    parts = getattr(section.outline, "geoms", [section.outline])
    points = np.concatenate([np.asarray(part.exterior.coords)[:-1, :2] for part in parts])
    points = points - np.asarray(section.centroid)
    scale = np.abs(points).max(axis=0)
    corners = []
    for signs in ((1, 1), (-1, 1), (-1, -1), (1, -1)):
        reach = (points / scale) @ np.array(signs)
        y, z = points[int(np.argmax(np.round(reach, 9)))]
        corners.append((float(np.round(y / scale[0], 12) * scale[0]), float(np.round(z / scale[1], 12) * scale[1])))
    return corners


def _grids(model: Model) -> Iterator[str]:
    for number, (x, y, z) in enumerate(model.mesh.nodes.tolist(), start=1):
        fields = f"{fixed_field(x):>16}{fixed_field(y):>16}"
        yield f"GRID*   {number:>16}{'':>16}{fields}\n*       {fixed_field(z):>16}"


def _elements(model: Model, numbering: _Numbering) -> Iterator[str]:
    for block, first in zip(model.mesh.blocks, numbering.first):
        pid = numbering.properties[numbering.key(block)]
        if block.kind in _LINE_PARTS:
            yield from _bars(block, first, pid)
            continue
        name, order = _CARDS[block.kind]
        card = _number_card(name, 2 + len(order))
        for number, row in enumerate((block.connectivity[:, list(order)] + 1).tolist(), start=first):
            yield card % (number, pid, *row)


def _bars(block: ElementBlock, first: int, pid: int) -> Iterator[str]:
    assert block.orientation is not None
    number = first
    for row, vector in zip(block.connectivity.tolist(), block.orientation.tolist()):
        for a, b in _LINE_PARTS[block.kind]:
            yield _wide("CBAR", [number, pid, row[a] + 1, row[b] + 1, *vector])
            number += 1


def _couplings(model: Model, numbering: _Numbering) -> Iterator[str]:
    number = numbering.next_element
    for coupling in model.couplings:
        yield _coupling(coupling, number)
        number += not isinstance(coupling, Mpc)


def _coupling(coupling: Coupling, number: int) -> str:
    if isinstance(coupling, Rbe2):
        fields = [number, coupling.independent + 1, int(coupling.components), *(int(n) + 1 for n in coupling.dependent)]
        return _card("RBE2", fields)
    if isinstance(coupling, Rbe3):
        return _rbe3(coupling, number)
    return _mpc(coupling)


def _rbe3(coupling: Rbe3, number: int) -> str:
    """Nodes of equal weight stand together. Weights are written relative to their mean."""
    weights = coupling.weights / coupling.weights.mean()
    groups: dict[str, list[int]] = {}
    for node, weight in zip(coupling.independent.tolist(), weights.tolist()):
        groups.setdefault(fixed_field(float(f"{weight:.12g}")), []).append(node + 1)
    fields: list[object] = [number, "", coupling.dependent + 1, int(coupling.components)]
    for weight_text, nodes in groups.items():
        fields += [weight_text, int(coupling.independent_components), *nodes]
    return _wide("RBE3", fields)


def _mpc(coupling: Mpc) -> str:
    """MPC, two terms a row of eight fields: set, then (node, component, coefficient) twice and a blank."""
    terms = [
        [node + 1, component, coefficient]
        for node, component, coefficient in zip(
            coupling.nodes.tolist(), coupling.components.tolist(), coupling.coefficients.tolist()
        )
    ]
    fields: list[object] = [MPC_SET]
    for position, term in enumerate(terms):
        if position and position % 2 == 0:
            fields += ["", ""]
        fields += term
    return _wide("MPC", fields)


def _text(field: object) -> str:
    return fixed_field(field) if isinstance(field, float) else str(field)


def _number_card(name: str, n_field: int) -> str:
    """A %-template of a card of whole numbers, eight a line: all ids fit, which _Numbering has seen to."""
    rows = ["%8d" * min(8, n_field - start) for start in range(0, n_field, 8)]
    return f"{name:<8}" + "\n+       ".join(rows)


def _card(name: str, fields: Sequence[object]) -> str:
    """8-character fields, eight a line: whole numbers and words only."""
    texts = [_text(field) for field in fields]
    if any(len(text) > 8 for text in texts):
        return _wide(name, fields)
    lines = [f"{name:<8}"]
    for position, text in enumerate(texts):
        if position and position % 8 == 0:
            lines.append("+       ")
        lines[-1] += f"{text:>8}"
    return "\n".join(line.rstrip() for line in lines)


def _wide(name: str, fields: Sequence[object]) -> str:
    """16-character fields, four a line; an even number of lines, as the format asks."""
    texts = [_text(field) for field in fields]
    lines = [f"{name + '*':<8}"]
    for position, text in enumerate(texts):
        if position and position % 4 == 0:
            lines.append("*       ")
        lines[-1] += f"{text:>16}"
    if len(lines) % 2:
        lines.append("*")
    return "\n".join(line.rstrip() for line in lines)


def _chunks(items: Sequence[int], size: int) -> Iterable[Sequence[int]]:
    return (items[start : start + size] for start in range(0, len(items), size))


register(DeckFormat("nastran", "NASTRAN bulk data", (".bdf", ".nas", ".dat"), "text/plain", write))
