"""Ties of beams: to other beams, to walls, to bricks; and the stations that these need."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.idealise.beam import Beam
from kernel.idealise.footprints import footprint, grazes_edge, is_on_face
from kernel.idealise.outlines import even_odd, ring_points
from kernel.idealise.parts import Parts
from kernel.idealise.walls import Wall, patch_points
from kernel.mesh.assembly import Tie
from kernel.mesh.faces import FaceMesh
from kernel.mesh.meshed import Meshed, average, edge_nodes, interpolated
from kernel.mesh.patches import corner_areas, shape_functions
from kernel.solid.surfaces import CylinderSurface, Plane, Surface

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

PARALLEL = 0.9
"""Beams whose directions have this cosine run side by side."""


def beam_stations(parts: Parts, joint: Joint, sizes: dict[str, float]) -> None:
    """Put the stations that the joint needs into its beams, before they are divided."""
    beams = [parts.beams[name] for name in joint.segments if name in parts.beams]
    if len(beams) == 2 and joint.kind == "along" and abs(beams[0].direction @ beams[1].direction) > PARALLEL:
        for point in side_by_side(parts, joint, min(sizes[name] for name in joint.segments)):
            for beam in beams:
                beam.stations.append(beam.offset_of(point))
        return
    if len(beams) == 2 and _common_end(parts, beams[0], beams[1], joint) is not None:
        return
    for beam in beams:
        if joint.kind == "end_on" or len(beams) == 2:
            beam.stations.append(_foot(parts, joint, beam))
        elif joint.kind == "along":
            start, end = _extent(parts, joint, beam)
            beam.stations += [_snapped(parts, beam, start), _snapped(parts, beam, end)]


def _foot(parts: Parts, joint: Joint, beam: Beam) -> float:
    """Where on the beam's axis a joint holds it: its end, where that lies within a hollow or dome of the contact."""
    offset = beam.offset_of(joint.middle)
    surface = beam.segment.solid.surfaces.surfaces[joint.surface]
    if joint.kind == "end_on" and not isinstance(surface, Plane | CylinderSurface):
        for end in (beam.start, beam.end):
            if abs(offset - end) <= 0.5 * beam.section.area**0.5:
                return end
    return _snapped(parts, beam, offset)


def _common_end(parts: Parts, first: Beam, second: Beam, joint: Joint) -> tuple[float, float] | None:
    """The offsets of the ends that two beams have at one point, next to a joint of theirs."""
    slack = 8 * parts.topology.tolerance
    reach = 2 * max(first.section.area, second.section.area) ** 0.5
    for one in (first.start, first.end):
        for other in (second.start, second.end):
            point = first.at(one)
            if np.linalg.norm(point - second.at(other)) <= slack and np.linalg.norm(point - joint.centre) <= reach:
                return one, other
    return None


def _snapped(parts: Parts, beam: Beam, offset: float) -> float:
    for end in (beam.start, beam.end):
        if abs(offset - end) <= 4 * parts.topology.tolerance:
            return end
    return offset


def _extent(parts: Parts, joint: Joint, beam: Beam) -> tuple[float, float]:
    surface = beam.segment.solid.surfaces.surfaces[joint.surface]
    offsets = patch_points(surface, joint.patch) @ beam.direction
    return (
        beam.offset_of(float(offsets.min()) * beam.direction),
        beam.offset_of(float(offsets.max()) * beam.direction),
    )


def side_by_side(parts: Parts, joint: Joint, size: float) -> Array:
    """Points (n, 3) on the first beam's axis, along which two beams that run side by side are tied."""
    first, second = (parts.beams[name] for name in joint.segments)
    start, end = _extent(parts, joint, first)
    reach = sorted(float(second.at(offset) @ first.direction) for offset in (second.start, second.end))
    start, end = max(start, reach[0]), min(end, reach[1])
    count = max(1, round((end - start) / size))
    return np.array([first.at(offset) for offset in np.linspace(start, end, count + 1)])


def _rigid(joint: Joint, independent: int, dependent: Sequence[int]) -> Tie:
    return Tie("rigid", joint, np.array(list(dependent), dtype=np.int64), np.array([independent], dtype=np.int64))


