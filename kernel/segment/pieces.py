"""A piece: a solid that waits to be decided, with what is known of it, measured when first asked for."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.facts import Facts, Value
from kernel.segment.prism import Prism, Sweep, best_prism, sweeps
from kernel.segment.slabs import WallDecomposition, decompose

if TYPE_CHECKING:
    from kernel.segment.operands import Operand
    from kernel.solid.solid import Solid


@dataclass(frozen=True, slots=True, eq=False)
class Likeness:
    """Another piece that this one is a copy of, and the shift (3,) from that one to this."""

    of: Piece
    shift: NDArray[np.float64]


@dataclass(eq=False)
class Piece:
    """solid: in the working frame. path: the CSG node that its segments will name; label: the path, with "#n" behind
    it for the n-th piece of a node that was divided. operand: None where the solid has no tree of its own.
    neighbours: pieces beside it that may touch it. likeness: set where an equal piece was measured before.
    """

    solid: Solid
    path: str
    label: str
    role: str
    depth: int = 0
    name: str | None = None
    operand: Operand | None = None
    neighbours: tuple[Piece, ...] = field(default=())
    likeness: Likeness | None = None
    intent: Facts | None = None
    measured: dict[str, dict[str, Value]] = field(default_factory=dict)

    @cached_property
    def components(self) -> tuple[Solid, ...]:
        """The parts that do not touch one another, in a fixed order."""
        parts = self.solid.components()
        return tuple(sorted(parts, key=lambda part: tuple(np.round(part.bounds.mean(axis=0) / self.solid.size, 6))))

    @cached_property
    def sweeps(self) -> tuple[Sweep, ...]:
        """Directions along which the solid might be swept."""
        if self.likeness is not None:
            return tuple(sweep.moved(self.likeness.shift) for sweep in self.likeness.of.sweeps)
        return sweeps(self.solid)

    @cached_property
    def prism(self) -> Prism | None:
        """The solid measured along the best of them."""
        if self.likeness is not None:
            prism = self.likeness.of.prism
            return None if prism is None else prism.moved(self.likeness.shift)
        return best_prism(self.solid, self.sweeps)

    @cached_property
    def walls(self) -> WallDecomposition:
        """The thin-wall decomposition."""
        return decompose(self.solid)

    def part(self, solid: Solid, number: int, role: str) -> Piece:
        """The n-th part of this piece, a solid without a tree of its own."""
        return Piece(
            solid=solid,
            path=self.path,
            label=f"{self.label}#{number}",
            role=role,
            depth=self.depth,
            name=self.name,
            neighbours=self.neighbours,
        )
