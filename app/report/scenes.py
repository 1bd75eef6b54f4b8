"""What the pictures show: the solid, its segments by colour, and the mesh; triangles and lines in the user's frame."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.elements import ELEMENT_KINDS

if TYPE_CHECKING:
    from kernel.connect.model import Model
    from kernel.idealise.section import SectionProperties
    from kernel.mesh.mesh import ElementBlock
    from kernel.segment.segments import Segment
    from kernel.solid.evaluate import Evaluated
    from kernel.solid.solid import Facets

SOLID_COLOUR = (176, 190, 204)
EDGE_COLOUR = (38, 44, 52)
PALETTE = (
    (86, 140, 200), (236, 148, 62), (104, 176, 110), (212, 98, 98), (150, 126, 190), (168, 128, 112),
    (226, 146, 190), (140, 150, 160), (190, 186, 76), (84, 186, 200),
)  # fmt: skip
"""Told apart by hue and lightness; from the eleventh segment on they come again."""


COUPLING_COLOURS = {"rbe2": (200, 40, 50), "rbe3": (20, 130, 70), "mpc": (130, 60, 170)}
"""Rigid couplings, averages and equations, as lines from the node that stands alone to the others."""


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """Part of a scene. triangles: (n, 3, 3), lines: (m, 2, 3), model units, user's frame.

    is_mark: the lines are no edges but marks in the body's colour, which nothing hides.
    """

    name: str
    colour: tuple[int, int, int]
    triangles: NDArray[np.float64]
    lines: NDArray[np.float64]
    is_mark: bool = False

    @property
    def line_colour(self) -> tuple[int, int, int]:
        """The colour of the lines."""
        return self.colour if self.is_mark else EDGE_COLOUR


def segment_colours(ids: list[str]) -> dict[str, tuple[int, int, int]]:
    """A colour for each segment, in their order."""
    return {name: PALETTE[index % len(PALETTE)] for index, name in enumerate(ids)}


def solid_body(evaluated: Evaluated) -> Body:
    """The whole solid with the edges between its surfaces."""
    return _facets_body("solid", SOLID_COLOUR, evaluated.solid.facets, evaluated.frame)


def segment_bodies(evaluated: Evaluated, segments: tuple[Segment, ...]) -> list[Body]:
    """Every segment's own solid in its colour."""
    colours = segment_colours([segment.id for segment in segments])
    return [_facets_body(s.id, colours[s.id], s.solid.facets, evaluated.frame) for s in segments]


def mesh_bodies(model: Model) -> list[Body]:
    """Every segment's elements: shells' and solids' outer faces with their edges, beams as their extruded sections."""
    nodes = model.mesh.nodes
    bodies = []
    blocks = blocks_by_segment(model)
    sections = {prop.segment: prop.section for prop in model.properties}
    for name, colour in segment_colours([prop.segment for prop in model.properties]).items():
        triangles, lines = beam_shapes(nodes, blocks.get(name, []), sections[name])
        for loop, _ in outer_faces(blocks.get(name, [])):
            triangles.append(fans(nodes, loop))
            lines.append(rims(nodes, loop))
        bodies.append(Body(name, colour, np.concatenate(triangles), np.concatenate(lines)))
    return bodies + coupling_bodies(model)


def coupling_bodies(model: Model) -> list[Body]:
    """The couplings of each kind that the model has (`rbe2`, `rbe3`, `mpc`): lines and no triangles."""
    from kernel.connect.model import Rbe2, Rbe3

    nodes = model.mesh.nodes
    spokes: dict[str, list[NDArray[np.float64]]] = {kind: [] for kind in COUPLING_COLOURS}
    for coupling in model.couplings:
        if isinstance(coupling, Rbe2):
            kind, alone, others = "rbe2", coupling.independent, coupling.dependent
        elif isinstance(coupling, Rbe3):
            kind, alone, others = "rbe3", coupling.dependent, coupling.independent
        else:
            kind, alone, others = "mpc", int(coupling.nodes[0]), np.unique(coupling.nodes[1:])
        spokes[kind].append(np.stack([np.broadcast_to(nodes[alone], (len(others), 3)), nodes[others]], axis=1))
    none = np.empty((0, 3, 3))
    return [
        Body(kind, COUPLING_COLOURS[kind], none, np.unique(np.concatenate(lines), axis=0), is_mark=True)
        for kind, lines in spokes.items()
        if lines
    ]


def blocks_by_segment(model: Model) -> dict[str, list[ElementBlock]]:
    """The blocks of each segment, in their order."""
    found: dict[str, list[ElementBlock]] = {}
    for block in model.mesh.blocks:
        found.setdefault(block.segment, []).append(block)
    return found


def beam_shapes(
    nodes: NDArray[np.float64], blocks: list[ElementBlock], section: SectionProperties | None
) -> tuple[list[NDArray[np.float64]], list[NDArray[np.float64]]]:
    """Triangles (n, 3, 3) and lines (n, 2, 3) of the line elements among a segment's blocks, section extruded."""
    triangles, lines = [np.empty((0, 3, 3))], [np.empty((0, 2, 3))]
    for block in blocks:
        if ELEMENT_KINDS[block.kind].dimension == 1:
            if section is not None and block.orientation is not None:
                beam_triangles, beam_lines = _beam(nodes, block, section)
                triangles.append(beam_triangles)
                lines.append(beam_lines)
            lines.append(nodes[block.connectivity[:, :2]])
    return triangles, lines


