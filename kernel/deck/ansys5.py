"""ANSYS 5.0 commands: BEAM4, SHELL63 and SHELL93, SOLID45, SOLID95 and SOLID92; couplings as CE throughout.

BEAM4 knows principal axes only, so its orientation node is turned with them, and its shear deflection constants are
A over the section's shear areas along those axes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.equations import equation, rows
from kernel.connect.mass import section_axes
from kernel.connect.model import Property
from kernel.deck.ansys import constraint_equation
from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import ascii_text, header_lines, set_names
from kernel.deck.numbers import free_field
from kernel.idealise.section import SectionProperties, principal_section

if TYPE_CHECKING:
    from kernel.connect.model import Model
    from kernel.mesh.mesh import ElementBlock

Array = NDArray[np.float64]

# ANSYS 5.0 element and our places of its nodes in its order (repeated where it is degenerate)
_TYPES: dict[str, tuple[int, tuple[int, ...]]] = {
    "tri3": (63, (0, 1, 2, 2)),
    "quad4": (63, (0, 1, 2, 3)),
    "tri6": (93, (0, 1, 2, 2, 3, 4, 2, 5)),
    "quad8": (93, (0, 1, 2, 3, 4, 5, 6, 7)),
    "tet4": (45, (0, 1, 2, 2, 3, 3, 3, 3)),
    "wedge6": (45, (0, 1, 2, 2, 3, 4, 5, 5)),
    "hex8": (45, (0, 1, 2, 3, 4, 5, 6, 7)),
    "tet10": (92, (0, 1, 2, 3, 4, 5, 6, 7, 8, 9)),
    "wedge15": (95, (0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 2, 8, 9, 10, 5, 11, 12, 13, 14, 14)),
    "hex20": (95, (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19)),
}

_LINE_PARTS = {"line2": ((0, 1),), "line3": ((0, 2), (2, 1))}

RESERVED_NAMES = ("ALL", "STAT", "DEFA")
"""Words that commands read as something else where the name of a component stands."""

NODES_PER_COMMAND = 8
"""EN takes eight nodes; EMORE the next eight."""


def write(model: Model) -> bytes:
    """The commands, complete but for supports and loads."""
    types = list(dict.fromkeys(_type(block.kind) for block in model.mesh.blocks))
    materials = list(dict.fromkeys((element.material, element.density_factor) for element in model.properties))
    lines = [f"/COM,{line}"[:75] for line in header_lines(model, "ANSYS 5.0 commands")]
    lines += ["/PREP7", f"/TITLE,{ascii_text(model.title)[:65]}"]
    lines += [f"ET,{number},{element}" for number, element in enumerate(types, start=1)]
    for number, (name, factor) in enumerate(materials, start=1):
        material = model.materials[name]
        lines.append(f"MP,EX,{number},{_number(material.elastic_modulus)}")
        lines.append(f"MP,NUXY,{number},{_number(material.poisson_ratio)}")
        lines.append(f"MP,DENS,{number},{_number(material.density * factor)}")
    principal = {
        element.segment: principal_section(element.section)
        for element in model.properties
        if element.section is not None
    }
    for number, element in enumerate(model.properties, start=1):
        lines += _real_constants(element, number, principal.get(element.segment))
    lines += [
        f"N,{number},{','.join(map(_number, place))}" for number, place in enumerate(model.mesh.nodes.tolist(), start=1)
    ]
    lines += _elements(model, types, materials, principal)
    lines += _components(model)
    for coupling in model.couplings:
        for freedom, row in rows(coupling, model.mesh.nodes):
            lines += constraint_equation(equation(freedom, row))
    lines.append("FINISH")
    return ("\n".join(lines) + "\n").encode("ascii")


def _type(kind: str) -> int:
    return 4 if kind in _LINE_PARTS else _TYPES[kind][0]


def _number(value: float) -> str:
    return free_field(float(f"{value:.12g}"))


def _real_constants(element: Property, number: int, principal: tuple[SectionProperties, float] | None) -> Iterator[str]:
    """SHELL63: TK. BEAM4: AREA, IZZ, IYY, TKZ, TKY, THETA; ISTRN, IXX, SHEARZ, SHEARY.

    SHEARZ goes with IZZ, so with shear along the element's y, SHEARY with IYY (ANSYS Elements Reference, BEAM4).
    """
    if element.kind == "shell":
        assert element.thickness is not None
        yield f"R,{number},{_number(element.thickness)}"
    elif principal is not None:
        section, _ = principal
        low_y, low_z, high_y, high_z = section.outline.bounds
        first = (section.area, section.izz, section.iyy, high_z - low_z, high_y - low_y, 0.0)
        second = (0.0, section.j, section.area / section.shear_area_y, section.area / section.shear_area_z)
        yield f"R,{number},{','.join(map(_number, first))}"
        yield f"RMORE,{','.join(map(_number, second))}"


def _elements(
    model: Model,
    types: list[int],
    materials: list[tuple[str, float]],
    principal: dict[str, tuple[SectionProperties, float]],
) -> Iterator[str]:
    numbers = {element.segment: number for number, element in enumerate(model.properties, start=1)}
    material_numbers = {key: number for number, key in enumerate(materials, start=1)}
    free_node = model.mesh.n_node + 1
    element_number = 1
    for block in model.mesh.blocks:
        element = model.properties[numbers[block.segment] - 1]
        yield f"TYPE,{types.index(_type(block.kind)) + 1}"
        yield f"MAT,{material_numbers[(element.material, element.density_factor)]}"
        if element.kind != "solid":
            yield f"REAL,{numbers[block.segment]}"
        if block.kind in _LINE_PARTS:
            places = _orientation_places(block, model.mesh.nodes, principal[block.segment][1])
            for row, place in zip((block.connectivity + 1).tolist(), places.tolist()):
                yield f"N,{free_node},{','.join(map(_number, place))}"
                for a, b in _LINE_PARTS[block.kind]:
                    yield f"EN,{element_number},{row[a]},{row[b]},{free_node}"
                    element_number += 1
                free_node += 1
            continue
        for row in (block.connectivity[:, list(_TYPES[block.kind][1])] + 1).tolist():
            yield f"EN,{element_number},{','.join(map(str, row[:NODES_PER_COMMAND]))}"
            for start in range(NODES_PER_COMMAND, len(row), NODES_PER_COMMAND):
                yield f"EMORE,{','.join(map(str, row[start : start + NODES_PER_COMMAND]))}"
            element_number += 1


def _orientation_places(block: ElementBlock, nodes: Array, angle: float) -> Array:
    """Off each first node along the principal z axis, which is the section's z turned by the angle from y to z."""
    assert block.orientation is not None
    start, end = nodes[block.connectivity[:, 0]], nodes[block.connectivity[:, 1]]
    y, z = section_axes(start, end, block.orientation)
    across = np.cos(angle) * z - np.sin(angle) * y
    places: Array = start + across * np.linalg.norm(end - start, axis=1, keepdims=True)
    return places


def _components(model: Model) -> Iterator[str]:
    """Components of elements: selected one by one, for 5.0 has no CMBLOCK."""
    counts = np.concatenate(
        [np.full(len(b.connectivity), len(_LINE_PARTS.get(b.kind, ((),)))) for b in model.mesh.blocks]
    )
    ends = np.cumsum(counts)
    for named, name in zip(model.sets, set_names([named.name for named in model.sets], 8, RESERVED_NAMES)):
        if not len(named.elements):
            continue
        ids = np.sort(
            np.concatenate([np.arange(ends[k] - counts[k] + 1, ends[k] + 1) for k in named.elements.tolist()])
        )
        select = "S"
        for run in np.split(ids, np.flatnonzero(np.diff(ids) != 1) + 1):
            yield f"ESEL,{select},ELEM,,{run[0]},{run[-1]}"
            select = "A"
        yield f"CM,{name},ELEM"
    if model.sets:
        yield "ESEL,ALL"


register(DeckFormat("ansys5", "ANSYS 5.0 commands", (".ans",), "text/plain", write))
