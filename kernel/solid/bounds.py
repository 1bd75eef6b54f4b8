"""Boxes of a tree before it is evaluated, and the precision that its numbers can claim."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.csg.tree import (
    Block,
    Cone,
    CsgModel,
    CsgNode,
    Cylinder,
    Extrusion,
    Hull,
    Polyhedron,
    Primitive,
    Revolution,
    Sphere,
    Torus,
    Wedge,
    walk,
)
from kernel.units import MODEL_TOLERANCE, RIGID_TOLERANCE

THIN = 0.01
"""Coordinates are never drawn together over more than this share of the thinnest primitive."""


@dataclass(frozen=True, slots=True, eq=False)
class Box:
    """low, high: (3,) corners along the axes; empty where low > high."""

    low: NDArray[np.float64]
    high: NDArray[np.float64]

    @staticmethod
    def of_leaf(leaf: Primitive) -> Box:
        """Box in the model's axes of the primitive's own box, placed."""
        if isinstance(leaf, Hull):
            return _hull_of([box_of_tree(member) for member in leaf.members])
        low, high = standard_extent(leaf)
        corners = np.array([[(low, high)[k >> axis & 1][axis] for axis in range(3)] for k in range(8)])
        placed = corners @ leaf.placement[:3, :3].T + leaf.placement[:3, 3]
        return Box(placed.min(axis=0), placed.max(axis=0))

    @property
    def size(self) -> float:
        """Diagonal; 0 where empty."""
        return float(np.linalg.norm(np.maximum(self.high - self.low, 0.0)))

    @property
    def volume(self) -> float:
        """Volume; 0 where empty."""
        return float(np.prod(np.maximum(self.high - self.low, 0.0)))


def own_volume(leaf: Primitive) -> float:
    """Volume of the primitive's box in its own axes, the same however it is turned; a hull's, of its box."""
    if isinstance(leaf, Hull):
        return Box.of_leaf(leaf).volume
    low, high = standard_extent(leaf)
    return float(np.prod(high - low)) * abs(float(np.linalg.det(leaf.placement[:3, :3])))


def standard_extent(leaf: Primitive) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(low, high) of the primitive in its standard position."""
    match leaf:
        case Block() | Wedge():
            return np.zeros(3), np.array(leaf.size, dtype=np.float64)
        case Cylinder():
            r = leaf.radius
            return np.array([-r, -r, 0.0]), np.array([r, r, leaf.height])
        case Cone():
            r = max(leaf.bottom_radius, leaf.top_radius)
            return np.array([-r, -r, 0.0]), np.array([r, r, leaf.height])
        case Sphere():
            return np.full(3, -leaf.radius), np.full(3, leaf.radius)
        case Torus():
            r = leaf.major_radius + leaf.minor_radius
            return np.array([-r, -r, -leaf.minor_radius]), np.array([r, r, leaf.minor_radius])
        case Extrusion():
            flat = np.concatenate([np.asarray(loop) for loop in leaf.loops])
            reach = np.abs(flat).max() * np.sqrt(2.0) if leaf.twist else 0.0
            factor = np.maximum(1.0, np.array(leaf.scale))
            low, high = (flat * factor).min(axis=0), (flat * factor).max(axis=0)
            low, high = np.minimum(low, flat.min(axis=0)), np.maximum(high, flat.max(axis=0))
            if leaf.twist:
                low, high = np.minimum(low, -reach * factor.max()), np.maximum(high, reach * factor.max())
            return np.append(low, 0.0), np.append(high, leaf.height)
        case Revolution():
            flat = np.concatenate([np.asarray(loop) for loop in leaf.loops])
            r = float(flat[:, 0].max())
            return np.array([-r, -r, flat[:, 1].min()]), np.array([r, r, flat[:, 1].max()])
        case Polyhedron():
            return np.min(leaf.points, axis=0), np.max(leaf.points, axis=0)
    raise TypeError(f"a {leaf.kind} has no standard position")


def _hull_of(boxes: Sequence[Box]) -> Box:
    return Box(np.min([box.low for box in boxes], axis=0), np.max([box.high for box in boxes], axis=0))


def box_of_tree(root: CsgNode) -> Box:
    """A box around the tree's solid, by box arithmetic: unions join, intersections cut, tools do not count."""
    done: dict[int, Box] = {}
    stack: list[tuple[CsgNode, bool]] = [(root, False)]
    while stack:
        node, is_ready = stack.pop()
        if isinstance(node, Primitive):
            done[id(node)] = Box.of_leaf(node)
        elif not is_ready:
            stack.append((node, True))
            stack.extend((operand, False) for operand in node.operands)
        else:
            boxes = [done[id(operand)] for operand in node.operands]
            if node.kind == "difference":
                done[id(node)] = boxes[0]
            elif node.kind == "union":
                full = [box for box in boxes if (box.low <= box.high).all()]
                done[id(node)] = _hull_of(full) if full else boxes[0]
            else:
                low = np.max([box.low for box in boxes], axis=0)
                done[id(node)] = Box(low, np.min([box.high for box in boxes], axis=0))
    return done[id(root)]


def model_precision(model: CsgModel, leaves: Sequence[Primitive], box: Box) -> float:
    """Length within which two coordinates of the model are one.

    Exact input: MODEL_TOLERANCE of the size. OpenSCAD prints six digits, and a chain of placements adds up their
    rounding, in proportion to the largest coordinate on the way: RIGID_TOLERANCE of that, but never more than THIN
    of the thinnest primitive.
    """
    size = box.size if box.size > 0.0 else max((Box.of_leaf(leaf).size for leaf in leaves), default=1.0)
    tolerance = MODEL_TOLERANCE * size
    if model.language != "openscad":
        return tolerance
    reach = max(float(np.abs(box.low).max()), float(np.abs(box.high).max()), size)
    thinnest = min((_thickness(node) for _, node in walk(model.root) if isinstance(node, Primitive)), default=size)
    return max(tolerance, min(RIGID_TOLERANCE * reach, THIN * thinnest))


def _thickness(leaf: Primitive) -> float:
    """Least extent of the primitive in its own axes; a hull's, of its box."""
    if isinstance(leaf, Hull):
        box = Box.of_leaf(leaf)
        return float((box.high - box.low).min())
    low, high = standard_extent(leaf)
    return float(((high - low) * np.linalg.norm(leaf.placement[:3, :3], axis=0)).min())
