"""Curves divided, each once: by the sizes of the faces that use it, by gaps in them, and by what the user asks.

size of the faces, or the one asked for a curve      a count asked for a curve
-> finer beside narrow gaps of any face              -> that many even parts, whatever else holds
-> growing gently along curves, from curve to curve and from face to face
-> divided in an even number, enough to show the curve's bend
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kernel.errors import OptionError
from kernel.idealise.carriers import is_curved
from kernel.idealise.outlines import unwrapped
from kernel.idealise.sheets import Sheet
from kernel.idealise.topology import BOUNDARY, Curve, Topology
from kernel.mesh.arms import HungCurve
from kernel.mesh.faces import SeededCurve
from kernel.mesh.gaps import GROWTH, LEAST, PER_GAP, SAMPLES_PER_SIZE, SampledCurve, divide, gap_sizes
from kernel.mesh.line import least_divisions
from kernel.mesh.nodes import NodeTable
from kernel.mesh.size_field import MOST_ASKED

Array = NDArray[np.float64]

STRIP = 0.5
"""A line that is beside a narrow strip for most of its length is divided by this share of the size: quads in strips
may be long, and nothing is gained by making them square.
"""

MOST_SAMPLES = 4000
"""Places along one curve at which gaps are measured."""

SETTLED = 0.01
"""Sizes that change by less than this share from pass to pass have settled."""

LAYERED = 0.75
"""Elements beside a wall are this much shorter than would just give the layers, for sizes grow towards its middle. At
.9 one of 24 box sections had too few somewhere, at .7 none."""

MOST_PASSES = 20
"""Passes in which sizes spread from face to face."""

LEAST_CELL = 1 / 30
"""Sizes are spread between curves in cells no smaller than this share of the largest size."""


@dataclass(frozen=True, slots=True)
class CurveWish:
    """What is asked of one curve: exactly `count` elements, or none longer than `size`."""

    count: int | None = None
    size: float | None = None


@dataclass(frozen=True, slots=True)
class SeedRules:
    """How curves are divided. wishes: by the curve's place in the list of curves. growth: of the size per unit of
    length, None for what gaps alone have. per_circle: fewest elements round a full circle, None for the usual.
    layers: fewest elements across a gap, None for the usual. fewest: elements by the curve's place, where more are
    needed than the usual.
    """

    wishes: Mapping[int, CurveWish] = field(default_factory=dict)
    growth: float | None = None
    per_circle: int | None = None
    layers: int | None = None
    fewest: Mapping[int, int] = field(default_factory=dict)

    @property
    def spreads(self) -> bool:
        """Whether sizes grow from whatever is small, not from narrow gaps alone."""
        return bool(self.wishes) or self.growth is not None or self.per_circle is not None or self.layers is not None

    @property
    def rate(self) -> float:
        """Growth of the size per unit of length."""
        rate = GROWTH if self.growth is None else self.growth
        return rate if self.layers is None else min(rate, 1 / self.layers)

    @property
    def per_gap(self) -> float:
        """Largest share of a gap that an element beside it may have: quads come in pairs across it."""
        if self.layers is None:
            return PER_GAP
        return min(PER_GAP, LAYERED / (2 * math.ceil(self.layers / 2)))

    @property
    def least(self) -> float:
        """Smallest share of the size asked for that a gap may ask for."""
        return LEAST if self.layers is None else LEAST / self.layers


def growth_rate(ratio: float) -> float:
    """Growth of the size per unit of length, where each element is `ratio` times as long as the one before."""
    return math.log(ratio)


def seed_curves(
    topology: Topology,
    curves: Sequence[Curve],
    sheets: Mapping[int, Sheet],
    sizes: Mapping[int, float],
    nodes: NodeTable,
    hung: Sequence[HungCurve] = (),
    rules: SeedRules | None = None,
) -> list[SeededCurve]:
    """Divide every curve once: by the smallest size of the faces that use it, finer beside narrow gaps in any of them.

    sheets, sizes: by face. hung: curves that are divided as those are from which they hang. rules: what the user asks
    beyond that; what he asks of a hung curve holds for the one that it hangs from.
    """
    rules = rules or SeedRules()
    wishes = _wishes_hung(topology, curves, rules.wishes, hung)
    edges = {one.edge: one for one in hung}
    numbers: dict[int, int] = {}
    for curve in curves:
        for vertex in curve.vertices:
            if vertex not in numbers:
                numbers[vertex] = int(nodes.add(topology.vertices.points[vertex])[0])
    wanted = [min(sizes[face] for face in curve.uses) for curve in curves]
    least = [
        max(
            least_divisions(topology.carrier(curve.carrier), curve.length, size, rules.per_circle),
            rules.fewest.get(place, 0),
        )
        for place, (curve, size) in enumerate(zip(curves, wanted))
    ]
    for one in hung:
        wanted[one.along] = min(wanted[one.along], wanted[one.edge])
    for place, wish in wishes.items():
        wanted[place] = wish.size or curves[place].length / (wish.count or 1)
    graded = _graded_sizes(topology, curves, sheets, wanted, least, rules)
    for one in hung:
        one.grade(graded)
    seeded: dict[int, SeededCurve] = {}
    for place, (curve, along_curve) in enumerate(zip(curves, graded)):
        if place in edges:
            continue
        carrier = topology.carrier(curve.carrier)
        own = wishes.get(place, CurveWish())
        if own.count is not None:
            inner = curve.start + curve.length * (np.arange(1, own.count) / own.count)
        else:
            samples = np.linspace(0.0, curve.length, len(along_curve))
            is_bound = own.size is not None or rules.layers is not None
            inner = curve.start + divide(samples, along_curve, least[place], is_even=True, is_bound=is_bound)
        parameters = np.concatenate([[curve.start], inner, [curve.end]])
        first, last = (numbers[vertex] for vertex in curve.vertices)
        between = nodes.add(carrier.at(inner))
        chain = np.concatenate([[first], between, [last]])
        seeded[place] = SeededCurve(curve, chain, parameters, is_curved(carrier))
    for place, one in edges.items():
        curve, along = curves[place], seeded[one.along]
        parameters, points = one.divided(topology, curve, along.curve, along.parameters)
        first, last = (numbers[vertex] for vertex in curve.vertices)
        chain = np.concatenate([[first], nodes.add(points), [last]])
        seeded[place] = SeededCurve(curve, chain, parameters, is_curved(topology.carrier(curve.carrier)))
    return [seeded[place] for place in range(len(curves))]


def refuse_too_fine(curves: Sequence[SeededCurve], growth: float | None) -> None:
    """OptionError where the faces could not be filled: from n edges elements grow at a rate g to about n / g in all."""
    n_edge = sum((len(seeded.nodes) - 1) * len(seeded.curve.uses) for seeded in curves)
    expected = n_edge / (GROWTH if growth is None else growth)
    if expected > MOST_ASKED:
        raise OptionError(
            f"the curves' {n_edge} edges would give about {expected:.2g} elements, expected at most {MOST_ASKED:.2g}: "
            "fewer seeds, larger curve sizes, or more growth"
        )


def _wishes_hung(
    topology: Topology, curves: Sequence[Curve], wishes: Mapping[int, CurveWish], hung: Sequence[HungCurve]
) -> dict[int, CurveWish]:
    """The wishes, those for hung curves moved to what they hang from: a count before a size, the lesser of two sizes.

    OptionError: a hung curve and the one from which it hangs are to have different numbers of elements.
    """
    found = dict(wishes)
    for one in hung:
        wish, known = found.pop(one.edge, None), found.get(one.along)
        if wish is None:
            continue
        if known is None or (known.count is None and wish.count is not None):
            found[one.along] = wish
        elif known.count is None and wish.size is not None and known.size is not None:
            found[one.along] = CurveWish(size=min(wish.size, known.size))
        elif wish.count is not None and wish.count != known.count:
            curve = curves[one.along]
            middle = topology.carrier(curve.carrier).at(np.array([0.5 * (curve.start + curve.end)]))[0]
            names = f"{one.arm.web.segment.id} and {one.arm.flanges[0].segment.id}"
            raise OptionError(
                f"seeds of the tee of {names} near {topology.place_text(middle)}: {wish.count} on the edge that hangs "
                f"by rigid arms and {known.count} on the curve that carries it, expected one number"
            )
    return found


def _graded_sizes(
    topology: Topology,
    curves: Sequence[Curve],
    sheets: Mapping[int, Sheet],
    wanted: Sequence[float],
    least: Sequence[int],
    rules: SeedRules,
) -> list[Array]:
    """Sizes along each curve, at samples evenly spaced from its start to its end: the least of what its faces ask."""
    by_face: dict[int, list[int]] = {}
    for place, curve in enumerate(curves):
        for face in curve.uses:
            by_face.setdefault(face, []).append(place)
    points = []
    for curve, size in zip(curves, wanted):
        count = int(min(max(np.ceil(SAMPLES_PER_SIZE * curve.length / size), 2 * SAMPLES_PER_SIZE), MOST_SAMPLES))
        points.append(topology.carrier(curve.carrier).at(np.linspace(curve.start, curve.end, count + 1)))
    sizes = [np.full(len(samples), float(size)) for samples, size in zip(points, wanted)]
    flats: dict[int, list[Array]] = {}
    for face in sorted(by_face):
        sheet = sheets[face]
        sampled = []
        for place in by_face[face]:
            curve = curves[place]
            use = curve.uses[face]
            flat = unwrapped(sheet, points[place] if use.forward else points[place][::-1])
            first, last = curve.vertices if use.forward else curve.vertices[::-1]
            sampled.append(SampledCurve(flat, first, last, use.role == BOUNDARY, wanted[place]))
            flats.setdefault(face, []).append(flat if use.forward else flat[::-1])
        found_sizes = gap_sizes(sampled, sheet.turn, rules.rate, rules.per_gap, rules.least)
        for place, found in zip(by_face[face], found_sizes):
            ordered = found if curves[place].uses[face].forward else found[::-1]
            is_line = not is_curved(topology.carrier(curves[place].carrier))
            strip = STRIP * wanted[place]
            if is_line and rules.layers is None and found.min() < strip and np.median(found) < strip:
                ordered = np.maximum(ordered, strip)
            np.minimum(sizes[place], ordered, out=sizes[place])
    if rules.spreads and curves:
        for place, curve in enumerate(curves):
            if is_curved(topology.carrier(curve.carrier)):
                np.minimum(sizes[place], curve.length / least[place], out=sizes[place])
        _spread(curves, by_face, flats, sizes, rules.rate)
    return sizes


def _spread(
    curves: Sequence[Curve],
    by_face: Mapping[int, Sequence[int]],
    flats: Mapping[int, Sequence[Array]],
    sizes: list[Array],
    rate: float,
) -> None:
    """Limit the growth of sizes along all curves, across the vertices that they share and within each face; in place.

    flats: by face, the samples of its curves in its sheet.
    """
    from kernel.numeric.gaps import grade_across, grade_along

    counts = np.array([len(own) for own in sizes])
    starts = np.concatenate([[0], np.cumsum(counts)])
    curve_of = np.repeat(np.arange(len(curves), dtype=np.int32), counts)
    along = np.concatenate([np.linspace(0.0, curve.length, count) for curve, count in zip(curves, counts)])
    names = {vertex: i for i, vertex in enumerate(sorted({v for curve in curves for v in curve.vertices}))}
    first, last = (np.array([names[curve.vertices[end]] for curve in curves], np.int32) for end in (0, 1))
    every = np.concatenate(sizes)
    faces = []
    for face, places in sorted(by_face.items()):
        flat = np.ascontiguousarray(np.concatenate(flats[face]))
        faces.append((flat, np.concatenate([np.arange(starts[place], starts[place + 1]) for place in places])))
    for _ in range(MOST_PASSES):
        before = every.copy()
        grade_along(every, along, curve_of, first, last, len(names), rate)
        for flat, own in faces:
            inside = every[own]
            if inside.max() > (1 + SETTLED) * inside.min():
                grade_across(flat, inside, max(inside.min(), LEAST_CELL * inside.max()), rate)
                every[own] = inside
        if (every >= (1 - SETTLED) * before).all():
            break
    grade_along(every, along, curve_of, first, last, len(names), rate)
    for place, own in enumerate(np.split(every, starts[1:-1])):
        sizes[place] = own
