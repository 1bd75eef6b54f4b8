"""Curves as analysts name them: by a node, by two nodes that share them, or by a point beside one.

HOLE      a CSG node, by path or name: the curves that lie on its own surfaces, as the rims of a drilled hole do, and
          the axes of the beams that it becomes
s3        a segment: its outline, or its axis where it is a beam
A&B       two nodes or segments: the curves that both have, as the joint of two plates or the footprint of a leg
10,0,25   a point in the model's own coordinates: the curve nearest to it

A closed curve is one, an edge of a swept brick along its direction is one too. Where texts disagree about a curve the
narrower wins: a point over a pair, a pair over a segment, a segment over a node, a deep node over those above it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.csg.tree import CsgNode, walk
from kernel.errors import OptionError
from kernel.idealise.parts import Parts
from kernel.idealise.shares import shared_out
from kernel.idealise.topology import Curve
from kernel.mesh.curve_items import WALLS, AnyItem, CurveItem, StraightItem, items_of, on_surfaces
from kernel.mesh.curve_names import point_of
from kernel.mesh.options import MOST_COUNTED, MeshOptions
from kernel.mesh.seeding import CurveWish
from kernel.places import place_text
from kernel.segment.addresses import depth, is_under, node_of, segments_of
from kernel.solid.solid import Solid

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated

Array = NDArray[np.float64]
Rank = tuple[int, int]

FAR = 0.1
"""A point further from every curve than this share of the model's size names none."""

SAME = 1e-6
"""Distances that differ by less than this share of the model's size are equal."""

SHOWN = 4
"""Alternatives that a message names."""

LEAST_ROUND = 3
"""Fewest elements on a closed curve."""


@dataclass(frozen=True, slots=True, eq=False)
class ChosenCurves:
    """What is asked of curves. walls: by place in the walls' list of curves; sections: the same by group of bricks.

    beams: by segment id. rises: by group of bricks, for what a piece's start and end lie apart along the sweep.
    """

    walls: dict[int, CurveWish] = field(default_factory=dict)
    sections: dict[int, dict[int, CurveWish]] = field(default_factory=dict)
    beams: dict[str, CurveWish] = field(default_factory=dict)
    rises: dict[int, dict[tuple[float, float], CurveWish]] = field(default_factory=dict)


def choose_curves(options: MeshOptions, parts: Parts, curves: Sequence[Curve], evaluated: Evaluated) -> ChosenCurves:
    """What `curve_sizes` and `seeds` ask of the curves that they name. curves: of the walls' topology.

    OptionError: a text that names no curve, with the nearest that there are, or two that disagree.
    """
    if not options.curve_sizes and not options.seeds:
        return ChosenCurves()
    choice = _Choice(parts, curves, evaluated)
    found: dict[int, CurveWish] = {}
    for place, size in choice.resolve("curve size", options.curve_sizes, is_least=True).items():
        found[place] = CurveWish(size=size)
    for place, count in choice.resolve("seeds", options.seeds, is_least=False).items():
        found[place] = CurveWish(count=int(count))
    chosen = ChosenCurves()
    for place, wish in sorted(found.items()):
        item = choice.items[place]
        if isinstance(item, CurveItem):
            own = chosen.walls if item.topology == WALLS else chosen.sections.setdefault(item.topology, {})
            own.update(_shared(wish, item))
        elif item.kind == "axis":
            chosen.beams[item.name] = wish
        else:
            chosen.rises.setdefault(item.group, {})[item.span] = wish
    return chosen


def _shared(wish: CurveWish, item: CurveItem) -> dict[int, CurveWish]:
    """The wish for a curve as wishes for its pieces."""
    if wish.count is None:
        return dict.fromkeys(item.places, wish)
    counts = shared_out(item.lengths, wish.count).tolist()
    return {place: CurveWish(count=count) for place, count in zip(item.places, counts)}


