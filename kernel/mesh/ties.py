"""Ties: what the joints ask for once everything is meshed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.errors import ConnectError
from kernel.idealise.beam import Beam
from kernel.idealise.footprints import edge_carriers, footprint, is_on_face
from kernel.idealise.members import Tie
from kernel.idealise.outlines import even_odd, ring_points
from kernel.idealise.parts import Parts
from kernel.idealise.walls import Wall, patch_points
from kernel.mesh.beams import SeatedNode
from kernel.mesh.bricks import BrickMesh, outer_faces
from kernel.mesh.faces import CurvesByFace, FaceMesh
from kernel.mesh.patches import SurfaceFaces, faces_on, flatten, host_of, node_areas
from kernel.solid.surfaces import CylinderSurface, Surface

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

ON_SURFACE = 1e-6
"""Nodes nearer than this share of the model's size to a surface lie on it."""

PARALLEL = 0.9
"""Beams whose directions have this cosine run side by side."""


@dataclass(slots=True, eq=False)
class Meshed:
    """What has been meshed. points: of all nodes. seated: the beams' nodes that sit on wall nodes.

    curves: of each wall, by its face. sheets: by face, the id of its mid-surface.
    """

    parts: Parts
    curves: CurvesByFace
    faces: dict[str, FaceMesh]
    bricks: dict[str, BrickMesh]
    seated: dict[str, list[SeatedNode]]
    points: Array
    sheets: dict[int, int] = field(init=False)
    _outer: dict[str, list[Indices]] = field(default_factory=dict)
    _on: dict[tuple[str, int], SurfaceFaces] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self.sheets = {wall.index: wall.sheet.surface_id for wall in self.parts.walls.values()}

    def surface(self, joint: Joint) -> Surface:
        """The joint's surface."""
        return self.parts.segments[joint.segments[0]].solid.surfaces.surfaces[joint.surface]

    def brick_faces(self, name: str, joint: Joint) -> SurfaceFaces:
        """A brick's element faces on the joint's surface."""
        key = (name, joint.surface)
        if key not in self._on:
            if name not in self._outer:
                self._outer[name] = outer_faces(self.bricks[name].blocks)
            size = self.parts.topology.carriers.reach
            surface = self.surface(joint)
            tolerance = ON_SURFACE * size
            if isinstance(surface, CylinderSurface):
                tolerance = max(tolerance, 5e-3 * surface.radius)
            self._on[key] = faces_on(surface, self._outer[name], self.points, tolerance)
            if not self._on[key].corners:
                raise ConnectError(f"{name} has no element face on the surface of its joint {joint.id}")
        return self._on[key]


def make_ties(meshed: Meshed) -> tuple[Tie, ...]:
    """The ties of all joints that do not share nodes. ConnectError, by joint, where one cannot be made."""
    ties: list[Tie] = []
    walls: dict[tuple[str, str], list[Joint]] = {}
    for joint in meshed.parts.joints:
        if all(name in meshed.parts.walls for name in joint.segments):
            walls.setdefault(joint.segments, []).append(joint)
        else:
            ties += _joint_ties(meshed, joint)
    for (first, second), joints in walls.items():
        ties += _wall_on_wall(meshed, joints, meshed.parts.walls[first], meshed.parts.walls[second])
    return tuple(ties)


def _kinds(parts: Parts, joint: Joint) -> dict[str, list[str]]:
    kinds: dict[str, list[str]] = {"beam": [], "wall": [], "brick": []}
    for name in joint.segments:
        kinds["wall" if name in parts.walls else "beam" if name in parts.beams else "brick"].append(name)
    return kinds


def _joint_ties(meshed: Meshed, joint: Joint) -> list[Tie]:
    parts = meshed.parts
    kinds = _kinds(parts, joint)
    match (len(kinds["beam"]), len(kinds["wall"]), len(kinds["brick"])):
        case (2, 0, 0):
            return _beam_on_beam(meshed, joint)
        case (1, 1, 0):
            return _beam_on_wall(meshed, joint, parts.beams[kinds["beam"][0]], parts.walls[kinds["wall"][0]])
        case (1, 0, 1):
            return _beam_on_brick(meshed, joint, parts.beams[kinds["beam"][0]], kinds["brick"][0])
        case (0, 1, 1):
            return _brick_on_wall(meshed, joint, parts.walls[kinds["wall"][0]], kinds["brick"][0])
        case _:
            return _brick_on_brick(meshed, joint)


