"""The faces of a solid as polygons in the plane: planar ones in the plane's frame, cylindrical ones unrolled."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias
from weakref import WeakKeyDictionary

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from kernel.segment.slices import SNAP, parts_of
from kernel.solid.section import face_polygon
from kernel.solid.surfaces import Axis, CylinderSurface, FacetedSurface, Plane, outward

if TYPE_CHECKING:
    from kernel.solid.solid import Facets, Solid

Region: TypeAlias = Polygon | MultiPolygon


class Faces:
    """Faces of one solid by surface id and side, polygons made when first asked for.

    side: +1 where the outward normal runs with the surface's own (plane's normal; away from the cylinder's axis),
    -1 where it runs against it; likewise away from a cone's axis, a sphere's centre, the middle of a torus's tube.
    """

    def __init__(self, solid: Solid) -> None:
        self.table = solid.surfaces
        self.facets = facets = solid.facets
        self._sides = _sides(facets, self.table.surfaces)
        self._polygons: dict[tuple[int, int], Region] = {}
        self._unrolled: dict[tuple[int, int], Region] = {}
        self.areas: dict[tuple[int, int], float] = {}
        for side in (1, -1):
            mask = self._sides == side
            held = np.bincount(facets.surface[mask], weights=facets.areas[mask])
            for surface in np.unique(facets.surface[mask]):
                self.areas[(int(surface), side)] = float(held[surface])

    def mask(self, surface: int, side: int) -> NDArray[np.bool_]:
        """Which triangles are that face."""
        return (self.facets.surface == surface) & (self._sides == side)

    def polygon(self, surface: int, side: int) -> Region:
        """A planar face in coordinates (x.u, x.v) of its plane; empty where the solid has none such."""
        key = (surface, side)
        if key not in self._polygons:
            plane = self.table.surfaces[surface]
            assert isinstance(plane, Plane)
            self._polygons[key] = face_polygon(self.facets, self.mask(surface, side), plane.u, plane.v)
        return self._polygons[key]

    def unrolled(self, surface: int, side: int) -> Region:
        """A cylindrical face in coordinates (angle in radians, z along the axis), angles within -pi..pi."""
        key = (surface, side)
        if key not in self._unrolled:
            cylinder = self.table.surfaces[surface]
            assert isinstance(cylinder, CylinderSurface)
            self._unrolled[key] = unroll(self.facets, self.mask(surface, side), cylinder.axis)
        return self._unrolled[key]


_KNOWN: WeakKeyDictionary[Solid, Faces] = WeakKeyDictionary()


def faces_of(solid: Solid) -> Faces:
    """The faces of a solid, made once."""
    known = _KNOWN.get(solid)
    if known is None:
        known = _KNOWN[solid] = Faces(solid)
    return known


def _sides(facets: Facets, surfaces: list) -> NDArray[np.int64]:
    """(m,) +1, -1, or 0 for triangles on a surface without an analytic form."""
    sides = np.zeros(len(facets.triangles), np.int64)
    ids, place = np.unique(facets.surface, return_inverse=True)
    held = [surfaces[index] for index in ids.tolist()]
    is_flat = np.array([isinstance(surface, Plane) for surface in held], dtype=bool)
    normals = np.array([surface.normal if isinstance(surface, Plane) else np.zeros(3) for surface in held])
    flat = is_flat[place]
    along = np.einsum("ij,ij->i", facets.normals, normals.reshape(-1, 3)[place])
    sides[flat] = np.where(along[flat] > 0.0, 1, -1)
    for number in np.flatnonzero(~is_flat).tolist():
        surface, own = held[number], np.flatnonzero(place == number)
        if isinstance(surface, CylinderSurface):
            arm = facets.centroids[own] - surface.axis.point
            along = np.einsum("ij,ij->i", arm, facets.normals[own])
        elif isinstance(surface, FacetedSurface):
            continue
        else:
            along = np.einsum("ij,ij->i", outward(surface, facets.centroids[own]), facets.normals[own])
        sides[own] = np.where(along > 0.0, 1, -1)
    return sides


HALF_TURN = round(math.pi, 12)
TURN = 2.0 * HALF_TURN
"""Angles are kept to 12 decimals, a full turn too, so that what is shifted by a turn fits its neighbours exactly."""


def unroll(facets: Facets, mask: NDArray[np.bool_], axis: Axis) -> Region:
    """Triangles on a cylinder as a polygon in (angle, z), cut at angle +-pi."""
    if not mask.any():
        return Polygon()
    arm = facets.vertices - axis.point
    z = arm @ axis.direction
    grid = SNAP * max(float(np.ptp(z)), 1e-300)
    z = np.round(z / grid) * grid
    angle = np.round(np.arctan2(arm @ axis.y, arm @ axis.x), 12)[facets.triangles[mask]]
    angle = np.where(angle - angle[:, :1] > HALF_TURN, angle - TURN, angle)
    angle = np.where(angle - angle[:, :1] < -HALF_TURN, angle + TURN, angle)
    corners = np.stack([np.round(angle, 12), z[facets.triangles[mask]]], axis=-1)
    rings = np.concatenate([corners, corners[:, :1]], axis=1)
    edge_one, edge_two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(edge_one[:, 0] * edge_two[:, 1] - edge_one[:, 1] * edge_two[:, 0])
    patch = _covered(shapely.polygons(rings[area > 0.0]), 0.5 * float(area.sum()), SNAP * float(np.ptp(z)))
    return _within_a_turn(shapely.multipolygons(parts_of(patch)))


def _covered(triangles: NDArray[np.object_], area: float, grid: float) -> shapely.Geometry:
    """Union of triangles that share whole edges: ten times the speed of a general union, which serves where rounding
    broke that promise (the area tells, or the union refuses).
    """
    try:
        patch = shapely.coverage_union_all(triangles)
    except shapely.errors.GEOSException:
        patch = None
    if patch is None or abs(patch.area - area) > 1e-6 * area:
        return shapely.union_all(triangles, grid_size=grid)
    return patch


def _shifted(region: Region, turns: int) -> Region:
    return shapely.transform(
        region, lambda points: np.stack([np.round(points[:, 0] + turns * TURN, 12), points[:, 1]], axis=1)
    )


def _sound(region: Region) -> Region:
    """The region without the self-contacts that rounding left in its rings."""
    return region if region.is_valid else shapely.make_valid(region, method="structure", keep_collapsed=False)


def _within_a_turn(region: Region) -> Region:
    """A region in (angle, z) brought within -pi..pi."""
    left, bottom, right, top = region.bounds
    copies = [region]
    if right > HALF_TURN:
        copies.append(_shifted(region, -1))
    if left < -HALF_TURN:
        copies.append(_shifted(region, 1))
    if len(copies) == 1:
        return region
    height = top - bottom
    window = shapely.box(-HALF_TURN, bottom - height, HALF_TURN, top + height)
    try:  # exact, so that the two sides of the cut fit one another when they are glued again
        whole = shapely.union_all(copies).intersection(window)
    except shapely.errors.GEOSException:
        grid = SNAP * max(height, TURN)
        whole = shapely.union_all([_sound(copy) for copy in copies], grid_size=grid)
        whole = shapely.intersection(whole, window, grid_size=grid)
    return shapely.multipolygons(parts_of(whole))


def _three_turns(region: Region) -> Region:
    """The region glued to its copies on either side."""
    copies = [_sound(_shifted(region, turns)) for turns in (-1, 0, 1)]
    return shapely.union_all(copies)


def periodic_holes(region: Region) -> list[Polygon]:
    """Holes of a region in (angle, z) that closes on itself at +-pi; a hole across the seam counts once."""
    holes = [Polygon(ring) for part in parts_of(_three_turns(region)) for ring in part.interiors]
    slack = 1e-6  # a hole centred on the seam counts at -pi, not at pi
    return [hole for hole in holes if -math.pi - slack <= hole.centroid.x < math.pi - slack]


def closes(region: Region) -> bool:
    """Whether some part of a region in (angle, z) goes all the way round the axis."""
    if region.is_empty or region.bounds[2] - region.bounds[0] < TURN - 1e-9:
        return False
    return any(part.bounds[2] - part.bounds[0] > 1.5 * TURN for part in parts_of(_three_turns(region)))
