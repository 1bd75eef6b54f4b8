"""Bricks: sections swept to hexahedra and wedges, everything else tetrahedra."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.idealise.brick import SweepGroup, SweptBrick
from kernel.idealise.parts import Parts
from kernel.idealise.revolved import revolved_brick
from kernel.idealise.walls import Wall
from kernel.mesh.chord_loss import CHORD_LOSS
from kernel.mesh.curve_choice import ChosenCurves
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.faces import CurvesByFace, FaceMesh, curve_middles
from kernel.mesh.layers import fewer_levels, layered_size, level_wishes
from kernel.mesh.mesh import ElementBlock
from kernel.mesh.method import not_a_stack, swept_text, turned_text
from kernel.mesh.nodes import NodeTable
from kernel.mesh.options import MeshOptions
from kernel.mesh.region import RegionMesh
from kernel.mesh.revolve import mesh_revolved
from kernel.mesh.section import mesh_section
from kernel.mesh.seeding import SeedRules, growth_rate
from kernel.mesh.sweep import UnfitSweep, divide_levels, sweep
from kernel.places import place_text
from kernel.segment.segments import Segment

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class BrickMesh:
    """blocks: of one brick. pairs: (n, 2) its nodes and the host wall's nodes that they stand on.

    edges: (e, 2) boundary edges of tets as node pairs; middles: (e, 3) their mid-side nodes on the true surfaces.
    how: it was meshed, and why so, in words.
    """

    blocks: tuple[ElementBlock, ...]
    pairs: Indices
    edges: Indices = field(default_factory=lambda: np.empty((0, 2), np.int64))
    middles: Array = field(default_factory=lambda: np.empty((0, 3)))
    how: str = ""


def mesh_bricks(
    parts: Parts,
    curves: CurvesByFace,
    faces: dict[str, FaceMesh],
    sizes: dict[str, float],
    options: MeshOptions,
    chosen: ChosenCurves,
    nodes: NodeTable,
    frame: Array,
    report: Callable[[str, float], None],
) -> dict[str, BrickMesh]:
    """Every brick's elements, by segment id. curves, faces: of the walls, meshed already.

    frame: (3, 3), user's point = frame @ working point, for what is said. report: called with each segment that is
    meshed with tetrahedra, and the share of the meshing done. MeshError: hexahedra alone are asked for
    and a brick cannot be swept; or the tetrahedra failed.
    """
    meshes: dict[str, BrickMesh] = {}
    if options.layers is not None and not any(segment.type == "brick" for segment in parts.segments.values()):
        parts.warnings.append("layers: no segment is a brick, so there is nothing to have layers")
    why: dict[str, str] = {}
    growth = None if options.growth is None else growth_rate(options.growth)
    loss = CHORD_LOSS if options.order == 1 else None
    for number, group in enumerate(parts.sweeps):
        size = min(sizes[brick.segment.id] for brick in group.bricks)
        rules = SeedRules(chosen.sections.get(number, {}), growth, options.per_circle, options.layers)
        wishes = level_wishes(group, chosen.rises.get(number, {}), options.layers)
        try:
            section = _section_of(parts, group, curves, faces, size, options.faces, rules, loss)
            pieces = [piece for brick in group.bricks for piece in brick.pieces]
            levels = divide_levels([value for piece in pieces for value in (piece.start, piece.end)], size, wishes)
            meshes.update(_sweep_group(group, section, levels, nodes, frame))
            parts.warnings += fewer_levels(group, levels, wishes, options.layers, frame)
        except MeshError as error:
            why.update(dict.fromkeys((brick.segment.id for brick in group.bricks), _told(error, frame)))
            if number in chosen.sections or number in chosen.rises:
                names = ", ".join(brick.segment.id for brick in group.bricks)
                parts.warnings.append(f"{names}: what is asked of its curves does not hold for tetrahedra")
    for name, segment in parts.segments.items():
        is_left_out = name in parts.absorbed or (parts.only is not None and name not in parts.only)
        if segment.type == "brick" and name not in meshes and not is_left_out:
            if options.volumes != "tet":
                rules = SeedRules(growth=growth, per_circle=options.per_circle, layers=options.layers)
                turned = _turned(parts, segment, sizes[name], options, nodes, frame, rules)
                if turned is not None:
                    meshes[name] = turned
                    continue
            reason = "asked for" if options.volumes == "tet" else why.get(name) or not_a_stack(segment, frame)
            if options.volumes == "hex":
                raise MeshError(f"{name} ({segment.node}) cannot be meshed with hexahedra only: {reason}")
            if name in why:
                parts.warnings.append(f"{name} ({segment.node}) is not swept but meshed with tetrahedra: {reason}")
            size = sizes[name]
            if options.layers is not None:
                size, told = layered_size(segment, size, options.layers, frame)
                parts.warnings += [told] if told else []
            report(f"{name} tetrahedra", 0.8)
            meshes[name] = _tetrahedra(segment, size, options.deadline, nodes, f"tetrahedra: {reason}")
    return meshes


def _told(error: MeshError, frame: Array) -> str:
    """What is wrong, and where that is known. frame: see mesh_bricks."""
    return f"{error.message} near {place_text(frame @ error.at)}" if isinstance(error, UnfitSweep) else error.message


# ---------------------------------------------------------------- sections


@dataclass(frozen=True, slots=True, eq=False)
class _Section:
    """A meshed section in its sheet's frame. wall_nodes: (n,) the host wall's node at each point; empty without host.

    edges: (e, 2) points on curves that are not straight, middles: (e, 3) places amid them, on the sheet.
    inner: (n_element,) a shapely point for each element, quads first, that tells what outline it lies in: amid its
    cell, or amid itself.
    """

    mesh: RegionMesh
    wall_nodes: Indices
    edges: Indices
    middles: Array
    inner: NDArray[np.object_]


def _section_of(
    parts: Parts,
    group: SweepGroup,
    curves: CurvesByFace,
    faces: dict[str, FaceMesh],
    size: float,
    kind: str,
    rules: SeedRules,
    loss: float | None,
) -> _Section:
    """The group's own section, or the elements of the wall that it stands on."""
    if group.section is None:
        assert group.host is not None
        return _host_section(parts, group.host[0], curves, faces[group.host[0].segment.id])
    names = ", ".join(f"{brick.segment.id} ({brick.segment.node})" for brick in group.bricks)
    own = mesh_section(names, group.section, group.sheet, size, kind, rules, loss)
    parts.warnings += own.notes
    cells = shapely.points([cell.inner_point for cell in group.section.cells])
    return _Section(own.mesh, np.empty(0, np.int64), own.edges, own.middles, cells[own.cell_of])