def beam_on_beam(meshed: Meshed, joint: Joint) -> list[Tie]:
    """A rigid arm where one ends on the other or they cross; one at every station where they run side by side."""
    first, second = (meshed.parts.beams[name] for name in joint.segments)
    if joint.kind == "along" and abs(first.direction @ second.direction) > PARALLEL:
        return [_rigid(joint, partner, [node]) for node, partner in _side_by_side_nodes(meshed, joint)]
    common = _common_end(meshed.parts, first, second, joint)
    if common is not None:
        return [_rigid(joint, first.node_at(common[0]), [second.node_at(common[1])])]
    slack = 8 * meshed.parts.topology.tolerance
    ends = [beam.is_end(beam.offset_of(joint.middle), slack) for beam in (first, second)]
    leaning = [abs(beam.direction @ joint.normal) for beam in (first, second)]
    ending, through = (first, second) if (ends[0], leaning[0]) >= (ends[1], leaning[1]) else (second, first)
    return [
        _rigid(
            joint,
            through.node_at(through.offset_of(joint.middle)),
            [ending.node_at(ending.offset_of(joint.middle))],
        )
    ]


def _side_by_side_nodes(meshed: Meshed, joint: Joint) -> list[tuple[int, int]]:
    """Nodes of the first beam and of the second that face one another along the contact.

    They do where the stations of the joint stand. Walls that the beams lie along have a say in where their nodes are,
    too: then each node goes with the one that is nearest to it, if that is so of both; the nearest of all at least.
    """
    first, second = (meshed.parts.beams[name] for name in joint.segments)
    slack = meshed.parts.topology.tolerance * 4

    def along(beam: Beam) -> Indices:
        start, end = _extent(meshed.parts, joint, beam)
        inside = (beam.offsets >= start - slack) & (beam.offsets <= end + slack)
        return beam.nodes[inside] if inside.any() else beam.nodes

    own, other = along(first), along(second)
    apart = np.linalg.norm(meshed.points[own][:, None] - meshed.points[other][None], axis=2)
    nearest, back = apart.argmin(axis=1), apart.argmin(axis=0)
    mutual = np.flatnonzero(back[nearest] == np.arange(len(own)))
    return [(int(own[place]), int(other[nearest[place]])) for place in mutual.tolist()]


def beam_on_wall(meshed: Meshed, joint: Joint, beam: Beam, wall: Wall) -> list[Tie]:
    """The end's node on the elements in its footprint, or on the edge's nodes; node by node where it lies along."""
    if joint.kind == "along":
        ties = [
            _rigid(joint, seat.wall_node, [seat.beam_node])
            for seat in meshed.seated.get(beam.segment.id, [])
            if seat.joint is joint
        ]
        return ties or [_along_elements(meshed, joint, beam, wall)]
    node = beam.node_at(beam.offset_of(joint.middle))
    face = meshed.faces[wall.segment.id]
    if not is_on_face(wall, joint):
        return [_rigid(joint, node, edge_nodes(meshed, wall, joint))]
    rings = footprint(meshed.parts.topology, wall.sheet, beam.segment, joint)
    outline = even_odd([ring_points(meshed.parts.topology, wall.sheet, ring) for ring in rings])
    is_imprinted = not any(grazes_edge(meshed.parts.topology, wall, ring) for ring in rings)
    nodes, areas = _areas_within(face, outline, is_imprinted)
    if not len(nodes):  # the wall was cut back from there
        return [interpolated(meshed, joint, np.array([node]), wall, has_rotations=True)]
    return [Tie("beam_on_face", joint, np.array([node]), nodes, areas)]


def _along_elements(meshed: Meshed, joint: Joint, beam: Beam, wall: Wall) -> Tie:
    """The beam's nodes along the contact follow the wall's elements nearest to them.

    So it is where the wall's mid-surface has no curve for the beam's nodes to stand opposite: it was cut back there, or
    the beam touches it beside its axis.
    """
    start, end = _extent(meshed.parts, joint, beam)
    slack = 4 * meshed.parts.topology.tolerance
    nodes = beam.nodes[(beam.offsets >= start - slack) & (beam.offsets <= end + slack)]
    if not len(nodes):
        nodes = np.array([beam.node_at(0.5 * (start + end))])
    return interpolated(meshed, joint, nodes, wall, has_rotations=True)


