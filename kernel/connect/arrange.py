"""Who depends on whom: ties sorted out so that every node depends once, before any equation is written.

1. Rigid ties join nodes into bodies that move as one. A weighted average whose patch cannot define a rotation
   (collinear, or fewer than three nodes), and every average on request ("rigid"), is such a body too.
2. A body has at most one anchor: a node that rests on an average or an interpolation. Averages of one node become
   one over all their patches (several.py). Where a body would still have several anchors, all become rigid, with a
   note.
3. Patches keep nodes that depend on something else: the average is then written out in what those follow. Nodes
   that follow the average's own are left out; where they are most of the patch, they hold the joint, and the average
   says nothing more.
4. An interpolation from hosts of which one is in the node's own body says nothing more, and is left out.
5. Interpolations that rest on one another in a ring (three plates round one corner, each in lap with the next) leave
   nothing free to follow: their nodes become one rigid body, with a note.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.bodies import Bodies
from kernel.connect.several import one_average_each
from kernel.errors import ConnectError
from kernel.mesh.assembly import Tie

Array = NDArray[np.float64]

MOST = 0.5
"""Share of a patch, by weight, that must be left for its average to stand for the whole."""

FLATNESS = 1e-3
"""A patch whose width is less than this times its length is a line: translations on it define no rotation about it.

Both as the weights count them. The rotation's error is rounding over the square of this: 1e-10."""


@dataclass(frozen=True, slots=True, eq=False)
class Average:
    """A node that moves as the average of a patch; n_face: of how many faces' patches, where they were put together."""

    node: int
    patch: NDArray[np.int64]
    weights: Array
    tie: Tie
    n_face: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class Interpolation:
    """A node that moves as its place on an element face does."""

    node: int
    hosts: NDArray[np.int64]
    weights: Array
    tie: Tie


