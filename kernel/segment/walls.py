"""What a wall is: pairs of opposite faces, near enough to one another to be a plate or a cylinder-plate.

    planes of one direction n:  bottom b (outward -n), top t (outward +n), thickness = offset t - offset b > 0
        paired = proj(b) and proj(t), less the tops between them (they are nearer)
        a part of it is a wall where its opening by OPENING_FACTOR thicknesses leaves at least KEPT_SHARE of it
    coaxial cylinders:  outer (convex), inner (concave), mean radius / thickness >= RADIUS_RATIO
        the paired region, unrolled at the mean radius, reaches OPENING_FACTOR thicknesses both ways

The opening settles the competition between pairs: the sides of a plate are parallel pairs too, but a region four
thicknesses wide does not fit between them. KEPT_SHARE keeps an egg-crate from becoming one plate.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from kernel.segment.faces import Faces, Region, faces_of
from kernel.segment.slices import parts_of, smallest_rectangle
from kernel.segment.stretches import heights_apart
from kernel.solid.surfaces import Axis, CylinderSurface, Plane
from kernel.units import ANGLE_TOLERANCE

if TYPE_CHECKING:
    from kernel.solid.solid import Solid

Vector = NDArray[np.float64]

OPENING_FACTOR = 4.0
"""Least width of a wall / its thickness. Under L/t = 4 a part is solid (Altair Radioss, shells: thin beyond 20,
thick 4-10, solid under 4); 3 to 5 gave the same answers on the labelled models."""

RADIUS_RATIO = 5.0
"""Least mean radius / thickness of a cylindrical wall: R/t under 4-5 is a solid (same source)."""

KEPT_SHARE = 0.5
"""Share of a region that must survive the opening, and share of its outline that must be there (holes aside)."""

LARGE_HOLE = 40.0
"""A hole larger than this many thicknesses squared shapes the wall; smaller ones are drilled through it."""


MET = 2e-4
"""A limit that is missed by less than this share is met: an erosion that leaves less than a 1e-5 of its width may
come back empty, and rounding must not decide what the input meets exactly."""


CHORD = 1.0 - float(np.cos(np.pi / 90.0))
"""How far, as a share of the radius, the chord of a circle may come within it: circles are drawn with 96 facets."""


SMOOTH = 1e-6
"""Outlines are smoothed by this share of the opening's width before it is measured."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaneWall:
    """Between two parallel planes; bottom < top along `normal`. paired: in coordinates (x.u, x.v), u x v = normal."""

    surface_ids: tuple[int, int]
    normal: Vector
    u: Vector
    v: Vector
    bottom: float
    top: float
    paired: Region

    @property
    def thickness(self) -> float:
        """Distance of the two faces."""
        return self.top - self.bottom

    @property
    def area(self) -> float:
        """Of the paired region."""
        return float(self.paired.area)

    @property
    def width(self) -> float:
        """Least width of the paired region: shorter side of the smallest rectangle around it."""
        return smallest_rectangle(self.paired)[1]


@dataclass(frozen=True, slots=True, eq=False)
class TubeWall:
    """Between two coaxial cylinders. paired: in coordinates (angle, z along the axis from its point)."""

    surface_ids: tuple[int, int]
    axis: Axis
    axis_id: int
    inner_radius: float
    outer_radius: float
    paired: Region

    @property
    def thickness(self) -> float:
        """Outer less inner radius."""
        return self.outer_radius - self.inner_radius

    @property
    def mid_radius(self) -> float:
        """Radius of the mid-surface."""
        return 0.5 * (self.inner_radius + self.outer_radius)

    @property
    def area(self) -> float:
        """Of the paired region at the mean radius."""
        return float(self.paired.area) * self.mid_radius

    @property
    def width(self) -> float:
        """Shorter extent of the unrolled region."""
        left, bottom, right, top = self.paired.bounds
        return min((right - left) * self.mid_radius, top - bottom)


Wall = PlaneWall | TubeWall


def opening(region: Region, width: float) -> Region:
    """The region less everything too narrow to hold a square of `width` (erosion, then dilation, mitred).

    Edges that rounding left are taken out first: a mitred erosion of them may come back empty.
    """
    smooth = region.simplify(SMOOTH * width)
    return smooth.buffer(-0.5 * width, join_style="mitre").buffer(0.5 * width * 1.001, join_style="mitre")


def find_walls(faces: Faces) -> tuple[Wall, ...]:
    """Every pair of faces of a solid that makes a wall, in a fixed order (planes first)."""
    flat = _without_details(list(_plane_walls(faces)))
    return (*_without_laps(flat, faces.table.tolerance), *_tube_walls(faces))


# ---------------------------------------------------------------- planes


@dataclass(frozen=True, slots=True, eq=False)
class _PlaneFace:
    surface: int
    side: int
    offset: float
    area: float


