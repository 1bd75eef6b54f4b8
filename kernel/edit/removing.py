"""Deleting a segment."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.audit import connected_components, coupling_nodes
from kernel.connect.model import Coupling, Rbe2
from kernel.connect.reference import part_of, renumbered, renumbered_arms
from kernel.edit.edited import Edited, known_segment, renumbered_coupling, renumbered_sets, segment_names
from kernel.errors import OptionError
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh

Indices = NDArray[np.int64]


def delete_segment(edited: Edited, segment: str) -> Edited:
    """Take a segment out, with the nodes that only it had and the couplings that hold such nodes.

    An RBE2 goes on with the dependent nodes that are left. OptionError: no such segment, or the only one.
    """
    model = edited.model
    left = [name for name in segment_names(model) if name != known_segment(model, segment)]
    if not left:
        raise OptionError(f"{segment} is the only segment, expected one of several")
    kept = [block for block in model.mesh.blocks if block.segment != segment]
    is_used = np.zeros(model.mesh.n_node, dtype=bool)
    for block in kept:
        is_used[block.connectivity.ravel()] = True
    of_segment = np.concatenate([b.connectivity.ravel() for b in model.mesh.blocks if b.segment == segment])
    is_gone = np.zeros(model.mesh.n_node, dtype=bool)
    is_gone[of_segment] = True
    is_gone &= ~is_used
    numbers = np.where(is_gone, -1, np.cumsum(~is_gone) - 1)
    whole = [_without(coupling, is_gone) for coupling in model.couplings]
    couplings = [renumbered_coupling(coupling, numbers) for coupling in whole if coupling is not None]
    mesh = Mesh(
        model.mesh.nodes[~is_gone],
        tuple(replace(block, connectivity=numbers[block.connectivity]) for block in kept),
    )
    stays = np.concatenate([np.full(len(b.connectivity), b.segment != segment) for b in model.mesh.blocks])
    properties = tuple(element for element in model.properties if element.segment != segment)
    materials = {element.material for element in properties}
    smaller = replace(
        model,
        mesh=mesh,
        properties=properties,
        materials={name: material for name, material in model.materials.items() if name in materials},
        couplings=tuple(coupling for coupling in couplings if coupling is not None),
        sets=renumbered_sets(model.sets, numbers, np.where(stays, np.cumsum(stays) - 1, -1)),
    )
    reference = part_of(edited.reference, left)
    reference = replace(
        reference,
        pieces=connected_components(smaller),
        pieces_of="what was left",
        curve_uses=renumbered(_fewer_uses(model.mesh, segment, reference.curve_uses), numbers),
        arms=renumbered_arms(reference.arms, numbers),
    )
    lost = sum(coupling is None for coupling in whole)
    told = f", with {lost} couplings" if lost else ""
    return edited.done(smaller, reference, f"deleted {segment}{told}")


def _without(coupling: Coupling, is_gone: NDArray[np.bool_]) -> Coupling | None:
    """The coupling without nodes that are gone; None where it cannot do without them."""
    if isinstance(coupling, Rbe2) and not is_gone[coupling.independent]:
        dependent = coupling.dependent[~is_gone[coupling.dependent]]
        return replace(coupling, dependent=dependent) if len(dependent) else None
    return None if is_gone[coupling_nodes(coupling)].any() else coupling


def _fewer_uses(mesh: Mesh, segment: str, curve_uses: Indices) -> Indices:
    """The uses of every edge without those of the segment; rows for edges that it shared and that no curve knew."""
    expected = {(min(a, b), max(a, b)): count for a, b, count in curve_uses.tolist()}
    own, others = _edges(mesh.blocks, segment, True), set(_edges(mesh.blocks, segment, False))
    for edge in own:
        if edge in expected or edge in others:
            expected[edge] = expected.get(edge, 2) - 1
    rows = [(a, b, count) for (a, b), count in expected.items() if count > 0]
    return np.array(rows, dtype=np.int64).reshape(-1, 3)


def _edges(blocks: Sequence[ElementBlock], segment: str, of_segment: bool) -> list[tuple[int, int]]:
    """Edges of shells, smaller node first, once for each element."""
    found: list[tuple[int, int]] = []
    for block in blocks:
        kind = ELEMENT_KINDS[block.kind]
        if kind.dimension == 2 and (block.segment == segment) == of_segment:
            pairs = np.concatenate([np.sort(block.connectivity[:, list(edge)], axis=1) for edge in kind.edges])
            found += [(a, b) for a, b in pairs.tolist()]
    return found
