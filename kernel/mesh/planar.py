"""The planar mesher's door: a seeded region in, a checked mesh on exactly those seeds out."""

from __future__ import annotations

from kernel.mesh.region import Region, RegionMesh


def mesh_region(region: Region, size: float, faces: str = "quad") -> RegionMesh:
    """Mesh a planar or periodic region with elements of about `size`.

    faces: "quad" or "tri". The first n_point nodes of the result are the region's points; every edge of the region is
    an edge of the mesh. MeshError, with the place, where the region cannot be meshed.
    """
    if region.period is not None:
        from kernel.mesh.unrolled import periodic_mesh

        return periodic_mesh(region, size, faces)
    if faces == "tri":
        from kernel.mesh.triangles import triangle_mesh

        return triangle_mesh(region, size)
    from kernel.mesh.quads import quad_mesh

    return quad_mesh(region, size)
