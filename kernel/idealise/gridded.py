"""Geometries with their corners on a grid, so that edges which lie on one another within its spacing become one."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray


def squared(layers: Sequence[Sequence[shapely.Geometry]], grid: float) -> list[list[shapely.Geometry]] | None:
    """The geometries with their corners on the grid where all their edges then run along its axes, else None.

    Such edges cross on the grid: what is combined of them is on it without being rounded, which is four fifths of the
    work. None also where corners fall together: a sliver or a slot that the grid closes.
    """
    shapes = np.array([shape for layer in layers for shape in layer], dtype=object)
    parts = shapely.get_parts(shapes)
    is_line = shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING
    points, line = shapely.get_coordinates([*shapely.get_rings(parts), *parts[is_line]], return_index=True)
    steps = np.diff(_rounded(points, grid), axis=0)[line[1:] == line[:-1]]
    if not ((steps[:, 0] == 0.0) ^ (steps[:, 1] == 0.0)).all():
        return None
    shapes = shapely.set_coordinates(shapes, _rounded(shapely.get_coordinates(shapes), grid))
    ends = np.cumsum([0, *map(len, layers)]).tolist()
    return [list(shapes[first:end]) for first, end in itertools.pairwise(ends)]


def _rounded(points: NDArray[np.float64], grid: float) -> NDArray[np.float64]:
    return np.round(points / grid) * grid
