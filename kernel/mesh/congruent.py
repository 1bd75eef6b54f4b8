"""Equal regions get one mesh, wherever they lie and however their curves are numbered.

    +--+--+--+      +--+--+--+      Moved to its lowest corner, rounded to far less than its shortest edge, points and
    |  A     |      |  A'    |      edges in the order of their places: so regions that differ by a translation and
    +--+--+--+      +--+--+--+      rounding are the same bytes. That standard region is what is meshed, always, so a
                                    mesh does not depend on which of them is met first, or whether there are several.

A frame of equal bays, or a box of equal cells, has thousands of faces and few different ones. Regions that are turned
against one another count as different, as does all on a closed cylinder, where x has no lowest value.
"""

from __future__ import annotations

import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.region import Region, RegionError, RegionMesh

Indices = NDArray[np.int64]

BITS = 28
"""Coordinates are rounded to 2^-28 of the shortest edge: no mesh sees that, and rounding errors of a model some
thousand times as large as the edge are gone but for one coordinate in some thousand."""


@dataclass(frozen=True, slots=True, eq=False)
class Standard:
    """The region in its standard place. order: (n_point,) the original's number of each of its points.

    origin: (2,) what brings it back.
    """

    region: Region
    order: Indices
    origin: NDArray[np.float64]


Meshes = dict[bytes, RegionMesh]
"""Meshes of standard regions by what they were made from; threads may share one, for each entry is what anyone would
have put there."""


def mesh_once(
    region: Region, wanted: tuple[float, str, float], mesher: Callable[[Region], RegionMesh], known: Meshes
) -> RegionMesh:
    """The mesh of a planar region by way of its standard one, made by `mesher` unless it is known.

    wanted: size, faces and growth, which the mesher has too. RegionError with the place in the region itself.
    """
    standard = standard_region(region)
    key = _key(standard.region, wanted)
    if key not in known:
        try:
            known[key] = mesher(standard.region)
        except RegionError as error:
            raise type(error)(error.said, error.at + standard.origin) from error
    return _brought_back(known[key], region, standard)


def standard_region(region: Region) -> Standard:
    """The region as all are that differ from it by a translation and the order of points and edges only."""
    origin = region.points.min(axis=0)
    unit = _unit(region)
    rounded = np.round((region.points - origin) / unit)
    order = _order(region, rounded)
    number = np.empty(len(order), np.int64)
    number[order] = np.arange(len(order))
    ends = number[region.edges]
    inner = ~region.is_boundary
    ends[inner] = np.sort(ends[inner], axis=1)  # an imprint runs neither way
    rank = np.lexsort((ends[:, 1], ends[:, 0]))
    place = rounded[order] * unit
    standard = Region(place, ends[rank], region.is_boundary[rank], region.is_curved[rank])
    return Standard(standard, order, origin)


def _order(region: Region, rounded: NDArray[np.float64]) -> Indices:
    """Numbers of the points by place, those on curves first: hard points come last in a region."""
    is_hard = np.ones(len(rounded), np.bool_)
    is_hard[region.edges.ravel()] = False
    return np.lexsort((rounded[:, 1], rounded[:, 0], is_hard))


def _unit(region: Region) -> float:
    """A power of two some 2^-BITS of the shortest edge; it changes where no round number lies, at 2^(n + 1/2)."""
    along = region.points[region.edges[:, 1]] - region.points[region.edges[:, 0]]
    square = np.einsum("ij,ij->i", along, along)
    extent = np.ptp(region.points, axis=0)
    shortest = math.sqrt(float(square.min())) or float(extent.max()) or 1.0
    return 2.0 ** (round(math.log2(shortest)) - BITS)


def _key(region: Region, wanted: tuple[float, str, float]) -> bytes:
    digest = hashlib.blake2b(repr((wanted, len(region.points))).encode(), digest_size=24)
    for array in (region.points, region.edges, region.is_boundary, region.is_curved):
        digest.update(np.ascontiguousarray(array).data)
    return digest.digest()


def _brought_back(mesh: RegionMesh, region: Region, standard: Standard) -> RegionMesh:
    """The mesh on the region's own points, in their order."""
    n_point = len(region.points)
    points = np.empty_like(mesh.points)
    points[:n_point] = region.points
    points[n_point:] = mesh.points[n_point:] + standard.origin
    numbers = np.arange(len(points))
    numbers[:n_point] = standard.order
    return RegionMesh(points, numbers[mesh.quads.reshape(-1, 4)], numbers[mesh.triangles.reshape(-1, 3)])
