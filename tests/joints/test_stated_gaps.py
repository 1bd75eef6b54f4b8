"""Gaps: told of where they are small, and joined across where they are stated."""

from __future__ import annotations

import re

import numpy as np
import pytest
import shapely
from solids import cube, placed, rod, tube, union
from test_catalogue import any_turn
from verification.solvers import run_mystran
from weighing import holding_nodes

from app.pipeline import classify, mesh
from kernel.connect.gaps import near_misses
from kernel.connect.parallels import carried, levels
from kernel.connect.sides import FaceSide
from kernel.csg.reader import read_model
from kernel.deck.nastran import nastran_self_weight
from kernel.errors import OptionError
from kernel.mesh.options import MeshOptions
from kernel.solid.surfaces import Plane, plane_frame

GAP = 0.15
APART = {
    "plates edge to edge": (union(cube(100, 120, 8), cube(100, 80, 8, (100 + GAP, 20, 0))), "edge", 640.0),
    "tee": (union(cube(200, 150, 10), cube(200, 8, 100, (0, 71, 10 + GAP))), "tee", 1600.0),
    "lap": (union(cube(200, 100, 8), cube(200, 100, 6, (150, 0, 8 + GAP))), "lap", 5000.0),
    "post on a plate": (union(cube(300, 300, 10), cube(30, 30, 400, (135, 135, 10 + GAP))), "end_on", 900.0),
    "stiffener on a plate": (union(cube(500, 200, 8), cube(500, 20, 20, (0, 90, 8 + GAP))), "along", 10000.0),
    "beam on a beam": (union(cube(900, 40, 40), cube(30, 400, 30, (435, 40 + GAP, 5))), "end_on", 900.0),
    "beam on a brick": (union(cube(120, 120, 120), cube(30, 30, 400, (45, 45, 120 + GAP))), "end_on", 900.0),
    "brick on a plate": (union(cube(300, 300, 10), cube(80, 80, 60, (110, 110, 10 + GAP))), "face", 6400.0),
    "brick on a brick": (union(cube(120, 120, 60), cube(50, 50, 50, (30, 40, 60 + GAP))), "face", 2500.0),
    "plate's edge on a brick": (union(cube(150, 120, 80), cube(150, 10, 150, (0, 55, 80 + GAP))), "face", 1500.0),
    "pipe on a plate": (union(cube(240, 240, 8, (-120, -120, -8)), tube(200, 60, 56, (0, 0, GAP))), "pipe", 1457.7),
    "rod in a sleeve": (union(tube(200, 60, 56), rod(60, 56 - GAP, (0, 0, 70))), "face", 2 * np.pi * 56 * 60),
}


def classified_of(text: str, gap: float = 0.0, turn: np.ndarray | None = None):
    text = text if turn is None else placed(text, (5.0, 4.0, 3.0), turn)
    return classify(read_model(text, "apart"), gap=gap)


@pytest.mark.parametrize("turn", [None, any_turn(8)], ids=["straight", "turned"])
@pytest.mark.parametrize("name", APART)
def test_a_small_gap_is_told_with_its_size_and_the_segments(name, turn):
    text, _, area = APART[name]
    found = classified_of(text, turn=turn)
    assert found.joints == ()
    (line,) = near_misses(found.partition.segments, found.evaluated, found.joints)
    assert {"s1", "s2"} <= set(line.split())
    told = re.search(r"are (\S+) apart over an area of (\S+):", line)
    assert told is not None
    assert float(told[1]) == pytest.approx(GAP, rel=1e-2)
    assert float(told[2]) == pytest.approx(area, rel=1e-2)
    assert f"a stated gap of {GAP:.3g}" in line


@pytest.mark.solver
@pytest.mark.parametrize("turn", [None, any_turn(8)], ids=["straight", "turned"])
@pytest.mark.parametrize("name", APART)
def test_a_stated_gap_is_joined_across(name, turn, tmp_path):
    text, kind, area = APART[name]
    found = classified_of(text, gap=GAP * 1.001, turn=turn)
    assert {joint.kind for joint in found.joints} == {kind}
    assert sum(joint.area for joint in found.joints) == pytest.approx(area, rel=2e-3)
    assert [joint.gap for joint in found.joints] == pytest.approx([GAP] * len(found.joints))
    meshed = mesh(found, MeshOptions(size=10.0 if name == "rod in a sleeve" else 20.0))
    assert meshed.checks.passed, meshed.checks.failures
    assert meshed.checks.components == 1
    assert len(meshed.model.couplings) > 0
    assert not any("apart over" in warning for warning in meshed.warnings)
    model = meshed.model
    solved = run_mystran(nastran_self_weight(model, holding_nodes(model)), tmp_path, model.mesh.n_node)
    assert solved.epsilon < 1e-6
    assert solved.reactions[:, 2].sum() == pytest.approx(meshed.checks.model_mass * 9806.65, rel=1e-3)


def test_a_gap_wider_than_the_stated_one_stays_open():
    found = classified_of(APART["tee"][0], gap=0.5 * GAP)
    assert found.joints == ()


@pytest.mark.parametrize("gap", [-1.0, float("nan"), 8.0])
def test_a_gap_that_swallows_a_wall_is_refused(gap):
    with pytest.raises(OptionError, match=r"gap is .*, (expected 0 or more|but s2 is only 8 thick)"):
        classified_of(APART["tee"][0], gap=gap)


def test_planes_on_both_sides_of_a_rounding_boundary_are_parallel():
    normals = [np.array([0.6000005 + shift, 0.0, 0.0]) for shift in (-1e-9, 1e-9)]
    normals = [normal + (0, 0, np.sqrt(1 - normal @ normal)) for normal in normals]
    tilted = np.array([np.sin(np.arcsin(0.6000005) + 1e-3), 0.0, 0.0])
    planes = []
    for normal, offset in (
        (normals[0], 5.0),
        (-normals[1], -5.1),
        (tilted + (0, 0, np.sqrt(1 - tilted @ tilted)), 5.0),
    ):
        frame = plane_frame(normal)
        planes.append(Plane(frame.normal, offset, frame.u, frame.v))
    box = np.array([(0.0, 0.0, 0.0), (10.0, 10.0, 5.0)])
    one, other, third = levels([FaceSide(k, k, 1, box) for k in range(3)], planes)
    assert one.group == other.group != third.group
    assert one.side == -other.side
    assert one.side * (other.at - one.at) == pytest.approx(0.1, abs=1e-6)
    square = shapely.box(1, 2, 3, 5)
    assert carried(carried(square, planes[0], planes[1]), planes[1], planes[0]).equals_exact(square, 1e-6)
