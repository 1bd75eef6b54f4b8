"""Cylinders that lie side by side, their axes parallel: they touch along a line in the plane of both axes.

    outside    two outsides of radii a, b, the axes d apart:       gap d - a - b, growing by y^2 (1/a + 1/b) / 2
    inside     an outside of radius a within a bore b > a:         gap b - a - d, growing by y^2 (1/a - 1/b) / 2

with y across, from that line. What their facets have in common there depends on how these happen to lie; so touching is
decided on the true surfaces, as it is for flat faces (tangents.py).
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.sides import FaceSide, patch_of
from kernel.connect.tangents import SQUARE, STEPS, touching_reach
from kernel.segment.faces import Faces, Region
from kernel.segment.slices import parts_of
from kernel.solid.boxes import BoxIndex
from kernel.solid.surfaces import CylinderSurface, Surface

Array = NDArray[np.float64]

WIDEST = 0.5
"""A strip of contact reaches no further from its line than this share of the smaller radius: there its faces lean on
each other like those of a joint at an angle."""

TURNS = (-1, 0, 1)
"""Turns by which the angle of a line of contact may differ from those of a face about it."""


@dataclass(frozen=True, slots=True, eq=False)
class Neighbours:
    """Two cylinders side by side, the face of the earlier segment first; patches: what of each is within reach of the
    other, in its own coordinates. gap: along the line where it is least, 0 where they touch or overlap by no more than
    their facets show.
    """

    faces: tuple[FaceSide, FaceSide]
    patches: tuple[Region, Region]
    gap: float


def neighbours(
    rows: Sequence[FaceSide],
    faces: Sequence[Faces],
    surfaces: Sequence[Surface],
    tolerance: float,
    reach: float,
    known: Collection[tuple[int, int]],
) -> Iterator[Neighbours]:
    """Cylinders of different segments whose parallel faces come within `reach` of each other along a line.

    known: pairs of segments, the earlier one first, that are not asked for.
    """
    bent = [row for row in rows if isinstance(surfaces[row.surface], CylinderSurface)]
    if len(bent) < 2:
        return
    widest = max(touching_reach(_cylinder(surfaces, row)) for row in bent)
    index = BoxIndex([row.box for row in bent])
    asked = np.array([row.box for row in bent]) + np.array([[-1.0], [1.0]]) * (reach + 2 * widest)
    for one, other in index.pairs(asked):
        first, second = bent[one], bent[other]
        pair = (first.segment, second.segment)
        if pair[0] >= pair[1] or pair in known:
            continue
        beside = _beside(first, second, surfaces, tolerance, reach)
        if beside is not None and (found := _common(first, second, beside, surfaces, faces)) is not None:
            yield found


def parallel_apart(one: CylinderSurface, other: CylinderSurface) -> Array:
    """From one axis square to the other (3,), of two cylinders whose axes are parallel; zeros where they are not."""
    direction = one.axis.direction
    if np.linalg.norm(np.cross(direction, other.axis.direction)) > SQUARE:
        return np.zeros(3)
    apart = other.axis.point - one.axis.point
    return np.asarray(apart - direction * (apart @ direction))


def _cylinder(surfaces: Sequence[Surface], row: FaceSide) -> CylinderSurface:
    surface = surfaces[row.surface]
    assert isinstance(surface, CylinderSurface)
    return surface


@dataclass(frozen=True, slots=True, eq=False)
class _Beside:
    """outs: from each axis to the line of contact, unit. gap: along it. half: of the strip's width within reach."""

    outs: tuple[Array, Array]
    gap: float
    half: float


