"""Joining meshes after the fact, as an analyst does by hand: merge two meshes, then connect what touches.

`merge` lays meshes side by side in one table of nodes: still so many pieces. `connect` makes one node of nodes at one
place, and ties nodes that lie on another segment's shells without a partner there (meshes that do not match):

    A +-----+-----+        A's middle node has no partner on B's edge: it follows the place on B's element
      |     |     |        where it lies. The side with more such nodes follows the other, so that no two
      +-----x-----+        follow each other.
    B +-----------+
      |           |
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.audit import near_pairs
from kernel.connect.bodies import Bodies
from kernel.errors import ConnectError
from kernel.idealise.members import Tie
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.shapes import family, shape_derivatives, shape_values
from kernel.units import VERTEX_TOLERANCE

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

NEWTON_STEPS = 12
INSIDE = 1e-6
"""Local coordinates beyond an element's rim by less than this are on it."""


@dataclass(frozen=True, slots=True, eq=False)
class Connected:
    """The mesh with coincident nodes made one, the ties that are left to couple, and how many nodes were made one."""

    mesh: Mesh
    ties: tuple[Tie, ...]
    n_joined: int


def merge(meshes: Sequence[Mesh]) -> Mesh:
    """All meshes in one, nodes and blocks one after the other; nothing is joined.

    ConnectError: two meshes hold a segment of the same id.
    """
    seen: set[str] = set()
    blocks: list[ElementBlock] = []
    start = 0
    for mesh in meshes:
        own = {block.segment for block in mesh.blocks}
        if own & seen:
            raise ConnectError(f"segment {min(own & seen)} is in two meshes, expected each in one")
        seen |= own
        blocks += [replace(block, connectivity=block.connectivity + start) for block in mesh.blocks]
        start += mesh.n_node
    nodes = np.vstack([mesh.nodes for mesh in meshes]) if meshes else np.empty((0, 3))
    return Mesh(nodes, tuple(blocks))


def connect(mesh: Mesh, tolerance: float | None = None) -> Connected:
    """Join the segments of a mesh where they touch. tolerance: a length; by default the vertex tolerance of its size.

    ConnectError: two nodes of one element are nearer than the tolerance.
    """
    size = float(np.linalg.norm(np.ptp(mesh.nodes, axis=0))) if mesh.n_node else 0.0
    reach = VERTEX_TOLERANCE * size if tolerance is None else tolerance
    joined = _coincident_made_one(mesh, reach)
    return Connected(joined, _ties(joined, reach), mesh.n_node - joined.n_node)


def _coincident_made_one(mesh: Mesh, reach: float) -> Mesh:
    bodies = Bodies()
    for a, b in near_pairs(mesh.nodes, reach) if reach > 0 else []:
        bodies.join(a, b)
    first = np.array([bodies.find(node) for node in range(mesh.n_node)], dtype=np.int64)
    kept, index = np.unique(first, return_inverse=True)
    blocks = []
    for block in mesh.blocks:
        connectivity = index[block.connectivity]
        ordered = np.sort(connectivity, axis=1)
        if (ordered[:, 1:] == ordered[:, :-1]).any():
            raise ConnectError(f"an element of segment {block.segment} is smaller than the tolerance {reach:g}")
        blocks.append(replace(block, connectivity=connectivity))
    return Mesh(mesh.nodes[kept], tuple(blocks))


def _ties(mesh: Mesh, reach: float) -> tuple[Tie, ...]:
    """For each two segments, the side with more hanging nodes follows the other."""
    shells = [block for block in mesh.blocks if ELEMENT_KINDS[block.kind].dimension == 2]
    segments = list(dict.fromkeys(block.segment for block in shells))
    ties = []
    for position, one in enumerate(segments):
        for other in segments[position + 1 :]:
            ahead, back = _hanging(mesh, shells, one, other, reach), _hanging(mesh, shells, other, one, reach)
            found = ahead if len(ahead[0]) > len(back[0]) else back
            if len(found[0]):
                ties.append(Tie("interpolated", None, found[0], hosts=found[1], host_weights=found[2]))
    return tuple(ties)


def _hanging(
    mesh: Mesh, shells: Sequence[ElementBlock], follower: str, host: str, reach: float
) -> tuple[Indices, tuple[Indices, ...], tuple[Array, ...]]:
    """Nodes of the follower alone that lie on the host's elements, with these elements' nodes and weights."""
    on_host = np.unique(np.concatenate([b.connectivity.ravel() for b in shells if b.segment == host]))
    own = np.unique(np.concatenate([b.connectivity.ravel() for b in shells if b.segment == follower]))
    own = np.setdiff1d(own, on_host)
    low, high = mesh.nodes[on_host].min(axis=0) - reach, mesh.nodes[on_host].max(axis=0) + reach
    own = own[((mesh.nodes[own] >= low) & (mesh.nodes[own] <= high)).all(axis=1)]
    nodes: list[int] = []
    hosts: list[Indices] = []
    weights: list[Array] = []
    for node in own.tolist():
        found = _host(mesh, shells, host, mesh.nodes[node], reach)
        if found is not None:
            nodes.append(node)
            hosts.append(found[0])
            weights.append(found[1])
    return np.array(nodes, dtype=np.int64), tuple(hosts), tuple(weights)


def _host(
    mesh: Mesh, shells: Sequence[ElementBlock], segment: str, place: Array, reach: float
) -> tuple[Indices, Array] | None:
    """The element of the segment on which the place lies, without nodes of no weight."""
    for block in shells:
        if block.segment != segment:
            continue
        places = mesh.nodes[block.connectivity]
        margin = reach + 1e-3 * np.ptp(places, axis=1)
        near = ((place >= places.min(axis=1) - margin) & (place <= places.max(axis=1) + margin)).all(axis=1)
        for element in np.flatnonzero(near).tolist():
            weights = _weights_at(block.kind, places[element], place, reach)
            if weights is not None:
                heavy = np.abs(weights) > INSIDE
                return block.connectivity[element][heavy], weights[heavy] / weights[heavy].sum()
    return None


def _weights_at(kind: str, corners: Array, place: Array, reach: float) -> Array | None:
    """Shape functions where the place projects into the element, None where it is outside or off by more than reach."""
    local = np.full(2, 1 / 3) if family(kind) == "tri" else np.zeros(2)
    for _ in range(NEWTON_STEPS):
        off = place - shape_values(kind, local[None])[0] @ corners
        tangents = shape_derivatives(kind, local[None])[0] @ corners  # (2, 3)
        local = np.clip(local + np.linalg.lstsq(tangents.T, off, rcond=None)[0], -3, 3)
    values: Array = shape_values(kind, local[None])[0]
    if float(np.linalg.norm(place - values @ corners)) > reach:
        return None
    if family(kind) == "tri":
        inside = local.min() >= -INSIDE and local.sum() <= 1 + INSIDE
    else:
        inside = np.abs(local).max() <= 1 + INSIDE
    return values if inside else None
