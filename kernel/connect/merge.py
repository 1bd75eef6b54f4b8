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

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.bodies import Bodies
from kernel.errors import ConnectError
from kernel.mesh.assembly import Tie
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.shapes import beyond_rim, foot_on_face, shape_values
from kernel.pieces import near_pairs
from kernel.solid.boxes import BoxIndex
from kernel.units import VERTEX_TOLERANCE

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

INSIDE = 1e-6
"""Local coordinates beyond an element's rim by less than this are on it."""

BULGE = 1e-3
"""Places on an element lie in the box of its nodes, widened by this share: more than rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Connected:
    """The mesh with coincident nodes made one, the ties that are left to couple, and how many nodes were made one.

    numbers: (n_node,) the new number of every old node. reach: the tolerance that was used.
    """

    mesh: Mesh
    ties: tuple[Tie, ...]
    n_joined: int
    numbers: Indices
    reach: float


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
    nodes.flags.writeable = False
    return Mesh(nodes, tuple(blocks))


def connect(
    mesh: Mesh,
    tolerance: float | None = None,
    segments: Collection[str] | None = None,
    bound: Collection[int] = (),
) -> Connected:
    """Join the segments of a mesh where they touch. tolerance: a length; by default the vertex tolerance of its size.

    Nodes of one segment are never joined with each other, so that a slit stays open. segments: only these, None for
    all. bound: nodes that depend on something already and are not tied to anything more.
    ConnectError: an unknown segment, or elements so small that the tolerance would join neighbours.
    """
    size = float(np.linalg.norm(np.ptp(mesh.nodes, axis=0))) if mesh.n_node else 0.0
    reach = VERTEX_TOLERANCE * size if tolerance is None else tolerance
    names = list(dict.fromkeys(block.segment for block in mesh.blocks))
    for name in segments or ():
        if name not in names:
            raise ConnectError(f"no segment {name!r} in the mesh, expected one of {', '.join(names)}")
    chosen = [name for name in names if segments is None or name in segments]
    _refuse_wide(mesh, reach, chosen)
    numbers = _coincident(mesh, reach, chosen)
    joined = _renumbered(mesh, numbers)
    held = {int(numbers[node]) for node in bound}
    return Connected(joined, _ties(joined, reach, chosen, held), mesh.n_node - joined.n_node, numbers, reach)


def _coincident(mesh: Mesh, reach: float, segments: Sequence[str]) -> Indices:
    """New number of each node, nodes of different segments nearer than the reach made one.

    A node of beams or shells and one of solids stay two: the solid's has no rotations, so that one would be a hinge.
    """
    found = near_pairs(mesh.nodes, reach) if reach > 0 else []
    pairs = sorted(found, key=lambda pair: float(np.linalg.norm(mesh.nodes[pair[0]] - mesh.nodes[pair[1]])))
    chosen = set(segments)
    owners: dict[int, set[str]] = {node: set() for pair in pairs for node in pair}
    turning: set[int] = set()
    for block in mesh.blocks:
        for node in owners.keys() & set(block.connectivity.ravel().tolist()):
            owners[node].add(block.segment)
            if ELEMENT_KINDS[block.kind].dimension < 3:
                turning.add(node)
    bodies = Bodies()
    for a, b in pairs:
        one, other = bodies.find(a), bodies.find(b)
        both = owners[one] | owners[other]
        is_hinge = (a in turning) != (b in turning)
        if one != other and not is_hinge and both <= chosen and owners[one].isdisjoint(owners[other]):
            bodies.join(one, other)
            owners[bodies.find(one)] = both
    first = np.array([bodies.find(node) for node in range(mesh.n_node)], dtype=np.int64)
    return np.unique(first, return_inverse=True)[1].reshape(-1)


def _refuse_wide(mesh: Mesh, reach: float, segments: Sequence[str]) -> None:
    """ConnectError where an edge is so short that both its nodes may be near to one node of another segment."""
    for block in mesh.blocks:
        if block.segment not in segments or not len(block.connectivity):
            continue
        a, b = np.array(ELEMENT_KINDS[block.kind].edges).T
        lengths = np.linalg.norm(mesh.nodes[block.connectivity[:, a]] - mesh.nodes[block.connectivity[:, b]], axis=-1)
        shortest = float(lengths.min()) / ELEMENT_KINDS[block.kind].order
        if shortest <= 2 * reach:
            raise ConnectError(
                f"segment {block.segment} has nodes {shortest:.4g} apart, expected a tolerance under half of that, "
                f"not {reach:g}"
            )


def _renumbered(mesh: Mesh, numbers: Indices) -> Mesh:
    blocks = [replace(block, connectivity=numbers[block.connectivity]) for block in mesh.blocks]
    nodes = np.empty((int(numbers.max(initial=-1)) + 1, 3))
    nodes[numbers[::-1]] = mesh.nodes[::-1]  # the first of those that become one gives the place
    nodes.flags.writeable = False
    return Mesh(nodes, tuple(blocks))


def _ties(mesh: Mesh, reach: float, segments: Sequence[str], bound: Collection[int]) -> tuple[Tie, ...]:
    """For each two segments, the side with more hanging nodes follows the other."""
    blocks: dict[str, list[ElementBlock]] = {name: [] for name in segments}
    for block in mesh.blocks:
        if block.segment in blocks and ELEMENT_KINDS[block.kind].dimension < 3:
            blocks[block.segment].append(block)
    parts = {name: part for name, own in blocks.items() if (part := _part(mesh, own, reach)) is not None}
    names = list(parts)
    boxes = np.array([parts[name].box for name in names]).reshape(-1, 2, 3)
    ties = []
    for number, place in BoxIndex(boxes).pairs(boxes + [[[-reach], [reach]]]):
        if number < place:
            one, other = names[number], names[place]
            ahead = _hanging(mesh, parts[one], parts[other], reach, bound)
            back = _hanging(mesh, parts[other], parts[one], reach, bound)
            found = ahead if len(ahead[0]) > len(back[0]) else back
            if len(found[0]):
                ties.append(Tie("interpolated", None, found[0], hosts=found[1], host_weights=found[2]))
    return tuple(ties)


@dataclass(frozen=True, slots=True, eq=False)
class _Part:
    """A segment of beams or shells: its nodes, their box (2, 3), and its blocks of shells, which can be hosts.

    boxes: of each block of shells, its elements' lowest and highest corners, (2, n_element, 3), a little widened.
    """

    nodes: Indices
    box: Array
    shells: tuple[ElementBlock, ...]
    boxes: tuple[Array, ...]


def _part(mesh: Mesh, blocks: Sequence[ElementBlock], reach: float) -> _Part | None:
    """Of a segment's blocks of beams and shells; None for solids: their nodes have no rotations to follow with."""
    rows = [block.connectivity.ravel() for block in blocks if block.connectivity.size]
    if not rows:
        return None
    nodes = np.unique(np.concatenate(rows))
    places = mesh.nodes[nodes]
    shells = tuple(block for block in blocks if ELEMENT_KINDS[block.kind].dimension == 2)
    boxes = []
    for block in shells:
        corners = mesh.nodes[block.connectivity]
        low, high = corners.min(axis=1), corners.max(axis=1)
        margin = reach + BULGE * (high - low)
        boxes.append(np.array([low - margin, high + margin]))
    return _Part(nodes, np.array([places.min(axis=0), places.max(axis=0)]), shells, tuple(boxes))


