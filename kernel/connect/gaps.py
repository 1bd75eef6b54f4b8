"""Faces that look at one another over a small gap: near misses to be told, or joints where a gap is stated.

    plane      outward +n at offset a,  outward -n at offset b > a:  gap b - a
    cylinder   a body's outside of radius a, another's bore of radius b > a:  gap b - a
    tangent    a flat face beside a cylinder (tangents.py): the gap is that of the line where it is least
    parallel   two cylinders side by side (side_by_side.py): likewise

Of these the last two alone may touch, too: along a line, or over a strip that the cylinder's facets do not show.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely

from kernel.connect.joints import Joint
from kernel.connect.parallels import carried, levels
from kernel.connect.side_by_side import neighbours
from kernel.connect.sides import FaceSide, patch_of, sides_of
from kernel.connect.tangents import SQUARE, Tangent, tangents, touching_reach
from kernel.errors import OptionError
from kernel.segment.faces import Region, faces_of
from kernel.segment.segments import BeamShape, CylinderShape, PlateShape, Segment
from kernel.solid.boxes import BoxIndex
from kernel.solid.surfaces import CylinderSurface, Plane, Surface

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated

NEAR_MISS = 1e-3
"""Faces that are nearer to one another than this share of the model's size, and do not touch, are worth a word."""


FULL = 0.5
"""A flat face that a cylinder faces over this share of it stands against it; over less they touch along a line, which
joins walls that lie along one another or end there, and beams that run along it, but no solid: that would hinge."""


@dataclass(frozen=True, slots=True, eq=False)
class ClosePair:
    """Two faces `gap` apart, the one of the earlier segment first; patches: what they have opposite each other, each
    in its own surface's coordinates.

    joins: whether a gap stated just above this one joins them.
    """

    faces: tuple[FaceSide, FaceSide]
    gap: float
    patches: tuple[Region, Region]
    joins: bool = True


def close_pairs(
    segments: Sequence[Segment], evaluated: Evaluated, joined: Collection[tuple[int, int]], reach: float
) -> list[ClosePair]:
    """Faces of segments that are up to `reach` apart, over more than reach^2; in order of segments.

    joined: pairs of segments, by index and the earlier first, that are not asked for. With no reach at all: flat faces
    and cylinders that touch.
    """
    table = evaluated.solid.surfaces
    if not reach and not any(isinstance(surface, CylinderSurface) for surface in table.surfaces):
        return []
    faces = [faces_of(segment.solid) for segment in segments]
    rows = [row for index, of_segment in enumerate(faces) for row in sides_of(index, of_segment)]
    found = []
    patches_of: dict[int, Region] = {}  # by id of a row, all of which are held: a floor's face looks at thousands
    for inner, outer, gap in _facing(rows, table.surfaces, table.tolerance, reach) if reach else ():
        pair = (inner, outer) if inner.segment < outer.segment else (outer, inner)
        if (pair[0].segment, pair[1].segment) not in joined:
            for row in pair:
                if id(row) not in patches_of:
                    patches_of[id(row)] = patch_of(faces[row.segment], row)
            own = (patches_of[id(pair[0])], patches_of[id(pair[1])])
            patches = _opposite(own, pair, table.surfaces)
            if patches[0].area > reach**2:
                found.append(ClosePair(pair, gap, patches))
    within = tangents(rows, faces, table.surfaces, table.tolerance, lambda c: reach + touching_reach(c), joined)
    for item in within:
        if item.least <= reach + table.tolerance and _is_wide(item.flat_patch, reach, table.tolerance):
            found.append(_beside(item, segments, _cylinder(table.surfaces, item.round), table.tolerance))
    for beside in neighbours(rows, faces, table.surfaces, table.tolerance, reach, joined):
        if beside.gap <= reach + table.tolerance and _is_wide(beside.patches[0], reach, table.tolerance):
            joins = _along_a_line(beside.faces, segments, _cylinder(table.surfaces, beside.faces[0]))
            found.append(ClosePair(beside.faces, beside.gap, beside.patches, joins))
    found.sort(key=lambda item: (item.faces[0].segment, item.faces[1].segment, item.faces[0].surface))
    return found


def _is_wide(patch: Region, reach: float, tolerance: float) -> bool:
    """Whether a patch is more than rounding, and than what lies within reach about a point."""
    left, low, right, high = patch.bounds
    return bool(patch.area > max(reach**2, 10 * tolerance * max(right - left, high - low)))


def _cylinder(surfaces: Sequence[Surface], row: FaceSide) -> CylinderSurface:
    surface = surfaces[row.surface]
    assert isinstance(surface, CylinderSurface)
    return surface


def _beside(item: Tangent, segments: Sequence[Segment], cylinder: CylinderSurface, tolerance: float) -> ClosePair:
    """A tangent as a pair of faces: 0 apart where it touches.

    In a bore only the corners of a flat face touch: it must stand against it.
    """
    both = [(item.flat, item.flat_patch), (item.round, item.round_patch)]
    both.sort(key=lambda one: one[0].segment)
    is_against = item.share >= FULL and item.most <= item.least + touching_reach(cylinder) + tolerance
    is_outside = item.round.side > 0
    return ClosePair(
        faces=(both[0][0], both[1][0]),
        gap=item.least if item.least > tolerance else 0.0,
        patches=(both[0][1], both[1][1]),
        joins=is_against or (is_outside and _along_a_line((item.flat, item.round), segments, cylinder)),
    )


