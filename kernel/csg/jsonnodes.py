"""JSON values to nodes: every field checked, errors with the JSON pointer of the field."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from kernel.csg.jsonplaces import pointer
from kernel.csg.limits import check_material, missing_of_material
from kernel.csg.outline import ordered_loops
from kernel.csg.placement import mended_rigid, place
from kernel.csg.polyhedra import closed_polyhedron
from kernel.csg.source import MAX_SLICES, MAX_TREE_DEPTH, MIN_SIZE, either, wrong_number
from kernel.csg.tree import (
    BOOLEANS,
    IDENTITY,
    Block,
    Boolean,
    Cone,
    CsgModel,
    CsgNode,
    Cylinder,
    Extrusion,
    Hull,
    Matrix,
    Primitive,
    Revolution,
    Sphere,
    Torus,
    Wedge,
)
from kernel.errors import Place, ReadError
from kernel.units import UNIT_SETS
from kernel.words import did_you_mean, is_writable

Path = tuple[str | int, ...]

FIELDS: dict[str, tuple[str, ...]] = {
    "block": ("size",),
    "cylinder": ("radius", "height"),
    "cone": ("bottom_radius", "top_radius", "height"),
    "wedge": ("size",),
    "sphere": ("radius",),
    "torus": ("major_radius", "minor_radius"),
    "extrusion": ("loops", "height", "twist", "scale", "slices"),
    "revolution": ("loops", "angle", "facets"),
    "polyhedron": ("points", "faces"),
    "hull": ("members",),
    **dict.fromkeys(BOOLEANS, ("operands",)),
}
"""A node's own fields by its kind; `kind`, `name`, `placement` and `place` may stand on all."""

COMMON_FIELDS = ("kind", "name", "placement", "place")
_MODEL_FIELDS = ("root", "units", "materials")


