"""Walls: plates and cylinder-plates as they are joined; the crossings of their mid-surfaces."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from kernel.connect.joints import Joint
from kernel.errors import ConnectError, MeshError
from kernel.idealise.carriers import Carrier, Line, Traced
from kernel.idealise.implicit import project
from kernel.idealise.intersections import intersection
from kernel.idealise.outlines import PolygonLike, Stretch, domain, trace_ring, unwrapped
from kernel.idealise.rings import middle_angle, sheet_rings
from kernel.idealise.sheets import PlaneSheet, Sheet, cylinder_sheet, plane_sheet
from kernel.idealise.topology import Topology
from kernel.segment.segments import CylinderShape, PlateShape, Segment
from kernel.solid.solid import Solid
from kernel.solid.surfaces import CylinderSurface, Plane, Surface, signed_distance

Array = NDArray[np.float64]
Interval = tuple[float, float]

CROSSING_SINE = 0.17
"""Mid-surfaces that meet at less than 10 degrees do not join in a curve: they lap."""

SEAM_ANGLE = 0.7390851
"""Where closed cylinders are cut open, in radians from their x axis: at no angle that a model would use."""

CURVED_OVERLAP = 0.02
"""Share of the thinner wall by which strips beside curved joints overlap the walls: more than chords deviate."""

NEARLY_INSIDE = 0.2
"""A joint curve that ends this share of a third wall's thickness before that wall goes on through it."""


@dataclass(slots=True, eq=False)
class Wall:
    """A plate or cylinder-plate. index: its face in the topology; own: its own mid-section, in the sheet's frame.

    known: carriers that its outline may lie on. region, outline: what is meshed, set once the walls are joined.
    """

    index: int
    segment: Segment
    sheet: Sheet
    thickness: float
    rings: list[list[Stretch]]
    own: PolygonLike
    known: list[int]
    region: PolygonLike = field(default_factory=Polygon)
    outline: list[Stretch] = field(default_factory=list)


@dataclass(slots=True, eq=False)
class Crossing:
    """The curve `carrier` in which the mid-surfaces of two walls meet, and where each wall's material reaches it.

    gap: by wall, how far its mid-surface may end before the other's face: a wall that stands askew and is cut square
    touches with one corner only.
    """

    walls: tuple[Wall, Wall]
    carrier: int
    reach: dict[int, list[Interval]]
    gap: dict[int, float] = field(default_factory=dict)

    def other(self, wall: Wall) -> Wall:
        """The wall on the far side."""
        return self.walls[1] if wall is self.walls[0] else self.walls[0]


def make_wall(topology: Topology, index: int, segment: Segment) -> Wall:
    """The wall of a plate or cylinder-plate segment, with its own mid-section."""
    shape, table = segment.shape, segment.solid.surfaces
    sheet: Sheet
    if isinstance(shape, PlateShape):
        sheet = plane_sheet(shape, table)
        thickness = shape.thickness
    else:
        assert isinstance(shape, CylinderShape)
        sheet = cylinder_sheet(shape, table, SEAM_ANGLE, is_closed=True)
        if not any(_winds(sheet, ring.points) for ring in sheet_rings(segment.solid, sheet)):
            sheet = cylinder_sheet(shape, table, middle_angle(segment.solid, shape), is_closed=False)
        thickness = shape.thickness
    rings = section_outline(topology, segment.solid, sheet)
    if not rings:
        raise MeshError(f"{segment.id} ({segment.node}): its mid-surface does not meet its own solid")
    wall = Wall(
        index=index,
        segment=segment,
        sheet=sheet,
        thickness=thickness,
        rings=rings,
        own=domain(topology, sheet, rings),
        known=sorted({stretch.carrier for ring in rings for stretch in ring}),
    )
    wall.region = wall.own
    wall.outline = [stretch for ring in rings for stretch in ring]
    return wall


def section_outline(topology: Topology, solid: Solid, sheet: Sheet, onto: Sheet | None = None) -> list[list[Stretch]]:
    """The rings in which a solid meets a sheet, on carriers; rings that enclose nothing are left out.

    onto: another sheet on which they are laid, for a solid that has the same section there.
    """
    rings = []
    for ring in sheet_rings(solid, sheet):
        if _encloses(sheet, ring.points, topology.tolerance):
            points = ring.points if onto is None else project(ring.points, (onto.surface,))
            stretches = trace_ring(topology, solid.surfaces, onto or sheet, points, ring.labels)
            if stretches:
                rings.append(stretches)
    return rings


