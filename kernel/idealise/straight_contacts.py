"""Where flat walls touch one another's slabs along the straight lines in which they cross: all of them at once.

=====:=======:====  section of the wall, in its sheet
:   |   :              "|" the line, ":" the edges of the other wall's slab there, and so of what touches it
:   |   :
========  no part of the section lies under the edge on the left: it reaches the line from the right
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.idealise.carriers import Line
from kernel.idealise.sheets import PlaneSheet
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall
from kernel.solid.surfaces import crosses

Array = NDArray[np.float64]
Interval = tuple[float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Side:
    """The line in which two walls cross, as one of them sees it; both on plane sheets."""

    line: Line
    wall: Wall
    other: Wall


def straight_contacts(topology: Topology, sides: Sequence[Side], margin: float) -> list[list[Interval]]:
    """By side, the stretches of the line along which the wall's own section lies under an edge of the other's slab.

    margin: by how much the slab is taken thicker on each side.
    """
    found: list[list[Interval]] = [[] for _ in sides]
    if not sides:
        return found
    frames = [_sheet_of(side.wall) for side in sides]
    u, v = np.array([sheet.u for sheet in frames]), np.array([sheet.v for sheet in frames])
    direction = np.array([side.line.direction for side in sides])
    edges = _edges(topology, sides, margin)
    flat = np.stack([_onto(edges, u[:, None]), _onto(edges, v[:, None])], axis=-1)
    sections = np.array([side.wall.own for side in sides], dtype=object)
    pieces, place = _pieces(shapely.linestrings(flat.reshape(-1, 2, 2)), np.repeat(sections, 2))
    is_long = shapely.length(pieces) > topology.tolerance
    pieces, number = pieces[is_long], place[is_long] // 2
    ends = shapely.get_coordinates(np.stack([shapely.get_point(pieces, 0), shapely.get_point(pieces, -1)], axis=1))
    ends = ends.reshape(-1, 2, 2)
    foot = np.array([sheet.normal * sheet.offset for sheet in frames])
    points = ends[..., :1] * u[number, None] + ends[..., 1:] * v[number, None] + foot[number, None]
    values = np.sort(_onto(points, direction[number]), axis=1)
    for side, (first, last) in zip(number.tolist(), values.tolist(), strict=True):
        found[side].append((first, last))
    return found


def _edges(topology: Topology, sides: Sequence[Side], margin: float) -> Array:
    """(n, 2, 2, 3) the two edges of each other wall's slab in the wall's sheet, by their ends."""
    normal = np.array([_sheet_of(side.wall).normal for side in sides])
    other = np.array([_sheet_of(side.other).normal for side in sides])
    half = np.array([0.5 * side.other.thickness + margin for side in sides])
    aside = crosses(normal, crosses(normal, other))
    shift = aside * (half / (aside[:, 0] ** 2 + aside[:, 1] ** 2 + aside[:, 2] ** 2))[:, None]
    point = np.array([side.line.point for side in sides])
    direction = np.array([side.line.direction for side in sides])
    bounds = np.array([side.other.segment.solid.bounds for side in sides])
    along = _onto(bounds, direction)
    reach = topology.carriers.reach
    ends = np.stack([along.min(axis=1) - reach, along.max(axis=1) + reach], axis=1)
    line = point[:, None] + ends[..., None] * direction[:, None]
    return np.stack([line - shift[:, None], line + shift[:, None]], axis=1)


def _pieces(lines: NDArray[np.object_], sections: NDArray[np.object_]) -> tuple[NDArray[np.object_], NDArray[np.int64]]:
    """The stretches of lines within sections, lines that touch in a point being one, and the place of each's line."""
    common = shapely.intersection(lines, sections)
    is_whole = shapely.get_type_id(common) == shapely.GeometryType.LINESTRING
    common[~is_whole] = shapely.line_merge(common[~is_whole])
    parts, place = shapely.get_parts(common, return_index=True)
    is_line = (shapely.get_type_id(parts) == shapely.GeometryType.LINESTRING) & ~shapely.is_empty(parts)
    return parts[is_line], place[is_line]


def _sheet_of(wall: Wall) -> PlaneSheet:
    assert isinstance(wall.sheet, PlaneSheet)
    return wall.sheet


def _onto(points: Array, axes: Array) -> Array:
    """How far along its axis (..., 3) each of the points (..., k, 3) lies; rounded as for one axis by itself."""
    return np.asarray(np.matmul(points, axes[..., None])[..., 0])