@dataclass(frozen=True, slots=True, eq=False)
class Pair:
    """A node of solids that follows another node rigidly, in its translations."""

    node: int
    independent: int
    tie: Tie


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Nodes that move as one; head: the node that the others follow, free or resting on an anchor."""

    head: int
    members: tuple[int, ...]
    anchor: Average | Interpolation | None


class Arrangement:
    """The ties, sorted out. bodies (those with an anchor too, be they of one node), pairs and notes are its result."""

    def __init__(
        self,
        ties: Sequence[Tie],
        nodes: Array,
        has_rotations: NDArray[np.bool_],
        is_rigid: Callable[[Tie], bool],
        pieces: Callable[[], NDArray[np.int64]],
    ) -> None:
        self.nodes = nodes
        self.has_rotations = has_rotations
        self.is_rigid = is_rigid
        self.notes: list[str] = []
        self.pairs: list[Pair] = []
        self._joined = Bodies()
        self._preferred: Counter[int] = Counter()
        self._averages: list[Average] = []
        self._interpolations: list[Interpolation] = []
        for tie in ties:
            self._take(tie)
        self._averages = one_average_each(self._averages, ties, pieces, is_rigid)
        self._one_interpolation_each()
        while self._pass():
            pass
        self.bodies = self._bodies()
        self.pairs = self._pairs_once()

    @property
    def dependents(self) -> set[int]:
        """Nodes that depend on something, those of pairs left out."""
        result: set[int] = set()
        for body in self.bodies:
            result.update(body.members)
            if body.anchor is None:
                result.discard(body.head)
        return result

    def _take(self, tie: Tie) -> None:
        if tie.kind == "rigid":
            (independent,) = tie.independent.tolist()
            self._preferred[independent] += len(tie.dependent)
            for node in tie.dependent.tolist():
                self._joined.join(independent, node)
        elif tie.kind == "beam_on_face":
            (node,) = tie.dependent.tolist()
            self._averages.append(Average(node, tie.independent, tie.weights, tie))
        elif tie.kind == "rigid_pairs":
            pairs = zip(tie.dependent.tolist(), tie.independent.tolist())
            self.pairs += [Pair(node, independent, tie) for node, independent in pairs]
        elif tie.kind == "interpolated":
            rows = zip(tie.dependent.tolist(), tie.hosts, tie.host_weights)
            self._interpolations += [Interpolation(node, hosts, weights, tie) for node, hosts, weights in rows]
        else:
            raise ConnectError(f"{joint_of(tie)}: unknown tie {tie.kind!r}")

    def _one_interpolation_each(self) -> None:
        """A node that lies on two faces follows the first."""
        first: dict[int, Interpolation] = {}
        for item in self._interpolations:
            first.setdefault(item.node, item)
        self._interpolations = list(first.values())

    def _pass(self) -> bool:
        """One round of rules 2 to 5; True where it changed a body, so that all must be looked at again."""
        find = self._joined.find
        self._interpolations = [
            item for item in self._interpolations if find(item.node) not in {find(host) for host in item.hosts.tolist()}
        ]
        return self._join_anchors() or self._join_rings() or self._thin_patches()

    def _anchors(self) -> list[Average | Interpolation]:
        return [*self._averages, *self._interpolations]

    def _join_anchors(self) -> bool:
        anchors: dict[int, list[Average | Interpolation]] = {}
        for anchor in self._anchors():
            anchors.setdefault(self._joined.find(anchor.node), []).append(anchor)
        rigid: set[int] = set()
        for body, found in anchors.items():
            stiff = len(self._joined.members(body)) > 1 and not all(self.has_rotations[a.node] for a in found)
            if len(found) == 1 and not stiff:
                continue
            for place in dict.fromkeys(joint_of(anchor.tie) for anchor in found):
                self.notes.append(f"{place}: rigid where its node rests on {len(found)} faces and bodies at once")
            for anchor in found:
                self._join(anchor)
                rigid.add(id(anchor))
        self._averages = [anchor for anchor in self._averages if id(anchor) not in rigid]
        self._interpolations = [anchor for anchor in self._interpolations if id(anchor) not in rigid]
        return bool(rigid)

    def _join_rings(self) -> bool:
        """Rule 5. A solid's nodes cannot carry others rigidly: such rings are refused with the equations."""
        find = self._joined.find
        able = [item for item in self._interpolations if self.has_rotations[item.node]]
        rests = {find(item.node): {find(host) for host in item.hosts.tolist()} for item in able}
        in_ring = _going_round(rests)
        ring = [item for item in able if find(item.node) in in_ring]
        for place in dict.fromkeys(joint_of(item.tie) for item in ring):
            self.notes.append(f"{place}: rigid where its nodes rest on one another in a ring")
        for item in ring:
            self._join(item)
        gone = {id(item) for item in ring}
        self._interpolations = [item for item in self._interpolations if id(item) not in gone]
        return bool(ring)

    def _thin_patches(self) -> bool:
        leads = self._leads()
        kept: list[Average] = []
        for average in self._averages:
            own = self._joined.find(average.node)
            free = np.array(
                [not _reaches(leads, self._joined.find(n), own) for n in average.patch.tolist()], dtype=bool
            )
            patch, weights = average.patch[free], average.weights[free]
            if weights.sum() < MOST * average.weights.sum() and not self.is_rigid(average.tie):
                leads[own] = set()
                continue
            if not self.is_rigid(average.tie) and defines_rotation(self.nodes[patch], weights):
                leads[own] = {self._joined.find(n) for n in patch.tolist()}
                kept.append(replace(average, patch=patch, weights=weights))
                continue
            self._join(average)
        changed = len(kept) < len(self._averages)
        self._averages = kept
        return changed

    def _leads(self) -> dict[int, set[int]]:
        """By body, those that it follows: of its anchor's patch or hosts, or of its pair's other node."""
        find = self._joined.find
        leads: dict[int, set[int]] = {}
        for average in self._averages:
            leads.setdefault(find(average.node), set()).update(find(node) for node in average.patch.tolist())
        for item in self._interpolations:
            leads.setdefault(find(item.node), set()).update(find(host) for host in item.hosts.tolist())
        for pair in self.pairs:
            leads.setdefault(find(pair.node), set()).add(find(pair.independent))
        return leads

    def _join(self, anchor: Average | Interpolation) -> None:
        """The anchor's node and what it rests on move as one from now on."""
        others = anchor.patch if isinstance(anchor, Average) else anchor.hosts
        self._preferred[anchor.node] += 1
        for node in others.tolist():
            self._joined.join(anchor.node, node)

    def _bodies(self) -> list[Body]:
        """In the order of their heads."""
        anchors = {self._joined.find(anchor.node): anchor for anchor in self._anchors()}
        groups = self._joined.groups()
        for root, anchor in anchors.items():
            groups.setdefault(root, [anchor.node])
        bodies = []
        for root, members in groups.items():
            found = anchors.get(root)
            head = found.node if found is not None else self._head(members)
            bodies.append(Body(head, tuple(members), found))
        return sorted(bodies, key=lambda body: body.head)

    def _head(self, members: Sequence[int]) -> int:
        """The independent node of a body: the most preferred that has rotations, then the first."""
        able = [node for node in members if self.has_rotations[node]]
        if not able:
            place = ", ".join(f"{x:g}" for x in self.nodes[members[0]])
            raise ConnectError(f"the node ({place}) of a solid is to carry others rigidly, but has no rotations")
        return max(able, key=lambda node: (self._preferred[node], -node))

    def _pairs_once(self) -> list[Pair]:
        """A node asked to follow two follows the first; ConnectError where a joint is left without any."""
        done = self.dependents
        heads = {body.head for body in self.bodies}
        carried: dict[str, int] = {}
        kept = []
        for pair in self.pairs:
            place = joint_of(pair.tie)
            carried.setdefault(place, 0)
            if pair.node in done or pair.node in heads or pair.node == pair.independent:
                continue
            done.add(pair.node)
            carried[place] += 1
            kept.append(pair)
        for place, count in carried.items():
            if count == 0:
                raise ConnectError(f"{place}: every node of it already depends on another joint")
        return kept


