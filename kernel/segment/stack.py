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

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.segment.prism import CAP_SHARE, PARALLEL
from kernel.solid.surfaces import ConeSurface, CylinderSurface, Plane, SphereSurface, TorusSurface
from kernel.units import MODEL_TOLERANCE

if TYPE_CHECKING:
    from kernel.solid.solid import Solid

Vector = NDArray[np.float64]

Layer = tuple[float, float]
"""Start and end along the direction."""

WORDS: dict[type, str] = {
    Plane: "oblique plane",
    CylinderSurface: "cylinder across it",
    ConeSurface: "cone",
    SphereSurface: "sphere",
    TorusSurface: "torus",
}
"""Faces in the way of a stack."""


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


@dataclass(frozen=True, slots=True, eq=False)
class Obstacle:
    """What keeps a solid from being a stack along `direction`: `what` it is, in words, and a place on it (3,)."""

    direction: Vector
    what: str
    place: Vector


def obstacle(solid: Solid, directions: Sequence[Vector]) -> Obstacle | None:
    """The largest face in the way along the direction that has the least area in the way; None without directions."""
    facets = solid.facets
    best: tuple[float, Obstacle] | None = None
    for direction in directions:
        tilt = np.abs(facets.normals @ direction)
        in_way = np.where((tilt >= PARALLEL) & (tilt <= 1.0 - PARALLEL), facets.areas, 0.0)
        area = float(in_way.sum())
        if best is None or area < (1.0 - MODEL_TOLERANCE) * best[0]:
            number = int(np.bincount(facets.surface, in_way).argmax())
            row = int(np.argmax(np.where(facets.surface == number, in_way, 0.0)))
            what = WORDS.get(type(solid.surfaces.surfaces[number]), "freely shaped face")
            best = (area, Obstacle(direction, what, facets.centroids[row]))
    return None if best is None else best[1]
