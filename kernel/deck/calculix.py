"""CalculiX (ccx) input.

Beams are B32R, a middle node added where ours have two: their sections are rectangles, circles, tubes and boxes of one
web and one flange thickness. ccx knows no others (SECTION=GENERAL needs the user element U1), so they are refused.
Couplings are written as equations. A node of a beam or shell has rotations in ccx only where it is a knot, so each
node whose rotations stand in an equation gets a short weightless beam to make it one (sets KNOTS and KNOT_NODES).
Quadratic shells and bricks are the reduced ones (S8R, C3D20R), which do not lock.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.equations import Expression, Freedom, rows
from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import header_lines
from kernel.deck.keywords import (
    OWN_MATERIAL,
    Group,
    comment_lines,
    element_lines,
    groups,
    material_lines,
    material_names,
    node_lines,
    real,
    set_lines,
    wrapped,
)
from kernel.errors import DeckError
from kernel.idealise.profiles import profile_directions
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.units import UNIT_SETS

if TYPE_CHECKING:
    from kernel.connect.model import Model

Array = NDArray[np.float64]

# our node orders are CalculiX's
_TYPES = {
    "line2": "B32R", "line3": "B32R", "tri3": "S3", "tri6": "S6", "quad4": "S4", "quad8": "S8R",
    "tet4": "C3D4", "tet10": "C3D10", "wedge6": "C3D6", "wedge15": "C3D15", "hex8": "C3D8I", "hex20": "C3D20R",
}  # fmt: skip

KNOT_LENGTH = 1e-3
"""Length of a knot's beam, of the model's size."""

WORTH_A_NOTE = 0.01
"""A beam that ccx makes stiffer than this is named in the deck's head."""

MANY_KNOTS = 0.5
"""A beam with more than this share of its nodes knots, and with more than two of them, is named as well."""


def write(model: Model) -> bytes:
    """The deck, complete but for supports, loads and steps; DeckError for a beam section that ccx does not know."""
    return assemble_deck(model, ["** supports and steps go here"])


def calculix_self_weight(model: Model, supports: Sequence[int], direction: Sequence[float] = (0, 0, -1)) -> bytes:
    """The deck under its own weight; nodes `supports` (indices) held in all the freedoms that they have."""
    turning = np.zeros(model.mesh.n_node, dtype=bool)
    for block in model.mesh.blocks:
        if ELEMENT_KINDS[block.kind].dimension < 3:
            turning[block.connectivity.ravel()] = True
    gravity = UNIT_SETS[model.units].gravity
    lines = ["*NSET, NSET=HELD", *wrapped([node + 1 for node in sorted(supports)]), "*BOUNDARY"]
    lines += [f"{node + 1}, 1, {6 if turning[node] else 3}" for node in sorted(supports)]
    lines += ["*STEP", "*STATIC", "*DLOAD", f"EALL, GRAV, {real(gravity)}, {', '.join(map(real, direction))}"]
    lines += ["*NODE PRINT, NSET=NALL", "U", "*NODE PRINT, NSET=HELD, TOTALS=ONLY", "RF", "*END STEP"]
    return assemble_deck(model, lines)


def assemble_deck(model: Model, lines: Sequence[str]) -> bytes:
    """The deck, then lines of one's own: supports, steps. Node numbers are index + 1; the set EALL is all elements."""
    return ("\n".join([*_deck(model), *lines]) + "\n").encode("ascii")


