"""Saint-Venant torsion and shear of any connected section, by quadratic triangles on its outline.

With Poisson's ratio 0 (the usual choice for A / k) the three problems are one Laplacian with free boundaries:

    warping    div grad w = 0,          dw/dn = z n_y - y n_z     j = iyy + izz + integral (y w,z - z w,y)
    shear y    div grad p = -s_y(y, z), dp/dn = 0                 1 / shear_area_y = integral |grad p|^2
    shear z    the same with s_z                                  shear centre = moment of the shear flow grad p

s_y is the rate of bending stress along the beam for a unit shear force along y: linear, of zero mean, with
integral s_y y = 1 and integral s_y z = 0. Pilkey, Analysis and Design of Elastic Beams (2002), chapters 5 and 6.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.outline import SectionValues

if TYPE_CHECKING:
    from shapely import Polygon

SEEDS_PER_THICKNESS = 1.0
"""Boundary divisions per mean thickness 2 A / perimeter, before two uniform refinements."""

MAX_SEEDS = 1200
"""Bound on boundary divisions: sections thinner than 1/600 of their length are seeded less densely."""

REFINEMENTS = 2

DUST = 1e-9
"""Sides shorter than this times the perimeter are rounding of whoever made the outline."""

# Symmetric six-point rule, exact to degree 4 (Dunavant 1985), on the unit triangle.
_A, _B = 0.445948490915965, 0.091576213509771
_POINTS = np.array([[_A, _A], [1 - 2 * _A, _A], [_A, 1 - 2 * _A], [_B, _B], [1 - 2 * _B, _B], [_B, 1 - 2 * _B]])
_WEIGHTS = np.array([0.223381589678011] * 3 + [0.109951743655322] * 3) / 2

SHEAR_CENTRE_TOLERANCE = 1e-5
"""A shear centre nearer the centroid than this times the section's extent is the solution's error: written as 0."""


@dataclass(frozen=True, slots=True, eq=False)
class Warping:
    """What the finite element solution gives; shear_centre: (y, z) from the centroid.

    points: (n_point, 2) places in the section, from the centroid; areas: (n_point,) that they stand for; stress:
    (3, n_point, 2) shear stress (y, z) there under a unit torque, a unit shear force along y, and one along z, the
    forces in the shear centre.
    """

    j: float
    shear_area_y: float
    shear_area_z: float
    shear_centre: tuple[float, float]
    points: NDArray[np.float64]
    areas: NDArray[np.float64]
    stress: NDArray[np.float64]


def solve_warping(polygon: Polygon, exact: SectionValues) -> Warping:
    """Torsion constant, shear areas and shear centre of one connected polygon."""
    points, triangles = triangulate(polygon)
    points = points - np.asarray(exact.centroid)
    scale = float(np.sqrt(exact.area))
    nodes, elements = _quadratic(points / scale, triangles)
    return _solve(nodes, elements, scale, polygon)


def triangulate(polygon: Polygon) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """(n, 2) points and (m, 3) counter-clockwise triangles that fill the polygon exactly."""
    import shapely

    spacing = max(2 * polygon.area / polygon.length / SEEDS_PER_THICKNESS, polygon.length / MAX_SEEDS)
    clean = polygon.simplify(DUST * polygon.length)
    pieces = shapely.constrained_delaunay_triangles(shapely.segmentize(clean, spacing)).geoms
    corners = np.array([np.asarray(piece.exterior.coords)[:3, :2] for piece in pieces])
    points, index = np.unique(corners.reshape(-1, 2), axis=0, return_inverse=True)
    triangles = index.reshape(-1, 3).astype(np.int64)
    clockwise = _doubled_areas(points, triangles) < 0
    triangles[clockwise] = triangles[clockwise][:, [0, 2, 1]]
    for _ in range(REFINEMENTS):
        nodes, six = _quadratic(points, triangles)
        points = nodes
        triangles = np.concatenate([six[:, p] for p in ([0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5])])
    return points, triangles


def _doubled_areas(points: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


def _quadratic(
    points: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Mid-side nodes added behind the points: (m, 6) in the order corners, 01, 12, 20."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    middle = points[unique].mean(axis=1)
    return np.vstack([points, middle]), np.hstack([triangles, len(points) + index.reshape(-1, 3)])


def _shapes() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Values (6, 6) and derivatives (6, 2, 6) of the quadratic shape functions at the integration points."""
    x, y = _POINTS.T
    l0 = 1 - x - y
    zero = np.zeros_like(x)
    values = np.stack([l0 * (2 * l0 - 1), x * (2 * x - 1), y * (2 * y - 1), 4 * l0 * x, 4 * x * y, 4 * y * l0], axis=1)
    d_x = np.stack([1 - 4 * l0, 4 * x - 1, zero, 4 * (l0 - x), 4 * y, -4 * y], axis=1)
    d_y = np.stack([1 - 4 * l0, zero, 4 * y - 1, -4 * x, 4 * x, 4 * (l0 - y)], axis=1)
    return values, np.stack([d_x, d_y], axis=1)


