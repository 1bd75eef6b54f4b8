"""The rings in which a solid meets a sheet, and those around a set of triangles: points, and what trims each edge."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.sheets import PlaneSheet, Sheet
from kernel.solid.section import boundary_chains
from kernel.solid.solid import Solid, cut_by, intersect, tube

if TYPE_CHECKING:
    from kernel.solid.facets import Facets
    from kernel.solid.surfaces import Axis

Array = NDArray[np.float64]

LEAST_GAP = 1e-6
"""Radians: rings that come nearer to one another than this leave no gap."""


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


def middle_angle(rings: Sequence[Ring], axis: Axis) -> float | None:
    """The angle (radians) opposite the middle of the widest gap that rings leave about an axis; None where they leave
    none.
    """
    spans = []
    for ring in rings:
        relative = ring.points - axis.point
        angles = np.arctan2(relative @ axis.y, relative @ axis.x)
        steps = np.mod(np.roll(angles, -1) - angles + np.pi, 2 * np.pi) - np.pi
        spans += [(a + min(0.0, step), a + max(0.0, step)) for a, step in zip(angles.tolist(), steps.tolist())]
    spans.sort()
    covered, widest, middle = spans[0][1], LEAST_GAP, 0.0
    for low, high in (*spans[1:], *((low + 2 * np.pi, high + 2 * np.pi) for low, high in spans)):
        if low - covered > widest:
            widest, middle = low - covered, 0.5 * (low + covered)
        covered = max(covered, high)
    return float(middle + np.pi) if widest > LEAST_GAP else None