def _areas_within(face: FaceMesh, outline: shapely.Geometry, is_imprinted: bool) -> tuple[Indices, Array]:
    """Nodes of the elements within the outline, and their shares of those elements' areas.

    Where the outline is imprinted an element is in it or not, however its chords lie to the curve: its middle says so.
    Elsewhere it counts with what the outline covers of it.
    """
    areas: dict[int, float] = {}
    order = np.argsort(face.nodes)
    for elements in (face.quads, face.triangles):
        if not len(elements):
            continue
        flat = face.flat[order[np.searchsorted(face.nodes[order], elements)]]
        if is_imprinted:
            middle = flat.mean(axis=1)
            inside = np.flatnonzero(shapely.contains_xy(outline, middle[:, 0], middle[:, 1])).tolist()
            shares = [corner_areas(flat[row]) for row in inside]
        else:
            common = shapely.intersection(shapely.polygons(flat), outline)
            inside = np.flatnonzero(shapely.area(common) > 0.0).tolist()
            shares = [common[row].area * _weights_amid(flat[row], common[row]) for row in inside]
        for row, own in zip(inside, shares):
            for node, share in zip(elements[row].tolist(), own.tolist()):
                areas[node] = areas.get(node, 0.0) + share
    ordered = {node: area for node, area in sorted(areas.items()) if area > 0.0}
    return np.fromiter(ordered, np.int64, len(ordered)), np.fromiter(ordered.values(), np.float64, len(ordered))


def _weights_amid(corners: Array, part: shapely.Geometry) -> Array:
    """Weights (n,) of an element's corners (n, 2) at the centroid of a part of it."""
    return np.clip(shape_functions(corners, shapely.get_coordinates(part.centroid)[0]), 0.0, None)


def beam_on_brick(meshed: Meshed, joint: Joint, beam: Beam, brick: str) -> list[Tie]:
    """The end's node on the element faces it covers; where it lies along, each node on its share of the contact."""
    faces = meshed.brick_faces(brick, joint)
    if joint.kind == "end_on":
        node = beam.node_at(beam.offset_of(joint.middle))
        return [average(joint, node, faces, joint.patch_of(brick), beam.segment.id)]
    surface = faces.surface
    start, end = _extent(meshed.parts, joint, beam)
    slack = 4 * meshed.parts.topology.tolerance
    inside = np.nonzero((beam.offsets >= start - slack) & (beam.offsets <= end + slack))[0]
    ties = []
    for place in inside:
        low = beam.offsets[place] if place == inside[0] else 0.5 * (beam.offsets[place - 1] + beam.offsets[place])
        high = beam.offsets[place] if place == inside[-1] else 0.5 * (beam.offsets[place] + beam.offsets[place + 1])
        part = _slice(surface, joint.patch_of(brick), beam.direction, float(low), float(high))
        if part.area > 0:
            ties.append(average(joint, int(beam.nodes[place]), faces, part, beam.segment.id))
    return ties


def _slice(surface: Surface, patch: shapely.Geometry, direction: Array, low: float, high: float) -> shapely.Geometry:
    """The part of a planar or cylindrical patch with low <= x . direction <= high; all of any other."""
    if not isinstance(surface, Plane | CylinderSurface):
        return patch
    if isinstance(surface, CylinderSurface):
        if abs(surface.axis.direction @ direction) < PARALLEL:
            return patch
        base = float(surface.axis.point @ direction)
        sign = 1.0 if surface.axis.direction @ direction > 0 else -1.0
        along = np.array([0.0, sign])
    else:
        assert isinstance(surface, Plane)
        along = np.array([surface.u @ direction, surface.v @ direction])
        base = float((surface.normal * surface.offset) @ direction)
    across = np.array([-along[1], along[0]])
    reach = 4 * max(map(abs, patch.bounds)) + 1
    corners = [
        along * (value - base) + across * side
        for value, side in ((low, -reach), (high, -reach), (high, reach), (low, reach))
    ]
    return patch.intersection(shapely.Polygon(corners))
