"""Surfaces, the table that gives them ids, and the choice of the working frame."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from trees import at, turned

from kernel.solid.frame import PlacedLeaf, choose_frame, nearest_turn, signed_permutations
from kernel.solid.lathe import unit_circle
from kernel.solid.surfaces import (
    Axis,
    ConeSurface,
    CylinderSurface,
    FacetedSurface,
    Plane,
    SphereSurface,
    TorusSurface,
    outward,
    plane_frame,
    project,
    signed_distance,
)
from kernel.solid.table import PointIndex, SurfaceTable, snap_to

X, Y, Z = np.eye(3)
AXIS = Axis(np.array([1.0, 2.0, 0.0]), Z, X, Y)
SURFACES = [
    Plane(Z, 0.5, X, Y),
    CylinderSurface(AXIS, 0, 2.0),
    ConeSurface(AXIS, 0, np.array([1.0, 2.0, -9.0]), 0.4),
    ConeSurface(AXIS, 0, np.array([1.0, 2.0, 9.0]), -0.4),
    SphereSurface(np.array([1.0, 1, 1]), 3.0),
    TorusSurface(AXIS, 0, np.array([1.0, 2.0, 1.0]), 4.0, 1.5),
]


@pytest.mark.parametrize("surface", SURFACES, ids=lambda surface: type(surface).__name__)
def test_normals_are_the_gradient_of_the_distance_and_projection_lands_on_the_surface(surface) -> None:
    points = np.random.default_rng(1).uniform(-3, 3, (50, 3))
    step = 1e-6
    gradient = np.stack(
        [
            (signed_distance(surface, points + step * e) - signed_distance(surface, points - step * e)) / (2 * step)
            for e in np.eye(3)
        ],
        axis=1,
    )
    assert gradient == pytest.approx(outward(surface, points), abs=1e-6)
    assert np.abs(signed_distance(surface, project(surface, points))).max() < 1e-12


def test_a_faceted_surface_has_no_form() -> None:
    surface = FacetedSurface("test")
    points = np.ones((2, 3))
    assert project(surface, points) is points
    for ask in (signed_distance, outward):
        with pytest.raises(ValueError, match="no analytic"):
            ask(surface, points)


@settings(max_examples=50)
@given(st.tuples(*[st.floats(-1, 1)] * 3).filter(lambda n: np.linalg.norm(n) > 1e-3))
def test_plane_frames_are_right_handed(normal) -> None:
    frame = plane_frame(np.array(normal))
    assert np.cross(frame.u, frame.v) == pytest.approx(frame.normal, abs=1e-12)
    assert np.stack(frame) @ np.stack(frame).T == pytest.approx(np.eye(3), abs=1e-12)


def test_the_two_sides_of_a_plane_have_one_id() -> None:
    table = SurfaceTable(1e-6)
    assert table.plane(Z, 2.0) == table.plane(-3 * Z, -6.0) == table.plane(Z, 2.0 + 5e-7)
    assert table.plane(Z, 2.0 + 3e-6) != table.plane(Z, 2.0)
    assert table.plane(Z, -2.0) != table.plane(Z, 2.0)
    assert table.find_plane(Y, 0.0) is None
    assert len(table.surfaces) == 3


def test_planes_through_given_points_take_their_offset_from_them() -> None:
    table = SurfaceTable(1e-5, size=10.0)
    first = table.plane(Z, 1.0)
    tilted = np.array([1e-6, 0.0, 1.0])
    assert table.plane(tilted, 0.0, through=np.array([[5.0, 0, 1.0], [5.0, 1, 1.0]])) == first


def test_lines_with_one_place_are_one_axis_whichever_way_they_run() -> None:
    table = SurfaceTable(1e-6)
    direction = np.array([1.0, 2.0, 3.0])
    point = np.array([4.0, 5.0, 6.0])
    first = table.axis(point, direction)
    assert table.axis(point + 7 * direction, -2 * direction) == first
    assert table.axis(point + np.array([1e-3, 0, 0]), direction) != first
    axis = table.axes[first]
    assert np.cross(axis.x, axis.y) == pytest.approx(axis.direction)
    assert table.cylinder(first, 2.0) == table.cylinder(first, 2.0 + 5e-7)
    assert table.find_cylinder(first, 2.0 - 5e-7) == 2.0
    assert table.find_cylinder(first, 2.1) is None


def test_round_surfaces_are_found_again() -> None:
    table = SurfaceTable(1e-6)
    axis = table.axis(np.zeros(3), Z)
    assert table.cone(axis, 1.0, 0.5) == table.cone(axis, 1.0, 0.5)
    assert table.cone(axis, 1.0, -0.5) != table.cone(axis, 1.0, 0.5)
    assert table.sphere(X, 1.0) == table.sphere(X + 1e-7, 1.0)
    assert table.sphere(X, 1.1) != table.sphere(X, 1.0)
    assert table.torus(axis, 0.0, 3.0, 1.0) == table.torus(axis, 0.0, 3.0, 1.0)
    assert table.other("one") != table.other("one")


@settings(max_examples=50)
@given(
    st.lists(st.tuples(*[st.floats(-5, 5)] * 2), min_size=1, max_size=30, unique=True),
    st.tuples(*[st.floats(-1, 1)] * 2),
)
def test_the_point_index_finds_what_a_search_through_all_finds(points, shift) -> None:
    index = PointIndex(0.5)
    for number, point in enumerate(points):
        index.add(point, number)
    wanted = (points[0][0] + shift[0], points[0][1] + shift[1])
    distances = [max(abs(a - b) for a, b in zip(point, wanted)) for point in points]
    found = index.find(wanted)
    if min(distances) > 0.5:
        assert found is None
    else:
        assert found is not None and distances[found] == min(distances)


def test_snapping_keeps_the_first_number() -> None:
    values: list[float] = []
    assert snap_to(values, 1.0, 1e-3) == 1.0
    assert snap_to(values, 1.0005, 1e-3) == 1.0
    assert snap_to(values, 2.0, 1e-3) == 2.0
    assert values == [1.0, 2.0]


def test_the_frame_is_that_of_most_volume() -> None:
    lean = turned([1, 2, 3], 40)
    leaves = [PlacedLeaf(at(linear=lean), 5.0, False), PlacedLeaf(at(), 1.0, False)]
    frame = choose_frame(leaves, 1e-6, 1e-9)
    assert np.abs(frame.rotation.T @ lean).max(axis=0) == pytest.approx(np.ones(3))
    assert np.linalg.det(frame.rotation) == pytest.approx(1.0)
    assert len(frame.families) == 2
    assert np.array_equal(choose_frame(leaves[1:] * 9, 1e-6, 1e-9).rotation, np.eye(3))


def test_right_angles_and_mirrors_are_one_family() -> None:
    lean = turned([1, 2, 3], 40)
    leaves = [
        PlacedLeaf(at(linear=lean @ turn @ mirror), 1.0, False)
        for turn in signed_permutations()[:7]
        for mirror in (np.eye(3), np.diag([1.0, -1, 1]))
    ]
    assert len(choose_frame(leaves, 1e-6, 1e-9).families) == 1


def test_a_cylinder_joins_the_family_of_its_axis() -> None:
    frame = choose_frame(
        [PlacedLeaf(at(), 1.0, False), PlacedLeaf(at(linear=turned([0, 0, 1], 33)), 9.0, True)], 1e-6, 1e-9
    )
    assert len(frame.families) == 1
    placed = frame.place(at(1, 2, 3, turned([0, 0, 1], 33)), 1e-9)
    assert placed.axis_of_z == 2 and not placed.is_square
    assert np.array_equal(placed.linear[:, 2], Z)


def test_axes_that_are_nearly_square_are_made_square() -> None:
    frame = choose_frame([PlacedLeaf(at(), 1.0, False)], 1e-3, 2e-6)
    nearly = np.eye(3) + 1e-6 * np.array([[0, 1, -1], [-1, 0, 1], [1, -1, 0]])
    assert np.array_equal(frame.place(at(linear=nearly), 2e-6).linear, np.eye(3))
    skew = turned([0, 0, 1], 10)
    assert frame.place(at(linear=turned([1, 1, 1], 10)), 2e-6).family is None
    assert frame.place(at(linear=skew), 2e-6).linear == pytest.approx(skew)


def test_the_nearest_turn_names_axes_so_that_little_turns() -> None:
    for turn in signed_permutations():
        assert np.array_equal(nearest_turn(turn), np.eye(3))
    lean = turned([0, 0, 1], 80)
    assert nearest_turn(lean) == pytest.approx(turned([0, 0, 1], -10))


@pytest.mark.parametrize("count", [4, 7, 12, 96, 160])
def test_the_unit_circle_is_symmetric(count) -> None:
    cosine, sine = unit_circle(count)
    angles = 2 * math.pi * np.arange(count) / count
    assert cosine == pytest.approx(np.cos(angles), abs=1e-15 * 4)
    assert sine == pytest.approx(np.sin(angles), abs=1e-15 * 4)
    if count % 4 == 0:
        assert np.array_equal(np.sort(cosine), np.sort(-sine))
        assert cosine[count // 4] == 0.0 and sine[0] == 0.0
