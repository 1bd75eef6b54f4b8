"""From the CSG tree to the evaluated solid, in the working frame.

Primitives are built in an order of their own (by kind and numbers, not by place in the tree) and operands that may be
swapped are folded in that order, so shuffled operands give the same surfaces, facets and sums.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, fields

import numpy as np
from manifold3d import Manifold, OpType
from numpy.typing import NDArray

from kernel.csg.tree import Boolean, CsgModel, CsgNode, Hull, Primitive, frozen_array, walk
from kernel.errors import DefectError, GeometryError
from kernel.solid.bounds import box_of_tree, model_precision, own_volume
from kernel.solid.frame import PlacedLeaf, WorkingFrame, choose_frame
from kernel.solid.hull import hull_manifold
from kernel.solid.primitives import build, check_numbers
from kernel.solid.setting import Setting
from kernel.solid.solid import Solid
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import CUTTER, NotSolidError, check_status

_OPERATIONS = {"union": OpType.Add, "difference": OpType.Subtract, "intersection": OpType.Intersect}

_TOOL_WEIGHT = 1e-6
"""What a primitive that is only taken away counts in the choice of the frame."""


@dataclass(frozen=True, eq=False)
class Evaluated:
    """The model's solid in the working frame.

    frame: (3, 3) rotation, world point = frame @ working point. size: diagonal of the solid's bounds.
    leaves: the primitives in the order of the tree; Facets.source is an index into them.
    """

    model: CsgModel
    solid: Solid
    frame: NDArray[np.float64]
    size: float
    leaves: tuple[Primitive, ...]
    _built: dict[int, Manifold] = field(repr=False)
    _solids: dict[int, Solid] = field(repr=False)
    _rank: dict[int, int] = field(repr=False)

    @property
    def surfaces(self) -> SurfaceTable:
        """The surface table that all solids of this model share."""
        return self.solid.surfaces

    def solid_of(self, node: CsgNode) -> Solid:
        """The solid of a node or of any tree made of this model's primitives, in the working frame; may be empty.

        The same node is evaluated once. DefectError: a primitive that is none of this model's.
        """
        known = self._solids.get(id(node))
        if known is not None:
            return known
        solid = Solid(_fold(node, self._built, self._rank), self.surfaces)
        self._solids[id(node)] = solid
        self._keep.append(node)
        return solid

    def solid_of_operands(self, operation: str, operands: Sequence[CsgNode]) -> Solid:
        """The solid of `operation` (union, difference, intersection) on nodes of this model; may be empty."""
        if len(operands) == 1:
            return self.solid_of(operands[0])
        return Solid(
            _fold(Boolean(operation=operation, children=tuple(operands)), self._built, self._rank), self.surfaces
        )

    _keep: list[CsgNode] = field(default_factory=list, repr=False)
    """Nodes whose solids are known by identity must outlive the entry."""


def evaluate(model: CsgModel) -> Evaluated:
    """Evaluate the whole model. GeometryError: a primitive without volume or with an open surface; an empty model."""
    paths = {id(node): path for path, node in walk(model.root)}
    leaves = tuple(node for _, node in walk(model.root) if isinstance(node, Primitive))
    for leaf in leaves:
        for part in _all_primitives(leaf):
            with _naming(part, paths[id(leaf)]):
                check_numbers(part)
    shape = box_of_tree(model.root)
    if not shape.size > 0.0:  # an intersection of parts whose boxes do not even meet
        root = model.root
        raise GeometryError(f"the {root.kind} at {_called(root, '/')} is empty, expected a solid", place=root.place)
    precision = model_precision(model, leaves, shape)
    angle_tolerance = SurfaceTable(precision, shape.size).angle_tolerance
    frame = choose_frame(_weigh(model.root), precision, angle_tolerance)
    table = SurfaceTable(precision, shape.size)

    rank = _ranks(leaves)
    index = {id(leaf): number for number, leaf in reversed(list(enumerate(leaves)))}
    built: dict[int, Manifold] = {}
    for leaf in sorted(leaves, key=lambda leaf: rank[id(leaf)]):
        if id(leaf) not in built:
            built[id(leaf)] = _leaf(leaf, paths[id(leaf)], index[id(leaf)], table, frame)
    solid = Solid(_fold(model.root, built, rank), table)
    _check(solid, model.root, paths, built, rank)
    return Evaluated(
        model, solid, frozen_array(frame.rotation), solid.size, leaves, built, {id(model.root): solid}, rank
    )


# ---- leaves


def _leaf(leaf: Primitive, path: str, source: int, table: SurfaceTable, frame: WorkingFrame) -> Manifold:
    with _naming(leaf, path):
        if isinstance(leaf, Hull):
            return hull_manifold(_members(leaf, path, table, frame), table, source)
        return build(leaf, Setting(table, frame.place(leaf.placement, table.angle_tolerance), source))


@contextmanager
def _naming(leaf: Primitive, path: str) -> Iterator[None]:
    """Turn NotSolidError into a GeometryError that names the primitive and its place."""
    try:
        yield
    except NotSolidError as error:
        message = f"the {leaf.kind} at {_called(leaf, path)} is no solid: {error}"
        raise GeometryError(message, place=leaf.place) from error


def _all_primitives(leaf: Primitive) -> Iterator[Primitive]:
    """The primitive, and those in it where it is a hull."""
    stack: list[Primitive] = [leaf]
    while stack:
        here = stack.pop()
        yield here
        if isinstance(here, Hull):
            stack += [node for member in here.members for _, node in walk(member) if isinstance(node, Primitive)]


def _called(node: CsgNode, path: str) -> str:
    return path if node.name is None else f"{path} ({node.name})"


def _members(hull: Hull, path: str, table: SurfaceTable, frame: WorkingFrame) -> list[Solid]:
    """The hull's members as solids; their primitives are no leaves of the model."""
    solids = []
    for member in hull.members:
        inner = [node for _, node in walk(member) if isinstance(node, Primitive)]
        rank = _ranks(inner)
        built = {id(leaf): _leaf(leaf, path, CUTTER, table, frame) for leaf in inner}
        solids.append(Solid(_fold(member, built, rank), table))
    return solids


