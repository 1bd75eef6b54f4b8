"""The report's pictures, as PNG."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from app.report.quality_scene import quality_bodies
from app.report.render import Scene, png, render
from app.report.scenes import Body, mesh_bodies, segment_bodies, solid_body

if TYPE_CHECKING:
    from app.pipeline import Meshed


def pictures(meshed: Meshed) -> dict[str, bytes]:
    """PNG files: "solid", "segments", "mesh" and "quality", in this order."""
    classified = meshed.classified
    return {
        "solid": picture([solid_body(classified.evaluated)]),
        "segments": picture(segment_bodies(classified.evaluated, classified.partition.segments)),
        "mesh": picture(mesh_bodies(meshed.model)),
        "quality": picture(quality_bodies(meshed.model)),
    }


def picture(bodies: list[Body], width: int = 900, height: int = 640) -> bytes:
    """Bodies in their colours with their lines, as a PNG."""
    triangles = np.concatenate([body.triangles for body in bodies])
    colours = np.repeat(
        np.array([body.colour for body in bodies], np.uint8), [len(body.triangles) for body in bodies], axis=0
    )
    edges = _lines([body for body in bodies if not body.is_mark])
    marks = _lines([body for body in bodies if body.is_mark])
    return png(render(Scene(triangles, colours, *edges, *marks), width, height))


def _lines(bodies: list[Body]) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """The lines (n, 2, 3) of bodies, and the colour (n, 3) of each."""
    lines = [np.empty((0, 2, 3)), *(body.lines for body in bodies)]
    colours = [np.empty((0, 3), np.uint8)]
    colours += [np.tile(np.array(body.line_colour, np.uint8), (len(body.lines), 1)) for body in bodies]
    return np.concatenate(lines), np.concatenate(colours)
