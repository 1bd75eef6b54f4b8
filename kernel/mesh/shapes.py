"""Shape functions and integration rules of every element kind, as arrays over the rule's points.

Reference elements: lines, quads and hexes on [-1, 1]; triangles and tets on the unit simplex; wedges a unit triangle
by [-1, 1]. Node orders are elements.py's. Serendipity functions: Zienkiewicz and Taylor, The Finite Element Method,
volume 1, chapter 8; the wedge of 15 nodes: the same construction, as in Abaqus Theory, 3.2.6.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.elements import ELEMENT_KINDS

Array = NDArray[np.float64]

FOOT_STEPS = 12
"""Of Gauss-Newton; on a flat face one does."""

FOOT_STAYS = 1e-13
"""A step in local coordinates that is but rounding."""

_LINE = np.array([[-1.0], [1.0]])
_QUAD = np.array([[-1.0, -1], [1, -1], [1, 1], [-1, 1]])
_HEX = np.vstack([np.column_stack([_QUAD, np.full(4, z)]) for z in (-1.0, 1.0)])
_TRI = np.array([[0.0, 0], [1, 0], [0, 1]])
_TET = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
_WEDGE = np.vstack([np.column_stack([_TRI, np.full(3, z)]) for z in (-1.0, 1.0)])
_CORNERS = {"line": _LINE, "tri": _TRI, "quad": _QUAD, "tet": _TET, "wedge": _WEDGE, "hex": _HEX}


@dataclass(frozen=True, slots=True, eq=False)
class Rule:
    """values: (n_point, n_node); derivatives: (n_point, dimension, n_node); weights: (n_point,)."""

    values: Array
    derivatives: Array
    weights: Array


def family(kind: str) -> str:
    """`quad` of `quad8`."""
    return kind.rstrip("0123456789")


def reference_nodes(kind: str) -> Array:
    """(n_node, dimension) places of the nodes in the reference element."""
    element = ELEMENT_KINDS[kind]
    corners = _CORNERS[family(kind)]
    if element.order == 1:
        return corners
    return np.vstack([corners, *(corners[list(edge)].mean(axis=0) for edge in element.edges)])


def shape_values(kind: str, points: Array) -> Array:
    """(n_point, n_node) shape functions at points of the reference element."""
    terms, inverse = _monomials(kind)
    return _powers(points, terms) @ inverse


def shape_derivatives(kind: str, points: Array) -> Array:
    """(n_point, dimension, n_node) derivatives along the reference coordinates."""
    terms, inverse = _monomials(kind)
    rows = []
    for axis in range(points.shape[1]):
        lowered = terms.copy()
        lowered[:, axis] = np.maximum(lowered[:, axis] - 1, 0)
        rows.append((_powers(points, lowered) * terms[:, axis]) @ inverse)
    return np.stack(rows, axis=1)


def foot_on_face(kind: str, corners: Array, place: Array) -> Array:
    """Local coordinates (2,) of the foot of a place (3,) on a face (n_node, 3), which goes on beyond its rim.

    Gauss-Newton on the distance; no further out than three faces away.
    """
    local = np.full(2, 1 / 3) if family(kind) == "tri" else np.zeros(2)
    for _ in range(FOOT_STEPS):
        off = place - shape_values(kind, local[None])[0] @ corners
        tangents = shape_derivatives(kind, local[None])[0] @ corners  # (2, 3)
        step = np.linalg.lstsq(tangents.T, off, rcond=None)[0]
        local = np.clip(local + step, -3, 3)
        if np.abs(step).max() < FOOT_STAYS:
            break
    return local


def beyond_rim(kind: str, local: Array) -> float:
    """How far local coordinates (2,) lie outside of a face, 0 within it."""
    if family(kind) == "tri":
        return max(0.0, -float(local.min()), float(local.sum()) - 1)
    return max(0.0, float(np.abs(local).max()) - 1)


@cache
def integration_rule(kind: str) -> Rule:
    """A rule that integrates the element's volume and second moments; exact for straight-sided elements."""
    points, weights = _points(family(kind))
    return Rule(shape_values(kind, points), shape_derivatives(kind, points), weights)


