"""Is a solid a stack of prisms along a direction: sections that change at levels only, and not between them.

    direction ^    +---+           level 2
              |    |   |
              | +--+   +--+        level 1
              | |         |
              | +---------+        level 0

Every face is parallel to the direction, or lies in a level across it: a stepped shaft, a plate with a boss, a block
with a blind hole.
"""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.segment.prism import CAP_SHARE, PARALLEL
from kernel.units import MODEL_TOLERANCE

if TYPE_CHECKING:
    from kernel.solid.solid import Solid

Vector = NDArray[np.float64]

Layer = tuple[float, float]
"""Start and end along the direction."""


def layers_along(solid: Solid, direction: Vector) -> tuple[Layer, ...]:
    """The layers of the stack that the solid is along the unit `direction`, lowest first; none where it is no stack.

    One layer: the solid is a prism. Faces across the direction that hold no area (slivers) make no level.
    """
    facets = solid.facets
    tilt = np.abs(facets.normals @ direction)
    is_across = tilt > 1.0 - PARALLEL
    total = float(facets.areas.sum())
    if float(facets.areas[(tilt >= PARALLEL) & ~is_across].sum()) > CAP_SHARE * total:
        return ()
    height = (facets.centroids @ direction)[is_across]
    order = np.argsort(height, kind="stable")
    height, areas = height[order], facets.areas[is_across][order]
    if not len(height):
        return ()
    group = np.cumsum(np.append(False, np.diff(height) > MODEL_TOLERANCE * solid.size))
    weight = np.bincount(group, areas)
    level = np.bincount(group, areas * height) / np.where(weight > 0.0, weight, 1.0)
    return tuple(pairwise(level[weight > CAP_SHARE * total].tolist()))
