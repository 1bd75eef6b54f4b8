"""Ties become couplings: RBE2, RBE3 or equations, each node dependent once and no dependent node independent elsewhere.

arrange.py says who depends on whom. Here a body without an anchor follows its head (RBE2). A body on an average gives
each of its nodes that very average, taken at the node (RBE3): exactly the same motion, and no chain. What remains,
interpolations, work, averages of dependent nodes, and nodes that follow those, are equations in which dependent
freedoms have been replaced by what they depend on.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.connect.arrange import Arrangement, Average, Body, Interpolation, Pair, joint_of
from kernel.connect.equations import Expression, Freedom, average_matrices, cross_matrix, equation, rigid_row, rows
from kernel.connect.model import Coupling, Mpc, Rbe2, Rbe3
from kernel.connect.several import element_pieces
from kernel.connect.work import BeamFrame, beam_frames, patch_faces, warping_of, work_matrix
from kernel.errors import ConnectError, OptionError
from kernel.idealise.section import SectionProperties
from kernel.idealise.torsion import Warping
from kernel.mesh.assembly import Tie
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import Mesh
from kernel.mesh.shapes import doubled_normals

Array = NDArray[np.float64]

COUPLINGS = ("distributing", "rigid", "work")

ROUNDING = 1e-9
"""Arms shorter than this share of an element are none."""

MAX_CHAIN = 50
"""Longest chain of couplings that is followed."""


@dataclass(frozen=True, slots=True, eq=False)
class Coupled:
    """The couplings, in order of kind and node, and a line for each tie that was changed to make them consistent."""

    couplings: tuple[Coupling, ...]
    notes: tuple[str, ...]


def make_couplings(
    ties: Sequence[Tie],
    mesh: Mesh,
    nodes: Array,
    kind: str = "distributing",
    sections: Mapping[str, SectionProperties] | None = None,
    by_joint: Mapping[str, str] | None = None,
) -> Coupled:
    """Couplings for the ties. nodes: (n_node, 3) in the frame of the model; sections: by segment, for "work".

    by_joint: joint id -> kind, for joints that differ.
    OptionError: unknown kind. ConnectError: a tie that cannot be made consistent with the others, by its joint.
    """
    by_joint = by_joint or {}
    for name in (kind, *by_joint.values()):
        if name not in COUPLINGS:
            raise OptionError(f"unknown coupling {name!r}, expected one of {', '.join(COUPLINGS)}")

    def kind_of(tie: Tie) -> str:
        return by_joint.get(tie.joint.id, kind) if tie.joint is not None else kind

    has_rotations = nodes_with_rotations(mesh)
    arrangement = Arrangement(
        ties, nodes, has_rotations, is_rigid=lambda tie: kind_of(tie) == "rigid", pieces=lambda: element_pieces(mesh)
    )
    rigid = [coupling for body in arrangement.bodies if body.anchor is None for coupling in _rigid(body, has_rotations)]
    on_average = [(body, body.anchor) for body in arrangement.bodies if isinstance(body.anchor, Average)]
    frames = beam_frames(mesh, nodes, sections or {}) if "work" in (kind, *by_joint.values()) else {}
    by_work = [
        body
        for body, average in on_average
        if kind_of(average.tie) == "work" and _why_not_work(average, frames) is None
    ]
    worked = {body.head for body in by_work}
    dependents = arrangement.dependents | {pair.node for pair in arrangement.pairs}
    table: dict[Freedom, Expression] = {}
    couplings: list[Coupling] = [*rigid]
    table.update(_work(by_work, frames, mesh, nodes, has_rotations))
    notes = list(arrangement.notes)
    for body, average in on_average:
        if body.head in worked:
            continue
        if dependents.isdisjoint(average.patch.tolist()):
            couplings += _averaged(body, average, has_rotations)
        else:
            table.update(_average_rows(body, average, nodes, has_rotations))
        if kind_of(average.tie) == "work":
            notes.append(f"{joint_of(average.tie)}: distributing, for {_why_not_work(average, frames)}")
    for body in arrangement.bodies:
        if isinstance(body.anchor, Interpolation):
            table.update(_interpolated(body.anchor, nodes, has_rotations))
            table.update(_followers(body, nodes, has_rotations))
    followers: dict[int, list[int]] = {}
    for pair in arrangement.pairs:
        if pair.independent not in dependents and has_rotations[pair.independent]:
            followers.setdefault(pair.independent, []).append(pair.node)
            continue
        for component in (1, 2, 3):
            table[(pair.node, component)] = _pair_row(pair, component, nodes, has_rotations)
    couplings += [
        Rbe2(independent, np.array(sorted(held), dtype=np.int64), "123")
        for independent, held in sorted(followers.items())
    ]
    couplings += equations_of(table, couplings, nodes)
    return Coupled(tuple(couplings), tuple(dict.fromkeys(notes)))


def nodes_with_rotations(mesh: Mesh) -> NDArray[np.bool_]:
    """(n_node,) True where a line or shell element gives the node rotations."""
    has = np.zeros(mesh.n_node, dtype=bool)
    for block in mesh.blocks:
        if ELEMENT_KINDS[block.kind].dimension < 3:
            has[block.connectivity.ravel()] = True
    return has


def _why_not_work(average: Average, frames: Mapping[int, BeamFrame]) -> str | None:
    """What speaks against equating work over the face that holds a node; None where work can be equated."""
    if average.n_face > 1:
        return f"its node rests on {average.n_face} faces at once"
    if average.tie.joint is not None and average.tie.joint.kind == "along":
        return "the face lies along the beam, and its section's stresses act across"
    return None if average.node in frames else "only a beam's section says how work is shared out"


def _components(node: int, has_rotations: NDArray[np.bool_]) -> range:
    return range(1, 7) if has_rotations[node] else range(1, 4)


def _rigid(body: Body, has_rotations: NDArray[np.bool_]) -> list[Coupling]:
    others = np.array([node for node in body.members if node != body.head], dtype=np.int64)
    turning = has_rotations[others]
    chosen = ((others[turning], "123456"), (others[~turning], "123"))
    return [Rbe2(body.head, nodes, components) for nodes, components in chosen if len(nodes)]


def _averaged(body: Body, average: Average, has_rotations: NDArray[np.bool_]) -> list[Coupling]:
    return [
        Rbe3(node, average.patch, average.weights, "123456" if has_rotations[node] else "123") for node in body.members
    ]


def _average_rows(
    body: Body, average: Average, nodes: Array, has_rotations: NDArray[np.bool_]
) -> dict[Freedom, Expression]:
    """The same as rows, for a patch of which nodes depend on something else."""
    return {
        freedom: row for coupling in _averaged(body, average, has_rotations) for freedom, row in rows(coupling, nodes)
    }


def _work(
    bodies: Sequence[Body], frames: Mapping[int, BeamFrame], mesh: Mesh, nodes: Array, has_rotations: NDArray[np.bool_]
) -> dict[Freedom, Expression]:
    """Equal work in the place of each average; the rest of the node's body follows it rigidly."""
    warpings: dict[int, Warping] = {}
    table: dict[Freedom, Expression] = {}
    for body in bodies:
        average = body.anchor
        assert isinstance(average, Average)
        place = joint_of(average.tie)
        frame = frames[average.node]
        if id(frame.section) not in warpings:
            warpings[id(frame.section)] = warping_of(frame.section)
        points = nodes[average.patch] - nodes[average.node]
        faces = patch_faces(mesh, average.patch)
        matrix = work_matrix(frame.section, warpings[id(frame.section)], frame.axes, points, faces, place)
        for c in range(6):
            table[(average.node, c + 1)] = _row_on(average.patch, matrix[c])
        table.update(_followers(body, nodes, has_rotations))
    return table


