"""The surface of a shell segment, found again from its nodes: a plane, or a cylinder unrolled about a place.

A finished mesh carries no geometry; but csgmesh's plates are plane and its cylinder-plates round to rounding.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ON_SURFACE = 1e-6
"""Nodes nearer than this share of the segment's size to a surface lie on it."""

STEPS = 20
"""Gauss-Newton steps of the cylinder's fit; it converges in some five."""

WIDEST = 0.9 * np.pi
"""A place further round than this from where a cylinder is cut open is not unrolled."""


@dataclass(frozen=True, slots=True, eq=False)
class FittedPlane:
    """origin (3,), unit u and v (3,): x = origin + a u + b v."""

    origin: Array
    u: Array
    v: Array

    def flat(self, points: Array) -> Array:
        """(n, 2) of (n, 3) points, brought onto the plane."""
        return (points - self.origin) @ np.stack([self.u, self.v], axis=1)

    def lift(self, flat: Array) -> Array:
        """(n, 3) of (n, 2)."""
        lifted: Array = self.origin + flat @ np.stack([self.u, self.v])
        return lifted


@dataclass(frozen=True, slots=True, eq=False)
class FittedCylinder:
    """Unrolled about the direction u (unit, square to the axis): a = sign radius angle, b = along the axis."""

    origin: Array
    axis: Array
    u: Array
    radius: float
    sign: float = 1.0

    def flat(self, points: Array) -> Array:
        """(n, 2); angles from -pi to pi about u."""
        arms = points - self.origin
        angle = np.arctan2(arms @ np.cross(self.axis, self.u), arms @ self.u)
        return np.stack([self.sign * self.radius * angle, arms @ self.axis], axis=1)

    def lift(self, flat: Array) -> Array:
        """(n, 3) on the cylinder."""
        angle = self.sign * flat[:, 0] / self.radius
        around = np.outer(np.cos(angle), self.u) + np.outer(np.sin(angle), np.cross(self.axis, self.u))
        lifted: Array = self.origin + self.radius * around + np.outer(flat[:, 1], self.axis)
        return lifted

    def is_wide(self, flat: Array) -> bool:
        """Whether some of the places lie near where the cylinder is cut open."""
        return bool(np.abs(flat[:, 0]).max() > WIDEST * self.radius)


Fitted = FittedPlane | FittedCylinder


def fit_surface(points: Array, centres: Array, normals: Array, place: Array) -> Fitted | None:
    """The plane or cylinder on which points (n, 3) lie; None where they lie on neither.

    centres, normals: (m, 3) of elements, their unit normals to the side from which they run counter-clockwise.
    place: (3,) about which a cylinder is to be unrolled.
    """
    centre = points.mean(axis=0)
    size = float(np.linalg.norm(np.ptp(points, axis=0)))
    spread = np.linalg.svd(points - centre, full_matrices=False)[2]
    normal = spread[2] * (np.sign(spread[2] @ normals.mean(axis=0)) or 1.0)
    if np.abs((points - centre) @ normal).max() <= ON_SURFACE * size:
        u = spread[0]
        return FittedPlane(centre, u, np.cross(normal, u))
    fitted = _cylinder(points, normals, size)
    if fitted is None:
        return None
    origin, axis, radius = fitted
    arm = place - origin
    arm -= (arm @ axis) * axis
    u = arm / np.linalg.norm(arm)
    outward = float(np.sign((normals * (centres - origin)).sum()))
    return FittedCylinder(origin, axis, u, radius, outward)


def _cylinder(points: Array, normals: Array, size: float) -> tuple[Array, Array, float] | None:
    """(point on the axis, unit axis, radius) by Gauss-Newton on the distances from the axis."""
    axis = np.linalg.eigh(normals.T @ normals)[1][:, 0]
    centre = points.mean(axis=0)
    u, v = _across(axis)
    flat = (points - centre) @ np.stack([u, v], axis=1)
    rows = np.column_stack([2 * flat, np.ones(len(flat))])
    found = np.linalg.lstsq(rows, (flat**2).sum(axis=1), rcond=None)[0]
    origin = centre + found[0] * u + found[1] * v
    radius = float(np.sqrt(max(found[2] + found[0] ** 2 + found[1] ** 2, 0.0)))
    for _ in range(STEPS):
        u, v = _across(axis)
        arms = points - origin
        along = arms @ axis
        out = arms - np.outer(along, axis)
        distance = np.linalg.norm(out, axis=1)
        if distance.min() <= 0:
            return None
        e = out / distance[:, None]
        jacobian = -np.column_stack([e @ u, e @ v, along * (e @ u), along * (e @ v), np.ones(len(e))])
        step = np.linalg.lstsq(jacobian, radius - distance, rcond=None)[0]
        origin = origin + step[0] * u + step[1] * v
        axis = axis + step[2] * u + step[3] * v
        axis = axis / np.linalg.norm(axis)
        radius += float(step[4])
        if np.abs(step[[0, 1, 4]]).max() <= 1e-12 * size:
            break
    out = points - origin
    out = out - np.outer(out @ axis, axis)
    if radius <= 0 or np.abs(np.linalg.norm(out, axis=1) - radius).max() > ON_SURFACE * size:
        return None
    return origin, axis, radius


def _across(axis: Array) -> tuple[Array, Array]:
    """Two unit vectors square to the axis and to each other."""
    least = np.eye(3)[int(np.argmin(np.abs(axis)))]
    u = np.cross(axis, least)
    u /= np.linalg.norm(u)
    return u, np.cross(axis, u)
