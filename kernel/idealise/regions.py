"""Regions: what of its sheet each wall covers once walls that cross are carried on, or cut back, to where they meet.

In the wall's own flat frame, with strips for the slabs of the walls that it crosses:

    +-----------+--:--+        own section, strip, and the joint curve ":" amid the strip
    |           |  :  |
    |    own    |  :  |        cells = own and strips, within the material, cut along the joint curves
    |           |  :  |        a cell that holds nothing of the wall outside the strips, and ends elsewhere
    +-----------+--:--+        than on joint curves, goes; so a corner ends on the curve, whoever owned it, as far as
                               the other wall stands there (trims.py)

Polygons are for combinatorics only: every edge of the result is put back on its carrier.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from kernel.idealise.carriers import Line
from kernel.idealise.crossings import CURVED_OVERLAP, Crossing
from kernel.idealise.gridded import squared
from kernel.idealise.laid import Laid
from kernel.idealise.outlines import PolygonLike, Stretch, domain
from kernel.idealise.relined import outline_of
from kernel.idealise.sheets import PlaneSheet, Sheet
from kernel.idealise.strips import slab, slabs_of_tube, strip
from kernel.idealise.topology import Topology
from kernel.idealise.trims import trimmed
from kernel.idealise.tube_curve import TubeCurve
from kernel.idealise.walls import Wall, section_outline
from kernel.segment.segments import Segment
from kernel.segment.slices import parts_of

Array = NDArray[np.float64]

GRID = 1e-7
"""Polygons are rounded to this share of the model's size while they are combined."""

HELD = 1e-3
"""A cell holds part of the wall when it has this share of its area (or of the thickness squared) outside strips."""

PINHOLE = 0.01
"""Holes beside other walls' slabs are closed when smaller than this share of the thickness squared."""

FREE = 0.3
"""A cell that holds nothing goes when more than this share of its outline is no joint curve."""

CRUMB = 0.02
"""Islands smaller than this share of the region are joint material of others."""


def joined_regions(
    topology: Topology, walls: Sequence[Wall], crossings: Sequence[Crossing], nearby: dict[int, list[Segment]]
) -> dict[int, PolygonLike]:
    """By index, the region of every wall that crosses others. nearby: by wall index, the segments around it."""
    by_wall = _by_wall(crossings)
    sections = _Sections(topology, walls)
    return {
        wall.index: _region(topology, wall, by_wall[wall.index], nearby[wall.index], sections)
        for wall in walls
        if wall.index in by_wall
    }


def lay_regions(
    topology: Topology, walls: Sequence[Wall], crossings: Sequence[Crossing], regions: Mapping[int, PolygonLike]
) -> None:
    """Give walls their regions, by index, with outlines on carriers."""
    by_wall = _by_wall(crossings)
    for wall in walls:
        if wall.index in regions:
            joint_carriers = {crossing.carrier for crossing in by_wall[wall.index]}
            wall.outline, wall.region = outline_of(topology, wall, regions[wall.index], joint_carriers)


def _by_wall(crossings: Sequence[Crossing]) -> dict[int, list[Crossing]]:
    found: dict[int, list[Crossing]] = {}
    for crossing in crossings:
        for wall in crossing.walls:
            found.setdefault(wall.index, []).append(crossing)
    return found


