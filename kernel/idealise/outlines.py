"""Outlines: the rings in which a solid meets a sheet, put from their facets onto exact carriers, and back to polygons.

A ring comes as points and, for each edge, the surface that trims it there. Edges of one surface make a stretch of one
carrier; where two stretches meet, their common point is found on the sheet and both surfaces at once.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import MultiPolygon, Polygon

from kernel.idealise.carriers import Carrier, Circle, Line, Traced, distance_to
from kernel.idealise.implicit import project
from kernel.idealise.intersections import intersection
from kernel.idealise.sheets import PlaneSheet, Sheet
from kernel.idealise.topology import Topology
from kernel.idealise.tube_curve import TubeCurve
from kernel.solid.surfaces import Axis, CylinderSurface, FacetedSurface, Plane, Surface, cross
from kernel.solid.table import SurfaceTable
from kernel.units import ANGLE_TOLERANCE

Array = NDArray[np.float64]
SEAM_GRID = 1e-9
"""Outlines that close over the seam are rounded to this share of the model's size, so that their ends meet."""

BEND = 2e-4
"""Curves of tubes meet in a corner that lies within this share of the radius from where they were found to meet."""

LINES_CROSS = 1e-4
"""Least sine at which two lines cross in one point."""

PolygonLike: TypeAlias = Polygon | MultiPolygon


@dataclass(frozen=True, slots=True, eq=False)
class Stretch:
    """Part of a carrier from `first` to `last` (3,), walked in the direction that keeps the region on the left.

    start < end: lengths on the carrier; forward: walked from start to end. whole: all of a closed carrier.
    """

    carrier: int
    start: float
    end: float
    forward: bool
    first: Array
    last: Array
    whole: bool = False


def stretch_between(topology: Topology, number: int, first: Array, last: Array, through: Array) -> Stretch:
    """The stretch of the carrier from `first` to `last` (3,) that runs along the points `through` (n, 3).

    On a closed carrier there must be a point in every third of a turn.
    """
    carrier = topology.carrier(number)
    if isinstance(carrier, Line):
        a, b = carrier.parameters(np.array([first, last])).tolist()
        return Stretch(number, min(a, b), max(a, b), a < b, first, last)
    values = carrier.parameters(np.vstack([first, through, last]))
    a, b = float(values[0]), float(values[-1])
    period = carrier.period
    if period is None:
        return Stretch(number, min(a, b), max(a, b), a < b, first, last)
    steps = np.diff(values)
    total = float((steps - period * np.round(steps / period)).sum())
    if total > 0:
        return Stretch(number, a, a + total, True, first, last)
    return Stretch(number, b, b - total, False, first, last)


def _breaks(labels: NDArray[np.int64], surfaces: list[Surface]) -> list[int]:
    """Indices of the edges with which a new stretch begins."""
    before = np.roll(labels, 1)
    return [
        index
        for index in range(len(labels))
        if labels[index] != before[index] or isinstance(surfaces[labels[index]], FacetedSurface)
    ]


def trace_ring(
    topology: Topology, table: SurfaceTable, sheet: Sheet, points: Array, labels: NDArray[np.int64]
) -> list[Stretch]:
    """The ring through points (n, 3), whose edge k (to point k+1) is trimmed by the surface labels[k].

    The points need only be near the sheet; edges that shrink to nothing on it are left out. Where all of the ring is
    trimmed by one plane that is parallel to the sheet there is none: the sheet is a face of what it cuts.
    """
    surfaces = table.surfaces
    starts = _breaks(labels, surfaces)
    if not starts and _is_parallel(sheet, surfaces[labels[0]]):
        return []
    if not starts:
        return [_whole_ring(topology, surfaces, sheet, points, int(labels[0]))]
    n = len(points)
    corners: list[Array] = []
    guides: list[Array] = []
    for position, begin in enumerate(starts):
        end = starts[(position + 1) % len(starts)]
        count = (end - begin) % n or n
        guides.append(points[(begin + np.arange(count + 1)) % n])
        met = (surfaces[labels[begin - 1]], surfaces[labels[begin]])
        corners.append(_corner(sheet, met, points[begin], _reach(points, begin)))
    ring = []
    for position, begin in enumerate(starts):
        first, last = corners[position], corners[(position + 1) % len(corners)]
        guide = guides[position]
        if len(guide) == 2 and math.dist(first, last) <= topology.tolerance:
            continue
        if _is_parallel(sheet, surfaces[labels[begin]]):
            ring += _brought_straight(topology, first, last)
            continue
        straight = isinstance(sheet, PlaneSheet)
        own = project(guide, (sheet.surface,)) if isinstance(surfaces[labels[begin]], FacetedSurface) else guide
        number = intersection(topology.carriers, surfaces, sheet.surface_id, int(labels[begin]), own, straight=straight)
        ring.append(stretch_between(topology, number, first, last, 0.5 * (guide[:-1] + guide[1:])))
    return ring