def _plane_walls(faces: Faces) -> Iterator[PlaneWall]:
    for direction, bottoms, tops in _parallel_faces(faces):
        for bottom in bottoms:
            for top in tops:
                thickness = top.offset - bottom.offset
                if thickness <= faces.table.tolerance:
                    continue
                if min(top.area, bottom.area) < KEPT_SHARE * np.pi / 4.0 * (OPENING_FACTOR * thickness) ** 2:
                    continue  # no disc of the opening's width fits
                wall = _plane_wall(faces, direction, bottom, top, tops)
                if wall is not None:
                    yield wall


def _parallel_faces(faces: Faces) -> list[tuple[Plane, list[_PlaneFace], list[_PlaneFace]]]:
    """By direction: a plane of it, the faces that look down it, and those that look up, by offset."""
    groups: list[tuple[Plane, list[_PlaneFace], list[_PlaneFace]]] = []
    for (surface, side), area in sorted(faces.areas.items()):
        plane = faces.table.surfaces[surface]
        if not isinstance(plane, Plane):
            continue
        known = [group for group in groups if np.abs(group[0].normal - plane.normal).max() < ANGLE_TOLERANCE]
        if not known:
            known = [(plane, [], [])]
            groups += known
        _, bottoms, tops = known[0]
        (tops if side > 0 else bottoms).append(_PlaneFace(surface, side, plane.offset, area))
    for _, bottoms, tops in groups:
        bottoms.sort(key=lambda face: face.offset)
        tops.sort(key=lambda face: face.offset)
    return groups


def _plane_wall(
    faces: Faces, direction: Plane, bottom: _PlaneFace, top: _PlaneFace, tops: list[_PlaneFace]
) -> PlaneWall | None:
    paired = faces.polygon(bottom.surface, -1).intersection(faces.polygon(top.surface, 1))
    if paired.is_empty:
        return None
    tolerance = faces.table.tolerance
    between = [face for face in tops if bottom.offset + tolerance < face.offset < top.offset - tolerance]
    if between:
        paired = paired.difference(shapely.union_all([faces.polygon(face.surface, 1) for face in between]))
    thickness = top.offset - bottom.offset
    parts = [part for part in parts_of(paired) if _is_wide(part, thickness)]
    if not parts:
        return None
    return PlaneWall(
        surface_ids=(bottom.surface, top.surface),
        normal=direction.normal,
        u=direction.u,
        v=direction.v,
        bottom=bottom.offset,
        top=top.offset,
        paired=shapely.multipolygons(parts) if len(parts) > 1 else parts[0],
    )


def _is_wide(part: Polygon, thickness: float) -> bool:
    """The opening criterion, drilled holes filled first (unless they are most of the region)."""
    outline = Polygon(
        part.exterior, [hole for hole in part.interiors if Polygon(hole).area > LARGE_HOLE * thickness**2]
    )
    if part.area < KEPT_SHARE * outline.area:
        outline = part
    return bool(opening(outline, OPENING_FACTOR * thickness * (1.0 - MET)).area >= KEPT_SHARE * outline.area)


def _without_details(walls: list[PlaneWall]) -> list[PlaneWall]:
    """Walls that are no more than the floor of a hole in another are left out (a counterbore)."""
    kept = []
    for wall in walls:
        for other in walls:
            is_beside = other is not wall and other.normal is wall.normal
            if not is_beside or wall.top <= other.bottom or other.top <= wall.bottom or wall.area >= other.area:
                continue
            holes = [Polygon(ring) for part in parts_of(other.paired) for ring in part.interiors]
            holes = [hole for hole in holes if hole.area <= LARGE_HOLE * other.thickness**2]
            if holes and wall.paired.difference(shapely.union_all(holes)).area < 1e-3 * wall.area:
                break
        else:
            kept.append(wall)
    return kept


def _without_laps(walls: list[PlaneWall], tolerance: float) -> list[PlaneWall]:
    """Where two walls lie on one another, each reaches through the lap; their common thickness is no wall.

    The lap runs from the bottom of one to the top of the other, and a plane between is the top of the one and the
    bottom of the other, outside the lap.
    """
    laps: set[int] = set()
    reach: dict[int, list[Region]] = {}
    for number, lap in enumerate(walls):
        lower = [k for k, wall in enumerate(walls) if wall.surface_ids[0] == lap.surface_ids[0] and k != number]
        upper = [k for k, wall in enumerate(walls) if wall.surface_ids[1] == lap.surface_ids[1] and k != number]
        for low in lower:
            for high in upper:
                if walls[low].surface_ids[1] != walls[high].surface_ids[0]:
                    continue
                if max(walls[k].paired.distance(lap.paired) for k in (low, high)) < 10.0 * tolerance:
                    laps.add(number)
                    reach.setdefault(low, []).append(lap.paired)
                    reach.setdefault(high, []).append(lap.paired)
    return [
        replace(wall, paired=shapely.union_all([wall.paired, *reach[number]])) if number in reach else wall
        for number, wall in enumerate(walls)
        if number not in laps
    ]


