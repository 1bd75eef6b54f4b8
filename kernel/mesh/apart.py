"""Meshing apart: the curves that two faces share are torn, so that each divides its own copy and has nodes of its own.

    v---c---w            v---c---w      The geometry stays joined: mid-surfaces still meet in the curve c. At a
A   |   |   |  B  ->  A  |     v'--c'--w'   B      vertex the faces stay together as far as pairs that are not
    ...                                            apart hold them together.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from kernel.connect.bodies import Bodies
from kernel.connect.joints import Joint
from kernel.errors import OptionError
from kernel.idealise.arms import TeeOf, extended
from kernel.idealise.parts import Parts
from kernel.idealise.topology import Curve, Topology

Apart = Callable[[int, int], bool]
"""Whether two faces are meshed apart."""

HANGING = ("tee", "pipe")
"""Kinds of joints at which a wall may end within another."""

SHOWN = 6
"""Joints that a warning names."""


def wanted_apart(joints: Sequence[Joint], apart: Collection[str]) -> frozenset[str]:
    """Ids of the joints to be meshed apart, checked. OptionError: there is no such joint."""
    known = dict.fromkeys(joint.id for joint in joints)
    for name in sorted(apart):
        if name not in known:
            raise OptionError(f"no joint {name!r} in the model, expected one of {', '.join(known) or 'none'}")
    return frozenset(apart)


def joined_tees(tee_of: TeeOf, joints: Sequence[Joint], apart: Collection[str]) -> TeeOf:
    """The same choice of tees, but extended ones where a joint is apart: nothing hangs from what is not joined."""
    pairs = torn_pairs(joints, apart)
    return lambda along: extended(along) if frozenset(along[0].segments) in pairs else tee_of(along)


def torn_pairs(joints: Sequence[Joint], apart: Collection[str]) -> set[frozenset[str]]:
    """The pairs of segments all of whose joints are apart."""
    held = {frozenset(joint.segments) for joint in joints if joint.id not in apart}
    return {frozenset(joint.segments) for joint in joints if joint.id in apart} - held


def half_apart(walls: Collection[str], joints: Sequence[Joint], apart: Collection[str]) -> list[str]:
    """A line for each joint of two walls that is to be apart, while another of theirs is not. walls: segment ids."""
    pairs = torn_pairs(joints, apart)
    lines = []
    for joint in joints:
        if (
            joint.id in apart
            and frozenset(joint.segments) not in pairs
            and all(name in walls for name in joint.segments)
        ):
            others = [o.id for o in joints if set(o.segments) == set(joint.segments) and o.id not in apart]
            lines.append(
                f"{joint.id} is not apart, for {' and '.join(joint.segments)} are joined by {' and '.join(others)} "
                "too; expected all of them apart"
            )
    return lines


def lost_arms(
    tee: str, of_joint: Mapping[str, str], joints: Sequence[Joint], apart: Collection[str], only: Collection[str] | None
) -> list[str]:
    """A line where arms are asked of joints that are apart.

    tee, of_joint: as in MeshOptions. only: ids of the segments to mesh, None for all.
    """
    pairs = torn_pairs(joints, apart)
    lost = [
        joint.id
        for joint in joints
        if frozenset(joint.segments) in pairs
        and (only is None or any(name in only for name in joint.segments))
        and of_joint.get(joint.id, tee if joint.kind in HANGING else "extend") == "arms"
    ]
    if not lost:
        return []
    more = f" and {len(lost) - SHOWN} more" if len(lost) > SHOWN else ""
    return [
        f"{', '.join(lost[:SHOWN])}{more}: no arms, for nothing hangs across what is meshed apart (--apart, "
        "--joint JOINT=apart); mid-surfaces are carried on to one another there, expected arms or apart, not both"
    ]


def faces_apart(parts: Parts, joints: Sequence[Joint], apart: Collection[str]) -> Apart:
    """Two walls are apart where every joint that they have is; where all joints are, any two walls."""
    if apart and all(joint.id in apart for joint in joints):
        return lambda one, other: one != other
    pairs = {
        frozenset(parts.walls[name].index for name in pair)
        for pair in torn_pairs(joints, apart)
        if all(name in parts.walls for name in pair)
    }
    return lambda one, other: frozenset((one, other)) in pairs


def torn(topology: Topology, curves: Sequence[Curve], faces: Collection[int], is_apart: Apart) -> list[Curve]:
    """The curves of the faces, one copy for each group of faces that stays together, with vertices of their own."""
    at_vertex: dict[int, set[int]] = {}
    for curve in curves:
        for vertex in curve.vertices:
            at_vertex.setdefault(vertex, set()).update(set(curve.uses) & set(faces))
    copies: dict[tuple[int, int], int] = {}
    for vertex, around in at_vertex.items():
        for number, group in enumerate(_groups(around, is_apart)):
            own = vertex if number == 0 else topology.vertices.copy(vertex)
            copies.update({(vertex, face): own for face in group})
    found = []
    for curve in curves:
        for group in _groups(set(curve.uses) & set(faces), is_apart):
            first, last = (copies[vertex, group[0]] for vertex in curve.vertices)
            uses = {face: use for face, use in curve.uses.items() if face in group}
            found.append(replace(curve, uses=uses, vertices=(first, last)))
    return found


def count_pieces(
    segments: Iterable[str], joints: Sequence[Joint], apart: Collection[str], meshed: Collection[str]
) -> int:
    """In how many pieces the meshed segments are, joined by all joints that are not apart."""
    order = {name: number for number, name in enumerate(segments)}
    bodies = Bodies()
    for joint in joints:
        if joint.id not in apart:
            bodies.join(*(order[name] for name in joint.segments))
    return len({bodies.find(order[name]) for name in meshed})


def _groups(faces: Collection[int], is_apart: Apart) -> list[list[int]]:
    """Faces that stay together, each group in order and the groups by their first face."""
    ordered = sorted(faces)
    bodies = Bodies()
    for place, one in enumerate(ordered):
        for other in ordered[place + 1 :]:
            if not is_apart(one, other):
                bodies.join(one, other)
    groups: dict[int, list[int]] = {}
    for face in ordered:
        groups.setdefault(bodies.find(face), []).append(face)
    return list(groups.values())
