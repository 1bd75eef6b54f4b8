"""What CalculiX and Abaqus input files share: keyword lines, element names, sets, groups by property."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.mass import section_axes
from kernel.deck.header import ascii_text, set_name, set_names
from kernel.deck.numbers import free_field

if TYPE_CHECKING:
    from kernel.connect.model import Model, Property
    from kernel.mesh.mesh import ElementBlock

Array = NDArray[np.float64]

OWN_SETS = ("EALL", "NALL", "HELD", "KNOTS", "KNOT_NODES", "BEAM_MIDDLES")
"""Sets that decks have of their own: no named node or segment may add to them."""

OWN_MATERIAL = "WEIGHTLESS"
"""Of CalculiX's knots."""

NAMES_PER_LINE = 4
"""Of at most sixty characters each: a line of Abaqus ends at 256."""

SAME_ORIENTATION = 1e-9
"""Section axes (unit vectors) whose components differ by less are one beam section."""


@dataclass(frozen=True, slots=True, eq=False)
class Group:
    """Elements of one block that share a section card; first: number of its first element, from 1.

    rows: (n,) positions in the block. axes: the section's y and z, (3,) unit vectors, of beams, else None.
    """

    name: str
    block: ElementBlock
    element: Property
    first: int
    rows: NDArray[np.int64]
    axes: tuple[Array, Array] | None


def groups(model: Model) -> list[Group]:
    """Every block, beams divided by orientation; numbers run over all blocks in order. No two names are the same."""
    by_segment = {element.segment: element for element in model.properties}
    result = []
    first = 1
    for block in model.mesh.blocks:
        element = by_segment[block.segment]
        base = set_name(f"{block.segment}_{block.kind}", 60)
        if block.orientation is None:
            result.append(Group(base, block, element, first, np.arange(len(block.connectivity)), None))
        else:
            ends = model.mesh.nodes[block.connectivity[:, :2]]
            y, z = section_axes(ends[:, 0], ends[:, 1], block.orientation)
            both = np.round(np.hstack([y, z]) / SAME_ORIENTATION).astype(np.int64)
            keys, index = np.unique(both, axis=0, return_inverse=True)
            for number in range(len(keys)):
                rows = np.flatnonzero(index.ravel() == number)
                name = base if len(keys) == 1 else f"{base}_{number + 1}"
                result.append(Group(name, block, element, first, rows, (y[rows[0]], z[rows[0]])))
        first += len(block.connectivity)
    names = set_names([group.name for group in result], 60, OWN_SETS)
    return [replace(group, name=name) for group, name in zip(result, names)]


def node_lines(nodes: Array, first: int = 1) -> Iterator[str]:
    """number, x, y, z."""
    for number, place in enumerate(nodes.tolist(), start=first):
        yield f"{number}, {', '.join(map(real, place))}"


def element_lines(numbers: Sequence[int], rows: Sequence[Sequence[int]]) -> Iterator[str]:
    """number, nodes (from 1); broken after fifteen nodes."""
    for number, row in zip(numbers, rows):
        yield from wrapped([number, *row])


def wrapped(items: Sequence[object], width: int = 16) -> Iterator[str]:
    """Items in lines of at most `width`, all but the last ending with a comma."""
    for start in range(0, len(items), width):
        line = ", ".join(map(str, items[start : start + width]))
        yield line + ("," if start + width < len(items) else "")


def set_lines(model: Model, parts: Sequence[Group]) -> Iterator[str]:
    """ELSET and NSET of every named set, under names that neither the groups nor the deck itself have.

    A set that is written twice is the union of both: elements would get the section of another group.
    """
    couplings = [coupling_set(number) for number in range(1, len(model.couplings) + 1)]
    reserved = [*OWN_SETS, *(part.name for part in parts), *couplings]
    names = set_names([named.name for named in model.sets], 60, reserved)
    for named, name in zip(model.sets, names):
        for kind, ids in (("ELSET", named.elements), ("NSET", named.nodes)):
            if len(ids):
                yield f"*{kind}, {kind}={name}"
                yield from wrapped((ids + 1).tolist())


def coupling_set(number: int) -> str:
    """The name of the set of nodes that a coupling holds."""
    return f"COUPLING_{number}"


def material_names(model: Model) -> dict[tuple[str, float], str]:
    """The name of each material and density factor in use."""
    keys = list(dict.fromkeys((element.material, element.density_factor) for element in model.properties))
    names = set_names([name if factor == 1 else f"{name}_x" for name, factor in keys], 60, [OWN_MATERIAL])
    return dict(zip(keys, names))


def material_lines(model: Model) -> Iterator[str]:
    """MATERIAL, ELASTIC, DENSITY."""
    for (key, factor), name in material_names(model).items():
        material = model.materials[key]
        yield f"*MATERIAL, NAME={name}"
        yield "*ELASTIC"
        yield f"{real(material.elastic_modulus)}, {real(material.poisson_ratio)}"
        yield "*DENSITY"
        yield real(material.density * factor)


def comment_lines(lines: Sequence[str]) -> list[str]:
    """As keyword comments."""
    return [f"** {ascii_text(line)}" for line in lines]


def real(value: float) -> str:
    """A real with a point or an exponent, of at most 20 characters."""
    text = free_field(float(f"{float(value):.13g}"))
    return text if any(c in text for c in ".e") else f"{text}."
