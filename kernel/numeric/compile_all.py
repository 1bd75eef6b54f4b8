"""Compile every kernel once, so that no user's first mesh waits for it: `python -m kernel.numeric.compile_all`.

Small regions are meshed through the public door, so each kernel is compiled for just the signature that real calls
use. Machine code is kept beside the sources, or in NUMBA_CACHE_DIR, or in the user's own cache folder; it is made
anew when any file of this package has changed (see compiled).
"""

from __future__ import annotations

import sys
from time import perf_counter

import numpy as np


def compile_all() -> float:
    """Seconds that it took: some twenty on a machine that has no cache yet, under one afterwards."""
    from kernel.mesh.gaps import SampledCurve, gap_sizes
    from kernel.mesh.planar import mesh_region
    from kernel.mesh.region import Region

    started = perf_counter()
    square = _ring(_square(8))
    clockwise = -np.linspace(0, 2 * np.pi, 8, endpoint=False)
    hole = 4.0 + 1.1 * np.column_stack([np.cos(clockwise), np.sin(clockwise)])
    points, edges = _joined([square, _ring(hole)])
    boundary = np.ones(len(edges), np.bool_)
    plate = Region(points, edges, boundary, np.arange(len(edges)) >= 32)
    for faces in ("quad", "tri", "mixed"):
        mesh_region(plate, 1.0, faces)
    # a hole that nearly touches the rim: its neighbourhood is meshed anew
    near = plate.points.copy()
    near[32:] -= [0.0, 2.88]
    mesh_region(Region(near, edges, boundary, plate.is_curved), 1.0, "quad")
    # a cylinder with a hole: with free room for a straight seam, and with an imprint all round that forces a path
    x = np.arange(24.0)
    rings = [np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + 8]), hole, np.column_stack([x, 0 * x + 6])]
    for n_ring in (3, 4):
        points, edges = _joined([_ring(ring) for ring in rings[:n_ring]])
        is_boundary = np.arange(len(edges)) < 56
        mesh_region(Region(points, edges, is_boundary, np.zeros(len(edges), np.bool_), 24.0), 1.0, "quad")
    # seeds along two holes that nearly touch
    t = np.linspace(0, -2 * np.pi, 33)
    circles = [np.column_stack([x + np.cos(t), np.sin(t)]) for x in (0.0, 2.1)]
    gap_sizes([SampledCurve(circle, i, i, True, 0.5) for i, circle in enumerate(circles)])
    return perf_counter() - started


def _square(n: int) -> np.ndarray:
    t = np.arange(n, dtype=np.float64)
    zero, full = 0 * t, 0 * t + n
    sides = [(t, zero), (full, t), (n - t, full), (zero, n - t)]
    return np.concatenate([np.column_stack(side) for side in sides])


def _ring(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    number = np.arange(len(points))
    return points, np.column_stack([number, np.roll(number, -1)])


def _joined(rings: list[tuple[np.ndarray, np.ndarray]]) -> tuple[np.ndarray, np.ndarray]:
    points, edges, n = [], [], 0
    for ring_points, ring_edges in rings:
        points.append(ring_points)
        edges.append(ring_edges + n)
        n += len(ring_points)
    return np.concatenate(points), np.concatenate(edges)


if __name__ == "__main__":
    sys.stdout.write("compiling the meshers' kernels, once on this machine...\n")
    sys.stdout.flush()
    sys.stdout.write(f"done in {compile_all():.1f} s\n")
