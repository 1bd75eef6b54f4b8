"""The planar mesher's door: a seeded region in, a checked mesh on exactly those seeds out.

The meshers behind it are imported when they are needed: numba takes a third of a second to import.
"""

from __future__ import annotations

import numpy as np

from kernel.errors import MeshError
from kernel.mesh.congruent import Meshes, mesh_once
from kernel.mesh.period import shortest_way
from kernel.mesh.region import Region, RegionError, RegionMesh
from kernel.mesh.region_cells import cells_of_region, joined

FACES = ("quad", "tri", "mixed")

GROWTH = 0.3
"""How much longer elements may get per unit of distance from short edges, where nobody asks for another growth."""

MOST_ELEMENTS = 20_000_000
"""A region that would take more elements than this is refused: the size is surely a mistake."""


def mesh_region(
    region: Region, size: float, faces: str = "quad", growth: float = GROWTH, known: Meshes | None = None
) -> RegionMesh:
    """Mesh a planar or periodic region with elements of about `size`.

    faces: "quad": all quads (a few triangles only where curves lie so near to each other that quads would be bad),
    which asks for an even number of edges on each curve; "mixed": the same on any number; "tri": all triangles.
    growth: elements are as long as the edges beside them; from shorter edges they grow, from longer ones they shrink to
    `size`, by this much per unit of distance.
    known: meshes of regions that may come again, see congruent.py.
    The first n_point nodes of the result are the region's points; every edge of the region is an edge of the mesh;
    no element is inverted and no quad under a scaled Jacobian of 0.2. RegionError, with the place, where the region
    cannot be meshed: a boundary that is no ring, points or edges that meet where they should not, an odd curve.
    """
    _check(region, size, faces, growth)
    known = {} if known is None else known
    wanted = (float(size), faces, float(growth))
    cells = cells_of_region(region)
    if cells is None:
        return _mesh_cell(region, wanted, known)
    return joined(region, cells, [_mesh_cell(cell.region, wanted, known) for cell in cells])


def _mesh_cell(region: Region, wanted: tuple[float, str, float], known: Meshes) -> RegionMesh:
    if region.period is not None:
        return _mesh_here(region, *wanted)
    return mesh_once(region, wanted, lambda standard: _mesh_here(standard, *wanted), known)


def _mesh_here(region: Region, size: float, faces: str, growth: float) -> RegionMesh:
    if faces != "tri":
        from kernel.mesh.structured import structured_mesh

        mesh = structured_mesh(region, size)
        if mesh is not None:
            return mesh  # checked by its own measure of quality, without compiled kernels
    mesh = _general_mesh(region, size, faces, growth)
    _check_elements(mesh, region.period)
    return mesh


def _general_mesh(region: Region, size: float, faces: str, growth: float) -> RegionMesh:
    if region.period is not None:
        from kernel.mesh.unrolled import periodic_mesh

        return periodic_mesh(region, size, faces, growth)
    if faces == "tri":
        from kernel.mesh.triangles import triangle_mesh

        return triangle_mesh(region, size, growth)
    if faces == "mixed":
        from kernel.mesh.mixed import mixed_mesh

        return mixed_mesh(region, size, growth)
    from kernel.mesh.quads import quad_mesh

    return quad_mesh(region, size, growth)


def _check_elements(mesh: RegionMesh, period: float | None) -> None:
    """RegionError, with the place, where an element has no area or runs clockwise: none ever leaves."""
    from kernel.numeric.areas import least_area

    for elements in (mesh.quads, mesh.triangles):
        if len(elements) == 0:
            continue
        worst, area = least_area(mesh.points, elements, float(period or 0.0))
        if not area > 0:
            middle = mesh.points[elements[worst]].mean(axis=0)
            raise RegionError("curves lie so near to each other that an element would be flat near {}", middle)


def _check(region: Region, size: float, faces: str, growth: float) -> None:
    """MeshError where the values make no sense; what depends on geometry the triangulation finds."""
    if faces not in FACES:
        raise MeshError(f"faces is {faces!r}, expected one of {', '.join(FACES)}")
    if not (np.isfinite(size) and size > 0):
        raise MeshError(f"size is {size}, expected a positive number")
    if not (np.isfinite(growth) and growth > 0):
        raise MeshError(f"growth is {growth}, expected a positive number")
    n_point = len(region.points)
    if len(region.edges) == 0 or not region.is_boundary.any():
        raise MeshError("the region has no boundary")
    if not np.isfinite(region.points).all():
        bad = region.points[np.flatnonzero(~np.isfinite(region.points).all(axis=1))[0]]
        raise RegionError("the region has a point at {}", bad)
    if region.edges.min() < 0 or region.edges.max() >= n_point:
        raise MeshError(
            f"the region's edges name points from {region.edges.min()} to {region.edges.max()} of {n_point}"
        )
    boundary = region.edges[region.is_boundary]
    leaving = np.bincount(boundary[:, 0], minlength=n_point)
    arriving = np.bincount(boundary[:, 1], minlength=n_point)
    wanted = abs(enclosed_area(region)) / size**2
    if wanted > MOST_ELEMENTS:
        raise MeshError(f"a region meshed at size {size:.6g} would take some {wanted:.2g} elements")
    open_points = np.flatnonzero(leaving != arriving)
    if len(open_points):
        raise RegionError("the region's boundary is not closed at {}", region.points[open_points[0]])


def enclosed_area(region: Region) -> float:
    """Area enclosed by the boundary edges."""
    a, b = (region.points[region.edges[region.is_boundary, k]] for k in (0, 1))
    dx = b[:, 0] - a[:, 0]
    if region.period is not None:
        dx = shortest_way(dx, region.period)
    return -float((dx * (0.5 * (a[:, 1] + b[:, 1]) - region.points[0, 1])).sum())
