"""The same model moved, scaled, mirrored, written in another order: what must not change the answer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from kernel.csg.tree import Boolean, CsgModel, CsgNode, Hull


def rebuilt(node: CsgNode, placed: np.ndarray, order: Callable[[list], list]) -> CsgNode:
    """The tree with every primitive moved by `placed` (4, 4) and free operands in another order."""
    if isinstance(node, Boolean):
        children = [rebuilt(child, placed, order) for child in node.children]
        fixed = 1 if node.operation == "difference" else 0
        return replace(node, children=(*children[:fixed], *order(children[fixed:])))
    if isinstance(node, Hull):
        return replace(node, members=tuple(rebuilt(member, placed, order) for member in node.members))
    return replace(node, placement=placed @ node.placement)


def moved(model: CsgModel, placed: np.ndarray) -> CsgModel:
    """The model under an affine map of space."""
    return replace(model, root=rebuilt(model.root, placed, list))


def shuffled(model: CsgModel, seed: int) -> CsgModel:
    """The model with the operands of unions and intersections, and the tools of differences, in another order."""
    generator = np.random.default_rng(seed)
    return replace(
        model, root=rebuilt(model.root, np.eye(4), lambda items: [items[k] for k in generator.permutation(len(items))])
    )


def rigid(angles: tuple[float, float, float], shift: tuple[float, float, float]) -> np.ndarray:
    """(4, 4) rotation about x, then y, then z, in radians, then a shift."""
    placed = np.eye(4)
    for axis, angle in enumerate(angles):
        c, s = np.cos(angle), np.sin(angle)
        turn = np.eye(4)
        i, j = (axis + 1) % 3, (axis + 2) % 3
        turn[i, i], turn[i, j], turn[j, i], turn[j, j] = c, -s, s, c
        placed = turn @ placed
    placed[:3, 3] = shift
    return placed


def scaled_answer(answer: list[dict], factor: float) -> list[dict]:
    """What an analyst expects of the model scaled by `factor`."""
    power = {"length": 1, "thickness": 1, "radius": 1, "area": 2}
    return [
        {name: value * factor ** power[name] if name in power else value for name, value in item.items()}
        for item in answer
    ]
