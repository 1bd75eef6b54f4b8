"""The whole model as JSON, for programs: every value of `kernel.connect.model.Model`, numbers exact, indices from 0.

kernel/deck/jsonread.py reads it back without loss: it is the form in which meshes are merged, connected and edited.
`nodes`: [x, y, z] in the user's frame. `blocks`: elements by segment and kind, node orders as in
kernel/mesh/elements.py. `couplings`: objects with `kind` rbe2, rbe3 or mpc; components 1-6.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from kernel.connect.model import Coupling, Mpc, Property, Rbe2
from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import header_lines

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

    from kernel.connect.model import Model

VERSION = 1
"""Counted up when a reader of the older form would misread the newer."""


def write(model: Model) -> bytes:
    """One JSON object, a line for each of its members."""
    blocks = [
        {
            "segment": block.segment,
            "kind": block.kind,
            "connectivity": block.connectivity.tolist(),
            "orientation": None if block.orientation is None else block.orientation.tolist(),
        }
        for block in model.mesh.blocks
    ]
    members: dict[str, Any] = {
        "csgmesh": VERSION,
        "header": header_lines(model, "JSON"),
        "title": model.title,
        "units": model.units,
        "rule_base": model.rule_base,
        "materials": {name: asdict(material) for name, material in model.materials.items()},
        "properties": [_property(element) for element in model.properties],
        "nodes": model.mesh.nodes.tolist(),
        "blocks": blocks,
        "couplings": [_coupling(coupling) for coupling in model.couplings],
        "sets": [
            {"name": named.name, "nodes": named.nodes.tolist(), "elements": named.elements.tolist()}
            for named in model.sets
        ],
        "notes": list(model.notes),
    }
    lines = ",\n".join(f"{json.dumps(key)}: {json.dumps(value, allow_nan=False)}" for key, value in members.items())
    return f"{{\n{lines}\n}}\n".encode()


def _property(element: Property) -> dict[str, Any]:
    section = element.section
    return {
        "segment": element.segment,
        "kind": element.kind,
        "material": element.material,
        "thickness": element.thickness,
        "density_factor": element.density_factor,
        "section": None
        if section is None
        else {
            "shape": section.shape,
            "dimensions": section.dimensions,
            "area": section.area,
            "iyy": section.iyy,
            "izz": section.izz,
            "iyz": section.iyz,
            "j": section.j,
            "centroid": list(section.centroid),
            "shear_centre": list(section.shear_centre),
            "shear_area_y": section.shear_area_y,
            "shear_area_z": section.shear_area_z,
            "outline": _rings(section.outline),
        },
    }


def _rings(outline: Polygon | MultiPolygon) -> list[list[list[list[float]]]]:
    """Of each polygon its rings, the outer one first, each a closed list of (y, z)."""
    return [
        [[[float(y), float(z)] for y, z, *_ in ring.coords] for ring in (part.exterior, *part.interiors)]
        for part in getattr(outline, "geoms", [outline])
    ]


def _coupling(coupling: Coupling) -> dict[str, Any]:
    if isinstance(coupling, Mpc):
        return {
            "kind": "mpc",
            "nodes": coupling.nodes.tolist(),
            "components": coupling.components.tolist(),
            "coefficients": coupling.coefficients.tolist(),
        }
    if isinstance(coupling, Rbe2):
        return {
            "kind": "rbe2",
            "independent": int(coupling.independent),
            "dependent": coupling.dependent.tolist(),
            "components": coupling.components,
        }
    return {
        "kind": "rbe3",
        "dependent": int(coupling.dependent),
        "independent": coupling.independent.tolist(),
        "weights": coupling.weights.tolist(),
        "components": coupling.components,
        "independent_components": coupling.independent_components,
    }


register(DeckFormat("json", "JSON", (".json",), "application/json", write))
