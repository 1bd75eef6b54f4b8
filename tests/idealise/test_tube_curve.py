"""Curves of tubes of nearly equal radius: exact on both tubes, by length, with corners where the radii are equal."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.idealise.carriers import CarrierTable
from kernel.idealise.intersections import intersection
from kernel.idealise.tube_curve import SHARP, pinched, slab_sides, slab_stations, tube_curve, tube_frame
from kernel.solid.surfaces import Axis, CylinderSurface, plane_frame, signed_distance

TOLERANCE = 1e-6
RUN = (0.0, 0.0, 1.0)


def cylinder(direction, radius, point=(0.0, 0.0, 0.0)):
    frame = plane_frame(np.asarray(direction, float))
    return CylinderSurface(Axis(np.asarray(point, float), frame.normal, frame.u, frame.v), 0, radius)


PAIRS = {
    "square, equal": (cylinder(RUN, 10), cylinder((1, 0, 0), 10, (3, 0, 2))),
    "oblique, equal": (cylinder(RUN, 10), cylinder((1, 0, 0.7), 10, (3, 0, 2))),
    "mirrored, equal": (cylinder(RUN, 10), cylinder((-1, 0, -2), 10)),
    "a thousandth less": (cylinder(RUN, 10), cylinder((1, 0.3, 0.7), 9.99)),
    "five hundredths less": (cylinder(RUN, 10), cylinder((1, 0, -0.7), 9.5)),
    "beside the axis": (cylinder(RUN, 10), cylinder((1, 0, 1), 9.7, (0, 0.2, 0))),
}


@pytest.fixture(params=PAIRS)
def frame(request):
    return tube_frame(*PAIRS[request.param], TOLERANCE)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_every_point_lies_on_both_tubes_and_has_its_parameter(frame, side):
    curve = tube_curve(frame, side)
    stations = np.linspace(0, curve.period, 1000, endpoint=False)
    points = curve.at(stations)
    for surface in curve.surfaces:
        assert np.abs(signed_distance(surface, points)).max() < 1e-12
    assert curve.parameters(points) == pytest.approx(stations, abs=1e-10)
    assert frame.sign(points) == side


def test_parameters_are_lengths_up_to_the_bends(frame):
    curve = tube_curve(frame, 1.0)
    bottom, top = curve.bends
    for low, high in ((bottom, top), (top, curve.period)):
        points = curve.at(np.linspace(low, high, 20_001)[1:-1])
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        assert steps == pytest.approx((high - low) / 20_000, rel=2e-3)


def test_curves_of_equal_tubes_are_two_ellipses_that_cross_in_corners():
    frame = tube_frame(*PAIRS["oblique, equal"], TOLERANCE)
    one, other = (tube_curve(frame, side) for side in (1.0, -1.0))
    assert one.at(np.array(one.bends)) == pytest.approx(other.at(np.array(other.bends)), abs=1e-12)
    assert np.ptp(one.at(np.array(one.bends)), axis=0) == pytest.approx([0, 20, 0], abs=1e-9)
    lobe = one.at(np.linspace(*one.bends, 200))
    flat = np.linalg.svd(lobe - lobe.mean(axis=0))[1]
    assert flat[2] < 1e-10 * flat[0]


def test_the_two_asked_for_either_way_round_share_their_curves():
    table = CarrierTable(tolerance=TOLERANCE, reach=100.0)
    surfaces = list(PAIRS["square, equal"])
    front = intersection(table, surfaces, 0, 1, np.array([[7.0, 6, 9]]))
    assert intersection(table, surfaces, 1, 0, np.array([[-7.0, 6, 9]])) == front
    assert intersection(table, surfaces, 1, 0, np.array([[7.0, 6, -5]])) != front
    assert tube_frame(*surfaces, TOLERANCE).least_sine < SHARP


@pytest.mark.parametrize("place", [0, 1])
def test_sides_of_a_slab_lie_on_the_one_tube_and_half_a_wall_from_the_other(frame, place):
    tubes = (frame.small, frame.large)
    curve = tube_curve(frame, -1.0)
    stations = slab_stations(curve, tubes[place], 0.25, 0.0, curve.period)
    sides = slab_sides(curve, tubes[place], curve.at(stations), 0.25)
    for side, away in zip(sides, (-0.25, 0.25)):
        assert np.abs(signed_distance(tubes[place], side)).max() < 1e-9
        off = np.abs(signed_distance(tubes[1 - place], side) - away)
        stands = off < 1e-9
        assert stands.mean() > 0.4  # the rest runs on along the line midway between the two curves
        assert off[~stands].max(initial=0.0) < 0.75


def test_tubes_that_do_not_pass_through_one_another_have_no_frame():
    assert tube_frame(cylinder(RUN, 10), cylinder((1, 0, 0), 8, (0, 3, 0)), TOLERANCE) is None
    assert tube_frame(cylinder(RUN, 10), cylinder((0, 0.1, 1), 8), TOLERANCE) is None


def test_pinched_tubes_meet_in_corners_on_the_smaller_one():
    frame = pinched(tube_frame(*PAIRS["beside the axis"], TOLERANCE))
    corners = [tube_curve(frame, side).at(np.zeros(1)) for side in (1.0, -1.0)]
    assert corners[0] == pytest.approx(corners[1], abs=1e-12)
    assert frame.pinch == pytest.approx(0.5)
    assert np.abs(signed_distance(frame.small, corners[0])).max() < 1e-12
