"""Which points a tree holds, from the definitions of its primitives alone: an oracle for tests."""

from __future__ import annotations

import math

import numpy as np

from kernel.csg.tree import (
    Block,
    Boolean,
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


def holds(node: CsgNode, points: np.ndarray) -> np.ndarray:
    """(n,) bool: the points (n, 3) inside the tree."""
    if isinstance(node, Boolean):
        results = [holds(child, points) for child in node.children]
        if node.operation == "union":
            return np.any(results, axis=0)
        if node.operation == "intersection":
            return np.all(results, axis=0)
        return results[0] & ~np.any(results[1:], axis=0)
    assert isinstance(node, Primitive)
    local = (points - node.placement[:3, 3]) @ np.linalg.inv(node.placement[:3, :3]).T
    return _standard(node, local)


def _standard(node: Primitive, p: np.ndarray) -> np.ndarray:
    x, y, z = p.T
    r = np.hypot(x, y)
    match node:
        case Block():
            return ((p >= 0) & (p <= node.size)).all(axis=1)
        case Cylinder():
            return (r <= node.radius) & (z >= 0) & (z <= node.height)
        case Cone():
            share = z / node.height
            limit = node.bottom_radius + (node.top_radius - node.bottom_radius) * share
            return (r <= limit) & (z >= 0) & (z <= node.height)
        case Wedge():
            w, d, h = node.size
            return (x >= 0) & (y >= 0) & (x / w + y / d <= 1) & (z >= 0) & (z <= h)
        case Sphere():
            return np.linalg.norm(p, axis=1) <= node.radius
        case Torus():
            return np.hypot(r - node.major_radius, z) <= node.minor_radius
        case Extrusion():
            share = z / node.height
            factor = 1 + (np.array(node.scale) - 1) * share[:, None]
            with np.errstate(divide="ignore", invalid="ignore"):
                flat = p[:, :2] / factor
            angle = np.radians(node.twist) * share
            turned = np.column_stack(
                [
                    flat[:, 0] * np.cos(angle) - flat[:, 1] * np.sin(angle),
                    flat[:, 0] * np.sin(angle) + flat[:, 1] * np.cos(angle),
                ]
            )
            return _even_odd(node.loops, turned) & (z >= 0) & (z <= node.height)
        case Revolution():
            turn = np.degrees(np.arctan2(y, x)) % 360.0
            return _even_odd(node.loops, np.column_stack([r, z])) & (turn <= node.angle)
        case Polyhedron():
            return _winds(node, p)
    raise AssertionError(node)


def _even_odd(loops: tuple[np.ndarray, ...], p: np.ndarray) -> np.ndarray:
    inside = np.zeros(len(p), dtype=bool)
    for loop in loops:
        for a, b in zip(loop, np.roll(loop, -1, axis=0)):
            straddles = (a[1] > p[:, 1]) != (b[1] > p[:, 1])
            with np.errstate(divide="ignore", invalid="ignore"):
                at = a[0] + (p[:, 1] - a[1]) * (b[0] - a[0]) / (b[1] - a[1])
            inside ^= straddles & (at > p[:, 0])
    return inside


def _winds(node: Polyhedron, p: np.ndarray) -> np.ndarray:
    """By the solid angle (van Oosterom and Strackee 1983) that the faces fill; faces clockwise from outside."""
    total = np.zeros(len(p))
    for face in node.faces:
        for k in range(1, len(face) - 1):
            a, b, c = (node.points[index] - p for index in (face[0], face[k + 1], face[k]))
            la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
            top = np.einsum("ij,ij->i", a, np.cross(b, c))
            dot = lambda u, v: np.einsum("ij,ij->i", u, v)  # noqa: E731
            total += 2 * np.arctan2(top, la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb)
    return total > 2 * math.pi
