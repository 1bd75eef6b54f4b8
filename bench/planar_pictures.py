"""Pictures of the planar benchmarks' meshes, coloured by quality: PNG by matplotlib, which is no dependency.

python bench/planar.py --pictures FOLDER
"""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
from plates import Plate, dense_pipe, graded_plate, pipe, plate_a, plate_e
from quality import on_cylinder, quad_quality, triangle_angles

from kernel.mesh.planar import mesh_region
from kernel.mesh.region import RegionMesh

WORST_SHOWN = 0.4
WIDTH = 7.0
DOTS = 80
WORDS = {"quad": "quads", "tri": "triangles"}

Box = tuple[float, float, float, float]


def draw(mesh: RegionMesh, path: Path, title: str, box: Box | None = None, period: float | None = None) -> None:
    """One mesh, or what of it lies in the box (x, x, y, y), green where good and red where bad."""
    from matplotlib import pyplot
    from matplotlib.collections import PolyCollection

    shapes, values = [], []
    for nodes in (mesh.quads, mesh.triangles):
        if not len(nodes):
            continue
        x = on_cylinder(mesh.points[nodes], period)
        value = quad_quality(x)[0] if nodes.shape[1] == 4 else triangle_angles(mesh.points, nodes) / 60
        middle = x.mean(axis=1)
        kept = np.ones(len(x), bool)
        if box is not None:
            kept = (middle >= [box[0], box[2]]).all(axis=1) & (middle <= [box[1], box[3]]).all(axis=1)
        shapes += list(x[kept])
        values += list(value[kept])
    span = np.ptp(np.concatenate(shapes), axis=0)
    figure, axes = pyplot.subplots(figsize=(WIDTH, max(1.5, WIDTH * span[1] / span[0] + 0.4)))
    drawn = PolyCollection(shapes, array=np.array(values), cmap="RdYlGn", edgecolors="black", linewidths=0.25)
    drawn.set_clim(WORST_SHOWN, 1.0)
    axes.add_collection(drawn)
    axes.autoscale()
    axes.set_aspect("equal")
    axes.axis("off")
    axes.set_title(title, fontsize=9)
    figure.savefig(path, dpi=DOTS, bbox_inches="tight")
    pyplot.close(figure)


def pictures(folder: Path) -> None:
    """All pictures of docs/benchmarks.md, into the folder."""
    try:
        import matplotlib
    except ImportError:
        sys.exit("pictures need matplotlib, which is not installed (pip install matplotlib)")
    matplotlib.use("Agg")
    folder.mkdir(parents=True, exist_ok=True)

    def plate(name: str, case: Plate, faces: str, box: Box | None = None) -> None:
        mesh = mesh_region(case.region(faces == "quad"), case.size, faces)
        draw(
            mesh, folder / f"{name}.png", f"{case.name}, {len(mesh.quads) or len(mesh.triangles):,} {WORDS[faces]}", box
        )

    plate("plate_a_quads", plate_a(2), "quad")
    plate("plate_a_triangles", plate_a(3), "tri")
    plate("case_e_100_holes", plate_e(10, 1e5), "quad", (90, 310, 90, 310))
    plate("case_e_1600_holes", plate_e(40, 1e5), "quad", (0, 110, 0, 110))
    graded, size = graded_plate()
    for faces in ("quad", "tri"):
        mesh = mesh_region(graded, size, faces)
        draw(mesh, folder / f"graded_{WORDS[faces]}.png", f"curves seeded at .8 to 10, size {size:g}: {WORDS[faces]}")
    period = 2 * math.pi * 98.5
    four = pipe([(15 + 90 * k, 150.0) for k in range(4)], 98.5, 20.0, 300.0, 5.0)
    draw(mesh_region(four, 5.0), folder / "pipe.png", "closed pipe, unrolled", None, period)
    draw(mesh_region(dense_pipe(), 5.0), folder / "dense_pipe.png", "48 holes, no straight seam free", None, period)