# ---------------------------------------------------------------- cylinders


def _tube_walls(faces: Faces) -> Iterator[TubeWall]:
    coaxial: dict[int, list[tuple[float, int, int]]] = {}
    for surface, side in sorted(faces.areas):
        cylinder = faces.table.surfaces[surface]
        if isinstance(cylinder, CylinderSurface):
            coaxial.setdefault(cylinder.axis_id, []).append((cylinder.radius, surface, side))
    for group in coaxial.values():
        group.sort()
        outer_faces = [(radius, surface) for radius, surface, side in group if side > 0]
        inner_faces = [(radius, surface) for radius, surface, side in group if side < 0]
        for outer_radius, outer in outer_faces:
            for inner_radius, inner in inner_faces:
                if inner_radius >= outer_radius - faces.table.tolerance:
                    continue
                mean, thickness = 0.5 * (inner_radius + outer_radius), outer_radius - inner_radius
                if mean / thickness < RADIUS_RATIO * (1.0 - MET):
                    continue
                hidden = [surface for radius, surface in outer_faces if inner_radius < radius < outer_radius]
                wall = _tube_wall(faces, inner, outer, hidden)
                for stretch in stretches(faces, wall) if wall is not None else ():
                    if stretch.width >= OPENING_FACTOR * thickness * (1.0 - MET):
                        yield stretch


def _tube_wall(faces: Faces, inner: int, outer: int, hidden: list[int]) -> TubeWall | None:
    """The wall between two faces of one axis, whatever its proportions; None where they do not face one another."""
    inner_surface, outer_surface = faces.table.surfaces[inner], faces.table.surfaces[outer]
    assert isinstance(inner_surface, CylinderSurface)
    assert isinstance(outer_surface, CylinderSurface)
    paired = faces.unrolled(inner, -1).intersection(faces.unrolled(outer, 1))
    for surface in hidden:
        paired = paired.difference(faces.unrolled(surface, 1))
    parts = parts_of(paired)
    if not parts:
        return None
    return TubeWall(
        surface_ids=(inner, outer),
        axis=outer_surface.axis,
        axis_id=outer_surface.axis_id,
        inner_radius=inner_surface.radius,
        outer_radius=outer_surface.radius,
        paired=MultiPolygon(parts),
    )


def stretches(faces: Faces, wall: TubeWall) -> list[TubeWall]:
    """The wall in stretches along its axis, cut where there is nothing between them: rings about a pipe are many.

    Where another wall runs through it, the wall goes on.
    """
    groups = heights_apart(faces.facets, wall.axis, wall.mid_radius, parts_of(wall.paired))
    return [wall] if len(groups) == 1 else [replace(wall, paired=MultiPolygon(parts)) for parts in groups]


def enclosing_tube(solid: Solid) -> TubeWall | None:
    """The pair of coaxial cylinders that the whole solid lies between, whatever its proportions; or None."""
    faces = faces_of(solid)
    cylinders = [
        (faces.table.surfaces[surface], surface, side)
        for surface, side in sorted(faces.areas)
        if isinstance(faces.table.surfaces[surface], CylinderSurface)
    ]
    for outer, outer_id, outer_side in cylinders:
        assert isinstance(outer, CylinderSurface)
        if outer_side < 0:
            continue
        arm = solid.facets.vertices - outer.axis.point
        radius = np.hypot(arm @ outer.axis.x, arm @ outer.axis.y)
        for inner, inner_id, inner_side in cylinders:
            assert isinstance(inner, CylinderSurface)
            if inner_side > 0 or inner.axis_id != outer.axis_id or inner.radius >= outer.radius:
                continue
            slack = 10.0 * faces.table.tolerance
            if least_radius(solid, outer.axis) > inner.radius - slack and radius.max() < outer.radius + slack:
                return _tube_wall(faces, inner_id, outer_id, [])
    return None


def least_radius(solid: Solid, axis: Axis) -> float:
    """How near the solid's edges come to an axis; chords of circles about it count as those circles."""
    facets = solid.facets
    arm = facets.vertices - axis.point
    flat = np.stack([arm @ axis.x, arm @ axis.y], axis=1)
    start, end = flat[facets.triangles.ravel()], flat[np.roll(facets.triangles, -1, axis=1).ravel()]
    along = end - start
    square = np.maximum(np.einsum("ij,ij->i", along, along), np.finfo(float).tiny)
    share = np.clip(-np.einsum("ij,ij->i", start, along) / square, 0.0, 1.0)
    nearest = np.linalg.norm(start + share[:, None] * along, axis=1)
    ends = np.minimum(np.linalg.norm(start, axis=1), np.linalg.norm(end, axis=1))
    is_chord = nearest >= ends * (1.0 - CHORD)
    return float(np.where(is_chord, ends, nearest).min())