def _encloses(sheet: Sheet, points: Array, tolerance: float) -> bool:
    """Whether the ring winds round a closed sheet, or is wider than a sliver."""
    if _winds(sheet, points):
        return True
    flat = unwrapped(sheet, np.vstack([points, points[:1]]))
    x, y = flat[:, 0], flat[:, 1]
    area = 0.5 * abs(float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])))
    length = float(np.linalg.norm(np.diff(flat, axis=0), axis=1).sum())
    return len(points) > 2 and area > tolerance * length


def corner_material(segments: Sequence[Segment], joints: Sequence[Joint], walls: dict[str, Wall]) -> tuple[str, ...]:
    """Ids of the segments that lie within the slabs of two walls that they touch and that stand across one another.

    Such a piece is what two walls have in common beyond their faces (the mitre of a sharp corner), already counted by
    their mid-surfaces.
    """
    touched: dict[str, list[Wall]] = {}
    for joint in joints:
        for name, other in (joint.segments, joint.segments[::-1]):
            if name not in walls and other in walls and walls[other] not in touched.setdefault(name, []):
                touched[name].append(walls[other])
    found = []
    for segment in segments:
        points = segment.solid.facets.vertices
        slack = 10 * segment.solid.surfaces.tolerance
        around = [
            wall
            for wall in touched.get(segment.id, [])
            if np.abs(signed_distance(wall.sheet.surface, points)).max() <= 0.5 * wall.thickness + slack
        ]
        normals = [wall.sheet.normals(points[:1])[0] for wall in around]
        if any(np.linalg.norm(np.cross(a, b)) > CROSSING_SINE for a in normals for b in normals):
            found.append(segment.id)
    return tuple(found)


def _winds(sheet: Sheet, points: Array) -> bool:
    """Whether a ring goes round a closed sheet."""
    if sheet.turn is None:
        return False
    flat = unwrapped(sheet, np.vstack([points, points[:1]]))
    return bool(abs(flat[-1, 0] - flat[0, 0]) > 0.5 * sheet.turn)


# ---------------------------------------------------------------- crossings


def find_crossings(topology: Topology, walls: Sequence[Wall], joints: Sequence[Joint]) -> list[Crossing]:
    """Every curve in which the mid-surfaces of two joined walls meet at an angle."""
    by_id = {wall.segment.id: wall for wall in walls}
    touching: dict[str, set[str]] = {}
    for joint in joints:
        for one, two in (joint.segments, joint.segments[::-1]):
            if one in by_id and two in by_id:
                touching.setdefault(one, set()).add(two)
    found: dict[tuple[int, int, int], Crossing] = {}
    for joint in joints:
        if not all(name in by_id for name in joint.segments):
            continue
        pair = (by_id[joint.segments[0]], by_id[joint.segments[1]])
        for number in _joint_carriers(topology, pair, joint):
            key = (pair[0].index, pair[1].index, number)
            if key not in found:
                found[key] = Crossing(pair, number, {})
                for wall in pair:
                    wall.known.append(number)
    for crossing in found.values():
        _refuse_tangents(topology, crossing)
        for wall in crossing.walls:
            crossing.reach[wall.index] = _reach(topology, crossing, wall)
    reached = {
        (crossing.carrier, wall.sheet.surface_id)
        for crossing in found.values()
        for wall in crossing.walls
        if crossing.reach[wall.index]
    }
    for crossing in found.values():
        a, b = crossing.walls
        near = sorted((touching[a.segment.id] | touching[b.segment.id]) - {a.segment.id, b.segment.id})
        for wall in crossing.walls:
            # Where a coplanar neighbour reaches the curve, this wall is the part beyond it, not one cut askew.
            if not crossing.reach[wall.index] and (crossing.carrier, wall.sheet.surface_id) not in reached:
                crossing.gap[wall.index] = _askew_gap(topology, crossing, wall)
                crossing.reach[wall.index] = _reach(topology, crossing, wall)
            intervals = crossing.reach[wall.index]
            for third in near:
                intervals = [_lengthened(topology, crossing.carrier, ends, by_id[third]) for ends in intervals]
            crossing.reach[wall.index] = merged(
                intervals, 10 * topology.tolerance, topology.carrier(crossing.carrier).period
            )
    return [found[key] for key in sorted(found)]


def _joint_carriers(topology: Topology, pair: tuple[Wall, Wall], joint: Joint) -> list[int]:
    """The carriers of the curves in which two mid-surfaces meet next to the joint's patch."""
    a, b = pair
    surfaces = a.segment.solid.surfaces.surfaces
    met = (a.sheet.surface, b.sheet.surface)
    if a.sheet.surface_id == b.sheet.surface_id:
        return []
    seeds = patch_points(surfaces[joint.surface], joint.patch)
    points = project(seeds, met)
    near = np.linalg.norm(points - seeds, axis=1) <= 3 * (a.thickness + b.thickness)
    on_both = np.max([np.abs(signed_distance(surface, points)) for surface in met], axis=0) <= topology.tolerance
    sine = np.linalg.norm(np.cross(a.sheet.normals(points), b.sheet.normals(points)), axis=1)
    numbers: list[int] = []
    for point in points[near & on_both & (sine > CROSSING_SINE)]:
        if any(_lies_on(topology, number, point) for number in numbers):
            continue
        numbers.append(intersection(topology.carriers, surfaces, a.sheet.surface_id, b.sheet.surface_id, point[None]))
    return numbers