# ---------------------------------------------------------------- beams


def beam_stations(parts: Parts, joint: Joint, sizes: dict[str, float]) -> None:
    """Put the stations that the joint needs into its beams, before they are divided."""
    beams = [parts.beams[name] for name in joint.segments if name in parts.beams]
    if len(beams) == 2 and joint.kind == "along" and abs(beams[0].direction @ beams[1].direction) > PARALLEL:
        for point in side_by_side(parts, joint, min(sizes[name] for name in joint.segments)):
            for beam in beams:
                beam.stations.append(beam.offset_of(point))
        return
    for beam in beams:
        if joint.kind == "end_on" or len(beams) == 2:
            beam.stations.append(_snapped(parts, beam, beam.offset_of(joint.centre)))
        elif joint.kind == "along":
            start, end = _extent(parts, joint, beam)
            beam.stations += [_snapped(parts, beam, start), _snapped(parts, beam, end)]


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


def _beam_on_beam(meshed: Meshed, joint: Joint) -> list[Tie]:
    first, second = (meshed.parts.beams[name] for name in joint.segments)
    if joint.kind == "along" and abs(first.direction @ second.direction) > PARALLEL:
        spacing = float(np.diff(first.offsets).max())
        points = first.origin + first.offsets[:, None] * first.direction
        start, end = _extent(meshed.parts, joint, first)
        ties = []
        slack = meshed.parts.topology.tolerance * 4
        for offset, node, point in zip(first.offsets, first.nodes.tolist(), points):
            if not start - slack <= offset <= end + slack:
                continue
            other = second.offset_of(point)
            partner = second.node_at(other)
            place = second.offsets[int(np.argmin(np.abs(second.offsets - other)))]
            if abs(place - other) <= 1e-3 * spacing and abs(second.at(other) @ first.direction - offset) <= slack:
                ties.append(_rigid(joint, partner, [node]))
        if not ties:
            raise ConnectError(f"{joint.id}: {first.segment.id} and {second.segment.id} have no stations side by side")
        return ties
    slack = 8 * meshed.parts.topology.tolerance
    ends = [beam.is_end(beam.offset_of(joint.centre), slack) for beam in (first, second)]
    leaning = [abs(beam.direction @ joint.normal) for beam in (first, second)]
    ending, through = (first, second) if (ends[0], leaning[0]) >= (ends[1], leaning[1]) else (second, first)
    return [
        _rigid(
            joint,
            through.node_at(through.offset_of(joint.centre)),
            [ending.node_at(ending.offset_of(joint.centre))],
        )
    ]


def _beam_on_wall(meshed: Meshed, joint: Joint, beam: Beam, wall: Wall) -> list[Tie]:
    if joint.kind == "along":
        ties = [
            _rigid(joint, seat.wall_node, [seat.beam_node])
            for seat in meshed.seated.get(beam.segment.id, [])
            if seat.joint is joint
        ]
        if not ties:
            raise ConnectError(f"{joint.id}: {beam.segment.id} finds no node of {wall.segment.id} along its axis")
        return ties
    node = beam.node_at(beam.offset_of(joint.centre))
    face = meshed.faces[wall.segment.id]
    if not is_on_face(wall, joint):
        return [_rigid(joint, node, _edge_nodes(meshed, wall, joint))]
    rings = footprint(meshed.parts.topology, wall.sheet, beam.segment, joint)
    outline = even_odd([ring_points(meshed.parts.topology, wall.sheet, ring) for ring in rings])
    nodes, areas = _areas_within(face, outline)
    if not len(nodes):
        raise ConnectError(f"{joint.id}: the end of {beam.segment.id} covers no element of {wall.segment.id}")
    return [Tie("beam_on_face", joint, np.array([node]), nodes, areas)]


