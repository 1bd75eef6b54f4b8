"""The faces of segments as joints see them: one side of one surface each, and what of the surface it covers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.segment.faces import Faces
from kernel.solid.charts import cover
from kernel.solid.surfaces import CylinderSurface, Plane

if TYPE_CHECKING:
    from kernel.segment.faces import Region

CONVEX = 1e-10
"""A face whose area is that of its hull within this is its hull: no boundary need be chained."""


@dataclass(slots=True, eq=False)
class FaceSide:
    """One side of one surface in the segment of index `segment`; `box` (2, 3) bounds its triangles."""

    segment: int
    surface: int
    side: int
    box: NDArray[np.float64]


def sides_of(index: int, faces: Faces) -> list[FaceSide]:
    """All faces of a segment."""
    facets = faces.facets
    rows = []
    for surface, side in sorted(faces.areas):
        corners = facets.vertices[facets.triangles[faces.mask(surface, side)]].reshape(-1, 3)
        rows.append(FaceSide(index, surface, side, np.array([corners.min(axis=0), corners.max(axis=0)])))
    return rows


def patch_of(faces: Faces, row: FaceSide) -> Region:
    """The face in the surface's own coordinates."""
    surface = faces.table.surfaces[row.surface]
    if isinstance(surface, CylinderSurface):
        return shapely.transform(faces.unrolled(row.surface, row.side), lambda at: at * (surface.radius, 1.0))
    facets = faces.facets
    if not isinstance(surface, Plane):
        return cover(surface, facets.vertices[facets.triangles[faces.mask(row.surface, row.side)]])
    corners = facets.vertices[np.unique(facets.triangles[faces.mask(row.surface, row.side)])]
    hull = shapely.convex_hull(shapely.multipoints(np.stack([corners @ surface.u, corners @ surface.v], axis=1)))
    if hull.area <= faces.areas[(row.surface, row.side)] * (1 + CONVEX):
        return hull
    return faces.polygon(row.surface, row.side)
