"""Analytic surfaces, and the table that gives each one id however many primitives lie on it.

Every surface lives in the working frame (see solid.evaluate). The side of the material is not the surface's:
it comes from the triangles' outward normals.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Plane:
    """Points x with normal . x = offset. u, v: unit vectors with u x v = normal; `origin` = normal * offset."""

    normal: Vector
    offset: float
    u: Vector
    v: Vector


@dataclass(frozen=True, slots=True, eq=False)
class Axis:
    """Canonical line that coaxial surfaces share. x, y: unit vectors with x cross y = direction; angle 0 is x."""

    point: Vector
    direction: Vector
    x: Vector
    y: Vector


@dataclass(frozen=True, slots=True, eq=False)
class CylinderSurface:
    """Points at `radius` from `axis`; axis_id: the axis's index in the table."""

    axis: Axis
    axis_id: int
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class ConeSurface:
    """Apex on `axis`; slope = radius gained per unit of axial distance from the apex along +direction or -direction."""

    axis: Axis
    axis_id: int
    apex: Vector
    slope: float


@dataclass(frozen=True, slots=True, eq=False)
class SphereSurface:
    """Points at `radius` from `centre`."""

    centre: Vector
    radius: float


@dataclass(frozen=True, slots=True, eq=False)
class TorusSurface:
    """Tube of minor_radius about the circle of major_radius around `axis` through `centre`."""

    axis: Axis
    axis_id: int
    centre: Vector
    major_radius: float
    minor_radius: float


@dataclass(frozen=True, slots=True, eq=False)
class FacetedSurface:
    """No analytic form: the triangles are the surface (sheared cylinders, twisted extrusions, cuts)."""

    reason: str


Surface = Plane | CylinderSurface | ConeSurface | SphereSurface | TorusSurface | FacetedSurface
