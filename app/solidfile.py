"""The evaluated solid as a file of triangles, through trimesh."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from kernel.errors import OptionError

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated

ENDINGS = ("stl", "glb", "3mf", "ply")


def ending_of(path: str) -> str:
    """The file type that the ending of `path` means; OptionError where it is none of ours."""
    ending = path.rpartition(".")[2].lower()
    if ending not in ENDINGS:
        raise OptionError(f"no solid format for the ending of {path!r}, expected one of .{' .'.join(ENDINGS)}")
    return ending


def solid_file(evaluated: Evaluated, ending: str) -> bytes:
    """The whole solid in the user's frame, as the bytes of a file of type `ending`."""
    from trimesh import Trimesh

    facets = evaluated.solid.facets
    points = np.ascontiguousarray(facets.vertices @ evaluated.frame.T)
    body = Trimesh(points, facets.triangles, process=False).export(file_type=ending)
    return body.encode() if isinstance(body, str) else bytes(body)
