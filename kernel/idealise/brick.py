"""Bricks that are swept: those of one direction that stand on one another share one section, and so their nodes.

    direction ^   +-----+            levels: every start and end of a piece, divided between
              |   |  b  |
              |   +-----+---+        section: all outlines drawn in one plane; they part it into cells, and a piece
              |   |    a    |        takes the elements of the cells within its own outline
              |   +---------+

A brick is one piece, or a stack of them where its section changes at levels across the direction. A group that stands
on a plate, swept along the plate's normal, takes the plate's own elements for its section.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint, joints_by_segment
from kernel.errors import MeshError
from kernel.idealise.cells import Cell, cells_of, curves_of_cells
from kernel.idealise.footprints import foot_sides, footprint, grazes_edge
from kernel.idealise.imprints import Candidate, imprint, lay_outlines
from kernel.idealise.outlines import PolygonLike, Stretch, domain
from kernel.idealise.roundness import roundness
from kernel.idealise.sheets import PlaneSheet, plane_sheet_at
from kernel.idealise.topology import Curve, Topology
from kernel.idealise.walls import Wall, section_outline
from kernel.segment.prism import sweeps
from kernel.segment.segments import BrickShape, Segment
from kernel.segment.stack import layers_along
from kernel.solid.surfaces import CylinderSurface, Plane, Surface, plane_frame
from kernel.units import ANGLE_TOLERANCE

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Piece:
    """A prism: from start to end along the direction, within `outline` of the section's frame."""

    start: float
    end: float
    outline: PolygonLike


@dataclass(frozen=True, slots=True, eq=False)
class SweptBrick:
    """One brick of a group, as the pieces of its stack, lowest first."""

    segment: Segment
    pieces: tuple[Piece, ...]


@dataclass(frozen=True, slots=True, eq=False)
class OwnSection:
    """A section parted into cells. curves: used by the cells, numbered by their place in the list.

    roundness: by carrier of a circle, see roundness.py; the largest of the outlines that it bounds.
    """

    topology: Topology
    curves: list[Curve]
    cells: list[Cell]
    roundness: dict[int, float] = field(default_factory=dict)


@dataclass(slots=True, eq=False)
class SweepGroup:
    """Bricks swept along one direction. sheet: the section's plane.

    host: the wall whose elements are swept, with the joint, or None where the group has a section of its own.
    roundness: of the circles that a group with a host imprints in it, by carrier; see roundness.py.
    """

    direction: Array
    sheet: PlaneSheet
    bricks: list[SweptBrick]
    section: OwnSection | None = None
    host: tuple[Wall, Joint] | None = None
    roundness: dict[int, float] = field(default_factory=dict)


def _parallel(a: Array, b: Array) -> bool:
    return bool(np.linalg.norm(np.cross(a, b)) < 4 * ANGLE_TOLERANCE)


def _across(segment: Segment, joint: Joint, direction: Array) -> bool:
    """Whether the joint lies in a plane across the direction."""
    surface = segment.solid.surfaces.surfaces[joint.surface]
    return isinstance(surface, Plane) and _parallel(surface.normal, direction)


def _is_upright(segment: Segment, joint: Joint, direction: Array) -> bool:
    """Whether a foot may be carried along the direction: a leaning segment's own sides would carry it elsewhere."""
    surfaces = segment.solid.surfaces.surfaces
    return all(
        _is_round_side(surfaces[label], direction) or _is_flat_side(surfaces[label], direction)
        for label in foot_sides(segment, joint)
    )


def _is_flat_side(surface: Surface, direction: Array) -> bool:
    return isinstance(surface, Plane) and abs(float(surface.normal @ direction)) < 4 * ANGLE_TOLERANCE


def _is_round_side(surface: Surface, direction: Array) -> bool:
    return isinstance(surface, CylinderSurface) and _parallel(surface.axis.direction, direction)


def sweep_directions(segments: Sequence[Segment], joints: Sequence[Joint], walls: dict[str, Wall]) -> dict[str, Array]:
    """By segment id, the direction along which each brick is swept; bricks that cannot be are not in it.

    Of several (a block has three) the one across which most of its contacts lie, with walls that it may stand on and
    with bricks that can be swept the same way; without such contacts, the shape's own: that of the fewest layers.
    """
    bricks = [segment for segment in segments if isinstance(segment.shape, BrickShape)]
    options = {segment.id: directions for segment in bricks if (directions := stack_directions(segment))}
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
                stands = wall is not None and joint.surface_of(other) in wall.surface_ids
                if stands or any(_parallel(direction, mate) for mate in options.get(other, [])):
                    weights[place] += joint.area
        found[name] = directions[int(np.argmax(weights))]
    return found


