"""Bodies as binary glTF 2.0: a node for each body's triangles, and one named "NAME edges" for its lines.

12 bytes "glTF", version, length | chunk: length, "JSON", text | chunk: length, "BIN", arrays
"""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray

from app.report.scenes import Body

TRIANGLES, LINES = 4, 1
FLOAT, UNSIGNED_INT = 5126, 5125


def glb(bodies: list[Body]) -> bytes:
    """The file. Coordinates are float32 in the user's frame and units, z up, as the model has them."""
    document: dict[str, Any] = {
        "asset": {"version": "2.0", "generator": "csgmesh"},
        "scene": 0,
        "scenes": [{"nodes": []}],
        **{name: [] for name in ("nodes", "meshes", "materials", "accessors", "bufferViews")},
    }
    arrays: list[bytes] = []
    for body in bodies:
        for name, primitives, colour, mode in (
            (body.name, body.triangles, body.colour, TRIANGLES),
            (f"{body.name} edges", body.lines, body.line_colour, LINES),
        ):
            if len(primitives):
                points, inverse = np.unique(primitives.reshape(-1, 3).astype("<f4"), axis=0, return_inverse=True)
                _add(document, arrays, name, points, inverse.ravel().astype("<u4"), colour, mode)
    document["buffers"] = [{"byteLength": sum(len(content) for content in arrays)}]
    if not arrays:  # glTF allows no empty arrays
        document = {key: value for key, value in document.items() if key in ("asset", "scene", "scenes")}
        document["scenes"] = [{}]
    text = json.dumps(document, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    binary = b"".join(arrays)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    if binary:
        chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def _add(
    document: dict[str, Any],
    arrays: list[bytes],
    name: str,
    points: NDArray[np.float32],
    indices: NDArray[np.uint32],
    colour: tuple[int, int, int],
    mode: int,
) -> None:
    first = len(document["accessors"])
    for values, component, kind in ((points, FLOAT, "VEC3"), (indices, UNSIGNED_INT, "SCALAR")):
        accessor: dict[str, Any] = {
            "bufferView": len(document["bufferViews"]),
            "componentType": component,
            "count": len(values),
            "type": kind,
        }
        if kind == "VEC3":
            accessor |= {"min": values.min(axis=0).tolist(), "max": values.max(axis=0).tolist()}
        content = np.ascontiguousarray(values).tobytes()
        view = {"buffer": 0, "byteOffset": sum(len(a) for a in arrays), "byteLength": len(content)}
        document["bufferViews"].append(view)
        document["accessors"].append(accessor)
        arrays.append(content)
    base = [round((c / 255) ** 2.2, 4) for c in colour]  # glTF's factors are linear, ours are as on the screen
    document["materials"].append(
        {"pbrMetallicRoughness": {"baseColorFactor": [*base, 1.0], "metallicFactor": 0.0}, "doubleSided": True}
    )
    primitive = {
        "attributes": {"POSITION": first},
        "indices": first + 1,
        "material": len(document["materials"]) - 1,
        "mode": mode,
    }
    document["scenes"][0]["nodes"].append(len(document["nodes"]))
    document["nodes"].append({"name": name, "mesh": len(document["meshes"])})
    document["meshes"].append({"name": name, "primitives": [primitive]})
