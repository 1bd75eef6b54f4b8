"""Ties become couplings: which node depends on which, each at most once, no dependent node independent elsewhere.

1. Rigid ties join nodes into bodies that move as one. A weighted average whose patch cannot define a rotation
   (collinear, or fewer than three nodes), and every average on request ("rigid"), is such a body too.
2. A body rests on at most one average: of more than one, all become rigid, with a note.
3. A body without one follows its most used independent node (RBE2). A body with an average gives each of its
   nodes that very average, taken at the node (RBE3): exactly the same motion, and no chain.
4. Patches leave out nodes that depend on something else, as long as the rest still defines a rotation.
5. Interpolations are equations; dependent nodes in them are replaced by what these depend on.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.bodies import Bodies
from kernel.connect.equations import Expression, Freedom, equation, rigid_row, rows
from kernel.connect.model import Coupling, Mpc, Rbe2, Rbe3
from kernel.errors import ConnectError, OptionError
from kernel.idealise.members import Tie
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import Mesh

Array = NDArray[np.float64]

COUPLINGS = ("distributing", "rigid")

FLATNESS = 1e-4
"""A patch whose width is less than this times its length is a line: translations on it define no rotation about it."""


@dataclass(frozen=True, slots=True, eq=False)
class Coupled:
    """The couplings, in order of kind and node, and a line for each tie that was changed to make them consistent."""

    couplings: tuple[Coupling, ...]
    notes: tuple[str, ...]


def make_couplings(ties: Sequence[Tie], mesh: Mesh, nodes: Array, kind: str = "distributing") -> Coupled:
    """Couplings for the ties. nodes: (n_node, 3) in the frame of the model.

    OptionError: unknown kind. ConnectError: a tie that cannot be made consistent with the others, by its joint.
    """
    if kind not in COUPLINGS:
        raise OptionError(f"unknown coupling {kind!r}, expected one of {', '.join(COUPLINGS)}")
    return _Coupler(ties, nodes, nodes_with_rotations(mesh), kind).run()


def nodes_with_rotations(mesh: Mesh) -> NDArray[np.bool_]:
    """(n_node,) True where a line or shell element gives the node rotations."""
    has = np.zeros(mesh.n_node, dtype=bool)
    for block in mesh.blocks:
        if ELEMENT_KINDS[block.kind].dimension < 3:
            has[block.connectivity.ravel()] = True
    return has


@dataclass(frozen=True, slots=True, eq=False)
class _Average:
    """A body's node that moves as the average of a patch."""

    node: int
    patch: NDArray[np.int64]
    weights: Array
    tie: Tie


@dataclass(frozen=True, slots=True, eq=False)
class _Interpolated:
    node: int
    hosts: NDArray[np.int64]
    weights: Array
    tie: Tie


