"""Footprints: what beams, bricks and lapping plates imprint in the walls that they meet."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.errors import ConnectError
from kernel.idealise.beam import Beam
from kernel.idealise.carriers import Circle, Line
from kernel.idealise.implicit import project
from kernel.idealise.imprints import Candidate
from kernel.idealise.outlines import Stretch, stretch_between, trace_ring
from kernel.idealise.parts import Parts
from kernel.idealise.rings import Ring, boundary_rings
from kernel.idealise.sheets import Sheet
from kernel.idealise.tangent_lines import is_tangent
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall, patch_points
from kernel.segment.faces import faces_of
from kernel.segment.segments import Segment
from kernel.solid.surfaces import FacetedSurface, Plane, Surface, outward, signed_distance

Array = NDArray[np.float64]

GRAZING = 1e-2
"""A round foot whose rim is nearer to a straight edge than this share of its radius grazes it."""


@dataclass(frozen=True, slots=True, eq=False)
class Seat:
    """Where a beam lies along a wall: nodes of the wall on this carrier, between the beam's offsets, get beam nodes.

    edge: whether they are on the wall's outline, not on an imprint.
    """

    joint: Joint
    wall: Wall
    carrier: int
    start: float
    end: float
    edge: bool


def is_on_face(wall: Wall, joint: Joint) -> bool:
    """Whether the joint lies on one of the wall's two faces (not on its edge)."""
    own = joint.surface_of(wall.segment.id)
    if own in wall.surface_ids:
        return True
    surface = wall.segment.solid.surfaces.surfaces[own]
    if isinstance(surface, FacetedSurface):
        return False
    points = patch_points(surface, joint.patch_of(wall.segment.id))
    return bool(
        np.abs(np.abs(signed_distance(wall.sheet.surface, points)) - 0.5 * wall.thickness).max()
        <= 1e-6 * wall.segment.solid.surfaces.size
    )


def footprint(topology: Topology, sheet: Sheet, segment: Segment, joint: Joint) -> list[list[Stretch]]:
    """The outline of the segment's face on the joint's surface, carried to the sheet along the segment's own sides."""
    outlines = []
    for ring in _foot_rings(segment, joint):
        points = project(ring.points, (sheet.surface,))
        stretches = trace_ring(topology, segment.solid.surfaces, sheet, points, ring.labels)
        if stretches:
            outlines.append(stretches)
    return outlines


def foot_sides(segment: Segment, joint: Joint) -> list[int]:
    """Ids of the surfaces that bound the segment's face on the joint's surface."""
    return sorted({int(label) for ring in _foot_rings(segment, joint) for label in ring.labels})


def _foot_rings(segment: Segment, joint: Joint) -> list[Ring]:
    """The boundary of the segment's face on the joint's surface."""
    table = segment.solid.surfaces
    faces = faces_of(segment.solid)
    rings: list[Ring] = []
    own = joint.surface_of(segment.id)
    for side in (1, -1):
        if (own, side) not in faces.areas:
            continue
        out = side * outward(table.surfaces[own], joint.centre[None])[0]
        leaving = joint.normal if joint.segments[0] == segment.id else -joint.normal
        if out @ leaving >= 0:
            rings += boundary_rings(faces.facets, faces.mask(own, side))
    return rings


def footprint_candidates(parts: Parts) -> list[Candidate]:
    """Outlines of beam ends and brick faces in the walls that they stand on."""
    found = []
    for joint in parts.joints:
        for name, other in (joint.segments, joint.segments[::-1]):
            wall = parts.walls.get(name)
            if wall is None or other in parts.walls or not is_on_face(wall, joint):
                continue
            if other in parts.beams and joint.kind == "along":
                continue
            for ring in footprint(parts.topology, wall.sheet, parts.segments[other], joint):
                if not grazes_edge(parts.topology, wall, ring):
                    found += [Candidate(wall, stretch) for stretch in ring]
    return found


def grazes_edge(topology: Topology, wall: Wall, ring: list[Stretch]) -> bool:
    """Whether a round foot touches a straight edge of the wall, or nearly so: between the two would be slivers.

    Such a foot is not imprinted; what stands on it takes its share of the elements that it covers in part.
    """
    for stretch in ring:
        circle = topology.carrier(stretch.carrier)
        if not isinstance(circle, Circle):
            continue
        for edge in wall.outline:
            line = topology.carrier(edge.carrier)
            if isinstance(line, Line) and _grazes(topology, stretch, circle, edge, line):
                return True
    return False


def _grazes(topology: Topology, stretch: Stretch, circle: Circle, edge: Stretch, line: Line) -> bool:
    along = line.parameters(circle.centre[None])
    nearest = line.at(along)
    gap = abs(float(np.linalg.norm(nearest[0] - circle.centre)) - circle.radius)
    if gap > GRAZING * circle.radius or not edge.start <= along[0] <= edge.end:
        return False
    on_arc = (float(circle.parameters(nearest)[0]) - stretch.start) % circle.period
    return stretch.whole or on_arc <= stretch.end - stretch.start


def lap_candidates(parts: Parts) -> list[Candidate]:
    """The outline of each plate of a lap, in the other: what of it lies there bounds the lap."""
    found = []
    for joint in parts.joints:
        if joint.kind != "lap" or is_tangent(parts, joint):
            continue
        for name, other in (joint.segments, joint.segments[::-1]):
            wall = parts.walls[name]
            for ring in footprint(parts.topology, wall.sheet, parts.segments[other], joint):
                found += [Candidate(wall, stretch) for stretch in ring]
    return found


