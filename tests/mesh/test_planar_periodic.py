"""Closed cylinders: watertight over the seam, wherever the holes are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from planar_regions import assert_meshes, count, hole, least_angles, region, scaled_jacobian

from kernel.errors import MeshError
from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region

RADIUS = 98.5
PERIOD = 2 * math.pi * RADIUS


def pipe(
    holes: list[tuple[float, float]],
    size: float = 5.0,
    radius: float = 20.0,
    height: float = 300.0,
    ring: float | None = None,
) -> Region:
    """A pipe cut by drills along radii. holes: angle in degrees and height; ring: height of an imprint all round."""
    x = np.arange(n := count(PERIOD, size)) / n * PERIOD
    rings = [np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + height])]
    for angle, z in holes:
        t = -2 * np.pi * np.arange(m := max(16, count(2 * math.pi * radius, size))) / m
        trace = RADIUS * np.arcsin(radius * np.cos(t) / RADIUS)
        rings.append(np.column_stack([RADIUS * math.radians(angle) + trace, z + radius * np.sin(t)]))
    lines = []
    if ring is not None:
        lines.append(np.column_stack([x, 0 * x + ring]))
    made = region(rings, tuple(range(2, len(rings))), lines, period=PERIOD)
    points = made.points.copy()
    points[:, 0] %= PERIOD
    points[points[:, 0] >= PERIOD, 0] = 0.0
    edges, is_boundary, is_curved = made.edges, made.is_boundary, made.is_curved
    if ring is not None:  # close the imprint
        edges = np.concatenate([edges, [[len(points) - 1, len(points) - n]]])
        is_boundary = np.append(is_boundary, False)
        is_curved = np.append(is_curved, False)
    return Region(points, edges, is_boundary, is_curved, PERIOD)


@pytest.mark.parametrize("turn", range(0, 90, 15))
def test_a_pipe_with_four_holes_is_meshed_in_good_quads_however_it_is_turned(turn: int) -> None:
    plane = pipe([(turn + 90 * k, 150.0) for k in range(4)])
    mesh = mesh_region(plane, 5.0)
    assert_meshes(plane, mesh)
    assert len(mesh.triangles) == 0
    quality = scaled_jacobian(mesh, PERIOD)
    assert quality.min() >= 0.75
    assert np.percentile(quality, 5) >= 0.95


def test_triangles_close_over_the_seam() -> None:
    plane = pipe([(90 * k, 150.0) for k in range(4)])
    mesh = mesh_region(plane, 5.0, "tri")
    assert_meshes(plane, mesh)
    assert least_angles(mesh, PERIOD).min() >= 30


@pytest.mark.parametrize("faces", ["quad", "tri", "mixed"])
def test_holes_so_dense_that_no_straight_seam_is_free(faces: str) -> None:
    holes = [(360 / 8 * (k + 0.5 * row), 40 + 44.0 * row) for row in range(6) for k in range(8)]
    plane = pipe(holes, radius=28.0)
    mesh = mesh_region(plane, 5.0, faces)
    assert_meshes(plane, mesh)
    if faces == "quad":
        assert scaled_jacobian(mesh, PERIOD).min() >= 0.3


def test_an_imprint_all_round_is_crossed_at_a_seed() -> None:
    plane = pipe([(90 * k, 200.0) for k in range(4)], ring=80.0)
    for faces in ("quad", "tri"):
        mesh = mesh_region(plane, 5.0, faces)
        assert_meshes(plane, mesh)


def test_a_bare_pipe_is_meshed_in_squares() -> None:
    plane = pipe([])
    mesh = mesh_region(plane, 5.0)
    assert_meshes(plane, mesh)
    assert scaled_jacobian(mesh, PERIOD).min() >= 0.95


@pytest.mark.parametrize("turn", [0.0, 0.25, 0.5])
def test_a_short_band_with_a_hole_stands_upright_far_from_the_hole(turn: float) -> None:
    n = 48
    x = np.arange(n, dtype=float)
    rings = [np.column_stack([x, 0 * x]), np.column_stack([(x[::-1] + 1) % n, 0 * x + 6]), hole(24 + turn, 3, 1.2, 0.5)]
    band = region(rings, (2,), period=float(n))
    mesh = mesh_region(band, 1.0)
    assert_meshes(band, mesh)
    quality = scaled_jacobian(mesh, float(n))
    middle = mesh.points[mesh.quads][:, 0, 0]
    assert quality[(middle < 10) | (middle > 38)].min() > 0.99


def test_a_short_ring_of_few_elements_meshes() -> None:
    plane = pipe([], size=40.0, height=60.0)
    assert_meshes(plane, mesh_region(plane, 40.0))


def test_a_patch_across_the_jump_of_the_angle_is_one_piece() -> None:
    corners = np.array([(-60.0, 0.0), (60.0, 0.0), (60.0, 80.0), (-60.0, 80.0)])
    rim = np.concatenate(
        [a + np.arange(8)[:, None] / 8 * (b - a) for a, b in zip(corners, np.roll(corners, -1, 0), strict=True)]
    )
    patch = region([rim, hole(5, 40, 15, 8)], (1,), points=[(-40.0, 20.0)], period=PERIOD)
    points = patch.points.copy()
    points[:, 0] %= PERIOD
    points[points[:, 0] >= PERIOD, 0] = 0.0
    patch = Region(points, patch.edges, patch.is_boundary, patch.is_curved, PERIOD)
    mesh = mesh_region(patch, 12.0)
    assert_meshes(patch, mesh)


def test_three_ends_are_refused() -> None:
    two = pipe([])
    above = two.points + [0.0, 400.0]
    edges = np.concatenate([two.edges, two.edges + len(two.points)])
    both = Region(
        np.concatenate([two.points, above]), edges, np.tile(two.is_boundary, 2), np.tile(two.is_curved, 2), PERIOD
    )
    with pytest.raises(MeshError, match="2 lower and 2 upper ends"):
        mesh_region(both, 5.0)
