r"""Bricks that are solids of revolution: the profile in a half-plane through the axis, and the core round the axis.

axis |                       A profile off the axis is meshed and turned. One that reaches the axis is cut at the
     |---+                   radius of a core: what is outside is turned, the core is a disc swept along the axis
     |   :  \                 between the two surfaces that close it, its layers those of the cut. No element has an
     |   :   \                edge on the axis, so none degenerates.
     |core    |
     |---+----+              The core ends in planes across the axis or in spheres about it; a tip is refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.idealise.brick import OwnSection
from kernel.idealise.carriers import Circle, Line
from kernel.idealise.cells import cells_of, curves_of_cells
from kernel.idealise.imprints import Candidate, imprint, lay_outlines
from kernel.idealise.outlines import Stretch, domain, polyline
from kernel.idealise.roundness import roundness
from kernel.idealise.sheets import PlaneSheet, plane_sheet_at
from kernel.idealise.topology import Topology
from kernel.idealise.walls import SEAM_ANGLE, Wall, section_outline
from kernel.segment.segments import Segment
from kernel.solid.solid import Solid
from kernel.solid.surfaces import (
    Axis,
    ConeSurface,
    CylinderSurface,
    Plane,
    SphereSurface,
    Surface,
    TorusSurface,
    cross,
    plane_frame,
)
from kernel.units import ANGLE_TOLERANCE

Array = NDArray[np.float64]

CORE_SHARE = 0.5
"""Radius of the core over that of the profile's innermost corner: room for the quads on both sides of the cut."""

LEAST_CORE = 0.1
"""A core of less than this share of the largest radius would have elements of another scale than the rest."""


@dataclass(frozen=True, slots=True, eq=False)
class CoreEnd:
    """What closes the core: at `height` along the axis, bulging by the sphere's `radius` (None: plane).

    sign: +1 where the sphere's surface is above its centre, at `height`.
    """

    height: float
    radius: float | None = None
    sign: int = 1

    def at(self, distance: Array) -> Array:
        """Heights (n,) at distances (n,) from the axis."""
        if self.radius is None:
            return np.full(len(distance), self.height)
        return self.height + self.sign * np.sqrt(self.radius**2 - distance**2)


@dataclass(frozen=True, slots=True, eq=False)
class RevolvedBrick:
    """A solid of revolution. sheet: the half-plane of the profile, u pointing away from the axis, v along it.

    section: the profile outside the core. core_radius: 0 without a core; ends: of the core, the lower first.
    """

    segment: Segment
    axis: Axis
    sheet: PlaneSheet
    section: OwnSection
    largest: float
    core_radius: float = 0.0
    ends: tuple[CoreEnd, ...] = ()

    @property
    def offset(self) -> float:
        """The sheet's first coordinate on the axis."""
        return float(self.axis.point @ self.sheet.u)


def revolved_brick(
    segment: Segment, tolerance: float, reach: float, frame: Array | None = None
) -> RevolvedBrick | None:
    """The segment as a solid of revolution, None where it is none or its core has a tip, a void, or no room.

    tolerance, reach, frame: of the model's topology.
    """
    solid = segment.solid
    axis = revolution_axis(solid, tolerance)
    if axis is None or _has_tip(solid, tolerance):
        return None
    u = np.cos(SEAM_ANGLE) * axis.x + np.sin(SEAM_ANGLE) * axis.y  # off the facets' edges
    normal = cross(u, axis.direction)
    sheet = plane_sheet_at(normal, float(normal @ axis.point), u, axis.direction, solid.surfaces)
    topology = Topology(tolerance, reach, frame)
    rings = section_outline(topology, solid, sheet)
    if not rings:
        return None
    region = domain(topology, sheet, rings)
    face = Wall(0, segment, sheet, 0.0, [], region, [], region)
    face.outline = [stretch for ring in rings for stretch in ring]
    lay_outlines(topology, [face])
    zero = float(axis.point @ u)
    largest = float(region.bounds[2]) - zero
    core = 0.0
    ends: tuple[CoreEnd, ...] = ()
    if _reaches(region, zero, tolerance):
        core = CORE_SHARE * _innermost(topology, face.outline, sheet, zero)
        found = _ends(topology, face.outline, sheet, axis, core)
        if found is None or core < LEAST_CORE * largest:
            return None
        ends = found
        imprint(topology, [Candidate(face, _cut_line(topology, sheet, axis, region, core))])
    curves = topology.curves()
    cells = [cell for cell in cells_of(topology, sheet, curves) if _is_outside(cell.inner_point, region, zero + core)]
    if not cells:
        return None
    shares = roundness(topology, sheet, rings, region.area)
    section = OwnSection(topology, curves_of_cells(curves, cells), cells, shares)
    return RevolvedBrick(segment, axis, sheet, section, largest, core, ends)


def revolution_axis(solid: Solid, tolerance: float) -> Axis | None:
    """The axis about which every surface of the solid turns into itself, None where there is none."""
    facets = solid.facets
    areas = np.bincount(facets.surface, facets.areas)
    surfaces = [solid.surfaces.surfaces[k] for k in np.flatnonzero(areas > 0.0)]
    axis = next((s.axis for s in surfaces if isinstance(s, CylinderSurface | ConeSurface | TorusSurface)), None)
    if axis is None:
        axis = _axis_of_spheres(surfaces)
    if axis is None or not all(_turns_into_itself(surface, axis, tolerance) for surface in surfaces):
        return None
    return axis


