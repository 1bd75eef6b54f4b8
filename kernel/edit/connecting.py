"""Connecting: what touches becomes one, nodes at one place made one node and hanging nodes tied to what they lie on.

Bodies may touch while their mid-surfaces and axes are half a thickness apart: kernel/connect/facing.py.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.audit import connected_components
from kernel.connect.couplings import Coupled, equations_of, make_couplings, nodes_with_rotations
from kernel.connect.equations import Expression, Freedom, rows
from kernel.connect.facing import facing_ties
from kernel.connect.merge import Connected, connect
from kernel.connect.model import Coupling, Model
from kernel.connect.reference import joined_uses, renumbered_arms
from kernel.edit.edited import (
    Edited,
    dependent_nodes,
    independent_nodes,
    renumbered_coupling,
    renumbered_sets,
    segment_names,
)
from kernel.errors import ConnectError, OptionError
from kernel.mesh.assembly import Tie
from kernel.pieces import near_pairs
from kernel.places import place_text

Array = NDArray[np.float64]


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
    found = replace(found, ties=(*found.ties, *_facing(model, found, segments)))
    if found.n_joined == 0 and not found.ties:
        among = "the segments" if segments is None else " and ".join(segments)
        reach = "" if tolerance is None else f" of {tolerance:g}"
        raise ConnectError(f"nothing to connect: no nodes of {among} touch within the tolerance{reach}")
    _refuse_hinges(model, found, segments)
    kept = [renumbered_coupling(coupling, found.numbers) for coupling in model.couplings]
    coupled = make_couplings(found.ties, found.mesh, found.mesh.nodes)
    couplings = _with_ties([coupling for coupling in kept if coupling is not None], coupled, found.mesh.nodes)
    elements = np.arange(sum(len(block.connectivity) for block in model.mesh.blocks))
    joined = replace(
        model,
        mesh=found.mesh,
        couplings=tuple(couplings),
        sets=renumbered_sets(model.sets, found.numbers, elements),
        notes=(*model.notes, *(note for note in coupled.notes if note not in model.notes)),
    )
    n_tied = sum(len(tie.dependent) for tie in found.ties)
    reach = "" if tolerance is None else f" within {tolerance:g}"
    among = "" if segments is None else f" of {' and '.join(segments)}"
    line = f"connected{among}{reach}: {found.n_joined} nodes became one with others, {n_tied} tied to elements"
    reference = replace(
        edited.reference,
        pieces=connected_components(joined),
        pieces_of="it was connected to be",
        curve_uses=joined_uses(model.mesh, edited.reference.curve_uses, found.numbers),
        arms=renumbered_arms(edited.reference.arms, found.numbers),
        may_coincide=segments is not None and edited.reference.may_coincide,
    )
    return edited.done(joined, reference, line)


def _facing(model: Model, found: Connected, segments: Collection[str] | None) -> tuple[Tie, ...]:
    """Ties of what touches half a thickness apart, between segments that nothing connects yet."""
    owners: dict[int, set[str]] = {}
    for block in found.mesh.blocks:
        for node in np.unique(block.connectivity).tolist():
            owners.setdefault(node, set()).add(block.segment)

    def pairs(dependent: Collection[int], hosts: Collection[int]) -> set[frozenset[str]]:
        if not hosts:  # an equation that holds a freedom at nought
            return set()
        on = set.intersection(*(owners.get(node, set()) for node in hosts))
        return {frozenset((one, other)) for node in dependent for one in owners.get(node, ()) for other in on - {one}}

    coupled: set[frozenset[str]] = set()
    old = [renumbered_coupling(coupling, found.numbers) for coupling in model.couplings]
    couplings = [coupling for coupling in old if coupling is not None]
    for coupling in couplings:
        coupled |= pairs(dependent_nodes([coupling]), independent_nodes(coupling))
    bound = dependent_nodes(couplings)
    for tie in found.ties:
        bound.update(tie.dependent.tolist())
        for node, hosts in zip(tie.dependent.tolist(), tie.hosts, strict=True):
            coupled |= pairs([node], hosts.tolist())
    names = segment_names(model) if segments is None else segments
    return facing_ties(found.mesh, model.properties, found.reach, names, bound, coupled)


def _refuse_hinges(model: Model, found: Connected, segments: Collection[str] | None) -> None:
    """ConnectError where a node that turns lies on a node of solids and is not tied: a hinge that nobody sees."""
    names = segment_names(model) if segments is None else segments
    chosen = np.zeros(found.mesh.n_node, dtype=bool)
    for block in found.mesh.blocks:
        if block.segment in names:
            chosen[block.connectivity.ravel()] = True
    turning = nodes_with_rotations(found.mesh)
    tied = {node for tie in found.ties for node in tie.dependent.tolist()}
    tied |= {int(found.numbers[node]) for node in dependent_nodes(model.couplings)}
    for a, b in near_pairs(found.mesh.nodes, found.reach):
        if chosen[a] and chosen[b] and turning[a] != turning[b] and tied.isdisjoint((a, b)):
            raise ConnectError(
                f"at {place_text(found.mesh.nodes[a])} a node of beams or shells lies on a node of solids, which has "
                "no rotations: joined they would be a hinge; expected a beam's end or a shell's edge on a face"
            )


def _with_ties(couplings: list[Coupling], coupled: Coupled, nodes: Array) -> list[Coupling]:
    """Those that were there and the ties' own; what would depend on a dependent node is written out in equations."""
    ties = coupled.couplings
    tied = {node for coupling in ties for node in dependent_nodes([coupling])}
    stay: list[Coupling] = []
    opened: list[Coupling] = []
    for coupling in couplings:
        (stay if tied.isdisjoint(independent_nodes(coupling)) else opened).append(coupling)
    held = dependent_nodes(couplings)
    for coupling in ties:
        (stay if held.isdisjoint(independent_nodes(coupling)) else opened).append(coupling)
    taken: set[Freedom] = set()
    table: dict[Freedom, Expression] = {}
    for place, coupling in enumerate((*stay, *opened)):
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