class JsonReader:
    """Reads one document.

    places: where objects stand, by path. find: the place of any path, asked only for an error; None: no text is known.
    """

    def __init__(
        self, source: str, places: Mapping[Path, Place] | None = None, find: Callable[[Path], Place] | None = None
    ) -> None:
        self.source = source
        self.places = places or {}
        self.find = find

    def model(self, content: Any) -> CsgModel:
        """The whole document."""
        fields = self._object(content, (), _MODEL_FIELDS, "a model")
        if "root" not in fields:
            raise self._error((), "has no 'root', expected the tree's root node")
        units = fields.get("units")
        if units is not None and (not isinstance(units, str) or units not in UNIT_SETS):
            raise self._error(("units",), f"is {_shown(units)}, expected {either(list(UNIT_SETS))}")
        materials = self._materials(fields.get("materials"))
        root = self._node(fields["root"], ("root",), IDENTITY, 0)
        return CsgModel(root=root, source=self.source, language="json", units=units, materials=materials)

    def _materials(self, value: Any) -> dict[str, dict[str, float]]:
        materials: dict[str, dict[str, float]] = {}
        for name, properties in self._object(value or {}, ("materials",)).items():
            path: Path = ("materials", name)
            if not is_writable(name):
                raise self._error(("materials",), f"has {_shown(name)}, expected names of letters that can be written")
            given: dict[str, float] = {}
            for key, number in self._object(properties, path).items():
                given[key.upper()] = self._number(number, (*path, key))
                try:
                    check_material({key.upper(): given[key.upper()]}, None)
                except ReadError as error:
                    raise self._error((*path, key), f"cannot be: {error.message}") from None
            lacks = missing_of_material(given)
            if lacks:
                raise self._error(path, f"lacks {lacks}, expected E, NU and RHO")
            materials[name] = given
        return materials

    def _node(self, value: Any, path: Path, outer: Matrix, depth: int) -> CsgNode:
        if depth > MAX_TREE_DEPTH:
            raise self._error(path, f"is nested too deeply, expected at most {MAX_TREE_DEPTH} nodes inside each other")
        fields = self._object(value, path)
        kind = fields.get("kind")
        if not isinstance(kind, str) or kind not in FIELDS:
            if "kind" not in fields:
                raise self._error(path, f"has no 'kind', expected one of {', '.join(FIELDS)}")
            raise self._error(
                (*path, "kind"),
                f"is {_shown(kind)}, expected one of {', '.join(FIELDS)}{did_you_mean(str(kind), FIELDS)}",
            )
        self._object(value, path, (*COMMON_FIELDS, *FIELDS[kind]), f"a {kind}")
        matrix = outer
        if fields.get("placement") is not None:
            matrix = outer @ self._placement(fields["placement"], (*path, "placement"))
        name = fields.get("name")
        if name is not None and not (isinstance(name, str) and name and is_writable(name)):
            raise self._error((*path, "name"), f"is {_shown(name)}, expected a text or nothing")
        where = self._own_place(fields.get("place"), path)
        if kind in BOOLEANS:
            children = self._nodes(fields.get("operands"), (*path, "operands"), matrix, depth, at_least=2)
            return Boolean(operation=kind, children=children, name=name, place=where)
        if kind == "hull":
            members = self._nodes(fields.get("members"), (*path, "members"), matrix, depth, at_least=1)
            return Hull(members=members, name=name, place=where)
        primitive: Primitive = getattr(self, f"_{kind}")(fields, path)
        return replace(place(primitive, matrix), name=name, place=where)

    def _nodes(self, value: Any, path: Path, matrix: Matrix, depth: int, *, at_least: int) -> tuple[CsgNode, ...]:
        if not isinstance(value, list) or len(value) < at_least:
            found = f"has {len(value)} nodes" if isinstance(value, list) else f"is {_shown(value)}"
            raise self._error(path, f"{found}, expected a list of {at_least} or more")
        return tuple(self._node(item, (*path, index), matrix, depth + 1) for index, item in enumerate(value))

    def _block(self, fields: dict[str, Any], path: Path) -> Primitive:
        return Block(size=self._size(fields, path))

    def _wedge(self, fields: dict[str, Any], path: Path) -> Primitive:
        return Wedge(size=self._size(fields, path))

    def _cylinder(self, fields: dict[str, Any], path: Path) -> Primitive:
        return Cylinder(radius=self._positive(fields, path, "radius"), height=self._positive(fields, path, "height"))

    def _sphere(self, fields: dict[str, Any], path: Path) -> Primitive:
        return Sphere(radius=self._positive(fields, path, "radius"))

    def _cone(self, fields: dict[str, Any], path: Path) -> Primitive:
        bottom = self._at_least_zero(fields, path, "bottom_radius")
        top = self._at_least_zero(fields, path, "top_radius")
        height = self._positive(fields, path, "height")
        if bottom == top == 0:
            raise self._error((*path, "bottom_radius"), "and top_radius are both 0, expected one of them over 0")
        if bottom == top:
            return Cylinder(radius=bottom, height=height)
        return Cone(bottom_radius=bottom, top_radius=top, height=height)

    def _torus(self, fields: dict[str, Any], path: Path) -> Primitive:
        major = self._positive(fields, path, "major_radius")
        minor = self._positive(fields, path, "minor_radius")
        if minor >= major:
            raise self._error((*path, "minor_radius"), f"is {minor:g}, expected less than major_radius ({major:g})")
        return Torus(major_radius=major, minor_radius=minor)

    def _extrusion(self, fields: dict[str, Any], path: Path) -> Primitive:
        scale = self._numbers(fields.get("scale", [1.0, 1.0]), (*path, "scale"), 2)
        if min(scale) < 0 or (scale[0] == 0) != (scale[1] == 0):
            raise self._error((*path, "scale"), f"is {_shown(scale)}, expected two numbers over 0, or both 0")
        return Extrusion(
            loops=self._loops(fields, path),
            height=self._positive(fields, path, "height"),
            twist=self._number(fields.get("twist", 0.0), (*path, "twist")),
            scale=(scale[0], scale[1]),
            slices=self._whole(fields.get("slices", 1), (*path, "slices"), (1, MAX_SLICES)),
        )

    def _revolution(self, fields: dict[str, Any], path: Path) -> Primitive:
        loops = self._loops(fields, path)
        if any((loop[:, 0] < 0).any() for loop in loops):
            raise self._error((*path, "loops"), "has a point at x < 0, expected the outline on one side of the axis")
        angle = self._number(fields.get("angle", 360.0), (*path, "angle"))
        if not 0 < angle <= 360:
            raise self._error((*path, "angle"), f"is {angle:g}, expected a number over 0 and up to 360")
        facets = self._whole(fields.get("facets", 0), (*path, "facets"), (0, MAX_SLICES))
        if facets in (1, 2):
            raise self._error((*path, "facets"), f"is {facets}, expected 0, or 3 or more")
        return Revolution(loops=loops, angle=angle, facets=facets)

    def _polyhedron(self, fields: dict[str, Any], path: Path) -> Primitive:
        points = self._points(fields.get("points"), (*path, "points"), 3)
        faces = fields.get("faces")
        if not isinstance(faces, list) or not faces:
            raise self._error((*path, "faces"), f"is {_shown(faces)}, expected a list of lists of point numbers")
        read = []
        for number, face in enumerate(faces):
            if not isinstance(face, list) or len(face) < 3:
                raise self._error((*path, "faces", number), f"is {_shown(face)}, expected three point numbers or more")
            limits = (0, len(points) - 1)
            read.append([self._whole(index, (*path, "faces", number), limits) for index in face])
        try:
            return closed_polyhedron(points, read, None)
        except ReadError as error:
            raise self._error(path, f"cannot be: {error.message}") from None

    def _loops(self, fields: dict[str, Any], path: Path) -> tuple[Matrix, ...]:
        value, here = fields.get("loops"), (*path, "loops")
        if not isinstance(value, list) or not value:
            raise self._error(here, f"is {_shown(value)}, expected a list of outlines")
        loops = ordered_loops([self._points(loop, (*here, index), 2) for index, loop in enumerate(value)])
        if not loops:
            raise self._error(here, "encloses nothing, expected outlines with some area")
        return loops

    def _points(self, value: Any, path: Path, dimension: int) -> Matrix:
        if not isinstance(value, list) or len(value) < 3:
            raise self._error(path, f"is {_shown(value)}, expected three points or more")
        return np.array([self._numbers(point, (*path, index), dimension) for index, point in enumerate(value)])

    def _placement(self, value: Any, path: Path) -> Matrix:
        """(4, 4) from four or three rows of four, or 16 or 12 numbers row by row."""
        expected = "four rows of four finite numbers, or 12 numbers row by row"
        rows: Any = value
        if isinstance(value, list) and len(value) in (12, 16) and not isinstance(value[0], list):
            rows = [value[start : start + 4] for start in range(0, len(value), 4)]
        if not isinstance(rows, list) or len(rows) not in (3, 4):
            raise self._error(path, f"is {_shown(value)}, expected {expected}")
        matrix = np.eye(4)
        for index, row in enumerate(rows):
            matrix[index] = self._numbers(row, (*path, index) if rows is value else path, 4)
        if matrix[3].tolist() != [0.0, 0.0, 0.0, 1.0]:
            raise self._error(path, "has another last row than 0 0 0 1, expected a placement")
        linear = matrix[:3, :3]
        if abs(np.linalg.det(linear)) <= 1e-12 * np.abs(linear).max() ** 3:
            raise self._error(path, "flattens the solid, expected a matrix that keeps its volume")
        return mended_rigid(matrix)

    def _size(self, fields: dict[str, Any], path: Path) -> tuple[float, float, float]:
        here = (*path, "size")
        x, y, z = self._numbers(self._given(fields, path, "size"), here, 3)
        if min(x, y, z) < MIN_SIZE:
            raise self._error(here, f"is {_shown([x, y, z])}, expected three numbers over 0")
        return x, y, z

    def _given(self, fields: dict[str, Any], path: Path, key: str) -> Any:
        if fields.get(key) is None:
            raise self._error(path, f"has no {key!r}, expected it on a {fields['kind']}")
        return fields[key]

    def _positive(self, fields: dict[str, Any], path: Path, key: str) -> float:
        number = self._number(self._given(fields, path, key), (*path, key))
        expected = wrong_number(number, positive=True)
        if expected:
            raise self._error((*path, key), f"is {number:g}, expected {expected}")
        return number

    def _at_least_zero(self, fields: dict[str, Any], path: Path, key: str) -> float:
        number = self._number(self._given(fields, path, key), (*path, key))
        if number < 0:
            raise self._error((*path, key), f"is {number:g}, expected a number of 0 or more")
        return number

    def _numbers(self, value: Any, path: Path, count: int) -> list[float]:
        if not isinstance(value, list) or len(value) != count:
            raise self._error(path, f"is {_shown(value)}, expected {count} finite numbers")
        return [self._number(entry, (*path, index)) for index, entry in enumerate(value)]

    def _number(self, value: Any, path: Path) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self._error(path, f"is {_shown(value)}, expected a finite number")
        try:
            number = float(value)
        except OverflowError:
            number = math.inf
        expected = wrong_number(number)
        if expected:
            raise self._error(path, f"is {number:g}, expected {expected}")
        return number

    def _whole(self, value: Any, path: Path, limits: tuple[int, int]) -> int:
        number = self._number(value, path)
        if number != int(number) or not limits[0] <= number <= limits[1]:
            raise self._error(path, f"is {_shown(value)}, expected a whole number from {limits[0]} to {limits[1]}")
        return int(number)

    def _object(self, value: Any, path: Path, known: tuple[str, ...] = (), what: str = "") -> dict[str, Any]:
        if not isinstance(value, dict):
            raise self._error(path, f"is {_shown(value)}, expected an object")
        for key in value if known else ():
            if key not in known:
                raise self._error(
                    (*path, key), f"is no field of {what}, expected {either(list(known))}{did_you_mean(key, known)}"
                )
        return value

    def _own_place(self, value: Any, path: Path) -> Place | None:
        """The place that the node itself carries, else where it stands in the text."""
        if value is None:
            return self.places.get(path)
        here = (*path, "place")
        fields = self._object(value, here, ("file", "line", "column"), "a place")
        file = fields.get("file", self.source)
        if not isinstance(file, str):
            raise self._error((*here, "file"), f"is {_shown(file)}, expected a text")
        line, column = (
            self._whole(self._given({**fields, "kind": "place"}, here, key), (*here, key), (1, 2**53))
            for key in ("line", "column")
        )
        return Place(file, line, column)

    def _place(self, path: Path) -> Place | None:
        return self.find(path) if self.find else None

    def _error(self, path: Path, message: str) -> ReadError:
        what = pointer(path) or "the document"
        where = self._place(path)
        return ReadError(f"{what} {message}" if where else f"{self.source}: {what} {message}", place=where)


def _shown(value: Any) -> str:
    if isinstance(value, str):
        return repr(value if len(value) <= 30 else value[:27] + "...")
    if value is None:
        return "not given"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int | float):
        return f"{value:g}"
    if isinstance(value, list):
        text = f"[{', '.join(_shown(entry) for entry in value[:4])}{', ...' if len(value) > 4 else ''}]"
        return text if len(text) <= 60 else f"a list of {len(value)}"
    return "an object"
