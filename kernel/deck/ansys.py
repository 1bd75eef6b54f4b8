"""ANSYS blocked archive (.cdb): NBLOCK and EBLOCK, 188/189, 181/281, 185/186/187, components, CE, CERIG and RBE3.

Element types by kind; triangles, wedges and linear tets are the degenerate quads and bricks of ANSYS. Each beam has an
orientation node of its own behind the model's nodes: it lies along the section's z axis, in the element's x-z plane.
Read it with CDREAD,DB.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.mass import section_axes
from kernel.connect.model import Mpc, Property, Rbe2, Rbe3
from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import ascii_text, header_lines, set_name, set_names
from kernel.deck.numbers import free_field
from kernel.errors import DeckError

if TYPE_CHECKING:
    from kernel.connect.model import Model
    from kernel.mesh.mesh import ElementBlock

Array = NDArray[np.float64]

LABELS = ("UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ")

# ANSYS element, key options, and our places of its nodes in its order (repeated where it is degenerate)
_TYPES: dict[str, tuple[int, tuple[tuple[int, int], ...], tuple[int, ...]]] = {
    "line2": (188, ((3, 3),), (0, 1)),
    "line3": (189, (), (0, 1, 2)),
    "tri3": (181, ((3, 2),), (0, 1, 2, 2)),
    "quad4": (181, ((3, 2),), (0, 1, 2, 3)),
    "tri6": (281, (), (0, 1, 2, 2, 3, 4, 2, 5)),
    "quad8": (281, (), (0, 1, 2, 3, 4, 5, 6, 7)),
    "tet4": (185, ((2, 2),), (0, 1, 2, 2, 3, 3, 3, 3)),
    "wedge6": (185, ((2, 2),), (0, 1, 2, 2, 3, 4, 5, 5)),
    "hex8": (185, ((2, 2),), (0, 1, 2, 3, 4, 5, 6, 7)),
    "tet10": (187, (), (0, 1, 2, 3, 4, 5, 6, 7, 8, 9)),
    "wedge15": (186, (), (0, 1, 2, 2, 3, 4, 5, 5, 6, 7, 2, 8, 9, 10, 5, 11, 12, 13, 14, 14)),
    "hex20": (186, (), (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 18, 19)),
}


def write(model: Model) -> bytes:
    """The archive, complete but for supports and loads."""
    kinds = [kind for kind in _TYPES if any(block.kind == kind for block in model.mesh.blocks)]
    materials = list(dict.fromkeys((element.material, element.density_factor) for element in model.properties))
    lines = [f"/COM,{line}"[:75] for line in header_lines(model, "ANSYS blocked archive")]
    lines += ["/PREP7", "/NOPR", f"/TITLE,{ascii_text(model.title)[:65]}"]
    for number, kind in enumerate(kinds, start=1):
        ansys_type, options, _ = _TYPES[kind]
        lines.append(f"ET,{number},{ansys_type}")
        lines += [f"KEYOPT,{number},{key},{value}" for key, value in options]
    for number, (name, factor) in enumerate(materials, start=1):
        material = model.materials[name]
        lines.append(f"MP,EX,{number},{free_field(material.elastic_modulus)}")
        lines.append(f"MP,NUXY,{number},{free_field(material.poisson_ratio)}")
        lines.append(f"MP,DENS,{number},{free_field(material.density * factor)}")
    for number, element in enumerate(model.properties, start=1):
        lines += _section(element, number)
    orientation = _orientation_nodes(model)
    lines += _nodes(np.vstack([model.mesh.nodes, orientation]))
    lines += _elements(model, kinds, materials)
    lines += _components(model)
    lines += _couplings(model)
    lines += ["/GO", "FINISH"]
    return ("\n".join(lines) + "\n").encode("ascii")


def _section(element: Property, number: int) -> Iterator[str]:
    name = set_name(element.segment, 8)
    if element.kind == "shell":
        assert element.thickness is not None
        yield f"SECTYPE,{number},SHELL,,{name}"
        yield f"SECDATA,{free_field(element.thickness)},1"
    elif element.kind == "beam":
        section = element.section
        assert section is not None
        # A, Iyy, Iyz, Izz, Iw, J, centroid y z, shear centre y z: our axes are BEAM188's
        values = (section.area, section.iyy, section.iyz, section.izz, 0.0, section.j, 0.0, 0.0, *section.shear_centre)
        yield f"SECTYPE,{number},BEAM,ASEC,{name}"
        yield "SECDATA," + ",".join(free_field(float(f"{value:.12g}")) for value in values)


def _orientation_nodes(model: Model) -> Array:
    """(n_line, 3): one node for each line element, off its first node along the section's z axis by its length."""
    found = [np.empty((0, 3))]
    for block in model.mesh.blocks:
        if block.orientation is not None:
            found.append(orientation_places(block, model.mesh.nodes))
    return np.vstack(found)


def orientation_places(block: ElementBlock, nodes: Array) -> Array:
    """(n_element, 3) places in the x-z plane of each line element."""
    assert block.orientation is not None
    start, end = nodes[block.connectivity[:, 0]], nodes[block.connectivity[:, 1]]
    _, z = section_axes(start, end, block.orientation)
    places: Array = start + z * np.linalg.norm(end - start, axis=1, keepdims=True)
    return places


