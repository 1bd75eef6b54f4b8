"""Seeds that follow the gaps between curves: where holes nearly touch, uniform seeds would make needles.

A curve is sampled; at each sample the wanted size is the smaller of the size asked for and a share of the gap to the
curve that faces it through the material; sizes grow gently along curves and from curve to curve; and a curve is
divided so that each element takes its share of the integral of 1 / size.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.numeric.gaps import gaps_between, grade_across, grade_along

PER_GAP = 0.7
"""Elements are at most this share of the gap long: quads across a gap are then not far from square."""
LEAST = 1 / 40
"""But never shorter than this share of the size asked for: narrower gaps get stretched elements."""
GROWTH = 0.25
"""Growth of the size per unit of length along a curve."""
STEEP = 1e-9
"""A size that changes by less than this share from sample to sample is constant."""
ROUNDING = 1e-6
"""A whole number of elements that is exceeded by less than this is still enough."""
SAMPLES_PER_SIZE = 4
"""How densely a curve should be sampled."""


@dataclass(frozen=True, slots=True, eq=False)
class SampledCurve:
    """A curve in the plane of its face.

    points: (n, 2), ends included; where it bounds the face, with the material on the left. first, last: numbers of
    its vertices, the same for a closed curve. is_boundary: False for imprints. size: wanted along it. A hard point
    inside the face is a curve of two equal points.
    """

    points: NDArray[np.float64]
    first: int
    last: int
    is_boundary: bool
    size: float


def gap_sizes(
    curves: Sequence[SampledCurve],
    period: float | None = None,
    growth: float = GROWTH,
    per_gap: float = PER_GAP,
    least: float = LEAST,
) -> list[NDArray[np.float64]]:
    """Wanted size at each curve's samples, (n,) each. period: of the first coordinate, on unrolled cylinders.

    growth: of the size per unit of length. per_gap: largest share of a gap that an element may have; least: share of
    the size asked for under which no gap makes it fall.
    """
    points = np.concatenate([curve.points for curve in curves])
    counts = np.array([len(curve.points) for curve in curves])
    ends = np.cumsum(counts)
    steps = np.hypot(*np.diff(points, axis=0).T)
    along = np.zeros(len(points))
    for end, count in zip(ends.tolist(), counts.tolist()):
        np.cumsum(steps[end - count : end - 1], out=along[end - count + 1 : end])
    curve_of = np.repeat(np.arange(len(curves), dtype=np.int32), counts)
    is_inner = np.diff(curve_of) == 0
    start = np.flatnonzero(is_inner).astype(np.int32)
    names = {name: i for i, name in enumerate(sorted({v for c in curves for v in (c.first, c.last)}))}
    first = np.array([names[curve.first] for curve in curves], np.int32)
    last = np.array([names[curve.last] for curve in curves], np.int32)
    length = along[ends - 1]
    is_boundary = np.array([curve.is_boundary for curve in curves], np.uint8)
    size = np.repeat(np.array([curve.size for curve in curves], np.float64), counts)
    reach = float(size.max()) / per_gap
    gap = gaps_between(
        points,
        start,
        start + np.int32(1),
        curve_of,
        along,
        first,
        last,
        length,
        is_boundary,
        reach,
        float(period or 0.0),
    )
    sizes = np.minimum(size, np.maximum(per_gap * gap, least * size))
    grade_across(points, sizes, float(size.max()) / PER_GAP / 4, growth)
    grade_along(sizes, along, curve_of, first, last, len(names), growth)
    return np.split(sizes, ends[:-1])


def divide(
    along: NDArray[np.float64], sizes: NDArray[np.float64], least: int, is_even: bool, is_bound: bool = False
) -> NDArray[np.float64]:
    """Arc lengths of the seeds between the curve's ends. along, sizes: (n,) at its samples; least: fewest elements.

    is_bound: no element is longer than the size there; else the number that is nearest to it is taken.
    """
    step = np.diff(along)
    slope = np.diff(sizes) / step  # of the size, which is linear between two samples
    steep = np.abs(slope) * step > STEEP * sizes[:-1]
    inside = step / sizes[:-1]
    inside[steep] = np.log(sizes[1:] / sizes[:-1])[steep] / slope[steep]
    elements = np.concatenate([[0.0], np.cumsum(inside)])
    unit = 2 if is_even else 1
    wanted = math.ceil(elements[-1] / unit - ROUNDING) if is_bound else round(elements[-1] / unit)
    count = max(least, unit * wanted, 1)
    if is_even:
        count += count % 2
    inner = elements[-1] * np.arange(1, count) / count
    row = np.clip(np.searchsorted(elements, inner, side="right") - 1, 0, len(step) - 1)
    beyond = inner - elements[row]
    far = sizes[row] * beyond
    bent = steep[row]
    far[bent] = sizes[row][bent] * np.expm1(slope[row][bent] * beyond[bent]) / slope[row][bent]
    return along[row] + far
