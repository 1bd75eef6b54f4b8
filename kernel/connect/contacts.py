"""Joints from the segments' own faces: one surface, opposite sides, patches that overlap.

Touching faces share a canonical surface because the table makes them; where an overlap was cut away from one segment,
the cut inherited the other's surface. So both are found the same way, without a Boolean of no thickness.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon, STRtree

from kernel.connect.gaps import ClosePair, check_gap, close_pairs
from kernel.connect.joints import Joint
from kernel.connect.parallels import PARALLEL
from kernel.connect.sides import FaceSide, patch_of, sides_of
from kernel.connect.tangents import SQUARE
from kernel.idealise.implicit import project
from kernel.idealise.sheets import PlaneSheet, plane_sheet
from kernel.idealise.walls import CROSSING_SINE
from kernel.segment.faces import faces_of
from kernel.segment.segments import BeamShape, BrickShape, CylinderShape, PlateShape, Segment
from kernel.segment.slices import parts_of, slice_polygon
from kernel.solid.charts import lift
from kernel.solid.surfaces import CylinderSurface, Plane, Surface, cross, outward

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated

Array = NDArray[np.float64]

SLIVER_WIDTH = 10.0
"""Patches narrower than this many tolerances are rounding, no contact."""

END_ON = 0.9
"""A beam meets a face with its end where the face's normal leans on its axis by more than this cosine."""

END_IN = 0.4
"""The same on cones, spheres and tori, which no beam lies along: it ends in them, or they sit around it."""

ALONG = 1e-6
"""A beam lies along a wall when it leans on its mid-surface, or on a tube's axis, by no more than this sine."""

AROUND = 0.25
"""Of two coaxial tubes' thicknesses: with mid-surfaces further apart than this one is around the other, nearer they
go on in one another. It is 0.5 where they only touch."""

LIES_ALONG = 0.9
"""A plate that a tube meets in this direction (cosine to its normal) is met on its face; so are two tubes whose axes
lie apart in that direction."""


def find_joints(segments: Sequence[Segment], evaluated: Evaluated, gap: float = 0.0) -> tuple[Joint, ...]:
    """Every pair of segments that share an area of a surface, once for each surface; ids "j1", "j2" ... in order.

    Flat faces that touch a cylinder do so too, though their facets may not. gap: faces that look at one another over no
    more than this count as touching, where the two segments have no other joint. OptionError: it is negative, or not
    less than the thinnest wall.
    """
    check_gap(gap, segments)
    table = evaluated.solid.surfaces
    faces = [faces_of(segment.solid) for segment in segments]
    rows = [row for index, of_segment in enumerate(faces) for row in sides_of(index, of_segment)]
    found: list[ClosePair] = []
    patches: dict[int, Polygon | MultiPolygon] = {}
    for one, other in _facing(rows, 10 * table.tolerance):
        for row in (one, other):
            if id(row) not in patches:
                patches[id(row)] = patch_of(faces[row.segment], row)
        patch = patches[id(one)].intersection(patches[id(other)])
        parts = [part for part in parts_of(patch) if part.area > 0.5 * SLIVER_WIDTH * table.tolerance * part.length]
        if parts:
            first, second = sorted((one, other), key=lambda row: row.segment)
            whole = parts[0] if len(parts) == 1 else MultiPolygon(parts)
            found.append(ClosePair((first, second), 0.0, (whole, whole)))
    apart: list[ClosePair] = []
    for item in close_pairs(segments, evaluated, {_pair(item) for item in found}, gap):
        if item.joins:
            (apart if item.gap else found).append(item)
    found.sort(key=lambda item: (*_pair(item), item.faces[0].surface, item.faces[0].side))
    touched = {_pair(item) for item in found}
    found += [item for item in apart if _pair(item) not in touched]
    middles = _Middles()
    return tuple(_joint(number, item, segments, middles) for number, item in enumerate(found, start=1))


def _pair(item: ClosePair) -> tuple[int, int]:
    return item.faces[0].segment, item.faces[1].segment


def _joint(number: int, item: ClosePair, segments: Sequence[Segment], middles: _Middles) -> Joint:
    one, other = item.faces
    pair = (segments[one.segment], segments[other.segment])
    surface = pair[0].solid.surfaces.surfaces[one.surface]
    centre = _centre(surface, item.patches[0])
    normal = one.side * outward(surface, centre[None])[0]
    is_shared = one.surface == other.surface
    return Joint(
        id=f"j{number}",
        kind=_kind(pair, (one.surface, other.surface), normal, centre, middles),
        segments=(pair[0].id, pair[1].id),
        surface=one.surface,
        area=float(item.patches[0].area),
        patch=item.patches[0],
        centre=centre,
        normal=normal,
        middle=_middle(surface, item.patches[0], centre),
        gap=item.gap,
        mate=None if is_shared else other.surface,
        mate_patch=None if is_shared else item.patches[1],
    )


