"""Is a solid swept, along what, with which section: the facts behind beams, and the sweep of bricks.

A solid is exactly prismatic along d where every triangle is parallel to d, or a cap at one of its two ends.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from kernel.segment.slices import outline_points, parts_of, slice_loops, slice_polygon, smallest_rectangle
from kernel.solid.surfaces import ConeSurface, CylinderSurface, Plane, TorusSurface, plane_frame
from kernel.units import ANGLE_TOLERANCE, MODEL_TOLERANCE

if TYPE_CHECKING:
    from kernel.solid.solid import Solid

Vector = NDArray[np.float64]

SECTION_COUNT = 9
"""Sections taken along a solid that is not exactly prismatic."""

SECTION_OFF = 0.02
"""A section that differs from the median one by more than this share of its area is off."""

PARALLEL = 1e-6
"""A unit normal with a smaller component along d is perpendicular to d (sliver triangles are noisier than planes)."""

CAP_SHARE = 1e-9
"""Area that may be neither parallel to d nor at an end: rounding of the facets."""

LARGEST_PLANES = 6
"""Planes whose lines of intersection are tried as directions."""


@dataclass(frozen=True, slots=True, eq=False)
class Sweep:
    """A direction along which a solid might be swept, from start to end (offsets along it)."""

    direction: Vector
    start: float
    end: float
    is_exact: bool
    slenderness: float
    """length / the larger extent across, an estimate from the facets alone."""

    @property
    def length(self) -> float:
        """Extent along the direction."""
        return self.end - self.start

    def moved(self, shift: Vector) -> Sweep:
        """The same sweep of the solid moved by `shift` (3,)."""
        along = float(self.direction @ shift)
        return replace(self, start=self.start + along, end=self.end + along)


@dataclass(frozen=True, slots=True, eq=False)
class Prism:
    """A solid measured along one sweep. section: the median section, in coordinates (x.u, x.v); u x v = direction.

    deviations: share of the median's area by which each of the sections differs from it.
    """

    sweep: Sweep
    u: Vector
    v: Vector
    section: Polygon | MultiPolygon
    section_offset: float
    long_side: float
    short_side: float
    volume_deviation: float
    deviations: tuple[float, ...]

    def moved(self, shift: Vector) -> Prism:
        """The same prism moved by `shift` (3,)."""
        across = np.array([self.u @ shift, self.v @ shift])
        return replace(
            self,
            sweep=self.sweep.moved(shift),
            section=shapely.transform(self.section, lambda points: points + across),
            section_offset=self.section_offset + float(self.sweep.direction @ shift),
        )

    @property
    def area(self) -> float:
        """Of the median section."""
        return float(self.section.area)

    @property
    def slenderness(self) -> float:
        """Length / longer side of the section."""
        return self.sweep.length / self.long_side

    @property
    def sections_off(self) -> int:
        """How many sections differ from the median by more than SECTION_OFF."""
        return sum(deviation > SECTION_OFF for deviation in self.deviations)

    @property
    def worst_section_off(self) -> float:
        """Largest deviation."""
        return max(self.deviations)


def canonical_direction(direction: Vector) -> Vector:
    """The unit vector or its opposite: first component that is not 0 is positive."""
    direction = np.where(np.abs(direction) < MODEL_TOLERANCE, 0.0, direction)
    direction = direction / np.linalg.norm(direction)
    return -direction if direction[np.nonzero(direction)[0][0]] < 0 else direction


def plane_directions(solid: Solid) -> list[Vector]:
    """Canonical unit normals of the solid's planes, those that hold most area first."""
    facets = solid.facets
    held: dict[tuple[float, ...], tuple[float, Vector]] = {}
    areas = np.bincount(facets.surface, weights=facets.areas)
    for index in np.unique(facets.surface):
        plane = solid.surfaces.surfaces[index]
        if isinstance(plane, Plane):
            key = tuple(plane.normal)
            held[key] = (held.get(key, (0.0,))[0] + float(areas[index]), plane.normal)
    total = float(facets.areas.sum())
    order = sorted(held, key=lambda key: (-round(held[key][0] / total, 9), key))
    return [held[key][1] for key in order]