@cache
def corner_rule(kind: str) -> Rule:
    """Values and derivatives at all the element's nodes (weights 1): where Jacobians are judged."""
    points = reference_nodes(kind)
    return Rule(shape_values(kind, points), shape_derivatives(kind, points), np.ones(len(points)))


def jacobians(places: Array, rule: Rule) -> Array:
    """(n_element, n_point, dimension, 3): rows are the derivatives of place along the reference coordinates.

    places: (n_element, n_node, 3) of the elements' nodes.
    """
    return np.einsum("qdn,enk->eqdk", rule.derivatives, places)


def measures(jacobian: Array) -> Array:
    """Length, area or signed volume density (n_element, n_point) of jacobians(...)."""
    dimension = jacobian.shape[2]
    if dimension == 1:
        return np.linalg.norm(jacobian[:, :, 0], axis=-1)
    if dimension == 2:
        return np.linalg.norm(np.cross(jacobian[:, :, 0], jacobian[:, :, 1]), axis=-1)
    return np.linalg.det(jacobian)


def doubled_normals(corners: Array) -> Array:
    """(n, 3) normals of triangles or quads (n, 3 or 4, 3), as long as twice their areas; of quads the mean one."""
    if corners.shape[1] == 3:
        return np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.cross(corners[:, 2] - corners[:, 0], corners[:, 3] - corners[:, 1])


def _powers(points: Array, terms: NDArray[np.int64]) -> Array:
    return np.prod(points[:, None, :] ** terms[None, :, :], axis=2)


@cache
def _monomials(kind: str) -> tuple[NDArray[np.int64], Array]:
    """Exponents (n_node, dimension) of the element's monomials, and the matrix that makes shape functions of them."""
    nodes = reference_nodes(kind)
    dimension, order = nodes.shape[1], ELEMENT_KINDS[kind].order
    name = family(kind)
    grid = np.array(np.meshgrid(*[range(order + 1)] * dimension, indexing="ij")).reshape(dimension, -1).T
    total = grid.sum(axis=1)
    if name in ("tri", "tet"):
        terms = grid[total <= order]
    elif name == "wedge":  # full order in the triangle times the axis; at second order without x^i y^j z^2, i + j = 2
        plane = grid[:, :2].sum(axis=1)
        terms = grid[(plane <= order) & ((grid[:, 2] < 2) | (plane < 2))]
    elif order == 1:
        terms = grid
    else:  # serendipity: at most one exponent is 2, the others at most 1
        terms = grid[(grid == 2).sum(axis=1) <= 1]
    inverse: Array = np.asarray(np.linalg.inv(_powers(nodes, terms)), dtype=np.float64)
    return terms.astype(np.int64), inverse


def _points(name: str) -> tuple[Array, Array]:
    """Points and weights of the reference element: exact for polynomials of degree 4 at least."""
    g, w = np.polynomial.legendre.leggauss(3)
    if name in ("line", "quad", "hex"):
        dimension = {"line": 1, "quad": 2, "hex": 3}[name]
        points = np.array(np.meshgrid(*[g] * dimension, indexing="ij")).reshape(dimension, -1).T
        weights = np.prod(np.array(np.meshgrid(*[w] * dimension, indexing="ij")).reshape(dimension, -1), axis=0)
        return points, weights
    half, half_weight = (g + 1) / 2, w / 2
    if name == "tet":  # collapsed cube
        g4, w4 = np.polynomial.legendre.leggauss(4)
        a, b, c = np.array(np.meshgrid(*[(g4 + 1) / 2] * 3, indexing="ij")).reshape(3, -1)
        weights = np.prod(np.array(np.meshgrid(*[w4 / 2] * 3, indexing="ij")).reshape(3, -1), axis=0)
        points = np.column_stack([a, b * (1 - a), c * (1 - a) * (1 - b)])
        return points, weights * (1 - a) ** 2 * (1 - b)
    g4, w4 = np.polynomial.legendre.leggauss(4)
    a, b = np.array(np.meshgrid((g4 + 1) / 2, half, indexing="ij")).reshape(2, -1)
    weights = np.outer(w4 / 2, half_weight).ravel() * (1 - a)
    triangle = np.column_stack([a, b * (1 - a)])
    if name == "tri":
        return triangle, weights
    points = np.vstack([np.column_stack([triangle, np.full(len(triangle), z)]) for z in g])
    return points, np.concatenate([weights * k for k in w])
