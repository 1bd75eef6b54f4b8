"""Beams: the axis through the section's centroid, and the stations at which it must have nodes."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError, OptionError
from kernel.idealise.section import SectionProperties, section_properties
from kernel.idealise.shares import shared_out
from kernel.segment.segments import BeamShape, Segment

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(slots=True, eq=False)
class Beam:
    """A beam segment. origin: the point of the axis with offset 0 along `direction`; start < end: offsets.

    stations: offsets that must be nodes. offsets, nodes: where the nodes are and their numbers, once meshed.
    """

    segment: Segment
    section: SectionProperties
    origin: Array
    direction: Array
    start: float
    end: float
    stations: list[float] = field(default_factory=list)
    offsets: Array = field(default_factory=lambda: np.empty(0))
    nodes: Indices = field(default_factory=lambda: np.empty(0, np.int64))

    @property
    def orientation(self) -> Array:
        """Unit vector of the section's y axis."""
        assert isinstance(self.segment.shape, BeamShape)
        return self.segment.shape.u

    def at(self, offset: float) -> Array:
        """The point (3,) of the axis."""
        return self.origin + offset * self.direction

    def offset_of(self, point: Array) -> float:
        """Where on the axis `point` (3,) is, held between its ends."""
        return float(np.clip(point @ self.direction, self.start, self.end))

    def is_end(self, offset: float, tolerance: float) -> bool:
        """Whether the offset is one of the two ends."""
        return bool(min(abs(offset - self.start), abs(offset - self.end)) <= tolerance)

    def node_at(self, offset: float) -> int:
        """Number of the node nearest to an offset."""
        return int(self.nodes[int(np.argmin(np.abs(self.offsets - offset)))])


def make_beam(segment: Segment) -> Beam:
    """The beam of a segment, with its section's properties."""
    shape = segment.shape
    assert isinstance(shape, BeamShape)
    properties = section_properties(shape.outline)
    y, z = properties.centroid
    return Beam(
        segment=segment,
        section=properties,
        origin=y * shape.u + z * shape.v,
        direction=shape.direction,
        start=shape.start,
        end=shape.end,
        stations=[shape.start, shape.end],
    )


def divide(beam: Beam, size: float, tolerance: float, count: int | None = None, most: float | None = None) -> Array:
    """Offsets (n,) of the beam's nodes: its stations, and between them even parts of about `size`.

    count: as many elements in all, as nearly alike as the stations let them be. OptionError: more are needed.
    most: none longer than that.
    """
    stations: list[float] = []
    for value in sorted(beam.stations):
        if not stations or value - stations[-1] > tolerance:
            stations.append(value)
    if len(stations) < 2:
        raise MeshError(f"{beam.segment.id} ({beam.segment.node}): a beam without length")
    lengths = np.diff(stations)
    counts = np.maximum(1, np.rint(lengths / size)).astype(np.int64)
    if most is not None:
        counts = np.maximum(1, np.ceil(lengths / most * (1 - 1e-9))).astype(np.int64)
    if count is not None:
        if count < len(lengths):
            raise OptionError(
                f"seeds of {beam.segment.id} ({beam.segment.node}): {count} asked for, but others meet it at "
                f"{len(lengths) - 1} places between its ends: expected at least {len(lengths)}"
            )
        counts = shared_out(lengths, count)
    parts = []
    for (start, end), own in zip(itertools.pairwise(stations), counts.tolist()):
        parts.append(start + (end - start) * np.arange(own) / own)
    return np.concatenate([*parts, stations[-1:]])
