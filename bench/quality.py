"""Measures of planar meshes that the benchmarks print, written anew: not the mesher's own."""

from __future__ import annotations

import numpy as np


def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def on_cylinder(x: np.ndarray, period: float | None) -> np.ndarray:
    """Corners (n, k, 2) with each element in one piece."""
    if period is None:
        return x
    x = x.copy()
    x[..., 0] -= period * np.round((x[..., 0] - x[:, :1, 0]) / period)
    return x


def triangle_angles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Smallest angle of each, degrees."""
    x = points[triangles]
    ahead = np.roll(x, -1, 1) - x
    back = -np.roll(ahead, 1, 1)
    return np.degrees(np.arctan2(cross(ahead, back), (ahead * back).sum(2))).min(1)


def quad_quality(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Scaled Jacobian and aspect (longest edge times perimeter over four areas) of quads (n, 4, 2)."""
    edge = np.roll(x, -1, 1) - x
    back = np.roll(edge, 1, 1)
    length = np.hypot(edge[..., 0], edge[..., 1])
    jacobian = (cross(back, edge) / (length * np.roll(length, 1, 1))).min(1)
    area = 0.5 * np.abs(cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]))
    return jacobian, length.max(1) * length.sum(1) / (4 * area)


def irregular_share(n_node: int, quads: np.ndarray) -> float:
    """Share of inner nodes with other than four neighbours."""
    pairs = np.sort(np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1)
    sides, uses = np.unique(pairs, axis=0, return_counts=True)
    valence = np.bincount(sides.ravel(), minlength=n_node)
    is_inner = valence > 0
    is_inner[sides[uses == 1].ravel()] = False
    return float((valence[is_inner] != 4).mean())
