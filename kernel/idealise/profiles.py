"""Which standard profile an outline is, with its dimensions.

A right-angled outline is told by its turns: walking round it, between two re-entrant corners (o) stand so many
convex ones. angle 5; channel 0 6; tee 2 4; zed 3 3; I 0 4 0 4.

     I  +-------+     channel  +-----+    tee  +-----+    zed  +---+      angle  +-+
        +--o o--+              | o---+         +-o o-+         +-o |             | |
           | |                 | |               | |             | |             | o--+
        +--o o--+              | o---+           +-+             | o-+           +----+
        +-------+              +-----+                           +---+
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.outline import rings

if TYPE_CHECKING:
    from shapely import Polygon

SHAPE_TOLERANCE = 1e-6
"""Lengths that differ by less than this times the outline's extent are equal (input has six digits)."""

CIRCLE_SIDES = 48
"""A regular polygon with at least so many sides stands for a circle through its corners (fine polygons have 96)."""

Loop = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Profile:
    """Standard shape and its sizes. `width` lies along the section's flange (or y), `height` across it."""

    shape: str
    dimensions: dict[str, float]


_GENERAL = Profile("general", {})


def recognise(polygon: Polygon) -> Profile:
    """The standard profile that the outline is, or "general" without dimensions."""
    loops = rings(polygon)
    extent = float(np.ptp(loops[0], axis=0).max())
    tolerance = SHAPE_TOLERANCE * extent
    circles = [_circle(loop, tolerance) for loop in loops]
    outer = circles[0]
    if outer is not None and len(loops) == 1:
        return Profile("circle", {"radius": outer[1]})
    if outer is not None and len(loops) == 2 and (inner := circles[1]) is not None:
        if float(np.hypot(*(outer[0] - inner[0]))) <= tolerance:
            return Profile("tube", {"radius": outer[1], "inner_radius": inner[1], "thickness": outer[1] - inner[1]})
    corners = [_corners(loop, tolerance) for loop in loops]
    if len(loops) == 2:
        return _box(corners[0], corners[1], tolerance)
    if len(loops) == 1 and _is_right_angled(corners[0]):
        return _right_angled(corners[0], tolerance)
    return _GENERAL


def profile_directions(polygon: Polygon) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit vectors along the `width` and the `height` of a rectangle or box, in the outline's coordinates."""
    loop = rings(polygon)[0]
    tolerance = SHAPE_TOLERANCE * float(np.ptp(loop, axis=0).max())
    return _frame(_corners(loop, tolerance))


def _circle(loop: Loop, tolerance: float) -> tuple[NDArray[np.float64], float] | None:
    """Centre and radius where the loop is a fine, evenly divided polygon inscribed in a circle."""
    if len(loop) < CIRCLE_SIDES:
        return None
    # least squares |p|^2 = 2 c.p + k, about the mean for the digits
    mean = loop.mean(axis=0)
    points = loop - mean
    matrix = np.column_stack([2 * points, np.ones(len(points))])
    solution = np.linalg.lstsq(matrix, (points**2).sum(axis=1), rcond=None)[0]
    centre = solution[:2]
    distance = np.hypot(*(points - centre).T)
    radius = float(distance.mean())
    sides = np.hypot(*(np.roll(loop, -1, axis=0) - loop).T)
    longest = 2 * radius * np.sin(np.pi / CIRCLE_SIDES)
    if np.abs(distance - radius).max() > tolerance or sides.max() > longest * (1 + SHAPE_TOLERANCE):
        return None
    return centre + mean, radius


def _corners(loop: Loop, tolerance: float) -> Loop:
    """The loop without points that lie on the straight line between their neighbours."""
    before, after = np.roll(loop, 1, axis=0), np.roll(loop, -1, axis=0)
    chord = after - before
    length = np.maximum(np.hypot(*chord.T), tolerance)
    offset = np.abs(chord[:, 0] * (loop - before)[:, 1] - chord[:, 1] * (loop - before)[:, 0]) / length
    return loop[offset > tolerance]


def _is_right_angled(corners: Loop) -> bool:
    if len(corners) < 4:
        return False
    sides = np.roll(corners, -1, axis=0) - corners
    units = sides / np.hypot(*sides.T)[:, None]
    return bool(np.abs((units * np.roll(units, 1, axis=0)).sum(axis=1)).max() < SHAPE_TOLERANCE)


