"""From segments to one mesh: mid-surfaces joined, curves seeded once, faces, beams and bricks meshed on them.

walls -> crossings -> regions -> outlines and imprints -> curves -> seeds -> faces -> bricks, beams -> ties
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kernel.connect.gaps import near_misses
from kernel.connect.joints import Joint
from kernel.errors import OptionError
from kernel.idealise.arm_cuts import pair_vertices
from kernel.idealise.arms import TeeOf, arm_candidates, extended, stand_off, tee_choice, unused_choices
from kernel.idealise.beam import make_beam
from kernel.idealise.brick import group_bricks
from kernel.idealise.crossings import find_crossings, pinch_notes
from kernel.idealise.footprints import cut_edges, footprint_candidates, lap_candidates, seats
from kernel.idealise.imprints import crossing_candidates, imprint, lay_outlines, outline_candidates
from kernel.idealise.ledger import misfits, unexplained, volume_ledger
from kernel.idealise.parts import Parts
from kernel.idealise.regions import join_walls
from kernel.idealise.tangent_lines import tangent_candidates
from kernel.idealise.topology import BOUNDARY, Curve, Topology
from kernel.idealise.walls import corner_material, make_wall
from kernel.mesh.apart import count_pieces, faces_apart, half_apart, joined_tees, lost_arms, torn, wanted_apart
from kernel.mesh.arms import arm_rows, arm_ties, hung_curves
from kernel.mesh.assembly import Assembly
from kernel.mesh.beam_ties import beam_stations
from kernel.mesh.beams import mesh_beams
from kernel.mesh.bricks import mesh_bricks
from kernel.mesh.chord_loss import least_on_walls
from kernel.mesh.chord_rows import chord_rows, coarse_walls
from kernel.mesh.curve_choice import choose_curves
from kernel.mesh.faces import (
    CurvesByFace,
    FaceMesh,
    FaceTask,
    SeededCurve,
    curves_by_face,
    face_region,
    mesh_all,
    odd_seeds_note,
)
from kernel.mesh.layers import coarser_wishes, host_wishes
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.meshed import Meshed
from kernel.mesh.nodes import NodeTable
from kernel.mesh.options import MeshOptions
from kernel.mesh.planar import GROWTH
from kernel.mesh.second_order import raise_order
from kernel.mesh.seeding import SeedRules, growth_rate, refuse_too_fine, seed_curves
from kernel.mesh.size_field import plan_sizes
from kernel.mesh.ties import make_ties
from kernel.segment.segments import Segment
from kernel.units import VERTEX_TOLERANCE

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated

Progress = Callable[[str, float], None]


def _silent(stage: str, share: float) -> None:
    """Progress that nobody asked for."""


ALWAYS_SECOND_ORDER = ("tet4",)
"""A linear tetrahedron has constant strain and locks in bending: tetrahedra get mid-side nodes whatever the order."""


def assemble(
    evaluated: Evaluated,
    segments: Sequence[Segment],
    joints: Sequence[Joint],
    options: MeshOptions,
    progress: Progress | None = None,
    *,
    apart: Collection[str] = (),
    only: Collection[str] | None = None,
) -> Assembly:
    """Mesh every segment, those that share a curve with shared nodes, and say what must be tied.

    apart: ids of joints across which segments are meshed apart: they meet, but share no nodes and are not tied.
    only: ids of the segments to mesh, each by itself; None for all.
    progress: called with the stage or segment and the share done (0..1). MeshError or ConnectError, naming the
    segments, where something cannot be done.
    """
    report = progress or _silent
    planned = plan_sizes(segments, options, evaluated)
    sizes = planned.by_segment
    torn_joints = wanted_apart(joints, apart)
    if only is not None:
        torn_joints = frozenset(joint.id for joint in joints)
    tee_of = joined_tees(tee_choice(options.tee, options.joint_tees, joints), joints, torn_joints)
    parts = idealise(segments, joints, evaluated.size, options.volumes, tee_of, torn_joints, evaluated.frame)
    joined_choices = {name: tee for name, tee in options.joint_tees.items() if name not in torn_joints}
    parts.warnings += unused_choices(joined_choices, joints, parts.arms)
    parts.warnings += lost_arms(options.tee, options.joint_tees, joints, torn_joints, only)
    parts.warnings += half_apart(parts.walls, joints, torn_joints)
    hangings = pair_vertices(parts.topology, parts.arms, parts.thickest()) if parts.arms else []
    joined = parts.topology.curves()
    ledger = volume_ledger(parts, joined, evaluated.solid.true_volume)  # as joined, whatever is meshed
    parts.warnings += unexplained(ledger, sum(segment.volume for segment in segments))
    pinned = [segment for segment in segments if segment.origin == "override"]
    parts.warnings += [f"{name} {misfit}" for name, misfit in misfits(ledger, pinned).items()]
    every_segment = [segment.id for segment in segments]
    segments = _limited(parts, segments, only)
    report("idealised", 0.2)
    nodes = NodeTable()
    pieces = _apart(joined, parts, joints, torn_joints, only)
    hung = hung_curves(parts.topology, pieces, hangings)
    chosen = choose_curves(options, parts, pieces, evaluated)
    growth = None if options.growth is None else growth_rate(options.growth)
    hosted = host_wishes(parts, pieces, sizes, options.layers, evaluated.size) if options.layers else {}
    parts.warnings += coarser_wishes(parts, pieces, hosted, chosen.walls)
    is_free = options.order == 1 and options.per_circle is None
    fewest = least_on_walls(parts, pieces, sizes) if is_free else {}
    curves = seed_curves(
        parts.topology,
        pieces,
        {wall.index: wall.sheet for wall in parts.walls.values()},
        {wall.index: sizes[wall.segment.id] for wall in parts.walls.values()},
        nodes,
        hung,
        SeedRules({**hosted, **chosen.walls}, growth, options.per_circle, fewest=fewest),
    )
    refuse_too_fine(curves, growth)
    blocks: dict[str, list[ElementBlock]] = {segment.id: [] for segment in segments}
    by_face = curves_by_face(curves)
    faces = _mesh_faces(parts, by_face, sizes, options.faces, growth, options.layers, nodes, report)
    for name, face in faces.items():
        blocks[name] += _blocks(name, face)
    bricks = mesh_bricks(parts, by_face, faces, sizes, options, chosen, nodes, evaluated.frame, report)
    for name, brick in bricks.items():
        blocks[name] += brick.blocks
    for joint in parts.joints:
        beam_stations(parts, joint, sizes)
    lines, seated = mesh_beams(parts, by_face, sizes, chosen.beams, nodes)
    for name, block in lines.items():
        blocks[name].append(block)
    report("meshed", 0.9)
    ties = make_ties(Meshed(parts, by_face, faces, bricks, seated, nodes.points))
    mesh = Mesh(nodes.points, tuple(block for segment in segments for block in blocks[segment.id]))
    raised = None if options.order == 2 else ALWAYS_SECOND_ORDER
    if raised is None or any(block.kind in raised for block in mesh.blocks):
        mesh, ties, drawn = raise_order(mesh, ties, parts, curves, faces, bricks, raised)
        if drawn:
            parts.warnings.append(f"{drawn} mid-side nodes were drawn back from their curves: the elements are coarse")
    chords = chord_rows(parts, by_face, mesh)
    parts.warnings += coarse_walls(chords, sum(segment.volume for segment in segments))
    chains = [seeded.nodes for seeded in curves]
    arms = arm_rows(chains, hung)
    report("tied", 1.0)
    return Assembly(
        segments=tuple(segment for segment in segments if segment.id not in parts.absorbed),
        joints=tuple(joints),
        mesh=mesh,
        sections={name: beam.section for name, beam in parts.beams.items()},
        ties=(*arm_ties(mesh, arms, hung, chains), *ties),
        ledger=(*ledger, *chords),
        curve_uses=_curve_uses(curves),
        arms=arms,
        warnings=(*planned.warnings, *parts.warnings, *near_misses(segments, evaluated, joints)),
        sizes=planned,
        bricks={name: brick.how for name, brick in bricks.items()},
        apart=torn_joints,
        only=None if only is None else frozenset(only),
        pieces=count_pieces(every_segment, joints, torn_joints, [block.segment for block in mesh.blocks]),
    )


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
    topology = Topology(VERTEX_TOLERANCE * size, size, frame)
    parts = Parts(topology, {segment.id: segment for segment in segments}, tuple(joints))
    for segment in segments:
        if segment.type in ("plate", "cylinder_plate"):
            parts.walls[segment.id] = make_wall(topology, len(parts.walls), segment)
    parts.absorbed = corner_material(segments, joints, parts.walls)
    for segment in segments:
        if segment.type == "beam" and segment.id not in parts.absorbed:
            parts.beams[segment.id] = make_beam(segment)
    segments = [segment for segment in segments if segment.id not in parts.absorbed]
    absorbed = set(parts.absorbed)
    joints = parts.joints = tuple(joint for joint in joints if absorbed.isdisjoint(joint.segments))
    parts.warnings += [f"{name} is the material of a corner of walls: it has no elements" for name in parts.absorbed]
    walls = list(parts.walls.values())
    crossings = parts.crossings = find_crossings(topology, walls, joints)
    parts.warnings += pinch_notes(topology, crossings)
    join_walls(topology, walls, crossings, parts.surroundings(crossings))
    parts.arms = stand_off(topology, walls, crossings, tee_of, parts.warnings)
    lay_outlines(topology, walls)
    parts.joints = tuple(joint for joint in joints if joint.id not in apart)
    candidates = [*crossing_candidates(topology, crossings), *outline_candidates(topology, walls, joints)]
    candidates += arm_candidates(parts.arms)
    candidates += [*footprint_candidates(parts), *lap_candidates(parts), *tangent_candidates(parts)]
    axes, parts.seats = seats(parts)
    candidates += axes
    if volumes != "tet":
        parts.sweeps, outlines = group_bricks(segments, parts.joints, parts.walls, topology)
        candidates += outlines
        parts.hosts = {brick.segment.id: group.host for group in parts.sweeps if group.host for brick in group.bricks}
    imprint(topology, candidates)
    cut_edges(parts)
    return parts


def _limited(parts: Parts, segments: Sequence[Segment], only: Collection[str] | None) -> Sequence[Segment]:
    """The segments to mesh; leaves the others' walls, beams and sweeps out of the parts. OptionError: unknown ones."""
    if only is None:
        return segments
    names = [segment.id for segment in segments if segment.id not in parts.absorbed]
    for name in sorted(only):
        if name not in names:
            raise OptionError(f"no segment {name!r} that has elements, expected one of {', '.join(names)}")
    parts.walls = {name: wall for name, wall in parts.walls.items() if name in only}
    parts.beams = {name: beam for name, beam in parts.beams.items() if name in only}
    parts.sweeps = [group for group in parts.sweeps if group.bricks[0].segment.id in only]
    parts.absorbed = ()
    parts.only = frozenset(only)
    return [segment for segment in segments if segment.id in only]