def _facing(rows: list[FaceSide], slack: float) -> list[tuple[FaceSide, FaceSide]]:
    """Pairs of faces on opposite sides of one surface, of different segments, whose boxes touch."""
    by_surface: dict[int, tuple[list[FaceSide], list[FaceSide]]] = {}
    for row in rows:
        by_surface.setdefault(row.surface, ([], []))[0 if row.side > 0 else 1].append(row)
    pairs = []
    for surface in sorted(by_surface):
        above, below = by_surface[surface]
        if not above or not below:
            continue
        spread = np.ptp(np.array([row.box for row in (*above, *below)]).reshape(-1, 3), axis=0)
        x, y = sorted(np.argsort(spread)[1:].tolist())
        first, second = STRtree(_boxes(below, x, y)).query(_boxes(above, x, y))
        for i, j in sorted(zip(first.tolist(), second.tolist())):
            one, other = above[i], below[j]
            gap = np.maximum(one.box[0], other.box[0]) - np.minimum(one.box[1], other.box[1])
            if one.segment != other.segment and (gap <= slack).all():
                pairs.append((one, other))
    return pairs


def _boxes(rows: list[FaceSide], x: int, y: int) -> NDArray[np.object_]:
    box = np.array([row.box for row in rows])
    return shapely.box(box[:, 0, x], box[:, 0, y], box[:, 1, x], box[:, 1, y])


def _centre(surface: Surface, patch: Polygon | MultiPolygon) -> Array:
    """The patch's centroid in space; a point within it where the centroid is not (rings, bent strips)."""
    middle = patch.centroid if patch.covers(patch.centroid) else patch.representative_point()
    return lift(surface, np.array([[middle.x, middle.y]]))[0]


def _middle(surface: Surface, patch: Polygon | MultiPolygon, centre: Array) -> Array:
    """The patch's centroid in space, in it or not; the centre on surfaces whose charts have none to speak of."""
    if not isinstance(surface, Plane | CylinderSurface):
        return centre
    return lift(surface, np.array([[patch.centroid.x, patch.centroid.y]]))[0]


# ---------------------------------------------------------------- kinds


class _Middles:
    """The mid-planes of plates and their mid-sections, made once: a floor has thousands of joints."""

    def __init__(self) -> None:
        self._known: dict[str, Polygon | MultiPolygon] = {}
        self._sheets: dict[str, PlaneSheet] = {}

    def sheet(self, segment: Segment, plate: PlateShape) -> PlaneSheet:
        """The mid-plane of a plate."""
        if segment.id not in self._sheets:
            self._sheets[segment.id] = plane_sheet(plate, segment.solid.surfaces)
        return self._sheets[segment.id]

    def of(self, segment: Segment, plate: PlateShape) -> Polygon | MultiPolygon:
        """The section of a plate in its mid-plane, in coordinates (x.u, x.v)."""
        if segment.id not in self._known:
            section = slice_polygon(segment.solid.facets, plate.normal, plate.mid_offset, plate.u, plate.v)
            shapely.prepare(section)
            self._known[segment.id] = section
        return self._known[segment.id]


def _kind(
    pair: tuple[Segment, Segment], surfaces: tuple[int, int], normal: Array, centre: Array, middles: _Middles
) -> str:
    """One of joints.JOINT_KINDS."""
    beams = [segment.shape for segment in pair if isinstance(segment.shape, BeamShape)]
    if beams:
        is_ruled = isinstance(pair[0].solid.surfaces.surfaces[surfaces[0]], Plane | CylinderSurface)
        least = END_ON if is_ruled else END_IN
        if any(abs(beam.direction @ normal) > least for beam in beams):
            return "end_on"
        walls = [segment.shape for segment in pair if isinstance(segment.shape, PlateShape | CylinderShape)]
        if any(_leans(beams[0], wall) for wall in walls):
            return "end_on"
        # a plane that is not parallel to a beam cuts its end off: a brick's face, on which a slanting beam stands
        is_flat = isinstance(pair[0].solid.surfaces.surfaces[surfaces[0]], Plane)
        is_cut = is_flat and len(beams) == 1 and not walls and abs(beams[0].direction @ normal) > ALONG
        return "end_on" if is_cut else "along"
    if any(isinstance(segment.shape, BrickShape) for segment in pair):
        return "face"
    tubes = [segment.shape for segment in pair if isinstance(segment.shape, CylinderShape)]
    if len(tubes) == 2 and _is_around(tubes[0], tubes[1], pair[0].solid.surfaces.surfaces[surfaces[0]]):
        return "lap"
    if tubes:
        is_beside = _lie_side_by_side(tubes, normal) if len(tubes) == 2 else _lies_along(pair, normal)
        return "lap" if is_beside else "pipe"
    return _wall_kind(pair, surfaces, centre, middles)


