"""Clusters: pieces of a split that may be one member, found by what they share; the rules say whether they are.

profile   touching pieces swept along one direction over one interval (an I of three blocks beside a column)
chain     pieces end to end on one line with one section, where nothing else meets the joint
sheet     plates between the same two planes that touch
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import shapely
from shapely import STRtree

from kernel.segment.prism import Sweep, sweep_along, sweeps
from kernel.segment.shapes import Draft
from kernel.segment.walls import PlaneWall
from kernel.solid.solid import Solid, unite

Span = tuple[int, ...]


@dataclass(frozen=True, slots=True, eq=False)
class Cluster:
    """Drafts (by index) that may be one; solid: their union."""

    kind: str
    members: tuple[int, ...]
    solid: Solid


class Touching:
    """Which drafts' boxes touch, by an index over all of them."""

    def __init__(self, drafts: Sequence[Draft]) -> None:
        self._boxes = np.array([draft.solid.bounds for draft in drafts]).reshape(-1, 2, 3)
        self._slack = 10.0 * drafts[0].solid.surfaces.tolerance if drafts else 0.0
        low, high = self._boxes[:, 0] - self._slack, self._boxes[:, 1] + self._slack
        self._tree = STRtree(shapely.box(low[:, 0], low[:, 1], high[:, 0], high[:, 1]))

    def of(self, low: np.ndarray, high: np.ndarray) -> list[int]:
        """Drafts whose boxes meet the box low..high, in order."""
        near = np.sort(self._tree.query(shapely.box(low[0], low[1], high[0], high[1])))
        return [
            int(index)
            for index in near
            if self._boxes[index, 0, 2] <= high[2] + self._slack and self._boxes[index, 1, 2] >= low[2] - self._slack
        ]


def find_clusters(drafts: Sequence[Draft]) -> Iterator[Cluster]:
    """Every group worth asking about: sheets, then profiles, then chains; a draft may stand in several."""
    if len(drafts) < 2:
        return
    touching = Touching(drafts)
    yield from _sheets(drafts, touching)
    yield from _profiles(drafts, touching)
    yield from _chains(drafts, touching)


def _connected(members: Sequence[int], drafts: Sequence[Draft], touching: Touching) -> list[tuple[int, ...]]:
    """The members in groups that touch by their boxes, single ones left out."""
    pending, groups = set(members), []
    for first in members:
        if first not in pending:
            continue
        pending.discard(first)
        group, frontier = [first], [first]
        while frontier:
            bounds = drafts[frontier.pop()].solid.bounds
            for other in touching.of(bounds[0], bounds[1]):
                if other in pending:
                    pending.discard(other)
                    group.append(other)
                    frontier.append(other)
        if len(group) > 1:
            groups.append(tuple(sorted(group)))
    return groups


def _united(kind: str, group: tuple[int, ...], drafts: Sequence[Draft]) -> Iterator[Cluster]:
    """The group as one solid; where boxes touched and solids do not, as several."""
    whole = unite([drafts[index].solid for index in group])
    parts = whole.components()
    if len(parts) == 1:
        yield Cluster(kind, group, whole)
        return
    for part in parts:
        slack = 10.0 * part.surfaces.tolerance
        members = tuple(
            index
            for index in group
            if np.all(drafts[index].solid.bounds[0] >= part.bounds[0] - slack)
            and np.all(drafts[index].solid.bounds[1] <= part.bounds[1] + slack)
        )
        volume = sum(drafts[index].solid.volume for index in members)
        if len(members) > 1 and abs(volume - part.volume) < 1e-6 * part.volume:
            yield Cluster(kind, members, part)


def _sheets(drafts: Sequence[Draft], touching: Touching) -> Iterator[Cluster]:
    by_faces: dict[tuple[int, int], list[int]] = {}
    for index, draft in enumerate(drafts):
        if isinstance(draft.wall, PlaneWall) and draft.type == "plate" and not draft.is_pinned:
            by_faces.setdefault(draft.wall.surface_ids, []).append(index)
    for faces in sorted(by_faces):
        for group in _connected(by_faces[faces], drafts, touching):
            yield from _united("sheet", group, drafts)


def _profiles(drafts: Sequence[Draft], touching: Touching) -> Iterator[Cluster]:
    by_span: dict[Span, list[int]] = {}
    for index, draft in enumerate(drafts):
        if draft.type == "brick" or draft.is_pinned:
            continue
        for sweep in _long_sweeps(draft):
            by_span.setdefault(_span(sweep, draft.solid), []).append(index)
    for span in sorted(by_span, key=lambda span: (-len(by_span[span]), span)):
        if len(by_span[span]) > 1:
            for group in _connected(by_span[span], drafts, touching):
                yield from _united("profile", group, drafts)


def _long_sweeps(draft: Draft) -> list[Sweep]:
    """Directions along which the draft is exactly swept, and longer than it is wide: parts of a profile are."""
    if draft.prism is None:
        found = sweeps(draft.solid)
    elif draft.solid is draft.whole:
        found = (draft.prism.sweep,)
    else:
        found = (sweep_along(draft.solid, draft.prism.sweep.direction),)
    return [sweep for sweep in found if sweep.is_exact and sweep.slenderness >= 1.0]


def _span(sweep: Sweep, solid: Solid) -> Span:
    """Direction and interval, on a grid of ten tolerances."""
    grid = 10.0 * solid.surfaces.tolerance
    direction = np.round(sweep.direction * 1e5).astype(int)
    return (*map(int, direction), round(sweep.start / grid), round(sweep.end / grid))


def _chains(drafts: Sequence[Draft], touching: Touching) -> Iterator[Cluster]:
    """Beams whose sections are one and whose ends meet, with no third draft at the joint."""
    beams = [index for index, draft in enumerate(drafts) if draft.type == "beam" and not draft.is_pinned]
    links: dict[int, list[int]] = {index: [] for index in beams}
    for index in beams:
        for other in _next_on_line(index, drafts, touching):
            links[index].append(other)
            links[other].append(index)
    pending = set(beams)
    for index in beams:
        if index not in pending or not links[index]:
            continue
        pending.discard(index)
        chain, frontier = [index], [index]
        while frontier:
            for other in links[frontier.pop()]:
                if other in pending:
                    pending.discard(other)
                    chain.append(other)
                    frontier.append(other)
        yield from _united("chain", tuple(sorted(chain)), drafts)


def _next_on_line(index: int, drafts: Sequence[Draft], touching: Touching) -> list[int]:
    """Beams that go on where this one ends (along its direction), alone at the joint."""
    draft = drafts[index]
    assert draft.prism is not None
    direction = draft.prism.sweep.direction
    slack = 10.0 * draft.solid.surfaces.tolerance
    vertices = draft.solid.facets.vertices
    along = vertices @ direction
    at_end = vertices[along > along.max() - slack]
    meeting = [other for other in touching.of(at_end.min(axis=0), at_end.max(axis=0)) if other != index]
    if len(meeting) != 1:
        return []
    other = drafts[meeting[0]]
    if other.type != "beam" or other.is_pinned or other.prism is None:
        return []
    if np.abs(other.prism.sweep.direction - direction).max() > 1e-5:
        return []
    if abs(float((other.solid.facets.vertices @ direction).min()) - float(along.max())) > slack:
        return []
    difference = other.prism.section.symmetric_difference(draft.prism.section).area
    return meeting if difference < 1e-5 * draft.prism.area else []