def _reaches(leads: dict[int, set[int]], start: int, end: int) -> bool:
    """Whether what `start` follows, however long the chain, is `end`, or it is `end` itself."""
    seen, open_ones = {start}, [start]
    while open_ones:
        body = open_ones.pop()
        if body == end:
            return True
        fresh = leads.get(body, set()) - seen
        seen |= fresh
        open_ones += fresh
    return False


def _going_round(rests: dict[int, set[int]]) -> set[int]:
    """Those of the bodies that lie in rings, or between two, where each rests on the bodies listed with it."""
    left = {body: {other for other in others if other in rests} for body, others in rests.items()}
    while True:
        rested_on = set().union(*left.values())
        loose = {body for body, others in left.items() if not others or body not in rested_on}
        if not loose:
            return set(left)
        left = {body: others - loose for body, others in left.items() if body not in loose}


def defines_rotation(points: Array, weights: Array) -> bool:
    """Three points or more that do not lie on one line, so that their translations define a rigid motion.

    points: (n, 3); weights: (n,), positive: a point beside the line counts for nothing where its weight is nothing.
    """
    if len(points) < 3 or not weights.sum() > 0.0:
        return False
    share = weights / weights.sum()
    arms = (points - share @ points) * np.sqrt(share)[:, None]
    lengths = np.linalg.svd(arms, compute_uv=False)
    return bool(lengths[1] > FLATNESS * lengths[0])


def joint_of(tie: Tie) -> str:
    """How messages call the tie's joint."""
    if tie.joint is None:
        return "a joint"
    return f"joint {tie.joint.id} of {tie.joint.segments[0]} and {tie.joint.segments[1]}"
