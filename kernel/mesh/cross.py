"""The direction that a region's mesh follows where nothing else says one, and the square front that grows along it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.constrained import Edges
from kernel.numeric.front import EARLY, LATE, RING, grow_front
from kernel.numeric.halfedge import BOUNDARY

_SCREEN = 0.2
"""Weight of the dominant direction against a neighbour cell's in the cross field."""
_DOMINANT_SHARE = 0.08
"""The field is pulled to the dominant direction if this share of the length that counts runs along it."""
_UPRIGHT = 1e-9
"""Radians under which a region stands upright already."""


def dominant_cross(
    points: NDArray[np.float64], edges: Edges, is_curved: NDArray[np.bool_]
) -> tuple[float, float, float]:
    """cos 4a and sin 4a of the direction that most of the straight boundary runs along, and the weight it deserves.

    is_curved: (n_edge,); where all is curved, all counts.
    """
    along = points[edges.end] - points[edges.start]
    length = np.hypot(along[:, 0], along[:, 1])
    counts = edges.kind == BOUNDARY
    if not is_curved.all():
        counts = counts & ~is_curved
    angle4 = 4 * np.arctan2(along[:, 1], along[:, 0])
    bucket = np.round(np.mod(angle4, 2 * np.pi) / (2 * np.pi) * 90).astype(np.int64) % 90
    weight = np.bincount(bucket, weights=length * counts, minlength=90)
    chosen = bucket == weight.argmax()
    angle = math.atan2((length * np.sin(angle4))[chosen].sum(), (length * np.cos(angle4))[chosen].sum())
    screen = _SCREEN if weight.max() > _DOMINANT_SHARE * (length * counts).sum() else 0.0
    return math.cos(angle), math.sin(angle), screen


def growth_order(
    n_point: int, edges: Edges, is_curved: NDArray[np.bool_], is_small_ring: NDArray[np.bool_] | None = None
) -> NDArray[np.uint8]:
    """When each point grows (see numeric.front): points of curves only late, those of small holes first.

    is_curved, is_small_ring: (n_edge,).
    """
    order = np.zeros(n_point, np.uint8)
    small = is_curved & is_small_ring if is_small_ring is not None else np.zeros(len(is_curved), np.bool_)
    for chosen, when in ((is_curved, LATE), (small, RING), (~is_curved, EARLY)):
        order[edges.start[chosen]] = when
        order[edges.end[chosen]] = when
    return order


def grow(
    points: NDArray[np.float64],
    edges: Edges,
    order: NDArray[np.uint8],
    size: float,
    growth: float,
    cross: tuple[float, float, float],
) -> NDArray[np.float64]:
    """The points, then the nodes of the square front.

    order: see growth_order; growth: see planar.mesh_region; cross: see dominant_cross.
    The front grows in a frame turned along the dominant direction: a turned region gets a turned mesh, and a long
    oblique one a grid that fits it.
    """
    cosine, sine, screen = cross
    angle = math.atan2(sine, cosine) / 4
    if abs(angle) < _UPRIGHT:
        return grow_front(points, *edges.arrays, order, float(size), cosine, sine, screen, growth)
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    nodes = grow_front(points @ turn, *edges.arrays, order, float(size), 1.0, 0.0, screen, growth) @ turn.T
    nodes[: len(points)] = points
    return nodes