def _leans(beam: BeamShape, wall: PlateShape | CylinderShape) -> bool:
    """Whether a beam cannot lie along a wall, for it is not parallel to its mid-surface: one ends on the other."""
    if isinstance(wall, PlateShape):
        return bool(abs(beam.direction @ wall.normal) > ALONG)
    return bool(np.linalg.norm(np.cross(beam.direction, wall.axis.direction)) > ALONG)


def _is_around(one: CylinderShape, other: CylinderShape, surface: Surface) -> bool:
    """Whether two tubes meet on a cylinder about their common axis, most of the one outside of the other: a sleeve."""
    if not isinstance(surface, CylinderSurface) or not one.axis_id == other.axis_id == surface.axis_id:
        return False
    return abs(one.mid_radius - other.mid_radius) > AROUND * (one.thickness + other.thickness)


def _lies_along(pair: tuple[Segment, Segment], normal: Array) -> bool:
    """Whether a plate and a cylinder-plate meet face to face, and their mid-surfaces at no angle: a tangent plate."""
    first, second = pair[0].shape, pair[1].shape
    plate, tube = (first, second) if isinstance(first, PlateShape) else (second, first)
    if not isinstance(plate, PlateShape) or not isinstance(tube, CylinderShape):
        return False
    away = abs(plate.mid_offset - float(plate.normal @ tube.axis.point))
    is_beside = abs(float(plate.normal @ tube.axis.direction)) < SQUARE
    is_flat = away >= tube.mid_radius * float(np.sqrt(1.0 - CROSSING_SINE**2))
    return is_beside and is_flat and abs(float(plate.normal @ normal)) > LIES_ALONG


def _lie_side_by_side(tubes: Sequence[CylinderShape], normal: Array) -> bool:
    """Whether two tubes of parallel axes meet face to face, and their mid-surfaces at no angle."""
    one, other = tubes
    direction = one.axis.direction
    apart = other.axis.point - one.axis.point
    apart = apart - direction * (apart @ direction)
    away = float(np.linalg.norm(apart))
    if np.linalg.norm(np.cross(direction, other.axis.direction)) > SQUARE or one.axis_id == other.axis_id:
        return False
    cosine = (one.mid_radius**2 + other.mid_radius**2 - away**2) / (2 * one.mid_radius * other.mid_radius)
    is_flat = abs(cosine) >= float(np.sqrt(1.0 - CROSSING_SINE**2))  # more than 1 where they do not meet at all
    return is_flat and abs(float(apart @ normal)) > LIES_ALONG * away


def _wall_kind(pair: tuple[Segment, Segment], surfaces: tuple[int, int], centre: Array, middles: _Middles) -> str:
    a, b = pair[0].shape, pair[1].shape
    assert isinstance(a, PlateShape)
    assert isinstance(b, PlateShape)
    table = pair[0].solid.surfaces
    if np.linalg.norm(cross(a.normal, b.normal)) < PARALLEL:
        if surfaces[0] in a.surface_ids and surfaces[1] in b.surface_ids:
            return "lap"
        apart = a.mid_offset - b.mid_offset * float(np.sign(a.normal @ b.normal))
        return "edge" if abs(apart) <= 10 * table.tolerance else "step"
    sides = sorted((_sides(pair[0], pair[1], centre, middles), _sides(pair[1], pair[0], centre, middles)))
    return {(2, 2): "cross", (1, 1): "corner", (0, 1): "corner", (0, 0): "corner"}.get((sides[0], sides[1]), "tee")


def _sides(segment: Segment, other: Segment, centre: Array, middles: _Middles) -> int:
    """On how many sides of the other plate's slab this plate goes on, next to the contact."""
    own, across = segment.shape, other.shape
    assert isinstance(own, PlateShape)
    assert isinstance(across, PlateShape)
    here, there = middles.sheet(segment, own), middles.sheet(other, across)
    middle = project(centre[None], (here.surface, there.surface))[0]
    away = across.normal - own.normal * (across.normal @ own.normal)
    sine = float(np.linalg.norm(away))
    away = away / sine
    # a hair beyond the slab's faces
    reach = 0.5 * across.thickness / sine + 0.05 * min(own.thickness, across.thickness)
    points = here.flat(np.array([middle + reach * away, middle - reach * away]))
    return int(np.count_nonzero(shapely.contains_xy(middles.of(segment, own), points)))
