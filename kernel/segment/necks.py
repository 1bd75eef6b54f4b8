"""Neck cuts: planes through concave edges, along which a solid falls into members that hide in it.

The plane with the smallest internal patch is the neck; patches on it up to NECK_RATIO times as large are cut too,
larger ones stay whole. A window frame cut from one block falls into its four bars this way.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from shapely import Polygon

from kernel.segment.faces import Region
from kernel.segment.slices import parts_of
from kernel.solid.section import face_polygon
from kernel.solid.solid import half_space_cut, unite
from kernel.solid.surfaces import Plane

if TYPE_CHECKING:
    from kernel.solid.solid import Facets, Solid

NECK_RATIO = 1.5
"""Internal patches up to this many times the smallest are cut with it."""

MOST_PLANES = 60
"""Solids with more planes at concave edges are not searched: they are no assembly of a few members."""

CONCAVE_ANGLE_COSINE = 0.9
"""Neighbours whose normals are closer than this are facets of one curved face."""

EMPTY = 1e-9
"""Pieces smaller than this share of the whole are rounding."""


def cut_at_neck(solid: Solid) -> tuple[Solid, ...]:
    """The two or more pieces that a cut at the smallest neck gives, in a fixed order; () where there is no neck."""
    best: tuple[float, Plane, Solid, Solid] | None = None
    for plane in _planes_at_concave_edges(solid):
        upper = half_space_cut(solid, plane.normal, plane.offset)
        lower = half_space_cut(solid, -plane.normal, -plane.offset)
        if upper.is_empty or lower.is_empty:
            continue
        # inside the solid, the plane bounds both halves; a face of the solid that lies on it bounds one
        for patch in parts_of(_face_on(upper, plane, -1).intersection(_face_on(lower, plane, 1))):
            if best is None or patch.area < best[0] * (1.0 - 1e-6):
                best = (patch.area, plane, upper, lower)
    if best is None:
        return ()
    area, plane, upper, lower = best
    pieces = [(piece, side) for half, side in ((upper, -1), (lower, 1)) for piece in half.components()]
    pieces = [(piece, side) for piece, side in pieces if piece.volume > EMPTY * solid.volume]
    return _joined(pieces, plane, NECK_RATIO * area)


def _planes_at_concave_edges(solid: Solid) -> list[Plane]:
    """Planes of the faces that meet others in a concave edge; none where there are too many."""
    facets = solid.facets
    near = facets.neighbours.ravel()
    here = np.repeat(np.arange(len(facets.triangles)), 3)
    other = (near >= 0) & (facets.surface[here] != facets.surface[np.maximum(near, 0)])
    here, near = here[other], near[other]
    rise = np.einsum("ij,ij->i", facets.centroids[near] - facets.centroids[here], facets.normals[here])
    cosine = np.einsum("ij,ij->i", facets.normals[here], facets.normals[near])
    concave = (rise > 1e-6 * solid.size) & (cosine < CONCAVE_ANGLE_COSINE)
    ids = np.unique(np.concatenate([facets.surface[here[concave]], facets.surface[near[concave]]]))
    planes = [plane for index in ids if isinstance(plane := solid.surfaces.surfaces[index], Plane)]
    return planes if len(planes) <= MOST_PLANES else []


def _face_on(piece: Solid, plane: Plane, side: int) -> Region:
    """The piece's face on the plane, looking along its normal (side 1) or against it (-1)."""
    facets: Facets = piece.facets
    at = np.abs(facets.centroids @ plane.normal - plane.offset) < 10.0 * piece.surfaces.tolerance
    mask = at & (facets.normals @ plane.normal * side > 0.99)
    return face_polygon(facets, mask, plane.u, plane.v) if mask.any() else Polygon()


def _joined(pieces: list[tuple[Solid, int]], plane: Plane, limit: float) -> tuple[Solid, ...]:
    """The pieces, joined again over patches larger than `limit`; () where that leaves one."""
    faces = [_face_on(piece, plane, side) for piece, side in pieces]
    group = list(range(len(pieces)))
    for i, (_, side_i) in enumerate(pieces):
        for j, (_, side_j) in enumerate(pieces[:i]):
            if side_i == side_j:
                continue
            if any(patch.area > limit for patch in parts_of(faces[i].intersection(faces[j]))):
                old, new = group[i], group[j]
                group = [new if label == old else label for label in group]
    labels = sorted(set(group), key=group.index)
    if len(labels) < 2:
        return ()
    whole = []
    for label in labels:
        members = [piece for (piece, _), own in zip(pieces, group) if own == label]
        whole.append(members[0] if len(members) == 1 else unite(members))
    return tuple(sorted(whole, key=lambda piece: tuple(np.round(piece.bounds.mean(axis=0) / piece.size, 6))))
