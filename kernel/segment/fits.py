"""How a tool stands to the solid that it is taken from, read from the two primitives alone; nothing is evaluated.

axes of a primitive     its own, as placed: x, y, z of a block, z of what is turned or extruded
span along a direction  lowest and highest coordinate that the primitive reaches, exact for true circles
through                 along an axis of its own the tool reaches at least as far as the head, both ways, and
                        they meet sideways
coaxial                 both are round about one line
concentric              the tool's axis (of a block: the one along which it passes through) or, where it has none,
                        its middle is at the head's middle
"""

from __future__ import annotations

import math
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from kernel.csg.tree import (
    Block,
    Cone,
    CsgNode,
    Cylinder,
    Extrusion,
    Polyhedron,
    Primitive,
    Revolution,
    Sphere,
    Torus,
    Wedge,
)
from kernel.facts import Value
from kernel.solid.bounds import standard_extent
from kernel.units import ANGLE_TOLERANCE

FLUSH = 1e-6
"""Share of the head's size within which ends are flush and lines are one: six-digit input tells no finer."""

ROUND = ("cylinder", "cone", "revolution", "torus", "sphere")

Span: TypeAlias = tuple[float, float]


def head_of(node: CsgNode) -> Primitive | None:
    """The primitive that a node's material comes from, below its differences; None where that is several."""
    while node.kind == "difference":
        node = node.operands[0]
    return node if isinstance(node, Primitive) and node.kind != "hull" else None


def diameter_of(node: CsgNode) -> float | None:
    """Of a cylinder, a sphere, or a cone at its wider end; None for all else."""
    match head_of(node):
        case Cylinder(radius=radius) | Sphere(radius=radius):
            return 2.0 * radius
        case Cone(bottom_radius=bottom, top_radius=top):
            return 2.0 * max(bottom, top)
    return None


def fit(tool: CsgNode, head: CsgNode) -> dict[str, Value]:
    """`is_through`, `is_coaxial`, `is_concentric` of a tool; what the two trees do not tell is left out."""
    body, cut = head_of(head), head_of(tool)
    if body is None or cut is None:
        return {}
    size = _size(body)
    values: dict[str, Value] = {"is_coaxial": _is_coaxial(cut, body, FLUSH * size)}
    passes: int | None = None
    axes = _axes(cut)
    if axes is not None:
        spans = [(_span(cut, axis), _span(body, axis)) for axis in axes]
        if all(of_cut is not None and of_body is not None for of_cut, of_body in spans):
            passes = _passes([(a, b) for a, b in spans if a is not None and b is not None], cut, FLUSH * size)
            values["is_through"] = passes is not None
    line = None if axes is None else 2 if cut.kind != "block" else passes
    away = _middle(body) - _middle(cut)
    if line is not None and axes is not None:
        away = away - axes[line] * (axes[line] @ away)
    values["is_concentric"] = bool(np.linalg.norm(away) <= FLUSH * size)
    return values


def _passes(spans: list[tuple[Span, Span]], cut: Primitive, slack: float) -> int | None:
    """Number of the axis along which the tool passes right through the head."""
    if any(min(a[1], b[1]) - max(a[0], b[0]) <= slack for a, b in spans):
        return None
    for number, (of_cut, of_body) in enumerate(spans):
        if cut.kind != "block" and number != 2:
            continue
        if of_cut[0] <= of_body[0] + slack and of_cut[1] >= of_body[1] - slack:
            return number
    return None


def _is_coaxial(cut: Primitive, body: Primitive, slack: float) -> bool:
    if cut.kind not in ROUND or body.kind not in ROUND:
        return False
    away = _middle(body) - _middle(cut)
    if cut.kind == "sphere" and body.kind == "sphere":
        return bool(np.linalg.norm(away) <= slack)
    line = _unit(body.placement[:3, 2]) if body.kind != "sphere" else _unit(cut.placement[:3, 2])
    if cut.kind != "sphere" and abs(float(_unit(cut.placement[:3, 2]) @ line)) < math.cos(ANGLE_TOLERANCE):
        return False
    return bool(np.linalg.norm(away - line * (line @ away)) <= slack)


def _axes(leaf: Primitive) -> NDArray[np.float64] | None:
    """(3, 3) the primitive's own axes in rows, the last one along what is turned or extruded; None: it has none."""
    if leaf.kind in ("sphere", "polyhedron"):
        return None
    return np.array([_unit(column) for column in leaf.placement[:3, :3].T])


def _middle(leaf: Primitive) -> NDArray[np.float64]:
    """Where the middle of the primitive's own box is placed."""
    low, high = standard_extent(leaf)
    return leaf.placement[:3, :3] @ (0.5 * (low + high)) + leaf.placement[:3, 3]


def _size(leaf: Primitive) -> float:
    low, high = standard_extent(leaf)
    return float(np.linalg.norm(leaf.placement[:3, :3] @ (high - low)))


def _span(leaf: Primitive, direction: NDArray[np.float64]) -> Span | None:
    """Lowest and highest coordinate of the placed primitive; None where no closed form says it."""
    across = leaf.placement[:3, :3].T @ direction
    origin = float(leaf.placement[:3, 3] @ direction)
    reach = [_reach(leaf, side * across) for side in (-1.0, 1.0)]
    if reach[0] is None or reach[1] is None:
        return None
    return origin - reach[0], origin + reach[1]


def _reach(leaf: Primitive, g: NDArray[np.float64]) -> float | None:
    """Largest g . x over the primitive in its standard position."""
    around = math.hypot(g[0], g[1])
    match leaf:
        case Block(size=size):
            return float(np.maximum(g * size, 0.0).sum())
        case Wedge(size=(x, y, z)):
            return float(max(0.0, g[0] * x, g[1] * y) + max(0.0, g[2] * z))
        case Cylinder(radius=radius, height=height):
            return radius * around + max(0.0, float(g[2]) * height)
        case Cone(bottom_radius=bottom, top_radius=top, height=height):
            return max(bottom * around, top * around + float(g[2]) * height)
        case Sphere(radius=radius):
            return radius * float(np.linalg.norm(g))
        case Torus(major_radius=major, minor_radius=minor):
            return major * around + minor * float(np.linalg.norm(g))
        case Extrusion(twist=0.0, scale=scale, loops=loops, height=height):
            flat = np.concatenate([np.asarray(loop) for loop in loops])
            return float(max((flat @ g[:2]).max(), ((flat * scale) @ g[:2]).max() + g[2] * height))
        case Revolution(angle=360.0, loops=loops):
            flat = np.concatenate([np.asarray(loop) for loop in loops])
            return float((flat[:, 0] * around + flat[:, 1] * g[2]).max())
        case Polyhedron(points=points):
            return float((points @ g).max())
    return None


def _unit(vector: NDArray[np.float64]) -> NDArray[np.float64]:
    return vector / np.linalg.norm(vector)
