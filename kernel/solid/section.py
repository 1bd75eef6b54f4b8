"""Plane sections of solids, and polygons of flat faces, by chaining half-edges: no union of triangles, exact rings.

A section is made by cutting the solid and taking the cut's face: the triangle across each of its boundary edges names
the surface that trims it there.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.solid.facets import Facets
from kernel.solid.solid import Solid, cut_by
from kernel.solid.surfaces import Plane, Vector, plane_frame

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

CUT_FACE = 1 << 30
"""Face id of a section's cut where its plane is none of the table's."""

GRID = 1e-9
"""Polygon coordinates are rounded to this share of the largest extent: slivers below it vanish."""

Ring = tuple[NDArray[np.float64], NDArray[np.int64]]


@dataclass(frozen=True, eq=False)
class Section:
    """What the plane normal . x = offset cuts out of a solid.

    u, v: the plane's directions, u x v = normal. facets: triangles of the part with normal . x >= offset;
    cap: (m,) True for those that lie in the plane.
    """

    normal: Vector
    u: Vector
    v: Vector
    offset: float
    facets: Facets
    cap: NDArray[np.bool_]

    @cached_property
    def polygon(self) -> Polygon | MultiPolygon:
        """The section in coordinates (x.u, x.v); an empty Polygon where the plane misses the solid."""
        return face_polygon(self.facets, self.cap, self.u, self.v)

    @cached_property
    def rings(self) -> list[Ring]:
        """Closed rings with the section on their left: points (n, 2), and the id of the surface that trims each edge.

        Edge k runs from point k to k + 1. Points on a circle are on it to rounding.
        """
        # seen along -normal the cap is clockwise; in (u, v) its edges run with the material on the right
        return [
            (points[::-1].copy(), np.roll(surface[::-1], -1).copy())
            for points, surface in face_rings(self.facets, self.cap, self.u, self.v)
        ]

    @property
    def area(self) -> float:
        """Area of the section's facets."""
        return float(self.facets.areas[self.cap].sum())


def section(solid: Solid, normal: Vector, offset: float) -> Section:
    """The section of `solid` by the plane normal . x = offset, seen from the side that the normal points away from.

    Where the plane is one of the table's within its tolerance, the section is made there. Where a face lies in the
    plane, the section is that of the part with normal . x >= offset.
    """
    table = solid.surfaces
    known = table.find_plane(normal, offset)
    unit = np.asarray(normal, dtype=np.float64) / np.linalg.norm(normal)
    at = float(offset) / float(np.linalg.norm(normal))
    if known is not None:
        value = table.surfaces[known]
        assert isinstance(value, Plane)
        sign = 1.0 if float(unit @ value.normal) > 0.0 else -1.0
        unit, at = sign * value.normal + 0.0, sign * value.offset
    face = CUT_FACE if known is None else known
    facets = cut_by(solid, unit, at, face).facets
    cap = (facets.surface == face) & (facets.normals @ unit < 0.0)
    frame = plane_frame(unit)
    return Section(unit, frame.u, frame.v, at, facets, cap)


def face_rings(facets: Facets, mask: NDArray[np.bool_], u: Vector, v: Vector) -> list[Ring]:
    """Boundary rings of the triangles in `mask`, material on the left as seen from outside.

    Each is points (n, 2) as (x.u, x.v) and the surface ids (n,) of the triangles across its edges. Where the
    boundary meets itself in a vertex, rings turn so that they part there. Rings start at their lowest vertex index.
    """
    flat = np.stack([facets.vertices @ u, facets.vertices @ v], axis=1)
    return [(flat[chain], facets.surface[across]) for chain, across in boundary_chains(facets, mask)]