def _solve(nodes: NDArray[np.float64], elements: NDArray[np.int64], scale: float, polygon: Polygon) -> Warping:
    """Assemble one Laplacian, solve for warping and the two shears; all in units of sqrt(area)."""
    from scipy.sparse import coo_matrix
    from scipy.sparse.linalg import splu

    values, local = _shapes()
    a, b, c = (nodes[elements[:, k]] for k in range(3))
    jacobian = np.stack([b - a, c - a], axis=1)  # (m, 2, 2): straight sides, so constant
    weight = np.abs(np.linalg.det(jacobian))[:, None] * _WEIGHTS  # (m, q)
    gradient = np.einsum("mij,qjn->mqin", np.linalg.inv(jacobian), local)  # (m, q, 2, 6)
    place = np.einsum("qn,mni->mqi", values, nodes[elements])  # (m, q, 2)
    y, z = place[..., 0], place[..., 1]

    def load(per_node: NDArray[np.float64]) -> NDArray[np.float64]:
        total = np.zeros(len(nodes))
        np.add.at(total, elements, per_node)
        return total

    stiffness = np.einsum("mq,mqin,mqik->mnk", weight, gradient, gradient)
    rows, columns = np.repeat(elements, 6, axis=1).ravel(), np.tile(elements, (1, 6)).ravel()
    matrix = coo_matrix((stiffness.ravel(), (rows, columns)), shape=(len(nodes), len(nodes))).tocsc()

    # shear: s = alpha y + beta z with unit resultant along y (z)
    yy, zz, yz = (weight * y * y).sum(), (weight * z * z).sum(), (weight * y * z).sum()
    inverse = np.linalg.inv(np.array([[yy, yz], [yz, zz]]))
    turned = np.stack([z, -y], axis=-1)  # the torsion problem in weak form: (grad w, grad v) = (turned, grad v)
    loads = [load(np.einsum("mq,mqi,mqin->mn", weight, turned, gradient))]
    for alpha, beta in inverse:
        loads.append(load(np.einsum("mq,mq,qn->mn", weight, alpha * y + beta * z, values)))
    # one node is held: the potential's constant is free
    solution = np.zeros((len(nodes), 3))
    solution[1:] = splu(matrix[1:, 1:]).solve(np.column_stack(loads)[1:])

    flow = np.einsum("mqin,mnk->kmqi", gradient, solution[elements])  # (3, m, q, 2)
    moment = [(weight * (y * f[..., 1] - z * f[..., 0])).sum() for f in flow]
    energy = [(weight * (f**2).sum(axis=-1)).sum() for f in flow]
    shear_centre = np.array([moment[2], -moment[1]]) * scale
    extent = max(polygon.bounds[2] - polygon.bounds[0], polygon.bounds[3] - polygon.bounds[1])
    shear_centre[np.abs(shear_centre) < SHEAR_CENTRE_TOLERANCE * extent] = 0.0
    j = float(yy + zz + moment[0])
    torsion = (flow[0] - turned) / (j * scale**3)  # of w,y - z and w,z + y: the strains of unit twist
    stress = np.stack([torsion, flow[1] / scale**2, flow[2] / scale**2])
    return Warping(
        j=j * scale**4,
        shear_area_y=scale**2 / float(energy[1]),
        shear_area_z=scale**2 / float(energy[2]),
        shear_centre=(float(shear_centre[0]), float(shear_centre[1])),
        points=place.reshape(-1, 2) * scale,
        areas=weight.ravel() * scale**2,
        stress=stress.reshape(3, -1, 2),
    )
