"""Walls that meet another askew: cut square, their mid-surface ends before the other's face."""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.idealise.carriers import Line
from kernel.idealise.crossings import Crossing, slab_edges
from kernel.idealise.outlines import domain
from kernel.idealise.topology import Topology
from kernel.idealise.walls import Wall, section_outline
from kernel.solid.surfaces import signed_distance

Array = NDArray[np.float64]

ALONGSIDE = 1e-6
"""An edge runs along a joint curve when the sine between them is smaller."""


def own_edge(topology: Topology, crossing: Crossing, web: Wall, flange: Wall, side: float) -> tuple[float, int] | None:
    """How far from the flange's face a web that stands askew ends, and the carrier there; None where it is curved."""
    curve = topology.carrier(crossing.carrier)
    if not isinstance(curve, Line):
        return None
    found = []
    for number in {stretch.carrier for ring in web.rings for stretch in ring}:
        edge = topology.carrier(number)
        if isinstance(edge, Line) and np.linalg.norm(np.cross(edge.direction, curve.direction)) < ALONGSIDE:
            away = side * float(signed_distance(flange.sheet.surface, edge.point[None])[0]) - 0.5 * flange.thickness
            if -topology.tolerance <= away <= crossing.gap[web.index] + topology.tolerance:
                found.append((max(away, 0.0), number))
    return min(found, default=None)


def is_filled(topology: Topology, web: Wall, flanges: tuple[Wall, ...], points: Array, side: float, gap: float) -> bool:
    """Whether the wedge between a web's square end and the flange's face is material, which the flange was given."""
    middle = web.sheet.flat(slab_edges(web, flanges[0], points, 0.5 * gap)[0 if side > 0 else 1])
    inside = np.zeros(len(points), dtype=bool)
    for flange in flanges:
        rings = section_outline(topology, flange.segment.solid, web.sheet)
        if rings:
            inside |= shapely.contains_xy(domain(topology, web.sheet, rings), middle[:, 0], middle[:, 1])
    return bool(inside.all())
