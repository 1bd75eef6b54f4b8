"""Random regions with holes, slits, points and gaps down to a thirtieth of the size: how many mesh, how well.

    python bench/planar_random.py [REGIONS [FIRST_SEED]]      1,000 by default

Every mesh is checked: seeds and edges kept, watertight, positive elements, area, Euler characteristic.
"""

from __future__ import annotations

import math
import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np
from shapely import LineString, Point, Polygon

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "mesh"))
from planar_regions import assert_meshes, least_angles, scaled_jacobian
from plates import arc_lengths

from kernel.errors import MeshError
from kernel.mesh.gaps import SAMPLES_PER_SIZE, SampledCurve, divide, gap_sizes
from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region

GAP = 1 / 30
SHARP = 30.0
"""Degrees. A corner of the region under this bounds the quad in it, whatever the mesher does."""


class Shape:
    """Curves of a random region: sampled, with their vertices and the function that puts seeds on the true curve."""

    def __init__(self, seed: int) -> None:
        self.random = np.random.default_rng(seed)
        self.size = float(self.random.choice([8, 4, 2]))
        corners = self._corners()
        self.outline = Polygon(corners)
        self.taken: list = []
        self.curves: list[SampledCurve] = []
        self.places: list = []
        self.rounds: list[bool] = []
        self.points: list[tuple[float, float]] = []
        n = len(corners)
        for k in range(n):
            self._line(corners[k], corners[(k + 1) % n], k, (k + 1) % n, True)
        self.n_vertex = n
        for _ in range(40):
            self._hole(*self.random.uniform(-90, 90, 2), self.random.uniform(0.4 * self.size, 15))
        for _ in range(4):
            start = self.random.uniform(-80, 80, 2)
            angle, length = self.random.uniform(0, 2 * np.pi), self.random.uniform(2 * self.size, 40)
            end = start + length * np.array([math.cos(angle), math.sin(angle)])
            if self._has_room(LineString([start, end])):
                self._line(start, end, self.n_vertex, self.n_vertex + 1, False)
                self.n_vertex += 2
        for _ in range(3):
            x, y = self.random.uniform(-80, 80, 2)
            if self._has_room(Point(x, y)):
                self.points.append((x, y))
        u, v = np.roll(corners, -1, 0) - corners, np.roll(corners, 1, 0) - corners
        turn = np.arctan2(u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(1))
        self.sharpest = float(np.degrees(turn % (2 * np.pi)).min())

    def _corners(self) -> np.ndarray:
        while True:
            angles = np.sort(self.random.uniform(0, 2 * np.pi, self.random.integers(3, 14)))
            steps = np.diff(np.r_[angles, angles[0] + 2 * np.pi])
            if steps.min() > 0.15 and steps.max() < 2.8:
                radius = self.random.uniform(40, 100, len(angles))
                return np.column_stack([radius * np.cos(angles), radius * np.sin(angles)])

    def _has_room(self, shape: object) -> bool:
        gap = GAP * self.size
        if not self.outline.contains(shape) or self.outline.exterior.distance(shape) < gap:
            return False
        if any(shape.distance(other) < gap for other in self.taken):
            return False
        self.taken.append(shape)
        return True

    def _line(self, a: np.ndarray, b: np.ndarray, first: int, last: int, is_boundary: bool) -> None:
        length = float(np.hypot(*(b - a)))
        t = np.linspace(0, 1, max(8, int(SAMPLES_PER_SIZE * length / self.size)) + 1)[:, None]
        self.curves.append(SampledCurve(a + t * (b - a), first, last, is_boundary, self.size))
        self.places.append(lambda s: a + (s / length)[:, None] * (b - a))
        self.rounds.append(False)

    def _hole(self, x: float, y: float, radius: float) -> None:
        if not self._has_room(Point(x, y).buffer(radius, 64)):
            return

        def place(angle: np.ndarray) -> np.ndarray:
            return np.column_stack([x + radius * np.cos(angle), y - radius * np.sin(angle)])

        t = np.linspace(0, 2 * np.pi, max(128, int(SAMPLES_PER_SIZE * 2 * np.pi * radius / self.size)) + 1)
        curve = SampledCurve(place(t), self.n_vertex, self.n_vertex, True, min(self.size, 2 * math.pi * radius / 16))
        length = arc_lengths(curve.points)[-1]
        self.curves.append(curve)
        self.places.append(lambda s: place(2 * np.pi * s / length))
        self.rounds.append(True)
        self.n_vertex += 1

    def region(self, is_even: bool) -> Region:
        """Seeded by gaps: an even number on each curve for quads."""
        spots = [SampledCurve(np.array([p, p]), -i - 1, -i - 1, False, self.size) for i, p in enumerate(self.points)]
        sizes = gap_sizes([*self.curves, *spots])
        points: list[np.ndarray] = []
        numbers: dict[int, int] = {}
        edges, is_boundary, is_curved = [], [], []

        def add(point: np.ndarray) -> int:
            points.append(point)
            return len(points) - 1

        for curve, wanted, place, is_round in zip(self.curves, sizes, self.places, self.rounds):
            least = (16 if is_even else 8) if is_round else 2 if is_even else 1
            inner = place(divide(arc_lengths(curve.points), wanted, least, is_even))
            for vertex, point in ((curve.first, curve.points[0]), (curve.last, curve.points[-1])):
                if vertex not in numbers:
                    numbers[vertex] = add(point)
            chain = [numbers[curve.first], *(add(point) for point in inner), numbers[curve.last]]
            edges += list(pairwise(chain))
            is_boundary += [curve.is_boundary] * (len(chain) - 1)
            is_curved += [is_round] * (len(chain) - 1)
        points += [np.array(p) for p in self.points]
        return Region(np.array(points), np.array(edges), np.array(is_boundary), np.array(is_curved))


