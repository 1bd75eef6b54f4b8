"""Holding a model anywhere that holds it, for solutions under its own weight."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from verification.loading import dependent_nodes

from kernel.connect.audit import component_labels
from kernel.connect.model import Model
from kernel.mesh.elements import ELEMENT_KINDS

GRIPS = (1e-6, 0.02, 0.1, 0.25)
"""How deep a support may reach into a piece, of its extent: the first that holds it."""


def holding_nodes(model: Model) -> list[int]:
    """Nodes that, held in all their freedoms, leave no piece of the model a rigid motion: an end of each piece."""
    bound = dependent_nodes(model)
    labels = component_labels(model)
    needed = _needed_rank(model)
    held: list[int] = []
    for label in np.unique(labels):
        free = np.array([node for node in np.flatnonzero(labels == label) if node not in bound])
        held += _end(model.mesh.nodes, free, needed)
    return sorted(held)


def _end(nodes: NDArray[np.float64], free: NDArray[np.int64], needed: NDArray[np.int64]) -> list[int]:
    """The end of the longest side that is enough to hold the piece."""
    extents = np.ptp(nodes[free], axis=0)
    for grip in GRIPS:
        for axis in np.argsort(-extents, kind="stable"):
            along = nodes[free, axis]
            end = free[along <= along.min() + grip * extents[axis]]
            if len(end) < len(free) and _rank(nodes[end]) >= needed[end].min():
                return end.tolist()
    raise AssertionError("no end of the piece holds it")


def _needed_rank(model: Model) -> NDArray[np.int64]:
    """(n_node,) dimension of the support that a node's elements need: a beam's node holds alone, shells ask for a line
    of nodes (about their normals they are soft), solids for three nodes that are not in line.
    """
    needed = np.full(model.mesh.n_node, 3)
    for block in model.mesh.blocks:
        dimension = ELEMENT_KINDS[block.kind].dimension
        rows = block.connectivity.ravel()
        needed[rows] = np.minimum(needed[rows], dimension)
    return needed - 1


def _rank(points: NDArray[np.float64]) -> int:
    arms = points - points.mean(axis=0)
    return int(np.linalg.matrix_rank(arms, 1e-6 * float(np.abs(arms).max(initial=1.0))))