def _areas_within(face: FaceMesh, outline: shapely.Geometry) -> tuple[Indices, Array]:
    """Nodes of the elements whose middle lies in the outline, and their shares of those elements' areas."""
    areas: dict[int, float] = {}
    order = np.argsort(face.nodes)
    for elements in (face.quads, face.triangles):
        if not len(elements):
            continue
        flat = face.flat[order[np.searchsorted(face.nodes[order], elements)]]
        middle = flat.mean(axis=1)
        for row in np.nonzero(shapely.contains_xy(outline, middle[:, 0], middle[:, 1]))[0]:
            area = float(shapely.Polygon(flat[row]).area)
            for node in elements[row].tolist():
                areas[node] = areas.get(node, 0.0) + area / elements.shape[1]
    ordered = dict(sorted(areas.items()))
    return np.fromiter(ordered, np.int64, len(ordered)), np.fromiter(ordered.values(), np.float64, len(ordered))


def _edge_nodes(meshed: Meshed, wall: Wall, joint: Joint) -> list[int]:
    """Nodes on the wall's outline that lie on the joint's surface, within its patch seen along the wall's normal."""
    numbers = set(edge_carriers(meshed.parts, wall, joint))
    points = patch_points(meshed.surface(joint), joint.patch)
    found: set[int] = set()
    slack = 8 * meshed.parts.topology.tolerance
    for seeded in meshed.curves.get(wall.index, []):
        if seeded.curve.carrier not in numbers:
            continue
        carrier = meshed.parts.topology.carrier(seeded.curve.carrier)
        if carrier.period is not None:
            found.update(seeded.nodes.tolist())
            continue
        reach = carrier.parameters(points)
        values = carrier.parameters(meshed.points[seeded.nodes])
        inside = (values >= reach.min() - slack) & (values <= reach.max() + slack)
        found.update(seeded.nodes[inside].tolist())
    if not found:
        other = next(name for name in joint.segments if name != wall.segment.id)
        raise ConnectError(
            f"{joint.id}: {other} stands against an edge of {wall.segment.id} that is no part of its mid-surface's "
            "outline"
        )
    return sorted(found)


def _beam_on_brick(meshed: Meshed, joint: Joint, beam: Beam, brick: str) -> list[Tie]:
    faces = meshed.brick_faces(brick, joint)
    if joint.kind == "end_on":
        node = beam.node_at(beam.offset_of(joint.centre))
        return [_average(joint, node, faces, joint.patch, beam.segment.id)]
    surface = meshed.surface(joint)
    start, end = _extent(meshed.parts, joint, beam)
    slack = 4 * meshed.parts.topology.tolerance
    inside = np.nonzero((beam.offsets >= start - slack) & (beam.offsets <= end + slack))[0]
    ties = []
    for place in inside:
        low = beam.offsets[place] if place == inside[0] else 0.5 * (beam.offsets[place - 1] + beam.offsets[place])
        high = beam.offsets[place] if place == inside[-1] else 0.5 * (beam.offsets[place] + beam.offsets[place + 1])
        part = _slice(surface, joint.patch, beam.direction, float(low), float(high))
        if part.area > 0:
            ties.append(_average(joint, int(beam.nodes[place]), faces, part, beam.segment.id))
    return ties


def _slice(surface: Surface, patch: shapely.Geometry, direction: Array, low: float, high: float) -> shapely.Geometry:
    """The part of a planar patch with low <= x . direction <= high."""
    if isinstance(surface, CylinderSurface):
        if abs(surface.axis.direction @ direction) < PARALLEL:
            return patch
        base = float(surface.axis.point @ direction)
        sign = 1.0 if surface.axis.direction @ direction > 0 else -1.0
        along = np.array([0.0, sign])
    else:
        along = np.array([surface.u @ direction, surface.v @ direction])  # type: ignore[union-attr]
        base = float((surface.normal * surface.offset) @ direction)  # type: ignore[union-attr]
    across = np.array([-along[1], along[0]])
    reach = 4 * max(map(abs, patch.bounds)) + 1
    corners = [
        along * (value - base) + across * side
        for value, side in ((low, -reach), (high, -reach), (high, reach), (low, reach))
    ]
    return patch.intersection(shapely.Polygon(corners))


