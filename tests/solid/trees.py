"""Short ways to write CSG trees in tests."""

from __future__ import annotations

import numpy as np

from kernel.csg.tree import Boolean, CsgModel, CsgNode
from kernel.solid.evaluate import Evaluated, evaluate


def at(x: float = 0.0, y: float = 0.0, z: float = 0.0, linear: object = None) -> np.ndarray:
    """A placement: `linear` (3, 3) first, then a shift."""
    placement = np.eye(4)
    placement[:3, 3] = x, y, z
    if linear is not None:
        placement[:3, :3] = linear
    return placement


def turned(axis: object, degrees: float) -> np.ndarray:
    """(3, 3) rotation about `axis` (Rodrigues)."""
    x, y, z = np.asarray(axis, float) / np.linalg.norm(axis)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    angle = np.radians(degrees)
    return np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * cross @ cross


def union(*nodes: CsgNode) -> Boolean:
    return Boolean(operation="union", children=nodes)


def difference(*nodes: CsgNode) -> Boolean:
    return Boolean(operation="difference", children=nodes)


def intersection(*nodes: CsgNode) -> Boolean:
    return Boolean(operation="intersection", children=nodes)


def evaluated(root: CsgNode, language: str = "json") -> Evaluated:
    return evaluate(CsgModel(root=root, source="-", language=language))


def moved(node: CsgNode, placement: np.ndarray) -> CsgNode:
    """The tree with every primitive placed once more."""
    from dataclasses import replace

    if isinstance(node, Boolean):
        return replace(node, children=tuple(moved(child, placement) for child in node.children))
    if node.kind == "hull":
        return replace(node, members=tuple(moved(member, placement) for member in node.members))
    return replace(node, placement=placement @ node.placement)
