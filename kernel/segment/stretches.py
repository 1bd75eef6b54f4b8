"""Stretches along an axis: regions of an unrolled cylinder by height, and whether material goes on between them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from shapely import Polygon

from kernel.solid.facets import Facets
from kernel.solid.surfaces import Axis

Array = NDArray[np.float64]

ASIDE = 0.0123
"""Angle (radians) by which lines along the axis stand beside places that a model may have used."""


def heights_apart(facets: Facets, axis: Axis, radius: float, parts: Sequence[Polygon]) -> list[list[Polygon]]:
    """Parts of a region (angle, height) in groups, from below, between which there is no material at the radius."""
    groups: list[list[Polygon]] = []
    top = -np.inf
    for part in sorted(parts, key=lambda part: (part.bounds[1], part.bounds[0])):
        low, high = part.bounds[1], part.bounds[3]
        if not groups or (low > top and not _goes_on(facets, axis, radius, [*groups[-1], part], 0.5 * (top + low))):
            groups.append([])
        groups[-1].append(part)
        top = max(top, high)
    return groups


def _goes_on(facets: Facets, axis: Axis, radius: float, parts: Sequence[Polygon], height: float) -> bool:
    """Whether there is material at the height and radius, above or below any of the parts."""
    return any(_is_inside(facets, axis, radius, part.representative_point().x + ASIDE, height) for part in parts)


def _is_inside(facets: Facets, axis: Axis, radius: float, angle: float, height: float) -> bool:
    """Whether a point is in the solid: a line up to it along the axis enters once more than it leaves."""
    at = radius * np.array([np.cos(angle), np.sin(angle)])
    arms = (facets.vertices - axis.point) @ np.stack([axis.x, axis.y, axis.direction], axis=1)
    a, b, c = (arms[facets.triangles[:, k]] for k in range(3))
    areas = [_twice_area(p, q, at) for p, q in ((b, c), (c, a), (a, b))]
    up = (areas[0] > 0) & (areas[1] > 0) & (areas[2] > 0)
    down = (areas[0] < 0) & (areas[1] < 0) & (areas[2] < 0)
    crossed = np.flatnonzero(up | down)
    weights = np.stack([area[crossed] for area in areas])
    heights = (weights * np.stack([corner[crossed, 2] for corner in (a, b, c)])).sum(axis=0) / weights.sum(axis=0)
    below = crossed[heights < height]
    return int(np.count_nonzero(down[below])) > int(np.count_nonzero(up[below]))


def _twice_area(
    first: NDArray[np.float64], second: NDArray[np.float64], at: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Signed, of the triangles from points (n, 3) seen along the axis to a place (2,)."""
    one, other = first[:, :2] - at, second[:, :2] - at
    return one[:, 0] * other[:, 1] - one[:, 1] * other[:, 0]
