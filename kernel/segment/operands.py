"""Operands: which solids a node splits into, and which paths of the tree mean the same material.

A difference or an intersection above a union reaches into the union's operands:

    (a UN b) DIF t   ->   a DIF t  and  b DIF t          (the paths are those of a and b)

Where the first operand of a difference is no union, the node and its first operand are the same material: an
override on either counts (`aliases`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING

import numpy as np

from kernel.csg.tree import CsgNode, Primitive, child_path, walk
from kernel.solid.solid import intersect, subtract

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated
    from kernel.solid.solid import Solid


@dataclass(frozen=True, slots=True, eq=False)
class Cut:
    """What an operation above a union does to each of its operands."""

    operation: str
    tools: tuple[CsgNode, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Operand:
    """A node of the tree, with the cuts of the operations above it (innermost first).

    aliases: paths of every node that is this same material, `path` among them.
    """

    path: str
    node: CsgNode
    cuts: tuple[Cut, ...]
    aliases: tuple[str, ...]

    @property
    def depth(self) -> int:
        """Steps from the root."""
        return 0 if self.path == "/" else self.path.count(".") + 1


def operand_at(path: str, node: CsgNode, cuts: tuple[Cut, ...] = ()) -> Operand:
    """The operand that `node` at `path` is under `cuts`."""
    aliases = [path]
    head, head_path = node, path
    while head.kind in ("difference", "intersection"):
        index = _union_below(head) if head.kind == "intersection" else 0
        head_path = child_path(head_path, index)
        head = head.operands[index]
        aliases.append(head_path)
    return Operand(path, node, cuts, tuple(aliases))


def operands_of(operand: Operand) -> tuple[Operand, ...]:
    """The two or more operands that `operand` splits into; () where it is one solid."""
    node, path, cuts = operand.node, operand.path, operand.cuts
    while node.kind != "union":
        if node.kind not in ("difference", "intersection"):
            return ()
        index = _union_below(node) if node.kind == "intersection" else 0
        others = node.operands[:index] + node.operands[index + 1 :]
        cuts = (Cut(node.kind, others), *cuts)
        path = child_path(path, index)
        node = node.operands[index]
    return tuple(operand_at(child_path(path, index), child, cuts) for index, child in enumerate(node.operands))


def _union_below(node: CsgNode) -> int:
    """Index of the first operand of an intersection that is, or leads to, a union; 0 where none does."""
    for index, operand in enumerate(node.operands):
        head = operand
        while head.kind == "difference":
            head = head.operands[0]
        if head.kind == "union" or (head.kind == "intersection" and _leads_to_union(head)):
            return index
    return 0


def _leads_to_union(node: CsgNode) -> bool:
    while node.kind in ("difference", "intersection"):
        node = node.operands[_union_below(node) if node.kind == "intersection" else 0]
    return node.kind == "union"


def tools_of(operand: Operand) -> Iterator[CsgNode]:
    """The nodes that differences take away from the operand."""
    for cut in operand.cuts:
        if cut.operation == "difference":
            yield from cut.tools
    head = operand.node
    while head.kind == "difference":
        yield from head.operands[1:]
        head = head.operands[0]


def operand_count(node: CsgNode) -> int:
    """Solids that a node splits into, those of a union among them in its place: however unions nest, at least 1."""
    count, stack = 0, [node]
    while stack:
        head = stack.pop()
        while head.kind in ("difference", "intersection"):
            head = head.operands[_union_below(head) if head.kind == "intersection" else 0]
        if head.kind == "union":
            stack.extend(head.operands)
        else:
            count += 1
    return count


def leaf_count(operand: Operand) -> int:
    """Primitives in the operand's sub-tree."""
    return sum(not node.operands for _, node in walk(operand.node))


LIKENED = ("block", "cylinder", "cone", "wedge", "sphere", "torus")
"""Primitives that a few numbers describe, so that copies are told apart cheaply."""


def likeness_key(operand: Operand) -> tuple | None:
    """Equal for operands that are copies of one another, moved without turning; None where that is not told cheaply."""
    node = operand.node
    if operand.cuts or not isinstance(node, Primitive) or node.kind not in LIKENED:
        return None
    sizes = [getattr(node, item.name) for item in fields(node) if item.name not in ("name", "place", "placement")]
    return (node.kind, node.placement[:3, :3].tobytes(), *sizes)


def solid_of(evaluated: Evaluated, operand: Operand) -> Solid:
    """The operand's solid, in the working frame; may be empty."""
    if operand.path == "/":
        return evaluated.solid
    solid = evaluated.solid_of(operand.node)
    for cut in operand.cuts:
        if solid.is_empty:
            return solid
        tools = [evaluated.solid_of(tool) for tool in cut.tools]
        if cut.operation == "difference":
            near = [tool for tool in tools if not tool.is_empty and _boxes_meet(solid, tool)]
            if near:
                solid = subtract(solid, near)
        else:
            solid = intersect([solid, *tools])
    return solid


def _boxes_meet(one: Solid, other: Solid) -> bool:
    return bool(np.all(one.bounds[0] <= other.bounds[1]) and np.all(other.bounds[0] <= one.bounds[1]))
