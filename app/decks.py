"""Decks read back, as far as their quality needs it: nodes and elements of NASTRAN, Gmsh 4.1 and VTU files here,
of CalculiX, Abaqus and ANSYS archives in app/deckblocks.py, of JSON decks by kernel/deck/jsonread.py.

The tables say, for each node that a file lists, its place in our order (kernel/mesh/elements.py).
"""

from __future__ import annotations

import base64
import re
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from app.deckblocks import read_cdb, read_inp
from app.deckmesh import SAME, Rows, deck_mesh, ordered
from kernel.errors import OptionError, Place, ReadError
from kernel.mesh.mesh import Mesh

NASTRAN_CARDS: dict[str, tuple[tuple[str, tuple[int, ...]], ...]] = {
    "CBAR": (("line2", SAME[:2]),),
    "CBEAM": (("line2", SAME[:2]),),
    "CTRIA3": (("tri3", SAME[:3]),),
    "CTRIA6": (("tri6", SAME[:6]), ("tri3", SAME[:3])),
    "CQUAD4": (("quad4", SAME[:4]),),
    "CQUAD8": (("quad8", SAME[:8]), ("quad4", SAME[:4])),
    "CTETRA": (("tet10", SAME[:10]), ("tet4", SAME[:4])),
    "CPENTA": (("wedge15", (0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11)), ("wedge6", SAME[:6])),
    "CHEXA": (
        ("hex20", (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15)),
        ("hex8", SAME[:8]),
    ),
}
"""By card: the kinds that it can be, the one with most nodes first."""

GMSH_TYPES: dict[int, tuple[str, tuple[int, ...]]] = {
    1: ("line2", SAME[:2]),
    8: ("line3", SAME[:3]),
    2: ("tri3", SAME[:3]),
    9: ("tri6", SAME[:6]),
    3: ("quad4", SAME[:4]),
    16: ("quad8", SAME[:8]),
    4: ("tet4", SAME[:4]),
    11: ("tet10", (0, 1, 2, 3, 4, 5, 6, 7, 9, 8)),
    6: ("wedge6", SAME[:6]),
    18: ("wedge15", (0, 1, 2, 3, 4, 5, 6, 8, 12, 7, 13, 14, 9, 11, 10)),
    5: ("hex8", SAME[:8]),
    17: ("hex20", (0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 16, 9, 17, 10, 18, 19, 12, 15, 13, 14)),
}

VTK_TYPES: dict[int, tuple[str, tuple[int, ...]]] = {
    3: ("line2", SAME[:2]),
    21: ("line3", SAME[:3]),
    5: ("tri3", SAME[:3]),
    22: ("tri6", SAME[:6]),
    9: ("quad4", SAME[:4]),
    23: ("quad8", SAME[:8]),
    10: ("tet4", SAME[:4]),
    24: ("tet10", SAME[:10]),
    # VTK's wedge has its first triangle the other way round than ours
    13: ("wedge6", (0, 2, 1, 3, 5, 4)),
    26: ("wedge15", (0, 2, 1, 3, 5, 4, 8, 7, 6, 11, 10, 9, 12, 14, 13)),
    12: ("hex8", SAME[:8]),
    25: ("hex20", SAME[:20]),
}


def read_deck(path: str) -> Mesh:
    """Nodes and elements of the deck at `path`, all as one segment (of a JSON deck with its segments).

    OptionError: the file cannot be opened, or its ending is none that is read. ReadError: it is not what it seems.
    """
    reader = next((reader for endings, reader in _READERS.items() if path.lower().endswith(endings)), None)
    if reader is None:
        expected = " ".join(ending for endings in _READERS for ending in endings)
        raise OptionError(f"no deck is read from the ending of {path!r}, expected one of {expected}")
    try:
        text = Path(path).read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise OptionError(f"{path}: cannot be read, {error.strerror}") from error
    return reader(path, text)


def read_nastran(path: str, text: str) -> Mesh:
    """Bulk data in small, large or free fields."""
    nodes: dict[int, list[float]] = {}
    rows: Rows = {}
    for line, card in _nastran_cards(text):
        try:
            if card[0] == "GRID":
                if card[2] not in ("", "0"):
                    raise ReadError(f"coordinate system {card[2]} is not read", place=Place(path, line, 1))
                nodes[int(card[1])] = [_nastran_number(field) for field in card[3:6]]
            elif card[0] in NASTRAN_CARDS:
                _add_nastran_element(card, rows)
        except (ValueError, IndexError) as error:
            raise ReadError(f"{card[0]} cannot be read: {error}", place=Place(path, line, 1)) from error
    return deck_mesh(path, nodes, rows)


def read_gmsh(path: str, text: str) -> Mesh:
    """MSH 4.1, ASCII."""
    lines = text.splitlines()
    if lines[1:2] != ["4.1 0 8"]:
        raise ReadError("not MSH 4.1 in ASCII, expected '4.1 0 8'", place=Place(path, 2, 1))
    nodes: dict[int, list[float]] = {}
    rows: Rows = {}
    at = 0
    try:
        at = lines.index("$Nodes") + 2
        for _ in range(int(lines[at - 1].split()[0])):
            count = int(lines[at].split()[3])
            for k in range(at + 1, at + 1 + count):
                nodes[int(lines[k])] = [float(word) for word in lines[k + count].split()[:3]]
            at += 1 + 2 * count
        at = lines.index("$Elements") + 2
        for _ in range(int(lines[at - 1].split()[0])):
            _, _, code, count = (int(word) for word in lines[at].split())
            if code in GMSH_TYPES:
                kind, order = GMSH_TYPES[code]
                for line in lines[at + 1 : at + 1 + count]:
                    rows.setdefault(kind, []).append(ordered([int(word) for word in line.split()[1:]], order))
            elif code != 15:
                raise ReadError(f"element type {code} is not known", place=Place(path, at + 1, 1))
            at += 1 + count
    except (ValueError, IndexError) as error:
        raise ReadError(f"the mesh cannot be read: {error}", place=Place(path, at + 1, 1)) from error
    return deck_mesh(path, nodes, rows)


