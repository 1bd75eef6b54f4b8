"""Round holes of a solid, read from its concave cylindrical faces: whichever tree made them.

A hole is a patch of one cylinder, hollow side inwards, that goes all the way round and is open somewhere. It is
through where nothing stands in it: every edge of the patch falls away from the bore (a mouth), none closes it (a floor
or a step to a narrower bore). A closed round void is no hole.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.solid.surfaces import CylinderSurface, radial

if TYPE_CHECKING:
    from kernel.solid.facets import Facets
    from kernel.solid.solid import Solid

OPEN_ANGLE = 1e-3
"""Radians: a patch whose widest gap is below this goes all the way round."""

TURNED = 1e-6
"""A neighbour whose far corner is off the patch's plane by less than this share of the radius goes on smoothly."""


@dataclass(frozen=True, slots=True)
class RoundHole:
    """diameter: of the true cylinder. is_through: open at both ends, with nothing standing in it."""

    diameter: float
    is_through: bool


def round_holes(solid: Solid) -> tuple[RoundHole, ...]:
    """The round holes of a solid, narrow ones first."""
    facets = solid.facets
    found = []
    order = np.argsort(facets.surface, kind="stable")
    ids, starts = np.unique(facets.surface[order], return_index=True)
    for index, held in zip(ids, np.split(order, starts[1:])):
        surface = solid.surfaces.surfaces[index]
        if isinstance(surface, CylinderSurface):
            outward = radial(surface.axis, facets.centroids[held])
            held = held[(facets.normals[held] * outward).sum(axis=1) < 0.0]
            for patch in _patches(facets, held):
                hole = _hole(facets, patch, surface)
                if hole is not None:
                    found.append(hole)
    return tuple(sorted(found, key=lambda hole: (hole.diameter, hole.is_through)))


def _patches(facets: Facets, held: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """The triangles in groups that hang together by their edges."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    if not len(held):
        return []
    beside = facets.neighbours[held]
    place = np.searchsorted(held, beside)
    inside = (beside >= 0) & (held[np.minimum(place, len(held) - 1)] == beside)
    rows, _ = np.nonzero(inside)
    links = coo_array((np.ones(len(rows)), (rows, place[inside])), shape=(len(held), len(held)))
    count, group = connected_components(links, directed=False)
    return [held[group == number] for number in range(count)]


def _hole(facets: Facets, patch: NDArray[np.int64], surface: CylinderSurface) -> RoundHole | None:
    if not _goes_round(facets, patch, surface):
        return None
    beside = facets.neighbours[patch]
    rows, _ = np.nonzero(~np.isin(beside, patch))
    others = beside[~np.isin(beside, patch)]
    corners = facets.vertices[facets.triangles[others]]
    first = facets.vertices[facets.triangles[patch[rows], 0]]
    off = np.einsum("ikj,ij->ik", corners - first[:, None], facets.normals[patch[rows]])
    far = np.take_along_axis(off, np.abs(off).argmax(axis=1)[:, None], axis=1)[:, 0]
    falls = far < -TURNED * surface.radius
    closes = far > TURNED * surface.radius
    if not falls.any():
        return None
    return RoundHole(2.0 * surface.radius, not bool(closes.any()))


def _goes_round(facets: Facets, patch: NDArray[np.int64], surface: CylinderSurface) -> bool:
    """Whether the patch's triangles leave no gap around the axis."""
    points = facets.vertices[facets.triangles[patch]] - surface.axis.point
    angles = np.arctan2(points @ surface.axis.y, points @ surface.axis.x)
    apart = np.remainder(angles - angles[:, :1] + np.pi, 2.0 * np.pi) - np.pi
    start = np.remainder(angles[:, 0] + apart.min(axis=1), 2.0 * np.pi)
    end = start + np.ptp(apart, axis=1)
    order = np.argsort(start)
    start, end = start[order], end[order]
    reached = np.maximum.accumulate(end)
    if np.any(start[1:] > reached[:-1] + OPEN_ANGLE):
        return False
    return bool(reached[-1] >= start[0] + 2.0 * np.pi - OPEN_ANGLE)
