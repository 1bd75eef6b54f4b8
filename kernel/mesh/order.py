"""Second order: mid-side nodes, one per edge, shared by all elements of all segments that have the edge.

A callable puts them on the true curves and surfaces. Where that would turn an element inside out (a coarse element on
a strongly curved face), its mid-side nodes are drawn back towards the straight edges, and the caller is told how many.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kernel.errors import DefectError
from kernel.mesh.elements import ELEMENT_KINDS, SECOND_ORDER
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.shapes import corner_rule, jacobians

Project = Callable[[NDArray[np.float64], NDArray[np.int64]], NDArray[np.float64]]
"""(middles (n, 3) of straight edges, edges (n, 2) as node pairs) -> places (n, 3) of the mid-side nodes."""

LEAST_JACOBIAN = 0.2
"""Smallest Jacobian of a curved element, as a share of its straight one's at the same node."""

DRAWBACKS = (0.5, 0.25, 0.0)
"""Shares of the way to the true surface that are tried in turn."""


def to_second_order(mesh: Mesh, project: Project | None = None) -> Mesh:
    """The mesh with mid-side nodes: appended behind its own nodes, in the order of the edges' sorted node pairs."""
    return curved(mesh, project)[0]


def places_on(edges: NDArray[np.int64], places: NDArray[np.float64]) -> Project:
    """A callable for to_second_order that knows the mid-side nodes of some edges and leaves the others straight.

    edges: (n, 2) node pairs, either way round; places: (n, 3). Where an edge is given twice, the first counts.
    """
    pairs = np.sort(np.asarray(edges, dtype=np.int64).reshape(-1, 2), axis=1)
    known, first = np.unique(pairs, axis=0, return_index=True)
    found = np.asarray(places, dtype=np.float64).reshape(-1, 3)[first]

    def project(middles: NDArray[np.float64], wanted: NDArray[np.int64]) -> NDArray[np.float64]:
        result = middles.copy()
        if not len(known):
            return result
        base = int(max(known.max(), wanted.max(initial=0))) + 1
        keys, own = known[:, 0] * base + known[:, 1], wanted[:, 0] * base + wanted[:, 1]
        place = np.minimum(np.searchsorted(keys, own), len(keys) - 1)
        hit = keys[place] == own
        result[hit] = found[place[hit]]
        return result

    return project


def middle_nodes(mesh: Mesh) -> dict[tuple[int, int], int]:
    """Number of the mid-side node of every edge that has one, by its sorted corner nodes."""
    found: dict[tuple[int, int], int] = {}
    for block in mesh.blocks:
        kind = ELEMENT_KINDS[block.kind]
        if kind.order == 1:
            continue
        for place, (a, b) in enumerate(kind.edges):
            pairs = np.sort(block.connectivity[:, [a, b]], axis=1).tolist()
            for pair, middle in zip(pairs, block.connectivity[:, kind.n_corner + place].tolist()):
                found[(pair[0], pair[1])] = middle
    return found


def curved(mesh: Mesh, project: Project | None = None, kinds: Collection[str] | None = None) -> tuple[Mesh, int]:
    """(mesh of second order, number of edges whose mid-side nodes were drawn back towards the straight edge).

    kinds: raise the blocks of these kinds only, None for all. Blocks that are of second order already are refused:
    DefectError.
    """
    if kinds is not None:
        chosen = [index for index, block in enumerate(mesh.blocks) if block.kind in kinds]
        raised, n_drawn = curved(Mesh(mesh.nodes, tuple(mesh.blocks[index] for index in chosen)), project)
        new = dict(zip(chosen, raised.blocks, strict=True))
        return Mesh(raised.nodes, tuple(new.get(index, block) for index, block in enumerate(mesh.blocks))), n_drawn
    if any(block.kind not in SECOND_ORDER for block in mesh.blocks):
        raise DefectError("a mesh that has elements of second order cannot be raised to it")
    edges, of_block = _number_edges(mesh)
    straight = 0.5 * (mesh.nodes[edges[:, 0]] + mesh.nodes[edges[:, 1]])
    places = straight if project is None else np.asarray(project(straight, edges), dtype=np.float64)
    if places.shape != straight.shape or not np.isfinite(places).all():
        raise DefectError(f"mid-side nodes of shape {places.shape}, expected {straight.shape}, all finite")
    n_node = len(mesh.nodes)
    blocks = tuple(
        replace(block, kind=SECOND_ORDER[block.kind], connectivity=np.hstack([block.connectivity, n_node + numbers]))
        for block, numbers in zip(mesh.blocks, of_block, strict=True)
    )
    drawn: NDArray[np.int64] = np.empty(0, np.int64)
    if project is not None:
        places, drawn = _draw_back(mesh.nodes, blocks, straight, places)
    return Mesh(np.concatenate([mesh.nodes, places]), blocks), len(drawn)


