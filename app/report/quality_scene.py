"""The mesh coloured by quality: each element's outer faces in the colour of its scaled Jacobian."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from app.report.scenes import Body, beam_shapes, blocks_by_segment, fans, outer_faces, rims
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.quality import element_quality

if TYPE_CHECKING:
    from kernel.connect.model import Model

RAMP = (
    (196, 38, 46), (222, 84, 58), (238, 134, 78), (249, 184, 108), (252, 222, 150),
    (240, 240, 200), (214, 232, 226), (182, 216, 230), (150, 198, 224), (118, 176, 212),
)  # fmt: skip
"""Tenths of the scaled Jacobian from 0 to 1, bad to good: red to blue over pale yellow, told apart without
red and green; light enough for the element edges to show."""

BEAM_COLOUR = (176, 182, 190)
"""Line elements have no such measure."""


def quality_bodies(model: Model) -> list[Body]:
    """For each segment a body for each tenth of the scaled Jacobian that occurs: `s1 0.9` holds 0.9 to 1."""
    nodes = model.mesh.nodes
    bodies = []
    by_segment = blocks_by_segment(model)
    sections = {prop.segment: prop.section for prop in model.properties}
    for name in sections:
        triangles, lines = beam_shapes(nodes, by_segment.get(name, []), sections[name])
        if len(triangles) > 1:
            bodies.append(Body(name, BEAM_COLOUR, np.concatenate(triangles), np.concatenate(lines)))
        blocks = [block for block in by_segment.get(name, []) if ELEMENT_KINDS[block.kind].dimension > 1]
        if not blocks:
            continue
        values = np.concatenate([element_quality(block, nodes)["scaled_jacobian"] for block in blocks])
        tenth = np.clip(np.floor(10 * values), 0, 9).astype(int)
        outer = outer_faces(blocks)
        for place in np.unique(tenth).tolist():
            loops = [loop[tenth[owner] == place] for loop, owner in outer]
            shown = [loop for loop in loops if len(loop)]
            if shown:
                triangles, lines = ([draw(nodes, loop) for loop in shown] for draw in (fans, rims))
                parts = np.concatenate(triangles), np.concatenate(lines)
                bodies.append(Body(f"{name} {place / 10:g}", RAMP[place], *parts))
    return bodies
