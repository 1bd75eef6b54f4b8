"""Bricks that are swept: those of one direction that stand on one another share one section, and so their nodes.

    direction ^   +-----+            levels: every start and end of a brick, divided between
              |   |  b  |
              |   +-----+---+        section: the union of the outlines, each outline imprinted;
              |   |    a    |        a brick takes the elements within its own outline
              |   +---------+

A group that stands on a plate, swept along the plate's normal, takes the plate's own elements for its section.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint, joints_by_segment
from kernel.errors import MeshError
from kernel.idealise.footprints import footprint
from kernel.idealise.imprints import Candidate, imprint, lay_outlines
from kernel.idealise.outlines import PolygonLike, Stretch, domain
from kernel.idealise.regions import outline_of
from kernel.idealise.sheets import PlaneSheet, plane_sheet_at
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall, section_outline
from kernel.segment.prism import sweeps
from kernel.segment.segments import BrickShape, Segment
from kernel.solid.surfaces import CylinderSurface, Plane, Surface, plane_frame
from kernel.units import ANGLE_TOLERANCE

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class SweptBrick:
    """One brick of a group: from start to end along the direction, within `outline` of the section's frame."""

    segment: Segment
    start: float
    end: float
    outline: PolygonLike


@dataclass(slots=True, eq=False)
class SweepGroup:
    """Bricks swept along one direction. sheet: the section's plane.

    host: the wall whose elements are swept, with the joint, or None where the group has a section of its own: then
    topology and face hold that.
    """

    direction: Array
    sheet: PlaneSheet
    bricks: list[SweptBrick]
    topology: Topology | None = None
    face: Wall | None = None
    host: tuple[Wall, Joint] | None = None


def _parallel(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(np.cross(a, b)) < 4 * ANGLE_TOLERANCE)


def _across(segment: Segment, joint: Joint, direction: Array) -> bool:
    """Whether the joint lies in a plane across the direction."""
    surface = segment.solid.surfaces.surfaces[joint.surface]
    return isinstance(surface, Plane) and _parallel(surface.normal, direction)


def _is_round_side(surface: Surface, direction: Array) -> bool:
    return isinstance(surface, CylinderSurface) and _parallel(surface.axis.direction, direction)


def sweep_directions(segments: Sequence[Segment], joints: Sequence[Joint], walls: dict[str, Wall]) -> dict[str, Array]:
    """By segment id, the direction along which each brick is swept; bricks that cannot be are not in it.

    Of several (a block has three) the one across which most of its contacts lie, with walls that it may stand on and
    with bricks that can be swept the same way; without such contacts, the shape's own.
    """
    options: dict[str, list[Array]] = {}
    for segment in segments:
        if isinstance(segment.shape, BrickShape) and segment.shape.sweep is not None:
            others = [sweep.direction for sweep in sweeps(segment.solid) if sweep.is_exact]
            options[segment.id] = [_upward(direction) for direction in (segment.shape.sweep, *others)]
    by_id = {segment.id: segment for segment in segments}
    by_segment = joints_by_segment(joints)
    found: dict[str, Array] = {}
    for name, directions in options.items():
        weights = [0.0] * len(directions)
        for joint in by_segment.get(name, []):
            other = next(one for one in joint.segments if one != name)
            for place, direction in enumerate(directions):
                if not _across(by_id[name], joint, direction):
                    continue
                wall = walls.get(other)
                stands = wall is not None and joint.surface in wall.surface_ids
                if stands or any(_parallel(direction, mate) for mate in options.get(other, [])):
                    weights[place] += joint.area
        found[name] = directions[int(np.argmax(weights))]
    return found


def _upward(direction: Array) -> Array:
    """The direction or its opposite, its first large component positive."""
    return direction if direction[int(np.argmax(np.abs(direction) > 1e-6))] > 0 else -direction


def group_bricks(
    segments: Sequence[Segment], joints: Sequence[Joint], walls: dict[str, Wall], topology: Topology
) -> tuple[list[SweepGroup], list[Candidate]]:
    """The groups of swept bricks, and what those that stand on walls imprint there. topology: the walls'."""
    by_id = {segment.id: segment for segment in segments}
    directions = sweep_directions(segments, joints, walls)
    groups: list[SweepGroup] = []
    candidates: list[Candidate] = []
    by_segment = joints_by_segment(joints)
    for names in _connected(by_id, joints, directions):
        own = [joint for name in names for joint in by_segment.get(name, [])]
        group, wanted = _make_group([by_id[name] for name in names], directions[names[0]], own, walls, by_id, topology)
        groups.append(group)
        candidates += wanted
    return groups, candidates


