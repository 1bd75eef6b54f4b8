"""Planes that look along one direction, whichever way their own normals point and however those were rounded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.sides import FaceSide
from kernel.pieces import connected_pieces, near_pairs
from kernel.segment.faces import Region
from kernel.solid.surfaces import Plane, Surface

PARALLEL = 1e-5
"""Planes within this angle (radians) are parallel: over the whole model a gap differs by a hundredth of a near miss."""


@dataclass(frozen=True, slots=True, eq=False)
class Level:
    """A flat face in a group of parallel ones. at: along the group's direction; side: 1 where it looks that way."""

    group: int
    at: float
    side: int
    row: FaceSide


def levels(rows: Sequence[FaceSide], surfaces: Sequence[Surface]) -> list[Level]:
    """The rows that lie on planes, each in its group; its place is measured amid the face."""
    planes = [(row, plane) for row in rows if isinstance(plane := surfaces[row.surface], Plane)]
    if not planes:
        return []
    normals = np.stack([plane.normal for _, plane in planes])
    distinct, inverse = np.unique(normals, axis=0, return_inverse=True)
    groups = _groups(distinct)
    found = []
    for (row, plane), kind in zip(planes, np.ravel(inverse).tolist()):
        direction = distinct[groups[kind]]
        sign = 1 if direction @ plane.normal > 0 else -1
        middle = row.box.mean(axis=0)
        foot = middle - (float(middle @ plane.normal) - plane.offset) * plane.normal
        found.append(Level(groups[kind], float(foot @ direction), sign * row.side, row))
    return found


def _groups(normals: NDArray[np.float64]) -> list[int]:
    """For each of the distinct unit vectors (n, 3) the first that is parallel to it, or to one that is, and so on."""
    both = np.vstack([normals, -normals])
    pairs = np.array(near_pairs(both, PARALLEL), dtype=np.int64).reshape(-1, 2) % len(normals)
    return connected_pieces(len(normals), pairs[:, 0], pairs[:, 1]).tolist()


def carried(region: Region, start: Plane, end: Plane) -> Region:
    """A region in the coordinates of one plane in those of another, parallel one."""
    if start.u is end.u and start.v is end.v:
        return region
    axes = np.stack([start.u, start.v]) @ np.stack([end.u, end.v]).T
    shift = start.offset * (start.normal @ np.stack([end.u, end.v]).T)
    return shapely.transform(region, lambda at: at @ axes + shift)
