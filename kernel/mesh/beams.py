"""Beams divided into line elements."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kernel.idealise.beam import divide
from kernel.idealise.parts import Parts
from kernel.mesh.faces import SeededCurve
from kernel.mesh.mesh import ElementBlock
from kernel.mesh.nodes import NodeTable


def mesh_beams(
    parts: Parts, curves: Sequence[SeededCurve], sizes: dict[str, float], nodes: NodeTable
) -> dict[str, ElementBlock]:
    """Line elements of every beam, by segment id; sets the beams' nodes."""
    blocks = {}
    for name, beam in parts.beams.items():
        beam.offsets = divide(beam, sizes[name], parts.topology.tolerance)
        beam.nodes = nodes.add(beam.origin + beam.offsets[:, None] * beam.direction)
        lines = np.stack([beam.nodes[:-1], beam.nodes[1:]], axis=1)
        orientation = np.repeat(beam.orientation[None], len(lines), axis=0)
        blocks[name] = ElementBlock(name, "line2", lines, orientation)
    return blocks
