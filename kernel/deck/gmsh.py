"""Gmsh MSH 4.1, ASCII: entities by segment, physical groups from the segments and from named CSG nodes.

An entity holds the elements of one segment and dimension; each segment and each named CSG node is a physical group
of the entities inside it. Couplings are no elements: they stand in the $Comments section's counts only.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import header_lines, printable
from kernel.deck.numbers import free_field
from kernel.mesh.elements import ELEMENT_KINDS

if TYPE_CHECKING:
    from kernel.connect.model import Model

# MSH type, and our place of each node that Gmsh lists, in Gmsh's order (Gmsh reference manual, "Node ordering")
_TYPES: dict[str, tuple[int, tuple[int, ...]]] = {
    "line2": (1, (0, 1)),
    "line3": (8, (0, 1, 2)),
    "tri3": (2, (0, 1, 2)),
    "tri6": (9, (0, 1, 2, 3, 4, 5)),
    "quad4": (3, (0, 1, 2, 3)),
    "quad8": (16, (0, 1, 2, 3, 4, 5, 6, 7)),
    "tet4": (4, (0, 1, 2, 3)),
    "tet10": (11, (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)),
    "wedge6": (6, (0, 1, 2, 3, 4, 5)),
    "wedge15": (18, (0, 1, 2, 3, 4, 5, 6, 8, 12, 7, 13, 14, 9, 11, 10)),
    "hex8": (5, (0, 1, 2, 3, 4, 5, 6, 7)),
    "hex20": (17, (0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14)),
}


def write(model: Model) -> bytes:
    """The mesh with its groups."""
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$Comments", *header_lines(model, "Gmsh MSH 4.1")]
    lines += ["$EndComments", *_sections(model)]
    return ("\n".join(lines) + "\n").encode()


def _sections(model: Model) -> Iterator[str]:
    segments = list(dict.fromkeys(block.segment for block in model.mesh.blocks))
    entity = {segment: number for number, segment in enumerate(segments, start=1)}
    dimension = {block.segment: ELEMENT_KINDS[block.kind].dimension for block in model.mesh.blocks}
    groups = _groups(model, entity, dimension)
    yield "$PhysicalNames"
    yield str(len(groups))
    for number, (name, group_dimension, _) in enumerate(groups, start=1):
        yield f'{group_dimension} {number} "{name}"'
    yield "$EndPhysicalNames"
    yield from _entities(model, segments, entity, dimension, groups)
    yield from _nodes(model, entity, dimension)
    yield from _elements(model, entity, dimension)


def _groups(model: Model, entity: dict[str, int], dimension: dict[str, int]) -> list[tuple[str, int, list[int]]]:
    """(name, dimension, entities): a set that holds several dimensions becomes a group in each."""
    counts = [len(block.connectivity) for block in model.mesh.blocks]
    owner = np.repeat([entity[block.segment] for block in model.mesh.blocks], counts)
    size = np.bincount(owner, minlength=len(entity) + 1)
    segment_of = {number: segment for segment, number in entity.items()}
    groups = []
    for named in model.sets:
        inside, count = np.unique(owner[named.elements], return_counts=True)
        held = inside[count == size[inside]].tolist()
        name = printable(named.name).replace('"', "'")
        by_dimension: dict[int, list[int]] = {}
        for number in held:
            by_dimension.setdefault(dimension[segment_of[number]], []).append(number)
        groups += [(name, d, by_dimension[d]) for d in sorted(by_dimension)]
    return groups


def _entities(
    model: Model,
    segments: list[str],
    entity: dict[str, int],
    dimension: dict[str, int],
    groups: list[tuple[str, int, list[int]]],
) -> Iterator[str]:
    counts = [sum(dimension[segment] == d for segment in segments) for d in range(4)]
    tags: dict[int, list[int]] = {}
    for number, (_, _, members) in enumerate(groups, start=1):
        for member in members:
            tags.setdefault(member, []).append(number)
    used: dict[str, list[NDArray[np.int64]]] = {}
    for block in model.mesh.blocks:
        used.setdefault(block.segment, []).append(block.connectivity.ravel())
    yield "$Entities"
    yield " ".join(map(str, counts))
    for d in (1, 2, 3):
        for segment in segments:
            if dimension[segment] != d:
                continue
            box = model.mesh.nodes[np.concatenate(used[segment])]
            bounds = " ".join(free_field(x) for x in [*box.min(axis=0), *box.max(axis=0)])
            own = tags.get(entity[segment], [])
            yield f"{entity[segment]} {bounds} {len(own)}{''.join(f' {tag}' for tag in own)} 0"
    yield "$EndEntities"


def _nodes(model: Model, entity: dict[str, int], dimension: dict[str, int]) -> Iterator[str]:
    """Each node stands with the first segment that uses it; nodes of no element with the last."""
    names = list(entity)
    owner = np.full(model.mesh.n_node, len(names))
    for block in reversed(model.mesh.blocks):
        owner[block.connectivity.ravel()] = entity[block.segment]
    order = np.argsort(owner, kind="stable")
    ends = np.searchsorted(owner[order], np.arange(1, len(names) + 2))
    held = [order[ends[k] : ends[k + 1]] for k in range(len(names))]
    full = [(name, nodes) for name, nodes in zip(names, held) if len(nodes)]
    yield "$Nodes"
    yield f"{len(full)} {model.mesh.n_node} 1 {model.mesh.n_node}"
    for name, nodes in full:
        yield f"{dimension[name]} {entity[name]} 0 {len(nodes)}"
        yield from map(str, (nodes + 1).tolist())
        for place in model.mesh.nodes[nodes].tolist():
            yield " ".join(map(free_field, place))
    yield "$EndNodes"


def _elements(model: Model, entity: dict[str, int], dimension: dict[str, int]) -> Iterator[str]:
    total = sum(len(block.connectivity) for block in model.mesh.blocks)
    yield "$Elements"
    yield f"{len(model.mesh.blocks)} {total} 1 {total}"
    number = 1
    for block in model.mesh.blocks:
        code, order = _TYPES[block.kind]
        yield f"{dimension[block.segment]} {entity[block.segment]} {code} {len(block.connectivity)}"
        for row in (block.connectivity[:, list(order)] + 1).tolist():
            yield f"{number} {' '.join(map(str, row))}"
            number += 1
    yield "$EndElements"


register(DeckFormat("gmsh", "Gmsh 4.1", (".msh",), "text/plain", write))