def boundary_chains(facets: Facets, mask: NDArray[np.bool_]) -> list[tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """Rings as (vertex indices (n,), triangles across edge k -> k + 1 (n,)), by walking round the triangles' fans."""
    inside = np.nonzero(mask)[0]
    neighbours, triangles = facets.neighbours, facets.triangles
    t, k = np.nonzero(~mask[neighbours[inside]])
    starts = set(zip(inside[t].tolist(), k.tolist()))
    chains = []
    for first in sorted(starts, key=lambda edge: (int(triangles[edge]), edge)):
        if first not in starts:
            continue
        here: tuple[int, int] = first
        vertices, across = [], []
        while here in starts:
            starts.discard(here)
            triangle, corner = here
            vertices.append(int(triangles[triangle, corner]))
            across.append(int(neighbours[triangle, corner]))
            here = _next_boundary(triangles, neighbours, mask, triangle, (corner + 1) % 3)
        chains.append((np.array(vertices, np.int64), np.array(across, np.int64)))
    return chains


def _next_boundary(
    triangles: NDArray[np.int64], neighbours: NDArray[np.int64], mask: NDArray[np.bool_], triangle: int, corner: int
) -> tuple[int, int]:
    """The boundary edge that leaves the vertex at `corner`, turning round it through triangles of the mask."""
    vertex = triangles[triangle, corner]
    while mask[neighbours[triangle, corner]]:
        triangle = int(neighbours[triangle, corner])
        corner = int(np.nonzero(triangles[triangle] == vertex)[0][0])
    return triangle, corner


def face_polygon(facets: Facets, mask: NDArray[np.bool_], u: Vector, v: Vector) -> Polygon | MultiPolygon:
    """The region that coplanar triangles cover, in coordinates (x.u, x.v): boundary half-edges, no triangle union.

    Coordinates are rounded to GRID of the extent, and points on straight edges taken out.
    """
    import shapely

    if not mask.any():
        return shapely.Polygon()
    triangles = facets.triangles[mask]
    start = triangles.ravel()
    end = triangles[:, [1, 2, 0]].ravel()
    n_vertex = len(facets.vertices)
    is_boundary = ~np.isin(start * n_vertex + end, end * n_vertex + start)
    start, end = start[is_boundary], end[is_boundary]
    flat = np.stack([facets.vertices @ u, facets.vertices @ v], axis=1)
    extent = float(np.ptp(flat[start], axis=0).max())
    segments = np.stack([flat[start], flat[end]], axis=1)
    region = area_within(segments, GRID * extent)
    return shapely.normalize(region)


NODED = 1e-6
"""Where the area enclosed differs from the boundary's own by more than this share, segments overlap: see below."""


def area_within(segments: NDArray[np.float64], grid: float) -> Polygon | MultiPolygon:
    """The region that unordered boundary segments (n, 2, 2) enclose; its vertices are the segments' own end points.

    All run round the material the same way. They are chained on coordinates rounded to `grid`, and points on straight
    edges (within 3 grids) taken out; then each vertex gets its unrounded coordinates back, so that areas are exact to
    rounding (where boundaries cross within the rounding, the crossing is a vertex of its own and stays).

    Bodies that are skew to the axes and touch face to face may be left with a slit of no width between them: front
    and back of it lie on one another, with vertices of their own, and no chain of them closes. The area tells; then
    the segments are divided where they meet, and what they wind round is taken.
    """
    import shapely

    points = segments.reshape(-1, 2)
    cells = np.round(points / grid)
    rounded = cells * grid
    lines = shapely.multilinestrings(shapely.linestrings(rounded.reshape(-1, 2, 2)))
    try:
        enclosed = shapely.build_area(lines)
    except shapely.errors.GEOSException:  # rings that cross one another within the rounding
        enclosed = None
    swept = _swept_area(rounded.reshape(-1, 2, 2))
    if enclosed is None or abs(enclosed.area - abs(swept)) > NODED * abs(swept):
        enclosed = _wound_round(rounded.reshape(-1, 2, 2), grid)
    region = shapely.simplify(enclosed, 3.0 * grid)
    exact = dict(zip(map(tuple, cells.tolist()), points.tolist()))

    def unrounded(flat: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.array([exact.get(tuple(cell), point) for cell, point in zip(np.round(flat / grid).tolist(), flat)])

    return shapely.transform(region, unrounded)


def _swept_area(segments: NDArray[np.float64]) -> float:
    """Signed area that directed segments (n, 2, 2), closed together, run round."""
    start, end = segments[:, 0] - segments[0, 0], segments[:, 1] - segments[0, 0]
    return 0.5 * float(np.sum(start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]))


def _wound_round(segments: NDArray[np.float64], grid: float) -> Polygon | MultiPolygon:
    """What directed segments (n, 2, 2) wind round, however they overlap: cells of their arrangement on `grid`."""
    import shapely

    divided = _divided(segments, 2.0 * grid)
    noded = shapely.union_all(shapely.linestrings(divided), grid_size=grid)
    cells = np.array(shapely.get_parts(shapely.polygonize([noded])))
    inner = shapely.get_coordinates(shapely.point_on_surface(cells))
    wound = cells[[_winding(divided, point) != 0 for point in inner]]
    return shapely.union_all(wound, grid_size=grid)


def _divided(segments: NDArray[np.float64], near: float) -> NDArray[np.float64]:
    """The segments (n, 2, 2) led through every end point that lies on them within `near`."""
    import shapely

    points = np.unique(segments.reshape(-1, 2), axis=0)
    lines = shapely.linestrings(segments)
    number, on = shapely.STRtree(shapely.points(points)).query(lines, predicate="dwithin", distance=near)
    start = segments[number, 0]
    along = np.einsum("ij,ij->i", points[on] - start, segments[number, 1] - start)
    order = np.lexsort((along, number))
    number, way = number[order], points[on[order]]
    same = number[1:] == number[:-1]
    return np.stack([way[:-1][same], way[1:][same]], axis=1)


def _winding(segments: NDArray[np.float64], point: NDArray[np.float64]) -> int:
    """How often directed segments (n, 2, 2) run round a point off them: crossings of the ray to its right."""
    start, end = segments[:, 0] - point, segments[:, 1] - point
    turn = start[:, 0] * end[:, 1] - start[:, 1] * end[:, 0]
    up = (start[:, 1] <= 0.0) & (end[:, 1] > 0.0) & (turn > 0.0)
    down = (start[:, 1] > 0.0) & (end[:, 1] <= 0.0) & (turn < 0.0)
    return int(up.sum()) - int(down.sum())
