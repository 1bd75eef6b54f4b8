"""What every reader of decks gives: rows of nodes by kind, made a mesh."""

from __future__ import annotations

import numpy as np

from kernel.errors import ReadError
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh

SAME = tuple(range(20))
"""The order of a file that has ours."""

Rows = dict[str, list[list[int]]]
"""Connectivity by kind, in the node ids of the file and our order."""


def deck_mesh(path: str, nodes: dict[int, list[float]], rows: Rows) -> Mesh:
    """The mesh of what was read; ReadError where there are no elements or one uses a node that is not there."""
    if not rows:
        raise ReadError(f"{path}: no elements that are known")
    place = {node: index for index, node in enumerate(nodes)}
    blocks = []
    for kind in (kind for kind in ELEMENT_KINDS if kind in rows):
        try:
            connectivity = np.array([[place[node] for node in row] for row in rows[kind]], np.int64)
        except KeyError as error:
            raise ReadError(f"{path}: an element uses node {error}, which is not there") from None
        blocks.append(ElementBlock("deck", kind, connectivity))
    return Mesh(np.array(list(nodes.values()), float).reshape(-1, 3), tuple(blocks))


def ordered(row: list[int], order: tuple[int, ...]) -> list[int]:
    """A row of the file in our order; order: for each node of the file its place in ours."""
    if len(row) != len(order):
        raise ValueError(f"an element of {len(row)} nodes, expected {len(order)}")
    ours = [0] * len(order)
    for node, position in zip(row, order):
        ours[position] = node
    return ours


def used_nodes(nodes: dict[int, list[float]], rows: Rows) -> dict[int, list[float]]:
    """Without the nodes of no element, such as those that only turn a section."""
    used = {node for elements in rows.values() for row in elements for node in row}
    return {node: place for node, place in nodes.items() if node in used}