def read_vtu(path: str, text: str) -> Mesh:
    """VTK unstructured grid, its arrays in ASCII or in base64 without compression."""
    from xml.etree import ElementTree

    try:
        root = ElementTree.fromstring(text)
        if root.get("compressor"):
            raise ReadError("compressed arrays are not read", place=Place(path, 1, 1))
        points = _vtu_array(root, "Points/DataArray").reshape(-1, 3)
        named = {
            name: _vtu_array(root, f"Cells/DataArray[@Name='{name}']") for name in ("connectivity", "offsets", "types")
        }
    except (ElementTree.ParseError, ValueError, KeyError) as error:
        raise ReadError(f"the grid cannot be read: {error}", place=Place(path, 1, 1)) from error
    rows: Rows = {}
    start = 0
    for end, code in zip(named["offsets"].tolist(), named["types"].tolist()):
        if code in VTK_TYPES:
            kind, order = VTK_TYPES[code]
            rows.setdefault(kind, []).append(ordered(named["connectivity"][start:end].tolist(), order))
        elif code != 1:
            raise ReadError(f"cell type {code} is not known", place=Place(path, 1, 1))
        start = end
    return deck_mesh(path, dict(enumerate(points.tolist())), rows)


def read_json(path: str, text: str) -> Mesh:
    """The mesh of a JSON deck, whole."""
    from kernel.deck.jsonread import read_json_deck

    return read_json_deck(text, path).mesh


_READERS: dict[tuple[str, ...], Callable[[str, str], Mesh]] = {
    (".bdf", ".nas", ".dat"): read_nastran,
    (".msh",): read_gmsh,
    (".vtu",): read_vtu,
    (".inp",): read_inp,
    (".cdb",): read_cdb,
    (".json",): read_json,
}


_VTK_ARRAYS = {"Float64": "<f8", "Float32": "<f4", "Int64": "<i8", "Int32": "<i4", "UInt8": "u1"}


def _nastran_cards(text: str) -> Iterator[tuple[int, list[str]]]:
    """(line number, fields) of each card, continuations joined; the case control before BEGIN BULK is left out."""
    lines = text.splitlines()
    begin = next((k for k, line in enumerate(lines) if line.upper().startswith("BEGIN BULK")), -1)
    card: list[str] = []
    first = 0
    for number, raw in enumerate(lines[begin + 1 :], start=begin + 2):
        line = raw.partition("$")[0].rstrip()
        if not line:
            continue
        name, fields = _nastran_fields(line)
        if name and name[0] not in "+*":
            if card:
                yield first, card
            card, first = [name, *fields], number
        else:
            card += fields
    if card:
        yield first, card


def _nastran_fields(line: str) -> tuple[str, list[str]]:
    """Name and data fields of one line, blanks at the end kept: a continuation starts at the next row's first field."""
    if "," in line:
        name, *fields = [word.strip() for word in line.split(",")]
        fields = (fields + [""] * 8)[:8]
    else:
        name = line[:8].strip()
        width, count = (16, 4) if "*" in name else (8, 8)
        fields = [line[8 + k * width : 8 + (k + 1) * width].strip() for k in range(count)]
    return (name.upper().rstrip("*") or name), fields


def _nastran_number(field: str) -> float:
    """A real; `1.5-3` is 1.5e-3, and blank is 0."""
    if not field:
        return 0.0
    try:
        return float(field)
    except ValueError:
        return float(re.sub(r"(?<=[\d.])([+-])", r"e\1", field.upper().replace("D", "e")))


def _add_nastran_element(card: list[str], rows: Rows) -> None:
    for kind, order in NASTRAN_CARDS[card[0]]:
        fields = card[3 : 3 + len(order)]
        if len(fields) == len(order) and all(field not in ("", "0") for field in fields):
            rows.setdefault(kind, []).append(ordered([int(field) for field in fields], order))
            return
    raise ValueError("nodes are missing")


def _vtu_array(root: object, where: str) -> NDArray:
    from xml.etree.ElementTree import Element

    assert isinstance(root, Element)
    element = root.find(f"UnstructuredGrid/Piece/{where}")
    if element is None:
        raise ValueError(f"no {where}")
    kind = np.dtype(_VTK_ARRAYS[element.attrib["type"]])
    text = (element.text or "").strip()
    if element.get("format") == "ascii":
        return np.array(text.split(), dtype=kind)
    if element.get("format") != "binary":
        raise ValueError(f"array format {element.get('format')!r} is not read, expected ascii or binary")
    header = 8 if root.get("header_type") == "UInt64" else 4
    raw = base64.b64decode(text)
    return np.frombuffer(raw[header : header + int.from_bytes(raw[:header], "little")], kind)
