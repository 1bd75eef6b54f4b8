"""Flat faces: the canonical planes of groups of triangles, and polyhedra given by polygons."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kernel.solid.lathe import triangulate_loops
from kernel.solid.surfaces import plane_frame
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import NotSolidError

PLANAR = 1e-6
"""Points of a polyhedron's face nearer to its plane than this share of the model's size are in it."""


def area_vectors(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """(m, 3) half the cross product of two sides: area times normal."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return 0.5 * np.cross(b - a, c - a)


def flat_faces(
    table: SurfaceTable, points: NDArray[np.float64], triangles: NDArray[np.int64], group: NDArray[np.int64]
) -> NDArray[np.int64]:
    """(m,) plane ids: the triangles of one group lie in one plane. Planes are registered in the order of the groups."""
    surface = np.empty(len(triangles), np.int64)
    if not len(triangles):  # an ellipsoid has no flat face
        return surface
    area = area_vectors(points, triangles)
    order = np.argsort(group, kind="stable")
    for rows in np.split(order, np.nonzero(np.diff(group[order]))[0] + 1):
        normal = area[rows].sum(axis=0)
        if not float(normal @ normal) > 0.0:
            raise NotSolidError("one of its faces has no area")
        surface[rows] = table.plane(normal, 0.0, through=points[np.unique(triangles[rows])])
    return surface


def polyhedron_mesh(
    points: NDArray[np.float64], faces: tuple[tuple[int, ...], ...], size: float
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """(vertices, triangles, group): faces clockwise from outside become counter-clockwise triangles.

    Repeated points become one. A face that is not flat is triangulated as a fan, each triangle a group of its own.
    A polyhedron that is inside out as a whole is turned. NotSolidError: a face without area, or the volume is 0.
    """
    if not np.isfinite(points).all():
        raise NotSolidError("a point is not finite")
    _, first, same = np.unique(np.round(points / (1e-12 * size)), axis=0, return_index=True, return_inverse=True)
    vertices, same = points[first], same.reshape(-1)
    triangles: list[NDArray[np.int64]] = []
    group: list[NDArray[np.int64]] = []
    count = 0
    for face in faces:
        if face and (min(face) < 0 or max(face) >= len(points)):
            raise NotSolidError(f"a face names point {max(face)}, expected 0 to {len(points) - 1}")
        corners = same[list(face)][::-1]
        corners = corners[corners != np.roll(corners, 1)]
        if len(corners) < 3:
            continue
        flat, is_flat = _face_triangles(vertices, corners, size)
        triangles.append(flat)
        group.append(np.full(len(flat), count) if is_flat else count + np.arange(len(flat)))
        count += 1 if is_flat else len(flat)
    if not triangles:
        raise NotSolidError("it has no face, expected at least four")
    mesh = np.concatenate(triangles)
    start, end = mesh.ravel(), mesh[:, [1, 2, 0]].ravel()
    if not np.array_equal(np.sort(start * len(vertices) + end), np.sort(end * len(vertices) + start)):
        raise NotSolidError("its surface is not closed, or not consistently oriented")
    area = area_vectors(vertices, mesh)
    volume = float(np.einsum("ij,ij->", area, vertices[mesh[:, 0]] - vertices[0])) / 3.0
    if volume == 0.0:
        raise NotSolidError("its volume is 0")
    return vertices, mesh if volume > 0.0 else mesh[:, ::-1], np.concatenate(group)


def _face_triangles(
    vertices: NDArray[np.float64], corners: NDArray[np.int64], size: float
) -> tuple[NDArray[np.int64], bool]:
    """Counter-clockwise triangles of one polygon, and whether it is flat."""
    if len(corners) == 3:
        return corners.reshape(1, 3), True
    ring = vertices[corners]
    arm = ring - ring[0]
    normal = np.cross(arm, np.roll(arm, -1, axis=0)).sum(axis=0)
    if not float(normal @ normal) > 0.0:
        raise NotSolidError("one of its faces has no area")
    frame = plane_frame(normal)
    if np.abs(arm @ frame.normal).max() > PLANAR * size:
        k = np.arange(1, len(corners) - 1)
        return np.stack([np.full(len(k), corners[0]), corners[k], corners[k + 1]], axis=1), False
    flat = triangulate_loops([np.stack([arm @ frame.u, arm @ frame.v], axis=1)])
    return corners[flat], True
