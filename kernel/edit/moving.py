"""Moving a node: on its surface, along its curve, or freely within a body; whatever it must not leave, it does not.

A finished mesh carries no geometry, so a node's surfaces and curve are found again from the nodes about it: planes and
cylinders of shells (kernel/edit/fitted.py), the flat outer faces of solids, and of a curve the line or the circle.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kernel.connect.model import Model, Mpc
from kernel.edit.edited import Edited
from kernel.edit.fitted import Fitted, FittedCylinder
from kernel.edit.patch import fitted_surface
from kernel.edit.surroundings import kept_edges
from kernel.edit.workpiece import Edge, Workpiece
from kernel.errors import MeshError, OptionError
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import Mesh
from kernel.mesh.quality import refuse_inverted
from kernel.places import place_text

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

AT_NODE = 1e-6
"""A place is a node's, or on a surface or curve, where it is nearer than this share of the model's size."""

FLAT = 1e-6
"""Normals of outer faces that differ by less are those of one plane."""

SMOOTH = np.cos(np.radians(30.0))
"""Outer faces whose normals differ by less than this angle, and are not flat, follow a curved surface."""


def move_node(edited: Edited, at: Array, to: Array) -> Edited:
    """Move the node at one place to another; mid-side nodes beside it move half as far, on the surface.

    A node of shells stays on the surface of each of its segments (where that is a plane or a cylinder), one on a curve
    (a rim, a joint, a beam's axis) moves along it, one on a flat outer face of a solid in its plane.

    OptionError: no node there. MeshError: the node would leave its surface or its curve, it is the end of a curve or
    several meet there, it stands in an equation or on rigid arms, or an element would be turned inside out.
    """
    model, reach = edited.model, AT_NODE * edited.reference.size
    node = node_at(model, at, edited.reference.size)
    work = Workpiece(model, edited.reference)
    start, goal = model.mesh.nodes[node], np.asarray(to, dtype=np.float64)
    who = f"the node at {place_text(start)}"
    beside = _beside(model.mesh, node)
    _refuse_tied(work, {node, *beside.tolist()}, who)
    surfaces = _surfaces(work, node)
    for segment, fitted in surfaces.items():
        _refuse_off(goal, fitted.lift(fitted.flat(goal[None]))[0], reach, f"{who} would leave the surface of {segment}")
    _refuse_off_faces(model.mesh, work, node, goal, reach, who)
    curve = _curve_of(work, node, list(surfaces), reach, who)
    if curve is not None:
        _refuse_off(goal, curve.nearest(goal), reach, f"{who} would leave the curve that it stands on")
        if not curve.is_between(goal):
            raise MeshError(f"{who} would pass its neighbour on the curve that it stands on")
    nodes = np.array(model.mesh.nodes)
    nodes[node] = goal
    for middle, far in _far_ends(work, node, beside):
        nodes[middle] += 0.5 * (goal - start)
        if curve is not None and middle in curve.neighbours:
            nodes[middle] = curve.nearest(0.5 * (goal + nodes[far]))
            continue
        for segment, fitted in surfaces.items():
            if isinstance(fitted, FittedCylinder) and _has(work, segment, middle):
                nodes[middle] = fitted.lift(fitted.flat(nodes[middle][None]))[0]
    nodes.flags.writeable = False
    moved = replace(model, mesh=Mesh(nodes, model.mesh.blocks))
    refuse_inverted(moved.mesh)
    return edited.done(moved, edited.reference, f"moved the node at {place_text(at)} to {place_text(nodes[node])}")


def node_at(model: Model, at: Array, size: float) -> int:
    """The node at a place; OptionError where there is none, with the nearest one's place."""
    distances = np.linalg.norm(model.mesh.nodes - np.asarray(at), axis=1)
    nearest = int(np.argmin(distances))
    if distances[nearest] > AT_NODE * size:
        raise OptionError(
            f"there is no node at {place_text(at)}, the nearest is at {place_text(model.mesh.nodes[nearest])}"
        )
    return nearest


def _refuse_off(goal: Array, on: Array, reach: float, what: str) -> None:
    beside = float(np.linalg.norm(goal - on))
    if beside > reach:
        raise MeshError(f"{what} by {beside:.4g}, expected a place on it: the nearest is {place_text(on)}")


def _refuse_tied(work: Workpiece, moving: set[int], who: str) -> None:
    for coupling in work.model.couplings:
        if isinstance(coupling, Mpc) and not moving.isdisjoint(coupling.nodes.tolist()):
            raise MeshError(f"{who} stands in an equation that holds only where it is")
    if not moving.isdisjoint(work.reference.arms.ravel().tolist()):
        raise MeshError(f"{who} hangs by a rigid arm, or carries one: both ends would have to move")


def _has(work: Workpiece, segment: str, node: int) -> bool:
    return any(block.segment == segment and bool((block.connectivity == node).any()) for block in work.blocks)


def _surfaces(work: Workpiece, node: int) -> dict[str, Fitted]:
    """The plane or cylinder of each segment of shells that has the node; a segment that is neither is left out."""
    found = {}
    for block in work.blocks:
        if ELEMENT_KINDS[block.kind].dimension == 2 and block.segment not in found and _has(work, block.segment, node):
            fitted = fitted_surface(work, block.segment, work.nodes[node])
            if fitted is not None:
                found[block.segment] = fitted
    return found


def _beside(mesh: Mesh, node: int) -> Indices:
    """Mid-side nodes of the edges that end at the node."""
    found = [np.empty(0, np.int64)]
    for block in mesh.blocks:
        kind = ELEMENT_KINDS[block.kind]
        if kind.order == 2:
            for place, edge in enumerate(kind.edges):
                ends = (block.connectivity[:, list(edge)] == node).any(axis=1)
                found.append(block.connectivity[ends, kind.n_corner + place])
    return np.unique(np.concatenate(found))


def _far_ends(work: Workpiece, node: int, beside: Indices) -> list[tuple[int, int]]:
    """(mid-side node, the other end of its edge) of each edge that ends at the node."""
    wanted = set(beside.tolist())
    pairs = {middle: edge for edge, middle in work.middles.items() if middle in wanted}
    return [(middle, edge[1] if edge[0] == node else edge[0]) for middle, edge in sorted(pairs.items())]


# ---------------------------------------------------------------- outer faces of solids


def _refuse_off_faces(mesh: Mesh, work: Workpiece, node: int, goal: Array, reach: float, who: str) -> None:
    """MeshError where a flat outer face of a solid would have to leave its plane."""
    ends = next((edge for edge, middle in work.middles.items() if middle == node), (node,))
    faces: Counter[tuple[int, ...]] = Counter()
    rings: dict[tuple[int, ...], tuple[str, list[int]]] = {}
    for block in mesh.blocks:
        kind = ELEMENT_KINDS[block.kind]
        if kind.dimension != 3:
            continue
        for row in block.connectivity[(block.connectivity == node).any(axis=1)].tolist():
            for corners in kind.faces:
                ring = [row[k] for k in corners]
                if set(ends) <= set(ring):
                    faces[tuple(sorted(ring))] += 1
                    rings[tuple(sorted(ring))] = block.segment, ring
    outer = [rings[key] for key, times in faces.items() if times == 1]
    normals = [_normal(mesh.nodes[ring]) for _, ring in outer]
    for k, (segment, ring) in enumerate(outer):
        turns = [
            float(normals[k] @ normals[other])
            for other, (_, beside) in enumerate(outer)
            if other != k and len(set(ring) & set(beside)) >= 2
        ]
        if any(SMOOTH < turn < 1.0 - FLAT**2 / 2 for turn in turns):
            continue  # of a curved surface, which nobody knows: the mass is checked
        on = goal - float((goal - mesh.nodes[node]) @ normals[k]) * normals[k]
        _refuse_off(goal, on, reach, f"{who} would leave the flat outer face of {segment}")


def _normal(corners: Array) -> Array:
    one, other = (corners[2], corners[3] - corners[1]) if len(corners) == 4 else (corners[1], corners[2] - corners[0])
    across = np.cross(one - corners[0], other)
    return across / np.linalg.norm(across)


# ---------------------------------------------------------------- curves


@dataclass(frozen=True, slots=True, eq=False)
class _Curve:
    """A line, or a circle where there is a centre, through a node and its two neighbours on the curve.

    ends: (2, 3) where the neighbours are. axis: (3,) unit, the line's direction or square to the circle.
    """

    neighbours: tuple[int, int]
    ends: Array
    axis: Array
    centre: Array | None = None
    radius: float = 0.0

    def nearest(self, place: Array) -> Array:
        """The place on the curve that is nearest."""
        if self.centre is None:
            along: Array = self.ends[0] + float((place - self.ends[0]) @ self.axis) * self.axis
            return along
        out = place - self.centre
        out = out - float(out @ self.axis) * self.axis
        on: Array = self.centre + self.radius * out / np.linalg.norm(out)
        return on

    def is_between(self, place: Array) -> bool:
        """Whether a place on the curve lies between the neighbours, the way that goes through the node."""
        first, last = self.ends - place
        if self.centre is None:
            return bool(first @ last < 0)
        return bool(np.cross(last, first) @ self.axis > 0)


def _curve_of(work: Workpiece, node: int, shells: list[str], reach: float, who: str) -> _Curve | None:
    """The curve on which the node stands, None within a face. MeshError where it is no place along one curve."""
    about = np.zeros(len(work.nodes), dtype=bool)
    about[node] = True
    for _ in range(2):
        for block in work.blocks:
            about[block.connectivity[about[block.connectivity].any(axis=1)]] = True
    kept: set[Edge] = set()
    for segment in shells:
        kept |= kept_edges(work, segment, about)
    for block in work.blocks:
        if ELEMENT_KINDS[block.kind].dimension == 1:
            pairs = np.sort(block.connectivity[:, :2], axis=1)
            kept |= {(a, b) for a, b in pairs[about[pairs].all(axis=1)].tolist()}
    next_to: dict[int, set[int]] = {}
    for edge in kept:
        chain = [edge[0], *([work.middles[edge]] if edge in work.middles else []), edge[1]]
        for a, b in pairwise(chain):
            next_to.setdefault(a, set()).add(b)
            next_to.setdefault(b, set()).add(a)
    beside = sorted(next_to.get(node, ()))
    if not beside:
        return None
    if len(beside) != 2:
        what = "the end of a curve" if len(beside) == 1 else f"where {len(beside)} curves meet"
        raise MeshError(f"{who} is {what}: it cannot move without changing the shape")
    first, last = beside
    further = {n for other in beside for n in next_to[other] if n != node and len(next_to[other]) == 2} - {first, last}
    return _through(work.nodes, (first, node, last), sorted(further), reach, who)


def _through(nodes: Array, three: tuple[int, int, int], further: list[int], reach: float, who: str) -> _Curve:
    """The line or circle through three nodes; a circle must go through those that lie further along, too."""
    first, node, last = three
    ends = nodes[[first, last]]
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    off = nodes[node] - ends[0]
    if np.linalg.norm(off - float(off @ along) * along) <= reach:
        return _Curve((first, last), ends, along)
    a, b = nodes[node] - ends[0], ends[1] - ends[0]
    across = np.cross(a, b)
    centre = ends[0] + (np.cross(across, a) * (b @ b) - np.cross(across, b) * (a @ a)) / (2 * float(across @ across))
    radius = float(np.linalg.norm(centre - ends[0]))
    curve = _Curve((first, last), ends, across / np.linalg.norm(across), centre, radius)
    if not further or any(np.linalg.norm(curve.nearest(place) - place) > reach for place in nodes[further]):
        raise MeshError(f"{who} is a corner, or stands on a curve that is neither straight nor round: it cannot move")
    return curve
