"""Layers through bricks: what size of tetrahedra they ask for, and levels through swept pieces."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from kernel.errors import OptionError
from kernel.idealise.brick import SweepGroup
from kernel.idealise.parts import Parts
from kernel.idealise.topology import Curve
from kernel.mesh.curve_items import WALLS, CurveItem, items_of, on_surfaces
from kernel.mesh.method import axis_text
from kernel.mesh.seeding import CurveWish, SeedRules
from kernel.mesh.sweep import LevelWish
from kernel.mesh.tets import MAX_TETS
from kernel.mesh.thinnest import thinnest_wall
from kernel.places import place_text
from kernel.segment.segments import Segment

Array = NDArray[np.float64]

SLIVER = 1e-7
"""Lengths that differ by less than this share are one."""

TETS_PER_VOLUME = 6.0 * math.sqrt(2.0)
"""Regular tetrahedra of edge 1 in a volume of 1."""


def layered_size(segment: Segment, size: float, layers: int, frame: Array) -> tuple[float, str | None]:
    """(the size, held down so that `layers` tetrahedra stand across the body's thinnest wall; what to tell, or None).

    frame: (3, 3), user's point = frame @ working point. OptionError: that would be more than MAX_TETS tetrahedra.
    """
    thickness, place = thinnest_wall(segment.solid)
    held = thickness / layers
    if held >= size:
        return size, None
    where = f"across its thinnest wall of {thickness:.4g} at {place_text(frame @ place)}"
    expected = TETS_PER_VOLUME * segment.volume / held**3
    if expected > MAX_TETS:
        enough = thickness / (TETS_PER_VOLUME * segment.volume / MAX_TETS) ** (1 / 3)
        raise OptionError(
            f"layers: {layers} in {segment.id} ({segment.node}) {where} take about {expected:.2g} tetrahedra, expected "
            f"at most {MAX_TETS:.2g}" + (f": {math.floor(enough)} layers" if enough >= 1 else "")
        )
    told = f"size {size:.6g} is held down to {held:.4g}: {layers} layers of tetrahedra {where}"
    return held, f"{segment.id} ({segment.node}): {told}"


def host_wishes(
    parts: Parts, curves: Sequence[Curve], sizes: Mapping[str, float], layers: int, reach: float
) -> dict[int, CurveWish]:
    """Sizes along the outlines that bricks have in the walls whose elements they continue, so that the layers fit.

    curves: of the walls' topology; the result is by their place. sizes: by segment id. reach: the model's size.
    """
    found: dict[int, CurveWish] = {}
    hosted = [(group.host[0], group) for group in parts.sweeps if group.host is not None]
    items = [item for item in items_of(parts, curves) if isinstance(item, CurveItem)] if hosted else []
    for wall, group in hosted:
        for brick in group.bricks:
            thickness, _ = thinnest_wall(brick.segment.solid, group.direction)
            size = SeedRules(layers=layers).per_gap * thickness
            if size >= sizes[wall.segment.id]:
                continue
            for k in on_surfaces(brick.segment.solid, items, reach):
                if items[k].topology == WALLS and wall.segment.id in items[k].segments:
                    for place in items[k].places:
                        known = found.get(place)
                        found[place] = CurveWish(size=size if known is None else min(size, known.size or size))
    return found


def coarser_wishes(
    parts: Parts, curves: Sequence[Curve], hosted: Mapping[int, CurveWish], asked: Mapping[int, CurveWish]
) -> list[str]:
    """Where what the user asks of a curve is coarser than the layers need, a line for each pair of walls.

    curves: of the walls' topology; hosted, asked: by their place, see host_wishes and choose_curves.
    """
    by_index = {wall.index: wall.segment for wall in parts.walls.values()}
    told: dict[str, str] = {}
    for place, wish in sorted(asked.items()):
        needed = hosted[place].size if place in hosted else None
        own = wish.size or curves[place].length / (wish.count or 1)
        if needed is None or own <= needed * (1 + SLIVER):
            continue
        curve = curves[place]
        carrier = parts.topology.carrier(curve.carrier)
        middle = parts.topology.place_text(carrier.at(np.array([0.5 * (curve.start + curve.end)]))[0])
        names = " and ".join(f"{by_index[face].id} ({by_index[face].node})" for face in sorted(curve.uses))
        told.setdefault(
            names,
            f"{names}: elements of {own:.4g} are asked for along the curve through {middle}, where the layers need "
            f"{needed:.4g}: the brick that stands on it may have fewer",
        )
    return list(told.values())


def fewer_levels(
    group: SweepGroup, levels: Array, wishes: Sequence[LevelWish], layers: int | None, frame: Array
) -> list[str]:
    """Where counts that the user asks for along a sweep leave fewer elements than he asks for elsewhere, a line each.

    levels: (n_level,) of the group. wishes: see level_wishes. frame: (3, 3), user's point = frame @ working point.
    """
    told = []
    slack = SLIVER * float(levels[-1] - levels[0])
    for wish in wishes:
        inside = (levels > wish.start - slack) & (levels < wish.end + slack)
        n = int(np.count_nonzero(inside)) - 1
        if wish.count is not None or n >= wish.least:
            continue
        beside = [
            brick.segment
            for brick in group.bricks
            if any(min(p.end, wish.end) - max(p.start, wish.start) > slack for p in brick.pieces)
        ]
        names = ", ".join(f"{segment.id} ({segment.node})" for segment in beside)
        what = "by the layers" if wish.least == layers else "by a size"
        axis = axis_text(frame @ group.direction)
        told.append(
            f"{names}: {n} elements of the {wish.least} asked for {what} stand along {axis}: the seeds of an edge "
            "that lies there are a count"
        )
    return list(dict.fromkeys(told))


def level_wishes(
    group: SweepGroup, rises: Mapping[tuple[float, float], CurveWish], layers: int | None
) -> list[LevelWish]:
    """What the user asks of the levels: by the edges along the sweep that he names, and by layers through a piece."""
    wishes = []
    for (start, end), wish in rises.items():
        if wish.count is not None:
            wishes.append(LevelWish(start, end, count=wish.count))
        elif wish.size is not None:
            wishes.append(LevelWish(start, end, least=math.ceil((end - start) / wish.size * (1 - 1e-9))))
    if layers is not None:
        pieces = [piece for brick in group.bricks for piece in brick.pieces]
        wishes += [LevelWish(piece.start, piece.end, least=layers) for piece in pieces]
    return wishes
