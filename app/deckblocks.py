"""Readers of formats that group elements by type: CalculiX and Abaqus (.inp), ANSYS's blocked archive (.cdb)."""

from __future__ import annotations

import re

from app.deckmesh import SAME, Rows, deck_mesh, ordered, used_nodes
from kernel.errors import Place, ReadError
from kernel.mesh.mesh import Mesh

INP_TYPES: dict[str, tuple[str, tuple[int, ...]]] = {
    "B31": ("line2", SAME[:2]),
    "B32": ("line3", (0, 2, 1)),
    "S3": ("tri3", SAME[:3]),
    "S4": ("quad4", SAME[:4]),
    "S6": ("tri6", SAME[:6]),
    "STRI65": ("tri6", SAME[:6]),
    "S8": ("quad8", SAME[:8]),
    "C3D4": ("tet4", SAME[:4]),
    "C3D6": ("wedge6", SAME[:6]),
    "C3D8": ("hex8", SAME[:8]),
    "C3D10": ("tet10", SAME[:10]),
    "C3D15": ("wedge15", SAME[:15]),
    "C3D20": ("hex20", SAME[:20]),
}
"""By type without its formulation (R: reduced, I: incompatible modes); nodes as in the file."""

NO_MEMBERS = ("KNOTS",)
"""Element sets that carry no stiffness of the model: they only make rotations known to CalculiX."""

CDB_TYPES: dict[tuple[int, int], tuple[str, tuple[int, ...]]] = {
    (181, 3): ("tri3", (0, 1, 2)),
    (181, 4): ("quad4", SAME[:4]),
    (281, 6): ("tri6", (0, 1, 2, 4, 5, 7)),
    (281, 8): ("quad8", SAME[:8]),
    (185, 4): ("tet4", (0, 1, 2, 4)),
    (185, 6): ("wedge6", (0, 1, 2, 4, 5, 6)),
    (185, 8): ("hex8", SAME[:8]),
    (187, 10): ("tet10", SAME[:10]),
    (186, 15): ("wedge15", (0, 1, 2, 4, 5, 6, 8, 9, 11, 12, 13, 15, 16, 17, 18)),
    (186, 20): ("hex20", SAME[:20]),
}
"""By element and its number of different nodes (triangles and wedges repeat some): our nodes' places in the row."""

CDB_LINES = {188: ("line2", 2), 189: ("line3", 3)}
"""Beams by element: kind and number of nodes; one more turns the section."""

CDB_HEAD = 11
"""Fields of an element before its nodes; the second is the type's number, the ninth counts the nodes."""


def read_inp(path: str, text: str) -> Mesh:
    """Keyword input of CalculiX or Abaqus: *NODE and *ELEMENT. CalculiX's beams always have three nodes."""
    nodes: dict[int, list[float]] = {}
    rows: Rows = {}
    keyword, current = "", None
    row: list[int] = []
    for line_number, raw in enumerate(text.splitlines(), start=1):
        line = raw.strip()
        if not line or line.startswith("**"):
            continue
        try:
            if line.startswith("*"):
                keyword, options = _keyword(line)
                current, row = _inp_type(options) if keyword == "*ELEMENT" else None, []
            elif keyword == "*NODE":
                number, *place = [word.strip() for word in line.split(",")]
                nodes[int(number)] = [float(word) for word in place[:3]]
            elif current is not None:
                row += [int(word) for word in line.split(",") if word.strip()]
                if not line.endswith(","):
                    kind, order = current
                    rows.setdefault(kind, []).append(ordered(row[1:], order))
                    row = []
        except ValueError as error:
            raise ReadError(f"{keyword} cannot be read: {error}", place=Place(path, line_number, 1)) from error
    return deck_mesh(path, used_nodes(nodes, rows), rows)


def read_cdb(path: str, text: str) -> Mesh:
    """Blocked archive of ANSYS: ET, NBLOCK and EBLOCK."""
    lines = text.splitlines()
    types = {int(number): int(name) for number, name in re.findall(r"^ET,\s*(\d+),\s*(\d+)", text, re.MULTILINE)}
    nodes: dict[int, list[float]] = {}
    rows: Rows = {}
    at = 0
    try:
        while at < len(lines):
            if lines[at].startswith("NBLOCK"):
                at = _cdb_nodes(lines, at + 1, nodes)
            elif lines[at].startswith("EBLOCK"):
                at = _cdb_elements(lines, at + 1, types, rows)
            at += 1
    except (ValueError, IndexError, KeyError) as error:
        raise ReadError(f"the archive cannot be read: {error}", place=Place(path, at + 1, 1)) from error
    return deck_mesh(path, used_nodes(nodes, rows), rows)


def _keyword(line: str) -> tuple[str, dict[str, str]]:
    name, *words = [word.strip().upper() for word in line.split(",")]
    return name, {key.strip(): value.strip() for key, _, value in (word.partition("=") for word in words)}


def _inp_type(options: dict[str, str]) -> tuple[str, tuple[int, ...]] | None:
    if options.get("ELSET") in NO_MEMBERS:
        return None
    written = options.get("TYPE", "")
    known = INP_TYPES.get(written) or INP_TYPES.get(written[:-1] if written[-1:] in ("R", "I") else "")
    if known is None:
        raise ValueError(f"element type {written!r} is not known")
    return known


def _widths(line: str) -> list[int]:
    """Of a Fortran format such as (3i9,6e21.13e3): counts and widths in turn."""
    found = [int(number) for pair in re.findall(r"(\d+)[ie](\d+)", line.lower()) for number in pair]
    if not found:
        raise ValueError(f"the format {line.strip()!r} is not known, expected one such as (19i9)")
    return found


def _cdb_nodes(lines: list[str], at: int, nodes: dict[int, list[float]]) -> int:
    """Read from the format line on; gives the line that ends the block."""
    count, width, _, real = _widths(lines[at])[:4]
    at += 1
    while not lines[at].startswith(("N,", "-1")) and lines[at].strip() != "-1":
        line, start = lines[at], count * width
        fields = [line[start + k * real : start + (k + 1) * real].strip() for k in range(3)]
        nodes[int(line[:width])] = [float(field) if field else 0.0 for field in fields]
        at += 1
    return at


def _cdb_elements(lines: list[str], at: int, types: dict[int, int], rows: Rows) -> int:
    per_line, width = _widths(lines[at])[:2]
    at += 1
    while lines[at].strip() != "-1":
        fields: list[int] = []
        wanted = CDB_HEAD
        while len(fields) < wanted:
            line = lines[at]
            fields += [int(line[k : k + width]) for k in range(0, min(len(line), per_line * width), width)]
            wanted = CDB_HEAD + fields[8]
            at += 1
        row, element = fields[CDB_HEAD:], types[fields[1]]
        if element in CDB_LINES:
            kind, count = CDB_LINES[element]
            rows.setdefault(kind, []).append(row[:count])
            continue
        known = CDB_TYPES.get((element, len(set(row))))
        if known is None:
            raise ValueError(f"element {element} with {len(set(row))} nodes is not known")
        rows.setdefault(known[0], []).append([row[place] for place in known[1]])
    return at