def _deck(model: Model) -> list[str]:
    parts = groups(model)
    for part in parts:
        if part.element.kind == "beam":
            _section_data(part)  # refuse before anything is written
    lines = comment_lines(header_lines(model, "CalculiX input"))
    if any(part.block.kind == "tri3" for part in parts):
        lines += comment_lines(
            ["note: ccx makes wedges of triangles (S3), too stiff in bending: quads or order 2 are better"]
        )
    equations = [row for coupling in model.couplings for row in rows(coupling, model.mesh.nodes)]
    knots = _turning(equations)
    lines += comment_lines([*_notes_on_beams(model, parts), *_notes_on_knots(parts, knots)])
    lines += ["*NODE, NSET=NALL", *node_lines(model.mesh.nodes)]
    n_node = model.mesh.n_node
    for part in parts:
        numbers = (part.first + part.rows).tolist()
        nodes = part.block.connectivity[part.rows] + 1
        if part.block.kind == "line2":
            places = model.mesh.nodes[part.block.connectivity[part.rows]].mean(axis=1)
            lines += ["*NODE, NSET=BEAM_MIDDLES", *node_lines(places, n_node + 1)]
            nodes = np.column_stack([nodes[:, 0], n_node + 1 + np.arange(len(nodes)), nodes[:, 1]])
            n_node += len(nodes)
        elif part.block.kind == "line3":
            nodes = nodes[:, [0, 2, 1]]
        lines.append(f"*ELEMENT, TYPE={_type(part)}, ELSET={part.name}")
        lines += element_lines(numbers, nodes.tolist())
    lines.append("*ELSET, ELSET=EALL")
    lines += wrapped([part.name for part in parts], 1)
    lines += set_lines(model, parts)
    lines += material_lines(model)
    names = material_names(model)
    for part in parts:
        lines += _section(part, names[(part.element.material, part.element.density_factor)])
    lines += _couplings(model, equations, knots, n_node)
    return lines


def _notes_on_beams(model: Model, parts: Sequence[Group]) -> Iterator[str]:
    """A line for each beam that comes out noticeably stiff: ccx's beams are bricks inside, sheared over all their area.

    A hollow section's true shear area is its webs'. The share is that of a cantilever's tip deflection,
    F L^3 / 3 E I + F L / G A_s, the direction in which it is larger.
    """
    for part in parts:
        section = part.element.section
        if section is None:
            continue
        ends = model.mesh.nodes[part.block.connectivity[part.rows, :2].ravel()]
        length = float(np.linalg.norm(np.ptp(ends, axis=0)))
        material = model.materials[part.element.material]
        shear_modulus = material.elastic_modulus / 2 / (1 + material.poisson_ratio)
        stiffer = 0.0
        for second, area in ((section.iyy, section.shear_area_z), (section.izz, section.shear_area_y)):
            shear = length / (shear_modulus * area)
            tip = length**3 / (3 * material.elastic_modulus * second) + shear
            stiffer = max(stiffer, shear * (1 - area / section.area) / tip)
        if stiffer > WORTH_A_NOTE:
            yield (
                f"note: ccx shears beams over their whole area, which alone makes {part.element.segment} {stiffer:.1%} "
                "too stiff as a cantilever: plates or bricks are better"
            )


def _notes_on_knots(parts: Sequence[Group], knots: Sequence[int]) -> Iterator[str]:
    """A line for each beam most of whose nodes are knots, as where it lies along a plate.

    A knot keeps its section from contracting: the beam is as stiff there as one that is held on all sides.
    """
    for part in parts:
        if part.element.section is None:
            continue
        nodes = np.unique(part.block.connectivity[part.rows, :2])
        held = np.isin(nodes, knots).sum()
        if held > max(2, MANY_KNOTS * len(nodes)):
            yield (
                f"note: {held} of the {len(nodes)} nodes of {part.element.segment} are knots: it is tied all along. "
                "ccx makes such beams too stiff, more so with smaller elements: plates or bricks are better"
            )


def _type(part: Group) -> str:
    """Circles bend best as B32 (the section is a hex8 between its corners: 1.2 % short of area)."""
    section = part.element.section
    return "B32" if section is not None and section.shape == "circle" else _TYPES[part.block.kind]


def _section(part: Group, material: str) -> Iterator[str]:
    if part.element.kind == "solid":
        yield f"*SOLID SECTION, ELSET={part.name}, MATERIAL={material}"
    elif part.element.kind == "shell":
        assert part.element.thickness is not None
        yield f"*SHELL SECTION, ELSET={part.name}, MATERIAL={material}"
        yield real(part.element.thickness)
    else:
        shape, data, direction = _section_data(part)
        yield f"*BEAM SECTION, ELSET={part.name}, MATERIAL={material}, SECTION={shape}"
        yield ", ".join(map(real, data))
        yield ", ".join(map(real, direction))


