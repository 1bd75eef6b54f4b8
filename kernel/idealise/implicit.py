"""Points brought onto one, two or three surfaces at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kernel.solid.surfaces import FacetedSurface, Plane, Surface, outward, signed_distance

Array = NDArray[np.float64]
Vector = tuple[float, float, float]

_ITERATIONS = 30
_SINGULAR = 1e-4
"""Surfaces that meet at less than this angle (radians) say nothing about the position along their tangent."""

_FLAT = 1e-3
"""Three unit normals that span more than this volume are all of them determined: no singular value is then below
_SINGULAR of the largest."""


def project(points: Array, surfaces: Sequence[Surface]) -> Array:
    """Points (n, 3) moved onto all of `surfaces` (one to three) by Newton steps of least length.

    Where surfaces touch instead of crossing, the position along their common tangent stays as it was.
    Faceted surfaces are left out of the conditions.
    """
    planes = [surface for surface in surfaces if isinstance(surface, Plane)]
    if len(points) == 1 and len(planes) == len(surfaces) <= 3:
        found = _onto_planes(points[0].tolist(), planes)
        if found is not None:
            return np.array([found])
    equations = [surface for surface in surfaces if not isinstance(surface, FacetedSurface)]
    moved = np.array(points, dtype=np.float64).reshape(-1, 3)
    if not equations or not len(moved):
        return moved
    scale = max(float(np.abs(moved).max()), np.finfo(float).tiny)
    inverse = _inverse_of_planes(equations)
    for _ in range(_ITERATIONS):
        residual = np.stack([signed_distance(surface, moved) for surface in equations], axis=1)
        if inverse is not None:
            step = np.einsum("ij,nj->ni", inverse, residual)
        else:
            jacobian = np.stack([outward(surface, moved) for surface in equations], axis=1)
            step = _least_step(jacobian, residual)
        moved = moved - step
        if np.abs(step).max() < 1e-15 * scale:
            break
    return moved


def _onto_planes(point: Sequence[float], planes: Sequence[Plane]) -> Vector | None:
    """The same for one point and planes, in plain numbers: on single points arrays cost ten times as much.

    None where the planes meet at so little an angle that they say nothing about some direction.
    """
    normals: list[Vector] = [tuple(plane.normal.tolist()) for plane in planes]
    columns = _columns(normals)
    if columns is None:
        return None
    x, y, z = point
    smallest = 1e-15 * max(abs(x), abs(y), abs(z), np.finfo(float).tiny)
    for _ in range(_ITERATIONS):
        dx = dy = dz = 0.0
        for (a, b, c), plane, (u, v, w) in zip(normals, planes, columns):
            residual = a * x + b * y + c * z - plane.offset
            dx, dy, dz = dx + u * residual, dy + v * residual, dz + w * residual
        x, y, z = x - dx, y - dy, z - dz
        if max(abs(dx), abs(dy), abs(dz)) < smallest:
            break
    return x, y, z


def _columns(normals: Sequence[Vector]) -> list[Vector] | None:
    """The columns of the pseudo-inverse of one to three unit normals, None where it is not well determined."""
    if len(normals) == 1:
        return list(normals)
    first, second = normals[0], normals[1]
    if len(normals) == 2:
        cosine = _dot(first, second)
        square = 1.0 - cosine * cosine
        if square <= _SINGULAR:
            return None
        pairs = ((first, second), (second, first))
        return [
            ((u - cosine * a) / square, (v - cosine * b) / square, (w - cosine * c) / square)
            for (u, v, w), (a, b, c) in pairs
        ]
    third = normals[2]
    across = (_cross(second, third), _cross(third, first), _cross(first, second))
    volume = _dot(first, across[0])
    if abs(volume) <= _FLAT:
        return None
    return [(a / volume, b / volume, c / volume) for a, b, c in across]


def _dot(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _cross(a: Vector, b: Vector) -> Vector:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _inverse_of_planes(surfaces: Sequence[Surface]) -> Array | None:
    """What takes the residuals of three planes to a step, (3, 3), wherever the points are; None for other surfaces."""
    normals = [surface.normal for surface in surfaces if isinstance(surface, Plane)]
    if len(normals) < 3 or len(surfaces) > 3:
        return None
    return np.linalg.pinv(np.array(normals), rcond=_SINGULAR)


def _least_step(jacobian: Array, residual: Array) -> Array:
    """The shortest vectors (n, 3) with jacobian (n, k, 3) times step = residual (n, k)."""
    if jacobian.shape[1] == 1:
        return jacobian[:, 0] * residual
    if jacobian.shape[1] == 2:
        first, second = jacobian[:, 0], jacobian[:, 1]
        cosine = np.einsum("ni,ni->n", first, second)[:, None]
        sine_square = 1.0 - cosine * cosine
        if (sine_square > _SINGULAR).all():
            a, b = residual[:, :1], residual[:, 1:]
            return ((a - cosine * b) * first + (b - cosine * a) * second) / sine_square
    return np.einsum("nij,nj->ni", np.linalg.pinv(jacobian, rcond=_SINGULAR), residual)
