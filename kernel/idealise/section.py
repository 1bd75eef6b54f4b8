"""Properties of a beam's section, from its true outline.

Area and second moments are exact line integrals. Rectangles, circles and tubes have closed forms for the rest;
every other outline is solved for by finite elements (torsion.py), which alone needs scipy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kernel.errors import MeshError
from kernel.idealise.closed_sections import circle, rectangle, tube
from kernel.idealise.outline import moments
from kernel.idealise.profiles import recognise

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon


@dataclass(frozen=True, slots=True, eq=False)
class SectionProperties:
    """About the centroid, axes y (the beam's `u`) and z (the beam's `v`).

    shape: "rectangle", "circle", "tube", "i", "channel", "angle", "tee", "zed", "box" or "general".
    iyy = integral of z^2, izz = integral of y^2, iyz = integral of y z. j: Saint-Venant torsion constant.
    centroid: (y, z) in the outline's coordinates. shear_centre: (y, z) from the centroid.
    shear_area_y, shear_area_z: A / k of Timoshenko, for shear along y and z (strain energy, Poisson's ratio 0).
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


def section_properties(outline: Polygon | MultiPolygon) -> SectionProperties:
    """Properties of the outline; circles in it are inscribed polygons (a whole circle is recognised as one).

    MeshError: the outline is empty or in several pieces, so that it is no section of one beam.
    """
    parts = list(getattr(outline, "geoms", [outline]))
    if len(parts) != 1 or parts[0].area <= 0:
        what = f"is in {len(parts)} pieces" if len(parts) > 1 else "is empty"
        raise MeshError(f"the beam's section {what}, expected one connected outline")
    polygon = parts[0]
    profile = recognise(polygon)
    closed = {"rectangle": rectangle, "circle": circle, "tube": tube}.get(profile.shape)
    exact = moments(polygon)
    if closed is not None:
        values = closed(profile.dimensions, exact)
        shear_centre = (0.0, 0.0)
    else:
        from kernel.idealise.torsion import solve_warping  # scipy: only where no closed form serves

        warping = solve_warping(polygon, exact)
        values = exact.with_shear(warping.j, warping.shear_area_y, warping.shear_area_z)
        shear_centre = warping.shear_centre
    return SectionProperties(
        shape=profile.shape,
        area=values.area,
        iyy=values.iyy,
        izz=values.izz,
        iyz=values.iyz,
        j=values.j,
        centroid=exact.centroid,
        shear_centre=shear_centre,
        shear_area_y=values.shear_area_y,
        shear_area_z=values.shear_area_z,
        outline=outline,
        dimensions=profile.dimensions,
    )


def principal_section(section: SectionProperties) -> tuple[SectionProperties, float]:
    """The section in its principal axes, and the angle (radians, from y to z) by which they are turned.

    The turned y axis is the one that lies nearest to y, so that a section without iyz comes back as it is.
    """
    if section.iyz == 0:
        return section, 0.0
    # tan 2 a = 2 iyz / (izz - iyy) has one root within 45 degrees of y
    difference = section.izz - section.iyy
    angle = 0.5 * math.atan(2 * section.iyz / difference) if difference else math.pi / 4
    from shapely import affinity

    turned = affinity.rotate(section.outline, -angle, origin=section.centroid, use_radians=True)
    return replace(section_properties(turned), iyz=0.0), angle