def _nodes(places: Array) -> Iterator[str]:
    yield f"NBLOCK,6,SOLID,{len(places)},{len(places)}"
    yield "(3i9,6e21.13e3)"
    for number, place in enumerate(places.tolist(), start=1):
        yield f"{number:9d}{0:9d}{0:9d}" + "".join(_exponent3(value) for value in place)
    yield "N,R5.3,LOC,       -1,"


def _exponent3(value: float) -> str:
    """Fortran's e21.13e3: three digits of exponent."""
    if not math.isfinite(value):
        raise DeckError(f"the number {value} cannot be written, expected a finite one")
    mantissa, exponent = f"{value + 0.0:.13E}".split("E")
    return f"{mantissa}E{exponent[0]}{exponent[1:].zfill(3)}".rjust(21)


def _elements(model: Model, kinds: list[str], materials: list[tuple[str, float]]) -> Iterator[str]:
    total = sum(model.mesh.count().values())
    yield f"EBLOCK,19,SOLID,{total},{total}"
    yield "(19i9)"
    numbers = {element.segment: number for number, element in enumerate(model.properties, start=1)}
    material_numbers = {key: number for number, key in enumerate(materials, start=1)}
    orientation = model.mesh.n_node + 1
    element_number = 1
    for block in model.mesh.blocks:
        element = model.properties[numbers[block.segment] - 1]
        material = material_numbers[(element.material, element.density_factor)]
        order = list(_TYPES[block.kind][2])
        section = 1 if element.kind == "solid" else numbers[block.segment]
        for row in (block.connectivity[:, order] + 1).tolist():
            nodes = row
            if block.orientation is not None:
                nodes = [*row, orientation]
                orientation += 1
            head = [material, kinds.index(block.kind) + 1, 1, section, 0, 0, 0, 0, len(nodes), 0, element_number]
            fields = head + nodes
            for start in range(0, len(fields), 19):
                yield "".join(f"{field:9d}" for field in fields[start : start + 19])
            element_number += 1
    yield f"{-1:9d}"


def _components(model: Model) -> Iterator[str]:
    """CMBLOCK of elements (NAME_E) and nodes (NAME_N) of each set; runs as (first, -last)."""
    names = set_names([named.name for named in model.sets], 30)
    for named, name in zip(model.sets, names):
        for ending, kind, ids in (("_E", "ELEM", named.elements + 1), ("_N", "NODE", named.nodes + 1)):
            if not len(ids):
                continue
            items = _runs(np.sort(ids))
            yield f"CMBLOCK,{name + ending},{kind},{len(items):8d}"
            yield "(8i10)"
            for start in range(0, len(items), 8):
                yield "".join(f"{item:10d}" for item in items[start : start + 8])


def _runs(ids: NDArray[np.int64]) -> list[int]:
    items: list[int] = []
    for run in np.split(ids, np.flatnonzero(np.diff(ids) != 1) + 1):
        items += [int(run[0])] if len(run) == 1 else [int(run[0]), -int(run[-1])]
    return items


def _couplings(model: Model) -> Iterator[str]:
    for number, coupling in enumerate(model.couplings, start=1):
        if isinstance(coupling, Rbe2):
            label = "ALL" if len(coupling.components) == 6 else "UXYZ"
            for node in coupling.dependent.tolist():
                yield f"CERIG,{coupling.independent + 1},{node + 1},{label}"
        elif isinstance(coupling, Rbe3):
            yield from _rbe3(coupling, number)
        else:
            yield from constraint_equation(coupling)


def _rbe3(coupling: Rbe3, number: int) -> Iterator[str]:
    """Weights in an array parameter, in the order of the selected nodes' numbers."""
    order = np.argsort(coupling.independent)
    weights = (coupling.weights / coupling.weights.mean())[order].tolist()
    yield f"*DIM,WT{number},ARRAY,{len(order)}"
    for position, weight in enumerate(weights, start=1):
        yield f"WT{number}({position})={free_field(float(f'{weight:.12g}'))}"
    select = "S"
    for node in coupling.independent[order].tolist():
        yield f"NSEL,{select},NODE,,{node + 1}"
        select = "A"
    label = "ALL" if len(coupling.components) == 6 else "UXYZ"
    yield f"RBE3,{coupling.dependent + 1},{label},ALL,WT{number}"
    yield "ALLSEL"


def constraint_equation(coupling: Mpc) -> Iterator[str]:
    """CE, the dependent term first, three terms a command; HIGH is the equation that the last command was about."""
    terms = [
        f"{node + 1},{LABELS[component - 1]},{free_field(float(f'{value:.12g}'))}"
        for node, component, value in zip(
            coupling.nodes.tolist(), coupling.components.tolist(), coupling.coefficients.tolist()
        )
    ]
    for start in range(0, len(terms), 3):
        yield f"CE,{'NEXT' if start == 0 else 'HIGH'},0,{','.join(terms[start : start + 3])}"


register(DeckFormat("ansys", "ANSYS blocked archive", (".cdb",), "text/plain", write))
