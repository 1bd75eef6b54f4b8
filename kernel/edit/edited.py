"""A model under edit: with what it is checked against, and the history of what was done to it."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kernel.connect.model import Coupling, Model, Mpc, NamedSet, Rbe2
from kernel.connect.reference import Reference, own_reference
from kernel.errors import OptionError

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Edited:
    """model: never changed in place. reference: what its checks compare it with. history: a line for each edit."""

    model: Model
    reference: Reference
    history: tuple[str, ...] = ()

    @classmethod
    def of(cls, model: Model, reference: Reference | None = None) -> Edited:
        """A model before its first edit. reference: None where its solid is not known, as of a deck that was read.

        OptionError: a model without elements.
        """
        if not any(model.mesh.count().values()):
            raise OptionError(f"{model.title or 'the model'} has no elements, expected some to edit")
        return cls(model, reference or own_reference(model))

    def done(self, model: Model, reference: Reference, line: str) -> Edited:
        """After one more edit; the line goes into the model's notes too, so that its decks tell it."""
        noted = replace(model, notes=(*model.notes, f"edited: {line}"))
        return Edited(noted, reference, (*self.history, line))


def segment_names(model: Model) -> list[str]:
    """Ids of the segments, in the order of their properties."""
    return [element.segment for element in model.properties]


def known_segment(model: Model, name: str) -> str:
    """The id itself; OptionError where the model has no such segment."""
    names = segment_names(model)
    if name not in names:
        raise OptionError(f"no segment {name!r} in the mesh, expected one of {', '.join(names)}")
    return name


def dependent_nodes(couplings: Sequence[Coupling]) -> set[int]:
    """Nodes of which at least one freedom depends on others."""
    found: set[int] = set()
    for coupling in couplings:
        if isinstance(coupling, Rbe2):
            found.update(coupling.dependent.tolist())
        else:
            found.add(int(coupling.nodes[0]) if isinstance(coupling, Mpc) else coupling.dependent)
    return found


def independent_nodes(coupling: Coupling) -> set[int]:
    """Nodes that the coupling's dependents follow."""
    if isinstance(coupling, Rbe2):
        return {coupling.independent}
    return set((coupling.nodes[1:] if isinstance(coupling, Mpc) else coupling.independent).tolist())


def renumbered_coupling(coupling: Coupling, numbers: Indices) -> Coupling | None:
    """The coupling in new node numbers; None where its two sides have become one node."""
    if isinstance(coupling, Mpc):
        return replace(coupling, nodes=numbers[coupling.nodes])
    if isinstance(coupling, Rbe2):
        head = int(numbers[coupling.independent])
        dependent = numbers[coupling.dependent]
        dependent = dependent[dependent != head]
        return replace(coupling, independent=head, dependent=dependent) if len(dependent) else None
    return replace(coupling, dependent=int(numbers[coupling.dependent]), independent=numbers[coupling.independent])


def renumbered_sets(sets: Sequence[NamedSet], nodes: Indices, elements: Indices) -> tuple[NamedSet, ...]:
    """Sets in new numbers of nodes and elements, -1 where gone; a set that loses its last element is left out."""
    found = []
    for named in sets:
        of_nodes, of_elements = np.unique(nodes[named.nodes]), np.sort(elements[named.elements])
        of_nodes, of_elements = of_nodes[of_nodes >= 0], of_elements[of_elements >= 0]
        if len(of_elements) or (len(of_nodes) and not len(named.elements)):
            found.append(NamedSet(named.name, of_nodes, of_elements))
    return tuple(found)


def unique_name(name: str, taken: Collection[str]) -> str:
    """The name, with a number at its end where it is taken."""
    candidate, number = name, 2
    while candidate in taken:
        candidate = f"{name}_{number}"
        number += 1
    return candidate
