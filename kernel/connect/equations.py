"""Couplings as linear equations: each dependent freedom in terms of independent ones.

RBE2   u_d = u_i + theta_i x (x_d - x_i),  theta_d = theta_i
RBE3   the rigid motion that fits the weighted independent translations best, taken at the dependent node:
       centre c = sum w x / sum w,  r = x - c,  I = sum w (r.r 1 - r r^T),
       theta = I^-1 sum w r x u,    u_d = sum w u / sum w + theta x (x_d - c)
MPC    as it stands, solved for its first term
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from kernel.connect.model import Coupling, Mpc, Rbe2, Rbe3

Array = NDArray[np.float64]
Freedom = tuple[int, int]
"""(node, component 1-6)."""

Expression = dict[Freedom, float]

NEGLIGIBLE = 1e-14
"""Coefficients smaller than this are left out."""


def cross_matrix(vector: Array) -> Array:
    """(3, 3) matrix K with K @ a = vector x a."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def average_matrices(points: Array, weights: Array, place: Array) -> tuple[Array, Array]:
    """Translation and rotation at `place` of the best rigid fit: two (3, n, 3) arrays on the points' translations."""
    share = weights / weights.sum()
    centre = share @ points
    arms = points - centre
    inertia = np.einsum("n,nk,nk->", share, arms, arms) * np.eye(3) - np.einsum("n,ni,nj->ij", share, arms, arms)
    turn = np.einsum("n,nij->inj", share, np.stack([cross_matrix(arm) for arm in arms]))  # sum w r x u
    rotation = np.einsum("ij,jnk->ink", np.linalg.inv(inertia), turn)
    translation = np.einsum("n,ik->ink", share, np.eye(3)) - np.einsum(
        "ij,jnk->ink", cross_matrix(place - centre), rotation
    )
    return translation, rotation


def rows(coupling: Coupling, nodes: Array) -> Iterator[tuple[Freedom, Expression]]:
    """Every dependent freedom of the coupling with its expression."""
    if isinstance(coupling, Rbe2):
        yield from _rigid_rows(coupling, nodes)
    elif isinstance(coupling, Rbe3):
        yield from _average_rows(coupling, nodes)
    else:
        yield _equation_row(coupling)


def rigid_row(dependent: int, component: int, independent: int, nodes: Array) -> Expression:
    """Expression of one freedom of a node that follows another rigidly."""
    if component > 3:
        return {(independent, component): 1.0}
    turn = -cross_matrix(nodes[dependent] - nodes[independent])  # theta x r = -r x theta
    row: Expression = {(independent, component): 1.0}
    row.update({(independent, 4 + k): float(v) for k, v in enumerate(turn[component - 1]) if v != 0})
    return row


def _rigid_rows(coupling: Rbe2, nodes: Array) -> Iterator[tuple[Freedom, Expression]]:
    for node in coupling.dependent:
        for component in map(int, coupling.components):
            row = rigid_row(int(node), component, coupling.independent, nodes)
            yield (int(node), component), row


def _average_rows(coupling: Rbe3, nodes: Array) -> Iterator[tuple[Freedom, Expression]]:
    matrices = average_matrices(nodes[coupling.independent], coupling.weights, nodes[coupling.dependent])
    for component in map(int, coupling.components):
        matrix = matrices[(component - 1) // 3][(component - 1) % 3]
        row = {
            (int(node), k + 1): float(matrix[n, k])
            for n, node in enumerate(coupling.independent)
            for k in range(3)
            if abs(matrix[n, k]) > NEGLIGIBLE
        }
        yield (coupling.dependent, component), row


def _equation_row(coupling: Mpc) -> tuple[Freedom, Expression]:
    row: Expression = {}
    for node, component, value in zip(coupling.nodes[1:], coupling.components[1:], coupling.coefficients[1:]):
        freedom = (int(node), int(component))
        row[freedom] = row.get(freedom, 0.0) - float(value) / float(coupling.coefficients[0])
    return (int(coupling.nodes[0]), int(coupling.components[0])), row


def equation(dependent: Freedom, row: Expression) -> Mpc:
    """The expression as an equation: dependent with coefficient -1, then the terms in order of freedom."""
    terms = sorted((freedom, value) for freedom, value in row.items() if abs(value) > NEGLIGIBLE)
    return Mpc(
        nodes=np.array([dependent[0], *(freedom[0] for freedom, _ in terms)], dtype=np.int64),
        components=np.array([dependent[1], *(freedom[1] for freedom, _ in terms)], dtype=np.int64),
        coefficients=np.array([-1.0, *(value for _, value in terms)]),
    )


def rigid_motion_error(coupling: Coupling, nodes: Array, centre: Array, size: float) -> float:
    """Largest residual of the coupling's equations under the six unit rigid motions about `centre`.

    Rotations are of one radian over `size`, so that both kinds of motion move the model by about one.
    """
    worst = 0.0
    for freedom, row in rows(coupling, nodes):
        residual = -_motions(freedom, nodes, centre, size)
        for term, value in row.items():
            residual = residual + value * _motions(term, nodes, centre, size)
        scale = 1.0 if freedom[1] <= 3 else size  # a rotation is 1 / size
        worst = max(worst, float(np.abs(residual).max()) * scale)
    return worst


def rigid_links_error(couplings: Sequence[Rbe2], nodes: Array, centre: Array, size: float) -> float:
    """The largest rigid_motion_error of many RBE2 at once.

    Their rotations follow exactly, and in translations so do their residuals under translations: what is left is
    theta x (x_d - c) against theta x (x_i - c) + theta x (x_d - x_i).
    """
    if not couplings:
        return 0.0
    counts = [len(coupling.dependent) for coupling in couplings]
    dependent = np.concatenate([coupling.dependent for coupling in couplings])
    independent = np.repeat([coupling.independent for coupling in couplings], counts)
    held = np.array([[str(k) in coupling.components for k in (1, 2, 3)] for coupling in couplings])
    arms = nodes[dependent] - nodes[independent]
    turns = (
        -_cross_matrices((nodes[dependent] - centre) / size),
        -_cross_matrices((nodes[independent] - centre) / size),
        -_cross_matrices(arms) * (1 / size),
    )
    residual = -turns[0] + turns[1] + turns[2]
    return float(np.abs(residual[np.repeat(held, counts, axis=0)]).max(initial=0.0))


def _cross_matrices(vectors: Array) -> Array:
    """(n, 3, 3) cross_matrix of each of the vectors (n, 3)."""
    matrices = np.zeros((len(vectors), 3, 3))
    x, y, z = vectors.T
    matrices[:, 0, 1], matrices[:, 0, 2], matrices[:, 1, 2] = -z, y, -x
    matrices[:, 1, 0], matrices[:, 2, 0], matrices[:, 2, 1] = z, -y, x
    return matrices


def _motions(freedom: Freedom, nodes: Array, centre: Array, size: float) -> Array:
    """(6,) value of one freedom in each of the six rigid motions."""
    node, component = freedom
    values = np.zeros(6)
    if component > 3:
        values[component - 1] = 1 / size
        return values
    values[component - 1] = 1.0
    turn = -cross_matrix((nodes[node] - centre) / size)
    values[3:] = turn[component - 1]
    return values
