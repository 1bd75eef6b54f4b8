"""Bricks: sections swept to hexahedra and wedges, everything else tetrahedra."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.idealise.brick import SweepGroup, SweptBrick
from kernel.idealise.parts import Parts
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.faces import FaceMesh, SeededCurve, mesh_face, seed_curves
from kernel.mesh.mesh import ElementBlock
from kernel.mesh.nodes import NodeTable
from kernel.mesh.options import MeshOptions
from kernel.segment.segments import Segment

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class BrickMesh:
    """blocks: of one brick. pairs: (n, 2) its nodes and the host wall's nodes that they stand on.

    edges: (e, 2) boundary edges of tets as node pairs; middles: (e, 3) their mid-side nodes on the true surfaces.
    """

    blocks: tuple[ElementBlock, ...]
    pairs: Indices
    edges: Indices = field(default_factory=lambda: np.empty((0, 2), np.int64))
    middles: Array = field(default_factory=lambda: np.empty((0, 3)))


def mesh_bricks(
    parts: Parts,
    faces: dict[str, FaceMesh],
    sizes: dict[str, float],
    options: MeshOptions,
    nodes: NodeTable,
) -> dict[str, BrickMesh]:
    """Every brick's elements, by segment id. faces: of the walls, meshed already."""
    meshes: dict[str, BrickMesh] = {}
    for group in parts.sweeps:
        meshes.update(_sweep_group(group, faces, sizes, options.faces, nodes))
    for name, segment in parts.segments.items():
        if segment.type == "brick" and name not in meshes and name not in parts.absorbed:
            if options.volumes == "hex":
                raise MeshError(f"{name} ({segment.node}) cannot be swept, so it cannot be meshed with hexahedra only")
            meshes[name] = _tetrahedra(segment, sizes[name], options.deadline, nodes)
    return meshes


def _sweep_group(
    group: SweepGroup, faces: dict[str, FaceMesh], sizes: dict[str, float], kind: str, nodes: NodeTable
) -> dict[str, BrickMesh]:
    size = min(sizes[brick.segment.id] for brick in group.bricks)
    section = _host_section(group, faces) if group.host is not None else _own_section(group, size, kind)
    tolerance = 1e-9 * max(abs(brick.end) + abs(brick.start) for brick in group.bricks)
    levels = _levels(group.bricks, size, tolerance)
    numbers: dict[tuple[int, int], int] = {}
    meshes = {}
    for brick in group.bricks:
        meshes[brick.segment.id] = _sweep_brick(group, brick, section, levels, numbers, nodes)
    return meshes


def _own_section(group: SweepGroup, size: float, kind: str) -> FaceMesh:
    """The group's section meshed on its own curves; its nodes stay out of the model."""
    assert group.topology is not None
    assert group.face is not None
    flat = NodeTable()
    curves: list[SeededCurve] = seed_curves(group.topology, group.topology.curves(), {0: size}, flat)
    names = ", ".join(f"{brick.segment.id} ({brick.segment.node})" for brick in group.bricks)
    return mesh_face(names, 0, group.sheet, curves, size, kind, flat)


def _host_section(group: SweepGroup, faces: dict[str, FaceMesh]) -> FaceMesh:
    assert group.host is not None
    return faces[group.host[0].segment.id]


def _levels(bricks: Sequence[SweptBrick], size: float, tolerance: float) -> Array:
    """Offsets along the direction at which nodes lie: all starts and ends, and even parts between them."""
    ends: list[float] = []
    for value in sorted(value for brick in bricks for value in (brick.start, brick.end)):
        if not ends or value - ends[-1] > tolerance:
            ends.append(value)
    parts = []
    for start, end in itertools.pairwise(ends):
        count = max(1, round((end - start) / size))
        parts.append(start + (end - start) * np.arange(count) / count)
    return np.concatenate([*parts, ends[-1:]])


def _sweep_brick(
    group: SweepGroup,
    brick: SweptBrick,
    section: FaceMesh,
    levels: Array,
    numbers: dict[tuple[int, int], int],
    nodes: NodeTable,
) -> BrickMesh:
    """Elements between neighbouring levels over the section's elements inside the brick's outline."""
    local = {int(number): place for place, number in enumerate(section.nodes)}
    first = int(np.argmin(np.abs(levels - brick.start)))
    last = int(np.argmin(np.abs(levels - brick.end)))
    name = brick.segment.id
    blocks = []
    for kind, elements in (("hex8", section.quads), ("wedge6", section.triangles)):
        if not len(elements):
            continue
        places = np.vectorize(local.__getitem__, otypes=[np.int64])(elements)
        centres = section.flat[places].mean(axis=1)
        chosen = places[shapely.contains_xy(brick.outline, centres[:, 0], centres[:, 1])]
        if not len(chosen):
            continue
        layers = []
        for level in range(first, last):
            layer = [_level_nodes(group, section, chosen, at, levels, numbers, nodes) for at in (level, level + 1)]
            layers.append(np.concatenate(layer, axis=1))
        blocks.append(ElementBlock(name, kind, np.concatenate(layers)))
    if not blocks:
        raise MeshError(f"{name} ({brick.segment.node}): its section holds no element")
    return BrickMesh(tuple(blocks), _pairs(group, brick, section, levels, numbers, local))


def _level_nodes(
    group: SweepGroup,
    section: FaceMesh,
    places: Indices,
    level: int,
    levels: Array,
    numbers: dict[tuple[int, int], int],
    nodes: NodeTable,
) -> Indices:
    """Node numbers (like places) on one level, those that are new added."""
    wanted = np.unique(places)
    new = [int(place) for place in wanted if (int(place), level) not in numbers]
    if new:
        points = group.sheet.lift(section.flat[new]) + group.sheet.normal * (levels[level] - group.sheet.offset)
        for place, number in zip(new, nodes.add(points).tolist()):
            numbers[(place, level)] = number
    found = np.array([numbers[(int(place), level)] for place in wanted], dtype=np.int64)
    return found[np.searchsorted(wanted, places)]


def _pairs(
    group: SweepGroup,
    brick: SweptBrick,
    section: FaceMesh,
    levels: Array,
    numbers: dict[tuple[int, int], int],
    local: dict[int, int],
) -> Indices:
    """The brick's nodes on the host's face, each with the wall's node below or above it."""
    if group.host is None or brick.segment.id not in group.host[1].segments:
        return np.empty((0, 2), np.int64)
    at = float(group.host[1].centre @ group.sheet.normal)
    level = int(np.argmin(np.abs(levels - at)))
    found = [(numbers[(place, level)], number) for number, place in local.items() if (place, level) in numbers]
    return np.array(sorted(found), dtype=np.int64).reshape(-1, 2)


def _tetrahedra(segment: Segment, size: float, deadline: float, nodes: NodeTable) -> BrickMesh:
    from kernel.mesh.solid_tets import mesh_solid

    try:
        body = mesh_solid(segment.solid, size, deadline=deadline)
    except MeshError as error:
        raise MeshError(f"{segment.id} ({segment.node}): {error.message}") from error
    numbers = nodes.add(body.nodes)
    block = ElementBlock(segment.id, "tet4", numbers[body.tets])
    return BrickMesh((block,), np.empty((0, 2), np.int64), numbers[body.edges], body.middles)


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
