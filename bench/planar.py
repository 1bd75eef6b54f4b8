"""The planar mesher's speed and quality against gmsh and Triangle, in one run: median of 5.

    python bench/planar.py            everything (some minutes: gmsh)
    python bench/planar.py own        csgmesh alone

CPU seconds of this process, one thread, kernels compiled; the other tools from their geometry on. Triangle is
measured where it is installed (it is not free for commercial use, and no part of csgmesh).
"""

from __future__ import annotations

import math
import resource
import statistics
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
from plates import Plate, pipe, plate_a, plate_e

from kernel.mesh.planar import mesh_region
from kernel.mesh.region import RegionMesh
from kernel.mesh.sweep import sweep
from kernel.numeric.compile_all import compile_all

RUNS = 5
Mesh = tuple[np.ndarray, np.ndarray, np.ndarray]  # points, triangles, quads


def timed(work: Callable[[], object]) -> tuple[float, object]:
    """Median CPU seconds of RUNS runs, and the last result."""
    seconds, result = [], None
    for _ in range(RUNS):
        start = time.process_time()
        result = work()
        seconds.append(time.process_time() - start)
    return statistics.median(seconds), result


def cross(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    return u[..., 0] * v[..., 1] - u[..., 1] * v[..., 0]


def triangle_angles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Smallest angle of each, degrees."""
    x = points[triangles]
    ahead = np.roll(x, -1, 1) - x
    back = -np.roll(ahead, 1, 1)
    return np.degrees(np.arctan2(cross(ahead, back), (ahead * back).sum(2))).min(1)


def quad_quality(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Scaled Jacobian and aspect (longest edge times perimeter over four areas) of quads (n, 4, 2)."""
    edge = np.roll(x, -1, 1) - x
    back = np.roll(edge, 1, 1)
    length = np.hypot(edge[..., 0], edge[..., 1])
    jacobian = (cross(back, edge) / (length * np.roll(length, 1, 1))).min(1)
    area = 0.5 * np.abs(cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1]))
    return jacobian, length.max(1) * length.sum(1) / (4 * area)


def irregular_share(n_node: int, quads: np.ndarray) -> float:
    """Share of inner nodes with other than four neighbours."""
    pairs = np.sort(np.concatenate([quads[:, [k, (k + 1) % 4]] for k in range(4)]), axis=1)
    sides, uses = np.unique(pairs, axis=0, return_counts=True)
    valence = np.bincount(sides.ravel(), minlength=n_node)
    is_inner = valence > 0
    is_inner[sides[uses == 1].ravel()] = False
    return float((valence[is_inner] != 4).mean())


def row(case: str, tool: str, seconds: float, mesh: Mesh) -> None:
    points, triangles, quads = mesh
    n = len(triangles) + len(quads)
    if len(quads):
        jacobian, aspect = quad_quality(points[quads])
        quality = f"{jacobian.min():.2f} / {np.percentile(jacobian, 5):.3f} / {jacobian.mean():.3f}"
        quality += f", aspect {aspect.max():.1f}, irregular {100 * irregular_share(len(points), quads):.2f} %"
        quality += f", quads {100 * len(quads) / n:.1f} %"
    else:
        angles = triangle_angles(points, triangles)
        quality = f"{angles.min():.1f} / {np.percentile(angles, 5):.1f} / {angles.mean():.1f} degrees"
    print(f"| {case} | {tool} | {n:,} | {1e3 * seconds:.1f} | {n / seconds / 1e3:,.0f} | {quality} |", flush=True)


def own(plate: Plate, faces: str) -> tuple[float, Mesh]:
    region = plate.region(faces == "quad")
    mesh_region(region, plate.size, faces)
    seconds, mesh = timed(lambda: mesh_region(region, plate.size, faces))
    assert isinstance(mesh, RegionMesh)
    return seconds, (mesh.points, mesh.triangles, mesh.quads)


def gmsh_mesh(plate: Plate, algorithm: int, recombination: int | None) -> tuple[float, Mesh]:
    import gmsh

    seconds, mesh = [], None
    for _ in range(RUNS):
        gmsh.initialize(interruptible=False)
        options = {"General.Terminal": 0, "General.NumThreads": 1, "Mesh.Algorithm": algorithm}
        options |= {"Mesh.MeshSizeMin": plate.size, "Mesh.MeshSizeMax": plate.size}
        if recombination is not None:
            options |= {"Mesh.RecombineAll": 1, "Mesh.RecombinationAlgorithm": recombination}
        for name, value in options.items():
            gmsh.option.setNumber(name, value)
        model = gmsh.model.occ
        corners = [(0, 0), (plate.width, 0), (plate.width, plate.height), (0, plate.height)]
        vertices = [model.addPoint(x, y, 0) for x, y in corners]
        lines = [model.addLine(vertices[k], vertices[(k + 1) % 4]) for k in range(4)]
        loops = [model.addCurveLoop(lines)]
        loops += [model.addCurveLoop([model.addCircle(x, y, 0, r)]) for x, y, r in plate.holes]
        model.addPlaneSurface(loops)
        model.synchronize()
        start = time.process_time()
        gmsh.model.mesh.generate(2)
        seconds.append(time.process_time() - start)
        tags, places, _ = gmsh.model.mesh.getNodes()
        points = np.zeros((int(tags.max()) + 1, 2))
        points[tags.astype(int)] = places.reshape(-1, 3)[:, :2]
        kinds = [gmsh.model.mesh.getElementsByType(kind)[1].astype(int) for kind in (2, 3)]
        mesh = points, kinds[0].reshape(-1, 3), kinds[1].reshape(-1, 4)
        gmsh.finalize()
        if sum(seconds) > 60:
            break
    assert mesh is not None
    return statistics.median(seconds), mesh