def _along_a_line(faces: Sequence[FaceSide], segments: Sequence[Segment], cylinder: CylinderSurface) -> bool:
    """Whether the bodies of two faces that touch along a line of the cylinder can be held along it.

    So can tubes by their own faces, plates by theirs and by their edges, and beams that run along the line. A solid
    cannot: it would hinge there.
    """
    for row in faces:
        shape = segments[row.segment].shape
        if isinstance(shape, BeamShape):
            if np.linalg.norm(np.cross(shape.direction, cylinder.axis.direction)) > SQUARE:
                return False
        elif isinstance(shape, CylinderShape):
            if row.surface not in shape.surface_ids:
                return False
        elif not isinstance(shape, PlateShape):
            return False
    return True


def near_misses(segments: Sequence[Segment], evaluated: Evaluated, joints: Sequence[Joint]) -> tuple[str, ...]:
    """A line for each pair of segments without a joint whose faces almost touch: a gap that was not meant?"""
    nearest: dict[tuple[int, int], ClosePair] = {}
    place = {segment.id: index for index, segment in enumerate(segments)}
    known = [[place[name] for name in joint.segments if name in place] for joint in joints]
    joined = {(min(pair), max(pair)) for pair in known if pair}
    for item in close_pairs(segments, evaluated, joined, NEAR_MISS * evaluated.size):
        pair = (item.faces[0].segment, item.faces[1].segment)
        if pair not in nearest or (not item.joins, item.gap) < (not nearest[pair].joins, nearest[pair].gap):
            nearest[pair] = item
    return tuple(
        f"{segments[a].id} and {segments[b].id} {_apart(item)}: they are not joined ({_remedy(item)})"
        for (a, b), item in sorted(nearest.items())
    )


def _apart(item: ClosePair) -> str:
    if not item.gap:
        return "touch along a line of a cylinder"
    return f"are {item.gap:.3g} apart over an area of {item.patches[0].area:.3g}"


def _remedy(item: ClosePair) -> str:
    if item.joins and item.gap:
        return f"a stated gap of {_above(item.gap):.3g} would join them"
    return "a flat face that runs into the cylinder would join them"


def check_gap(gap: float, segments: Sequence[Segment]) -> None:
    """OptionError for a gap that is none, or that no wall is thicker than."""
    if not 0 <= gap < float("inf"):
        raise OptionError(f"gap is {gap:g}, expected 0 or more")
    walls = [(segment.thickness, segment.id) for segment in segments if segment.thickness is not None]
    thinnest, name = min(walls, default=(float("inf"), ""))
    if gap >= thinnest:
        raise OptionError(f"gap is {gap:g}, but {name} is only {thinnest:.4g} thick: expected less than every wall")


def _above(gap: float) -> float:
    """The gap rounded up to two digits."""
    digits = 1 - int(np.floor(np.log10(gap)))
    return float(np.ceil(gap * 10.0**digits - 1e-6) / 10.0**digits)


def _facing(
    rows: Sequence[FaceSide], surfaces: Sequence[Surface], tolerance: float, reach: float
) -> Iterator[tuple[FaceSide, FaceSide, float]]:
    """Pairs of faces of different segments that look at one another over a gap up to `reach`."""
    groups: dict[tuple[str, int], list[tuple[float, int, FaceSide]]] = {}
    for level in levels(rows, surfaces):
        groups.setdefault(("plane", level.group), []).append((level.at, level.side, level.row))
    for row in rows:
        surface = surfaces[row.surface]
        if isinstance(surface, CylinderSurface):
            groups.setdefault(("cylinder", surface.axis_id), []).append((surface.radius, row.side, row))
    for group in groups.values():
        out = [(at, row) for at, side, row in group if side > 0]
        back = sorted(((at, row) for at, side, row in group if side < 0), key=lambda item: item[0])
        if not out or not back:
            continue
        asked = np.array([row.box for _, row in out]) + np.array([[-reach], [reach]])
        for number, place in BoxIndex([row.box for _, row in back]).pairs(asked):
            (at, row), (there, other) = out[number], back[place]
            if at + tolerance < there <= at + reach and row.segment != other.segment:
                yield row, other, there - at


def _opposite(
    patches: tuple[Region, Region], pair: tuple[FaceSide, FaceSide], surfaces: Sequence[Surface]
) -> tuple[Region, Region]:
    """What two faces, with these patches, have opposite each other, in the coordinates of each one's surface."""
    one, other = patches
    first, second = (surfaces[row.surface] for row in pair)
    if isinstance(first, CylinderSurface) and isinstance(second, CylinderSurface):
        common = one.intersection(_scaled(other, first.radius / second.radius))
        return common, _scaled(common, second.radius / first.radius)
    assert isinstance(first, Plane) and isinstance(second, Plane)
    common = one.intersection(carried(other, second, first))
    return common, carried(common, first, second)


def _scaled(region: Region, factor: float) -> Region:
    """A region of an unrolled cylinder on one of another radius."""
    return shapely.transform(region, lambda at: at * (factor, 1.0))
