"""Seeding: how often a curve is divided, and the nodes that come of it."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.carriers import Carrier, Circle, Traced

PER_TURN = 16
"""Elements round a circle, so that its area is within 2.6 % and quads keep their shape."""

LEAST_PER_TURN = 8
"""Elements round a circle that is much smaller than the size."""

MUCH_SMALLER = 0.5
"""A circle is that when its diameter is under this share of the size."""


def divisions(carrier: Carrier, length: float, size: float) -> int:
    """Into how many elements a curve of `length` on the carrier is divided: even, so that quads alone can fill."""
    count = 2 * max(1, round(length / size / 2))
    period = carrier.period
    turn: float | None = None
    if isinstance(carrier, Circle):
        turn = length / carrier.period
        diameter = 2 * carrier.radius
    elif isinstance(carrier, Traced):
        turn = turning(carrier, length)
        diameter = (period or float(carrier.lengths[-1])) / math.pi
    if turn is not None:
        wanted = (LEAST_PER_TURN if diameter < MUCH_SMALLER * size else PER_TURN) * turn
        count = max(count, 2 * math.ceil(wanted / 2 - 1e-6))
    return count


def turning(carrier: Traced, length: float) -> float:
    """By how many full turns a traced curve bends over `length`, taking its bends as spread evenly."""
    corners = np.vstack([carrier.guide, carrier.guide[:2]]) if carrier.is_closed else carrier.guide
    along = np.diff(corners, axis=0)
    along = along / np.linalg.norm(along, axis=1)[:, None]
    bends = np.arccos(np.clip(np.einsum("ij,ij->i", along[:-1], along[1:]), -1, 1)).sum()
    return float(bends / (2 * math.pi) * length / float(carrier.lengths[-1]))


def inner_points(carrier: Carrier, start: float, end: float, count: int) -> NDArray[np.float64]:
    """The points (count - 1, 3) between the ends of a curve, evenly spaced."""
    return carrier.at(start + (end - start) * np.arange(1, count) / count)
