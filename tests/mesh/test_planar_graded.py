"""Regions whose curves are seeded very differently: the mesh grades between them, and its elements stay good."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planar_regions import assert_meshes, corners_of, elements, hole, least_angles, line, region, scaled_jacobian

from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region, RegionMesh

FEW = settings(max_examples=12)

RECTANGLE = [(0.0, 0.0), (200.0, 0.0), (200.0, 100.0), (0.0, 100.0)]


def polygon(corners: list[tuple[float, float]], sizes: list[float]) -> np.ndarray:
    """A ring with sides seeded each at a size of its own."""
    following = corners[1:] + corners[:1]
    return np.concatenate([line(a, b, size) for a, b, size in zip(corners, following, sizes, strict=True)])


def steps_of_size(mesh: RegionMesh, period: float | None = None) -> np.ndarray:
    """Ratio of the sizes (roots of areas, triangles counted double) of every two elements that share a side."""
    sizes, sides, n = [], [], 0
    for nodes in elements(mesh):
        x = corners_of(mesh, nodes, period)
        after = np.roll(x, -1, 1)
        areas = 0.5 * (x[..., 0] * after[..., 1] - after[..., 0] * x[..., 1]).sum(axis=1)
        n_corner = nodes.shape[1]
        sizes.append(np.sqrt(areas if n_corner == 4 else 2 * areas))
        for k in range(n_corner):
            side = np.sort(nodes[:, [k, (k + 1) % n_corner]], axis=1)
            sides.append(np.column_stack([side, np.arange(n, n + len(nodes))]))
        n += len(nodes)
    size, side = np.concatenate(sizes), np.concatenate(sides)
    side = side[np.lexsort((side[:, 1], side[:, 0]))]
    shared = (side[1:, :2] == side[:-1, :2]).all(axis=1)
    ratio = size[side[:-1, 2][shared]] / size[side[1:, 2][shared]]
    return np.maximum(ratio, 1 / ratio)


def random_region(seed: int) -> Region:
    """A quadrilateral with holes a dozen apart, each curve seeded at a size of its own between 1 and 10."""
    from shapely import Point, Polygon

    random = np.random.default_rng(seed)

    def any_size() -> float:
        return float(np.exp(random.uniform(0, math.log(10))))

    width, height = random.uniform(100, 200), random.uniform(80, 150)
    corners = [(0.0, 0.0), (width, 0.0), (random.uniform(0.8, 1) * width, height), (0.0, height)]
    rings, taken = [polygon(corners, [any_size() for _ in corners])], []
    outline = Polygon(corners)
    for _ in range(8):
        x, y, radius = random.uniform(0, width), random.uniform(0, height), random.uniform(6, 30)
        size, disc = min(any_size(), radius * math.pi / 4), Point(x, y).buffer(radius)
        if outline.contains(disc) and outline.exterior.distance(disc) > 12:
            if all(other.distance(disc) > 12 for other in taken):
                taken.append(disc)
                rings.append(hole(x, y, radius, size))
    return region(rings, tuple(range(1, len(rings))))


@FEW
@given(st.integers(0, 10_000))
def test_curves_seeded_up_to_ten_times_apart_mesh_well(seed: int) -> None:
    plane = random_region(seed)
    mesh = mesh_region(plane, 3.0)
    assert_meshes(plane, mesh)
    assert len(mesh.triangles) == 0
    assert scaled_jacobian(mesh).min() >= 0.45
    assert np.percentile(steps_of_size(mesh), 99) < 1.8
    mesh = mesh_region(plane, 3.0, "tri")
    assert_meshes(plane, mesh)
    assert np.percentile(least_angles(mesh), 1) > 30


@pytest.mark.parametrize("growth", [0.15, 0.3])
def test_a_fine_hole_in_a_coarse_plate_is_left_gently(growth: float) -> None:
    plane = region([polygon(RECTANGLE, [5.0] * 4), hole(100, 50, 10, 0.5)], (1,))
    for faces in ("quad", "tri"):
        mesh = mesh_region(plane, 5.0, faces, growth)
        assert_meshes(plane, mesh)
        assert steps_of_size(mesh).max() < 2.2
        if faces == "quad":
            assert scaled_jacobian(mesh).min() >= 0.7
        else:
            assert least_angles(mesh).min() >= 33
        away = np.hypot(*(mesh.points - [100, 50]).T)
        assert ((away > 11) & (away < 12)).sum() > 3 * ((away > 39) & (away < 40)).sum()


def test_edges_coarser_than_the_size_have_coarse_elements_beside_them() -> None:
    plane = region([polygon(RECTANGLE, [8.0] * 4), hole(100, 50, 15, 6)], (1,))
    for faces in ("quad", "tri"):
        mesh = mesh_region(plane, 2.0, faces)
        assert_meshes(plane, mesh)
        nodes = elements(mesh)[0]
        middle = mesh.points[nodes].mean(axis=1)
        edge = np.hypot(*(mesh.points[nodes[:, 0]] - mesh.points[nodes[:, 1]]).T)
        beside = (middle[:, 1] < 6) & (middle[:, 0] > 20) & (middle[:, 0] < 180)
        amid = np.hypot(*(middle - [40, 50]).T) < 10
        assert np.median(edge[beside]) > 1.7 * np.median(edge[amid])
        if faces == "quad":
            assert scaled_jacobian(mesh).min() >= 0.7
        else:
            assert least_angles(mesh).min() >= 35


def test_a_pipe_grades_between_fine_and_coarse_holes() -> None:
    period = 2 * math.pi * 98.5
    x = np.arange(62) / 62 * period
    rings = [np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + 300])]
    rings += [hole(30 + 200.0 * k, 150, 20, size) for k, size in enumerate((1.5, 15.0, 6.0))]
    plane = region(rings, (2, 3, 4), period=period)
    for faces in ("quad", "tri"):
        mesh = mesh_region(plane, 10.0, faces)
        assert_meshes(plane, mesh)
        steps = steps_of_size(mesh, period)
        assert np.percentile(steps, 99.5) < 1.8
        assert steps.max() < 3
        if faces == "quad":
            assert scaled_jacobian(mesh, period).min() >= 0.6
        else:
            assert least_angles(mesh, period).min() >= 30
