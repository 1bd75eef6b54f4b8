"""What chords cut off a section, by the formula and by polygons."""

import math

import pytest
from shapely import Point

from kernel.csg.reader import read_model
from kernel.idealise.brick import section_of
from kernel.idealise.roundness import roundness
from kernel.idealise.sheets import plane_sheet_at
from kernel.idealise.topology import Topology
from kernel.segment.partition import partition
from kernel.solid.evaluate import evaluate
from kernel.solid.surfaces import plane_frame
from rules.engine import load_rule_base

CHORDS = 240


def circles_of(text):
    """(area, [(roundness, radius)]) of the section of the one brick."""
    evaluated = evaluate(read_model(text, "test"))
    (segment,) = partition(evaluated, load_rule_base().decide).segments
    frame = plane_frame([0, 0, 1])
    sheet = plane_sheet_at(frame.normal, 1.0, frame.u, frame.v, evaluated.solid.surfaces)
    topology = Topology(1e-6 * evaluated.size, evaluated.size)
    rings, polygon = section_of(topology, segment, sheet, 1.0)
    found = roundness(topology, sheet, rings, polygon.area)
    return polygon.area, sorted((topology.carrier(k).radius, value) for k, value in found.items())


def polygon_loss(outer, inner, area):
    """Share of the area that chords cut off."""
    sides = [Point(0, 0).buffer(r, quad_segs=CHORDS // 4).area if r else 0.0 for r in (outer, inner)]
    return 1 - (sides[0] - sides[1]) / area


@pytest.mark.parametrize(("outer", "inner"), [(10, 0), (10, 6), (10, 9.5)])
def test_a_disc_and_a_tube_lose_the_same_share_however_thin_the_tube(outer, inner):
    solid = f"CYL(R={outer}, H=4)" if inner == 0 else f"CYL(R={outer}, H=4) DIF (CYL(R={inner}, H=6) AT (MOVZ=-1))"
    _, circles = circles_of(f"A = {solid}\nOUT A\n")
    area = math.pi * (outer**2 - inner**2)
    radius, value = circles[-1]
    assert radius == pytest.approx(outer) and value == pytest.approx(2, rel=2e-3)
    assert value * (2 * math.pi / CHORDS) ** 2 / 12 == pytest.approx(polygon_loss(outer, inner, area), rel=2e-3)


def test_a_small_hole_hardly_counts():
    _, circles = circles_of("A = BLO(60, 60, 30) DIF (CYL(R=2, H=40) AT (MOVX=30, MOVY=30, MOVZ=-1))\nOUT A\n")
    assert circles == [(pytest.approx(2), pytest.approx(2 * math.pi * 4 / (3600 - 4 * math.pi), rel=1e-3))]
