"""Volume, centre and second moments, of the finite element model and of a solid's triangles."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.shapes import integration_rule, jacobians, measures

if TYPE_CHECKING:
    from kernel.connect.model import Property
    from kernel.mesh.mesh import ElementBlock

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Moments:
    """mass; centre: (3,); second: (3, 3) integral of x x^T dm about the centre."""

    mass: float
    centre: Array
    second: Array

    @property
    def inertia(self) -> Array:
        """(3, 3) inertia tensor about the centre."""
        return np.trace(self.second) * np.eye(3) - self.second


def total(parts: Sequence[Moments]) -> Moments:
    """All parts together."""
    mass = sum(part.mass for part in parts)
    if mass == 0:
        return Moments(0.0, np.zeros(3), np.zeros((3, 3)))
    centre = np.sum([part.mass * part.centre for part in parts], axis=0) / mass
    second = np.zeros((3, 3))
    for part in parts:
        arm = part.centre - centre
        second += part.second + part.mass * np.outer(arm, arm)
    return Moments(float(mass), centre, second)


def block_moments(block: ElementBlock, nodes: Array, element: Property, density: float) -> Moments:
    """Of one block of elements, with beams' sections and shells' thickness at their true extent."""
    places = nodes[block.connectivity]
    rule = integration_rule(block.kind)
    jacobian = jacobians(places, rule)
    weight = measures(jacobian) * rule.weights * density * element.density_factor
    across = np.zeros((3, 3))
    if element.kind == "shell":
        assert element.thickness is not None
        weight = weight * element.thickness
        normal = np.cross(jacobian[:, :, 0], jacobian[:, :, 1])
        normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
        across = element.thickness**2 / 12 * np.einsum("eq,eqi,eqj->ij", weight, normal, normal)
    elif element.kind == "beam":
        assert element.section is not None and block.orientation is not None
        section = element.section
        weight = weight * section.area
        y, z = section_axes(places[:, 0], places[:, 1], block.orientation)
        per_element = weight.sum(axis=1) / section.area
        yz = np.einsum("e,ei,ej->ij", per_element, y, z)
        across = (
            section.izz * np.einsum("e,ei,ej->ij", per_element, y, y)
            + section.iyy * np.einsum("e,ei,ej->ij", per_element, z, z)
            + section.iyz * (yz + yz.T)
        )
    points = np.einsum("qn,enk->eqk", rule.values, places).reshape(-1, 3)
    flat = weight.ravel()
    mass = float(flat.sum())
    centre = flat @ points / mass if mass else np.zeros(3)
    arm = points - centre
    return Moments(mass, centre, np.einsum("p,pi,pj->ij", flat, arm, arm) + across)


def section_axes(start: Array, end: Array, orientation: Array) -> tuple[Array, Array]:
    """Unit y (in the plane of axis and orientation) and z = x cross y of line elements, each (n, 3)."""
    x = end - start
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    y = orientation - (orientation * x).sum(axis=1, keepdims=True) * x
    y = y / np.linalg.norm(y, axis=1, keepdims=True)
    return y, np.cross(x, y)


def solid_moments(vertices: Array, triangles: NDArray[np.int64], volume: float) -> Moments:
    """Of the body inside closed, outward triangles, scaled to its true volume; density 1."""
    origin = vertices.mean(axis=0)
    a, b, c = (vertices[triangles[:, k]] - origin for k in range(3))
    six = np.einsum("ni,ni->n", a, np.cross(b, c))
    facet_volume = six.sum() / 6
    centre = ((a + b + c) * six[:, None]).sum(axis=0) / 24 / facet_volume
    s = a + b + c
    second = np.einsum("n,ni,nj->ij", six, s, s)
    for corner in (a, b, c):
        second += np.einsum("n,ni,nj->ij", six, corner, corner)
    second = second / 120 - facet_volume * np.outer(centre, centre)
    return Moments(volume, centre + origin, second * (volume / facet_volume) ** (5 / 3))
