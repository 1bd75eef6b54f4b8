"""The faces of a solid as polygons in the plane: planar ones in the plane's frame, cylindrical ones unrolled."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from kernel.segment.slices import SNAP, parts_of
from kernel.solid.section import face_polygon
from kernel.solid.surfaces import Axis, CylinderSurface, Plane

if TYPE_CHECKING:
    from kernel.solid.solid import Facets, Solid

Region: TypeAlias = Polygon | MultiPolygon


class Faces:
    """Faces of one solid by surface id and side, polygons made when first asked for.

    side: +1 where the outward normal runs with the surface's own (plane's normal; away from the cylinder's axis),
    -1 where it runs against it.
    """

    def __init__(self, solid: Solid) -> None:
        self.solid = solid
        self.table = solid.surfaces
        facets = solid.facets
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
        return (self.solid.facets.surface == surface) & (self._sides == side)

    def polygon(self, surface: int, side: int) -> Region:
        """A planar face in coordinates (x.u, x.v) of its plane; empty where the solid has none such."""
        key = (surface, side)
        if key not in self._polygons:
            plane = self.table.surfaces[surface]
            assert isinstance(plane, Plane)
            self._polygons[key] = face_polygon(self.solid.facets, self.mask(surface, side), plane.u, plane.v)
        return self._polygons[key]

    def unrolled(self, surface: int, side: int) -> Region:
        """A cylindrical face in coordinates (angle in radians, z along the axis), angles within -pi..pi."""
        key = (surface, side)
        if key not in self._unrolled:
            cylinder = self.table.surfaces[surface]
            assert isinstance(cylinder, CylinderSurface)
            self._unrolled[key] = unroll(self.solid.facets, self.mask(surface, side), cylinder.axis)
        return self._unrolled[key]


def _sides(facets: Facets, surfaces: list) -> NDArray[np.int64]:
    """(m,) +1, -1, or 0 for triangles that are on no plane and no cylinder."""
    sides = np.zeros(len(facets.triangles), np.int64)
    for index in np.unique(facets.surface):
        surface = surfaces[index]
        mask = facets.surface == index
        if isinstance(surface, Plane):
            outward = facets.normals[mask] @ surface.normal
        elif isinstance(surface, CylinderSurface):
            arm = facets.centroids[mask] - surface.axis.point
            outward = np.einsum("ij,ij->i", arm, facets.normals[mask])
        else:
            continue
        sides[mask] = np.where(outward > 0.0, 1, -1)
    return sides


def unroll(facets: Facets, mask: NDArray[np.bool_], axis: Axis) -> Region:
    """Triangles on a cylinder as a polygon in (angle, z), cut at angle +-pi."""
    if not mask.any():
        return Polygon()
    arm = facets.vertices - axis.point
    z = arm @ axis.direction
    angle = np.arctan2(arm @ axis.y, arm @ axis.x)
    corner_angle = angle[facets.triangles[mask]]
    corner_angle = np.where(corner_angle - corner_angle[:, :1] > math.pi, corner_angle - 2 * math.pi, corner_angle)
    corner_angle = np.where(corner_angle - corner_angle[:, :1] < -math.pi, corner_angle + 2 * math.pi, corner_angle)
    corners = np.stack([corner_angle, z[facets.triangles[mask]]], axis=-1)
    grid = SNAP * max(float(np.ptp(z)), 1.0)
    corners = np.round(corners / grid) * grid
    rings = np.concatenate([corners, corners[:, :1]], axis=1)
    edge_one, edge_two = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    area = np.abs(edge_one[:, 0] * edge_two[:, 1] - edge_one[:, 1] * edge_two[:, 0])
    patch = shapely.union_all(shapely.polygons(rings[area > 0.0]), grid_size=grid)
    return wrapped(patch)


def wrapped(region: Region) -> Region:
    """A region in (angle, z) brought within -pi..pi."""
    left, bottom, right, top = region.bounds if not region.is_empty else (0.0, 0.0, 0.0, 0.0)
    turn = 2 * math.pi
    copies = [region]
    if right > math.pi:
        copies.append(shapely.transform(region, lambda points: points - (turn, 0.0)))
    if left < -math.pi:
        copies.append(shapely.transform(region, lambda points: points + (turn, 0.0)))
    whole = shapely.union_all(copies) if len(copies) > 1 else region
    window = shapely.box(-math.pi, bottom - 1.0, math.pi, top + 1.0)
    return shapely.multipolygons(parts_of(whole.intersection(window)))


def scaled(region: Region, x_factor: float) -> Region:
    """The region with its x coordinates multiplied."""
    return shapely.transform(region, lambda points: points * (x_factor, 1.0))


def periodic_holes(region: Region) -> list[Polygon]:
    """Holes of a region in (angle, z) that closes on itself at +-pi; a hole across the seam counts once."""
    turn = 2 * math.pi
    copies = [shapely.transform(region, lambda points, k=k: points + (k * turn, 0.0)) for k in (-1, 0, 1)]
    grid = SNAP * max(1.0, float(np.abs(region.bounds).max()) if not region.is_empty else 1.0)
    whole = shapely.union_all(copies, grid_size=grid)
    holes = [Polygon(ring) for part in parts_of(whole) for ring in part.interiors]
    return [hole for hole in holes if -math.pi <= hole.centroid.x < math.pi]


def closes(region: Region) -> bool:
    """Whether a region in (angle, z) goes all the way round the axis."""
    left, _, right, _ = region.bounds
    return bool(left < -math.pi + 1e-9 and right > math.pi - 1e-9) and _has_full_turn(region)


def _has_full_turn(region: Region) -> bool:
    """Whether some part, glued to its copies on either side, reaches through more than one turn."""
    turn = 2 * math.pi
    copies = [shapely.transform(region, lambda points, k=k: points + (k * turn, 0.0)) for k in (-1, 0, 1)]
    whole = shapely.union_all(copies, grid_size=SNAP * max(1.0, float(np.abs(region.bounds).max())))
    return any(part.bounds[2] - part.bounds[0] > 1.5 * turn for part in parts_of(whole))
