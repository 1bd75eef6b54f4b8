"""A whole solid in tetrahedra whose boundary stands on the true surfaces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.mesh.fit import FittedTets, fit
from kernel.mesh.tets import DEADLINE, MEMORY, UnfitTets, default_envelope, tetrahedralise
from kernel.solid.brep import brep_of
from kernel.solid.solid import Solid

NARROWER = (1.0, 0.25, 0.0625)
"""Envelopes tried in turn, as shares of the default, until no face of the solid is lost."""

LOST_SHARE = 0.5
"""A face is lost where the boundary triangles along it have less than this share of its area."""

SMALL_FACE = 4.0
"""Faces whose area is below the square of this many envelopes may be lost: the size cannot show them."""


def mesh_solid(solid: Solid, size: float, deadline: float = DEADLINE, memory: int = MEMORY) -> FittedTets:
    """Tets of about `size` in the solid, boundary nodes and mid-side nodes on its true surfaces.

    deadline: seconds for each attempt; memory: bytes. MeshError: see tetrahedralise; or a face of the solid is lost
    at this size.
    """
    facets = solid.facets
    faces = brep_of(solid).faces
    areas = np.array([float(facets.areas[face.triangles].sum()) for face in faces])
    envelope = default_envelope(solid.volume, solid.area, solid.size, size)
    lost: NDArray[np.int64] = np.empty(0, np.int64)
    for share in NARROWER:
        narrow = share * envelope
        try:
            nodes, tets = tetrahedralise(
                facets.vertices, facets.triangles, size, deadline=deadline, memory=memory, envelope=narrow
            )
        except UnfitTets:
            if share == NARROWER[-1]:
                raise
            continue
        fitted = fit(solid, nodes, tets, narrow)
        lost = np.flatnonzero((fitted.face_areas < LOST_SHARE * areas) & (areas > (SMALL_FACE * envelope) ** 2))
        if not len(lost):
            return fitted
    x, y, z = faces[int(lost[0])].centroid
    raise MeshError(
        f"tetrahedra of size {size:g} lose {len(lost)} of the solid's {len(faces)} faces, the first at "
        f"({x:g}, {y:g}, {z:g}); take a smaller size"
    )
