"""Points brought onto one, two or three surfaces at once."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kernel.solid.surfaces import FacetedSurface, Plane, Surface, outward, signed_distance

Array = NDArray[np.float64]

_ITERATIONS = 30
_SINGULAR = 1e-4
"""Surfaces that meet at less than this angle (radians) say nothing about the position along their tangent."""


def project(points: Array, surfaces: Sequence[Surface]) -> Array:
    """Points (n, 3) moved onto all of `surfaces` (one to three) by Newton steps of least length.

    Where surfaces touch instead of crossing, the position along their common tangent stays as it was.
    Faceted surfaces are left out of the conditions.
    """
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