def main() -> None:
    n = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    first = int(sys.argv[2]) if len(sys.argv) > 2 else 100_000
    worst: list[tuple[float, int, float]] = []
    angles, refused, with_triangles, seconds, n_quad = [], [], 0, 0.0, 0
    for seed in range(first, first + n):
        shape = Shape(seed)
        for faces in ("quad", "tri"):
            region = shape.region(faces == "quad")
            start = time.process_time()
            try:
                mesh = mesh_region(region, shape.size, faces)
            except MeshError as error:
                refused.append((seed, faces, str(error)))
                continue
            if faces == "quad":
                seconds += time.process_time() - start
                n_quad += len(mesh.quads)
                worst.append((float(scaled_jacobian(mesh).min()), seed, shape.sharpest))
                with_triangles += len(mesh.triangles) > 0
            else:
                angles.append((float(least_angles(mesh).min()), shape.sharpest))
            assert_meshes(region, mesh)
    worst.sort()
    blunt = [value for value, _, corner in worst if corner >= SHARP]
    print(f"{n} regions from seed {first}: {len(refused)} refused, all others valid")
    for seed, faces, message in refused[:10]:
        print(f"  seed {seed}, {faces}: {message}")
    good = 100 * np.mean([value >= 0.5 for value, _, _ in worst])
    good_blunt = 100 * np.mean(np.array(blunt) >= 0.5)
    print(f"quads: worst {worst[0][0]:.2f}, >= .5 in {good:.1f} %, {with_triangles} meshes with triangles")
    print(f"  without corners under {SHARP:g} degrees ({len(blunt)} regions): >= .5 in {good_blunt:.1f} %")
    print("  lowest:", ", ".join(f"{value:.2f} (seed {seed})" for value, seed, _ in worst[:8]))
    print(f"  {n_quad / seconds / 1e3:.0f} thousand/s")
    fine = [angle for angle, corner in angles if corner >= 2 * SHARP]
    print(f"triangles: smallest angle >= 30 degrees in {100 * np.mean([a >= 30 for a, _ in angles]):.1f} %")
    good_fine = 100 * np.mean(np.array(fine) >= 30)
    print(f"  without corners under {2 * SHARP:g} degrees ({len(fine)} regions): in {good_fine:.1f} %")


if __name__ == "__main__":
    main()