def sweeps(solid: Solid) -> tuple[Sweep, ...]:
    """Directions worth trying, most slender first: axes of revolution, plane normals, and lines where planes meet."""
    normals = plane_directions(solid)
    candidates = [surface.axis.direction for surface in _revolved(solid)]
    candidates += normals[: 2 * LARGEST_PLANES]
    largest = normals[:LARGEST_PLANES]
    for i in range(len(largest)):
        for j in range(i):
            cross = np.cross(largest[i], largest[j])
            norm = float(np.linalg.norm(cross))
            if norm > 1e-3:
                candidates.append(cross / norm)
    if not candidates:
        candidates = list(np.eye(3))
    distinct: list[Vector] = []
    for candidate in map(canonical_direction, candidates):
        if not any(abs(candidate @ other) > 1.0 - ANGLE_TOLERANCE**1.5 for other in distinct):
            distinct.append(candidate)
    found = [sweep_along(solid, direction) for direction in distinct]
    return tuple(
        sorted(found, key=lambda s: (-round(s.slenderness, 6), not s.is_exact, -round(s.length, 9), *(-s.direction)))
    )


def _revolved(solid: Solid) -> list[CylinderSurface | ConeSurface | TorusSurface]:
    surfaces = (solid.surfaces.surfaces[index] for index in np.unique(solid.facets.surface))
    return [surface for surface in surfaces if isinstance(surface, CylinderSurface | ConeSurface | TorusSurface)]


def sweep_along(solid: Solid, direction: Vector) -> Sweep:
    """The solid as a sweep along one direction, exact or not."""
    facets = solid.facets
    points = outline_points(solid)
    along = points @ direction
    start, end = float(along.min()), float(along.max())
    tilt = np.abs(facets.normals @ direction)
    at = facets.centroids @ direction
    near = MODEL_TOLERANCE * max(end - start, 1e-300)
    at_end = (np.abs(at - start) < near) | (np.abs(at - end) < near)
    fits = (tilt < PARALLEL) | ((tilt > 1.0 - PARALLEL) & at_end)
    is_exact = float(facets.areas[~fits].sum()) <= CAP_SHARE * float(facets.areas.sum())
    u, v, _ = plane_frame(direction)
    outline = shapely.multipoints(points @ np.stack([u, v], axis=1))
    across, _ = smallest_rectangle(outline)
    return Sweep(direction, start, end, is_exact, (end - start) / max(across, 1e-300))


def measure(solid: Solid, sweep: Sweep) -> Prism | None:
    """The solid measured along `sweep`; None where no section has an area or a width, or most are in several pieces.

    The latter is no member but several side by side that meet at an end: a post of angle that a panel cuts through.
    """
    u, v, _ = plane_frame(sweep.direction)
    shares = [0.5] if sweep.is_exact else [(k + 0.5) / SECTION_COUNT for k in range(SECTION_COUNT)]
    offsets = [sweep.start + share * sweep.length for share in shares]
    sections = [slice_polygon(solid.facets, sweep.direction, offset, u, v) for offset in offsets]
    areas = np.array([section.area for section in sections])
    order = np.argsort(areas, kind="stable")
    middle = int(order[len(order) // 2])
    median, area = sections[middle], float(areas[middle])
    if area <= 0.0 or (not sweep.is_exact and len(parts_of(median)) > 1):
        return None
    deviations = tuple(float(section.symmetric_difference(median).area) / area for section in sections)
    long_side, short_side = smallest_rectangle(median)
    if short_side <= 0.0:
        return None
    return Prism(
        sweep=sweep,
        u=u,
        v=v,
        section=median,
        section_offset=offsets[middle],
        long_side=long_side,
        short_side=short_side,
        volume_deviation=0.0 if sweep.is_exact else abs(solid.volume / (area * sweep.length) - 1.0),
        deviations=deviations,
    )


def best_prism(solid: Solid, found: tuple[Sweep, ...]) -> Prism | None:
    """The solid measured along its most slender direction that is exactly, or else roughly, a sweep.

    Exact directions come before inexact ones of the same slenderness; an inexact direction is passed over where
    more than half of its sections are off and an exact one is left (the diagonal of an L is no axis).
    """
    passed_over: list[Sweep] = []
    for sweep in found:
        if not sweep.is_exact and _is_uneven(solid, sweep):
            passed_over.append(sweep)
            continue
        prism = measure(solid, sweep)
        if prism is not None and (sweep.is_exact or prism.sections_off <= SECTION_COUNT // 2):
            return prism
        passed_over.append(sweep)
    return next((prism for sweep in passed_over if (prism := measure(solid, sweep)) is not None), None)


def _is_uneven(solid: Solid, sweep: Sweep) -> bool:
    """Whether the areas alone show that more than half of the sections are off: cheaper than their outlines."""
    u, v, _ = plane_frame(sweep.direction)
    offsets = [sweep.start + (k + 0.5) / SECTION_COUNT * sweep.length for k in range(SECTION_COUNT)]
    areas = np.array([slice_loops(solid.facets, sweep.direction, offset, u, v).sum() for offset in offsets])
    median = float(np.median(areas))
    return bool((np.abs(areas - median) > SECTION_OFF * median).sum() > SECTION_COUNT // 2)
