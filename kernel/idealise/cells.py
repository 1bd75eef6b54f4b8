"""Cells of a plane: what curves part it into, so that each can be meshed by itself on shared seeds.

    +-----------+
    |   .---.   |
    |  (  1  )  |
    | 0 '---'   |
    +-----------+

Every curve is walked both ways; at a vertex the walk takes the leftmost turn. A walk that runs counter-clockwise is the
outer ring of a cell, one that runs clockwise is a hole of the smallest cell around it, or the outside. A curve with one
cell on both sides is an imprint in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.errors import MeshError
from kernel.idealise.sheets import PlaneSheet
from kernel.idealise.topology import BOUNDARY, IMPRINT, Curve, Topology, Use

Array = NDArray[np.float64]
Half = tuple[int, bool]
"""A curve, and whether it is walked from its first vertex to its second."""

LEAVES = 0.05
"""The direction in which a curve leaves a vertex is taken at this share of the shortest curve there: tangent curves
have parted by then, and no curves cross before."""


@dataclass(frozen=True, slots=True, eq=False)
class Cell:
    """rings: of halves, the outer one first, with the cell on their left. polygon: in the sheet's coordinates."""

    rings: tuple[tuple[Half, ...], ...]
    polygon: shapely.Polygon

    @property
    def inner_point(self) -> tuple[float, float]:
        """A place within."""
        point = self.polygon.representative_point()
        return point.x, point.y


def cells_of(topology: Topology, sheet: PlaneSheet, curves: Sequence[Curve]) -> list[Cell]:
    """The bounded cells between the curves, in the order of their first curves. MeshError: curves that overlap."""
    lines = [_line(topology, sheet, curve) for curve in curves]
    outer: list[tuple[tuple[Half, ...], Array]] = []
    inner: list[tuple[tuple[Half, ...], Array]] = []
    for ring in _rings(topology, sheet, curves):
        points = np.concatenate([(lines[k] if forward else lines[k][::-1])[:-1] for k, forward in ring])
        (outer if _area(points) > 0.0 else inner).append((ring, points))
    polygons = [shapely.Polygon(points) for _, points in outer]
    tree = shapely.STRtree(polygons)
    holes: list[list[int]] = [[] for _ in outer]
    for number, (ring, points) in enumerate(inner):
        own = {curve for curve, _ in ring}
        around = [
            place
            for place in tree.query(shapely.Point(points[0]), predicate="within").tolist()
            if own.isdisjoint(curve for curve, _ in outer[place][0])
        ]
        if around:
            holes[min(around, key=lambda place: polygons[place].area)].append(number)
    cells = []
    for (ring, points), inside in zip(outer, holes, strict=True):
        rings = (ring, *(inner[number][0] for number in inside))
        polygon = shapely.Polygon(points, [inner[number][1] for number in inside if len(inner[number][1]) > 2])
        if not polygon.is_valid:
            polygon = polygon.buffer(0)
        if polygon.geom_type != "Polygon" or polygon.is_empty:
            place = topology.place_text(sheet.lift(points[:1])[0])
            raise MeshError(f"curves of the section lie on one another near {place}")
        cells.append(Cell(rings, polygon))
    return cells


def curves_of_cells(curves: Sequence[Curve], cells: Sequence[Cell]) -> list[Curve]:
    """The curves, used by the cells (by their place in the list) instead of by what used them before."""
    uses: list[dict[int, Use]] = [{} for _ in curves]
    for number, cell in enumerate(cells):
        for ring in cell.rings:
            for curve, forward in ring:
                is_second = number in uses[curve]
                uses[curve][number] = Use(IMPRINT if is_second else BOUNDARY, forward)
    return [replace(curve, uses=used) for curve, used in zip(curves, uses, strict=True) if used]


def _rings(topology: Topology, sheet: PlaneSheet, curves: Sequence[Curve]) -> list[tuple[Half, ...]]:
    """Every walk along halves that takes the leftmost turn at each vertex."""
    leaving: dict[int, list[Half]] = {}
    for number, curve in enumerate(curves):
        leaving.setdefault(curve.vertices[0], []).append((number, True))
        leaving.setdefault(curve.vertices[1], []).append((number, False))
    following: dict[Half, Half] = {}
    for halves in leaving.values():
        step = LEAVES * min(curves[number].length for number, _ in halves)
        turn = {half: _heading(topology, sheet, curves[half[0]], half[1], step) for half in halves}
        ordered = sorted(halves, key=lambda half: (turn[half], half))
        for place, (number, forward) in enumerate(ordered):
            following[(number, not forward)] = ordered[place - 1]  # clockwise from the way back
    rings = []
    open_halves = dict.fromkeys((number, forward) for number in range(len(curves)) for forward in (True, False))
    while open_halves:
        half = next(iter(open_halves))
        ring = []
        while half in open_halves:
            del open_halves[half]
            ring.append(half)
            half = following[half]
        rings.append(tuple(ring))
    return rings


def _heading(topology: Topology, sheet: PlaneSheet, curve: Curve, forward: bool, step: float) -> float:
    ends = [curve.start, curve.start + step] if forward else [curve.end, curve.end - step]
    flat = sheet.flat(topology.carrier(curve.carrier).at(np.array(ends)))
    return math.atan2(*(flat[1] - flat[0])[::-1])


def _line(topology: Topology, sheet: PlaneSheet, curve: Curve) -> Array:
    carrier = topology.carrier(curve.carrier)
    points = carrier.at(np.concatenate([[curve.start], carrier.breaks(curve.start, curve.end), [curve.end]]))
    points[[0, -1]] = [topology.vertices.points[vertex] for vertex in curve.vertices]
    return sheet.flat(points)


def _area(points: Array) -> float:
    x, y = (points - points[0]).T
    return 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
