"""The evaluated solid as a file of triangles, through trimesh; the same solid gives the same bytes."""

from __future__ import annotations

import io
import itertools
import re
import uuid
import zipfile
from typing import TYPE_CHECKING

import numpy as np

from kernel.errors import OptionError

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated
    from kernel.solid.solid import Solid

ENDINGS = ("stl", "glb", "3mf", "ply")

_ZIP_DATE = (1980, 1, 1, 0, 0, 0)
"""The earliest that a zip archive can say: files do not tell when they were written."""


def ending_of(path: str) -> str:
    """The file type that the ending of `path` means; OptionError where it is none of ENDINGS."""
    ending = path.rpartition(".")[2].lower() if "." in path else ""
    if ending not in ENDINGS:
        raise OptionError(f"no solid format for the ending of {path!r}, expected one of .{' .'.join(ENDINGS)}")
    return ending


def solid_bytes(evaluated: Evaluated, ending: str, solid: Solid | None = None) -> bytes:
    """`solid` (the whole model's where None) in the user's frame, as a file of type `ending` (one of ENDINGS)."""
    if ending not in ENDINGS:
        raise OptionError(f"no solid format {ending!r}, expected one of {', '.join(ENDINGS)}")
    from trimesh import Trimesh

    facets = (evaluated.solid if solid is None else solid).facets
    vertices, triangles = in_fixed_order(facets.vertices @ evaluated.frame.T, facets.triangles)
    body = Trimesh(vertices, triangles, process=False).export(file_type=ending)
    data = body.encode() if isinstance(body, str) else bytes(body)
    return _undated(data) if ending == "3mf" else data


def in_fixed_order(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The same surface with vertices sorted by coordinates and triangles by vertices."""
    order = np.lexsort(vertices.T[::-1])
    place = np.empty(len(order), np.int64)
    place[order] = np.arange(len(order))
    turned = place[triangles]
    first = np.argmin(turned, axis=1)
    turned = np.take_along_axis(turned, (first[:, None] + np.arange(3)) % 3, axis=1)
    return np.ascontiguousarray(vertices[order]), turned[np.lexsort(turned.T[::-1])]


_UUID = re.compile(rb'UUID="[0-9a-f-]{36}"')


def _undated(data: bytes) -> bytes:
    """The zip archive with its members in the order of their names, without times, ids counted, not random."""
    counter = itertools.count(1)
    out = io.BytesIO()
    with zipfile.ZipFile(io.BytesIO(data)) as archive, zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as undated:
        for name in sorted(archive.namelist()):
            text = _UUID.sub(lambda _: b'UUID="%s"' % str(uuid.UUID(int=next(counter))).encode(), archive.read(name))
            undated.writestr(zipfile.ZipInfo(name, _ZIP_DATE), text, zipfile.ZIP_DEFLATED)
    return out.getvalue()
