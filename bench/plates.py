"""Regions that the planar benchmarks mesh, seeded by us; the same shapes for gmsh and Triangle."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from kernel.mesh.region import Region


@dataclass(frozen=True)
class Plate:
    """A rectangle with round holes (x, y, radius), to be meshed at `size`."""

    name: str
    width: float
    height: float
    holes: tuple[tuple[float, float, float], ...]
    size: float

    @property
    def area(self) -> float:
        return self.width * self.height - sum(math.pi * r * r for _, _, r in self.holes)

    def region(self, even: bool) -> Region:
        rings = [rectangle(self.width, self.height, self.size, even)]
        rings += [hole(x, y, r, self.size, even) for x, y, r in self.holes]
        return rings_region(rings)


def plate_a(size: float) -> Plate:
    """200 by 100 with six holes of diameter 12."""
    return Plate(f"A h={size:g}", 200, 100, tuple((x, y, 6) for x in (50, 100, 150) for y in (100 / 3, 200 / 3)), size)


def plate_e(n: int, triangles: float) -> Plate:
    """1000 by 1000 with n by n holes of 0.4 pitch, at the size of which `triangles` equilateral ones would fill it."""
    pitch = 1000 / n
    holes = tuple(((i + 0.5) * pitch, (j + 0.5) * pitch, 0.2 * pitch) for i in range(n) for j in range(n))
    plate = Plate(f"E {n}x{n} holes", 1000, 1000, holes, 1.0)
    size = math.sqrt(plate.area / (math.sqrt(3) / 4 * triangles))
    return Plate(plate.name, 1000, 1000, holes, size)


def divisions(length: float, size: float, even: bool) -> int:
    return max(2, 2 * round(length / size / 2)) if even else max(1, round(length / size))


def rectangle(width: float, height: float, size: float, even: bool) -> np.ndarray:
    corners = [(0.0, 0.0), (width, 0.0), (width, height), (0.0, height)]
    sides = []
    for k in range(4):
        a, b = np.array(corners[k]), np.array(corners[(k + 1) % 4])
        n = divisions(math.dist(a, b), size, even)
        sides.append(a + np.arange(n)[:, None] / n * (b - a))
    return np.concatenate(sides)


def hole(x: float, y: float, radius: float, size: float, even: bool, least: int = 8) -> np.ndarray:
    n = max(least, divisions(2 * math.pi * radius, size, even))
    t = -2 * np.pi * np.arange(n) / n
    return np.column_stack([x + radius * np.cos(t), y + radius * np.sin(t)])


def rings_region(rings: list[np.ndarray], n_straight: int = 1, period: float | None = None) -> Region:
    """Rings as closed boundaries, all but the first n_straight of them round."""
    edges, curved, n = [], [], 0
    for i, ring in enumerate(rings):
        number = np.arange(len(ring)) + n
        edges.append(np.column_stack([number, np.roll(number, -1)]))
        curved.append(np.full(len(ring), i >= n_straight))
        n += len(ring)
    points, all_edges = np.concatenate(rings), np.concatenate(edges).astype(np.int64)
    return Region(points, all_edges, np.ones(len(all_edges), bool), np.concatenate(curved), period)


def pipe(holes: list[tuple[float, float]], radius: float, drill: float, height: float, size: float) -> Region:
    """A pipe's mid-surface, unrolled, cut by drills along radii. holes: angle in degrees, height."""
    period = 2 * math.pi * radius
    x = np.arange(n := divisions(period, size, True)) / n * period
    rings = [np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + height])]
    for angle, z in holes:
        t = -2 * np.pi * np.arange(m := max(16, divisions(2 * math.pi * drill, size, True))) / m
        trace = radius * np.arcsin(drill * np.cos(t) / radius)
        rings.append(np.column_stack([radius * math.radians(angle) + trace, z + drill * np.sin(t)]))
    made = rings_region(rings, 2, period)
    points = made.points.copy()
    points[:, 0] %= period
    points[points[:, 0] >= period, 0] = 0.0
    return Region(points, made.edges, made.is_boundary, made.is_curved, period)


def dense_pipe() -> Region:
    """A pipe of radius 98.5 with 48 holes in staggered rows, so near to each other that no straight seam is free."""
    return pipe([(360 / 8 * (k + 0.5 * r), 40 + 44.0 * r) for r in range(6) for k in range(8)], 98.5, 28.0, 300.0, 5.0)


def sided(corners: list[tuple[float, float]], sizes: list[float]) -> np.ndarray:
    """A polygon whose sides are seeded each at a size of its own, in even numbers."""
    sides = []
    for k, size in enumerate(sizes):
        a, b = np.array(corners[k]), np.array(corners[(k + 1) % len(corners)])
        n = divisions(math.dist(a, b), size, True)
        sides.append(a + np.arange(n)[:, None] / n * (b - a))
    return np.concatenate(sides)


def graded_plate() -> tuple[Region, float]:
    """200 by 100 with two holes; sides seeded at 4, 1, 4 and 10, holes at .8 and 8. And the size inside."""
    rings = [sided([(0, 0), (200, 0), (200, 100), (0, 100)], [4, 1, 4, 10])]
    rings += [hole(50, 50, 10, 0.8, True), hole(130, 60, 20, 8, True)]
    return rings_region(rings), 4.0


def arc_lengths(points: np.ndarray) -> np.ndarray:
    """(n,) lengths from the first of points (n, 2) along the line through them."""
    return np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