def _average(joint: Joint, node: int, faces: SurfaceFaces, patch: shapely.Geometry, name: str) -> Tie:
    nodes, areas = node_areas(faces, patch)
    if not len(nodes):
        raise ConnectError(f"{joint.id}: {name} covers no element face of what it stands on")
    return Tie("beam_on_face", joint, np.array([node]), nodes, areas)


# ---------------------------------------------------------------- walls


def _wall_on_wall(meshed: Meshed, joints: list[Joint], first: Wall, second: Wall) -> list[Tie]:
    """Nothing where the two share curves; else the nodes of the one in a contact follow the other's elements.

    joints: all contacts of the two. One of them must do: the largest first, the smaller wall's nodes first.
    """
    if any(second.index in seeded.curve.uses for seeded in meshed.curves.get(first.index, [])):
        return []
    if _joined_through_others(meshed, first, second):
        return []
    by_area = sorted((first, second), key=lambda wall: (wall.region.area, wall.index))
    for joint in sorted(joints, key=lambda joint: (-joint.area, joint.id)):
        for follower, host in (by_area, by_area[::-1]):
            chosen = _contact_nodes(meshed, joint, follower, host)
            if len(chosen) > 1:
                return [_interpolated(meshed, joint, chosen, host, has_rotations=True)]
    names = ", ".join(joint.id for joint in joints)
    raise ConnectError(
        f"{first.segment.id} and {second.segment.id} touch ({names}) without a common curve, and neither has nodes in "
        "the contact that the other could hold: a smaller size or another type is needed for one of them"
    )


def _contact_nodes(meshed: Meshed, joint: Joint, follower: Wall, host: Wall) -> Indices:
    """Nodes of a wall within a contact: inside the patch of a lap, on the outline where the wall ends there."""
    if joint.kind == "lap":
        nodes = meshed.faces[follower.segment.id].nodes
        patch = joint.patch.buffer(20 * meshed.parts.topology.tolerance)
    else:
        if not edge_carriers(meshed.parts, follower, joint):
            return np.empty(0, np.int64)
        nodes = np.array(_edge_nodes(meshed, follower, joint), dtype=np.int64)
        patch = joint.patch.buffer(0.6 * max(follower.thickness, host.thickness))
    flat = flatten(meshed.surface(joint), meshed.points[nodes])
    return np.sort(nodes[shapely.contains_xy(patch, flat[:, 0], flat[:, 1])])


def _joined_through_others(meshed: Meshed, first: Wall, second: Wall) -> bool:
    """Whether the curve in which their mid-surfaces meet runs in a wall that continues one of the two.

    So it is where one wall was cut in two beside the joint: the curve lies in the one part, the contact reaches the
    other.
    """
    carriers = {crossing.carrier for crossing in meshed.parts.crossings_of(first) if second in crossing.walls}
    wanted = {first.sheet.surface_id, second.sheet.surface_id}
    for wall in meshed.parts.walls.values():
        if wall.sheet.surface_id in wanted:
            for seeded in meshed.curves.get(wall.index, []):
                sheets = {meshed.sheets[face] for face in seeded.curve.uses}
                if seeded.curve.carrier in carriers and wanted <= sheets:
                    return True
    return False


def _wall_faces(meshed: Meshed, wall: Wall) -> SurfaceFaces:
    key = (wall.segment.id, -1)
    if key not in meshed._on:
        face = meshed.faces[wall.segment.id]
        size = meshed.parts.topology.carriers.reach
        meshed._on[key] = faces_on(wall.sheet.surface, (face.triangles, face.quads), meshed.points, ON_SURFACE * size)
    return meshed._on[key]


