"""Exact integrals over a polygon with holes (Green's theorem, edge by edge)."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from shapely import Polygon

NEGLIGIBLE_PRODUCT = 1e-12
"""iyz below this share of iyy + izz is rounding of a symmetric section: written as 0."""


@dataclass(frozen=True, slots=True)
class SectionValues:
    """Area, second moments about the centroid, and (0 until known) torsion constant and shear areas."""

    area: float
    iyy: float
    izz: float
    iyz: float
    centroid: tuple[float, float]
    j: float = 0.0
    shear_area_y: float = 0.0
    shear_area_z: float = 0.0

    def with_shear(self, j: float, shear_area_y: float, shear_area_z: float) -> SectionValues:
        """The same, torsion constant and shear areas filled in."""
        return replace(self, j=j, shear_area_y=shear_area_y, shear_area_z=shear_area_z)


def rings(polygon: Polygon) -> list[NDArray[np.float64]]:
    """Outer ring counter-clockwise, then the holes clockwise; each (n, 2), not closed."""
    result = []
    for index, ring in enumerate([polygon.exterior, *polygon.interiors]):
        points = np.asarray(ring.coords)[:-1, :2]
        result.append(points if ring.is_ccw == (index == 0) else points[::-1])
    return result


def moments(polygon: Polygon) -> SectionValues:
    """Area, centroid and second moments. Computed about a point of the outline, so far origins cost no digits."""
    loops = rings(polygon)
    origin = loops[0].mean(axis=0)
    area = first_y = first_z = yy = zz = yz = 0.0
    for loop in loops:
        y, z = (loop - origin).T
        y2, z2 = np.roll(y, -1), np.roll(z, -1)
        cross = y * z2 - y2 * z
        area += cross.sum() / 2
        first_y += ((y + y2) * cross).sum() / 6
        first_z += ((z + z2) * cross).sum() / 6
        yy += ((y * y + y * y2 + y2 * y2) * cross).sum() / 12
        zz += ((z * z + z * z2 + z2 * z2) * cross).sum() / 12
        yz += ((2 * y * z + y * z2 + y2 * z + 2 * y2 * z2) * cross).sum() / 24
    cy, cz = first_y / area, first_z / area
    izz, iyy, iyz = yy - area * cy * cy, zz - area * cz * cz, yz - area * cy * cz
    if abs(iyz) < NEGLIGIBLE_PRODUCT * (iyy + izz):
        iyz = 0.0
    return SectionValues(
        float(area), float(iyy), float(izz), float(iyz), (float(origin[0] + cy), float(origin[1] + cz))
    )
