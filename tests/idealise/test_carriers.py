"""Carriers: found again within the tolerance, exact on both of their surfaces, and measured by length."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.idealise.carriers import CarrierTable, Circle, Line, Traced, VertexTable, distance_to
from kernel.idealise.implicit import project
from kernel.idealise.intersections import intersection, march
from kernel.solid.surfaces import Axis, CylinderSurface, Plane, SphereSurface, plane_frame, signed_distance

X, Y, Z = np.eye(3)


def plane(normal, offset):
    frame = plane_frame(np.asarray(normal, float))
    return Plane(frame.normal, offset / float(np.linalg.norm(normal)), frame.u, frame.v)


def cylinder(point, direction, radius):
    frame = plane_frame(np.asarray(direction, float))
    return CylinderSurface(Axis(np.asarray(point, float), frame.normal, frame.u, frame.v), 0, radius)


@pytest.fixture
def table():
    return CarrierTable(tolerance=1e-4, reach=100.0)


def test_one_line_has_one_index_from_whichever_point_and_way_it_is_asked(table):
    first = table.line(np.array([1.0, 2, 3]), X + Y)
    assert table.line(np.array([11.0, 12, 3.00005]), -3 * (X + Y)) == first
    assert table.line(np.array([1.0, 2, 3.1]), X + Y) != first
    assert table.line(np.array([1.0, 2, 3]), X + 1.001 * Y) != first


def test_one_circle_has_one_index_whichever_way_its_normal_points(table):
    first = table.circle(X, Z, 5.0)
    assert table.circle(X + 1e-5 * Y, -Z, 5.00005) == first
    assert table.circle(X, Z, 5.1) != first
    assert table.circle(X, Y, 5.0) != first


@pytest.mark.parametrize("kind", ["line", "circle", "traced"])
def test_points_at_their_parameters_are_the_points(table, kind):
    if kind == "line":
        number = table.line(np.array([0, 3.0, 4]), X)
    elif kind == "circle":
        number = table.circle(np.array([0, 3.0, 4]), X + Y, 7.0)
    else:
        surfaces = [cylinder([0, 0, 0], Z, 10), cylinder([0, 0, 0], X, 4)]
        number = intersection(table, surfaces, 0, 1, np.array([[9.9, 0, 4]]))
    carrier = table[number]
    points = carrier.at(np.linspace(0.5, 6.5, 9))
    assert carrier.at(carrier.parameters(points)) == pytest.approx(points, abs=1e-9)
    assert distance_to(carrier, points) == pytest.approx(0, abs=1e-9)
    steps = np.linalg.norm(np.diff(carrier.at(np.linspace(1, 1.1, 11)), axis=0), axis=1)
    assert steps == pytest.approx(0.01, rel=1e-2)


def test_surfaces_of_one_axis_meet_in_a_circle_and_planes_in_a_line(table):
    surfaces = [cylinder([0, 0, 0], Z, 5), plane(Z, 7), plane(X, 3), SphereSurface(np.array([0, 0, 1.0]), 13)]
    found = table[intersection(table, surfaces, 0, 1, np.array([[5.0, 0, 7]]))]
    assert isinstance(found, Circle)
    assert found.centre == pytest.approx([0, 0, 7])
    assert isinstance(table[intersection(table, surfaces, 1, 2, np.array([[3.0, 0, 7]]))], Line)
    line = table[intersection(table, surfaces, 0, 2, np.array([[3.0, -4, 0]]))]
    assert isinstance(line, Line)
    assert line.point == pytest.approx([3, -4, 0])
    ring = table[intersection(table, surfaces, 0, 3, np.array([[5.0, 0, 13]]))]
    assert isinstance(ring, Circle)
    assert ring.centre == pytest.approx([0, 0, 13])


def test_a_hole_across_a_tube_is_traced_once_for_each_side(table):
    surfaces = [cylinder([0, 0, 0], Z, 10), cylinder([0, 0, 0], X, 4)]
    front = intersection(table, surfaces, 0, 1, np.array([[9.9, 0, 4]]))
    back = intersection(table, surfaces, 0, 1, np.array([[-9.9, 0, 4]]))
    assert front != back
    assert intersection(table, surfaces, 1, 0, np.array([[9.2, 4, 0]])) == front
    curve = table[front]
    assert isinstance(curve, Traced)
    points = curve.at(np.linspace(0, curve.period, 50))
    for surface in surfaces:
        assert np.abs(signed_distance(surface, points)).max() < 1e-12 * 100
    assert points[:, 0].min() > 9


def test_an_oblique_section_of_a_tube_is_an_ellipse():
    points, is_closed = march(cylinder([0, 0, 0], Z, 5), plane([1, 0, 1], 0), np.array([5.0, 0, -5]), 100.0)
    assert is_closed
    assert np.abs(points @ [1, 0, 1]).max() < 1e-12
    assert np.ptp(points @ [1, 0, -1]) / np.sqrt(2) == pytest.approx(2 * 5 * np.sqrt(2), rel=1e-3)


def test_an_open_curve_is_followed_both_ways():
    points, is_closed = march(plane(Z, 0), plane(X, 0), np.array([0.0, 3, 0]), 10.0)
    assert not is_closed
    assert np.ptp(points[:, 1]) == pytest.approx(20, rel=0.1)


def test_points_are_brought_onto_three_surfaces_at_once():
    surfaces = (plane(Z, 2), cylinder([0, 0, 0], Z, 5), plane(X, 3))
    assert project(np.array([[3.2, 3.5, 2.1]]), surfaces)[0] == pytest.approx([3, 4, 2])


def test_a_point_where_two_surfaces_touch_stays_there():
    found = project(np.array([[5.0, 0.0, 1.5]]), (cylinder([0, 0, 0], Z, 5), plane(X, 5), plane(Z, 2)))[0]
    assert found == pytest.approx([5, 0, 2])


def test_vertices_merge_within_the_tolerance_and_not_beyond():
    vertices = VertexTable(1e-3)
    first = vertices.add(np.array([1.0, 2, 3]))
    assert vertices.add(np.array([1.0, 2.0009, 3])) == first
    assert vertices.add(np.array([1.0, 2.0011, 3])) != first
    assert len(vertices.points) == 2