def _region(
    topology: Topology, wall: Wall, crossings: list[Crossing], nearby: list[Segment], sections: _Sections
) -> PolygonLike:
    size = topology.carriers.reach
    grid = GRID * size
    laid = Laid(topology, wall)
    lumps: list[PolygonLike] = []
    whole: list[PolygonLike] = []
    on_carrier: dict[int, list[Crossing]] = {}
    for crossing in crossings:
        on_carrier.setdefault(crossing.carrier, []).append(crossing)
    for crossing in crossings:
        carrier = topology.carrier(crossing.carrier)
        trims = trimmed(topology, crossing, wall, on_carrier[crossing.carrier])
        laid.add(crossing, trims)
        if isinstance(carrier, TubeCurve) and crossing.reach[wall.index]:
            about, all_round = slabs_of_tube(topology, wall, crossing.other(wall), carrier)
            lumps += about
            whole += all_round
    own = _without_dust(topology, wall, crossings)
    # of the shapes as they are: between one that is on the grid and one that is not there would be slivers
    held = own.difference(shapely.union_all([*laid.trims, *whole]))
    bridged = [part for crossing in crossings for part in _bridges(topology, wall, crossing)]
    beyond = [*laid.strips, *lumps]
    around = _beside([*bridged, *_material(wall, nearby, sections)], beyond, grid)
    layers: list[list[shapely.Geometry]] = [[own], [wall.own, *around], beyond, laid.gaps, laid.cuts]
    on_grid = squared(layers, grid)
    (own,), material, beyond, gaps, cuts = on_grid or layers
    spacing = None if on_grid else grid
    grown = shapely.intersection(
        shapely.union_all([own, *beyond], grid_size=spacing),
        shapely.union_all(material, grid_size=spacing),
        grid_size=spacing,
    )
    grown = shapely.union_all(parts_of(shapely.union_all([grown, *gaps], grid_size=spacing)))
    grown = _without_pinholes(grown, beyond, lumps, PINHOLE * wall.thickness**2)
    lines = shapely.union_all([grown.boundary, *cuts], grid_size=spacing)
    cells = parts_of(shapely.polygonize(shapely.get_parts(lines)))
    kept = _kept_cells(cells, wall, grown, held, shapely.geometrycollections(cuts), grid)
    region = shapely.union_all(kept, grid_size=spacing)
    return shapely.union_all([part for part in parts_of(region) if part.area >= CRUMB * region.area])


def _beside(pieces: list[PolygonLike], places: list[PolygonLike], reach: float) -> list[PolygonLike]:
    """The pieces whose bounds come within `reach` of the bounds of one of the places."""
    own, other = shapely.bounds(pieces).reshape(-1, 1, 4), shapely.bounds(places).reshape(1, -1, 4)
    apart = (own[..., :2] > other[..., 2:] + reach) | (other[..., :2] > own[..., 2:] + reach)
    is_beside = (~apart.any(axis=2)).any(axis=1)
    return [piece for piece, is_near in zip(pieces, is_beside.tolist(), strict=True) if is_near]


def _kept_cells(
    cells: list[Polygon], wall: Wall, grown: PolygonLike, held: PolygonLike, curves: shapely.Geometry, grid: float
) -> list[Polygon]:
    """The cells within `grown` that hold something of the wall (`held`), or that end on joint curves all but FREE."""
    shapely.prepare(grown)
    within = np.array(cells, dtype=object)
    within = within[shapely.contains(grown, shapely.point_on_surface(within))]
    least = HELD * np.minimum(shapely.area(within), wall.thickness**2)
    is_kept = shapely.area(shapely.intersection(within, held)) > least
    (doubtful,) = np.nonzero(~is_kept)
    is_kept[doubtful] = _free_shares(within[doubtful], curves, 20 * grid) < FREE
    return list(within[is_kept])


def _free_shares(cells: NDArray[np.object_], curves: shapely.Geometry, reach: float) -> Array:
    """(n,) which share of each cell's outline lies on none of the curves that parted the cells.

    The curves meet the outline in its corners only, or run along whole edges: the middle of an edge tells.
    """
    points, ring = shapely.get_coordinates(shapely.get_rings(cells), return_index=True)
    _, cell = shapely.get_rings(cells, return_index=True)
    is_edge = ring[1:] == ring[:-1]
    start, end = points[:-1][is_edge], points[1:][is_edge]
    length = np.linalg.norm(end - start, axis=1)
    is_free = shapely.distance(shapely.points(0.5 * (start + end)), curves) > reach
    owner = cell[ring[:-1][is_edge]]
    return np.asarray(np.bincount(owner, is_free * length, len(cells)) / np.bincount(owner, length, len(cells)))


