"""How often a curve must be divided to show its bend."""

from __future__ import annotations

import math

import numpy as np

from kernel.idealise.carriers import Carrier, Circle, Traced
from kernel.idealise.tube_curve import TubeCurve

PER_TURN = 16
"""Elements round a hole, so that quads keep their shape."""

LARGE_PER_TURN = 24
"""Elements round a large circle: a pipe of so many facets has lost 0.3 % of its mass."""

LARGE = 3.0
"""A circle is large when its diameter is more than this many sizes."""

LEAST_PER_TURN = 8
"""Elements round a circle that is much smaller than the size."""

MUCH_SMALLER = 0.5
"""A circle is that when its diameter is under this share of the size."""


KINK = 0.3
"""A bend of more than this (radians) between neighbouring points of a guide is a corner."""


def least_divisions(carrier: Carrier, length: float, size: float, per_circle: int | None = None) -> int:
    """Into how many elements a piece of `length` of the carrier is divided at least: enough to show its bend.

    per_circle: elements round a full circle, instead of what its diameter and the size suggest.

    Two, so that quads alone can fill the faces beside it.
    """
    period = carrier.period
    if isinstance(carrier, Circle):
        turn = length / carrier.period
        diameter = 2 * carrier.radius
    elif isinstance(carrier, Traced | TubeCurve):
        turn = turning(carrier, length)
        diameter = (period or float(carrier.lengths[-1])) / math.pi
    else:
        return 2
    per_turn = LEAST_PER_TURN if diameter < MUCH_SMALLER * size else PER_TURN
    usual = LARGE_PER_TURN if diameter > LARGE * size else per_turn
    wanted = (per_circle or usual) * turn
    return max(2, 2 * math.ceil(wanted / 2 - 1e-6))


def turning(carrier: Traced | TubeCurve, length: float) -> float:
    """By how many full turns a traced curve bends over `length`, taking its bends as spread evenly.

    The sharp bends of a tube's curve have nodes, and do not count.
    """
    corners = np.vstack([carrier.guide, carrier.guide[:2]]) if carrier.is_closed else carrier.guide
    along = np.diff(corners, axis=0)
    along = along / np.linalg.norm(along, axis=1)[:, None]
    bends = np.arccos(np.clip(np.einsum("ij,ij->i", along[:-1], along[1:]), -1, 1))
    if isinstance(carrier, TubeCurve):
        bends = bends[bends < KINK]
    return float(bends.sum() / (2 * math.pi) * length / float(carrier.lengths[-1]))
