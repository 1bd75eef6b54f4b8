"""What the crossings of a wall lay into its sheet: strips for the other walls' slabs, and lines that part the cells.

Each is laid once: walls in line on both sides of a third lay the same strips into it, and a stretch along which a wall
is cut back is mostly all that it reaches.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.idealise.crossings import Crossing, Interval, merged, samples, slab_edges
from kernel.idealise.outlines import PolygonLike, unwrapped, windowed
from kernel.idealise.strips import strip
from kernel.idealise.topology import Topology
from kernel.idealise.trims import step_ends
from kernel.idealise.walls import Wall

CUT_BEYOND = 0.2
"""Joint curves cut the cells this share of half the slab beyond their ends, so that ends never fall short."""


_Where = tuple[int, int, float, float, float, float]
"""Of a strip: the carrier, the sheet and thickness of the wall whose slab it is, start, end, and gap."""


class Laid:
    """strips: of the slabs that the wall reaches; gaps: those of crossings with a gap, taken thicker by it.

    trims: strips along which the wall may be cut back. cuts: the lines.
    """

    def __init__(self, topology: Topology, wall: Wall) -> None:
        self._topology, self._wall = topology, wall
        self._made: dict[_Where, PolygonLike] = {}
        self._strips: set[_Where] = set()
        self._gaps: set[_Where] = set()
        self._trims: set[_Where] = set()
        self._along: set[tuple[int, float, float]] = set()
        self.strips: list[PolygonLike] = []
        self.gaps: list[PolygonLike] = []
        self.trims: list[PolygonLike] = []
        self.cuts: list[shapely.Geometry] = []

    def add(self, crossing: Crossing, trims: Sequence[Interval]) -> None:
        """What one crossing lays. trims: the stretches of its curve along which the wall may be cut back."""
        gap = crossing.gap.get(self._wall.index, 0.0)
        for ends in crossing.reach[self._wall.index]:
            self._lay(self.strips, self._strips, crossing, ends, 0.0)
            if gap:
                self._lay(self.gaps, self._gaps, crossing, ends, gap)
        for ends in trims:
            self._lay(self.trims, self._trims, crossing, ends, gap)
        self._cut_along(crossing, trims)
        self._cut_across(crossing, trims, gap)

    def _lay(
        self, strips: list[PolygonLike], known: set[_Where], crossing: Crossing, ends: Interval, gap: float
    ) -> None:
        other = crossing.other(self._wall)
        where = (crossing.carrier, other.sheet.surface_id, other.thickness, *ends, gap)
        if where in known:
            return
        known.add(where)
        if where not in self._made:
            self._made[where] = strip(self._topology, self._wall, crossing, *ends, gap)
        strips.append(self._made[where])

    def _cut_along(self, crossing: Crossing, trims: Sequence[Interval]) -> None:
        """Lines along the joint curve, a little longer than either wall may be cut back."""
        carrier, other = self._topology.carrier(crossing.carrier), crossing.other(self._wall)
        beyond = CUT_BEYOND * 0.5 * other.thickness
        slack = 10 * self._topology.tolerance  # chords that differ leave slivers
        for start, end in merged([*trims, *crossing.reach[other.index]], slack, carrier.period):
            is_all = carrier.period is not None and end - start >= carrier.period - self._topology.tolerance
            more = 0.0 if is_all else beyond
            where = (crossing.carrier, start - more, end + more)
            if where not in self._along:
                self._along.add(where)
                self._cut(samples(self._topology, carrier, start - more, end + more))

    def _cut_across(self, crossing: Crossing, trims: Sequence[Interval], gap: float) -> None:
        """Lines across the slab where a trim ends within the wall's reach."""
        carrier, other = self._topology.carrier(crossing.carrier), crossing.other(self._wall)
        margin = gap + CUT_BEYOND * 0.5 * other.thickness
        for value in step_ends(crossing, self._wall, trims, 10 * self._topology.tolerance):
            ends = slab_edges(self._wall, other, carrier.at(np.array([value])), margin, carrier)
            self._cut(np.vstack(ends))

    def _cut(self, points: NDArray[np.float64]) -> None:
        sheet = self._wall.sheet
        self.cuts.append(windowed(sheet, shapely.LineString(unwrapped(sheet, points))))