def _connected(by_id: dict[str, Segment], joints: Sequence[Joint], directions: dict[str, Array]) -> list[list[str]]:
    """Swept bricks of one direction joined through planes across it or side by side, in order."""
    root = {name: name for name in directions}

    def find(name: str) -> str:
        while root[name] != name:
            name = root[name]
        return name

    for joint in joints:
        a, b = joint.segments
        if a in directions and b in directions and _parallel(directions[a], directions[b]):
            surface = by_id[a].solid.surfaces.surfaces[joint.surface]
            if isinstance(surface, Plane) or _is_round_side(surface, directions[a]):
                root[find(b)] = find(a)
    groups: dict[str, list[str]] = {}
    for name in directions:
        groups.setdefault(find(name), []).append(name)
    return list(groups.values())


def _make_group(
    segments: list[Segment],
    direction: Array,
    joints: Sequence[Joint],
    walls: dict[str, Wall],
    by_id: dict[str, Segment],
    topology: Topology,
) -> tuple[SweepGroup, list[Candidate]]:
    names = {segment.id for segment in segments}
    host = _host(names, direction, joints, walls)
    table = segments[0].solid.surfaces
    if host is not None:
        wall = host[0]
        assert isinstance(wall.sheet, PlaneSheet)
        outlines = [section_of(topology, segment, wall.sheet) for segment in segments]
        union = shapely.union_all([polygon for _, polygon in outlines])
        if wall.region.buffer(30 * topology.tolerance).covers(union):
            bricks = [_swept(segment, wall.sheet.normal, polygon) for segment, (_, polygon) in zip(segments, outlines)]
            group = SweepGroup(wall.sheet.normal, wall.sheet, bricks, host=host)
            return group, [Candidate(wall, stretch) for rings, _ in outlines for ring in rings for stretch in ring]
    frame = plane_frame(direction)
    start = min(float((segment.solid.facets.vertices @ direction).min()) for segment in segments)
    sheet = plane_sheet_at(direction, start, frame.u, frame.v, table)
    own = Topology(topology.tolerance, topology.carriers.reach)
    outlines = [section_of(own, segment, sheet) for segment in segments]
    bricks = [_swept(segment, direction, polygon) for segment, (_, polygon) in zip(segments, outlines)]
    all_rings = [ring for rings, _ in outlines for ring in rings]
    known = sorted({stretch.carrier for ring in all_rings for stretch in ring})
    face = Wall(0, segments[0], sheet, 0.0, all_rings, outlines[0][1], known)
    if len(segments) == 1:
        face.region = outlines[0][1]
        face.outline = [stretch for ring in all_rings for stretch in ring]
    else:
        region = shapely.union_all([polygon for _, polygon in outlines], grid_size=1e-7 * own.carriers.reach)
        face.outline, face.region = outline_of(own, face, region, set())
    wanted = [Candidate(face, stretch) for ring in all_rings for stretch in ring] if len(segments) > 1 else []
    for joint in joints:
        for name, other in (joint.segments, joint.segments[::-1]):
            if name in names and other not in names and _across(by_id[name], joint, direction):
                wanted += [
                    Candidate(face, stretch) for ring in footprint(own, sheet, by_id[other], joint) for stretch in ring
                ]
    lay_outlines(own, [face])
    imprint(own, wanted)
    return SweepGroup(direction, sheet, bricks, topology=own, face=face), []


def _host(
    names: set[str], direction: Array, joints: Sequence[Joint], walls: dict[str, Wall]
) -> tuple[Wall, Joint] | None:
    """The first flat wall across the direction that a brick of the group stands on."""
    for joint in joints:
        for name, other in (joint.segments, joint.segments[::-1]):
            wall = walls.get(other)
            if name in names and wall is not None and isinstance(wall.sheet, PlaneSheet):
                if _parallel(wall.sheet.normal, direction) and joint.surface in wall.surface_ids:
                    return wall, joint
    return None


def section_of(topology: Topology, segment: Segment, sheet: PlaneSheet) -> tuple[list[list[Stretch]], PolygonLike]:
    """The outline of a swept brick, carried along its direction to the sheet."""
    along = segment.solid.facets.vertices @ sheet.normal
    middle = 0.5 * float(along.min() + along.max())
    inner = plane_sheet_at(sheet.normal, middle, sheet.u, sheet.v, segment.solid.surfaces)
    rings = section_outline(topology, segment.solid, inner, onto=sheet)
    if not rings:
        raise MeshError(f"{segment.id} ({segment.node}): a swept brick without a section")
    return rings, domain(topology, sheet, rings)


def _swept(segment: Segment, direction: Array, outline: PolygonLike) -> SweptBrick:
    along = segment.solid.facets.vertices @ direction
    return SweptBrick(segment, float(along.min()), float(along.max()), outline)