def _host_section(parts: Parts, wall: Wall, curves: CurvesByFace, face: FaceMesh) -> _Section:
    """The elements of the wall that the group stands on."""
    order = np.argsort(face.nodes)

    def local(numbers: Indices) -> Indices:
        return order[np.searchsorted(face.nodes[order], numbers)]

    edges, middles = curve_middles(parts.topology, curves.get(wall.index, []))
    mesh = RegionMesh(face.flat, local(face.quads), local(face.triangles))
    centres = np.concatenate([mesh.points[mesh.quads].mean(axis=1), mesh.points[mesh.triangles].mean(axis=1)])
    return _Section(mesh, face.nodes, local(edges), middles, shapely.points(centres))


# ---------------------------------------------------------------- sweeping


def _sweep_group(
    group: SweepGroup,
    section: _Section,
    levels: Array,
    nodes: NodeTable,
    frame: Array,
) -> dict[str, BrickMesh]:
    """The bricks of a group through levels (n_level,); where they stand on one another they share nodes.

    UnfitSweep: a piece of one holds no element, or an element would be flat or inverted; no node is added then.
    """

    def lift(flat: Array, level: float) -> Array:
        return group.sheet.lift(flat) + group.sheet.normal * (level - group.sheet.offset)

    mesh = section.mesh
    elements = [*mesh.quads, *mesh.triangles]
    layer = 0.5 * (levels[:-1] + levels[1:])
    held = {}
    for brick in group.bricks:
        own = np.zeros((len(layer), len(elements)), dtype=bool)
        for piece in brick.pieces:
            inside = shapely.contains(piece.outline, section.inner)
            if not inside.any():
                said = (
                    f"a piece of {brick.segment.id} ({brick.segment.node}) is too narrow for an element of the section"
                )
                raise UnfitSweep(said, lift(_inner_point(piece.outline), 0.5 * (piece.start + piece.end))[0])
            own |= ((layer > piece.start) & (layer < piece.end))[:, None] & inside[None, :]
        held[brick.segment.id] = own
    present = np.logical_or.reduce(list(held.values()))
    points, hexes, wedges = sweep(mesh, lift, levels, present=present)
    numbers = nodes.add(points)
    at = np.full((len(levels), len(mesh.points)), -1, dtype=np.int64)
    used = _used(present, elements, at.shape)
    at[used] = numbers
    n_quad = len(mesh.quads)
    meshes = {}
    for brick in group.bricks:
        chosen = held[brick.segment.id]
        blocks = []
        for kind, swept, columns in (
            ("hex8", hexes, slice(None, n_quad)),
            ("wedge6", wedges, slice(n_quad, None)),
        ):
            own = swept[chosen[:, columns][present[:, columns]]]
            if len(own):
                blocks.append(ElementBlock(brick.segment.id, kind, numbers[own]))
        reach = _used(chosen, elements, at.shape)
        edges, middles = _level_middles(group, section, levels, np.where(reach, at, -1))
        pairs = _pairs(group, brick, section, levels, np.where(reach, at, -1))
        how = swept_text(group, brick, [block.kind for block in blocks], int(chosen.any(axis=1).sum()), frame)
        meshes[brick.segment.id] = BrickMesh(tuple(blocks), pairs, edges, middles, how)
    return meshes


