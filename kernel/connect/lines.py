"""Beams as lines with a section: where they end, and which place of a line stands opposite a point."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.work import beam_frames
from kernel.idealise.section import SectionProperties
from kernel.mesh.mesh import ElementBlock, Mesh

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

AXIS = 1e-6
"""Shares of an element's length, or of a section's radius, that do not count."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """nodes: of the beam, sorted; box: (2, 3) about them.

    axes: by node the section's, (3, 3) rows x, y, z. ends: by node at an end the way out (3,). pairs: (n, 2) the
    elements' end nodes. outline: the section's rings from its centroid, (n, 2) each, the outer one first; radius: of
    the circle about them.
    """

    segment: str
    nodes: Indices
    box: Array
    axes: Mapping[int, Array]
    ends: Mapping[int, Array]
    outline: tuple[Array, ...]
    radius: float
    pairs: Indices

    @property
    def reach(self) -> float:
        """How far the body's surface may lie outside the box of its nodes."""
        return self.radius

    @property
    def polygon(self) -> shapely.Polygon:
        """The section about its centroid."""
        return shapely.Polygon(self.outline[0], self.outline[1:])

    def polygon_in(self, node: int, axes: Array, place: Array) -> shapely.Polygon:
        """The section at a node in the y and z of other axes (3, 3), its centroid at a place (2,) there."""
        turn = self.axes[node][1:] @ axes[1:].T
        return shapely.Polygon(self.outline[0] @ turn + place, [ring @ turn + place for ring in self.outline[1:]])

    def foot(self, points: Array, place: Array) -> tuple[tuple[int, int], float, Array] | None:
        """The element in which a place falls square on the axis: its nodes, the share of the way, the axes (3, 3)."""
        start, end = points[self.pairs[:, 0]], points[self.pairs[:, 1]]
        way = end - start
        shares = np.einsum("ij,ij->i", place - start, way) / np.einsum("ij,ij->i", way, way)
        inside = np.flatnonzero((shares >= -AXIS) & (shares <= 1 + AXIS))
        if not len(inside):
            return None
        apart = np.linalg.norm(place - start[inside] - shares[inside, None] * way[inside], axis=1)
        row = int(inside[np.argmin(apart)])
        a, b = self.pairs[row].tolist()
        return (a, b), float(np.clip(shares[row], 0.0, 1.0)), self.axes[a]


def line_of(segment: str, blocks: Sequence[ElementBlock], section: SectionProperties, points: Array) -> Line:
    """The line of a beam's blocks. points: (n_node, 3) of the mesh."""
    frames = beam_frames(Mesh(points, tuple(blocks)), points, {segment: section})
    pairs = np.concatenate([block.connectivity[:, :2] for block in blocks])
    found, counts = np.unique(pairs, return_counts=True)
    ends = {}
    for end in found[counts == 1].tolist():
        ((a, b),) = pairs[(pairs == end).any(axis=1)].tolist()
        out = points[end] - points[a if b == end else b]
        ends[end] = out / np.linalg.norm(out)
    polygon = getattr(section.outline, "geoms", [section.outline])[0]
    rings = [shapely.get_coordinates(ring) - section.centroid for ring in (polygon.exterior, *polygon.interiors)]
    return Line(
        segment,
        nodes := np.array(sorted(frames), dtype=np.int64),
        np.array([points[nodes].min(axis=0), points[nodes].max(axis=0)]),
        {node: frame.axes for node, frame in frames.items()},
        ends,
        tuple(rings),
        float(np.linalg.norm(rings[0], axis=1).max()),
        pairs,
    )
