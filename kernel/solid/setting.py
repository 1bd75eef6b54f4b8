"""Where a primitive is built, and the checks that every builder makes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from kernel.solid.flat import flat_faces
from kernel.solid.frame import Placed
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import NotSolidError, tracked_manifold

FLAT = 1e-12
"""A profile edge whose rise (or whose change of radius) is below this share of the profile's size has none."""


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """Where a primitive is built: the table, its placement, its index among the primitives."""

    table: SurfaceTable
    placed: Placed
    source: int

    def to_working(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) or (3,) from the family's coordinates to the working frame."""
        return points if self.placed.family is None else self.placed.family.to_working(points)

    @property
    def mirrors(self) -> bool:
        """The placement turns the inside out."""
        return float(np.linalg.det(self.placed.linear)) < 0.0

    def solid(
        self,
        vertices: NDArray[np.float64],
        triangles: NDArray[np.int64],
        surface: NDArray[np.int64],
        *,
        inside_out: bool = False,
    ) -> Manifold:
        """The tracked manifold of this primitive."""
        return tracked_manifold(self.table, vertices, triangles, surface, self.source, inside_out=inside_out)

    def flat(self, vertices: NDArray[np.float64], triangles: NDArray[np.int64], group: NDArray[np.int64]) -> Manifold:
        """Vertices in the family's coordinates; triangles of one group make one flat face."""
        points = self.to_working(vertices)
        surface = flat_faces(self.table, points, triangles, group)
        return self.solid(points, triangles, surface, inside_out=self.mirrors)


def positive(**sizes: float) -> None:
    """NotSolidError where a size, named by its keyword, is not a positive finite number."""
    for name, size in sizes.items():
        if not 0.0 < size < math.inf:
            raise NotSolidError(f"its {name.replace('_', ' ')} is {size:g}, expected a positive number")


def still_thick(points: NDArray[np.float64], snapped: NDArray[np.float64]) -> None:
    """NotSolidError where snapping has taken an extent of the points away."""
    if ((np.ptp(points, axis=0) > 0.0) & (np.ptp(snapped, axis=0) <= 0.0)).any():
        raise NotSolidError("it is thinner than the precision of the model's coordinates")