def _beside(
    first: FaceSide, second: FaceSide, surfaces: Sequence[Surface], tolerance: float, reach: float
) -> _Beside | None:
    """How two faces lie; None where they are not opposite within reach, or overlap by more than facets show."""
    one, other = _cylinder(surfaces, first), _cylinder(surfaces, second)
    apart = parallel_apart(one, other)
    away = float(np.linalg.norm(apart))
    if away <= tolerance or (first.side < 0 and second.side < 0):
        return None
    out = apart / away
    if first.side > 0 and second.side > 0:
        gap, bend = away - one.radius - other.radius, 1 / one.radius + 1 / other.radius
        outs = (out, -out)
    else:
        bore, rod = (one, other) if first.side < 0 else (other, one)
        gap, bend = bore.radius - rod.radius - away, 1 / rod.radius - 1 / bore.radius
        outs = (out, out) if bore is one else (-out, -out)
    slack = touching_reach(one) + touching_reach(other)
    if not -slack <= gap <= reach + slack or bend <= 0:
        return None
    widest = WIDEST * min(one.radius, other.radius)
    half = float(np.sqrt(2 * (reach + slack - max(gap, 0.0)) / bend))
    return _Beside(outs, gap if gap > tolerance else 0.0, min(half, widest))


def _common(
    first: FaceSide, second: FaceSide, beside: _Beside, surfaces: Sequence[Surface], faces: Sequence[Faces]
) -> Neighbours | None:
    """What the two faces have opposite one another within the strip; None where they have nothing."""
    base, up = _cylinder(surfaces, first), beside.outs[0]
    regions = [patch_of(faces[row.segment], row) for row in (first, second)]
    strips = [_Strip(_cylinder(surfaces, row), out, base, up) for row, out in zip((first, second), beside.outs)]
    common = shapely.intersection(*(strip.laid(region, beside.half) for strip, region in zip(strips, regions)))
    one, other = (strip.raised(common, region) for strip, region in zip(strips, regions))
    if one.is_empty or other.is_empty:
        return None
    return Neighbours((first, second), (one, other), beside.gap)


class _Strip:
    """The strip of a cylinder about the line of contact, in the frame (across, along) that both cylinders have there.

    out: from the cylinder's axis to the line. base, up: the first of the two cylinders and its out.
    """

    def __init__(self, cylinder: CylinderSurface, out: Array, base: CylinderSurface, up: Array) -> None:
        axis, along = cylinder.axis, base.axis.direction
        self.radius = cylinder.radius
        self.middle = float(np.arctan2(out @ axis.y, out @ axis.x))
        self.sense = 1.0 if float(np.cross(along, up) @ np.cross(axis.direction, out)) > 0 else -1.0
        self.along = 1.0 if float(along @ axis.direction) > 0 else -1.0
        self.shift = float((axis.point - base.axis.point) @ along)

    def laid(self, region: Region, half: float) -> Region:
        """What of a region of the cylinder (r * angle, height) lies within `half` across."""
        widest = float(np.arcsin(half / self.radius))
        _, low, _, high = region.bounds
        parts = []
        for turn in TURNS:
            here = self.middle + 2 * np.pi * turn
            window = shapely.box((here - widest) * self.radius, low, (here + widest) * self.radius, high)
            part = shapely.segmentize(region.intersection(window), self.radius * widest / STEPS)
            parts.append(shapely.transform(part, lambda at, here=here: self._lay(at, here)))
        return shapely.union_all(parts)

    def _lay(self, at: Array, here: float) -> Array:
        across = self.sense * self.radius * np.sin(at[:, 0] / self.radius - here)
        return np.stack([across, self.along * at[:, 1] + self.shift], axis=1)

    def raised(self, region: Region, within: Region) -> Region:
        """A region of the strip as one of the cylinder, as far as it lies in `within`."""
        left, _, right, _ = region.bounds
        part = shapely.segmentize(region, (right - left) / STEPS) if region.area > 0 else region
        turned = [
            shapely.transform(part, lambda at, turn=turn: self._raise(at, self.middle + 2 * np.pi * turn))
            for turn in TURNS
        ]
        return shapely.multipolygons(parts_of(shapely.union_all(turned).intersection(within)))

    def _raise(self, at: Array, here: float) -> Array:
        angle = here + np.arcsin(np.clip(self.sense * at[:, 0] / self.radius, -1.0, 1.0))
        return np.stack([self.radius * angle, self.along * (at[:, 1] - self.shift)], axis=1)
