"""The report's pictures, as PNG."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.report.quality_scene import quality_bodies
from app.report.render import Scene, png, render
from app.report.scenes import EDGE_COLOUR, Body, mesh_bodies, segment_bodies, solid_body

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
    lines = np.concatenate([body.lines for body in bodies])
    colours = np.repeat(
        np.array([body.colour for body in bodies], np.uint8), [len(body.triangles) for body in bodies], axis=0
    )
    line_colours = np.tile(np.array(EDGE_COLOUR, np.uint8), (len(lines), 1))
    return png(render(Scene(triangles, colours, lines, line_colours), width, height))
