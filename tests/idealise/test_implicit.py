"""Points brought onto surfaces: on all of them, by the shortest way, one by one as in a row."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.idealise.implicit import project
from kernel.solid.surfaces import Plane, plane_frame, signed_distance


def planes(random: np.random.Generator, count: int) -> list[Plane]:
    normals = random.normal(size=(count, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    offsets = random.uniform(-50, 50, count)
    return [Plane(n, float(offset), *plane_frame(n)[:2]) for n, offset in zip(normals, offsets)]


@pytest.mark.parametrize("count", [1, 2, 3])
@pytest.mark.parametrize("seed", range(8))
def test_a_point_comes_onto_planes_by_the_shortest_way(count: int, seed: int) -> None:
    random = np.random.default_rng(seed)
    surfaces, point = planes(random, count), random.uniform(-100, 100, 3)
    moved = project(point[None], surfaces)[0]
    size = float(np.abs([*moved, *point]).max())
    assert max(abs(float(signed_distance(surface, moved[None])[0])) for surface in surfaces) < 1e-13 * size
    normals = np.array([surface.normal for surface in surfaces])
    residual = normals @ point - [surface.offset for surface in surfaces]
    assert np.allclose(point - moved, np.linalg.lstsq(normals, residual, rcond=None)[0], atol=1e-9 * size)


@pytest.mark.parametrize("count", [1, 2, 3])
def test_one_point_goes_where_it_goes_among_others(count: int) -> None:
    random = np.random.default_rng(11)
    surfaces, points = planes(random, count), random.uniform(-100, 100, (5, 3))
    together = project(points, surfaces)
    apart = np.concatenate([project(point[None], surfaces) for point in points])
    assert np.allclose(apart, together, atol=1e-11 * float(np.abs(together).max()))


def test_planes_at_hardly_any_angle_say_nothing_about_the_way_along_them() -> None:
    tilted = np.array([0.0, 1e-7, 1.0])
    tilted /= np.linalg.norm(tilted)
    up = np.array([0.0, 0.0, 1.0])
    surfaces = [Plane(n, 5.0, *plane_frame(n)[:2]) for n in (up, tilted)]
    moved = project(np.array([[3.0, 40.0, 6.0]]), surfaces)[0]
    assert np.allclose(moved, [3.0, 40.0, 5.0], atol=1e-4)
    third = [*surfaces, Plane(np.array([1.0, 0.0, 0.0]), 2.0, *plane_frame(np.array([1.0, 0.0, 0.0]))[:2])]
    assert np.allclose(project(np.array([[3.0, 40.0, 6.0]]), third)[0], [2.0, 40.0, 5.0], atol=1e-4)
