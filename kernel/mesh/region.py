"""The contract between topology and the planar meshers: a seeded region in, a mesh on exactly those seeds out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError


class RegionError(MeshError):
    """A place of a region at which it cannot be meshed.

    said: the message, with {} where it names the place. at: (2,) the place, in the region's coordinates. By itself the
    message gives those; whoever knows the sheet tells the place in space, with `told`.
    """

    def __init__(self, said: str, at: NDArray[np.float64]) -> None:
        x, y = at
        super().__init__(said.format(f"({x:.6g}, {y:.6g})"))
        self.args = (said, at)  # what pickle makes it from again
        self.said = said
        self.at = at

    def told(self, place: str) -> str:
        """The message with the place as the caller names it."""
        return self.said.format(place)


class OddCurveError(RegionError):
    """A chain of curves has an odd number of edges, on which no all-quad mesh can be made."""


@dataclass(frozen=True, slots=True, eq=False)
class Region:
    """A planar region, its curves already divided.

    points: (n_point, 2) seeds on the curves, then hard points inside the region (on no edge).
    edges: (n_edge, 2) int64 pairs of points; none may be split by the mesher, all become element edges.
    is_boundary: (n_edge,) True where the region ends, False for an imprint inside it (element edges on both sides).
        Boundary edges run with the region on their left. Every ring is closed; rings do not cross.
    is_curved: (n_edge,) True where the edge stands for a piece of an arc (meshers treat such curves later).
    period: None for a plane; for an unrolled closed cylinder the circumference: points then have 0 <= x < period,
        and an edge between two points takes the shorter way round.
    """

    points: NDArray[np.float64]
    edges: NDArray[np.int64]
    is_boundary: NDArray[np.bool_]
    is_curved: NDArray[np.bool_]
    period: float | None = None


@dataclass(frozen=True, slots=True, eq=False)
class RegionMesh:
    """points: (n_node, 2); the first n_point are the region's own, in their order.

    quads: (n_quad, 4) and triangles: (n_triangle, 3), int64, counter-clockwise; either may be empty. On a periodic
    region connectivity is already closed over the seam (no doubled nodes), and 0 <= x < period.
    """

    points: NDArray[np.float64]
    quads: NDArray[np.int64]
    triangles: NDArray[np.int64]
