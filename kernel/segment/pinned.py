"""Pinned decisions: which operands the user's overrides are about, which nodes must be split to reach them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from kernel.csg.tree import CsgNode, walk
from kernel.errors import OverrideError
from kernel.plan import OVERRIDES, Override
from kernel.segment.operands import Operand, operand_at, operands_of


@dataclass(frozen=True, slots=True, eq=False)
class Pins:
    """by_operand: the override and the path it names, by the operand's own path; forced: overrides below an operand."""

    by_operand: Mapping[str, tuple[str, Override]]
    forced: Mapping[str, tuple[str, ...]]

    def of(self, operand: Operand | None) -> tuple[str, Override] | None:
        """The override on this operand, with the path that the user named."""
        return None if operand is None else self.by_operand.get(operand.path)

    def below(self, operand: Operand | None) -> tuple[str, ...]:
        """Paths of overrides that only a split of this operand reaches."""
        return () if operand is None else self.forced.get(operand.path, ())


def pin(root: CsgNode, overrides: Mapping[str, Override]) -> Pins:
    """Where each override takes hold.

    OverrideError: a path is in no model, names no material of its own, or two overrides speak of one material.
    """
    wanted = {path: override for path, override in overrides.items() if override.type != "auto"}
    for path, override in overrides.items():
        if override.type not in OVERRIDES:
            raise OverrideError(f"override of {path}: unknown type {override.type!r}, expected {', '.join(OVERRIDES)}")
    if not overrides:
        return Pins({}, {})
    nodes = dict(walk(root))
    for path in overrides:
        if path not in nodes:
            raise OverrideError(f"no node {path!r} in the model, expected '/' or a path such as '0.1'")
    held, forced = _reached(operand_at("/", root), wanted)
    for path in wanted:
        if not any(path == named for named, _ in held.values()):
            raise OverrideError(f"override of {path} as {wanted[path].type} cannot be: {_no_material(path, nodes)}")
    for operand, paths in forced.items():
        if operand in held and held[operand][1].type != "split":
            named, override = held[operand]
            raise OverrideError(
                f"override of {paths[0]} as {wanted[paths[0]].type} cannot be: "
                f"{named} above it is overridden as {override.type}, expected split or auto there"
            )
    return Pins(held, forced)


def _reached(
    root: Operand, wanted: Mapping[str, Override]
) -> tuple[dict[str, tuple[str, Override]], dict[str, tuple[str, ...]]]:
    """Overrides by the operand that they take hold of, and by each operand above that one."""
    held: dict[str, tuple[str, Override]] = {}
    forced: dict[str, list[str]] = {}
    stack: list[tuple[Operand, tuple[str, ...]]] = [(root, ())]
    while stack:
        operand, above = stack.pop()
        named = [path for path in operand.aliases if path in wanted]
        if len({wanted[path].type for path in named}) > 1:
            raise OverrideError(
                f"overrides of {' and '.join(named)} cannot both be: the nodes are the same material, expected one"
            )
        if named:
            held[operand.path] = (named[0], wanted[named[0]])
            for path in above:
                forced.setdefault(path, []).append(named[0])
        stack += [(child, (*above, operand.path)) for child in operands_of(operand)]
    return held, {path: tuple(sorted(names)) for path, names in forced.items()}


def _no_material(path: str, nodes: Mapping[str, CsgNode]) -> str:
    """Why the node at `path` has no material that could be decided."""
    steps = [] if path == "/" else path.split(".")
    for length in range(len(steps)):
        above = ".".join(steps[:length]) or "/"
        kind, index = nodes[above].kind, int(steps[length])
        if kind == "difference" and index > 0:
            return f"it is taken away by the difference at {above}, so it has no material of its own"
        if kind == "intersection":
            return f"the intersection at {above} keeps only what its operands share; override {above} instead"
    return "it has no material of its own"
