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

from kernel.pieces import connected_pieces
from kernel.solid.surfaces import CylinderSurface

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
    """The round holes of a solid, narrow ones first; all patches are measured at once."""
    facets, table = solid.facets, solid.surfaces.surfaces
    ids = [int(index) for index in np.unique(facets.surface) if isinstance(table[index], CylinderSurface)]
    if not ids:
        return ()
    cylinders = [surface for index in ids if isinstance(surface := table[index], CylinderSurface)]
    round_ = np.nonzero(np.isin(facets.surface, ids))[0]
    which = np.searchsorted(ids, facets.surface[round_])
    points = np.array([cylinder.axis.point for cylinder in cylinders])[which]
    x = np.array([cylinder.axis.x for cylinder in cylinders])[which]
    y = np.array([cylinder.axis.y for cylinder in cylinders])[which]
    arms, normals = facets.centroids[round_] - points, facets.normals[round_]
    inward = _dot(arms, x) * _dot(normals, x) + _dot(arms, y) * _dot(normals, y) < 0.0
    if not inward.any():
        return ()
    held, which = round_[inward], which[inward]
    radii = np.array([cylinder.radius for cylinder in cylinders])[which]
    corners = facets.vertices[facets.triangles[held]] - points[inward][:, None]
    angles = np.arctan2(
        np.einsum("ikj,ij->ik", corners, y[inward]),
        np.einsum("ikj,ij->ik", corners, x[inward]),
    )
    beside, place = _beside(facets, held)
    patch = _patches(beside, place, which)
    falls, closes = _edges(facets, held, beside, radii)
    is_hole = _goes_round(angles, patch) & _any_of(falls, patch)
    is_through = ~_any_of(closes, patch)
    _, first = np.unique(patch, return_index=True)
    holes = [RoundHole(2.0 * float(radii[first[k]]), bool(is_through[k])) for k in np.nonzero(is_hole)[0]]
    return tuple(sorted(holes, key=lambda hole: (hole.diameter, hole.is_through)))


def _dot(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.einsum("ij,ij->i", a, b)


def _any_of(flags: NDArray[np.bool_], patch: NDArray[np.int64]) -> NDArray[np.bool_]:
    """By patch, whether any of its triangles is flagged."""
    return np.bincount(patch, weights=flags) > 0.0


def _beside(facets: Facets, held: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(n, 3) the triangles across the edges of `held`, and their places in `held`, -1 for those outside."""
    beside = facets.neighbours[held]
    place = np.minimum(np.searchsorted(held, beside), len(held) - 1)
    return beside, np.where(held[place] == beside, place, -1)


def _patches(beside: NDArray[np.int64], place: NDArray[np.int64], which: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) the number of each triangle's patch: triangles of one cylinder that hang together by their edges."""
    rows, sides = np.nonzero((place >= 0) & (which[place] == which[:, None]))
    return np.unique(connected_pieces(len(beside), rows, place[rows, sides]), return_inverse=True)[1]


def _edges(
    facets: Facets, held: NDArray[np.int64], beside: NDArray[np.int64], radii: NDArray[np.float64]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """(n,) whether a triangle has an edge to another surface that falls away from the bore, and one that closes it."""
    rows, sides = np.nonzero((beside >= 0) & (facets.surface[beside] != facets.surface[held][:, None]))
    others = facets.vertices[facets.triangles[beside[rows, sides]]]
    origin = facets.vertices[facets.triangles[held[rows], 0]]
    off = np.einsum("ikj,ij->ik", others - origin[:, None], facets.normals[held[rows]])
    far = np.take_along_axis(off, np.abs(off).argmax(axis=1)[:, None], axis=1)[:, 0] / radii[rows]
    falls, closes = np.zeros(len(held), dtype=bool), np.zeros(len(held), dtype=bool)
    falls[rows[far < -TURNED]] = True
    closes[rows[far > TURNED]] = True
    return falls, closes


def _goes_round(angles: NDArray[np.float64], patch: NDArray[np.int64]) -> NDArray[np.bool_]:
    """By patch, whether the triangles, whose corners stand at `angles` (n, 3), leave no gap around the axis."""
    turn = 2.0 * np.pi
    apart = np.remainder(angles - angles[:, :1] + np.pi, turn) - np.pi
    start = np.remainder(angles[:, 0] + apart.min(axis=1), turn) + 4.0 * turn * patch
    order = np.argsort(start, kind="stable")
    start, owner = start[order], patch[order]
    reached = np.maximum.accumulate(start + np.ptp(apart, axis=1)[order])
    first = np.nonzero(np.diff(owner, prepend=-1))[0]
    last = np.append(first[1:], len(owner)) - 1
    has_gap = np.zeros(len(owner), dtype=bool)
    has_gap[1:] = (start[1:] > reached[:-1] + OPEN_ANGLE) & (owner[1:] == owner[:-1])
    closes = reached[last] >= start[first] + turn - OPEN_ANGLE
    return closes & ~_any_of(has_gap, owner)