def _section_data(part: Group) -> tuple[str, list[float], Array]:
    """ccx's shape, its sizes and the 1-direction (along the profile's width)."""
    section = part.element.section
    assert section is not None and part.axes is not None
    size = section.dimensions
    y, z = part.axes
    if section.shape == "circle":
        return "CIRC", [2 * size["radius"]] * 2, y  # diameters, whatever the manual calls them
    if section.shape == "tube":
        return "PIPE", [size["radius"], size["radius"] - size["inner_radius"]], y
    if section.shape not in ("rectangle", "box"):
        raise DeckError(
            f"segment {part.element.segment}: CalculiX's beams are rectangles, circles, tubes and boxes, not "
            f"{section.shape} sections; expected another format, or the segment overridden to plates or brick"
        )
    width, _ = profile_directions(section.outline)
    direction = width[0] * y + width[1] * z
    if section.shape == "rectangle":
        return "RECT", [size["width"], size["height"]], direction
    web, flange = size["web"], size["flange"]
    return "BOX", [size["width"], size["height"], web, flange, web, flange], direction


def _turning(equations: Sequence[tuple[Freedom, Expression]]) -> list[int]:
    """Nodes whose rotations stand in equations, sorted: they need to be knots."""
    turning = {node for (node, component), _ in equations if component > 3}
    return sorted(turning | {node for _, row in equations for (node, component) in row if component > 3})


def _couplings(
    model: Model, equations: Sequence[tuple[Freedom, Expression]], turning: Sequence[int], n_node: int
) -> Iterator[str]:
    """Knots first, then one equation for each dependent freedom."""
    if turning:
        yield from _knots(model, turning, n_node)
    for (node, component), row in equations:
        terms: list[object] = [node + 1, component, "-1."]
        for (other, freedom), value in sorted(row.items()):
            terms += [other + 1, freedom, real(value)]
        yield "*EQUATION"
        yield str(len(terms) // 3)
        yield from wrapped(terms, 12)


def _knots(model: Model, turning: Sequence[int], n_node: int) -> Iterator[str]:
    """A weightless beam of one element at each node, across the beam that may be there."""
    size = float(np.linalg.norm(np.ptp(model.mesh.nodes, axis=0)))
    along = _directions_at(model)
    steps = np.array([_across(along.get(node)) for node in turning]) * (KNOT_LENGTH * size)
    places = model.mesh.nodes[list(turning)]
    first = n_node + 1
    element = sum(model.mesh.count().values()) + 1
    yield "*NODE, NSET=KNOT_NODES"
    yield from node_lines(np.stack([places + steps / 2, places + steps], axis=1).reshape(-1, 3), first)
    yield "*ELEMENT, TYPE=B32R, ELSET=KNOTS"
    ends = [[node + 1, first + 2 * k, first + 2 * k + 1] for k, node in enumerate(turning)]
    yield from element_lines(range(element, element + len(ends)), ends)
    material = next(iter(model.materials.values()))
    yield f"*MATERIAL, NAME={OWN_MATERIAL}"
    yield "*ELASTIC"
    yield f"{real(material.elastic_modulus)}, {real(material.poisson_ratio)}"
    yield "*DENSITY"
    yield "0."
    yield f"*BEAM SECTION, ELSET=KNOTS, MATERIAL={OWN_MATERIAL}, SECTION=RECT"
    yield f"{real(KNOT_LENGTH * size / 2)}, {real(KNOT_LENGTH * size / 2)}"
    yield "0.36, 0.48, 0.8"


def _directions_at(model: Model) -> dict[int, Array]:
    found: dict[int, Array] = {}
    for block in model.mesh.blocks:
        if block.orientation is None:
            continue
        ends = model.mesh.nodes[block.connectivity[:, :2]]
        for row, direction in zip(block.connectivity.tolist(), ends[:, 1] - ends[:, 0]):
            for node in row:
                found.setdefault(node, direction / np.linalg.norm(direction))
    return found


def _across(direction: Array | None) -> Array:
    """A unit vector that is along no axis and across the direction."""
    skew = np.array([0.48, 0.64, -0.6])
    if direction is None:
        return skew
    across = skew - (skew @ direction) * direction
    return across / float(np.linalg.norm(across))


register(DeckFormat("calculix", "CalculiX", (".inp",), "text/plain", write))