def stack_directions(segment: Segment) -> list[Array]:
    """Directions along which the segment's solid is a prism, or where there are none, a stack of prisms.

    Stacks of few layers come first.
    """
    assert isinstance(segment.shape, BrickShape)
    tried = sweeps(segment.solid)
    exact = [sweep.direction for sweep in tried if sweep.is_exact]
    if segment.shape.sweep is not None:
        return [_upward(direction) for direction in (segment.shape.sweep, *exact)]
    stacks = [(layers_along(segment.solid, sweep.direction), sweep.direction) for sweep in tried]
    ordered = sorted((stack for stack in stacks if stack[0]), key=lambda stack: len(stack[0]))
    return [_upward(direction) for _, direction in ordered]


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
    if host is not None:
        wall = host[0]
        assert isinstance(wall.sheet, PlaneSheet)
        bricks, rings, round_shares = _pieces(topology, segments, wall.sheet)
        is_inside = wall.region.buffer(30 * topology.tolerance).covers(_union(bricks))
        if is_inside and not any(grazes_edge(topology, wall, ring) for ring in rings):
            group = SweepGroup(wall.sheet.normal, wall.sheet, bricks, host=host, roundness=round_shares)
            return group, [Candidate(wall, stretch) for ring in rings for stretch in ring]
    frame = plane_frame(direction)
    start = min(float((segment.solid.facets.vertices @ direction).min()) for segment in segments)
    sheet = plane_sheet_at(direction, start, frame.u, frame.v, segments[0].solid.surfaces)
    own = Topology(topology.tolerance, topology.carriers.reach, topology.frame)
    bricks, rings, round_shares = _pieces(own, segments, sheet)
    feet = []
    for joint in joints:
        for name, other in (joint.segments, joint.segments[::-1]):
            if name in names and other not in names and _across(by_id[name], joint, direction):
                if _is_upright(by_id[other], joint, direction):
                    feet += footprint(own, sheet, by_id[other], joint)
    section = replace(_own_section(own, sheet, bricks, rings, feet), roundness=round_shares)
    return SweepGroup(direction, sheet, bricks, section=section), []


def _pieces(
    topology: Topology, segments: Sequence[Segment], sheet: PlaneSheet
) -> tuple[list[SweptBrick], list[list[Stretch]], dict[int, float]]:
    """The bricks with their pieces along the sheet's normal, the rings of all outlines, on the sheet, and the circles'
    roundness by carrier.
    """
    bricks, rings = [], []
    round_shares: dict[int, float] = {}
    for segment in segments:
        pieces = []
        for start, end in layers_along(segment.solid, sheet.normal):
            outline, polygon = section_of(topology, segment, sheet, 0.5 * (start + end))
            rings += outline
            for carrier, share in roundness(topology, sheet, outline, polygon.area).items():
                round_shares[carrier] = max(round_shares.get(carrier, 0.0), share)
            pieces.append(Piece(start, end, polygon))
        if not pieces:
            raise MeshError(f"{segment.id} ({segment.node}): a swept brick without a section")
        bricks.append(SweptBrick(segment, tuple(pieces)))
    return bricks, rings, round_shares


def _union(bricks: Sequence[SweptBrick], grid: float | None = None) -> PolygonLike:
    """All outlines of the bricks as one region."""
    outlines = [piece.outline for brick in bricks for piece in brick.pieces]
    return shapely.union_all(outlines) if grid is None else shapely.union_all(outlines, grid_size=grid)


def _own_section(
    topology: Topology,
    sheet: PlaneSheet,
    bricks: Sequence[SweptBrick],
    rings: Sequence[list[Stretch]],
    feet: Sequence[list[Stretch]],
) -> OwnSection:
    """The section of a group: cells between all outlines, and between the feet of what stands on it."""
    region = _union(bricks, 1e-7 * topology.carriers.reach)
    face = Wall(0, bricks[0].segment, sheet, 0.0, [], region, [], region)
    n_piece = sum(len(brick.pieces) for brick in bricks)
    if n_piece == 1:
        face.outline = [stretch for ring in rings for stretch in ring]
        lay_outlines(topology, [face])
    drawn = [*(rings if n_piece > 1 else ()), *feet]
    imprint(topology, [Candidate(face, stretch) for ring in drawn for stretch in ring])
    curves = topology.curves()
    inside = [cell for cell in cells_of(topology, sheet, curves) if shapely.contains_xy(region, *cell.inner_point)]
    return OwnSection(topology, curves_of_cells(curves, inside), inside)


def _host(
    names: set[str], direction: Array, joints: Sequence[Joint], walls: dict[str, Wall]
) -> tuple[Wall, Joint] | None:
    """The first flat wall across the direction that a brick of the group stands on."""
    for joint in joints:
        for name, other in (joint.segments, joint.segments[::-1]):
            wall = walls.get(other)
            if name in names and wall is not None and isinstance(wall.sheet, PlaneSheet):
                if _parallel(wall.sheet.normal, direction) and joint.surface_of(other) in wall.surface_ids:
                    return wall, joint
    return None


def section_of(
    topology: Topology, segment: Segment, sheet: PlaneSheet, offset: float
) -> tuple[list[list[Stretch]], PolygonLike]:
    """The outline of a brick where sheet.normal . x = offset, carried along the normal to the sheet."""
    inner = plane_sheet_at(sheet.normal, offset, sheet.u, sheet.v, segment.solid.surfaces)
    rings = section_outline(topology, segment.solid, inner, onto=sheet)
    if not rings:
        raise MeshError(f"{segment.id} ({segment.node}): a swept brick without a section")
    return rings, domain(topology, sheet, rings)
