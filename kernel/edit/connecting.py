"""Connecting: what touches becomes one, nodes at one place made one node and hanging nodes tied to what they lie on."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from kernel.connect.audit import connected_components
from kernel.connect.couplings import equations_of, make_couplings, nodes_with_rotations
from kernel.connect.equations import Expression, Freedom, rows
from kernel.connect.merge import Connected, connect
from kernel.connect.model import Coupling, Model
from kernel.connect.reference import renumbered, renumbered_arms
from kernel.edit.edited import Edited, dependent_nodes, independent_nodes, renumbered_coupling, renumbered_sets
from kernel.errors import ConnectError, OptionError
from kernel.places import place_text


def connect_model(edited: Edited, tolerance: float | None = None, segments: Collection[str] | None = None) -> Edited:
    """Join the segments (all, or those named) where they are nearer than the tolerance, a length.

    Couplings that are there already stay; a node that depends on something is not tied to anything more.
    OptionError: a tolerance that is no length. ConnectError: nothing touches within the tolerance, the tolerance is too
    wide for the elements, or a node would depend twice.
    """
    if tolerance is not None and not 0 < tolerance < float("inf"):
        raise OptionError(f"tolerance is {tolerance:g}, expected a positive length")
    model = edited.model
    found = connect(model.mesh, tolerance, segments, dependent_nodes(model.couplings))
    if found.n_joined == 0 and not found.ties:
        among = "the segments" if segments is None else " and ".join(segments)
        reach = "" if tolerance is None else f" of {tolerance:g}"
        raise ConnectError(f"nothing to connect: no nodes of {among} touch within the tolerance{reach}")
    _refuse_hinges(model, found)
    kept = [renumbered_coupling(coupling, found.numbers) for coupling in model.couplings]
    couplings = _with_ties([coupling for coupling in kept if coupling is not None], found)
    elements = np.arange(sum(len(block.connectivity) for block in model.mesh.blocks))
    joined = replace(
        model,
        mesh=found.mesh,
        couplings=tuple(couplings),
        sets=renumbered_sets(model.sets, found.numbers, elements),
    )
    n_tied = sum(len(tie.dependent) for tie in found.ties)
    reach = "" if tolerance is None else f" within {tolerance:g}"
    among = "" if segments is None else f" of {' and '.join(segments)}"
    line = f"connected{among}{reach}: {found.n_joined} nodes became one with others, {n_tied} tied to elements"
    reference = replace(
        edited.reference,
        pieces=connected_components(joined),
        pieces_of="it was connected to be",
        curve_uses=renumbered(edited.reference.curve_uses, found.numbers),
        arms=renumbered_arms(edited.reference.arms, found.numbers),
        may_coincide=segments is not None and edited.reference.may_coincide,
    )
    return edited.done(joined, reference, line)


def _refuse_hinges(model: Model, found: Connected) -> None:
    """ConnectError where a node that turns would become one with a node of solids only: a hinge that nobody sees."""
    turning = nodes_with_rotations(model.mesh)
    has_turning = np.zeros(found.mesh.n_node, dtype=bool)
    has_still = np.zeros(found.mesh.n_node, dtype=bool)
    has_turning[found.numbers[turning]] = True
    has_still[found.numbers[~turning]] = True
    hinges = np.flatnonzero(has_turning & has_still)
    if len(hinges):
        raise ConnectError(
            f"at {place_text(found.mesh.nodes[hinges[0]])} a node of beams or shells lies on a node of solids, "
            "which has no rotations: joined they would be a hinge; expected a coupling, as meshing both together gives"
        )


def _with_ties(couplings: list[Coupling], found: Connected) -> list[Coupling]:
    """Those that were there and the ties' own; what would depend on a dependent node is written out in equations."""
    nodes = found.mesh.nodes
    ties = make_couplings(found.ties, found.mesh, nodes).couplings
    tied = {node for coupling in ties for node in dependent_nodes([coupling])}
    stay: list[Coupling] = []
    opened: list[Coupling] = []
    for coupling in couplings:
        (stay if tied.isdisjoint(independent_nodes(coupling)) else opened).append(coupling)
    taken: set[Freedom] = set()
    table: dict[Freedom, Expression] = {}
    for place, coupling in enumerate((*stay, *ties, *opened)):
        for freedom, row in rows(coupling, nodes):
            if freedom in taken:
                raise ConnectError(
                    f"the node at {place_text(nodes[freedom[0]])} would depend on two couplings, expected one: "
                    "connect before coupling, or leave its segment out"
                )
            taken.add(freedom)
            if place >= len(stay):
                table[freedom] = row
    return [*stay, *equations_of(table, stay, nodes)]