def _hanging(
    mesh: Mesh, follower: _Part, host: _Part, reach: float, bound: Collection[int]
) -> tuple[Indices, tuple[Indices, ...], tuple[Array, ...]]:
    """Nodes of the follower alone that lie on the host's elements, with these elements' nodes and weights."""
    own = np.setdiff1d(follower.nodes, host.nodes)
    low, high = host.box[0] - reach, host.box[1] + reach
    own = own[((mesh.nodes[own] >= low) & (mesh.nodes[own] <= high)).all(axis=1)]
    nodes: list[int] = []
    hosts: list[Indices] = []
    weights: list[Array] = []
    for node in own.tolist():
        found = None if node in bound else _host(mesh, host, mesh.nodes[node], reach)
        if found is not None:
            nodes.append(node)
            hosts.append(found[0])
            weights.append(found[1])
    return np.array(nodes, dtype=np.int64), tuple(hosts), tuple(weights)


def _host(mesh: Mesh, host: _Part, place: Array, reach: float) -> tuple[Indices, Array] | None:
    """The element of the segment on which the place lies, without nodes of no weight."""
    for block, (low, high) in zip(host.shells, host.boxes):
        for element in np.flatnonzero(((place >= low) & (place <= high)).all(axis=1)).tolist():
            nodes = block.connectivity[element]
            weights = _weights_at(block.kind, mesh.nodes[nodes], place, reach)
            if weights is not None:
                heavy = np.abs(weights) > INSIDE
                return nodes[heavy], weights[heavy] / weights[heavy].sum()
    return None


def _weights_at(kind: str, corners: Array, place: Array, reach: float) -> Array | None:
    """Shape functions where the place projects into the element, None where it is outside or off by more than reach."""
    local = foot_on_face(kind, corners, place)
    values: Array = shape_values(kind, local[None])[0]
    if float(np.linalg.norm(place - values @ corners)) > reach or beyond_rim(kind, local) > INSIDE:
        return None
    return values
