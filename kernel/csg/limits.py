"""Bounds on a tree, whichever language it came from."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from kernel.csg.source import MAX_NODES, MAX_TREE_DEPTH
from kernel.csg.tree import CsgNode, Hull
from kernel.errors import Place, ReadError


def check_tree(root: CsgNode) -> None:
    """ReadError where Booleans (and hulls) nest deeper than MAX_TREE_DEPTH, or there are more than MAX_NODES nodes."""
    stack = [(root, 0)]
    n_node = 0
    while stack:
        node, depth = stack.pop()
        n_node += 1
        if depth > MAX_TREE_DEPTH:
            raise ReadError(
                f"Booleans nested too deeply, expected at most {MAX_TREE_DEPTH} inside each other", place=node.place
            )
        if n_node > MAX_NODES:
            raise ReadError(f"too many nodes in the tree, expected at most {MAX_NODES}", place=node.place)
        below = node.members if isinstance(node, Hull) else node.operands
        stack.extend((child, depth + 1) for child in below)


_MATERIAL_RANGES: dict[str, tuple[Callable[[float], bool], str]] = {
    "E": (lambda value: 0 < value < math.inf, "a number over 0"),
    "NU": (lambda value: -1 < value < 0.5, "a number over -1 and under 0.5"),
    "RHO": (lambda value: 0 <= value < math.inf, "a number of 0 or more"),
}
"""Elastic modulus, Poisson's ratio, density, in the model's own unit set: which values are possible."""


def check_material(properties: Mapping[str, float], place: Place | None) -> None:
    """ReadError: a key that is not E, NU or RHO, or a value that no isotropic elastic material can have."""
    for key, value in properties.items():
        if key not in _MATERIAL_RANGES:
            raise ReadError(f"a material has no property {key!r}, expected E, NU or RHO", place=place)
        is_possible, expected = _MATERIAL_RANGES[key]
        if not is_possible(value):
            raise ReadError(f"a material's {key} is {value:g}, expected {expected}", place=place)


def missing_of_material(properties: Mapping[str, float]) -> str | None:
    """What a material lacks, as `E and RHO`; None where it is complete."""
    missing = [key for key in _MATERIAL_RANGES if key not in properties]
    return " and ".join(missing) if missing else None
