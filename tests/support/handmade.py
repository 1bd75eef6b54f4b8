"""Small models made by hand, one mesh at a time: what the tests of connecting and writing stand on."""

from __future__ import annotations

import numpy as np
from shapely import Polygon, box

from kernel.connect.model import Model, NamedSet, Property
from kernel.idealise.section import section_properties
from kernel.materials import named_material
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.units import unit_set

STEEL = named_material("steel", unit_set("mm"))


def model_of(nodes, blocks, properties, couplings=(), sets=(), units="mm", materials=(STEEL,)) -> Model:
    return Model(
        title="handmade",
        units=units,
        rule_base="none 0",
        mesh=Mesh(np.asarray(nodes, dtype=float), tuple(blocks)),
        properties=tuple(properties),
        materials={material.name: material for material in materials},
        couplings=tuple(couplings),
        sets=tuple(sets),
    )


def beam_property(segment: str, outline: Polygon) -> Property:
    return Property(segment, "beam", "steel", section=section_properties(outline))


def line_block(segment: str, nodes, orientation, kind="line2") -> ElementBlock:
    """A chain of lines through the node numbers given."""
    step = ELEMENT_KINDS[kind].n_node - 1
    nodes = list(nodes)
    rows = [nodes[k : k + step + 1] for k in range(0, len(nodes) - 1, step)]
    if step == 2:
        rows = [[a, b, m] for a, m, b in rows]
    count = len(rows)
    return ElementBlock(segment, kind, np.array(rows), np.tile(np.asarray(orientation, float), (count, 1)))


def cantilever(outline: Polygon, length: float, count: int = 10, kind: str = "line2") -> Model:
    """Along x from the origin; y of the section is global y."""
    n = count * (ELEMENT_KINDS[kind].n_node - 1) + 1
    nodes = np.zeros((n, 3))
    nodes[:, 0] = np.linspace(0, length, n)
    return model_of(nodes, [line_block("s1", range(n), (0, 1, 0), kind)], [beam_property("s1", outline)])


def i_outline(width=100.0, height=100.0, web=6.0, flange=8.0) -> Polygon:
    top, bottom = box(0, height - flange, width, height), box(0, 0, width, flange)
    return top | bottom | box((width - web) / 2, 0, (width + web) / 2, height)


def channel_outline(width=50.0, height=100.0, web=6.0, flange=8.0) -> Polygon:
    return box(0, 0, width, height) - box(web, flange, width + 1, height - flange)


def grid(corner, along, across, n, m) -> tuple[np.ndarray, np.ndarray]:
    """(n+1)(m+1) nodes and n m quads of a parallelogram."""
    corner, along, across = (np.asarray(v, float) for v in (corner, along, across))
    s, t = np.meshgrid(np.arange(n + 1) / n, np.arange(m + 1) / m, indexing="ij")
    nodes = corner + s.ravel()[:, None] * along + t.ravel()[:, None] * across
    index = np.arange((n + 1) * (m + 1)).reshape(n + 1, m + 1)
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    return nodes, quads


def brick(size, divisions) -> tuple[np.ndarray, np.ndarray]:
    """Nodes and hex8 of a block in the positive octant."""
    n, m, k = divisions
    axes = [np.linspace(0, extent, count + 1) for extent, count in zip(size, divisions)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    i = np.arange((n + 1) * (m + 1) * (k + 1)).reshape(n + 1, m + 1, k + 1)
    low = [i[:-1, :-1, :-1], i[1:, :-1, :-1], i[1:, 1:, :-1], i[:-1, 1:, :-1]]
    high = [i[:-1, :-1, 1:], i[1:, :-1, 1:], i[1:, 1:, 1:], i[:-1, 1:, 1:]]
    return nodes, np.stack([*low, *high], axis=-1).reshape(-1, 8)


_TETS = ((0, 1, 3, 4), (1, 2, 3, 6), (1, 3, 4, 6), (1, 4, 5, 6), (3, 4, 6, 7))
"""A hex in five tets; neighbours only fit when mirrored, so a single hex or a chain mirrored along it."""

_SIX_TETS = ((0, 1, 2, 6), (0, 2, 3, 6), (0, 3, 7, 6), (0, 7, 4, 6), (0, 4, 5, 6), (0, 5, 1, 6))


def tets_of(hexes: np.ndarray) -> np.ndarray:
    """Six tets about the diagonal 0-6: they fit from hex to hex."""
    return np.concatenate([hexes[:, list(tet)] for tet in _SIX_TETS])


def wedges_of(hexes: np.ndarray) -> np.ndarray:
    return np.concatenate([hexes[:, [0, 1, 2, 4, 5, 6]], hexes[:, [0, 2, 3, 4, 6, 7]]])


def second_order(nodes: np.ndarray, kind: str, connectivity: np.ndarray) -> tuple[np.ndarray, str, np.ndarray]:
    """Straight mid-side nodes."""
    from kernel.mesh.elements import SECOND_ORDER

    edges = np.concatenate([np.sort(connectivity[:, list(e)], axis=1) for e in ELEMENT_KINDS[kind].edges])
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    middle = nodes[unique].mean(axis=1)
    extra = len(nodes) + index.reshape(len(ELEMENT_KINDS[kind].edges), -1).T
    return np.vstack([nodes, middle]), SECOND_ORDER[kind], np.hstack([connectivity, extra])


def solid_cantilever(kind: str, size=(100.0, 10.0, 10.0), divisions=(20, 4, 4)) -> Model:
    nodes, hexes = brick(size, divisions)
    name = {"tet10": "tet4", "wedge15": "wedge6", "hex20": "hex8"}.get(kind, kind)
    cells = {"hex8": hexes, "tet4": tets_of(hexes), "wedge6": wedges_of(hexes)}[name]
    if name != kind:
        nodes, kind, cells = second_order(nodes, name, cells)
    return model_of(nodes, [ElementBlock("s1", kind, cells)], [Property("s1", "solid", "steel")])


def shell_cantilever(kind: str, length=100.0, width=10.0, thickness=2.0, divisions=(20, 2)) -> Model:
    nodes, quads = grid((0, 0, 0), (length, 0, 0), (0, width, 0), *divisions)
    name = {"tri6": "tri3", "quad8": "quad4"}.get(kind, kind)
    cells = quads if name == "quad4" else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    if name != kind:
        nodes, kind, cells = second_order(nodes, name, cells)
    return model_of(nodes, [ElementBlock("s1", kind, cells)], [Property("s1", "shell", "steel", thickness=thickness)])


def whole_set(model: Model, name: str) -> NamedSet:
    count = sum(len(block.connectivity) for block in model.mesh.blocks)
    return NamedSet(name, np.arange(model.mesh.n_node), np.arange(count))
