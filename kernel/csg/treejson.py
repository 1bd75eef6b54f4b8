"""The service's own tree as JSON: what `tree_to_json` writes, `json_to_tree` reads back.

    {"units": "mm", "materials": {"steel": {"E": 210000, "NU": 0.3, "RHO": 7.85e-9}},
     "root": {"kind": "difference", "name": "PLATE", "operands": [
        {"kind": "block", "size": [240, 120, 8]},
        {"kind": "cylinder", "radius": 10, "height": 10,
         "placement": [[1, 0, 0, 40], [0, 1, 0, 35], [0, 0, 1, -1], [0, 0, 0, 1]]}]}}

An error names the JSON pointer (RFC 6901) of what is wrong; read from a text it has line and column too.
"""

from __future__ import annotations

import json
import re
from typing import Any, NoReturn

from kernel.csg.jsonnodes import JsonReader
from kernel.csg.jsonplaces import offset_of, values_of
from kernel.csg.limits import check_tree
from kernel.csg.source import MAX_TREE_DEPTH, check_brackets, place_at
from kernel.csg.tree import (
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
    Polyhedron,
    Primitive,
    Revolution,
    Sphere,
    Torus,
    Wedge,
)
from kernel.errors import DefectError, Place, ReadError

MAX_JSON_NESTING = 2 * MAX_TREE_DEPTH + 8
"""A node nests one object and one array; the arrays of its numbers nest a little more."""

_BRACKETS = re.compile(r'"(?:\\.|[^"\\])*+"|"|[{}\[\]]', re.DOTALL)


def read_json(text: str, source: str) -> CsgModel:
    """The model of a JSON text. ReadError: syntax or content, with line, column and JSON pointer."""
    check_brackets(text, source, _BRACKETS, MAX_JSON_NESTING)

    def refuse_constant(name: str) -> NoReturn:
        match = re.search(rf"(?<![\w\"]){re.escape(name)}(?!\w)", text)
        place = place_at(text, match.start() if match else 0, source)
        raise ReadError(f"found {name}, expected a finite number", place=place)

    def refuse_repeats(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key, value in pairs:
            if key in found:
                raise ReadError(f"{source}: the key {key!r} stands twice in one object, expected it once")
            found[key] = value
        return found

    try:
        content = json.loads(text, object_pairs_hook=refuse_repeats, parse_constant=refuse_constant, parse_int=float)
    except json.JSONDecodeError as error:
        raise ReadError(_syntax_message(error), place=place_at(text, error.pos, source)) from None
    places = dict(_object_places(text, source))
    reader = JsonReader(source, places, lambda path: place_at(text, offset_of(text, path), source))
    model = reader.model(content)
    check_tree(model.root)
    return model


def json_to_tree(obj: Any, source: str) -> CsgModel:
    """The model of a JSON value that is parsed already. ReadError: what is wrong, with its JSON pointer."""
    model = JsonReader(source).model(obj)
    check_tree(model.root)
    return model


def tree_to_json(model: CsgModel) -> dict[str, Any]:
    """The model as a JSON value; json_to_tree gives it back, every number to the last bit."""
    result: dict[str, Any] = {}
    if model.units is not None:
        result["units"] = model.units
    if model.materials:
        result["materials"] = {name: dict(properties) for name, properties in model.materials.items()}
    result["root"] = node_to_json(model.root)
    return result


def node_to_json(node: CsgNode) -> dict[str, Any]:
    """One node with all below it."""
    result: dict[str, Any] = {"kind": node.kind}
    if node.name is not None:
        result["name"] = node.name
    if node.place is not None:
        result["place"] = {"file": node.place.file, "line": node.place.line, "column": node.place.column}
    if isinstance(node, Boolean):
        result["operands"] = [node_to_json(operand) for operand in node.operands]
    elif isinstance(node, Hull):
        result["members"] = [node_to_json(member) for member in node.members]
    elif isinstance(node, Primitive):
        result.update(_parameters(node))
        if not (node.placement == IDENTITY).all():
            result["placement"] = node.placement.tolist()
    return result


def _parameters(node: Primitive) -> dict[str, Any]:
    match node:
        case Block() | Wedge():
            return {"size": list(node.size)}
        case Cylinder():
            return {"radius": node.radius, "height": node.height}
        case Cone():
            return {"bottom_radius": node.bottom_radius, "top_radius": node.top_radius, "height": node.height}
        case Sphere():
            return {"radius": node.radius}
        case Torus():
            return {"major_radius": node.major_radius, "minor_radius": node.minor_radius}
        case Extrusion():
            return {
                "loops": _loops(node.loops),
                "height": node.height,
                "twist": node.twist,
                "scale": list(node.scale),
                "slices": node.slices,
            }
        case Revolution():
            return {"loops": _loops(node.loops), "angle": node.angle, "facets": node.facets}
        case Polyhedron():
            return {"points": node.points.tolist(), "faces": [list(face) for face in node.faces]}
    raise DefectError(f"no JSON is known for a {node.kind}")


def _loops(loops: tuple[Matrix, ...]) -> list[list[list[float]]]:
    return [loop.tolist() for loop in loops]


def _object_places(text: str, source: str) -> list[tuple[tuple[str | int, ...], Any]]:
    """(path, place) of every object, in one pass over the text."""
    line, seen = 1, 0
    result = []
    for path, offset in values_of(text, objects_only=True):
        line += text.count("\n", seen, offset)
        line_start = text.rfind("\n", 0, offset) + 1
        seen = offset
        result.append((path, Place(source, line, offset - line_start + 1)))
    return result


def _syntax_message(error: json.JSONDecodeError) -> str:
    expected = {
        "Expecting value": "found no value, expected one",
        "Expecting ',' delimiter": "found no comma, expected ',' or a closing bracket",
        "Expecting ':' delimiter": "found no colon, expected ':' after the key",
        "Expecting property name enclosed in double quotes": "found no key, expected one in double quotes",
        "Illegal trailing comma before end of object": "found a comma before '}', expected none",
        "Illegal trailing comma before end of array": "found a comma before ']', expected none",
        "Extra data": "found more text after the model, expected the end of the file",
        "Unterminated string starting at": "a string is never closed, expected '\"'",
        "Invalid control character at": "found a control character in a string, expected it escaped",
        "Invalid \\escape": "found an unknown escape in a string, expected JSON's own",
        "Invalid \\uXXXX escape": "found a broken \\u escape, expected four hexadecimal digits",
    }
    return expected.get(error.msg.removesuffix(": "), f"{error.msg}, expected JSON")
