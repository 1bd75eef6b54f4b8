"""Spans on carriers become curves: cut once for all faces, boundary before imprint, closed carriers with vertices."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.idealise.topology import BOUNDARY, IMPRINT, Span, Topology

X, Y, Z = np.eye(3)


@pytest.fixture
def topology():
    return Topology(tolerance=1e-6, reach=10.0)


def along(topology, number, start, end):
    return tuple(topology.carrier(number).at(np.array([start, end])))


def test_faces_that_overlap_on_a_line_share_the_piece_between(topology):
    line = topology.carriers.line(np.zeros(3), X)
    topology.add_span(line, Span(0, 0.0, 6.0, BOUNDARY, True), along(topology, line, 0.0, 6.0))
    topology.add_span(line, Span(1, 4.0, 9.0, IMPRINT, True), along(topology, line, 4.0, 9.0))
    found = [(curve.start, curve.end, sorted(curve.uses)) for curve in topology.curves()]
    assert found == [(0.0, 4.0, [0]), (4.0, 6.0, [0, 1]), (6.0, 9.0, [1])]


def test_a_boundary_counts_before_an_imprint_of_the_same_face(topology):
    line = topology.carriers.line(np.zeros(3), X)
    topology.add_span(line, Span(0, 0.0, 6.0, IMPRINT, True), along(topology, line, 0.0, 6.0))
    topology.add_span(line, Span(0, 0.0, 6.0, BOUNDARY, False), along(topology, line, 0.0, 6.0))
    (curve,) = topology.curves()
    assert (curve.uses[0].role, curve.uses[0].forward) == (BOUNDARY, False)


def test_a_circle_without_cuts_gets_two_vertices(topology):
    circle = topology.carriers.circle(np.zeros(3), Z, 2.0)
    topology.add_span(circle, Span(0, 0.0, 4 * np.pi, BOUNDARY, True, whole=True))
    curves = topology.curves()
    assert [curve.length for curve in curves] == pytest.approx([2 * np.pi, 2 * np.pi])
    assert curves[0].vertices == curves[1].vertices[::-1]


def test_a_stretch_over_the_seam_of_a_circle_is_one_curve(topology):
    circle = topology.carriers.circle(np.zeros(3), Z, 1.0)
    topology.add_span(circle, Span(0, 6.0, 7.0, BOUNDARY, True), along(topology, circle, 6.0, 7.0))
    (curve,) = topology.curves()
    assert curve.length == pytest.approx(1.0)


def test_cuts_nearer_than_the_tolerance_are_one(topology):
    line = topology.carriers.line(np.zeros(3), X)
    topology.add_span(line, Span(0, 0.0, 6.0, BOUNDARY, True), along(topology, line, 0.0, 6.0))
    for value in (3.0, 3.0 + 5e-7):
        topology.cut(line, value, topology.carrier(line).at(np.array([value]))[0])
    assert len(topology.curves()) == 2


def test_carriers_that_cross_share_the_vertex(topology):
    one, other = topology.carriers.line(np.zeros(3), X), topology.carriers.line(np.zeros(3), Y)
    for number in (one, other):
        topology.add_span(number, Span(0, -1.0, 1.0, BOUNDARY, True), along(topology, number, -1.0, 1.0))
        topology.cut(number, 0.0, np.zeros(3))
    vertices = [vertex for curve in topology.curves() for vertex in curve.vertices]
    assert len(topology.vertices.points) == 5
    assert max(vertices.count(vertex) for vertex in vertices) == 4
