"""Compile every kernel once, so that no user's first mesh waits for it: `python -m kernel.numeric.compile_all`.

Small regions are meshed through the public door, so each kernel is compiled for just the signature that real calls
use. Machine code is kept beside the sources, or in NUMBA_CACHE_DIR, or in the user's own cache folder; it is made
anew when any file of this package has changed (see compiled).
"""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from time import perf_counter

import numpy as np

from kernel.errors import DefectError
from kernel.mesh.gaps import SampledCurve, gap_sizes
from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region

PARTS = ("quad", "tri")
"""What can be compiled beside each other: what quads need, and what triangles alone need."""


def compile_all(parts: Sequence[str] = PARTS) -> float:
    """Seconds that it took: some twenty for all parts on a machine that has no cache yet, under one afterwards."""
    started = perf_counter()
    if "quad" in parts:
        _compile_quads()
    if "tri" in parts:
        mesh_region(_plate(), 1.0, "tri")
    return perf_counter() - started


def compile_in_two_processes() -> float:
    """The same, a second process compiling what triangles alone need: half the wait where two cores are free."""
    started = perf_counter()
    command = [sys.executable, "-m", "kernel.numeric.compile_all", "tri"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL) as other:
        compile_all(("quad",))
    if other.returncode != 0:
        raise DefectError(f"compiling the triangles' kernels ended with status {other.returncode}")
    compile_all()  # read from the cache what the other wrote, or compile it where there is no cache
    return perf_counter() - started


def _compile_quads() -> None:
    # seeds along two holes that nearly touch
    t = np.linspace(0, -2 * np.pi, 33)
    circles = [np.column_stack([x + np.cos(t), np.sin(t)]) for x in (0.0, 2.1)]
    gap_sizes([SampledCurve(circle, i, i, True, 0.5) for i, circle in enumerate(circles)])
    plate = _plate()
    for faces in ("quad", "mixed"):
        mesh_region(plate, 1.0, faces)
    # a hole that nearly touches the rim: its neighbourhood is meshed anew
    near = plate.points.copy()
    near[32:] -= [0.0, 2.88]
    mesh_region(Region(near, plate.edges, plate.is_boundary, plate.is_curved), 1.0, "quad")
    # a cylinder with a hole: with free room for a straight seam, and with an imprint all round that forces a path
    x = np.arange(24.0)
    rings = [
        np.column_stack([x, 0 * x]),
        np.column_stack([x[::-1], 0 * x + 8]),
        _hole(),
        np.column_stack([x, 0 * x + 6]),
    ]
    for n_ring in (3, 4):
        points, edges = _joined([_ring(ring) for ring in rings[:n_ring]])
        is_boundary = np.arange(len(edges)) < 56
        mesh_region(Region(points, edges, is_boundary, np.zeros(len(edges), np.bool_), 24.0), 1.0, "quad")


def _plate() -> Region:
    """A square with a hole."""
    points, edges = _joined([_ring(_square(8)), _ring(_hole())])
    return Region(points, edges, np.ones(len(edges), np.bool_), np.arange(len(edges)) >= 32)


def _hole() -> np.ndarray:
    clockwise = -np.linspace(0, 2 * np.pi, 8, endpoint=False)
    return 4.0 + 1.1 * np.column_stack([np.cos(clockwise), np.sin(clockwise)])


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


def main() -> None:
    """Compile the parts named on the command line; without names all, in two processes, and say so."""
    if len(sys.argv) > 1:
        compile_all(sys.argv[1:])
        return
    sys.stdout.write("compiling the meshers' kernels, once on this machine...\n")
    sys.stdout.flush()
    sys.stdout.write(f"done in {compile_in_two_processes():.1f} s\n")


if __name__ == "__main__":
    main()