def _has_tip(solid: Solid, tolerance: float) -> bool:
    """Whether the apex of a cone is a point of the boundary."""
    points = solid.facets.vertices
    return any(
        isinstance(surface, ConeSurface) and float(np.linalg.norm(points - surface.apex, axis=1).min()) < 8 * tolerance
        for surface in (solid.surfaces.surfaces[k] for k in np.unique(solid.facets.surface))
    )


def _axis_of_spheres(surfaces: Sequence[Surface]) -> Axis | None:
    """An axis through the spheres' centres: along the planes' normal, from centre to centre, or upright."""
    centres = [surface.centre for surface in surfaces if isinstance(surface, SphereSurface)]
    if not centres:
        return None
    apart = centres[-1] - centres[0]
    direction = next((surface.normal for surface in surfaces if isinstance(surface, Plane)), None)
    if direction is None:
        direction = apart / np.linalg.norm(apart) if np.linalg.norm(apart) > 0.0 else np.array([0.0, 0.0, 1.0])
    frame = plane_frame(direction)
    return Axis(centres[0], frame.normal, frame.u, frame.v)


def _turns_into_itself(surface: Surface, axis: Axis, tolerance: float) -> bool:
    if isinstance(surface, Plane):
        return bool(np.linalg.norm(np.cross(surface.normal, axis.direction)) < 4 * ANGLE_TOLERANCE)
    if isinstance(surface, SphereSurface):
        return bool(np.linalg.norm(np.cross(surface.centre - axis.point, axis.direction)) < tolerance)
    if isinstance(surface, CylinderSurface | ConeSurface | TorusSurface):
        apart = np.cross(surface.axis.point - axis.point, axis.direction)
        across = np.cross(surface.axis.direction, axis.direction)
        return bool(np.linalg.norm(apart) < tolerance and np.linalg.norm(across) < 4 * ANGLE_TOLERANCE)
    return False


def _reaches(region: shapely.Geometry, zero: float, tolerance: float) -> bool:
    """Whether the profile reaches the axis."""
    low, high = region.bounds[1], region.bounds[3]
    return bool(region.intersection(shapely.box(zero - tolerance, low, zero + tolerance, high)).area > 0.0)


def _innermost(topology: Topology, outline: Sequence[Stretch], sheet: PlaneSheet, zero: float) -> float:
    """Least distance from the axis of a corner of the profile, or of the places where arcs turn back."""
    found = []
    for stretch in outline:
        away = np.abs(sheet.flat(polyline(topology, stretch))[:, 0] - zero)
        ends = away[[0, -1]]
        found += ends[ends > 8 * topology.tolerance].tolist()
        if isinstance(topology.carrier(stretch.carrier), Circle):
            found.append(float(away.max()))
    return min(found)


def _ends(
    topology: Topology, outline: Sequence[Stretch], sheet: PlaneSheet, axis: Axis, core: float
) -> tuple[CoreEnd, ...] | None:
    """The two surfaces that close the core, None where there are more, or others than planes and spheres."""
    zero = float(axis.point @ sheet.u)
    found: list[CoreEnd] = []
    for stretch in outline:
        carrier = topology.carrier(stretch.carrier)
        flat = sheet.flat(polyline(topology, stretch))
        near = flat[np.abs(flat[:, 0] - zero) < core * (1 - 1e-9)]
        crosses = flat[:, 0].min() < zero < flat[:, 0].max()
        if not crosses and not len(near):
            continue
        if not crosses:
            return None
        if isinstance(carrier, Line) and abs(carrier.direction @ axis.direction) < 4 * ANGLE_TOLERANCE:
            found.append(CoreEnd(float(flat[:, 1].mean())))
        elif isinstance(carrier, Circle):
            height = float(carrier.centre @ axis.direction)
            if abs(carrier.centre @ sheet.u - zero) > topology.tolerance:
                return None
            sides = {int(np.sign(z - height)) for z in near[:, 1]} - {0}
            found += [CoreEnd(height, carrier.radius, side) for side in sorted(sides)]
        else:
            return None
    if len(found) != 2:
        return None
    low, high = sorted(found, key=lambda end: float(end.at(np.zeros(1))[0]))
    return low, high


def _cut_line(topology: Topology, sheet: PlaneSheet, axis: Axis, region: shapely.Geometry, core: float) -> Stretch:
    """The line at the core's radius, beyond the profile at both ends."""
    margin = 0.1 * (region.bounds[3] - region.bounds[1])
    x = float(axis.point @ sheet.u) + core
    first, last = sheet.lift(np.array([[x, region.bounds[1] - margin], [x, region.bounds[3] + margin]]))
    number = topology.carriers.line(first, last - first)
    start, end = topology.carrier(number).parameters(np.array([first, last])).tolist()
    if start > end:
        first, last, start, end = last, first, end, start
    return Stretch(number, start, end, True, first, last)


def _is_outside(point: tuple[float, float], region: shapely.Geometry, least: float) -> bool:
    return bool(point[0] > least and shapely.contains_xy(region, *point))
