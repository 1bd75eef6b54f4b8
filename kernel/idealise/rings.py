"""The rings in which a solid meets a sheet, and those around a set of triangles: points, and what trims each edge."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.sheets import PlaneSheet, Sheet
from kernel.solid.section import boundary_chains
from kernel.solid.solid import cut_by, intersect, tube

if TYPE_CHECKING:
    from kernel.segment.segments import CylinderShape
    from kernel.solid.facets import Facets
    from kernel.solid.section import boundary_chains
from kernel.solid.solid import Solid

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Ring:
    """points: (n, 3); labels: (n,) id of the surface beyond the edge from point k to k + 1."""

    points: Array
    labels: NDArray[np.int64]

    def turned(self) -> Ring:
        """The same ring walked the other way."""
        return Ring(self.points[::-1], np.roll(self.labels[::-1], -1))


def boundary_rings(facets: Facets, mask: NDArray[np.bool_]) -> list[Ring]:
    """Rings around the triangles of `mask`, which lie on their left when seen from outside the solid."""
    return [Ring(facets.vertices[chain], facets.surface[across]) for chain, across in boundary_chains(facets, mask)]


def plane_rings(solid: Solid, sheet: PlaneSheet) -> list[Ring]:
    """Where the solid meets a plane: the region on the left, seen against the sheet's normal."""
    half = cut_by(solid, sheet.normal, sheet.offset, sheet.surface_id)
    if half.is_empty:
        return []
    facets = half.facets
    mask = (facets.surface == sheet.surface_id) & (facets.normals @ sheet.normal < 0)
    return [ring.turned() for ring in boundary_rings(facets, mask)] if mask.any() else []


def sheet_rings(solid: Solid, sheet: Sheet) -> list[Ring]:
    """Where the solid meets a sheet: the region on the left, seen against the sheet's normals."""
    if isinstance(sheet, PlaneSheet):
        return plane_rings(solid, sheet)
    table = solid.surfaces
    height = solid.bounds - sheet.axis.point
    corners = np.array([[height[i, 0], height[j, 1], height[k, 2]] for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    along = corners @ sheet.axis.direction
    margin = solid.size
    axis_id = sheet.surface.axis_id
    core = tube(table, axis_id, 0.0, sheet.radius, float(along.min()) - margin, float(along.max()) + margin)
    inside = intersect((solid, core))
    if inside.is_empty:
        return []
    facets = inside.facets
    away = sheet.normals(facets.centroids)
    mask = (facets.surface == sheet.surface_id) & (np.einsum("ij,ij->i", facets.normals, away) > 0)
    return boundary_rings(facets, mask) if mask.any() else []


def middle_angle(solid: Solid, shape: CylinderShape) -> float:
    """The angle (radians) amid the material of a cylinder-plate: opposite the middle of its widest gap."""
    relative = solid.facets.vertices - shape.axis.point
    angles = np.unique(np.arctan2(relative @ shape.axis.y, relative @ shape.axis.x))
    gaps = np.diff(np.concatenate([angles, angles[:1] + 2 * np.pi]))
    widest = int(np.argmax(gaps))
    return float(angles[widest] + 0.5 * gaps[widest] + np.pi)
