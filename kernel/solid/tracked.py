"""Closed triangle meshes as manifold solids whose triangles remember their surface and their primitive."""

from __future__ import annotations

import numpy as np
from manifold3d import Error, Manifold, Mesh64
from numpy.typing import NDArray

from kernel.solid.table import SurfaceTable

CUTTER = -1
"""Source of triangles that come from a cut, not from a primitive."""


class NotSolidError(Exception):
    """Triangles that bound no solid; the message says why, the caller says which."""


REASONS = {
    Error.NotManifold: "its surface is not closed, or not consistently oriented",
    Error.NonFiniteVertex: "a coordinate is not finite",
    Error.VertexOutOfBounds: "a face names a point that does not exist",
}


def check_status(manifold: Manifold) -> None:
    """NotSolidError where manifold reports an error (it does so as a status on an empty solid)."""
    status = manifold.status()
    if status != Error.NoError:
        raise NotSolidError(REASONS.get(status, f"the Boolean kernel reports {status.name}"))


def tracked_manifold(
    table: SurfaceTable,
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
    surface: NDArray[np.int64],
    source: int = CUTTER,
    *,
    inside_out: bool = False,
) -> Manifold:
    """vertices (n, 3), triangles (m, 3) counter-clockwise from outside, surface (m,) ids in the table.

    source: index of the primitive, noted in the table. inside_out: the triangles run the other way round.
    NotSolidError: the triangles bound no solid.
    """
    original = Manifold.reserve_ids(1)
    if source != CUTTER:
        table.sources[original] = source
    corners = np.ascontiguousarray(triangles[:, ::-1] if inside_out else triangles, dtype=np.uint64)
    manifold = Manifold(
        Mesh64(
            np.ascontiguousarray(vertices, dtype=np.float64),
            corners,
            run_index=np.array([0, 3 * len(corners)], dtype=np.uint64),
            run_original_id=np.array([original], dtype=np.uint32),
            face_id=np.ascontiguousarray(surface, dtype=np.uint64),
        )
    )
    check_status(manifold)
    return manifold
