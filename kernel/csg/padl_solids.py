"""Solids of the PADL-2-like language while it is read: shared by every name that uses them, placed when done."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from kernel.csg.placement import place, rotation, translation
from kernel.csg.tree import (
    IDENTITY,
    Block,
    Boolean,
    Cone,
    CsgNode,
    Cylinder,
    Matrix,
    Primitive,
    Sphere,
    Torus,
    Wedge,
)
from kernel.errors import Place


@dataclass(frozen=True, slots=True, eq=False)
class PadlSolid:
    """A solid that may be used more than once.

    body: a primitive in standard position, or (operation, operands). matrix: (4, 4), where it is put.
    n_node, depth: of the tree that it becomes.
    """

    body: Primitive | tuple[str, tuple[PadlSolid, ...]]
    place: Place
    matrix: Matrix
    name: str | None = None
    n_node: int = 1
    depth: int = 0

    def moved(self, matrix: Matrix) -> PadlSolid:
        """The solid after a motion about the global axes."""
        return replace(self, matrix=matrix @ self.matrix)

    def as_tree(self, outer: Matrix = IDENTITY) -> CsgNode:
        """The tree, every placement pushed down to its primitives."""
        matrix = outer @ self.matrix
        if isinstance(self.body, Primitive):
            return replace(place(self.body, matrix), name=self.name, place=self.place)
        operation, operands = self.body
        children = tuple(operand.as_tree(matrix) for operand in operands)
        return Boolean(operation=operation, children=children, name=self.name, place=self.place)


def boolean(operation: str, operands: tuple[PadlSolid, ...], place: Place) -> PadlSolid:
    """Union, difference or intersection of two or more."""
    return PadlSolid(
        body=(operation, operands),
        place=place,
        matrix=IDENTITY,
        n_node=1 + sum(operand.n_node for operand in operands),
        depth=1 + max(operand.depth for operand in operands),
    )


@dataclass(frozen=True, slots=True)
class Shape:
    """A primitive's parameters in written order, which of them may be 0, and what it becomes."""

    keys: tuple[str, ...]
    make: Callable[[Mapping[str, float], Place], Primitive]
    may_be_zero: tuple[str, ...] = ()


def _block(v: Mapping[str, float], where: Place) -> Primitive:
    return Block(size=(v["X"], v["Y"], v["Z"]), place=where)


def _cylinder(v: Mapping[str, float], where: Place) -> Primitive:
    return Cylinder(radius=v["R"], height=v["H"], place=where)


def _wedge(v: Mapping[str, float], where: Place) -> Primitive:
    return Wedge(size=(v["X"], v["Y"], v["Z"]), place=where)


def _cone(v: Mapping[str, float], where: Place) -> Primitive:
    if v["R1"] == v["R2"]:
        return Cylinder(radius=v["R1"], height=v["H"], place=where)
    return Cone(bottom_radius=v["R1"], top_radius=v["R2"], height=v["H"], place=where)


def _sphere(v: Mapping[str, float], where: Place) -> Primitive:
    return Sphere(radius=v["R"], place=where)


def _torus(v: Mapping[str, float], where: Place) -> Primitive:
    return Torus(major_radius=v["RMAJ"], minor_radius=v["RMIN"], place=where)


SHAPES = {
    "BLO": Shape(("X", "Y", "Z"), _block),
    "CYL": Shape(("R", "H"), _cylinder),
    "WED": Shape(("X", "Y", "Z"), _wedge),
    "CON": Shape(("R1", "R2", "H"), _cone, ("R1", "R2")),
    "SPH": Shape(("R",), _sphere),
    "TOR": Shape(("RMAJ", "RMIN"), _torus),
}

MOVES: dict[str, Callable[[float], Matrix]] = {
    "MOVX": lambda distance: translation(distance, 0.0, 0.0),
    "MOVY": lambda distance: translation(0.0, distance, 0.0),
    "MOVZ": lambda distance: translation(0.0, 0.0, distance),
    "ROTX": lambda angle: rotation("x", angle),
    "ROTY": lambda angle: rotation("y", angle),
    "ROTZ": lambda angle: rotation("z", angle),
}
