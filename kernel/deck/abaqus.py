"""Abaqus input: any beam section (BEAM GENERAL SECTION), RBE2 as kinematic and RBE3 as distributing couplings.

Written after the Abaqus Keywords Reference; its syntax is CalculiX's relative, but beams and couplings differ.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from kernel.connect.model import Mpc, Rbe2, Rbe3
from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import header_lines
from kernel.deck.keywords import (
    NAMES_PER_LINE,
    Group,
    comment_lines,
    coupling_set,
    element_lines,
    groups,
    material_lines,
    material_names,
    node_lines,
    real,
    set_lines,
    wrapped,
)

if TYPE_CHECKING:
    from kernel.connect.model import Model
    from kernel.materials import Material

# our node orders are Abaqus's, but for the middle node of a beam
_TYPES = {
    "line2": "B31", "line3": "B32", "tri3": "S3", "tri6": "STRI65", "quad4": "S4", "quad8": "S8R",
    "tet4": "C3D4", "tet10": "C3D10", "wedge6": "C3D6", "wedge15": "C3D15", "hex8": "C3D8I", "hex20": "C3D20R",
}  # fmt: skip


def write(model: Model) -> bytes:
    """The deck, complete but for supports, loads and steps."""
    lines = ["*HEADING", header_lines(model, "Abaqus input")[1][:80]]
    lines += comment_lines(header_lines(model, "Abaqus input"))
    lines += ["*NODE, NSET=NALL", *node_lines(model.mesh.nodes)]
    parts = groups(model)
    for part in parts:
        nodes = part.block.connectivity[part.rows] + 1
        if part.block.kind == "line3":
            nodes = nodes[:, [0, 2, 1]]
        lines.append(f"*ELEMENT, TYPE={_TYPES[part.block.kind]}, ELSET={part.name}")
        lines += element_lines((part.first + part.rows).tolist(), nodes.tolist())
    lines.append("*ELSET, ELSET=EALL")
    lines += wrapped([part.name for part in parts], NAMES_PER_LINE)
    lines += set_lines(model, parts)
    lines += material_lines(model)
    names = material_names(model)
    for part in parts:
        material = model.materials[part.element.material]
        lines += _section(part, names[(part.element.material, part.element.density_factor)], material)
    for number, coupling in enumerate(model.couplings, start=1):
        if isinstance(coupling, Rbe2):
            lines += _kinematic(coupling, number)
        elif isinstance(coupling, Rbe3):
            lines += _distributing(coupling, number)
        else:
            lines += _equation(coupling)
    lines.append("** supports and steps go here")
    return ("\n".join(lines) + "\n").encode("ascii")


def _section(part: Group, name: str, material: Material) -> Iterator[str]:
    if part.element.kind == "solid":
        yield f"*SOLID SECTION, ELSET={part.name}, MATERIAL={name}"
        return
    if part.element.kind == "shell":
        assert part.element.thickness is not None
        yield f"*SHELL SECTION, ELSET={part.name}, MATERIAL={name}"
        yield real(part.element.thickness)
        return
    section = part.element.section
    assert section is not None and part.axes is not None
    density = material.density * part.element.density_factor
    yield f"*BEAM GENERAL SECTION, ELSET={part.name}, SECTION=GENERAL, DENSITY={real(density)}"
    # the 1-direction is our y: I11 is about it
    yield ", ".join(map(real, (section.area, section.iyy, section.iyz, section.izz, section.j)))
    yield ", ".join(map(real, part.axes[0]))
    yield f"{real(material.elastic_modulus)}, {real(material.shear_modulus)}"
    if section.shear_centre != (0.0, 0.0):
        yield "*SHEAR CENTER"
        yield ", ".join(map(real, section.shear_centre))
    yield "*TRANSVERSE SHEAR STIFFNESS"
    shear = (material.shear_modulus * section.shear_area_z, material.shear_modulus * section.shear_area_y)
    yield ", ".join(map(real, shear))


def _kinematic(coupling: Rbe2, number: int) -> Iterator[str]:
    yield f"*NSET, NSET={coupling_set(number)}"
    yield from wrapped((coupling.dependent + 1).tolist())
    yield f"*SURFACE, NAME=SURFACE_{number}, TYPE=NODE"
    yield f"{coupling_set(number)}, 1."
    yield f"*COUPLING, CONSTRAINT NAME=RBE2_{number}, REF NODE={coupling.independent + 1}, SURFACE=SURFACE_{number}"
    yield "*KINEMATIC"
    components = sorted(map(int, coupling.components))
    yield f"{components[0]}, {components[-1]}"


def _distributing(coupling: Rbe3, number: int) -> Iterator[str]:
    yield f"*SURFACE, NAME=SURFACE_{number}, TYPE=NODE"
    weights = coupling.weights / coupling.weights.mean()
    for node, weight in zip(coupling.independent.tolist(), weights.tolist()):
        yield f"{node + 1}, {real(weight)}"
    yield f"*COUPLING, CONSTRAINT NAME=RBE3_{number}, REF NODE={coupling.dependent + 1}, SURFACE=SURFACE_{number}"
    yield "*DISTRIBUTING"
    components = sorted(map(int, coupling.components))
    yield f"{components[0]}, {components[-1]}"


def _equation(coupling: Mpc) -> Iterator[str]:
    yield "*EQUATION"
    yield str(len(coupling.nodes))
    terms: list[object] = []
    for node, component, value in zip(coupling.nodes.tolist(), coupling.components.tolist(), coupling.coefficients):
        terms += [node + 1, component, real(float(value))]
    yield from wrapped(terms, 12)


register(DeckFormat("abaqus", "Abaqus", (), "text/plain", write))
