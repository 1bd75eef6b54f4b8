"""Seeds follow the gaps between curves, and not the corners where curves meet."""

from __future__ import annotations

import numpy as np
import pytest
from planar_regions import assert_meshes, region, scaled_jacobian

from kernel.mesh.gaps import GROWTH, LEAST, PER_GAP, SampledCurve, divide, gap_sizes
from kernel.mesh.planar import mesh_region


def straight(
    a: tuple[float, float], b: tuple[float, float], first: int, last: int, is_boundary: bool = True, size: float = 2.0
):
    t = np.linspace(0, 1, 81)[:, None]
    return SampledCurve(np.array(a) + t * (np.array(b) - np.array(a)), first, last, is_boundary, size)


def along(curve: SampledCurve) -> np.ndarray:
    """Arc length of each sample from the first."""
    return np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(curve.points, axis=0).T))])


def circle(x: float, y: float, radius: float, name: int, size: float = 2.0) -> SampledCurve:
    t = -np.linspace(0, 2 * np.pi, 161)
    return SampledCurve(np.column_stack([x + radius * np.cos(t), y + radius * np.sin(t)]), name, name, True, size)


def square(side: float, size: float = 2.0) -> list[SampledCurve]:
    corners = [(0.0, 0.0), (side, 0.0), (side, side), (0.0, side)]
    return [straight(corners[k], corners[(k + 1) % 4], k, (k + 1) % 4, size=size) for k in range(4)]


def test_corners_are_no_gaps() -> None:
    for sizes in gap_sizes(square(40)):
        np.testing.assert_array_equal(sizes, 2.0)


def test_a_triangle_of_sixty_degrees_has_no_gaps() -> None:
    corners = [(0.0, 0.0), (40.0, 0.0), (20.0, 34.6)]
    for sizes in gap_sizes([straight(corners[k], corners[(k + 1) % 3], k, (k + 1) % 3) for k in range(3)]):
        np.testing.assert_array_equal(sizes, 2.0)


@pytest.mark.parametrize("gap", [0.3, 1.0, 2.0])
def test_two_holes_ask_for_a_share_of_the_gap_where_they_face_each_other(gap: float) -> None:
    *outer, left, right = gap_sizes([*square(60), circle(20, 30, 5, 10), circle(30 + gap, 30, 5, 11)])
    for sizes in (left, right):
        assert sizes.min() == pytest.approx(PER_GAP * gap, rel=0.02)
        assert sizes.max() == 2.0
    assert left.argmin() in (0, 160)
    for sizes in outer:
        np.testing.assert_array_equal(sizes, 2.0)


def test_holes_do_not_see_each_other_through_the_outside() -> None:
    plate = square(20)
    beside = [SampledCurve(c.points + [20.1, 0.0], c.first + 10, c.last + 10, True, 2.0) for c in square(20)]
    for sizes in gap_sizes([*plate, *beside]):
        np.testing.assert_array_equal(sizes, 2.0)


def test_a_gap_counts_over_the_seam_of_a_cylinder() -> None:
    one, other = circle(3, 30, 2.5, 1), circle(97, 30, 2.5, 2)
    assert gap_sizes([one, other])[0].min() == 2.0
    assert gap_sizes([one, other], period=100.0)[0].min() == pytest.approx(PER_GAP * 1.0, rel=0.03)


def test_a_slit_along_an_edge_and_a_point_near_it_are_seen() -> None:
    slit = straight((5.0, 0.5), (35.0, 0.5), 20, 21, is_boundary=False)
    bottom, *_, beside = gap_sizes([*square(40), slit])
    assert bottom.min() == pytest.approx(PER_GAP * 0.5)
    assert beside.max() == pytest.approx(PER_GAP * 0.5)
    point = SampledCurve(np.array([[20.0, 1.0], [20.0, 1.0]]), 30, 30, False, 2.0)
    bottom = gap_sizes([*square(40), point])[0]
    assert bottom.min() == pytest.approx(PER_GAP * 1.0, rel=0.02)


def test_very_narrow_gaps_stop_at_a_least_size_and_sizes_grow_gently() -> None:
    curves = [*square(60), circle(20, 30, 5, 10), circle(30 + 1e-4, 30, 5, 11)]
    left = gap_sizes(curves)[4]
    assert left.min() == pytest.approx(LEAST * 2.0)
    assert np.abs(np.diff(left)).max() <= GROWTH * np.diff(along(curves[4])).max() * (1 + 1e-9)


def test_a_curve_is_divided_in_an_even_number_by_its_sizes() -> None:
    stations = np.linspace(0, 10, 101)
    np.testing.assert_allclose(divide(stations, np.full(101, 1.0), 2, True), np.arange(1, 10))
    np.testing.assert_allclose(divide(stations, np.full(101, 3.3), 1, False), [10 / 3, 20 / 3])
    graded = divide(stations, 0.2 + 0.1 * stations, 2, True)
    steps = np.diff(np.concatenate([[0.0], graded, [10.0]]))
    assert len(steps) % 2 == 0
    assert (np.diff(steps) > 0).all()
    assert len(divide(stations, np.full(101, 50.0), 8, True)) == 7


@pytest.mark.parametrize("gap", [0.05, 0.2, 1.0])
def test_nearly_touching_holes_mesh_in_good_quads_on_such_seeds(gap: float) -> None:
    curves = [*square(40), circle(14, 20, 5, 10), circle(24 + gap, 20, 5, 11)]
    rings: list[np.ndarray] = [np.empty((0, 2))]
    for i, (curve, sizes) in enumerate(zip(curves, gap_sizes(curves), strict=True)):
        seeds = np.concatenate([[0.0], divide(along(curve), sizes, 16 if i > 3 else 2, True)])
        points = np.column_stack([np.interp(seeds, along(curve), x) for x in curve.points.T])
        if i < 4:
            rings[0] = np.concatenate([rings[0], points])
        else:
            rings.append(points)
    plane = region(rings, (1, 2))
    mesh = mesh_region(plane, 2.0)
    assert_meshes(plane, mesh)
    assert len(mesh.triangles) == 0
    assert scaled_jacobian(mesh).min() >= 0.5
