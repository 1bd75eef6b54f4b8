"""Strips: the slab of a wall in the sheet of one that it meets, along their joint curve."""

from __future__ import annotations

import numpy as np
import shapely
from shapely import Polygon

from kernel.idealise.carriers import Carrier, Line
from kernel.idealise.crossings import CURVED_OVERLAP, Crossing, samples, slab_edges, whole_range
from kernel.idealise.outlines import PolygonLike, unwrapped, windowed
from kernel.idealise.sheets import PlaneSheet
from kernel.idealise.topology import Topology
from kernel.idealise.tube_curve import TubeCurve, slab_stations, tube_curve
from kernel.idealise.walls import Wall


def strip(
    topology: Topology, wall: Wall, crossing: Crossing, start: float, end: float, gap: float = 0.0
) -> PolygonLike:
    """The other wall's slab in this wall's sheet, along a stretch of the joint curve; `gap` thicker on each side."""
    return _strip_beside(topology, wall, crossing.other(wall), topology.carrier(crossing.carrier), start, end, gap)


def _strip_beside(
    topology: Topology, wall: Wall, other: Wall, carrier: Carrier, start: float, end: float, gap: float
) -> PolygonLike:
    margin = 0.0 if isinstance(carrier, Line) else CURVED_OVERLAP * min(wall.thickness, other.thickness)
    if carrier.period is not None and end - start >= carrier.period - topology.tolerance:
        middle = 0.5 * (start + end)
        halves = [_strip_beside(topology, wall, other, carrier, a, b, gap) for a, b in ((start, middle), (middle, end))]
        return shapely.union_all(halves)
    if isinstance(carrier, TubeCurve):
        half = 0.5 * other.thickness + margin + gap
        curve = carrier.at(slab_stations(carrier, wall.sheet.surface, half, start, end))
    else:
        curve = samples(topology, carrier, start, end)
    edges = slab_edges(wall, other, curve, margin + gap, carrier)
    if isinstance(wall.sheet, PlaneSheet) and isinstance(other.sheet, PlaneSheet):
        return Polygon(wall.sheet.flat(np.concatenate([edges[0], edges[1][::-1]])))
    sides = [unwrapped(wall.sheet, side) for side in edges]
    if wall.sheet.turn is not None:
        sides[1] = sides[1] + (wall.sheet.turn * np.round((sides[0][0, 0] - sides[1][0, 0]) / wall.sheet.turn), 0.0)
    polygon = Polygon(np.vstack([sides[0], sides[1][::-1]]))
    return windowed(wall.sheet, polygon if polygon.is_valid else polygon.buffer(0))


def slabs_of_tube(
    topology: Topology, wall: Wall, other: Wall, carrier: TubeCurve
) -> tuple[list[PolygonLike], list[PolygonLike]]:
    """The other tube's slab in this one's sheet: where both merge about the bends, and all of it.

    About a bend the material is one lump of both walls, whoever owns it. What a tube has there, or elsewhere of the
    other's wall, does not say on which side of the curve it goes on.
    """
    margin = CURVED_OVERLAP * min(wall.thickness, other.thickness)
    around, whole = [], []
    for curve in (carrier, tube_curve(carrier.frame, -carrier.side)):
        (first, last), (start, end) = curve.clear_of_bends(0.5 * max(wall.thickness, other.thickness) + margin)
        for low, high in ((last, start), (end, first + curve.period)):
            if high - low > topology.tolerance:
                around.append(_strip_beside(topology, wall, other, curve, low, high, 0.0))
        whole.append(_strip_beside(topology, wall, other, curve, 0.0, curve.period, margin))
    return around, whole


def slab(topology: Topology, wall: Wall, crossing: Crossing) -> PolygonLike:
    """The other wall's slab in this wall's sheet, all along the joint curve."""
    ends = whole_range(topology, topology.carrier(crossing.carrier), wall.segment.solid.bounds)
    return strip(topology, wall, crossing, *ends)