def _box(outer: Loop, inner: Loop, tolerance: float) -> Profile:
    """A rectangle in a rectangle, same centre and directions, with one thickness on opposite sides."""
    if len(outer) != 4 or len(inner) != 4 or not (_is_right_angled(outer) and _is_right_angled(inner)):
        return _GENERAL
    y, z = _frame(outer)
    if np.abs(outer.mean(axis=0) - inner.mean(axis=0)).max() > tolerance or not _is_aligned(inner, y):
        return _GENERAL
    width, height = float(np.ptp(outer @ y)), float(np.ptp(outer @ z))
    web, flange = (width - float(np.ptp(inner @ y))) / 2, (height - float(np.ptp(inner @ z))) / 2
    return Profile("box", {"width": width, "height": height, "web": web, "flange": flange})


def _frame(corners: Loop, along: int = 0) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Unit vectors along the side after corner `along` (the one nearer the y axis of a rectangle) and across it."""
    side = corners[(along + 1) % len(corners)] - corners[along]
    unit = side / np.hypot(*side)
    other = np.array([-unit[1], unit[0]])
    if len(corners) == 4 and abs(other[0]) > abs(unit[0]):
        unit, other = other, -unit
    return unit, other


def _is_aligned(corners: Loop, direction: NDArray[np.float64]) -> bool:
    unit = _frame(corners)[0]
    return min(abs(float(unit @ direction)), abs(float(unit[0] * direction[1] - unit[1] * direction[0]))) < 1e-6


def _right_angled(corners: Loop, tolerance: float) -> Profile:
    """Rectangle, angle, channel, tee, zed or I, by the turns (see the head of the file)."""
    if len(corners) == 4:
        y, z = _frame(corners)
        return Profile("rectangle", {"width": float(np.ptp(corners @ y)), "height": float(np.ptp(corners @ z))})
    sides = np.roll(corners, -1, axis=0) - corners
    incoming = np.roll(sides, 1, axis=0)
    reentrant = np.flatnonzero(incoming[:, 0] * sides[:, 1] - incoming[:, 1] * sides[:, 0] < 0)
    gaps = [int((b - a) % len(corners)) - 1 for a, b in zip(reentrant, np.roll(reentrant, -1))]
    if len(corners) == 6:
        return _angle(corners, int(reentrant[0]))
    kind = {(0, 6): "channel", (2, 4): "tee", (3, 3): "zed", (0, 0, 4, 4): "i"}.get(tuple(sorted(gaps)))
    if kind is None or (kind == "i" and gaps[0] == gaps[1]):
        return _GENERAL
    return _flanged(kind, corners, reentrant, gaps, tolerance)


def _angle(corners: Loop, reentrant: int) -> Profile:
    """Two legs; `web` is the thickness of the leg along `height`, `flange` that of the one along `width`."""
    y, z = _frame(corners, reentrant)
    ring = np.roll(corners, -reentrant, axis=0)  # o, tip, tip, heel, tip, tip
    return Profile(
        "angle",
        {
            "width": float(np.ptp(corners @ y)),
            "height": float(np.ptp(corners @ z)),
            "web": float(np.hypot(*(ring[5] - ring[4]))),
            "flange": float(np.hypot(*(ring[2] - ring[1]))),
        },
    )


def _flanged(kind: str, corners: Loop, reentrant: NDArray[np.int64], gaps: list[int], tolerance: float) -> Profile:
    """Web and flanges; `height` runs along the web. Unequal flanges leave the standard shapes."""
    n = len(corners)
    sides = np.roll(corners, -1, axis=0) - corners
    first = int(reentrant[int(np.argmin(gaps))])
    # I and channel: the side between two re-entrant corners is the web's; tee: the side after one is the stem's;
    # zed: of the two sides at a re-entrant corner the longer one is the web's
    web = sides[first]
    if kind == "zed" and np.hypot(*sides[first - 1]) > np.hypot(*web):
        web = sides[first - 1]
    z = web / np.hypot(*web)
    y = np.array([z[1], -z[0]])
    width, height = float(np.ptp(corners @ y)), float(np.ptp(corners @ z))
    across = corners @ y
    inner = across[reentrant]
    tips = sorted(float(np.hypot(*side)) for side in sides if abs(side @ z) > abs(side @ y))
    equal_tips = {"i": 4, "channel": 2, "zed": 2, "tee": 2}[kind]
    equal = tips[equal_tips - 1] - tips[0] <= tolerance
    web_thickness = float(np.ptp(inner))
    if kind == "channel":
        web_thickness = float(min(abs(inner.mean() - across.min()), abs(inner.mean() - across.max())))
    elif kind == "zed":
        middle = [float(across[k]) for k in range(n) if abs(sides[k] @ z) > height / 2]
        web_thickness = abs(middle[0] - middle[1]) if len(middle) == 2 else 0.0
        equal = equal and len(middle) == 2
    if not equal:
        return _GENERAL
    return Profile(kind, {"width": width, "height": height, "web": web_thickness, "flange": tips[0]})
