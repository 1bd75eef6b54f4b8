"""OpenSCAD's `.csg` to a tree: placements pushed down to the primitives, groups dissolved, extrusions distributed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from kernel.csg.flat import Extrude, Flat, FlatBoolean, Turn, extruded, turned
from kernel.csg.leaves import FLAT_LEAVES, SOLID_LEAVES
from kernel.csg.limits import check_tree
from kernel.csg.parameters import Parameters
from kernel.csg.placement import mended, rotation
from kernel.csg.source import MAX_NODES, MAX_NUMBER, MAX_TREE_DEPTH
from kernel.csg.statements import Statement, parse_statements
from kernel.csg.tree import Block, Boolean, Cone, CsgModel, CsgNode, Cylinder, Hull, Matrix, Sphere, Wedge
from kernel.errors import ReadError
from kernel.words import did_you_mean

_UNIONS = ("union", "group", "render", "color")
_OPERATORS = (*_UNIONS, "difference", "intersection", "hull", "multmatrix", "linear_extrude", "rotate_extrude")
_REFUSED = {
    "minkowski": "a Minkowski sum",
    "import": "a body from another file",
    "surface": "a height field",
    "text": "letters",
    "projection": "a projection",
    "offset": "an offset outline",
    "resize": "a resized body",
    "fill": "a filled outline",
    "roof": "a roof",
}
_SOURCE_ONLY = (
    *("translate", "rotate", "scale", "mirror", "for", "intersection_for", "if", "else", "let", "each", "assign"),
    *("module", "function", "children", "child", "include", "use", "echo", "assert"),
)
_KNOWN = (*_OPERATORS, *SOLID_LEAVES, *FLAT_LEAVES)
_SINGULAR = 1e-12


def read_openscad(text: str, source: str) -> CsgModel:
    """The model of a `.csg` that OpenSCAD wrote. ReadError: what cannot be read, with its place."""
    statements = parse_statements(text, source)
    root = _build(_shown_alone(statements) or statements, source)
    if root is None:
        raise ReadError(f"{source}: there is no solid in the file, expected at least one")
    check_tree(root)
    return CsgModel(root=root, source=source, language="openscad")


Shape = CsgNode | Flat


@dataclass(slots=True)
class _Frame:
    """A statement whose children are being built: their results (None: empty), in order."""

    statement: Statement | None
    children: tuple[Statement, ...]
    matrix: Matrix
    is_flat: bool
    depth: int
    finish: Callable[[_Frame], Shape | None]
    next_child: int = 0
    results: list[Shape | None] = field(default_factory=list)


def _shown_alone(statements: tuple[Statement, ...]) -> tuple[Statement, ...] | None:
    """The first statement marked `!`, which stands for the whole model then, or None."""
    stack = list(reversed(statements))
    while stack:
        statement = stack.pop()
        if "!" in statement.modifier and not _is_left_out(statement):
            return (statement,)
        stack.extend(reversed(statement.children))
    return None


def _is_left_out(statement: Statement) -> bool:
    return "%" in statement.modifier or "*" in statement.modifier


def _build(statements: tuple[Statement, ...], source: str) -> CsgNode | None:
    return _Builder(source).build(statements)


class _Builder:
    """Builds with a stack of its own: a text may nest deeper than Python recurses."""

    def __init__(self, source: str) -> None:
        self.source = source
        self.n_leaf = 0

    def build(self, statements: tuple[Statement, ...]) -> CsgNode | None:
        """The solid of top-level `statements`, None where there is none."""
        top = _Frame(None, statements, np.eye(4), False, 0, self._united)
        stack = [top]
        while True:
            frame = stack[-1]
            if frame.next_child < len(frame.children):
                child = frame.children[frame.next_child]
                frame.next_child += 1
                if _is_left_out(child):
                    continue
                if child.name in _OPERATORS:
                    stack.append(self._opened(child, frame))
                else:
                    frame.results.append(self._leaf(child, frame))
                continue
            stack.pop()
            result = frame.finish(frame)
            if not stack:
                return result  # type: ignore[return-value]
            stack[-1].results.append(result)

    def _leaf(self, statement: Statement, frame: _Frame) -> Shape | None:
        name = statement.name
        if name in _REFUSED:
            raise self._error(
                statement, f"{name} ({_REFUSED[name]}) cannot be read, expected it to be modelled otherwise"
            )
        here, there = (FLAT_LEAVES, SOLID_LEAVES) if frame.is_flat else (SOLID_LEAVES, FLAT_LEAVES)
        if name not in here:
            raise self._unknown(statement, is_other=name in there, is_flat=frame.is_flat)
        if statement.children:
            child = statement.children[0].place(self.source)
            where = f"line {child.line}, column {child.column}"
            raise self._error(statement, f"{name} has children, expected none, or a ';' before what begins at {where}")
        self.n_leaf += 1
        if self.n_leaf > MAX_NODES:
            raise self._error(statement, f"too many primitives, expected at most {MAX_NODES}")
        return here[name](statement, self.source, frame.matrix)

    def _unknown(self, statement: Statement, *, is_other: bool, is_flat: bool) -> ReadError:
        name = statement.name
        if is_other and is_flat:
            return self._error(statement, f"{name} is a solid inside an extrusion, expected square, circle or polygon")
        if is_other:
            return self._error(
                statement, f"{name} is flat, expected it inside linear_extrude or rotate_extrude to make a solid"
            )
        if name in _SOURCE_ONLY:
            return self._error(
                statement,
                f"{name} belongs to OpenSCAD's source, expected what `openscad -o model.csg model.scad` writes",
            )
        return self._error(
            statement,
            f"unknown primitive or operation {name!r}, expected one of OpenSCAD's .csg such as cube or union"
            f"{did_you_mean(name, (*_KNOWN, *_REFUSED))}",
        )

    def _opened(self, statement: Statement, parent: _Frame) -> _Frame:
        """The frame in which the children of an operator are built."""
        name, depth = statement.name, parent.depth
        matrix, is_flat = parent.matrix, parent.is_flat
        finish = self._united
        if len(statement.children) > 1 or name == "hull":
            depth += 1
        if name == "multmatrix":
            matrix = matrix @ self._matrix(statement, is_flat)
        elif name in ("difference", "intersection", "hull"):
            finish = {"difference": self._less, "intersection": self._common, "hull": self._hulled}[name]
        elif name in ("linear_extrude", "rotate_extrude"):
            if is_flat:
                raise self._error(statement, f"{name} inside an extrusion, expected square, circle or polygon")
            how = self._extrude(statement, matrix) if name == "linear_extrude" else self._turn(statement, matrix)
            matrix, is_flat = np.eye(4), True
            finish = lambda frame: self._raised(frame, how)  # noqa: E731
        if depth > MAX_TREE_DEPTH:
            raise self._error(
                statement, f"Booleans nested too deeply, expected at most {MAX_TREE_DEPTH} inside each other"
            )
        return _Frame(statement, statement.children, matrix, is_flat, depth, finish)

    def _matrix(self, statement: Statement, is_flat: bool) -> Matrix:
        matrix = mended(Parameters(statement, self.source, ("m",)).matrix())
        size = np.abs(matrix[:3, :3]).max()
        flat_size = np.abs(matrix[:2, :2]).max()
        if is_flat and np.abs(matrix[2, :2]).max() > _SINGULAR * size:
            raise self._error(statement, "multmatrix tilts a flat shape out of its plane, expected it to stay flat")
        determinant = abs(np.linalg.det(matrix[:2, :2])) if is_flat else abs(np.linalg.det(matrix[:3, :3]))
        if determinant <= _SINGULAR * (flat_size**2 if is_flat else size**3):
            raise self._error(statement, "multmatrix flattens its children, expected a matrix that keeps their volume")
        return matrix

    def _extrude(self, statement: Statement, matrix: Matrix) -> Extrude:
        given = Parameters(
            statement, self.source, ("height", "center", "convexity", "twist", "slices", "scale"), ("segments",)
        )
        scale: Any = given.value("scale")
        factors: tuple[float, float] = (1.0, 1.0)
        if scale is not None:
            entries = scale if isinstance(scale, list) else [scale, scale]
            if len(entries) != 2 or not all(type(entry) is float and 0 <= entry <= MAX_NUMBER for entry in entries):
                raise given.wrong("scale", "two finite numbers of 0 or more")
            factors = (float(entries[0]), float(entries[1]))
            if (factors[0] == 0) != (factors[1] == 0):
                raise given.wrong("scale", "two numbers over 0, or both 0 for a point")
        return Extrude(
            matrix=matrix,
            place=statement.place(self.source),
            height=given.positive("height"),
            center=given.flag("center"),
            twist=given.number("twist", 0.0),
            scale=factors,
            slices=given.slices(),
            fn=given.number("$fn", 0.0),
            fa=given.positive("$fa", 12.0),
            fs=given.positive("$fs", 2.0),
        )

    def _turn(self, statement: Statement, matrix: Matrix) -> Turn:
        given = Parameters(statement, self.source, ("angle", "convexity"), ("start",))
        angle = given.number("angle", 360.0)
        if angle == 0:
            raise given.wrong("angle", "a number other than 0")
        if abs(angle) >= 360.0:
            angle = 360.0
        turn = rotation("z", given.number("start", 0.0))
        return Turn(matrix=matrix @ turn, place=statement.place(self.source), angle=angle, fn=given.number("$fn", 0.0))

    def _raised(self, frame: _Frame, how: Extrude | Turn) -> CsgNode | None:
        flat = self._united(frame)
        if flat is None:
            return None
        if isinstance(how, Extrude):
            return extruded(flat, how)  # type: ignore[arg-type]
        return turned(flat, how)  # type: ignore[arg-type]

    def _united(self, frame: _Frame) -> Shape | None:
        shapes = [shape for shape in frame.results if shape is not None]
        if len(shapes) < 2:
            return shapes[0] if shapes else None
        return self._boolean("union", shapes, frame)

    def _less(self, frame: _Frame) -> Shape | None:
        statement = frame.statement
        if statement is not None and not frame.results:
            raise self._error(statement, "difference has no operand, expected a solid and what is cut from it")
        if statement is not None and frame.results[0] is None:
            raise self._error(statement, "difference cuts from nothing, expected its first operand to hold a solid")
        shapes = [shape for shape in frame.results if shape is not None]
        return shapes[0] if len(shapes) == 1 else self._boolean("difference", shapes, frame)

    def _common(self, frame: _Frame) -> Shape | None:
        shapes = [shape for shape in frame.results if shape is not None]
        if frame.statement is not None and shapes and len(shapes) < len(frame.results):
            index = frame.results.index(None)
            raise self._error(
                frame.statement, f"operand {index} of intersection is empty, expected every operand to hold a solid"
            )
        if len(shapes) < 2:
            return shapes[0] if shapes else None
        return self._boolean("intersection", shapes, frame)

    def _hulled(self, frame: _Frame) -> Shape | None:
        shapes = [shape for shape in frame.results if shape is not None]
        if not shapes:
            return None
        assert frame.statement is not None
        place = frame.statement.place(self.source)
        if frame.is_flat:
            return FlatBoolean("hull", tuple(shapes), place)  # type: ignore[arg-type]
        if len(shapes) == 1 and isinstance(shapes[0], (Block, Cylinder, Cone, Sphere, Wedge)):
            return shapes[0]
        return Hull(members=tuple(shapes), place=place)  # type: ignore[arg-type]

    def _boolean(self, operation: str, shapes: list[Shape], frame: _Frame) -> Shape:
        place = frame.statement.place(self.source) if frame.statement else shapes[0].place
        if frame.is_flat:
            return FlatBoolean(operation, tuple(shapes), place)  # type: ignore[arg-type]
        return Boolean(operation=operation, children=tuple(shapes), place=place)  # type: ignore[arg-type]

    def _error(self, statement: Statement, message: str) -> ReadError:
        return ReadError(message, place=statement.place(self.source))