class _Choice:
    """Reads texts against one model's items."""

    def __init__(self, parts: Parts, curves: Sequence[Curve], evaluated: Evaluated) -> None:
        self.items: list[AnyItem] = items_of(parts, curves)
        self._parts = parts
        self._evaluated = evaluated
        self._root = evaluated.model.root
        self._on: dict[int, list[int]] = {}

    def resolve(self, what: str, wanted: Mapping[str, float], *, is_least: bool) -> dict[int, float]:
        """The value for each item that some text names. is_least: of texts of one rank the least value holds."""
        best: dict[int, tuple[Rank, float, str]] = {}
        for text, value in wanted.items():
            rank, places = self._select(f"{what} of {text!r}", text)
            for place in places:
                self._check(f"{what} of {text!r}", self.items[place], value, is_count=not is_least)
                known = best.get(place)
                if known is not None and known[0] == rank and known[1] != value and not is_least:
                    raise OptionError(
                        f"{what} of {known[2]!r} and of {text!r} are both of the curve through "
                        f"{self._at(self.items[place])}, expected one of {known[1]:g} and {value:g}"
                    )
                if known is None or rank > known[0] or (rank == known[0] and value < known[1]):
                    best[place] = (rank, value, text)
        return {place: value for place, (_, value, _) in best.items()}

    def _select(self, what: str, text: str) -> tuple[Rank, list[int]]:
        point = point_of(text, what)
        if point is not None:
            return (3, 0), self._nearest(what, point)
        names = [name.strip() for name in text.split("&")]
        if len(names) > 2 or not all(names):
            raise OptionError(f"{what}: expected a node, two as A&B, or a point x,y,z")
        if len(names) == 2:
            sets = [set(self._had_by(what, name)) for name in names]
            if not sets[0] & sets[1]:
                raise OptionError(f"{what}: they share no curve{self._sharing(what, names)}")
            return (2, sum(self._depth(what, name) for name in names)), sorted(sets[0] & sets[1])
        (name,) = names
        places = self._outline(name) if name in self._parts.segments else self._on_node(what, name)
        if not places:
            raise OptionError(f"{what}: {self._why_none(what, name)}")
        return ((1, 0) if name in self._parts.segments else (0, self._depth(what, name))), places

    def _check(self, what: str, item: AnyItem, value: float, *, is_count: bool) -> None:
        if item.kind == "axis" and isinstance(item, StraightItem) and self._parts.seats.get(item.name):
            others = " or ".join(f"{item.name}&{seat.wall.segment.id}" for seat in self._parts.seats[item.name])
            raise OptionError(
                f"{what}: {self._called(item.name)} lies along a wall, whose nodes it follows; expected {others}"
            )
        if not is_count and item.length / value > MOST_COUNTED:
            raise OptionError(
                f"{what} is {value:.4g}, but the curve through {self._at(item)} is {item.length:.4g} long: expected "
                f"{item.length / MOST_COUNTED:.2g} or more"
            )
        if is_count and isinstance(item, CurveItem):
            least = LEAST_ROUND if item.is_closed else len(item.places)
            if value < least:
                how = "is closed" if item.is_closed else f"is in {least} pieces"
                raise OptionError(
                    f"{what} is {value:g}, but the curve through {self._at(item)} {how}: expected at least {least}"
                )

    # ---- by node or segment

    def _outline(self, segment: str) -> list[int]:
        return [k for k, item in enumerate(self.items) if segment in item.outline_of]

    def _on_node(self, what: str, name: str) -> list[int]:
        """The axes of the node's beams, and the curves on the surfaces of its primitives that are part of no beam."""
        path, own = self._of_node(what, name)
        found = {k for k, item in enumerate(self.items) if item.kind == "axis" and not own.isdisjoint(item.segments)}
        for leaf_path, leaf in walk(self._root):
            if not leaf.operands and is_under(leaf_path, path) and not self._is_beams(leaf_path):
                found.update(self._on_leaf(leaf))
        return sorted(found)

    def _of_node(self, what: str, name: str) -> tuple[str, set[str]]:
        """A node's path and segments."""
        segments = list(self._parts.segments.values())
        path, node = node_of(name, self._root, what, [segment.id for segment in segments])
        return path, set(segments_of(path, node, self._evaluated, segments))

    def _is_beams(self, path: str) -> bool:
        """Whether all segments that a primitive takes part in are beams."""
        types = {s.type for s in self._parts.segments.values() if is_under(path, s.node) or is_under(s.node, path)}
        return types == {"beam"}

    def _on_leaf(self, leaf: CsgNode) -> list[int]:
        if id(leaf) not in self._on:
            self._on[id(leaf)] = self._on_solid(self._evaluated.solid_of(leaf))
        return self._on[id(leaf)]

    def _on_solid(self, solid: Solid) -> list[int]:
        return on_surfaces(solid, self.items, self._evaluated.size)

    def _had_by(self, what: str, name: str) -> list[int]:
        """The curves of a segment's or node's faces, and those on its surfaces."""
        found: set[int] = set()
        if name in self._parts.segments:
            own = {name}
            found.update(self._on_solid(self._parts.segments[name].solid))
        else:
            path, own = self._of_node(what, name)
            for leaf_path, leaf in walk(self._root):
                if not leaf.operands and is_under(leaf_path, path):
                    found.update(self._on_leaf(leaf))
        found.update(k for k, item in enumerate(self.items) if not own.isdisjoint(item.segments))
        return [k for k in sorted(found) if self.items[k].kind == "curve"]

    def _depth(self, what: str, name: str) -> int:
        return 0 if name in self._parts.segments else depth(node_of(name, self._root, what)[0])

    # ---- by point

    def _nearest(self, what: str, point: Array) -> list[int]:
        """The nearest item; all of them where several lie in the same place."""
        size = self._evaluated.size
        there = point @ self._evaluated.frame
        away = np.array([item.distance(there) for item in self.items])
        if not len(away):
            raise OptionError(f"{what}: only bricks that are not swept are here, which have no curves to name")
        least = float(away.min())
        if least > FAR * size:
            first = self.items[int(away.argmin())]
            raise OptionError(
                f"{what}: the nearest curve, through {self._at(first)}, is {least:.4g} away, expected a point within "
                f"{FAR * size:.4g} of one"
            )
        near = np.flatnonzero(away <= least + SAME * size).tolist()
        first = self.items[near[0]]
        others = [k for k in near[1:] if np.linalg.norm(self.items[k].middle - first.middle) > SAME * size]
        if others:
            raise OptionError(
                f"{what}: as near to the curve through {self._at(first)} as to the one through "
                f"{self._at(self.items[others[0]])}, expected a point amid one"
            )
        return near

    # ---- messages

    def _at(self, item: AnyItem) -> str:
        place = place_text(self._evaluated.frame @ item.middle)
        return f"{place} of {' and '.join(sorted(item.segments, key=_number))}"

    def _called(self, segment: str) -> str:
        return f"{segment} ({self._parts.segments[segment].node})"

    def _why_none(self, what: str, name: str) -> str:
        if name in self._parts.segments:
            return f"{name} has no curves; {self._tetrahedral([name])}"
        path, node = node_of(name, self._root, what)
        touched = [s.id for s in self._parts.segments.values() if is_under(path, s.node) or is_under(s.node, path)]
        here = _middle(self._evaluated.solid_of(node))
        near = []
        for other, leaf in walk(self._root):
            if not leaf.operands and not self._is_beams(other) and self._on_leaf(leaf):
                away = float(np.linalg.norm(_middle(self._evaluated.solid_of(leaf)) - here))
                near.append((away, leaf.name or other))
        names = ", ".join(name for _, name in sorted(near)[:SHOWN])
        expected = f", expected a node such as {names}" if near else ""
        return f"no curve of the mesh lies on the surfaces of node {path}{expected}; {self._tetrahedral(touched)}"

    def _tetrahedral(self, names: Sequence[str]) -> str:
        with_curves = {name for item in self.items for name in item.segments}
        without = [self._called(name) for name in names if name not in with_curves]
        beams = [self._called(name) for name in names if name in self._parts.beams]
        if without:
            return f"{', '.join(without[:SHOWN])}: a brick that is not swept has no curves to name, only a size"
        return f"{', '.join(beams[:SHOWN])}: a beam has its axis only" if beams else "a point x,y,z names any curve"

    def _sharing(self, what: str, names: Sequence[str]) -> str:
        """Which segments share curves with the first of two, or with the second."""
        for name in names:
            others = {other for k in self._had_by(what, name) for other in self.items[k].segments} - {name}
            if others:
                listed = ", ".join(self._called(other) for other in sorted(others, key=_number)[:SHOWN])
                return f"; expected {name} with one of {listed}"
        return ""


def _number(segment: str) -> int:
    return int(segment[1:])


def _middle(solid: Solid) -> Array:
    middle: Array = solid.bounds.mean(axis=0)
    return middle
