"""Meshes on closed cylinders: the region is cut open along a seam, meshed in the plane, and closed again.

The seam's seeds stand on both sides of the cut, so the two sides match node by node. After closing they are ordinary
inner nodes, and quads about the seam are smoothed once more, across it.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.constrained import edges_of
from kernel.mesh.cross import dominant_cross
from kernel.mesh.cut import CutRegion, cut_open
from kernel.mesh.mixed import mixed_mesh
from kernel.mesh.quads import coarse_edges, quad_mesh
from kernel.mesh.region import Region, RegionMesh
from kernel.mesh.seam import BRIDGE, Step, find_seam, free_ends
from kernel.mesh.smoothing import smooth
from kernel.mesh.triangles import triangle_mesh

_BAND = 3
"""Rings of quads about the seam that are smoothed across it."""


def periodic_mesh(region: Region, size: float, faces: str, growth: float) -> RegionMesh:
    """Mesh a region with a period, closed over its seam. MeshError as for plane regions."""
    assert region.period is not None
    is_candidate = np.zeros(len(region.points), np.bool_)
    is_candidate[region.edges.ravel()] = True
    if faces == "quad":
        # only points that are coarse nodes: the seam leaves an even number of edges between where it meets a ring
        points = np.array(region.points, dtype=np.float64, order="C")
        edges = edges_of(region)
        coarse = coarse_edges(points, edges, dominant_cross(points, edges, region.is_curved))
        is_candidate[coarse[:, 2]] = False
        is_candidate[free_ends(region)] = True
    seeded, seam = _seed_seam(region, find_seam(region, size, is_candidate), size, faces)
    cut = cut_open(seeded, seam)
    if faces == "quad":
        mesh = quad_mesh(cut.region, size, growth, cut.is_vertex)
    elif faces == "mixed":
        mesh = mixed_mesh(cut.region, size, growth)
    else:
        mesh = triangle_mesh(cut.region, size, growth)
    return _close(mesh, cut, seeded, len(region.points))


def _seed_seam(region: Region, steps: list[Step], size: float, faces: str) -> tuple[Region, list[Step]]:
    """The region with the seam's seeds and edges as imprints, and the seam as steps along single edges."""
    points = [region.points]
    edges = [region.edges]
    seam: list[Step] = []
    n_point = len(region.points)
    n_new = 0
    for step in steps:
        if step.kind != BRIDGE:
            seam.append(step)
            continue
        length = math.hypot(*step.along)
        n_part = max(2, 2 * round(length / size / 2)) if faces == "quad" else max(1, round(length / size))
        chain = [step.start, *range(n_point, n_point + n_part - 1), step.end]
        points.append(region.points[step.start] + np.arange(1, n_part)[:, None] / n_part * np.array(step.along))
        edges.append(np.column_stack([chain[:-1], chain[1:]]).astype(np.int64))
        n_point += n_part - 1
        n_new += n_part
        part = (step.along[0] / n_part, step.along[1] / n_part)
        seam.extend(Step(u, v, part, BRIDGE) for u, v in pairwise(chain))
    no = np.zeros(n_new, np.bool_)
    seeded = Region(
        np.concatenate(points),
        np.concatenate(edges),
        np.concatenate([region.is_boundary, no]),
        np.concatenate([region.is_curved, no]),
        region.period,
    )
    return seeded, seam


def _close(mesh: RegionMesh, cut: CutRegion, seeded: Region, n_own: int) -> RegionMesh:
    """Glue left copies to right ones and smooth across. seeded: the region with the seam; n_own: points without."""
    assert seeded.period is not None
    n_seeded = len(seeded.points)
    n_left = len(cut.left_of)
    n_cut = n_seeded + n_left
    closed_number = np.concatenate(
        [np.arange(n_seeded), cut.left_of, np.arange(n_seeded, n_seeded + len(mesh.points) - n_cut)]
    )
    points = np.concatenate([mesh.points[:n_seeded], mesh.points[n_cut:]])
    quads = closed_number[mesh.quads]
    if n_left and len(quads):
        _smooth_across(points, quads, mesh.quads, cut, n_seeded, n_own, closed_number, seeded.period)
    points[:, 0] %= seeded.period
    points[points[:, 0] >= seeded.period, 0] = 0.0  # -1e-17 % period is period
    points[:n_own] = seeded.points[:n_own]
    return RegionMesh(points, quads, closed_number[mesh.triangles])


def _near(quads: NDArray[np.int64], n_node: int, start: NDArray[np.int64]) -> NDArray[np.bool_]:
    """Nodes within _BAND quads of `start`."""
    is_near = np.zeros(n_node, np.bool_)
    is_near[start] = True
    for _ in range(_BAND):
        is_near[quads[is_near[quads].any(axis=1)].ravel()] = True
    return is_near


def _smooth_across(
    points: NDArray[np.float64],
    quads: NDArray[np.int64],
    cut_quads: NDArray[np.int64],
    cut: CutRegion,
    n_seeded: int,
    n_own: int,
    closed_number: NDArray[np.int64],
    period: float,
) -> None:
    """Smooth the quads about the seam in one chart: those on its left moved back by a period. In place.

    quads: closed; cut_quads: the same with left copies apart. Nodes near both sides of the seam at once (a narrow
    ring of material) stay where they are.
    """
    n_node = len(closed_number)
    near_right = _near(cut_quads, n_node, cut.left_of)
    near_left = _near(cut_quads, n_node, np.arange(n_seeded, n_seeded + len(cut.left_of)))
    of_right = near_right[cut_quads].any(axis=1)
    of_left = near_left[cut_quads].any(axis=1) & ~of_right
    local = points.copy()
    on_left = np.unique(quads[of_left])
    on_right = np.unique(quads[of_right])
    seam_points = cut.left_of
    shifted = np.setdiff1d(on_left, np.concatenate([on_right, seam_points]))
    local[shifted, 0] -= period
    in_both = np.intersect1d(on_left, np.setdiff1d(on_right, seam_points))
    chart = quads[of_right | of_left]
    is_inner = np.zeros(len(points), np.bool_)  # nodes all of whose quads are in the chart
    is_inner[chart.ravel()] = True
    is_inner[quads[~(of_right | of_left)].ravel()] = False
    is_inner[:n_own] = False
    is_inner[quads[np.isin(quads, in_both).any(axis=1)].ravel()] = False
    used = np.unique(chart)
    place = np.full(len(points), -1, np.int64)
    place[used] = np.arange(len(used))
    nodes = np.ascontiguousarray(local[used])
    smooth(nodes, place[chart], ~is_inner[used])
    moved = used[is_inner[used]]
    points[moved] = nodes[place[moved]]
