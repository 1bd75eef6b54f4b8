"""From segments to idealised parts: mid-surfaces joined, axes, sections, and all that is imprinted on faces.

walls -> crossings -> regions -> arms -> outlines -> imprints of joints, beams, laps and bricks
"""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from kernel.connect.joints import Joint
from kernel.idealise.arms import TeeOf, arm_candidates, extended, stand_off
from kernel.idealise.beam import make_beam
from kernel.idealise.brick import group_bricks
from kernel.idealise.crossings import CURVED_OVERLAP
from kernel.idealise.footprints import cut_edges, footprint_candidates, lap_candidates, seats
from kernel.idealise.imprints import crossing_candidates, imprint, lay_outlines, outline_candidates
from kernel.idealise.joint_curves import find_crossings, pinch_notes
from kernel.idealise.parts import Parts
from kernel.idealise.regions import joined_regions, lay_regions
from kernel.idealise.stubs import colliding_stubs, stub_notes, without_inner, without_stubs
from kernel.idealise.tangent_lines import line_notes, tangent_candidates
from kernel.idealise.topology import Topology
from kernel.idealise.walls import corner_material, make_wall, refuse_lost
from kernel.segment.segments import Segment
from kernel.units import VERTEX_TOLERANCE

CHORD = 0.5 * CURVED_OVERLAP
"""Share of the thinnest wall by which polylines may miss their curves: two of them stay within what strips overlap."""


def idealise(
    segments: Sequence[Segment],
    joints: Sequence[Joint],
    size: float,
    volumes: str = "auto",
    tee_of: TeeOf = extended,
    apart: Collection[str] = (),
    frame: np.ndarray | None = None,
) -> Parts:
    """Walls joined to one topology with all their imprints, beams with their axes, swept bricks in groups.

    size: the model's. volumes: as in MeshOptions. tee_of: how the tees of two segments are made. apart: joints that
    only walls take notice of, whose mid-surfaces meet there. frame: as in Topology.
    """
    thinnest = min((segment.thickness for segment in segments if segment.thickness is not None), default=np.inf)
    topology = Topology(VERTEX_TOLERANCE * size, size, frame, CHORD * thinnest)
    parts = Parts(topology, {segment.id: segment for segment in segments}, tuple(joints))
    beside: dict[str, list[Segment]] = {segment.id: [] for segment in segments}
    for joint in joints:
        if joint.kind != "lap":
            for name, other in (joint.segments, joint.segments[::-1]):
                beside[name].append(parts.segments[other])
    lost: list[str] = []
    for segment in segments:
        if segment.type in ("plate", "cylinder_plate"):
            wall = make_wall(topology, len(parts.walls), segment, beside[segment.id])
            if wall is None:
                lost.append(segment.id)
            else:
                parts.walls[segment.id] = wall
    refuse_lost(segments, lost, joints, parts.walls)
    corners = corner_material(segments, joints, parts.walls)
    parts.absorbed = tuple(segment.id for segment in segments if segment.id in corners or segment.id in lost)
    for segment in segments:
        if segment.type == "beam" and segment.id not in parts.absorbed:
            parts.beams[segment.id] = make_beam(segment)
    segments = [segment for segment in segments if segment.id not in parts.absorbed]
    absorbed = set(parts.absorbed)
    joints = parts.joints = tuple(joint for joint in joints if absorbed.isdisjoint(joint.segments))
    for name in parts.absorbed:
        what = "a crumb that walls have left beside themselves" if name in lost else "the material of a corner of walls"
        parts.warnings.append(f"{name} is {what}: it has no elements")
    walls = list(parts.walls.values())
    crossings = parts.crossings = find_crossings(topology, walls, joints)
    parts.warnings += pinch_notes(topology, crossings)
    regions = joined_regions(topology, walls, crossings, parts.surroundings(crossings))
    parts.stubs = colliding_stubs(topology, crossings, regions)
    parts.warnings += stub_notes(parts.stubs)
    joints = parts.joints = without_inner(joints, parts.stubs)
    lay_regions(topology, walls, crossings, without_stubs(regions, parts.stubs))
    parts.arms = stand_off(topology, walls, crossings, tee_of, parts.warnings)
    lay_outlines(topology, walls)
    parts.joints = tuple(joint for joint in joints if joint.id not in apart)
    candidates = [*crossing_candidates(topology, crossings), *outline_candidates(topology, walls, joints)]
    candidates += arm_candidates(parts.arms)
    candidates += [*footprint_candidates(parts), *lap_candidates(parts), *tangent_candidates(parts)]
    parts.warnings += line_notes(parts)
    axes, parts.seats = seats(parts)
    candidates += axes
    if volumes != "tet":
        parts.sweeps, outlines = group_bricks(segments, parts.joints, parts.walls, topology)
        candidates += outlines
        parts.hosts = {brick.segment.id: group.host for group in parts.sweeps if group.host for brick in group.bricks}
    imprint(topology, candidates)
    cut_edges(parts)
    return parts