class _Coupler:
    def __init__(self, ties: Sequence[Tie], nodes: Array, has_rotations: NDArray[np.bool_], kind: str) -> None:
        self.nodes = nodes
        self.has_rotations = has_rotations
        self.kind = kind
        self.bodies = Bodies()
        self.preferred: Counter[int] = Counter()
        self.averages: list[_Average] = []
        self.interpolated: list[_Interpolated] = []
        self.pairs: list[tuple[int, int, Tie]] = []
        self.notes: list[str] = []
        for tie in ties:
            self._take(tie)

    def run(self) -> Coupled:
        """All couplings."""
        self._settle()
        couplings: list[Coupling] = [*self._rigid(), *self._averaged()]
        dependents = self._dependent_nodes(couplings)
        couplings += self._pairs(dependents)
        couplings += self._equations(couplings)
        return Coupled(tuple(couplings), tuple(self.notes))

    # taking ties -------------------------------------------------------------------------------------------------

    def _take(self, tie: Tie) -> None:
        if tie.kind == "rigid":
            (independent,) = tie.independent
            self.preferred[int(independent)] += len(tie.dependent)
            for node in tie.dependent:
                self.bodies.join(int(independent), int(node))
        elif tie.kind == "beam_on_face":
            (node,) = tie.dependent
            self.averages.append(_Average(int(node), tie.independent, tie.weights, tie))
        elif tie.kind == "rigid_pairs":
            self.pairs += [(int(d), int(i), tie) for d, i in zip(tie.dependent, tie.independent)]
        elif tie.kind == "interpolated":
            self.interpolated += [
                _Interpolated(int(d), hosts, weights, tie)
                for d, hosts, weights in zip(tie.dependent, tie.hosts, tie.host_weights)
            ]
        else:
            raise ConnectError(f"{_place(tie)}: unknown tie {tie.kind!r}")

    # settling who depends on what --------------------------------------------------------------------------------

    def _settle(self) -> None:
        """Until nothing changes: make rigid what cannot be an average, and thin out patches."""
        while True:
            self._one_anchor_each()
            dependents = self._dependent_in_bodies()
            kept, changed = [], False
            for average in self.averages:
                free = np.array([int(node) not in dependents for node in average.patch], dtype=bool)
                free &= np.array(
                    [self.bodies.find(int(node)) != self.bodies.find(average.node) for node in average.patch]
                )
                patch, weights = average.patch[free], average.weights[free]
                if self.kind == "rigid" or not defines_rotation(self.nodes[patch]):
                    if self.kind != "rigid" and defines_rotation(self.nodes[average.patch]):
                        self.notes.append(
                            f"{_place(average.tie)}: rigid, for most of its patch depends on another joint"
                        )
                    self._make_rigid(average)
                    changed = True
                else:
                    kept.append(replace(average, patch=patch, weights=weights))
            self.averages = kept
            if not changed:
                return

    def _one_anchor_each(self) -> None:
        """Bodies that rest on several averages become rigid throughout."""
        by_body: dict[int, list[_Average]] = {}
        for average in self.averages:
            by_body.setdefault(self.bodies.find(average.node), []).append(average)
        for averages in by_body.values():
            if len(averages) > 1:
                for average in averages:
                    self.notes.append(f"{_place(average.tie)}: rigid, for its node rests on {len(averages)} patches")
                    self._make_rigid(average)
                    self.averages.remove(average)

    def _make_rigid(self, average: _Average) -> None:
        self.preferred[average.node] += 1
        for node in average.patch:
            self.bodies.join(average.node, int(node))

    def _head(self, members: list[int]) -> int:
        """The independent node of a body: the most preferred that has rotations, then the first."""
        able = [node for node in members if self.has_rotations[node]]
        return max(able or members, key=lambda node: (self.preferred[node], -node))

    def _dependent_in_bodies(self) -> set[int]:
        anchored = {self.bodies.find(average.node) for average in self.averages}
        dependents: set[int] = {average.node for average in self.averages}
        for root, members in self.bodies.groups().items():
            dependents.update(members if root in anchored else set(members) - {self._head(members)})
        return dependents

    # writing couplings -------------------------------------------------------------------------------------------

    def _rigid(self) -> list[Coupling]:
        anchored = {self.bodies.find(average.node) for average in self.averages}
        couplings: list[Coupling] = []
        for root, members in sorted(self.bodies.groups().items(), key=lambda item: self._head(item[1])):
            if root in anchored:
                continue
            head = self._head(members)
            if not self.has_rotations[head]:
                raise ConnectError(
                    f"nodes of solids only cannot be one rigid body (node at {self.nodes[head].tolist()})"
                )
            others = np.array([node for node in members if node != head], dtype=np.int64)
            turning = self.has_rotations[others]
            for chosen, components in ((others[turning], "123456"), (others[~turning], "123")):
                if len(chosen):
                    couplings.append(Rbe2(head, chosen, components))
        return couplings

    def _averaged(self) -> list[Coupling]:
        couplings: list[Coupling] = []
        for average in sorted(self.averages, key=lambda item: item.node):
            for node in self.bodies.members(average.node):
                components = "123456" if self.has_rotations[node] else "123"
                couplings.append(Rbe3(node, average.patch, average.weights, components))
        return couplings

    @staticmethod
    def _dependent_nodes(couplings: Sequence[Coupling]) -> set[int]:
        dependents: set[int] = set()
        for coupling in couplings:
            if isinstance(coupling, Rbe2):
                dependents.update(map(int, coupling.dependent))
            elif isinstance(coupling, Rbe3):
                dependents.add(coupling.dependent)
            else:
                dependents.add(int(coupling.nodes[0]))
        return dependents

    def _pairs(self, dependents: set[int]) -> list[Coupling]:
        """Nodes of solids that follow shell nodes. A node asked to follow two follows the first."""
        followers: dict[int, list[int]] = {}
        done = set(dependents)
        carried: dict[str, int] = {}
        chained: list[tuple[int, int]] = []
        for node, independent, tie in self.pairs:
            place = _place(tie)
            carried.setdefault(place, 0)
            if node in done or node == independent:
                continue
            done.add(node)
            carried[place] += 1
            if independent in dependents:
                chained.append((node, independent))
            else:
                followers.setdefault(independent, []).append(node)
        for place, count in carried.items():
            if count == 0:
                raise ConnectError(f"{place}: every node of it already depends on another joint")
        self.chained = chained
        return [
            Rbe2(independent, np.array(sorted(nodes), dtype=np.int64), "123")
            for independent, nodes in sorted(followers.items())
        ]

    def _equations(self, couplings: Sequence[Coupling]) -> list[Coupling]:
        """Interpolations, and pairs whose independent node depends on something, with dependents replaced."""
        table: dict[Freedom, Expression] = {}
        dependents = self._dependent_nodes(couplings)
        wanted: dict[Freedom, Expression] = {}
        for node, independent in self.chained:
            for component in (1, 2, 3):
                wanted[(node, component)] = rigid_row(node, component, independent, self.nodes)
        for item in sorted(self.interpolated, key=lambda item: item.node):
            if item.node in dependents or (item.node, 1) in wanted:
                continue  # it follows already: once is enough
            wanted.update(self._interpolation(item))
        if not wanted:
            return []
        needed = {freedom[0] for row in wanted.values() for freedom in row}
        for coupling in couplings:
            if needed & self._dependent_nodes([coupling]):
                table.update(rows(coupling, self.nodes))
        table.update(wanted)
        return [equation(freedom, self._expand(freedom, table)) for freedom in sorted(wanted)]

    def _interpolation(self, item: _Interpolated) -> dict[Freedom, Expression]:
        """u = sum N (u_i + theta_i x (x - x_i)), theta = sum N theta_i; hosts without rotations: u = sum N u_i."""
        result: dict[Freedom, Expression] = {}
        components = range(1, 7) if item.tie.has_rotations and self.has_rotations[item.node] else range(1, 4)
        hosts_turn = bool(self.has_rotations[item.hosts].all())
        for component in components:
            row: Expression = {}
            for host, weight in zip(item.hosts, item.weights):
                part: Expression = (
                    rigid_row(item.node, component, int(host), self.nodes)
                    if hosts_turn
                    else {(int(host), component): 1.0}
                )
                for freedom, value in part.items():
                    row[freedom] = row.get(freedom, 0.0) + float(weight) * value
            if component > 3 and not hosts_turn:
                continue
            result[(item.node, component)] = row
        return result

    def _expand(self, freedom: Freedom, table: dict[Freedom, Expression]) -> Expression:
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
            if freedom in row:
                break
        place = ", ".join(f"{x:g}" for x in self.nodes[freedom[0]])
        raise ConnectError(f"the couplings at the node ({place}) depend on each other in a ring, expected a chain")


MAX_CHAIN = 50
"""Longest chain of couplings that is followed."""


def defines_rotation(points: Array) -> bool:
    """Three points or more that do not lie on one line, so that their translations define a rigid motion."""
    if len(points) < 3:
        return False
    arms = points - points.mean(axis=0)
    lengths = np.linalg.svd(arms, compute_uv=False)
    return bool(lengths[1] > FLATNESS * lengths[0])


def equations_of(couplings: Sequence[Coupling]) -> list[Mpc]:
    """The couplings that are equations."""
    return [coupling for coupling in couplings if isinstance(coupling, Mpc)]


def _place(tie: Tie) -> str:
    if tie.joint is None:
        return "a joint"
    return f"joint {tie.joint.id} of {tie.joint.segments[0]} and {tie.joint.segments[1]}"