def fans(nodes: NDArray[np.float64], loops: NDArray[np.int64]) -> NDArray[np.float64]:
    """Corner loops (n, 3 or 4) as triangles (m, 3, 3), those of the first corner's fan one fan after the other."""
    return np.concatenate([nodes[loops[:, [0, k, k + 1]]] for k in range(1, loops.shape[1] - 1)])


def rims(nodes: NDArray[np.float64], loops: NDArray[np.int64]) -> NDArray[np.float64]:
    """The sides of corner loops as lines (m, 2, 3)."""
    return nodes[np.stack([loops, np.roll(loops, -1, axis=1)], axis=2).reshape(-1, 2)]


def _facets_body(name: str, colour: tuple[int, int, int], facets: Facets, frame: NDArray[np.float64]) -> Body:
    points = facets.vertices @ frame.T
    return Body(name, colour, points[facets.triangles], points[_feature_edges(facets)])


def _feature_edges(facets: Facets) -> NDArray[np.int64]:
    """(n, 2) vertex pairs where two surfaces meet, or one surface folds by over 40 degrees (prisms of one surface)."""
    triangles, neighbours = facets.triangles, facets.neighbours
    edges = np.stack([triangles, np.roll(triangles, -1, axis=1)], axis=2)
    mine = np.arange(len(triangles))[:, None]
    safe = np.maximum(neighbours, 0)
    folds = np.einsum("tj,tkj->tk", facets.normals, facets.normals[safe]) < 0.77
    shown = (neighbours < 0) | ((mine < neighbours) & ((facets.surface[safe] != facets.surface[:, None]) | folds))
    return edges[shown]


def outer_faces(blocks: list[ElementBlock]) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """What can be seen of one segment: corner loops of faces that stand once, and the element of each.

    Triangles and quadrilaterals apart. Elements count through all blocks that are given, lines included.
    """
    loops: dict[int, list[NDArray[np.int64]]] = {3: [], 4: []}
    owners: dict[int, list[NDArray[np.int64]]] = {3: [], 4: []}
    first = 0
    for block in blocks:
        for face in ELEMENT_KINDS[block.kind].faces:
            loops[len(face)].append(block.connectivity[:, list(face)])
            owners[len(face)].append(first + np.arange(len(block.connectivity)))
        first += len(block.connectivity)
    outer = []
    for corners in (3, 4):
        if loops[corners]:
            together, owner = np.concatenate(loops[corners]), np.concatenate(owners[corners])
            _, inverse, count = np.unique(np.sort(together, axis=1), axis=0, return_inverse=True, return_counts=True)
            shown = count[inverse.ravel()] == 1
            outer.append((together[shown], owner[shown]))
    return outer


def _beam(
    nodes: NDArray[np.float64], block: ElementBlock, section: SectionProperties
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The section's outline extruded along every line element, closed at the ends that only one element has.

    The element lies at the section's centroid; y along its orientation vector, z = direction x y.
    """
    from manifold3d import triangulate
    from shapely.geometry import MultiPolygon
    from shapely.geometry.polygon import orient

    centroid = np.array(section.centroid)
    parts = section.outline.geoms if isinstance(section.outline, MultiPolygon) else [section.outline]
    rings = [np.asarray(r.coords)[:-1] - centroid for p in parts for r in (orient(p).exterior, *orient(p).interiors)]
    points = np.concatenate(rings)
    cap = triangulate(rings)
    start, end = nodes[block.connectivity[:, 0]], nodes[block.connectivity[:, 1]]
    direction = _unit(end - start)
    assert block.orientation is not None
    y = _unit(block.orientation - direction * np.einsum("ij,ij->i", block.orientation, direction)[:, None])
    z = np.cross(direction, y)
    offset = points[None, :, 0, None] * y[:, None] + points[None, :, 1, None] * z[:, None]
    near, far = start[:, None] + offset, end[:, None] + offset
    triangles, lines = [], []
    first = 0
    for ring in rings:
        here = first + np.arange(len(ring))
        there = np.roll(here, -1)
        first += len(ring)
        for corners in ((near[:, here], near[:, there], far[:, there]), (near[:, here], far[:, there], far[:, here])):
            triangles.append(np.stack(corners, axis=2).reshape(-1, 3, 3))
        edges = _unit(ring - np.roll(ring, 1, axis=0))
        sharp = here[np.einsum("ij,ij->i", edges, np.roll(edges, -1, axis=0)) < 0.8]
        lines.append(np.stack([near[:, sharp], far[:, sharp]], axis=2).reshape(-1, 2, 3))
        lines += [np.stack([end_[:, here], end_[:, there]], axis=2).reshape(-1, 2, 3) for end_ in (near, far)]
    names, count = np.unique(block.connectivity[:, :2], return_counts=True)
    free = np.isin(block.connectivity[:, :2], names[count == 1])
    triangles += [near[free[:, 0]][:, cap].reshape(-1, 3, 3), far[free[:, 1]][:, cap].reshape(-1, 3, 3)]
    return np.concatenate(triangles), np.concatenate(lines)


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    unit: NDArray[np.float64] = vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)
    return unit
