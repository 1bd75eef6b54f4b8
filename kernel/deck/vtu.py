"""VTK unstructured grid (.vtu) with arrays in base64: segment, thickness, section and couplings for ParaView.

Cell data: `segment` (index into the property table), `property_kind` (0 beam, 1 shell, 2 solid), `thickness` (0 where
none), `area`. Point data: `coupled` (0 free, 1 independent, 2 dependent). Field data: `set NAME` for each named CSG
node and segment, the numbers of its segments.
"""

from __future__ import annotations

import base64
import re
from collections.abc import Iterator
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray

from kernel.connect.model import Mpc, Rbe2
from kernel.deck.deck import DeckFormat, register
from kernel.deck.header import header_lines, printable

if TYPE_CHECKING:
    from kernel.connect.model import Model

# VTK cell type (vtkCellType.h); our node orders are VTK's
_TYPES = {
    "line2": 3, "tri3": 5, "quad4": 9, "tet4": 10, "hex8": 12, "wedge6": 13,
    "line3": 21, "tri6": 22, "quad8": 23, "tet10": 24, "hex20": 25, "wedge15": 26,
}  # fmt: skip

# vtkWedge's triangle 0 1 2 has its normal away from the top: the other way round than ours
_WEDGE_ORDERS = {"wedge6": (0, 2, 1, 3, 5, 4), "wedge15": (0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13)}

_KIND_NUMBER = {"beam": 0, "shell": 1, "solid": 2}


def write(model: Model) -> bytes:
    """The mesh, its properties and where it is coupled."""
    blocks = model.mesh.blocks
    table = {element.segment: number for number, element in enumerate(model.properties)}
    rows = [
        block.connectivity[:, list(_WEDGE_ORDERS.get(block.kind, range(block.connectivity.shape[1])))]
        for block in blocks
    ]
    sizes = np.concatenate([np.full(len(row), row.shape[1]) for row in rows])
    kinds = np.concatenate([np.full(len(block.connectivity), _TYPES[block.kind]) for block in blocks])
    segments = np.concatenate([np.full(len(block.connectivity), table[block.segment]) for block in blocks])
    thickness = np.array([element.thickness or 0.0 for element in model.properties])
    area = np.array([element.section.area if element.section else 0.0 for element in model.properties])
    property_kind = np.array([_KIND_NUMBER[element.kind] for element in model.properties])
    names = "\n".join(printable(f"{element.segment} {element.kind} {element.material}") for element in model.properties)
    lines = [
        '<?xml version="1.0"?>',
        "<!--",
        *(_comment(line) for line in header_lines(model, "VTK unstructured grid")),
        "-->",
        '<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">',
        "<UnstructuredGrid>",
        "<FieldData>",
        *(_array(f"set {name}", numbers, is_field=True) for name, numbers in _sets(model, table)),
        "</FieldData>",
        f'<Piece NumberOfPoints="{model.mesh.n_node}" NumberOfCells="{len(sizes)}">',
        "<Points>",
        _array("Points", model.mesh.nodes, 3),
        "</Points>",
        "<Cells>",
        _array("connectivity", np.concatenate([row.ravel() for row in rows])),
        _array("offsets", np.cumsum(sizes)),
        _array("types", kinds.astype(np.uint8)),
        "</Cells>",
        '<CellData Scalars="segment">',
        _array("segment", segments),
        _array("property_kind", property_kind[segments]),
        _array("thickness", thickness[segments]),
        _array("area", area[segments]),
        "</CellData>",
        "<PointData>",
        _array("coupled", _coupled(model)),
        "</PointData>",
        "</Piece>",
        "</UnstructuredGrid>",
        "</VTKFile>",
    ]
    lines.insert(3, _comment(f"properties: {names}"))
    return ("\n".join(lines) + "\n").encode()


def _comment(text: str) -> str:
    """As XML takes it between `<!--` and `-->`: no two hyphens side by side, however many there are."""
    return re.sub("-(?=-)", "- ", escape(text))


def _sets(model: Model, table: dict[str, int]) -> Iterator[tuple[str, NDArray[np.int64]]]:
    """Of each named set the numbers of the segments that it holds whole, as in the cell data `segment`."""
    owner = np.concatenate([np.full(len(b.connectivity), table[b.segment]) for b in model.mesh.blocks])
    size = np.bincount(owner, minlength=len(table))
    for named in model.sets:
        inside = np.bincount(owner[named.elements], minlength=len(table))
        yield printable(named.name), np.flatnonzero((inside == size) & (size > 0))


def _coupled(model: Model) -> NDArray[np.int64]:
    state = np.zeros(model.mesh.n_node, dtype=np.int64)
    for coupling in model.couplings:
        if isinstance(coupling, Rbe2):
            dependent, independent = coupling.dependent, np.array([coupling.independent])
        elif isinstance(coupling, Mpc):
            dependent, independent = coupling.nodes[:1], coupling.nodes[1:]
        else:
            dependent, independent = np.array([coupling.dependent]), coupling.independent
        state[independent] = np.maximum(state[independent], 1)
        state[dependent] = 2
    return state


def _array(name: str, values: NDArray[np.generic], components: int = 1, is_field: bool = False) -> str:
    """A DataArray: eight bytes of length, then the little-endian values, in base64."""
    kinds = {"f8": "Float64", "i8": "Int64", "u1": "UInt8"}
    code = values.dtype.str[1:]
    raw = np.ascontiguousarray(values).astype(values.dtype.newbyteorder("<")).tobytes()
    payload = base64.b64encode(len(raw).to_bytes(8, "little") + raw).decode("ascii")
    shape = f' NumberOfComponents="{components}"' if components > 1 else ""
    shape += f' NumberOfTuples="{len(values)}"' if is_field else ""
    return f'<DataArray type="{kinds[code]}" Name={quoteattr(name)}{shape} format="binary">{payload}</DataArray>'


register(DeckFormat("vtu", "VTK unstructured grid", (".vtu",), "application/xml", write))
