"""Contacts on cones, spheres and tori, and the ties there."""

from __future__ import annotations

import numpy as np
import pytest
from assembling import RULES, WHOLE, assembled, audit, rod, turned, union
from shapely.errors import GEOSException

from kernel.connect.contacts import find_joints
from kernel.csg.reader import read_model
from kernel.errors import MeshError
from kernel.segment.partition import partition
from kernel.solid.charts import POLE, cover, flat_faces, flatten, lift
from kernel.solid.evaluate import evaluate
from kernel.solid.surfaces import Axis, ConeSurface, SphereSurface, TorusSurface

AXIS = Axis(np.array([1.0, 2.0, 0.0]), *np.eye(3)[[2, 0, 1]])
CURVED = {
    "cone": ConeSurface(AXIS, 0, np.array([1.0, 2.0, 5.0]), -0.7),
    "sphere": SphereSurface(np.array([3.0, -1.0, 2.0]), 4.0),
    "torus": TorusSurface(AXIS, 0, np.array([1.0, 2.0, 3.0]), 6.0, 2.0),
}
BALL = "SPH(R=20)"
TORUS = "TOR(RMAJ=50, RMIN=15)"
CONE = "CON(R1=60, R2=40, H=100)"
PLATE = "(BLO(200, 200, 6) AT (MOVX=-100, MOVY=-100, MOVZ=-3))"
TOUCHING = {
    "ball at a rod's end": (f"CYL(R=5, H=200) UN ({BALL} AT (MOVZ=210))", "SphereSurface", 1),
    "ball in the middle of a rod": (f"(CYL(R=5, H=400) AT (MOVZ=-200)) UN {BALL}", "SphereSurface", 2),
    "ball through a plate": (f"{PLATE} UN {BALL}", "SphereSurface", 1),
    "ball half in a block": (f"(BLO(90, 90, 90) AT (MOVX=-45, MOVY=-45, MOVZ=-90)) UN {BALL}", "Plane", 1),
    "rod into a cone's side": (f"{CONE} UN (CYL(R=5, H=200) AT (ROTY=90, MOVX=20, MOVZ=50))", "ConeSurface", 1),
    "cone through a plate": (f"({PLATE} AT (MOVZ=40)) UN {CONE}", "ConeSurface", 1),
    "block into a cone": (f"{CONE} UN (BLO(60, 60, 60) AT (MOVX=30, MOVY=-30, MOVZ=20))", "ConeSurface", 1),
    "rod into a torus": (f"{TORUS} UN (CYL(R=4, H=200) AT (ROTY=90, MOVX=50))", "TorusSurface", 1),
    "torus through a plate": (f"{PLATE} UN {TORUS}", "TorusSurface", 2),
}


@pytest.mark.parametrize("name", CURVED)
def test_a_chart_leads_back_to_the_point(name):
    surface = CURVED[name]
    angles = np.random.default_rng(3).uniform(-3, 3, (40, 2))
    if name == "cone":
        flat = flatten(surface, lift(surface, np.abs(angles) * (1, 0.2)))
        assert flat == pytest.approx(np.abs(angles) * (1, 0.2))
    else:
        assert flatten(surface, lift(surface, angles)) == pytest.approx(angles)


def test_a_spheres_chart_keeps_areas_and_leaves_out_the_face_that_it_tears():
    sphere = CURVED["sphere"]
    far = sphere.centre - 4.0 * POLE.normal
    torn = far + 0.1 * np.array([POLE.u, -0.5 * POLE.u + POLE.v, -0.5 * POLE.u - POLE.v])
    whole = sphere.centre + 4.0 * POLE.normal + 0.1 * np.array([POLE.u, POLE.v, -POLE.u])
    assert flat_faces(sphere, np.array([torn, whole]))[1].tolist() == [False, True]
    assert cover(sphere, np.array([torn, whole])).area == pytest.approx(0.01, rel=1e-3)


@pytest.mark.parametrize("name", TOUCHING)
def test_what_touches_is_a_joint_on_the_surface_that_cut_the_other(name):
    text, kind, count = TOUCHING[name]
    evaluated = evaluate(read_model(f"UNITS mm\nM = {text}\n", "test"))
    joints = find_joints(partition(evaluated, RULES.decide, {}).segments, evaluated)
    table = evaluated.solid.surfaces.surfaces
    assert [type(table[joint.surface]).__name__ for joint in joints] == [kind] * count


@pytest.mark.parametrize("name", ["ball at a rod's end", "ball through a plate"])
def test_a_ball_is_tied_to_what_it_touches(name):
    assembly, _ = assembled(f"UNITS mm\nM = {TOUCHING[name][0]}\n", size=20.0)
    assert audit(assembly).components == 1
    assert audit(assembly).free == 0


def test_three_rods_from_one_point_are_tied_there():
    rods = [rod(200, 5, turn=turned("y", angle)) for angle in (0, 60, 120)]
    assembly, _ = assembled(union(*rods), size=20.0)
    found = audit(assembly)
    assert (found.components, found.free) == (WHOLE.components, WHOLE.free)
    ends = [len(np.unique([*tie.dependent, *tie.independent])) for tie in assembly.ties]
    assert set(ends) == {2}


def test_pipes_one_inside_the_other_are_partitioned_whatever_rounding_leaves_in_their_faces():
    outer, inner = ("(CYL(R=50, H=300) DIF CYL(R=47, H=300))", "(CYL(R=47, H=300) DIF CYL(R=44, H=300))")
    evaluated = evaluate(read_model(f"UNITS mm\nM = {outer} UN ({inner} AT (MOVZ=250))\n", "test"))
    segments = partition(evaluated, RULES.decide, {}).segments
    assert [joint.kind for joint in find_joints(segments, evaluated)] == ["lap"]


def test_areas_that_cannot_be_joined_are_an_error_that_names_the_node(monkeypatch):
    def refuse(*_):
        raise GEOSException("side location conflict")

    monkeypatch.setattr("kernel.segment.numbering.shape_of", refuse)
    with pytest.raises(MeshError, match=r"^/.*faces cannot be joined as areas"):
        partition(evaluate(read_model("UNITS mm\nM = BLO(90, 90, 90)\n", "test")), RULES.decide, {})
