"""The target size of elements: what the user asks for, bounded, and what stands where he gives none."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from kernel.errors import OptionError
from kernel.mesh.options import MeshOptions
from kernel.segment.addresses import by_segment
from kernel.segment.segments import BeamShape, BrickShape, CylinderShape, PlateShape, Segment

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated

PER_WIDTH = 10.0
"""Elements across the median width of the segments."""

LEAST_PER_MODEL = 40.0
"""At least so many elements would fit along the model's size."""

MOST_ELEMENTS = 100_000
"""The automatic size is raised until about so many elements are left."""

MOST_ASKED = 5_000_000
"""A size that would give more elements is refused: neither memory nor a solver would take them."""

PER_TURN = 24
"""Elements round a full cylinder-plate at least: chords of 15 degrees lose 0.29 % of its area, no more."""

_BITES = 1 + 1e-9
"""A limit bites where the size is above it by more than rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Sizes:
    """size: where nothing else is said; because: what it comes from. by_segment: target size by segment id.

    reasons: by segment id, why it has a size of its own. warnings: one line for each size asked for that was bounded.
    """

    size: float
    because: str
    by_segment: dict[str, float]
    reasons: dict[str, str] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()


def plan_sizes(segments: Sequence[Segment], options: MeshOptions, evaluated: Evaluated) -> Sizes:
    """The size of every segment: asked for by id, node path or name, else the model's; no larger than the segment.

    OptionError: a size of nothing, or one that would give more than MOST_ASKED elements.
    """
    if options.size is not None:
        size, because = options.size, "as asked"
    else:
        size, because = automatic_size(segments, evaluated.size)
    own = by_segment(options.sizes, evaluated, segments, "size")
    sizes: dict[str, float] = {}
    reasons: dict[str, str] = {}
    warnings = []
    for segment in segments:
        asked, address = own.get(segment.id, (size, ""))
        largest, limit = _largest(segment, options.per_circle or PER_TURN)
        sizes[segment.id] = min(asked, largest)
        if address:
            reasons[segment.id] = f"asked for {address}"
        if asked > largest * _BITES:
            reasons[segment.id] = f"{asked:.6g} held down: {limit}"
            if address or options.size is not None:
                warnings.append(
                    f"{segment.id} ({segment.node}): size {asked:.6g} is held down to {largest:.4g}, {limit}"
                )
    _refuse_too_many(segments, sizes)
    return Sizes(size, because, sizes, reasons, tuple(warnings))


def _largest(segment: Segment, per_turn: int) -> tuple[float, str]:
    """The largest size that a segment can have, and why."""
    extent = float((segment.solid.bounds[1] - segment.solid.bounds[0]).max())
    if not isinstance(segment.shape, CylinderShape):
        return extent, "its largest extent"
    around = 2 * math.pi * segment.shape.mid_radius / per_turn
    return min((around, f"{per_turn} elements round its circle"), (extent, "its largest extent"))


def _refuse_too_many(segments: Sequence[Segment], sizes: dict[str, float]) -> None:
    expected = sum(_expected([segment], sizes[segment.id]) for segment in segments)
    if expected <= MOST_ASKED:
        return
    finest = coarse = min(sizes.values())
    while sum(_expected([segment], max(sizes[segment.id], coarse)) for segment in segments) > MOST_ASKED:
        coarse *= 1.25
    raise OptionError(
        f"size {finest:g} would give about {expected:.2g} elements, expected a size of {coarse:.2g} or more"
    )


def automatic_size(segments: Sequence[Segment], model_size: float) -> tuple[float, str]:
    """A size for the whole model, in model units, rounded to two digits; and what it comes from.

    A tenth of the segments' median width (the shorter side in the plane for plates, the developed shorter side for
    cylinder-plates, a tenth of the length for beams, the smallest extent for bricks) and no more than a fortieth of
    the model's size; but never so small that more than MOST_ELEMENTS elements are to be expected.
    """
    widths = [width for width in map(_width, segments) if width > 0.0]  # another owns all between a plate's faces
    width = float(np.median(widths)) if widths else model_size
    size, because = min(
        (width / PER_WIDTH, f"1/{PER_WIDTH:g} of the segments' median width {width:.4g}"),
        (model_size / LEAST_PER_MODEL, f"1/{LEAST_PER_MODEL:g} of the model's size {model_size:.4g}"),
    )
    if _expected(segments, size) > MOST_ELEMENTS:
        because = f"about {MOST_ELEMENTS} elements; {because} would give more"
    while _expected(segments, size) > MOST_ELEMENTS:
        size *= 1.1
    digits = 1 - int(np.floor(np.log10(size)))
    return float(round(size, digits)), f"automatic: {because}"


def _width(segment: Segment) -> float:
    extents = np.sort(segment.solid.bounds[1] - segment.solid.bounds[0])
    match segment.shape:
        case PlateShape(paired=paired):
            from kernel.segment.slices import smallest_rectangle

            return smallest_rectangle(paired)[1]
        case CylinderShape() as tube:
            return float(min(2 * np.pi * tube.mid_radius, tube.z_max - tube.z_min))
        case BeamShape() as beam:
            return beam.full_end - beam.full_start
        case BrickShape():
            return float(extents[0])
    raise AssertionError(segment.shape)


def _expected(segments: Sequence[Segment], size: float) -> float:
    total = 0.0
    for segment in segments:
        match segment.shape:
            case PlateShape() | CylinderShape():
                total += segment.volume / segment.shape.thickness / size**2
            case BeamShape() as beam:
                total += (beam.full_end - beam.full_start) / size
            case BrickShape():
                total += segment.volume / size**3
    return total
