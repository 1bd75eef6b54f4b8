"""Sections with closed forms: rectangle, circle, tube.

Torsion: Timoshenko and Goodier, Theory of Elasticity, section 109 (rectangle, series). Shear coefficients:
Cowper, J. Appl. Mech. 33 (1966) 335-340, at Poisson's ratio 0, where they are also the strain energy's:
5/6 for the rectangle in every direction, 6/7 for the circle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from kernel.idealise.outline import SectionValues


def rectangle(dimensions: Mapping[str, float], exact: SectionValues) -> SectionValues:
    """Of dimensions "width" and "height"; the area and second moments are the outline's own, whatever its tilt."""
    a, b = sorted((dimensions["width"], dimensions["height"]), reverse=True)
    shear_area = 5 / 6 * exact.area
    return exact.with_shear(rectangle_torsion_constant(a, b), shear_area, shear_area)


def rectangle_torsion_constant(a: float, b: float) -> float:
    """J for sides a >= b: a b^3 / 3 (1 - 192 b / (pi^5 a) sum over odd n of tanh(n pi a / 2b) / n^5)."""
    series = sum(math.tanh(n * math.pi * a / (2 * b)) / n**5 for n in range(1, 40, 2))
    return a * b**3 / 3 * (1 - 192 / math.pi**5 * b / a * series)


def circle(dimensions: Mapping[str, float], exact: SectionValues) -> SectionValues:
    """Of "radius": the true circle, not the polygon that stands for it."""
    radius = dimensions["radius"]
    area, second = math.pi * radius**2, math.pi * radius**4 / 4
    shear_area = 6 / 7 * area
    return SectionValues(area, second, second, 0.0, exact.centroid, 2 * second, shear_area, shear_area)


def tube(dimensions: Mapping[str, float], exact: SectionValues) -> SectionValues:
    """Of "radius" (outer) and "inner_radius": true circles."""
    outer, inner = dimensions["radius"], dimensions["inner_radius"]
    area, second = math.pi * (outer**2 - inner**2), math.pi * (outer**4 - inner**4) / 4
    m = (inner / outer) ** 2
    shear_area = area * 6 * (1 + m) ** 2 / (7 * (1 + m) ** 2 + 20 * m)
    return SectionValues(area, second, second, 0.0, exact.centroid, 2 * second, shear_area, shear_area)
