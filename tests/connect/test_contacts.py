"""Joints: found from shared surfaces, whether segments touch or overlapped, and called by what they are."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.connect.contacts import find_joints
from kernel.connect.gaps import near_misses
from kernel.connect.joints import JOINT_KINDS, joints_by_segment
from kernel.csg.reader import read_model
from kernel.plan import Override
from kernel.segment.partition import partition
from kernel.solid.evaluate import evaluate
from rules.engine import load_rule_base

RULES = load_rule_base()


def joints_of(text, **overrides):
    evaluated = evaluate(read_model(text, "test"))
    pinned = {path.strip("_"): Override(kind) for path, kind in overrides.items()}
    segments = partition(evaluated, RULES.decide, pinned).segments
    return find_joints(segments, evaluated), {segment.id: segment for segment in segments}


def kinds(text, **overrides):
    joints, _ = joints_of(text, **overrides)
    assert {joint.kind for joint in joints} <= set(JOINT_KINDS)
    return sorted(joint.kind for joint in joints)


PLATE = "BLO(200,150,8)"

NAMED = {
    "tee": f"P = {PLATE} UN BLO(200,8,100) AT(MOVY=71, MOVZ=8)",
    "corner": f"P = {PLATE} UN BLO(200,8,100) AT(MOVZ=8)",
    "lap": f"P = {PLATE} UN BLO(200,150,6) AT(MOVX=150, MOVZ=8)",
    "step": f"P = {PLATE} UN BLO(200,150,12) AT(MOVX=200)",
    "end_on": "P = BLO(40,40,900) UN BLO(900,40,40) AT(MOVX=40, MOVZ=400)",
    "along": "P = BLO(1000,300,8) UN BLO(1000,20,20) AT(MOVY=140, MOVZ=8)",
    "pipe": "P = (BLO(300,300,10) AT(MOVX=-150, MOVY=-150) UN CYL(60,200)) DIF CYL(55,300) AT(MOVZ=-5)",
    "face": "P = BLO(300,300,10) UN CYL(35,60) AT(MOVX=150, MOVY=150, MOVZ=10)",
}


@pytest.mark.parametrize("kind", NAMED)
def test_joints_are_called_by_what_they_are(kind):
    assert set(kinds(NAMED[kind] + "\n")) == {kind}


def test_plates_that_run_through_one_another_cross():
    assert "cross" in kinds("P = BLO(200,8,200) AT(MOVY=96) UN BLO(200,200,6) AT(MOVZ=97)\n")


@pytest.mark.parametrize("gap", [0, -20])
def test_touching_and_overlapping_blocks_share_the_same_patch(gap):
    text = f"P = BLO(100,100,100) UN BLO(40,40,300) AT(MOVX=30, MOVY=30, MOVZ={100 + gap})\n"
    joints, _ = joints_of(text, _0="brick", _1="beam")
    top = [joint for joint in joints if abs(joint.normal[2]) > 0.9]
    assert sum(joint.area for joint in top) == pytest.approx(1600)
    assert joints[0].centre[:2] == pytest.approx([50, 50])


def test_the_normal_points_out_of_the_first_segment_into_the_second():
    joints, segments = joints_of(NAMED["tee"] + "\n")
    (joint,) = joints
    middles = [segments[name].solid.bounds.mean(axis=0) for name in joint.segments]
    assert (middles[1] - middles[0]) @ joint.normal > 0
    assert np.linalg.norm(joint.normal) == pytest.approx(1)


def test_blocks_that_meet_along_an_edge_alone_are_not_joined():
    assert kinds("P = BLO(100,100,100) UN BLO(100,100,100) AT(MOVX=100, MOVY=100)\n", _0="brick", _1="brick") == []


def test_a_peg_in_a_hole_touches_on_the_cylinder():
    text = (
        "P = (BLO(200,200,60) DIF CYL(30,80) AT(MOVX=100, MOVY=100, MOVZ=-10)) UN CYL(30,60) AT(MOVX=100, MOVY=100)\n"
    )
    joints, _ = joints_of(text, _0="brick", _1="brick")
    (joint,) = joints
    assert joint.area == pytest.approx(2 * np.pi * 30 * 60)


def test_a_pipes_patch_has_the_rings_area():
    joints, _ = joints_of(NAMED["pipe"] + "\n")
    assert sum(joint.area for joint in joints) > 0
    ring = max((joint for joint in joints if abs(joint.normal[2]) > 0.9), key=lambda joint: joint.area, default=None)
    if ring is not None:
        assert ring.area == pytest.approx(np.pi * (60**2 - 55**2), rel=2e-3)


def test_joints_are_numbered_and_listed_by_segment():
    joints, segments = joints_of("P = BLO(400,300,200) DIF BLO(388,288,188) AT(MOVX=6, MOVY=6, MOVZ=6)\n")
    assert [joint.id for joint in joints] == [f"j{k + 1}" for k in range(12)]
    listed = joints_by_segment(joints)
    assert {name: len(of_one) for name, of_one in listed.items()} == dict.fromkeys(segments, 4)


def test_shuffled_operands_give_the_same_joints():
    one, _ = joints_of("P = BLO(40,40,900) UN BLO(900,40,40) AT(MOVX=40, MOVZ=400)\n")
    other, _ = joints_of("P = BLO(900,40,40) AT(MOVX=40, MOVZ=400) UN BLO(40,40,900)\n")
    assert [(joint.kind, joint.area) for joint in one] == [(joint.kind, joint.area) for joint in other]


@pytest.mark.parametrize(("gap", "is_told"), [(0.0, False), (0.5, True), (20.0, False)])
def test_a_gap_a_little_over_the_tolerance_is_told(gap, is_told):
    evaluated = evaluate(
        read_model(f"P = BLO(100,100,100) UN BLO(40,40,900) AT(MOVX=30, MOVY=30, MOVZ={100 + gap})\n", "t")
    )
    segments = partition(evaluated, RULES.decide).segments
    told = near_misses(segments, evaluated, find_joints(segments, evaluated))
    assert bool(told) == is_told
    if is_told:
        assert told[0].endswith(
            "are 0.5 apart over an area of 1.6e+03: they are not joined (a stated gap of 0.5 would join them)"
        )
