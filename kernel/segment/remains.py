"""Remains: what others left of a draft that was decided on its whole solid, and whether it is still what it was.

A post that a panel cuts along its length keeps a strip of its section; a plate sunk into another keeps part of its
thickness, here or all over. Neither is the beam or plate that its operand was, and is asked about again.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kernel.segment.prism import measure, sweep_along
from kernel.segment.slices import slice_polygon
from kernel.segment.walls import PlaneWall

if TYPE_CHECKING:
    from kernel.segment.shapes import Draft
    from kernel.solid.solid import Solid

LOST_SECTION = 0.05
"""Share of its section that a beam, or of its mean thickness that a plate, may lose and be the same: what a wall's
thickness may differ from its material's (see connect.reference)."""

SKIN = 0.1
"""What is left of a plate and thinner than this share of its thickness is a skin on what took the rest."""


def is_another(draft: Draft) -> bool:
    """Whether the draft's solid is no longer the beam of its section, or the plate of its thickness, that was decided.

    What a user decided stays.
    """
    if draft.solid is draft.whole or draft.is_pinned:
        return False
    if draft.type == "beam" and draft.prism is not None:
        left = measure(draft.solid, sweep_along(draft.solid, draft.prism.sweep.direction))
        return left is None or left.area < (1.0 - LOST_SECTION) * draft.prism.area
    if draft.type == "plate" and isinstance(draft.wall, PlaneWall):
        before, after = _mean_thickness(draft.whole, draft.wall), _mean_thickness(draft.solid, draft.wall)
        return abs(after - before) > LOST_SECTION * before
    return False


def is_skin(draft: Draft, rest: Solid) -> bool:
    """Whether the rest of a plate is so much thinner than it was that it is none."""
    if draft.type != "plate" or draft.wall is None or not isinstance(draft.wall, PlaneWall):
        return False
    return float(np.ptp(rest.facets.vertices @ draft.wall.normal)) < SKIN * draft.wall.thickness


def _mean_thickness(solid: Solid, wall: PlaneWall) -> float:
    """Volume over the area of the section half-way between the wall's faces; infinite where there is none."""
    middle = slice_polygon(solid.facets, wall.normal, 0.5 * (wall.bottom + wall.top), wall.u, wall.v)
    return solid.volume / middle.area if middle.area > 0.0 else np.inf
