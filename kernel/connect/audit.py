"""Audits of a mesh by counting: pieces, coincident nodes, cracks along shared curves."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.bodies import Bodies
from kernel.connect.model import Mpc, Rbe2
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.order import middle_nodes
from kernel.pieces import connected_pieces, near_pairs

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from kernel.connect.model import Coupling, Model
    from kernel.mesh.mesh import Mesh


def connected_components(model: Model) -> int:
    """Pieces of the model, elements and couplings counted as connections. Nodes of neither count not at all."""
    labels = component_labels(model)
    used = np.zeros(model.mesh.n_node, dtype=bool)
    for block in model.mesh.blocks:
        used[block.connectivity.ravel()] = True
    return len(np.unique(labels[used]))


def component_segments(model: Model) -> tuple[tuple[str, ...], ...]:
    """Ids of the segments in each of those pieces, in the order of the segments; pieces by their first segment."""
    labels = component_labels(model)
    pieces: dict[int, dict[str, None]] = {}
    for block in model.mesh.blocks:
        for label in np.unique(labels[block.connectivity.ravel()]).tolist():
            pieces.setdefault(label, {})[block.segment] = None
    rank = {element.segment: place for place, element in enumerate(model.properties)}
    ordered = (tuple(sorted(segments, key=rank.__getitem__)) for segments in pieces.values())
    return tuple(sorted(ordered, key=lambda segments: [rank[segment] for segment in segments]))


def coincident_nodes(model: Model, tolerance: float, joined: Collection[tuple[str, str]] | None = None) -> int:
    """Pairs of nodes nearer than the tolerance that no coupling ties to one another.

    A node tied to an element is tied to all of that element's nodes, be they in the coupling (its corners) or not, and
    to what follows the same nodes. joined: pairs of segments that have a joint, None where that is not known. Solids
    that have none may touch along a line: their nodes there are no pairs.
    """
    nodes = model.mesh.nodes
    if tolerance <= 0 or len(nodes) < 2:
        return 0
    pairs = near_pairs(nodes, tolerance)
    close = {node for pair in pairs for node in pair}
    couplings: dict[int, set[int]] = {node: set() for node in close}
    heads: dict[int, int] = {}  # RBE2 of one independent node are one body: they count as its first
    for index, coupling in enumerate(model.couplings):
        key = heads.setdefault(coupling.independent, index) if isinstance(coupling, Rbe2) else index
        for node in close.intersection(map(int, coupling_nodes(coupling))):
            couplings[node].add(key)
    untied = [(a, b) for a, b in pairs if not couplings[a] & couplings[b]]
    if not untied:
        return 0
    around = _neighbours(model.mesh, {node for pair in untied for node in pair})
    reached = {
        node: {int(n) for index in couplings[node] for n in coupling_nodes(model.couplings[index])} for node in around
    }
    followed = {
        node: {int(n) for index in couplings[node] for n in _followed(model.couplings[index], node)} for node in around
    }
    untied = [
        (a, b) for a, b in untied if not (reached[a] & around[b] or reached[b] & around[a] or followed[a] & followed[b])
    ]
    return len(untied) if joined is None else len(untied) - _on_lines(model.mesh, untied, joined, tolerance)


def _followed(coupling: Coupling, node: int) -> NDArray[np.int64]:
    """The nodes that `node` follows by a coupling in which it is dependent; none where it is not."""
    members = coupling_nodes(coupling)
    if isinstance(coupling, Rbe2):
        return members[:1] if node != coupling.independent else members[:0]
    dependent = int(coupling.nodes[0]) if isinstance(coupling, Mpc) else coupling.dependent
    return members[members != node] if node == dependent else members[:0]


def _on_lines(
    mesh: Mesh, pairs: Sequence[tuple[int, int]], joined: Collection[tuple[str, str]], tolerance: float
) -> int:
    """How many of the pairs are of two solids without a joint, all of whose pairs lie on one line."""
    solids: dict[int, set[str]] = {}
    others: set[int] = set()
    wanted = np.zeros(mesh.n_node, dtype=bool)
    wanted[[node for pair in pairs for node in pair]] = True
    for block in mesh.blocks:
        used = np.unique(block.connectivity[wanted[block.connectivity]]).tolist()
        if ELEMENT_KINDS[block.kind].dimension < 3:
            others.update(used)
        for node in used:
            solids.setdefault(node, set()).add(block.segment)
    touching: dict[tuple[str, str], list[int]] = {}
    for a, b in pairs:
        between = {(min(s, t), max(s, t)) for s in solids.get(a, ()) for t in solids.get(b, ())}
        is_apart = not any(s == t or (s, t) in joined or (t, s) in joined for s, t in between)
        if len(between) == 1 and is_apart and not others & {a, b}:
            touching.setdefault(between.pop(), []).append(a)
    return sum(len(at) for at in touching.values() if _are_on_a_line(mesh.nodes[at], tolerance))


def _are_on_a_line(points: NDArray[np.float64], tolerance: float) -> bool:
    """Whether points (n, 3) are no further than the tolerance from one line."""
    if len(points) < 3:
        return True
    arms = points - points[0]
    along = arms[int(np.argmax(np.linalg.norm(arms, axis=1)))]
    away = np.linalg.norm(np.cross(arms, along / np.linalg.norm(along)), axis=1)
    return bool(away.max() <= 2 * tolerance)


def _neighbours(mesh: Mesh, nodes: set[int]) -> dict[int, set[int]]:
    """For each of the nodes, all nodes of its elements."""
    around: dict[int, set[int]] = {node: set() for node in nodes}
    wanted = np.zeros(mesh.n_node, dtype=bool)
    wanted[list(nodes)] = True
    for block in mesh.blocks:
        for row in block.connectivity[wanted[block.connectivity].any(axis=1)].tolist():
            for node in nodes.intersection(row):
                around[node].update(row)
    return around


def edge_cracks(mesh: Mesh, curve_uses: NDArray[np.int64]) -> int:
    """Mesh edges whose number of shell elements is wrong.

    curve_uses: (n, 3) rows (node, node, expected number) for every edge on a curve. Every other edge of a shell lies
    inside a face, so that exactly two elements of its segment share it; two segments may have an edge between the same
    two nodes, each in its own face, where both nodes are on the curve in which they cross.
    """
    if len(curve_uses) == 0:
        return 0
    number = {name: k for k, name in enumerate(dict.fromkeys(block.segment for block in mesh.blocks))}
    key, n_segment = np.int64(max(mesh.n_node, 1)), np.int64(max(len(number), 1))
    sides = [np.empty(0, np.int64)]
    for block in mesh.blocks:
        if ELEMENT_KINDS[block.kind].dimension == 2:
            for edge in ELEMENT_KINDS[block.kind].edges:
                ends = np.sort(block.connectivity[:, list(edge)], axis=1)
                sides.append((ends[:, 0] * key + ends[:, 1]) * n_segment + number[block.segment])
    used, counts = np.unique(np.concatenate(sides), return_counts=True)
    edges = used // n_segment
    listed = np.sort(curve_uses[:, :2], axis=1)
    curve_keys = listed[:, 0] * key + listed[:, 1]
    on_curves = np.isin(edges, curve_keys)
    wrong = len(np.unique(edges[~on_curves & (counts != 2)]))
    known = np.sort(curve_keys)
    totals = np.bincount(np.searchsorted(known, edges[on_curves]), counts[on_curves], minlength=len(known))
    found = totals[np.searchsorted(known, curve_keys)]
    return wrong + int((found != curve_uses[:, 2]).sum())


def loose_arms(model: Model, arms: NDArray[np.int64]) -> int:
    """Nodes of edges that should hang by rigid arms, and do not move with what they should hang from.

    arms: (n, 4) rows (a, b, a', b'): the edge a-b hangs from a'-b', with its mid-side node where it has one. Two nodes
    move together when rigid couplings join them, or when one of them follows equations in all six freedoms.
    """
    bodies = Bodies()
    bound: dict[int, set[int]] = {}
    for coupling in model.couplings:
        if isinstance(coupling, Rbe2):
            if len(coupling.components) == 6:
                for node in coupling.dependent.tolist():
                    bodies.join(coupling.independent, node)
        elif isinstance(coupling, Mpc):
            bound.setdefault(int(coupling.nodes[0]), set()).add(int(coupling.components[0]))
        else:
            bound.setdefault(coupling.dependent, set()).update(map(int, coupling.components))
    middles = middle_nodes(model.mesh) if len(arms) else {}
    pairs: set[tuple[int, int]] = set()
    for a, b, from_a, from_b in arms.tolist():
        pairs.update(((a, from_a), (b, from_b)))
        if (min(a, b), max(a, b)) in middles:
            pairs.add((middles[min(a, b), max(a, b)], middles[min(from_a, from_b), max(from_a, from_b)]))
    return sum(
        bodies.find(one) != bodies.find(other) and all(len(bound.get(node, ())) < 6 for node in (one, other))
        for one, other in pairs
    )


def component_labels(model: Model) -> NDArray[np.int64]:
    """(n_node,) a label for each node, equal within a piece."""
    pairs: list[NDArray[np.int64]] = []
    for block in model.mesh.blocks:
        nodes = block.connectivity
        pairs += [nodes[:, [0, k]] for k in range(1, nodes.shape[1])]
    for coupling in model.couplings:
        members = coupling_nodes(coupling)
        pairs.append(np.column_stack([np.full(len(members) - 1, members[0]), members[1:]]))
    first, second = np.concatenate(pairs).T if pairs else np.empty((2, 0), np.int64)
    return connected_pieces(model.mesh.n_node, first, second)


def coupling_nodes(coupling: Coupling) -> NDArray[np.int64]:
    """All nodes of a coupling; the independent one of an RBE2 and the dependent one of an RBE3 first."""
    if isinstance(coupling, Rbe2):
        return np.concatenate([[coupling.independent], coupling.dependent])
    if isinstance(coupling, Mpc):
        return np.unique(coupling.nodes)
    return np.concatenate([[coupling.dependent], coupling.independent])