def triangle_mesh(plate: Plate) -> tuple[float, Mesh] | None:
    try:
        import triangle
    except ImportError:
        return None
    region = plate.region(False)
    given = {"vertices": region.points, "segments": region.edges, "holes": [(x, y) for x, y, _ in plate.holes]}
    switches = f"pq30a{math.sqrt(3) / 4 * plate.size**2:.9f}"
    seconds, made = timed(lambda: triangle.triangulate(given, switches))
    assert isinstance(made, dict)
    return seconds, (made["vertices"], made["triangles"], np.empty((0, 4), int))


def against_others(is_own_only: bool) -> None:
    print("| case | tool | elements | ms | thousand/s | minimum / 5th percentile / mean |\n|---|---|---|---|---|---|")
    plates = [plate_a(5), plate_a(1), plate_a(0.5), plate_e(10, 1e5), plate_e(40, 1e5)]
    for plate in plates:
        row(plate.name, "csgmesh triangles", *own(plate, "tri"))
        if not is_own_only:
            row(plate.name, "gmsh Frontal-Delaunay", *gmsh_mesh(plate, 6, None))
            if (made := triangle_mesh(plate)) is not None:
                row(plate.name, "Triangle pq30a", *made)
    for plate in plates:
        row(plate.name, "csgmesh quads", *own(plate, "quad"))
        if not is_own_only:
            row(plate.name, "gmsh quads, full-quad", *gmsh_mesh(plate, 8, 2))


def cylinders() -> None:
    print("\nClosed pipe R 98.5, length 300, h = 5:")
    radius, period = 98.5, 2 * math.pi * 98.5
    worst, counts, seconds = [], set(), []
    for turn in range(0, 90, 15):
        region = pipe([(turn + 90 * k, 150.0) for k in range(4)], radius, 20.0, 300.0, 5.0)
        mesh_region(region, 5.0)
        duration, mesh = timed(lambda region=region: mesh_region(region, 5.0))
        worst.append(worst_on_cylinder(mesh, period))
        counts.add(len(mesh.triangles))
        seconds.append(duration)
    print(f"four holes r = 20 turned 0..75 degrees: worst scaled Jacobian {min(worst):.2f}, triangles {max(counts)}, "
          f"{1e3 * max(seconds):.1f} ms")  # fmt: skip
    dense = [(360 / 8 * (k + 0.5 * r), 40 + 44.0 * r) for r in range(6) for k in range(8)]
    mesh = mesh_region(pipe(dense, radius, 28.0, 300.0, 5.0), 5.0)
    print(f"48 holes r = 28, no straight seam free: worst {worst_on_cylinder(mesh, period):.2f}, "
          f"{len(mesh.quads)} quads, {len(mesh.triangles)} triangles")  # fmt: skip


def worst_on_cylinder(mesh: RegionMesh, period: float) -> float:
    x = mesh.points[mesh.quads]
    x[..., 0] -= period * np.round((x[..., 0] - x[:, :1, 0]) / period)
    return float(quad_quality(x)[0].min())


def others() -> None:
    print("\nPlate A swept to hexes at h = 2 (five layers):")
    plate = plate_a(2)
    section = mesh_region(plate.region(True), plate.size)

    def lift(points: np.ndarray, level: float) -> np.ndarray:
        return np.column_stack([points, np.full(len(points), level)])

    def work() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        return sweep(mesh_region(plate.region(True), plate.size), lift, np.linspace(0, 10, 6))

    seconds, swept = timed(work)
    worst = quad_quality(section.points[section.quads])[0].min()
    print(f"{len(swept[1])} hexes in {1e3 * seconds:.1f} ms, {len(swept[1]) / seconds / 1e3:,.0f} thousand/s, "
          f"worst {worst:.2f}")  # fmt: skip

    print("\nA million triangles:")
    plate = plate_a(0.21)
    region = plate.region(False)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    start = time.process_time()
    mesh = mesh_region(region, plate.size, "tri")
    seconds = time.process_time() - start
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    print(f"{len(mesh.triangles):,} in {seconds:.2f} s, peak {peak / 1024:.0f} MB (before {before / 1024:.0f})")

    print("\nTwo faces on two threads:")
    region = plate_a(0.3).region(True)

    def wall(threads: int) -> float:
        start = time.perf_counter()
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(lambda _: mesh_region(region, 0.3), range(4)))
        return time.perf_counter() - start

    one, two = (min(wall(threads) for _ in range(RUNS)) for threads in (1, 2))
    print(f"{one / two:.2f} times as fast as on one")


def main() -> None:
    print(f"compiled or read from the cache in {compile_all():.1f} s\n")
    against_others(is_own_only="own" in sys.argv[1:])
    cylinders()
    others()


if __name__ == "__main__":
    main()
