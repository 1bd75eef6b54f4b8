"""Nodes that rest on the averages of several patches at once: one average over all of them.

The corner of a plate's edge in the nook of two bricks, a beam's end on the seam between two: each patch gives the node
an average of its own. As areas they are one face, so that their average is one too, each node with its area. That
holds the node; it does not hold the patches to one another. So it is done only where what the patches belong to hangs
together without it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.bodies import Bodies
from kernel.mesh.assembly import Tie
from kernel.mesh.mesh import Mesh
from kernel.pieces import connected_pieces

if TYPE_CHECKING:
    from kernel.connect.arrange import Average

Indices = NDArray[np.int64]


def one_average_each(
    averages: Sequence[Average],
    ties: Sequence[Tie],
    pieces_of: Callable[[], Indices],
    is_rigid: Callable[[Tie], bool],
) -> list[Average]:
    """The averages, those of one node as one where their patches are held to one another by the rest of the model.

    pieces_of: gives (n_node,) a label of what each node hangs together with by elements alone. Averages that are to be
    rigid stay as they are, and so do those of a node whose patches nothing else holds together.
    """
    by_node: dict[int, list[Average]] = {}
    for average in averages:
        by_node.setdefault(average.node, []).append(average)
    several = {node for node, own in by_node.items() if len(own) > 1}
    if not several:
        return list(averages)
    pieces = pieces_of()
    held = _held_without(several, ties, pieces)
    result = []
    for own in by_node.values():
        patches = {held.find(int(label)) for average in own for label in np.unique(pieces[average.patch])}
        if len(own) > 1 and len(patches) == 1 and not any(is_rigid(average.tie) for average in own):
            result.append(_together(own))
        else:
            result += own
    return result


def element_pieces(mesh: Mesh) -> Indices:
    """(n_node,) the smallest node of all that each node hangs together with by elements."""
    first, second = [np.empty(0, np.int64)], [np.empty(0, np.int64)]
    for block in mesh.blocks:
        first.append(np.repeat(block.connectivity[:, 0], block.connectivity.shape[1] - 1))
        second.append(block.connectivity[:, 1:].ravel())
    return connected_pieces(mesh.n_node, np.concatenate(first), np.concatenate(second))


def _held_without(several: set[int], ties: Sequence[Tie], pieces: Indices) -> Bodies:
    """The pieces as the ties hold them together, those of the nodes in `several` left out."""
    held = Bodies()
    for tie in ties:
        if tie.kind in ("rigid", "beam_on_face"):
            links = [(tie.dependent, tie.independent)]
        elif tie.kind == "rigid_pairs":
            links = list(zip(tie.dependent[:, None], tie.independent[:, None]))
        else:
            links = list(zip(tie.dependent[:, None], tie.hosts))
        for dependent, independent in links:
            if several.isdisjoint(dependent.tolist()):
                labels = np.unique(pieces[np.concatenate([dependent, independent])]).tolist()
                for label in labels[1:]:
                    held.join(labels[0], label)
    return held


def _together(averages: Sequence[Average]) -> Average:
    """One average over all patches, in the name of the tie with the largest."""
    nodes = np.concatenate([average.patch for average in averages])
    weights = np.concatenate([average.weights for average in averages])
    patch, place = np.unique(nodes, return_inverse=True)
    largest = max(averages, key=lambda average: float(average.weights.sum()))
    total = np.zeros(len(patch))
    np.add.at(total, place, weights)
    return replace(largest, patch=patch, weights=total, n_face=len(averages))
