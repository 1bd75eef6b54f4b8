"""From segments to one mesh: parts idealised, curves seeded once, faces, bricks and beams meshed on them, ties.

idealised parts -> curves -> seeds -> faces -> bricks -> beams -> ties -> order -> ledger
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from kernel.connect.gaps import near_misses
from kernel.connect.joints import Joint
from kernel.errors import OptionError
from kernel.idealise.arm_cuts import pair_vertices
from kernel.idealise.arms import tee_choice, unused_choices
from kernel.idealise.idealise import idealise
from kernel.idealise.ledger import misfits, unexplained, volume_ledger
from kernel.idealise.ledger_row import LedgerRow
from kernel.idealise.parts import Parts
from kernel.idealise.topology import BOUNDARY, Curve
from kernel.mesh.apart import count_pieces, faces_apart, half_apart, joined_tees, lost_arms, torn, wanted_apart
from kernel.mesh.arms import HungCurve, arm_rows, arm_ties, hung_curves
from kernel.mesh.assembly import Assembly
from kernel.mesh.beam_ties import beam_stations
from kernel.mesh.beams import mesh_beams
from kernel.mesh.bricks import BrickMesh, mesh_bricks
from kernel.mesh.chord_loss import least_on_walls
from kernel.mesh.chord_rows import chord_rows, coarse_walls
from kernel.mesh.curve_choice import ChosenCurves, choose_curves
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

    parts = _idealised(segments, joints, options, evaluated, torn_joints, only)
    hangings = pair_vertices(parts.topology, parts.arms, parts.thickest()) if parts.arms else []
    joined = parts.topology.curves()
    ledger = _ledger(parts, joined, segments, evaluated)  # as joined, whatever is meshed
    every_segment = [segment.id for segment in segments]
    segments = _limited(parts, segments, only)
    report("idealised", 0.2)

    nodes = NodeTable()
    pieces = _apart(joined, parts, joints, torn_joints, only)
    hung = hung_curves(parts.topology, pieces, hangings)
    chosen = choose_curves(options, parts, pieces, evaluated)
    curves = _seeded(parts, pieces, hung, sizes, chosen, options, nodes, evaluated.size)
    by_face = curves_by_face(curves)

    faces = _mesh_faces(parts, by_face, sizes, options, nodes, report)
    bricks = mesh_bricks(parts, by_face, faces, sizes, options, chosen, nodes, evaluated.frame, report)
    for joint in parts.joints:
        beam_stations(parts, joint, sizes)
    lines, seated = mesh_beams(parts, by_face, sizes, chosen.beams, nodes)
    report("meshed", 0.9)

    ties = make_ties(Meshed(parts, by_face, faces, bricks, seated, nodes.points))
    mesh = Mesh(nodes.points, _blocks(segments, faces, bricks, lines))
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


def _idealised(
    segments: Sequence[Segment],
    joints: Sequence[Joint],
    options: MeshOptions,
    evaluated: Evaluated,
    torn_joints: Collection[str],
    only: Collection[str] | None,
) -> Parts:
    """The idealised parts, with a warning of every choice for a joint that another one leaves without effect."""
    tee_of = joined_tees(tee_choice(options.tee, options.joint_tees, joints), joints, torn_joints)
    parts = idealise(segments, joints, evaluated.size, options.volumes, tee_of, torn_joints, evaluated.frame)
    joined_choices = {name: tee for name, tee in options.joint_tees.items() if name not in torn_joints}
    parts.warnings += unused_choices(joined_choices, joints, parts.arms)
    parts.warnings += lost_arms(options.tee, options.joint_tees, joints, torn_joints, only)
    parts.warnings += half_apart(parts.walls, joints, torn_joints)
    return parts


def _ledger(
    parts: Parts, curves: Sequence[Curve], segments: Sequence[Segment], evaluated: Evaluated
) -> tuple[LedgerRow, ...]:
    """What the parts count otherwise than the solid has it.

    Warned of are rows of no closed form, and walls that a user asked for whose thickness is not their material's.
    """
    ledger = volume_ledger(parts, curves, evaluated.solid.true_volume)
    parts.warnings += unexplained(ledger, sum(segment.volume for segment in segments))
    pinned = [segment for segment in segments if segment.origin == "override"]
    parts.warnings += [f"{name} {misfit}" for name, misfit in misfits(ledger, pinned).items()]
    return ledger


def _seeded(
    parts: Parts,
    pieces: Sequence[Curve],
    hung: Sequence[HungCurve],
    sizes: dict[str, float],
    chosen: ChosenCurves,
    options: MeshOptions,
    nodes: NodeTable,
    size: float,
) -> list[SeededCurve]:
    """Every curve divided once, by the sizes of the walls on it and by what the user asked of it. size: the model's."""
    growth = None if options.growth is None else growth_rate(options.growth)
    hosted = host_wishes(parts, pieces, sizes, options.layers, size) if options.layers else {}
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
    return curves


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
    options: MeshOptions,
    nodes: NodeTable,
    report: Progress,
) -> dict[str, FaceMesh]:
    """Every wall's elements, by segment id; finer by and by towards curves where bricks with layers stand on it."""
    growth = None if options.growth is None else growth_rate(options.growth)
    kind, layers = options.faces, options.layers
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


def _blocks(
    segments: Sequence[Segment],
    faces: Mapping[str, FaceMesh],
    bricks: Mapping[str, BrickMesh],
    lines: Mapping[str, ElementBlock],
) -> tuple[ElementBlock, ...]:
    """The elements of every segment, in the segments' order."""
    blocks: dict[str, list[ElementBlock]] = {segment.id: [] for segment in segments}
    for name, face in faces.items():
        own = (("quad4", face.quads), ("tri3", face.triangles))
        blocks[name] += [ElementBlock(name, kind, rows) for kind, rows in own if len(rows)]
    for name, brick in bricks.items():
        blocks[name] += brick.blocks
    for name, line in lines.items():
        blocks[name].append(line)
    return tuple(block for segment in segments for block in blocks[segment.id])


def _curve_uses(curves: Sequence[SeededCurve]) -> np.ndarray:
    rows = []
    for seeded in curves:
        expected = sum(1 if use.role == BOUNDARY else 2 for use in seeded.curve.uses.values())
        rows += [(a, b, expected) for a, b in zip(seeded.nodes[:-1].tolist(), seeded.nodes[1:].tolist())]
    return np.array(rows, dtype=np.int64).reshape(-1, 3)