def _is_parallel(sheet: Sheet, surface: Surface) -> bool:
    """Whether a face that bounds a ring is a plane parallel to the sheet's: it does not say where on the sheet."""
    if not isinstance(sheet, PlaneSheet) or not isinstance(surface, Plane):
        return False
    return not np.abs(cross(sheet.normal, surface.normal)).max() > ANGLE_TOLERANCE


def _brought_straight(topology: Topology, first: Array, last: Array) -> list[Stretch]:
    """The edge of a contact that ends at a face parallel to the sheet, brought onto it along its normal: a line."""
    if math.dist(first, last) <= topology.tolerance:
        return []
    number = topology.carriers.line(first, last - first)
    return [stretch_between(topology, number, first, last, 0.5 * (first + last)[None])]


def _reach(points: Array, index: int) -> float:
    """Length of the longer of the two edges at a point of the ring."""
    here = points[index]
    return max(math.dist(points[index - 1], here), math.dist(points[(index + 1) % len(points)], here))


def _corner(sheet: Sheet, met: tuple[Surface, Surface], point: Array, reach: float) -> Array:
    """Where the sheet and two trimming surfaces meet, near `point`; the point itself where they do not cross there."""
    crossing = [surface for surface in met if not _is_parallel(sheet, surface)]
    found = project(point[None], (sheet.surface, *crossing))[0]
    if math.dist(found, point) > 2 * reach:
        return project(point[None], (sheet.surface,))[0]
    return found


def _whole_ring(topology: Topology, surfaces: list[Surface], sheet: Sheet, points: Array, label: int) -> Stretch:
    """A ring that is trimmed by one surface all round: all of a closed carrier."""
    number = intersection(topology.carriers, surfaces, sheet.surface_id, label, points)
    carrier = topology.carrier(number)
    values = carrier.parameters(points[:3])
    period = carrier.period
    assert period is not None
    forward = (values[1] - values[0]) % period < (values[0] - values[1]) % period
    first = carrier.at(np.zeros(1))[0]
    return Stretch(number, 0.0, period, bool(forward), first, first, whole=True)


def polyline(topology: Topology, stretch: Stretch) -> Array:
    """Points (n, 3) along the stretch, in its direction, dense enough to show its curve."""
    carrier = topology.carrier(stretch.carrier)
    if isinstance(carrier, Line):
        return np.array([stretch.first, stretch.last])
    values = np.concatenate([[stretch.start], carrier.breaks(stretch.start, stretch.end), [stretch.end]])
    points = carrier.at(values)
    if not stretch.forward:
        points = points[::-1]
    points = points.copy()
    points[0], points[-1] = stretch.first, stretch.last
    if stretch.whole:
        points[0] = points[-1] = carrier.at(np.zeros(1))[0]
    return points


def unwrapped(sheet: Sheet, points: Array) -> Array:
    """The points of a line (n, 3) in the sheet's coordinates, without jumps where it crosses the seam."""
    flat = sheet.flat(points)
    if sheet.turn is not None:
        turns = np.round(np.diff(flat[:, 0]) / sheet.turn)
        flat[1:, 0] -= sheet.turn * np.cumsum(turns)
    return flat


def windowed(sheet: Sheet, geometry: shapely.Geometry) -> shapely.Geometry:
    """Geometry in unwrapped coordinates brought within one turn of a cylinder; as it is on planes."""
    if isinstance(sheet, PlaneSheet) or geometry.is_empty:
        return geometry
    low, high = geometry.bounds[1], geometry.bounds[3]
    window = shapely.box(sheet.seam, low - 1 - abs(low), sheet.seam + sheet.turn, high + 1 + abs(high))
    copies = [shapely.transform(geometry, lambda at, k=k: at + (k * sheet.turn, 0.0)) for k in (-2, -1, 0, 1, 2)]
    return shapely.union_all([copy.intersection(window) for copy in copies])


def ring_points(topology: Topology, sheet: Sheet, ring: list[Stretch]) -> Array:
    """The ring as a closed line (n, 2), last point as the first; one that winds ends a period further on."""
    pieces = [polyline(topology, stretch) for stretch in ring]
    joined = np.vstack([piece[:-1] for piece in pieces] + [pieces[-1][-1:]])
    return unwrapped(sheet, joined)


