"""The planar mesher's speed and quality against gmsh and Triangle, in one run: median of 5.

    python bench/planar.py                      everything (some minutes: gmsh)
    python bench/planar.py own                  csgmesh alone
    python bench/planar.py --pictures FOLDER    pictures of the meshes, no figures

CPU seconds of this process, one thread, kernels compiled; the other tools from their geometry on. Triangle is
measured where it is installed (it is not free for commercial use, and no part of csgmesh).
"""

from __future__ import annotations

import math
import multiprocessing
import resource
import statistics
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
from hard import hard_regions
from plates import Plate, dense_pipe, graded_plate, pipe, plate_a, plate_e
from quality import irregular_share, on_cylinder, quad_quality, triangle_angles

from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region, RegionMesh
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


def row(case: str, tool: str, seconds: float, mesh: Mesh, period: float | None = None) -> None:
    points, triangles, quads = mesh
    n = len(triangles) + len(quads)
    cells = [case, tool, f"{n:,}", f"{1e3 * seconds:.1f}", f"{n / seconds / 1e3:,.0f}"]
    if len(quads):
        jacobian, aspect = quad_quality(on_cylinder(points[quads], period))
        cells += [f"{jacobian.min():.2f}", f"{np.percentile(jacobian, 5):.3f}", f"{jacobian.mean():.3f}"]
        cells += [f"{aspect.max():.1f}", f"{100 * irregular_share(len(points), quads):.2f} %"]
        cells += [f"{100 * len(quads) / n:.1f} %"]
    else:
        angles = triangle_angles(points, triangles)
        cells += [f"{angles.min():.1f}", f"{np.percentile(angles, 5):.1f}", f"{angles.mean():.1f}", "", "", ""]
    print("| " + " | ".join(cells) + " |", flush=True)


HEAD = """
| case | tool | elements | ms | thousand/s | minimum | 5th percentile | mean | aspect | irregular | quads |
|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|"""


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
    print(HEAD)
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


def own_region(name: str, region: Region, size: float, faces: str) -> None:
    """A row for a region that has no plate."""
    mesh_region(region, size, faces)
    seconds, mesh = timed(lambda: mesh_region(region, size, faces))
    assert isinstance(mesh, RegionMesh)
    row(name, f"csgmesh {faces}", seconds, (mesh.points, mesh.triangles, mesh.quads), region.period)


def other_regions() -> None:
    print("\nClosed pipe R 98.5, length 300, h = 5; curves seeded very differently; and what is hard:\n" + HEAD)
    for turn in range(0, 90, 15):
        holes = [(turn + 90 * k, 150.0) for k in range(4)]
        own_region(f"pipe, 4 holes at {turn} degrees", pipe(holes, 98.5, 20.0, 300.0, 5.0), 5.0, "quad")
    own_region("pipe, 48 holes, no straight seam", dense_pipe(), 5.0, "quad")
    region, size = graded_plate()
    for faces in ("quad", "tri"):
        own_region("plate, seeds .8 to 10", region, size, faces)
    for name, region, size in hard_regions():
        for faces in ("quad", "tri"):
            own_region(name, region, size, faces)


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
    print(f"{one / two:.2f} times as fast as on one", end="; ")
    start = time.perf_counter()
    twins = [multiprocessing.get_context("fork").Process(target=twice, args=(region,)) for _ in range(2)]
    for twin in twins:
        twin.start()
    for twin in twins:
        twin.join()
    print(f"two processes, which share no lock: {one / (time.perf_counter() - start):.2f} times")


def twice(region: Region) -> None:
    for _ in range(2):
        mesh_region(region, 0.3)


def main() -> None:
    if "--pictures" in sys.argv[1:]:
        from planar_pictures import pictures

        if len(sys.argv) != 3:
            sys.exit("usage: python bench/planar.py --pictures FOLDER")
        pictures(Path(sys.argv[2]))
        return
    print(f"compiled or read from the cache in {compile_all():.1f} s\n")
    against_others(is_own_only="own" in sys.argv[1:])
    other_regions()
    others()


if __name__ == "__main__":
    main()
