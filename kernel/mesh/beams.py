"""Beams divided into line elements, with nodes opposite those of the walls that they lie along."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from kernel.connect.joints import Joint
from kernel.idealise.beam import Beam, divide
from kernel.idealise.footprints import Seat
from kernel.idealise.parts import Parts
from kernel.mesh.faces import CurvesByFace
from kernel.mesh.mesh import ElementBlock
from kernel.mesh.nodes import NodeTable
from kernel.mesh.seeding import CurveWish


@dataclass(frozen=True, slots=True, eq=False)
class SeatedNode:
    """A beam's node beside the wall's node that it follows."""

    joint: Joint
    wall_node: int
    beam_node: int


def mesh_beams(
    parts: Parts, curves: CurvesByFace, sizes: dict[str, float], wishes: Mapping[str, CurveWish], nodes: NodeTable
) -> tuple[dict[str, ElementBlock], dict[str, list[SeatedNode]]]:
    """Line elements of every beam, and the nodes that sit on walls, both by segment id; sets the beams' nodes.

    wishes: what is asked of axes, by segment id.
    """
    blocks: dict[str, ElementBlock] = {}
    seated: dict[str, list[SeatedNode]] = {}
    for name, beam in parts.beams.items():
        on_walls = [
            (seat, node, offset)
            for seat in parts.seats.get(name, [])
            for node, offset in _nodes_along(parts, beam, seat, curves, nodes)
        ]
        if on_walls:
            # The wall's nodes say where the beam's are: stations between them would make slivers of elements.
            low, high = min(offset for _, _, offset in on_walls), max(offset for _, _, offset in on_walls)
            slack = 0.25 * sizes[name]
            beam.stations = [
                value
                for value in beam.stations
                if not low - slack < value < high + slack or beam.is_end(value, parts.topology.tolerance)
            ]
            beam.stations += [offset for _, _, offset in on_walls]
        wish = wishes.get(name, CurveWish())
        beam.offsets = divide(beam, sizes[name], 4 * parts.topology.tolerance, wish.count, wish.size)
        beam.nodes = nodes.add(beam.origin + beam.offsets[:, None] * beam.direction)
        lines = np.stack([beam.nodes[:-1], beam.nodes[1:]], axis=1)
        blocks[name] = ElementBlock(name, "line2", lines, np.repeat(beam.orientation[None], len(lines), axis=0))
        if on_walls:
            seated[name] = [SeatedNode(seat.joint, node, beam.node_at(offset)) for seat, node, offset in on_walls]
    return blocks, seated


def _nodes_along(
    parts: Parts, beam: Beam, seat: Seat, curves: CurvesByFace, nodes: NodeTable
) -> list[tuple[int, float]]:
    """The wall's nodes on the seat, and the beam's offsets beside them."""
    slack = 8 * parts.topology.tolerance
    found: dict[int, float] = {}
    for seeded in curves.get(seat.wall.index, []):
        if seeded.curve.carrier == seat.carrier:
            for node, offset in zip(seeded.nodes.tolist(), nodes.points[seeded.nodes] @ beam.direction):
                if seat.start - slack <= offset <= seat.end + slack:
                    found[node] = beam.offset_of(offset * beam.direction)
    return sorted(found.items(), key=lambda item: item[1])