def _number_edges(mesh: Mesh) -> tuple[NDArray[np.int64], list[NDArray[np.int64]]]:
    """Unique edges (n, 2) as sorted node pairs, and for every block the numbers (n_element, n_edge) of its edges."""
    pairs = [
        np.sort(block.connectivity[:, np.array(ELEMENT_KINDS[block.kind].edges)].reshape(-1, 2), axis=1)
        for block in mesh.blocks
    ]
    if not pairs:
        return np.empty((0, 2), np.int64), []
    stacked = np.concatenate(pairs)
    keys, numbers = np.unique(stacked[:, 0] * max(len(mesh.nodes), 1) + stacked[:, 1], return_inverse=True)
    edges = np.stack([keys // max(len(mesh.nodes), 1), keys % max(len(mesh.nodes), 1)], axis=1)
    split = np.split(numbers.reshape(-1), np.cumsum([len(pair) for pair in pairs])[:-1])
    return edges, [part.reshape(len(block.connectivity), -1) for part, block in zip(split, mesh.blocks, strict=True)]


def _draw_back(
    nodes: NDArray[np.float64],
    blocks: tuple[ElementBlock, ...],
    straight: NDArray[np.float64],
    places: NDArray[np.float64],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Places with those of bad elements' edges drawn back, and the numbers of the edges drawn back."""
    n_node = len(nodes)
    share = np.ones(len(straight))
    for allowed in DRAWBACKS:
        now = np.concatenate([nodes, straight + share[:, None] * (places - straight)])
        flat = np.concatenate([nodes, straight])
        bad = [
            block.connectivity[_too_bent(block, now, flat)][:, ELEMENT_KINDS[block.kind].n_corner :].ravel()
            for block in blocks
            if ELEMENT_KINDS[block.kind].dimension > 1 and len(block.connectivity)
        ]
        numbers = np.unique(np.concatenate(bad)) - n_node if bad else np.empty(0, np.int64)
        if not len(numbers):
            break
        share[numbers] = np.minimum(share[numbers], allowed)
    # a drawn-back edge may bend its neighbours no further than before: shares only ever sink
    moved = np.linalg.norm(places - straight, axis=1) > 0.0
    return straight + share[:, None] * (places - straight), np.flatnonzero((share < 1.0) & moved)


def _too_bent(block: ElementBlock, now: NDArray[np.float64], flat: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(n_element,) True where a Jacobian falls below LEAST_JACOBIAN of the straight element's at the same node."""
    rule = corner_rule(block.kind)
    bent, plain = jacobians(now[block.connectivity], rule), jacobians(flat[block.connectivity], rule)
    if ELEMENT_KINDS[block.kind].dimension == 3:
        value, reference = np.linalg.det(bent), np.linalg.det(plain)
    else:
        normal = np.cross(plain[:, :, 0], plain[:, :, 1])
        length = np.linalg.norm(normal, axis=-1)
        value = (np.cross(bent[:, :, 0], bent[:, :, 1]) * normal).sum(axis=-1) / np.where(length > 0.0, length, 1.0)
        reference = length
    return np.asarray((value < LEAST_JACOBIAN * reference).any(axis=1))
