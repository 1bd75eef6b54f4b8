"""Properties of a beam's section, from its true outline."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon


@dataclass(frozen=True, slots=True, eq=False)
class SectionProperties:
    """About the centroid, axes y (the beam's `u`) and z (the beam's `v`).

    shape: "rectangle", "circle", "tube", "i", "channel", "angle", "tee", "zed", "box" or "general".
    iyy = integral of z^2, izz = integral of y^2, iyz = integral of y z. j: Saint-Venant torsion constant.
    centroid: (y, z) in the outline's coordinates. shear_centre: (y, z) from the centroid.
    shear_area_y, shear_area_z: A / k of Timoshenko, for shear along y and z.
    dimensions: the standard shape's own sizes (e.g. {"width", "height", "web", "flange"}), empty for "general".
    """

    shape: str
    area: float
    iyy: float
    izz: float
    iyz: float
    j: float
    centroid: tuple[float, float]
    shear_centre: tuple[float, float]
    shear_area_y: float
    shear_area_z: float
    outline: Polygon | MultiPolygon
    dimensions: dict[str, float]