def _row_on(patch: NDArray[np.int64], matrix: Array) -> Expression:
    """matrix: (n, 3) coefficients of the patch's translations."""
    return {(int(node), k + 1): float(row[k]) for node, row in zip(patch, matrix) for k in range(3)}


def _followers(body: Body, nodes: Array, has_rotations: NDArray[np.bool_]) -> dict[Freedom, Expression]:
    """All members of a body but its head, rigid with it."""
    return {
        (node, component): rigid_row(node, component, body.head, nodes)
        for node in body.members
        if node != body.head
        for component in _components(node, has_rotations)
    }


def _pair_row(pair: Pair, component: int, nodes: Array, has_rotations: NDArray[np.bool_]) -> Expression:
    """Rigid with a node that turns; with a node of solids only it can but move as it does."""
    if has_rotations[pair.independent]:
        return rigid_row(pair.node, component, pair.independent, nodes)
    return {(pair.independent, component): 1.0}


def _interpolated(item: Interpolation, nodes: Array, has_rotations: NDArray[np.bool_]) -> dict[Freedom, Expression]:
    """A node's place on a face, with its arm.

    Hosts of shells: u = sum N u_i + theta x (x - sum N x_i), with the shell's own rotation there. Hosts of solids have
    no rotations: u = sum N u_i + theta x (x - sum N x_i) with the rotation that fits the hosts' translations best.
    """
    components = _components(item.node, has_rotations) if item.tie.has_rotations else range(1, 4)
    foot = item.weights @ nodes[item.hosts]
    if has_rotations[item.hosts].all():
        arm = nodes[item.node] - foot
        arm[np.abs(arm) < ROUNDING * np.ptp(nodes[item.hosts], axis=0).max()] = 0.0
        rotation = _shell_rotation(item, nodes)
        across = -cross_matrix(arm)  # theta x arm
        table: dict[Freedom, Expression] = {}
        for component in components:
            if component > 3:
                table[(item.node, component)] = rotation[component - 4]
                continue
            row = {(int(n), component): float(w) for n, w in zip(item.hosts, item.weights)}
            for part, factor in zip(rotation, across[component - 1].tolist()):
                for freedom, value in part.items() if factor else ():
                    row[freedom] = row.get(freedom, 0.0) + factor * value
            table[(item.node, component)] = row
        return table
    even = np.full(len(item.hosts), 1.0)
    arm_and_turn = average_matrices(nodes[item.hosts], even, nodes[item.node])
    at_foot, _ = average_matrices(nodes[item.hosts], even, foot)
    translation = np.einsum("n,ik->ink", item.weights, np.eye(3)) + arm_and_turn[0] - at_foot
    both = (translation, arm_and_turn[1])
    return {
        (item.node, component): _row_on(item.hosts, both[(component - 1) // 3][(component - 1) % 3])
        for component in components
    }


def _shell_rotation(item: Interpolation, nodes: Array) -> list[Expression]:
    """The three rotations of a shell's element at a place: sum N theta_i, but about the normal as its corners' own
    translations tell it, for there the nodes' rotations hardly resist and carry nothing.

    On an edge, which says nothing of the element's plane, all three are the nodes'.
    """
    share = np.eye(3)
    rows: list[Expression] = [{}, {}, {}]
    places = nodes[item.hosts]
    normal = _normal_of(places)
    if normal is not None:
        turn = average_matrices(places, np.full(len(places), 1.0), places.mean(axis=0))[1]
        rows = [_row_on(item.hosts, normal[k] * np.einsum("i,ink->nk", normal, turn)) for k in range(3)]
        share -= np.outer(normal, normal)
    share[np.abs(share) < ROUNDING] = 0.0
    for k, row in enumerate(rows):
        for host, weight in zip(item.hosts.tolist(), item.weights.tolist()):
            for other in np.flatnonzero(share[k]).tolist():
                row[(host, 4 + other)] = row.get((host, 4 + other), 0.0) + weight * float(share[k, other])
    return rows


def _normal_of(places: Array) -> Array | None:
    """Unit normal of a shell's element with its nodes at `places` (n, 3), corners first; None of nodes on an edge."""
    corners = places[: len(places) // 2] if len(places) > 4 else places  # tri6 and quad8 have their middles last
    if len(corners) < 3:
        return None
    normal = doubled_normals(corners[None])[0]
    length = float(np.linalg.norm(normal))
    return normal / length if length > ROUNDING * float(np.ptp(places, axis=0).max()) ** 2 else None


def equations_of(table: dict[Freedom, Expression], couplings: Sequence[Coupling], nodes: Array) -> list[Mpc]:
    """The table's rows, with the freedoms replaced that depend on other rows or on couplings."""
    needed = {freedom[0] for row in table.values() for freedom in row}
    known = dict(table)
    for coupling in couplings:
        if not needed.isdisjoint(_dependents(coupling)):
            known.update(rows(coupling, nodes))
    return [equation(freedom, _expanded(freedom, known, nodes)) for freedom in sorted(table)]


def _dependents(coupling: Coupling) -> list[int]:
    if isinstance(coupling, Rbe2):
        return [int(node) for node in coupling.dependent]
    return [int(coupling.nodes[0]) if isinstance(coupling, Mpc) else coupling.dependent]


def _expanded(freedom: Freedom, table: dict[Freedom, Expression], nodes: Array) -> Expression:
    """The expression with all dependent freedoms replaced, however long the chain."""
    row = dict(table[freedom])
    for _ in range(MAX_CHAIN):
        chained = [term for term in sorted(row) if term in table]
        if not chained:
            return row
        for term in chained:
            value = row.pop(term)
            for inner, factor in table[term].items():
                row[inner] = row.get(inner, 0.0) + value * factor
    place = ", ".join(f"{x:g}" for x in nodes[freedom[0]])
    raise ConnectError(f"the couplings at the node ({place}) depend on each other in a ring, expected a chain")