def _interpolated(meshed: Meshed, joint: Joint, nodes: Indices, wall: Wall, has_rotations: bool) -> Tie:
    """Nodes that follow the elements of a wall, seen along its normal."""
    faces = _wall_faces(meshed, wall)
    flat = flatten(wall.sheet.surface, meshed.points[nodes])
    hosts, weights = zip(*(host_of(faces, point) for point in flat))
    return Tie(
        "interpolated",
        joint,
        nodes,
        hosts=tuple(hosts),
        host_weights=tuple(weights),
        has_rotations=has_rotations,
    )


# ---------------------------------------------------------------- bricks


def _brick_on_wall(meshed: Meshed, joint: Joint, wall: Wall, brick: str) -> list[Tie]:
    pairs = meshed.bricks[brick].pairs
    host = meshed.parts.hosts.get(brick)
    if host is not None and host[1] is joint and len(pairs):
        return [Tie("rigid_pairs", joint, pairs[:, 0], pairs[:, 1], has_rotations=False)]
    faces = meshed.brick_faces(brick, joint)
    if is_on_face(wall, joint):
        patch = joint.patch.buffer(20 * meshed.parts.topology.tolerance)
        nodes = faces.nodes
        flat = flatten(meshed.surface(joint), meshed.points[nodes])
        chosen = nodes[shapely.contains_xy(patch, flat[:, 0], flat[:, 1])]
        if len(chosen) < 3:
            raise ConnectError(
                f"{joint.id}: {brick} has {len(chosen)} nodes where it stands on {wall.segment.id}, expected 3 or "
                "more: a smaller size is needed there"
            )
        return [_interpolated(meshed, joint, chosen, wall, has_rotations=False)]
    return _edge_on_brick(meshed, joint, wall, brick, faces)


def _edge_on_brick(meshed: Meshed, joint: Joint, wall: Wall, brick: str, faces: SurfaceFaces) -> list[Tie]:
    """Each node of the wall's edge follows, turning too, the part of the patch that is nearest to it."""
    nodes = np.array(_edge_nodes(meshed, wall, joint), dtype=np.int64)
    surface = meshed.surface(joint)
    flat = flatten(surface, meshed.points[nodes])
    cells = shapely.get_parts(shapely.voronoi_polygons(shapely.MultiPoint(flat), extend_to=joint.patch.envelope))
    if len(nodes) == 1:
        cells = np.array([joint.patch.envelope.buffer(1e-9)])
    ties = []
    for node, point in zip(nodes.tolist(), flat):
        cell = next((c for c in cells if c.buffer(1e-9 * abs(c.area) ** 0.5).contains(shapely.Point(point))), None)
        part = joint.patch.intersection(cell) if cell is not None else joint.patch
        if part.area > 1e-9 * joint.patch.area:
            ties.append(_average(joint, node, faces, part, wall.segment.id))
    return ties


def _brick_on_brick(meshed: Meshed, joint: Joint) -> list[Tie]:
    """Nothing where the two share nodes; else the nodes of the one whose face is the smaller follow the other's."""
    faces = {name: meshed.brick_faces(name, joint) for name in joint.segments}
    if len(np.intersect1d(faces[joint.segments[0]].nodes, faces[joint.segments[1]].nodes)) >= 3:
        return []
    covered = {name: sum(polygon.area for polygon in faces[name].polygons) for name in faces}
    small, large = sorted(joint.segments, key=lambda name: (covered[name], name))
    patch = joint.patch.buffer(20 * meshed.parts.topology.tolerance)
    nodes = faces[small].nodes
    flat = flatten(meshed.surface(joint), meshed.points[nodes])
    inside = shapely.contains_xy(patch, flat[:, 0], flat[:, 1])
    chosen, at = nodes[inside], flat[inside]
    if len(chosen) < 3:
        raise ConnectError(
            f"{joint.id}: {small} has {len(chosen)} nodes in its contact with {large}, expected 3 or more: "
            "a smaller size is needed there"
        )
    hosts, weights = zip(*(host_of(faces[large], point) for point in at))
    return [Tie("interpolated", joint, chosen, hosts=tuple(hosts), host_weights=tuple(weights), has_rotations=False)]
