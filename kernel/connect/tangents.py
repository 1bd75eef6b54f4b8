"""Flat faces beside cylinders: their gap grows with the square of the distance from the line where it is least.

    outside   plane at d from the axis, looking at it:           gap sqrt(d^2 + y^2) - r, least at y = 0
    inside    plane at d < r from the axis, looking away:        gap r - sqrt(d^2 + y^2), least at its ends

A face that only stands against a cylinder has no area in common with it; and whether one that bites a little into it
has any depends on where the cylinder's facets lie. So what is nearer than a chord's sagitta touches, in the frame of
that line: across (y) and along the axis.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.sides import FaceSide, patch_of
from kernel.segment.faces import Faces, Region
from kernel.segment.slices import parts_of
from kernel.solid.boxes import BoxIndex
from kernel.solid.lathe import SAGITTA
from kernel.solid.surfaces import CylinderSurface, Plane, Surface

Array = NDArray[np.float64]

SQUARE = 1e-5
"""A plane stands along an axis when its normal is this near (sine) to square to it."""

STEEPEST = 0.5
"""Planes nearer to the axis than this share of the radius meet the cylinder at an angle: their edges touch it."""

STEPS = 16
"""Parts into which an arc is divided where it is laid into the plane."""


def touching_reach(cylinder: CylinderSurface) -> float:
    """What lies this near to a cylinder cannot be told from what touches it: the sagitta of its facets."""
    return SAGITTA * cylinder.radius


@dataclass(frozen=True, slots=True, eq=False)
class Tangent:
    """A flat face beside a cylinder. flat_patch, round_patch: what of each is within reach, in its own coordinates.

    least, most: the gap over that, where it is narrowest and widest. share: how much that is of the flat face.
    """

    flat: FaceSide
    round: FaceSide
    flat_patch: Region
    round_patch: Region
    least: float
    most: float
    share: float


def tangents(
    rows: Sequence[FaceSide],
    faces: Sequence[Faces],
    surfaces: Sequence[Surface],
    tolerance: float,
    reach: Callable[[CylinderSurface], float],
    known: Collection[tuple[int, int]],
) -> Iterator[Tangent]:
    """Flat faces and cylinders of different segments that are somewhere no further apart than `reach`.

    known: pairs of segments, the earlier one first, that are not asked for.
    """
    flat = [row for row in rows if isinstance(surfaces[row.surface], Plane)]
    bent = [row for row in rows if isinstance(surfaces[row.surface], CylinderSurface)]
    if not flat or not bent:
        return
    index = BoxIndex([row.box for row in flat])
    for bend in bent:
        cylinder = surfaces[bend.surface]
        assert isinstance(cylinder, CylinderSurface)
        slack = reach(cylinder)
        for place in index.near(bend.box[0] - slack, bend.box[1] + slack):
            row = flat[place]
            plane = surfaces[row.surface]
            assert isinstance(plane, Plane)
            pair = (min(row.segment, bend.segment), max(row.segment, bend.segment))
            if pair[0] == pair[1] or pair in known or abs(plane.normal @ cylinder.axis.direction) > SQUARE:
                continue
            beside = _Beside(plane, cylinder, is_outside=bend.side > 0)
            if beside.looks_at(row.side) and (strips := beside.strips(slack, tolerance)):
                found = _common(row, bend, beside, strips, faces)
                if found is not None:
                    yield found


class _Beside:
    """A plane along a cylinder's axis, and the frame (across, along the axis) on it, from the line nearest the axis."""

    def __init__(self, plane: Plane, cylinder: CylinderSurface, is_outside: bool) -> None:
        self.plane, self.cylinder, self.is_outside = plane, cylinder, is_outside
        signed = plane.offset - float(plane.normal @ cylinder.axis.point)
        self.away = abs(signed)
        self.sign = 1 if signed > 0 else -1
        self.out = self.sign * plane.normal
        self.across = np.cross(cylinder.axis.direction, self.out)
        self.middle = float(np.arctan2(self.out @ cylinder.axis.y, self.out @ cylinder.axis.x))

    def looks_at(self, side: int) -> bool:
        """Whether a face on that side of the plane looks at the cylinder's face: in at its outside, out at a bore."""
        return (side * self.sign < 0) == self.is_outside and self.away > STEEPEST * self.cylinder.radius

    def gap(self, across: float) -> float:
        """How far the plane is from the cylinder's face, 0 where it has crossed it."""
        gap = float(np.hypot(self.away, across)) - self.cylinder.radius
        return max(0.0, gap if self.is_outside else -gap)

    def strips(self, reach: float, tolerance: float) -> list[tuple[float, float]]:
        """The stretches across in which the gap is no more than `reach`, and the plane is on its side of the face."""
        radius, away = self.cylinder.radius, self.away
        if self.is_outside:
            if not radius - reach <= away < radius + reach:
                return []
            half = float(np.sqrt((radius + reach) ** 2 - away**2))
            return [(-half, half)]
        if away >= radius + tolerance:
            return []
        inner = float(np.sqrt(max(0.0, (radius - reach) ** 2 - away**2)))
        outer = float(np.sqrt(max(0.0, (radius + tolerance) ** 2 - away**2)))
        return [(-outer, outer)] if inner == 0.0 else [(-outer, -inner), (inner, outer)]

    def from_plane(self, region: Region) -> Region:
        """A region in the plane's coordinates in this frame."""
        own, origin = np.stack([self.plane.u, self.plane.v]), self.cylinder.axis.point
        frame = np.stack([self.across, self.cylinder.axis.direction])
        shift = frame @ (self.plane.offset * self.plane.normal - origin)
        return shapely.transform(region, lambda at: at @ (own @ frame.T) + shift)

    def to_plane(self, region: Region) -> Region:
        """The inverse."""
        own, origin = np.stack([self.plane.u, self.plane.v]), self.cylinder.axis.point
        frame = np.stack([self.across, self.cylinder.axis.direction])
        shift = own @ origin
        return shapely.transform(region, lambda at: at @ (frame @ own.T) + shift)

    def from_cylinder(self, region: Region, turn: int, half: float) -> Region:
        """What of a region of the cylinder (r * angle, height), `turn` turns on, lies within `half` across."""
        radius, here = self.cylinder.radius, self.middle + 2 * np.pi * turn
        widest = float(np.arctan2(half, self.away))
        _, low, _, high = region.bounds
        window = shapely.box((here - widest) * radius, low - radius, (here + widest) * radius, high + radius)
        part = shapely.segmentize(region.intersection(window), radius * widest / STEPS)
        return shapely.transform(part, lambda at: np.stack([self.away * np.tan(at[:, 0] / radius - here), at[:, 1]], 1))

    def to_cylinder(self, region: Region, turn: int, half: float) -> Region:
        """The inverse."""
        radius, here = self.cylinder.radius, self.middle + 2 * np.pi * turn
        part = shapely.segmentize(region, half / STEPS)
        return shapely.transform(
            part, lambda at: np.stack([radius * (here + np.arctan(at[:, 0] / self.away)), at[:, 1]], 1)
        )