def _ranks(leaves: Sequence[Primitive]) -> dict[int, int]:
    """Place of every leaf in an order that does not depend on the tree; equal leaves keep the tree's order."""
    order = sorted(
        range(len(leaves)), key=lambda number: (_KIND_ORDER.get(leaves[number].kind, 99), _key(leaves[number]))
    )
    return {id(leaves[number]): place for place, number in reversed(list(enumerate(order)))}


_KIND_ORDER = {
    kind: place
    for place, kind in enumerate(
        ("block", "wedge", "extrusion", "cylinder", "revolution", "cone", "sphere", "torus", "polyhedron", "hull")
    )
}
"""Square primitives first: they say where planes stand, round ones follow."""


def _key(leaf: Primitive) -> str:
    """What the leaf is and where, as text that sorts the same in every run."""
    parts = []
    for item in fields(leaf):
        if item.name in ("name", "place"):
            continue
        value = getattr(leaf, item.name)
        if item.name == "members":
            parts.append(
                repr([_key(node) for member in value for _, node in walk(member) if isinstance(node, Primitive)])
            )
        elif isinstance(value, np.ndarray):
            parts.append(repr(np.asarray(value).tolist()))
        elif item.name == "loops":
            parts.append(repr([np.asarray(loop).tolist() for loop in value]))
        else:
            parts.append(repr(value))
    return ";".join(parts)


def _weigh(root: CsgNode) -> list[PlacedLeaf]:
    """Every leaf with the volume it counts with: that of its own box, hardly any if it is taken away."""
    rows: list[PlacedLeaf] = []
    stack: list[tuple[CsgNode, float]] = [(root, 1.0)]
    while stack:
        node, factor = stack.pop()
        if isinstance(node, Hull):
            stack.extend((member, factor) for member in node.members)
        elif isinstance(node, Primitive):
            if node.kind != "sphere":
                turns = node.kind in ("cylinder", "cone", "torus")
                rows.append(PlacedLeaf(np.asarray(node.placement), factor * own_volume(node), turns))
        else:
            for number, operand in enumerate(node.operands):
                taken = node.kind == "difference" and number > 0
                stack.append((operand, factor * _TOOL_WEIGHT if taken else factor))
    return rows


# ---- Booleans


def _fold(root: CsgNode, built: dict[int, Manifold], rank: dict[int, int]) -> Manifold:
    """The tree's manifold, not forced: nested Booleans of one kind are folded in one batch. Not recursive."""
    done: dict[int, tuple[Manifold, int]] = {}
    stack: list[tuple[CsgNode, list[CsgNode] | None]] = [(root, None)]
    while stack:
        node, operands = stack.pop()
        if id(node) in done:
            continue
        if isinstance(node, Primitive):
            if id(node) not in built:
                raise DefectError(f"a {node.kind} that is no primitive of the evaluated model")
            done[id(node)] = built[id(node)], rank[id(node)]
        elif operands is None:
            operands = _flat_operands(node)
            stack.append((node, operands))
            stack.extend((operand, None) for operand in operands if id(operand) not in done)
        else:
            rows = [done[id(operand)] for operand in operands]
            fixed = 1 if node.kind == "difference" else 0
            rows[fixed:] = sorted(rows[fixed:], key=lambda row: row[1])
            manifold = Manifold.batch_boolean([row[0] for row in rows], _OPERATIONS[node.kind])
            done[id(node)] = manifold, min(row[1] for row in rows)
    return done[id(root)][0]


def _flat_operands(node: CsgNode) -> list[CsgNode]:
    """Operands with those of the same kind opened: a+(b+c) as a+b+c, (a-b)-c as a-b-c, a-(b+c) as a-b-c."""
    found: list[CsgNode] = []
    opens = "union" if node.kind == "difference" else node.kind
    stack: list[tuple[CsgNode, bool]] = [
        (operand, number == 0 and node.kind == "difference")
        for number, operand in reversed(list(enumerate(node.operands)))
    ]
    while stack:
        operand, is_head = stack.pop()
        if is_head and operand.kind == "difference":
            stack.extend((inner, number == 0) for number, inner in reversed(list(enumerate(operand.operands))))
        elif not is_head and operand.kind == opens:
            stack.extend((inner, False) for inner in reversed(operand.operands))
        else:
            found.append(operand)
    return found


def _check(
    solid: Solid, root: CsgNode, paths: dict[int, str], built: dict[int, Manifold], rank: dict[int, int]
) -> None:
    """GeometryError where the model is empty, naming the deepest node along the heads that is."""
    try:
        check_status(solid.manifold)
    except NotSolidError as error:
        raise GeometryError(f"the {root.kind} at / cannot be evaluated: {error}", place=root.place) from error
    if not solid.is_empty and solid.volume > 0.0:
        return
    node = root
    while node.operands:
        empty = [operand for operand in node.operands if _fold(operand, built, rank).is_empty()]
        if not empty or (node.kind == "difference" and empty[0] is not node.operands[0]):
            break
        node = empty[0]
    raise GeometryError(
        f"the {node.kind} at {_called(node, paths[id(node)])} is empty, expected a solid",
        place=node.place or root.place,
    )
