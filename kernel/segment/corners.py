"""Corners: where two slabs overlap, which of the two walls gets it.

The wall with more free face there (a tee goes to the flange); as good as equal: the larger wall, then the thinner one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import STRtree

from kernel.segment.faces import faces_of
from kernel.segment.walls import PlaneWall, TubeWall, Wall
from kernel.solid.fins import without_fins
from kernel.solid.solid import intersect, subtract
from kernel.solid.surfaces import Plane

if TYPE_CHECKING:
    from kernel.solid.solid import Solid

Array = NDArray[np.float64]

FREE_MARGIN = 0.3
"""Shares of free face that differ by less are as good as equal."""

EMPTY = 1e-9
"""Solids smaller than this share of the whole are rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class WallPart:
    """A wall and the connected solid that is its own; cut in several by a wall that runs through it, it stays one."""

    wall: Wall
    solid: Solid


def settle_corners(solid: Solid, slabs: list[tuple[Wall, Solid]]) -> list[WallPart]:
    """The slabs made disjoint: pairs first, and where three met, in the order of their areas."""
    volume = solid.volume
    losses: list[list[Solid]] = [[] for _ in slabs]
    rank = _ranks(slabs, solid.surfaces.size)
    for i, j in _overlapping_boxes([slab for _, slab in slabs]):
        corner = intersect([slabs[i][1], slabs[j][1]])
        if corner.is_empty or corner.volume < 1e-12 * volume:
            continue
        free_i, free_j = _free_share(corner, slabs[i][0], solid), _free_share(corner, slabs[j][0], solid)
        if abs(free_i - free_j) > FREE_MARGIN:
            winner = i if free_i > free_j else j
        else:
            winner = i if rank[i] < rank[j] else j
        losses[j if winner == i else i].append(corner)
    parts: list[tuple[int, WallPart]] = []
    for index, (wall, slab) in enumerate(slabs):
        # a tube's slab keeps sheets where the bore of another around it goes on: they would hold pieces together
        for whole in (without_fins(slab) if isinstance(wall, TubeWall) else slab).components():
            own = without_fins(subtract(whole, losses[index]) if losses[index] else whole)
            if own.is_empty or own.volume <= EMPTY * volume:
                continue
            if own is whole or own.components():  # flakes are no components
                parts.append((index, WallPart(wall, own)))
    parts.sort(key=lambda item: rank[item[0]])
    return _without_triples([part for _, part in parts], losses, volume)


def _without_triples(parts: list[WallPart], losses: list[list[Solid]], volume: float) -> list[WallPart]:
    """Parts that still overlap (three walls in one corner, each winning one pair) taken in order."""
    if sum(1 for lost in losses if lost) < 2:
        return parts
    for i, j in _overlapping_boxes([part.solid for part in parts]):
        later, earlier = max(i, j), min(i, j)
        common = intersect([parts[later].solid, parts[earlier].solid])
        if common.is_empty or common.volume < 1e-12 * volume:
            continue
        parts[later] = replace(parts[later], solid=without_fins(subtract(parts[later].solid, [parts[earlier].solid])))
    return [part for part in parts if not part.solid.is_empty and part.solid.volume > EMPTY * volume]


def _ranks(slabs: list[tuple[Wall, Solid]], size: float) -> list[int]:
    """Position of each slab among all: larger paired region, then thinner, then by where it lies."""
    keys = []
    for wall, slab in slabs:
        centre = np.round(slab.bounds.mean(axis=0) / size, 6) + 0.0
        keys.append((-round(wall.area / size**2, 6), round(wall.thickness / size, 9), *map(float, centre)))
    order = sorted(range(len(slabs)), key=lambda index: keys[index])
    rank = [0] * len(slabs)
    for position, index in enumerate(order):
        rank[index] = position
    return rank


def _overlapping_boxes(solids: list[Solid]) -> list[tuple[int, int]]:
    """Pairs i < j whose boxes overlap in all three axes; by an index, not pair by pair."""
    if len(solids) < 2:
        return []
    boxes = np.array([solid.bounds for solid in solids])
    flat = shapely.box(boxes[:, 0, 0], boxes[:, 0, 1], boxes[:, 1, 0], boxes[:, 1, 1])
    left, right = STRtree(flat).query(flat)
    overlap = np.all(np.minimum(boxes[left, 1], boxes[right, 1]) > np.maximum(boxes[left, 0], boxes[right, 0]), axis=1)
    pairs = np.stack([left, right], axis=1)[overlap & (left < right)]
    return sorted((int(i), int(j)) for i, j in pairs)


def _free_share(corner: Solid, wall: Wall, solid: Solid) -> float:
    """Share of the wall's two faces, inside the corner, that is free boundary of the whole solid (0 to 2).

    What comes from the solid is. What a cut in the same plane has made may be, for of two coincident faces a Boolean
    keeps either: it is where the solid's own face covers its middle.
    """
    facets = corner.facets
    if isinstance(wall, PlaneWall):
        lift = facets.normals @ wall.normal
        foot = float((facets.areas * lift)[lift > 0.0].sum())
    else:
        arm = facets.centroids - wall.axis.point
        arm -= np.outer(arm @ wall.axis.direction, wall.axis.direction)
        arm /= np.maximum(np.linalg.norm(arm, axis=1), 1e-300)[:, None]
        lift = np.einsum("ij,ij->i", arm, facets.normals)
        foot = float(facets.areas[lift > 0.9].sum())
    on_wall = np.isin(facets.surface, wall.surface_ids) & (np.abs(lift) > 0.5)
    cut = np.flatnonzero(on_wall & (facets.source < 0))
    on_wall[cut] = _on_boundary(facets.centroids[cut], facets.surface[cut], lift[cut], solid)
    return float(facets.areas[on_wall].sum()) / foot if foot > 0.0 else 0.0


def _on_boundary(points: Array, surfaces: NDArray[np.int64], lifts: Array, solid: Solid) -> NDArray[np.bool_]:
    """Which points (n, 3) on planes lie on the solid's own faces that look the same way; none of those on tubes."""
    found = np.zeros(len(points), dtype=bool)
    faces = faces_of(solid)
    for surface, side in sorted({(int(s), 1 if lift > 0 else -1) for s, lift in zip(surfaces, lifts)}):
        plane = solid.surfaces.surfaces[surface]
        if not isinstance(plane, Plane) or (surface, side) not in faces.areas:
            continue
        here = (surfaces == surface) & ((lifts > 0) == (side > 0))
        at = points[here]
        face = faces.polygon(surface, side)
        shapely.prepare(face)
        found[here] = shapely.contains_xy(face, at @ plane.u, at @ plane.v)
    return found
