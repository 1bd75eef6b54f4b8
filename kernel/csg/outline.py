"""Closed outlines in a plane: circles as polygons, and loops put in order (outer ones counter-clockwise, holes not)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from kernel.csg.placement import cosine, sine
from kernel.csg.tree import Matrix, frozen_array

TRUE_CIRCLE_FACETS = 12
"""`$fn` of this or more, or 0, means a true circle; a smaller one is a polygon that is meant as one."""

FINE_CIRCLE = 96
"""Sides of the polygon that stands for a true circle where no primitive can be (in a twist, in a hull that tapers)."""


def facets_of(fn: float) -> int:
    """Sides of the polygon that `$fn` asks for, or 0 for a true circle."""
    return max(3, int(fn)) if 0 < fn < TRUE_CIRCLE_FACETS else 0


def circle_polygon(radius: float, n_side: int) -> Matrix:
    """(n_side, 2) corners on the circle, counter-clockwise from the x axis, as OpenSCAD puts them."""
    angles = [360.0 * index / n_side for index in range(n_side)]
    return np.array([(radius * cosine(angle), radius * sine(angle)) for angle in angles])


def signed_area(loop: Matrix) -> float:
    """Positive when (n, 2) `loop` runs counter-clockwise."""
    x, y = loop[:, 0], loop[:, 1]
    return 0.5 * float(np.dot(x, np.roll(y, -1)) - np.dot(np.roll(x, -1), y))


def ordered_loops(loops: Sequence[Matrix]) -> tuple[Matrix, ...]:
    """The region that `loops` fill by the even-odd rule: outer loops counter-clockwise, holes clockwise.

    loops: (n, 2) each, closed by themselves, free to cross each other and themselves. Nothing where no area is left.
    """
    from shapely import LinearRing, LineString
    from shapely.ops import polygonize, unary_union

    cleaned = [loop for loop in map(_without_repeats, loops) if len(loop) >= 3]
    if len(cleaned) == 1 and LinearRing(cleaned[0]).is_simple:
        return _wound(cleaned[0], counter_clockwise=True)
    lines = unary_union([LineString(np.vstack([loop, loop[:1]])) for loop in cleaned])
    cells = list(polygonize(lines))
    rings = [(loop, np.roll(loop, -1, axis=0)) for loop in cleaned]
    filled = [cell for cell in cells if _crossings(np.array(cell.representative_point().coords[0]), rings) % 2]
    if not filled:
        return ()
    merged = unary_union(filled)
    polygons = sorted(getattr(merged, "geoms", [merged]), key=lambda polygon: polygon.bounds)
    result: list[Matrix] = []
    for polygon in polygons:
        result += _wound(_from_lowest(polygon.exterior), counter_clockwise=True)
        for hole in sorted(polygon.interiors, key=lambda ring: ring.bounds):
            result += _wound(_from_lowest(hole), counter_clockwise=False)
    return tuple(result)


def _without_repeats(loop: Matrix) -> Matrix:
    loop = np.asarray(loop, dtype=np.float64).reshape(-1, 2)
    return loop[(loop != np.roll(loop, 1, axis=0)).any(axis=1)] if len(loop) > 1 else loop


def _wound(loop: Matrix, *, counter_clockwise: bool) -> tuple[Matrix, ...]:
    area = signed_area(loop)
    if area == 0.0:
        return ()
    return (frozen_array(loop if (area > 0) == counter_clockwise else loop[::-1]),)


def _from_lowest(ring: Any) -> Matrix:
    """The corners of a shapely ring, from the one with the least (x, y): the same whatever the input began with."""
    corners = np.array(ring.coords)[:-1]
    return np.roll(corners, -int(np.lexsort((corners[:, 1], corners[:, 0]))[0]), axis=0)


def _crossings(point: Matrix, rings: list[tuple[Matrix, Matrix]]) -> int:
    """How often a ray from `point` towards +x crosses the rings ((starts, ends), (n, 2) each)."""
    count = 0
    for start, end in rings:
        straddles = (start[:, 1] > point[1]) != (end[:, 1] > point[1])
        a, b = start[straddles], end[straddles]
        at = a[:, 0] + (point[1] - a[:, 1]) * (b[:, 0] - a[:, 0]) / (b[:, 1] - a[:, 1])
        count += int((at > point[0]).sum())
    return count
