"""Constrained triangulations as the meshers use them: arrays of half-edges, and refusals that name the place."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.region import Region, RegionError
from kernel.numeric.triangulation import triangulate


@dataclass(frozen=True, slots=True, eq=False)
class Edges:
    """Edges as the kernels take them: start, end (n_edge,) int32; kind (n_edge,) uint8, see numeric.halfedge."""

    start: NDArray[np.int32]
    end: NDArray[np.int32]
    kind: NDArray[np.uint8]

    @property
    def arrays(self) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.uint8]]:
        """Start, end and kind."""
        return self.start, self.end, self.kind


def edges_of(region: Region) -> Edges:
    """The region's edges for the kernels."""
    return Edges(
        np.ascontiguousarray(region.edges[:, 0], dtype=np.int32),
        np.ascontiguousarray(region.edges[:, 1], dtype=np.int32),
        np.where(region.is_boundary, np.uint8(1), np.uint8(2)),
    )


@dataclass(frozen=True, slots=True, eq=False)
class Triangulation:
    """What numeric.triangulation returns: half-edges with spare room, and the integer grid for later insertions."""

    corner: NDArray[np.int32]
    twin: NDArray[np.int32]
    lock: NDArray[np.uint8]
    leaving: NDArray[np.int32]
    n_triangle: int
    x: NDArray[np.int64]
    y: NDArray[np.int64]
    origin: NDArray[np.float64]
    scale: float

    @property
    def half_edges(self) -> tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.uint8], NDArray[np.int32]]:
        """corner, twin, lock, leaving: the arrays that most kernels take."""
        return self.corner, self.twin, self.lock, self.leaving


def constrained(nodes: NDArray[np.float64], n_point: int, edges: Edges, n_spare: int) -> Triangulation:
    """Triangulate nodes, of which the first n_point are the region's; n_spare: room for nodes to come.

    RegionError, with the place, where two points coincide, edges cross or touch, or a point lies outside.
    """
    *arrays, double_of, failed = triangulate(nodes, n_point, *edges.arrays, n_spare)
    doubles = np.flatnonzero(double_of[:n_point] >= 0)
    if len(doubles):
        raise RegionError("two points of the region coincide at {}", nodes[doubles[0]])
    lost = np.flatnonzero(failed)
    if len(lost):
        middle = 0.5 * (nodes[edges.start[lost[0]]] + nodes[edges.end[lost[0]]])
        raise RegionError("an edge of the region meets another edge or point near {}", middle)
    triangulation = Triangulation(*arrays)
    outside = np.flatnonzero(triangulation.leaving[:n_point] < 0)
    if len(outside):
        raise RegionError(
            "the point {} of the region is not inside it; boundary edges should run in closed rings with the region on "
            "their left",
            nodes[outside[0]],
        )
    return triangulation