def _apart(
    curves: list[Curve], parts: Parts, joints: Sequence[Joint], apart: Collection[str], only: Collection[str] | None
) -> list[Curve]:
    """The curves, each copied for those of its faces that are to be apart, and without the faces that have no mesh."""
    if not apart and only is None:
        return curves
    by_index = {wall.index: wall.segment.id for wall in parts.walls.values()}
    is_apart = faces_apart(parts, joints, apart)
    copies = torn(parts.topology, curves, list(by_index), is_apart)
    held = {(a, b) for curve in copies for a in curve.uses for b in curve.uses if a < b and is_apart(a, b)}
    parts.warnings += [
        f"{by_index[a]} and {by_index[b]} are to be apart, but a third segment holds them together on a common curve"
        for a, b in sorted(held)
    ]
    return copies


def _mesh_faces(
    parts: Parts,
    by_face: CurvesByFace,
    sizes: dict[str, float],
    kind: str,
    growth: float | None,
    layers: int | None,
    nodes: NodeTable,
    report: Progress,
) -> dict[str, FaceMesh]:
    tasks = []
    hosting = {wall.segment.id for wall, _ in parts.hosts.values()}
    for name, wall in parts.walls.items():
        label = f"{name} ({wall.segment.node})"
        region, numbers = face_region(wall.index, wall.sheet, by_face[wall.index], nodes.points)
        rate = growth if layers is None or name not in hosting else min(growth or GROWTH, 1 / layers)
        tasks.append(FaceTask(label, wall.sheet, region, numbers, sizes[name], kind, rate, parts.topology.frame))
    faces = {}
    meshes = zip(parts.walls.items(), tasks, mesh_all(tasks))
    for number, ((name, wall), task, mesh) in enumerate(meshes, start=1):
        face = faces[name] = task.lay(mesh, nodes)
        parts.warnings += odd_seeds_note(task.name, by_face[wall.index], kind, len(face.triangles), "triangles")
        report(name, 0.2 + 0.6 * number / len(parts.walls))
    return faces


def _blocks(name: str, face: FaceMesh) -> list[ElementBlock]:
    found = []
    if len(face.quads):
        found.append(ElementBlock(name, "quad4", face.quads))
    if len(face.triangles):
        found.append(ElementBlock(name, "tri3", face.triangles))
    return found


def _curve_uses(curves: Sequence[SeededCurve]) -> np.ndarray:
    rows = []
    for seeded in curves:
        expected = sum(1 if use.role == BOUNDARY else 2 for use in seeded.curve.uses.values())
        rows += [(a, b, expected) for a, b in zip(seeded.nodes[:-1].tolist(), seeded.nodes[1:].tolist())]
    return np.array(rows, dtype=np.int64).reshape(-1, 3)