def _lies_on(topology: Topology, number: int, point: Array) -> bool:
    carrier = topology.carrier(number)
    foot = carrier.at(carrier.parameters(point[None]))[0]
    return bool(np.linalg.norm(foot - point) <= 4 * topology.tolerance)


def patch_points(surface: Surface, patch: PolygonLike) -> Array:
    """Points (n, 3) of a joint's patch: some of its outline, and one within each part."""
    flat = []
    for part in shapely.get_parts(patch):
        outline = np.asarray(part.exterior.coords)
        flat.append(outline[:: max(1, len(outline) // 16), :2])
        inner = part.representative_point()
        flat.append(np.array([[inner.x, inner.y]]))
    points = np.vstack(flat)
    if isinstance(surface, Plane):
        return points[:, :1] * surface.u + points[:, 1:] * surface.v + surface.offset * surface.normal
    assert isinstance(surface, CylinderSurface)
    axis, angle = surface.axis, points[:, :1] / surface.radius
    return (
        axis.point + surface.radius * (np.cos(angle) * axis.x + np.sin(angle) * axis.y) + points[:, 1:] * axis.direction
    )


def offset_surface(surface: Surface, distance: float) -> Surface:
    """The plane or cylinder parallel to one, `distance` further along its normals."""
    if isinstance(surface, Plane):
        return Plane(surface.normal, surface.offset + distance, surface.u, surface.v)
    assert isinstance(surface, CylinderSurface)
    return CylinderSurface(surface.axis, surface.axis_id, surface.radius + distance)


def slab_edges(wall: Wall, other: Wall, points: Array, margin: float) -> tuple[Array, Array]:
    """Where `wall`'s sheet leaves the slab of `other`, on its two sides, for points (n, 3) of the joint curve.

    margin: by how much the slab is taken thicker on each side.
    """
    across = np.cross(wall.sheet.normals(points), np.cross(wall.sheet.normals(points), other.sheet.normals(points)))
    sine = np.linalg.norm(across, axis=1)[:, None]
    half = 0.5 * other.thickness + margin
    sides = []
    for sign in (1.0, -1.0):
        guess = points - sign * across / sine * (half / sine)
        sides.append(project(guess, (wall.sheet.surface, offset_surface(other.sheet.surface, sign * half))))
    return sides[0], sides[1]


def samples(topology: Topology, carrier: Carrier, start: float, end: float) -> Array:
    """Points (n, 3) along a carrier from start to end, dense enough to show its curve."""
    return carrier.at(np.concatenate([[start], carrier.breaks(start, end), [end]]))


def whole_range(topology: Topology, carrier: Carrier, near: Array) -> Interval:
    """All of a carrier, or of a line what the model's size can hold about the points `near`."""
    if carrier.period is not None:
        return 0.0, carrier.period
    if isinstance(carrier, Traced):
        return 0.0, float(carrier.lengths[-1])
    values = carrier.parameters(near)
    return float(values.min()) - topology.carriers.reach, float(values.max()) + topology.carriers.reach


def windowed(sheet: Sheet, geometry: shapely.Geometry) -> shapely.Geometry:
    """Geometry in unwrapped coordinates brought within one turn of a cylinder; as it is on planes."""
    if isinstance(sheet, PlaneSheet) or geometry.is_empty:
        return geometry
    low, high = geometry.bounds[1], geometry.bounds[3]
    window = shapely.box(sheet.seam, low - 1 - abs(low), sheet.seam + sheet.turn, high + 1 + abs(high))
    copies = [shapely.transform(geometry, lambda at, k=k: at + (k * sheet.turn, 0.0)) for k in (-2, -1, 0, 1, 2)]
    return shapely.union_all([copy.intersection(window) for copy in copies])


def _reach(topology: Topology, crossing: Crossing, wall: Wall) -> list[Interval]:
    """Where the wall's own section touches either side of the other's slab, as stretches of the joint curve."""
    carrier = topology.carrier(crossing.carrier)
    other = crossing.other(wall)
    straight = isinstance(carrier, Line)
    margin = 0.3 * topology.tolerance if straight else CURVED_OVERLAP * min(wall.thickness, other.thickness)
    low, high = whole_range(topology, carrier, other.segment.solid.bounds)
    curve = samples(topology, carrier, low, high)
    margin += crossing.gap.get(wall.index, 0.0)
    intervals: list[Interval] = []
    for edge in slab_edges(wall, other, curve, margin):
        line = windowed(wall.sheet, shapely.LineString(unwrapped(wall.sheet, edge)))
        for piece in shapely.get_parts(shapely.line_merge(line.intersection(wall.own))):
            if piece.geom_type != "LineString" or piece.length <= topology.tolerance:
                continue
            values = carrier.parameters(wall.sheet.lift(np.asarray(piece.coords)))
            intervals.append(_unrolled_range(values, carrier.period))
    return merged(intervals, 10 * topology.tolerance, carrier.period)


def _askew_gap(topology: Topology, crossing: Crossing, wall: Wall) -> float:
    """How far the mid-surface of a wall cut square ends before the face of one that it meets askew."""
    carrier = topology.carrier(crossing.carrier)
    other = crossing.other(wall)
    low, high = whole_range(topology, carrier, other.segment.solid.bounds)
    point = carrier.at(np.array([0.5 * (low + high)]))
    cosine = float(abs(wall.sheet.normals(point)[0] @ other.sheet.normals(point)[0]))
    return 0.5 * wall.thickness * cosine / float(np.sqrt(1 - cosine * cosine)) + topology.tolerance


def _refuse_tangents(topology: Topology, crossing: Crossing) -> None:
    """ConnectError where two mid-surfaces touch somewhere on the curve in which they meet."""
    carrier = topology.carrier(crossing.carrier)
    if isinstance(carrier, Line):
        return
    a, b = crossing.walls
    points = samples(topology, carrier, *whole_range(topology, carrier, a.segment.solid.bounds))
    sine = np.linalg.norm(np.cross(a.sheet.normals(points), b.sheet.normals(points)), axis=1)
    worst = int(np.argmin(sine))
    if sine[worst] < CROSSING_SINE:
        x, y, z = points[worst]
        raise ConnectError(
            f"the mid-surfaces of {a.segment.id} and {b.segment.id} meet at no angle near ({x:.6g}, {y:.6g}, {z:.6g}) "
            "(walls of nearly equal radius), expected 10 degrees or more: one of them may be made a brick"
        )


def _unrolled_range(values: Array, period: float | None) -> Interval:
    """Smallest range that holds parameters which run along a curve, over the seam of a closed one where they do."""
    if period is None:
        return float(values.min()), float(values.max())
    steps = np.diff(values)
    steps -= period * np.round(steps / period)
    run = values[0] + np.concatenate([[0.0], np.cumsum(steps)])
    low, high = float(run.min()), float(run.max())
    shift = period * np.floor(low / period)
    return low - shift, high - shift


def merged(intervals: Sequence[Interval], slack: float, period: float | None = None) -> list[Interval]:
    """Intervals joined where they overlap or come nearer than `slack`; on a closed curve all of it is (0, period)."""
    result: list[list[float]] = []
    for start, end in sorted(intervals):
        if result and start <= result[-1][1] + slack:
            result[-1][1] = max(result[-1][1], end)
        else:
            result.append([start, end])
    if period is not None and result:
        while len(result) > 1 and result[-1][1] - period >= result[0][0] - slack:
            first = result.pop(0)
            result[-1][1] = max(result[-1][1], first[1] + period)
        if result[0][1] - result[0][0] >= period - slack:
            return [(0.0, period)]
    return [(start, end) for start, end in result]


def _lengthened(topology: Topology, number: int, ends: Interval, third: Wall) -> Interval:
    """The interval, carried on through the slab of a third wall where it ends within that."""
    carrier = topology.carrier(number)
    if carrier.period is not None and ends[1] - ends[0] >= carrier.period - topology.tolerance:
        return ends
    half = 0.5 * third.thickness
    step = NEARLY_INSIDE * third.thickness

    def outside(value: float) -> float:
        point = carrier.at(np.array([value]))
        return float(abs(signed_distance(third.sheet.surface, point)[0])) - half

    result = []
    for end, sign in zip(ends, (-1.0, 1.0)):
        if outside(end) >= -topology.tolerance and outside(end + sign * step) >= 0:
            result.append(end)
            continue
        inner = end
        for _ in range(100):
            if outside(inner + sign * step) > 0:
                break
            inner += sign * step
        else:
            result.append(end)  # the curve runs within the third wall: it ends where the walls do
            continue
        low, high = (inner, inner + sign * step) if outside(inner) <= 0 else (inner, inner)
        for _ in range(80):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if outside(middle) <= 0 else (low, middle)
        result.append(low)
    return result[0], result[1]
