"""Ownership: where drafts overlap, the overlap belongs to one of them.

To the brick, then the plate or cylinder-plate, then the beam; among equals to the larger section, then the larger
volume, then the thinner wall, then by place. But a brick that ends within a wall's thickness, as what stands on a plate
and is let into it a little, leaves the wall whole: a wall with a pocket has no mid-surface there, a shorter brick is a
brick. Drafts were decided on their untrimmed solids and keep their full length; a beam that loses a side over most of
its length, as a flange that laps the wall it is welded to, keeps the section that is left of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import shapely
from shapely import STRtree

from kernel.segment.prism import SECTION_COUNT, SECTION_OFF, measure, sweep_along
from kernel.segment.remains import is_skin
from kernel.segment.shapes import Draft
from kernel.segment.slabs import most_shared
from kernel.segment.walls import PlaneWall, TubeWall, Vector
from kernel.solid.fins import without_fins
from kernel.solid.lathe import SAGITTA
from kernel.solid.solid import Solid, intersect, subtract, unite
from kernel.units import VOLUME_TOLERANCE

RANK = {"brick": 0, "plate": 1, "cylinder_plate": 1, "beam": 2}
"""Lower ranks own overlaps."""

GONE = 1e-7
"""A draft left with less than this share of its volume lies within the others."""

SLIVER = 1e-6
"""A piece of a trimmed draft smaller than this share of it goes to the owner that it touches."""

MISSED = 0.5 * VOLUME_TOLERANCE
"""Share of their volume that drafts may gain or lose when they are made disjoint."""

UNTOUCHED = 1e-9
"""A draft that loses less than this share of its volume is not overlapped."""


THROUGH = 1e-3
"""An overlap nearer than this many thicknesses to a wall's face reaches that face."""


def settle_overlaps(drafts: Sequence[Draft], volume: float | None = None) -> list[Draft]:
    """The drafts made disjoint, in the order of their rank; together they fill what they filled before.

    volume: of all of them together, where it is known. A Boolean of several bodies whose faces nearly coincide may
    leave some of it behind; what is then not of that volume is cut again, by one owner after the other.
    """
    drafts = list(drafts)
    settled = _settled(drafts, at_once=True)
    if volume is not None and _misses(settled, volume):
        again = _settled(drafts, at_once=False)
        return settled if _misses(again, volume) else again
    return settled


def _misses(drafts: Sequence[Draft], volume: float) -> bool:
    return abs(sum(draft.solid.volume for draft in drafts) - volume) > MISSED * volume


def _settled(drafts: list[Draft], at_once: bool) -> list[Draft]:
    ranked = sorted(_on_walls(drafts.copy()), key=_rank)
    losses = _overlapped(ranked)
    kept: list[Draft] = []
    place: dict[int, list[int]] = {}
    slivers: list[tuple[Solid, int]] = []
    for index, draft in enumerate(ranked):
        pieces = [draft]
        if losses[index]:
            pieces, crumbs = _trimmed(draft, [ranked[owner] for owner in losses[index]], at_once)
            slivers += [(crumb, index) for crumb in crumbs]
        place[index] = list(range(len(kept), len(kept) + len(pieces)))
        kept += pieces
    for crumb, index in slivers:
        near = [position for owner in (*losses[index], index) for position in place[owner]]
        host = most_shared([kept[position].solid for position in near], crumb)
        if host is not None:
            kept[near[host]] = replace(kept[near[host]], solid=unite([kept[near[host]].solid, crumb]))
    return kept


def _rank(draft: Draft) -> tuple[float, ...]:
    size = draft.solid.surfaces.size
    volume = round(draft.solid.volume / size**3, 9)
    thickness = 0.0 if draft.wall is None else round(draft.wall.thickness / size, 9)
    corners = np.round(draft.solid.bounds / size, 6).ravel() + 0.0
    return (RANK[draft.type], -round(draft.section_area / size**2, 9), -volume, thickness, *map(float, corners))


def _on_walls(drafts: list[Draft]) -> list[Draft]:
    """Bricks that end within the thickness of a wall, each cut back to the wall's face; the others as they were."""
    for loser, owners in enumerate(_overlapped(drafts, both_ways=True)):
        draft = drafts[loser]
        if draft.type != "brick":
            continue
        walls = [drafts[owner] for owner in owners if _ends_within(draft, drafts[owner])]
        if not walls:
            continue
        rest = without_fins(subtract(draft.solid, [wall.solid for wall in walls]))
        if len(rest.components()) == 1:
            drafts[loser] = replace(draft, solid=rest)
    return drafts