def _common(
    row: FaceSide, bend: FaceSide, beside: _Beside, strips: list[tuple[float, float]], faces: Sequence[Faces]
) -> Tangent | None:
    """What the two faces have opposite one another within the strips; None where they have nothing."""
    own = beside.from_plane(patch_of(faces[row.segment], row))
    _, low, _, high = own.bounds
    beyond = beside.cylinder.radius  # the strips run on past the face's ends
    within = own.intersection(shapely.union_all([shapely.box(a, low - beyond, b, high + beyond) for a, b in strips]))
    if within.area == 0.0:
        return None
    region = patch_of(faces[bend.segment], bend)
    half = max(abs(end) for strip in strips for end in strip)
    flat: list[Region] = []
    bent: list[Region] = []
    for turn in (-1, 0, 1):
        common = within.intersection(beside.from_cylinder(region, turn, half))
        if common.area > 0.0:
            flat.append(common)
            bent.append(beside.to_cylinder(common, turn, half))
    if not flat:
        return None
    common = shapely.multipolygons(parts_of(shapely.union_all(flat)))
    gaps = [beside.gap(across) for across in _breadth(common)]
    return Tangent(
        flat=row,
        round=bend,
        flat_patch=beside.to_plane(common),
        round_patch=shapely.multipolygons(parts_of(shapely.union_all(bent))),
        least=min(gaps),
        most=max(gaps),
        share=float(common.area / own.area),
    )


def _breadth(region: Region) -> tuple[float, ...]:
    """Distances across at which the gap over a region is least and greatest."""
    low, _, high, _ = region.bounds
    return (low, high, 0.0) if low < 0.0 < high else (low, high)
