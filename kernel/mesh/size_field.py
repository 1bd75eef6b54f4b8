"""The target size of elements: what the user asks for, bounded, and what stands where he gives none."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kernel.errors import OptionError
from kernel.mesh.options import MeshOptions
from kernel.segment.segments import BeamShape, BrickShape, CylinderShape, PlateShape, Segment

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


def segment_sizes(segments: Sequence[Segment], options: MeshOptions, size: float) -> dict[str, float]:
    """Target size by segment id: asked for by id, node path or name, else `size`; no larger than the segment.

    OptionError where it would give more than MOST_ASKED elements.
    """
    sizes: dict[str, float] = {}
    for segment in segments:
        names = [name for name in (segment.id, segment.node, segment.name) if name is not None]
        asked = next((options.segment_sizes[name] for name in names if name in options.segment_sizes), size)
        largest = float((segment.solid.bounds[1] - segment.solid.bounds[0]).max())
        if isinstance(segment.shape, CylinderShape):
            largest = min(largest, 2 * np.pi * segment.shape.mid_radius / PER_TURN)
        sizes[segment.id] = min(asked, largest)
    expected = sum(_expected([segment], sizes[segment.id]) for segment in segments)
    if expected > MOST_ASKED:
        finest = min(sizes.values())
        coarse = finest
        while sum(_expected([segment], max(sizes[segment.id], coarse)) for segment in segments) > MOST_ASKED:
            coarse *= 1.25
        raise OptionError(
            f"size {finest:g} would give about {expected:.2g} elements, expected a size of {coarse:.2g} or more"
        )
    return sizes


def automatic_size(segments: Sequence[Segment], model_size: float) -> float:
    """A size for the whole model, in model units, rounded to two digits.

    A tenth of the segments' median width (the shorter side in the plane for plates, the developed shorter side for
    cylinder-plates, a tenth of the length for beams, the smallest extent for bricks) and no more than a fortieth of
    the model's size; but never so small that more than MOST_ELEMENTS elements are to be expected.
    """
    widths = [_width(segment) for segment in segments]
    size = min(float(np.median(widths)) / PER_WIDTH, model_size / LEAST_PER_MODEL)
    while _expected(segments, size) > MOST_ELEMENTS:
        size *= 1.1
    digits = 1 - int(np.floor(np.log10(size)))
    return float(round(size, digits))


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