def _ends_within(brick: Draft, draft: Draft) -> bool:
    """Whether what a brick and a wall share reaches one of the wall's two faces, and the brick goes on from there."""
    wall = draft.wall
    if wall is None:
        return False
    shared = intersect([brick.solid, draft.solid])
    if shared.is_empty or shared.volume < UNTOUCHED * brick.solid.volume:
        return False
    if isinstance(wall, PlaneWall):
        bottom, top = wall.bottom, wall.top
        depth, whole = (solid.facets.vertices @ wall.normal for solid in (shared, brick.solid))
    else:
        bottom, top = wall.inner_radius, wall.outer_radius
        depth, whole = (_radii(solid, wall) for solid in (shared, brick.solid))
    near = THROUGH * wall.thickness + (SAGITTA * wall.outer_radius if isinstance(wall, TubeWall) else 0.0)
    reaches_bottom, reaches_top = bool(depth.min() < bottom + near), bool(depth.max() > top - near)
    goes_on = bool(whole.min() < bottom - near) if reaches_bottom else bool(whole.max() > top + near)
    return reaches_bottom != reaches_top and goes_on


def _radii(solid: Solid, wall: TubeWall) -> Vector:
    arm = solid.facets.vertices - wall.axis.point
    return np.hypot(arm @ wall.axis.x, arm @ wall.axis.y)


def _overlapped(ranked: Sequence[Draft], both_ways: bool = False) -> list[list[int]]:
    """For each draft, the earlier ones (or all, both ways) whose boxes overlap its own."""
    losses: list[list[int]] = [[] for _ in ranked]
    if len(ranked) < 2:
        return losses
    boxes = np.array([draft.solid.bounds for draft in ranked])
    slack = ranked[0].solid.surfaces.tolerance
    flat = shapely.box(boxes[:, 0, 0], boxes[:, 0, 1], boxes[:, 1, 0], boxes[:, 1, 1])
    first, second = STRtree(flat).query(flat)
    depth = np.minimum(boxes[first, 1], boxes[second, 1]) - np.maximum(boxes[first, 0], boxes[second, 0])
    overlap = (depth > slack).all(axis=1) & ((second != first) if both_ways else (second < first))
    for loser, owner in zip(first[overlap], second[overlap]):
        losses[int(loser)].append(int(owner))
    return [sorted(owners) for owners in losses]


def _trimmed(draft: Draft, owners: list[Draft], at_once: bool) -> tuple[list[Draft], list[Solid]]:
    """What the owners leave of a draft, and the slivers and skins that are too small to stand alone."""
    cutters = [owner.solid for owner in owners]
    rest = draft.solid
    for group in [cutters] if at_once else [[cutter] for cutter in cutters]:
        rest = subtract(rest, group)
    volume = draft.solid.volume
    if rest.is_empty or rest.volume < GONE * volume:
        return [], []
    if rest.volume > (1.0 - UNTOUCHED) * volume:
        return [draft], []
    components = [without_fins(piece) for piece in rest.components()]
    slivers = [piece for piece in components if piece.volume <= SLIVER * volume or is_skin(draft, piece)]
    pieces = [piece for piece in components if piece not in slivers]
    if len(pieces) > 1 and isinstance(draft.wall, PlaneWall) and all(owner.wall is not None for owner in owners):
        return [replace(draft, solid=unite(pieces))], slivers  # walls that cross: each stays one
    if draft.type != "beam":
        return [replace(draft, solid=piece) for piece in pieces], slivers
    cut = [replace(draft, solid=pieces[0])] if len(pieces) == 1 else _cut_beam(draft, pieces)
    return [_measured_anew(beam) for beam in cut], slivers


def _measured_anew(draft: Draft) -> Draft:
    """A trimmed beam with the section that it has over most of its length, where that is no longer the old one."""
    assert draft.prism is not None
    old = draft.prism
    along = draft.solid.facets.vertices @ old.sweep.direction
    if abs(draft.solid.volume / (old.area * float(np.ptp(along))) - 1.0) <= SECTION_OFF:
        return draft
    left = measure(draft.solid, sweep_along(draft.solid, old.sweep.direction))
    if left is None or left.sections_off > SECTION_COUNT // 2 or abs(left.area - old.area) <= SECTION_OFF * old.area:
        return draft
    reach = draft.reach or (old.sweep.start, old.sweep.end)
    return replace(draft, prism=left, whole=draft.solid, reach=reach)


def _cut_beam(draft: Draft, pieces: list[Solid]) -> list[Draft]:
    """A beam in several pieces: only the outermost keep its full ends."""
    assert draft.prism is not None
    direction = draft.prism.sweep.direction
    spans = [(float((at := piece.facets.vertices @ direction).min()), float(at.max())) for piece in pieces]
    full_start, full_end = draft.reach or (draft.prism.sweep.start, draft.prism.sweep.end)
    first, last = min(start for start, _ in spans), max(end for _, end in spans)
    slack = draft.solid.surfaces.tolerance
    return [
        replace(
            draft,
            solid=piece,
            reach=(full_start if start < first + slack else start, full_end if end > last - slack else end),
        )
        for piece, (start, end) in zip(pieces, spans)
    ]