def _inner_point(outline: shapely.Geometry) -> Array:
    """A point (1, 2) within an outline."""
    point: Array = shapely.get_coordinates(outline.representative_point())
    return point


def _used(present: NDArray[np.bool_], elements: Sequence[Indices], shape: tuple[int, int]) -> NDArray[np.bool_]:
    """(n_level, n_point) True where a node of a present element stands."""
    used = np.zeros(shape, dtype=bool)
    for layer in range(len(present)):
        chosen = [elements[place] for place in np.nonzero(present[layer])[0].tolist()]
        if chosen:
            points = np.unique(np.concatenate(chosen))
            used[layer, points] = used[layer + 1, points] = True
    return used


def _level_middles(group: SweepGroup, section: _Section, levels: Array, at: Indices) -> tuple[Indices, Array]:
    """Edges of the swept bricks on curved sides, across the direction, and the places amid them."""
    edges, middles = [np.empty((0, 2), np.int64)], [np.empty((0, 3))]
    for level, offset in enumerate(levels):
        pairs = at[level][section.edges]
        there = (pairs >= 0).all(axis=1)
        edges.append(pairs[there])
        middles.append(section.middles[there] + group.sheet.normal * (offset - group.sheet.offset))
    return np.concatenate(edges), np.concatenate(middles)


def _pairs(group: SweepGroup, brick: SweptBrick, section: _Section, levels: Array, at: Indices) -> Indices:
    """The brick's nodes on the host's face, each with the wall's node below or above it."""
    if group.host is None or brick.segment.id not in group.host[1].segments:
        return np.empty((0, 2), np.int64)
    level = int(np.argmin(np.abs(levels - float(group.host[1].centre @ group.sheet.normal))))
    points = np.nonzero(at[level] >= 0)[0]
    return np.stack([at[level][points], section.wall_nodes[points]], axis=1)


def _turned(
    parts: Parts,
    segment: Segment,
    size: float,
    options: MeshOptions,
    nodes: NodeTable,
    frame: Array,
    rules: SeedRules,
) -> BrickMesh | None:
    """A solid of revolution turned about its axis; None where it is none, or would be meshed badly so."""
    try:
        topology = parts.topology
        brick = revolved_brick(segment, topology.tolerance, topology.carriers.reach, topology.frame)
        if brick is None:
            return None
        body = mesh_revolved(brick, size, options.faces, options.order, rules)
    except MeshError as error:
        parts.warnings.append(f"{segment.id} ({segment.node}) is not turned about its axis: {_told(error, frame)}")
        return None
    numbers = nodes.add(body.nodes)
    blocks = [
        ElementBlock(segment.id, kind, numbers[elements])
        for kind, elements in (("hex8", body.hexes), ("wedge6", body.wedges))
        if len(elements)
    ]
    how = turned_text(brick.axis.direction, [block.kind for block in blocks], body.n_turn, frame)
    return BrickMesh(tuple(blocks), np.empty((0, 2), np.int64), numbers[body.edges], body.middles, how)


def _tetrahedra(segment: Segment, size: float, deadline: float, nodes: NodeTable, how: str) -> BrickMesh:
    from kernel.mesh.solid_tets import mesh_solid

    try:
        body = mesh_solid(segment.solid, size, deadline=deadline)
    except MeshError as error:
        raise MeshError(f"{segment.id} ({segment.node}): {error.message}") from error
    numbers = nodes.add(body.nodes)
    block = ElementBlock(segment.id, "tet4", numbers[body.tets])
    if body.left:
        how += f"; {body.left} of their nodes stand beside the solid's surface, where no room was to move them"
    return BrickMesh((block,), np.empty((0, 2), np.int64), numbers[body.edges], body.middles, how)


def outer_faces(blocks: Sequence[ElementBlock]) -> list[Indices]:
    """Faces that belong to one element only, as arrays (n, 3) of triangles and (m, 4) of quads, corners only."""
    by_corners: dict[int, list[Indices]] = {3: [], 4: []}
    for block in blocks:
        kind = ELEMENT_KINDS[block.kind]
        for corners in kind.faces:
            by_corners[len(corners)].append(block.connectivity[:, list(corners)])
    found = []
    for count in (3, 4):
        if not by_corners[count]:
            found.append(np.empty((0, count), np.int64))
            continue
        faces = np.concatenate(by_corners[count])
        _, first, times = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        found.append(faces[np.sort(first[times == 1])])
    return found