# ---------------------------------------------------------------- beams along walls


def seats(parts: Parts) -> tuple[list[Candidate], dict[str, list[Seat]]]:
    """The axes of beams that lie along walls, as candidates for imprints, and the seats by beam."""
    candidates: list[Candidate] = []
    found: dict[str, list[Seat]] = {}
    for joint in parts.joints:
        if joint.kind != "along":
            continue
        for name, other in (joint.segments, joint.segments[::-1]):
            if name in parts.beams and other in parts.walls:
                beam, wall = parts.beams[name], parts.walls[other]
                edge = not is_on_face(wall, joint)
                if edge and not edge_carriers(parts, wall, joint):
                    continue  # the wall was cut back there: the beam's nodes follow its elements instead
                carrier, start, end = (
                    _edge_seat(parts, beam, wall, joint) if edge else _axis_seat(parts, beam, wall, joint)
                )
                found.setdefault(name, []).append(Seat(joint, wall, carrier, start, end, edge))
                if not edge:
                    points = project(np.array([beam.at(start), beam.at(end)]), (wall.sheet.surface,))
                    stretch = stretch_between(parts.topology, carrier, points[0], points[1], points.mean(axis=0)[None])
                    candidates.append(Candidate(wall, stretch))
    return candidates, found


def _patch_range(parts: Parts, beam: Beam, joint: Joint) -> tuple[float, float]:
    surface = beam.segment.solid.surfaces.surfaces[joint.surface]
    offsets = _outline_points(surface, joint) @ beam.direction
    return beam.offset_of(offsets.min() * beam.direction), beam.offset_of(offsets.max() * beam.direction)


def _outline_points(surface: Surface, joint: Joint) -> Array:
    """All corners (n, 3) of a joint's patch."""
    flat = np.vstack([np.asarray(part.exterior.coords)[:, :2] for part in shapely.get_parts(joint.patch)])
    if isinstance(surface, Plane):
        return flat[:, :1] * surface.u + flat[:, 1:] * surface.v + surface.offset * surface.normal
    return patch_points(surface, shapely.MultiPoint(flat).convex_hull)


def _axis_seat(parts: Parts, beam: Beam, wall: Wall, joint: Joint) -> tuple[int, float, float]:
    """The carrier of the beam's axis brought onto the wall's sheet, and the offsets of the beam along which it lies."""
    start, end = _patch_range(parts, beam, joint)
    ends = project(np.array([beam.at(start), beam.at(end)]), (wall.sheet.surface,))
    along = ends[1] - ends[0]
    if np.linalg.norm(np.cross(along / np.linalg.norm(along), beam.direction)) > 1e-6:
        raise ConnectError(
            f"{beam.segment.id} lies along {wall.segment.id} ({joint.id}) but not parallel to its mid-surface, "
            "expected a beam along a plate, or along a cylinder-plate's axis"
        )
    return parts.topology.carriers.line(ends[0], along), start, end


def _edge_seat(parts: Parts, beam: Beam, wall: Wall, joint: Joint) -> tuple[int, float, float]:
    """The carrier of the wall's edge that a beam runs along."""
    start, end = _patch_range(parts, beam, joint)
    return edge_carriers(parts, wall, joint)[0], start, end


def edge_carriers(parts: Parts, wall: Wall, joint: Joint) -> list[int]:
    """Carriers on which the wall ends at the joint's surface.

    Where the wall was carried on, or cut back, to a curve in which it meets another, that curve stands for the edge.
    """
    surface = wall.segment.solid.surfaces.surfaces[joint.surface_of(wall.segment.id)]
    if isinstance(surface, FacetedSurface):
        return []

    def away(number: int, start: float, end: float) -> float:
        points = parts.topology.carrier(number).at(np.linspace(start, end, 5))
        return float(np.abs(signed_distance(surface, points)).max())

    tolerance = 4 * parts.topology.tolerance
    found = {s.carrier for s in wall.outline if away(s.carrier, s.start, s.end) <= tolerance}
    if not found:
        for crossing in parts.crossings_of(wall):
            reach = 1.5 * crossing.other(wall).thickness
            for start, end in crossing.reach[wall.index]:
                if away(crossing.carrier, start, end) <= reach:
                    found.add(crossing.carrier)
    return sorted(found)


def cut_edges(parts: Parts) -> None:
    """Vertices on the edges of walls where what stands against them begins and ends."""
    for joint in parts.joints:
        for name, other in (joint.segments, joint.segments[::-1]):
            wall = parts.walls.get(name)
            if wall is None or other in parts.walls or is_on_face(wall, joint):
                continue
            surface = wall.segment.solid.surfaces.surfaces[joint.surface]
            points = project(_outline_points(surface, joint), (wall.sheet.surface,))
            for number in edge_carriers(parts, wall, joint):
                carrier = parts.topology.carrier(number)
                if carrier.period is not None:
                    continue
                values = carrier.parameters(points)
                for stretch in wall.outline:
                    if stretch.carrier != number:
                        continue
                    for value in (float(values.min()), float(values.max())):
                        if stretch.start < value < stretch.end:
                            parts.topology.cut(number, value, carrier.at(np.array([value]))[0])
