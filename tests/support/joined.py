"""Joined models made by hand: half beam and half solid, a post on a plate, a block on a plate, a lap."""

from __future__ import annotations

import numpy as np
from handmade import beam_property, brick, grid, line_block, model_of
from shapely import box

from kernel.connect.couplings import make_couplings
from kernel.connect.model import Model, Property
from kernel.mesh.assembly import Tie
from kernel.mesh.mesh import ElementBlock, Mesh


def coupled(nodes, blocks, properties, ties, kind="distributing") -> Model:
    mesh = Mesh(np.asarray(nodes, float), tuple(blocks))
    sections = {element.segment: element.section for element in properties if element.section is not None}
    couplings = make_couplings(ties, mesh, mesh.nodes, kind, sections).couplings
    return model_of(nodes, blocks, properties, couplings)


def tributary(nodes: np.ndarray, cells: np.ndarray, count: int) -> np.ndarray:
    """Area of flat quads shared out to their nodes: (count,)."""
    diagonal = np.cross(nodes[cells[:, 2]] - nodes[cells[:, 0]], nodes[cells[:, 3]] - nodes[cells[:, 1]])
    area = np.linalg.norm(diagonal, axis=1) / 2
    return np.bincount(cells.ravel(), np.repeat(area / 4, 4), minlength=count)


def half_beam_half_solid(kind: str, size=(200.0, 20.0, 30.0), divisions=(40, 4, 6)) -> Model:
    """A cantilever along x: solid to the middle, then a beam. The last node is the tip."""
    nodes, hexes = brick((size[0] / 2, *size[1:]), (divisions[0] // 2, *divisions[1:]))
    n = len(nodes)
    face = hexes[np.isclose(nodes[hexes[:, 1], 0], size[0] / 2)][:, [1, 2, 6, 5]]
    weights = tributary(nodes, face, n)
    patch = np.flatnonzero(weights)
    beam = np.column_stack([np.linspace(size[0] / 2, size[0], 11), np.full(11, size[1] / 2), np.full(11, size[2] / 2)])
    return coupled(
        np.vstack([nodes, beam]),
        [ElementBlock("s1", "hex8", hexes), line_block("s2", range(n, n + 11), (0, 1, 0))],
        [Property("s1", "solid", "steel"), beam_property("s2", box(0, 0, size[1], size[2]))],
        [Tie("beam_on_face", None, np.array([n]), patch, weights[patch])],
        kind,
    )


def post_on_plate(kind: str = "distributing") -> Model:
    """A plate of 100 x 100 x 5 in z = 0 with a post of 20 x 20 in its middle, 50 high, from its upper face."""
    nodes, quads = grid((0, 0, 0), (100, 0, 0), (0, 100, 0), 10, 10)
    n = len(nodes)
    inside = np.flatnonzero((np.abs(nodes - [50, 50, 0]) < 10.1).all(axis=1))
    foot = quads[np.isin(quads, inside).all(axis=1)]
    weights = tributary(nodes, foot, n)
    post = np.column_stack([np.full(6, 50.0), np.full(6, 50.0), 2.5 + np.linspace(0, 50, 6)])
    return coupled(
        np.vstack([nodes, post]),
        [ElementBlock("s1", "quad4", quads), line_block("s2", range(n, n + 6), (1, 0, 0))],
        [Property("s1", "shell", "steel", thickness=5.0), beam_property("s2", box(0, 0, 20, 20))],
        [Tie("beam_on_face", None, np.array([n]), inside, weights[inside])],
        kind,
    )


def block_on_plate() -> Model:
    """The same plate with a block of 20 x 20 x 30 on it, meshed on the very quads of its foot."""
    nodes, quads = grid((0, 0, 0), (100, 0, 0), (0, 100, 0), 10, 10)
    n = len(nodes)
    inside = np.flatnonzero((np.abs(nodes - [50, 50, 0]) < 10.1).all(axis=1))
    block, hexes = brick((20, 20, 30), (2, 2, 3))
    block = block + [40, 40, 2.5]
    base = np.flatnonzero(block[:, 2] == 2.5)
    order = np.lexsort((block[base, 1], block[base, 0]))
    ground = inside[np.lexsort((nodes[inside, 1], nodes[inside, 0]))]
    return coupled(
        np.vstack([nodes, block]),
        [ElementBlock("s1", "quad4", quads), ElementBlock("s2", "hex8", hexes + n)],
        [Property("s1", "shell", "steel", thickness=5.0), Property("s2", "solid", "steel")],
        [Tie("rigid_pairs", None, base[order] + n, ground, has_rotations=False)],
    )


def lap_of_plates() -> Model:
    """Two plates of 4 mm, one on the other over 40 x 40, their meshes unlike each other; clamped end at x = 0."""
    lower, quads = grid((0, 0, 0), (100, 0, 0), (0, 40, 0), 10, 4)
    upper, more = grid((60, 0, 4), (100, 0, 0), (0, 40, 0), 15, 5)
    n = len(lower)
    dependents, hosts, weights = [], [], []
    for k, (x, y, _) in enumerate(upper):
        if x > 100 + 1e-9:
            continue
        a, b = min(int(x // 10), 9), min(int(y // 10), 3)
        s, t = x / 10 - a, y / 10 - b
        dependents.append(n + k)
        hosts.append(quads[a * 4 + b])
        weights.append(np.array([(1 - s) * (1 - t), s * (1 - t), s * t, (1 - s) * t]))
    return coupled(
        np.vstack([lower, upper]),
        [ElementBlock("s1", "quad4", quads), ElementBlock("s2", "quad4", more + n)],
        [Property("s1", "shell", "steel", thickness=4.0), Property("s2", "shell", "steel", thickness=4.0)],
        [Tie("interpolated", None, np.array(dependents), hosts=tuple(hosts), host_weights=tuple(weights))],
    )
