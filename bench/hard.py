"""Regions that meshers fail on: thin strips, holes almost touching, holes under the size, sharp corners, many holes."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from plates import arc_lengths, hole, rectangle, rings_region, sided

from kernel.mesh.gaps import SampledCurve, divide, gap_sizes
from kernel.mesh.region import Region


def hard_regions() -> Iterator[tuple[str, Region, float]]:
    """Name, region and size."""
    yield "strip 10,000 x 1", rings_region([rectangle(10_000, 1, 10, True)]), 10.0
    yield "strip 1,000 x 3 with holes of 1", strip_with_holes(), 3.0
    for gap in (1.0, 0.1, 1 / 30):
        yield f"holes {gap:.2g} sizes apart", rows_of_holes(gap), 2.0
    small = [hole(4.0 * i + 2, 4.0 * j + 2, 0.3, 2.0, True) for i in range(25) for j in range(12)]
    yield "300 holes of .15 sizes", rings_region([rectangle(100, 48, 2, True), *small]), 2.0
    for angle in (30, 15, 5):
        height = 100 * math.tan(math.radians(angle))
        wedge = sided([(0.0, 0.0), (100.0, 0.0), (100.0, height)], [2.0] * 3)
        yield f"corner of {angle} degrees", rings_region([wedge]), 2.0
    many = [hole(10.0 * i + 5, 10.0 * j + 5, 2, 1.5, True) for i in range(100) for j in range(100)]
    yield "10,000 holes", rings_region([rectangle(1000, 1000, 5, True), *many]), 3.0


def strip_with_holes() -> Region:
    rings = [rectangle(1000, 3, 1, True)]
    rings += [hole(10.0 * k + 5, 1.5, 0.5, 0.4, True) for k in range(100)]
    return rings_region(rings)


def rows_of_holes(gap: float) -> Region:
    """Six by four holes of radius 6, `gap` sizes of 2 from each other, all curves seeded by their gaps."""
    size, radius = 2.0, 6.0
    pitch = 2 * radius + gap * size
    width, height = 6 * pitch + 12, 4 * pitch + 12
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    curves = []
    for k in range(4):
        a, b = np.array(corners[k]), np.array(corners[(k + 1) % 4])
        t = np.linspace(0, 1, 4 * round(math.dist(a, b) / size) + 1)[:, None]
        curves.append(SampledCurve(a + t * (b - a), k, (k + 1) % 4, True, size))
    t = np.linspace(0, -2 * np.pi, 385)
    for i in range(6):
        for j in range(4):
            x, y = 6 + (i + 0.5) * pitch, 6 + (j + 0.5) * pitch
            place = np.column_stack([x + radius * np.cos(t), y + radius * np.sin(t)])
            curves.append(SampledCurve(place, 4 + 4 * i + j, 4 + 4 * i + j, True, size))
    rings: list[np.ndarray] = []
    for curve, wanted in zip(curves, gap_sizes(curves)):
        along = arc_lengths(curve.points)
        seeds = np.concatenate([[0.0], divide(along, wanted, 2 if len(rings) == 0 else 16, True)])
        places = np.column_stack([np.interp(seeds, along, curve.points[:, k]) for k in range(2)])
        rings.append(places)
    return rings_region([np.concatenate(rings[:4]), *rings[4:]])
