"""The planar mesher's door: a seeded region in, a checked mesh on exactly those seeds out.

The meshers behind it are imported when they are needed: numba takes a third of a second to import.
"""

from __future__ import annotations

import numpy as np

from kernel.errors import MeshError
from kernel.mesh.region import Region, RegionMesh

FACES = ("quad", "tri", "mixed")


def mesh_region(region: Region, size: float, faces: str = "quad") -> RegionMesh:
    """Mesh a planar or periodic region with elements of about `size`.

    faces: "quad": all quads (a few triangles only where curves lie so near to each other that quads would be bad),
    which asks for an even number of edges on each curve; "mixed": the same on any number; "tri": all triangles.
    The first n_point nodes of the result are the region's points; every edge of the region is an edge of the mesh;
    no element is inverted and no quad under a scaled Jacobian of 0.2. MeshError, with the place, where the region
    cannot be meshed: a boundary that is no ring, points or edges that meet where they should not, an odd curve.
    """
    _check(region, size, faces)
    if faces != "tri":
        from kernel.mesh.structured import structured_mesh

        mesh = structured_mesh(region, size)
        if mesh is not None:
            return mesh
    if region.period is not None:
        from kernel.mesh.unrolled import periodic_mesh

        return periodic_mesh(region, size, faces)
    if faces == "tri":
        from kernel.mesh.triangles import triangle_mesh

        return triangle_mesh(region, size)
    if faces == "mixed":
        from kernel.mesh.mixed import mixed_mesh

        return mixed_mesh(region, size)
    from kernel.mesh.quads import quad_mesh

    return quad_mesh(region, size)


def _check(region: Region, size: float, faces: str) -> None:
    """MeshError where the values make no sense; what depends on geometry the triangulation finds."""
    if faces not in FACES:
        raise MeshError(f"faces is {faces!r}, expected one of {', '.join(FACES)}")
    if not (np.isfinite(size) and size > 0):
        raise MeshError(f"size is {size}, expected a positive number")
    n_point = len(region.points)
    if len(region.edges) == 0 or not region.is_boundary.any():
        raise MeshError("the region has no boundary")
    if not np.isfinite(region.points).all():
        x, y = region.points[np.flatnonzero(~np.isfinite(region.points).all(axis=1))[0]]
        raise MeshError(f"the region has a point at ({x}, {y})")
    if region.edges.min() < 0 or region.edges.max() >= n_point:
        raise MeshError(
            f"the region's edges name points from {region.edges.min()} to {region.edges.max()} of {n_point}"
        )
    boundary = region.edges[region.is_boundary]
    leaving = np.bincount(boundary[:, 0], minlength=n_point)
    arriving = np.bincount(boundary[:, 1], minlength=n_point)
    open_points = np.flatnonzero(leaving != arriving)
    if len(open_points):
        x, y = region.points[open_points[0]]
        raise MeshError(f"the region's boundary is not closed at ({x:.6g}, {y:.6g})")