def domain(topology: Topology, sheet: Sheet, rings: list[list[Stretch]]) -> PolygonLike:
    """What the rings enclose, in the sheet's coordinates; a cylinder's is cut open at its seam."""
    lines = [ring_points(topology, sheet, ring) for ring in rings]
    if isinstance(sheet, PlaneSheet):
        return even_odd([line for line in lines if len(line) > 3])
    turn = sheet.turn
    low = min(float(line[:, 1].min()) for line in lines)
    high = max(float(line[:, 1].max()) for line in lines)
    window = shapely.box(sheet.seam, low - turn, sheet.seam + turn, high + turn)
    copies = [shapely.LineString(line + (k * turn, 0.0)) for line in lines for k in (-2, -1, 0, 1, 2)]
    grid = SEAM_GRID * topology.carriers.reach
    cut = shapely.intersection(shapely.union_all(copies, grid_size=grid), window, grid_size=grid)
    cells = shapely.polygonize(list(shapely.get_parts(shapely.union_all([cut, window.boundary], grid_size=grid))))
    kept = []
    for cell in shapely.get_parts(cells):
        inner = cell.representative_point()
        below = shapely.LineString([(inner.x, low - 2 * turn), (inner.x, inner.y)])
        if sum(not part.is_empty for part in shapely.get_parts(below.intersection(cut))) % 2:
            kept.append(cell)
    return shapely.union_all(kept) if kept else Polygon()


def even_odd(lines: list[Array]) -> PolygonLike:
    """Polygon of closed lines (n, 2) that do not cross: outer rings less their holes, islands in holes included."""
    result: PolygonLike = Polygon()
    for line in lines:
        polygon = Polygon(line)
        if not polygon.is_valid:
            polygon = polygon.buffer(0)
        result = result.symmetric_difference(polygon)
    return result


def transversal(sheet: Sheet, carrier: Carrier) -> tuple[Surface, ...]:
    """A surface that cuts the sheet across in the carrier, which lies on the sheet."""
    if isinstance(carrier, TubeCurve):
        return (carrier.frame.large if sheet.surface is carrier.frame.small else carrier.frame.small,)
    if isinstance(carrier, Traced):
        others = tuple(surface for surface in carrier.surfaces if surface is not sheet.surface)
        return tuple(surface for surface in others if not isinstance(surface, FacetedSurface))
    if isinstance(carrier, Line):
        normal = np.cross(sheet.normals(carrier.point[None])[0], carrier.direction)
        normal = normal / np.linalg.norm(normal)
        return (Plane(normal, float(normal @ carrier.point), carrier.direction, np.cross(normal, carrier.direction)),)
    assert isinstance(carrier, Circle)
    if isinstance(sheet, PlaneSheet):
        axis = Axis(carrier.centre, carrier.normal, carrier.x, carrier.y)
        return (CylinderSurface(axis, -1, carrier.radius),)
    return (Plane(carrier.normal, float(carrier.normal @ carrier.centre), carrier.x, carrier.y),)


def meeting_point(sheet: Sheet, one: Carrier, other: Carrier, near: Array) -> Array:
    """The common point of two carriers of a sheet next to `near` (3,)."""
    if isinstance(one, Line) and isinstance(other, Line):
        across = cross(one.direction, other.direction)
        square = float(across @ across)
        if square > LINES_CROSS**2:
            along = float(cross(other.point - one.point, other.direction) @ across) / square
            return one.point + along * one.direction
    bend = _common_bend(one, other, near)
    if bend is not None:
        return bend
    found = project(near[None], (sheet.surface, *transversal(sheet, one), *transversal(sheet, other)))
    for carrier in (one, other):
        if isinstance(carrier, TubeCurve) and carrier.frame.pinch:
            found = carrier.at(carrier.parameters(found))  # beside the sheet
    return found[0]


def _common_bend(one: Carrier, other: Carrier, near: Array) -> Array | None:
    """The corner of a curve of two tubes, next to `near` (3,), that lies on the other carrier too.

    All surfaces that meet there have one tangent plane: they do not say where on it the corner is.
    """
    for carrier, across in ((one, other), (other, one)):
        if isinstance(carrier, TubeCurve):
            bends = carrier.at(np.array(carrier.bends))
            reach = BEND * carrier.frame.small.radius + 2 * carrier.frame.pinch
            bend = bends[int(np.argmin(np.linalg.norm(bends - near, axis=1)))]
            if np.linalg.norm(bend - near) <= reach and distance_to(across, bend[None])[0] <= reach:
                return bend
    return None