def _bridges(topology: Topology, wall: Wall, crossing: Crossing) -> list[PolygonLike]:
    """What closes the slivers between the wall's own section and that of a curved wall on which it ends.

    Both are polylines there, whose chords differ where the wall ends between two points of the other's.
    """
    other, carrier = crossing.other(wall), topology.carrier(crossing.carrier)
    if isinstance(carrier, Line | TubeCurve):
        return []
    fringe = wall.own.buffer(CURVED_OVERLAP * min(wall.thickness, other.thickness), join_style="mitre")
    return [strip(topology, wall, crossing, *ends).intersection(fringe) for ends in crossing.reach[wall.index]]


def _without_dust(topology: Topology, wall: Wall, crossings: list[Crossing]) -> PolygonLike:
    """The wall's section less its islands within other walls' slabs: corner posts that this wall happened to win."""
    parts = parts_of(wall.own)
    if len(parts) < 2:
        return wall.own
    slabs = shapely.union_all([slab(topology, wall, crossing) for crossing in crossings])
    kept = [part for part in parts if part.difference(slabs).area > 0.2 * part.area]
    return shapely.union_all(kept) if kept else wall.own


def _without_pinholes(
    region: PolygonLike, slabs: Sequence[shapely.Geometry], lumps: Sequence[PolygonLike], least: float
) -> PolygonLike:
    """The region less its holes where two tubes merge, or which are smaller than `least` (an area) and beside a slab.

    Sections that end there at hardly any angle leave some, and so do slabs of walls that meet within this one.
    """
    holes = [Polygon(ring) for part in parts_of(region) for ring in part.interiors]
    pinholes = [hole for hole in holes if hole.area < least and any(slab.intersects(hole) for slab in slabs)]
    if lumps:
        about = shapely.union_all(lumps)
        pinholes += [hole for hole in holes if about.contains(hole)]
    return shapely.union_all([region, *pinholes]) if pinholes else region


class _Sections:
    """Sections of segments in sheets; walls in one plane, as those on both sides of a third, ask for the same ones."""

    def __init__(self, topology: Topology, walls: Sequence[Wall]) -> None:
        self._topology = topology
        self._walls = {wall.segment.id: wall for wall in walls}
        self._known: dict[tuple[str, int, bytes, bytes], tuple[PolygonLike, set[int]] | None] = {}

    def of(self, segment: Segment, sheet: Sheet) -> tuple[PolygonLike, set[int]] | None:
        """The section in the sheet's coordinates and the carriers of its outline; None where they do not meet."""
        if not isinstance(sheet, PlaneSheet):
            return self._made(segment, sheet)
        key = (segment.id, sheet.surface_id, sheet.u.tobytes(), sheet.v.tobytes())
        if key not in self._known:
            self._known[key] = self._made(segment, sheet)
        return self._known[key]

    def _made(self, segment: Segment, sheet: Sheet) -> tuple[PolygonLike, set[int]] | None:
        rings = self._rings(segment, sheet)
        if not rings:
            return None
        return domain(self._topology, sheet, rings), {stretch.carrier for ring in rings for stretch in ring}

    def _rings(self, segment: Segment, sheet: Sheet) -> list[list[Stretch]]:
        wall = self._walls.get(segment.id)
        if wall is not None and isinstance(wall.sheet, PlaneSheet) and wall.sheet.surface_id == sheet.surface_id:
            if isinstance(sheet, PlaneSheet) and np.array_equal(wall.sheet.normal, sheet.normal):
                return wall.rings  # its own mid-section: the two walls stand in one plane
        return section_outline(self._topology, segment.solid, sheet)


def _material(wall: Wall, nearby: list[Segment], sections: _Sections) -> list[PolygonLike]:
    """Sections of the segments around the wall in its sheet; their carriers become known to it."""
    found: list[PolygonLike] = []
    known = set(wall.known)
    for segment in nearby:
        section = sections.of(segment, wall.sheet)
        if section is not None:
            found.append(section[0])
            known |= section[1]
    wall.known = sorted(known)
    return found
