"""What must not change the answer: rigid motion, mirror, scale, order of operands, six-digit matrices."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from moving import moved, rigid, scaled_answer, shuffled
from segmenting import is_answer, plain_decide, told

from kernel.csg.reader import read_file
from kernel.segment.partition import partition
from kernel.solid.evaluate import evaluate
from kernel.solid.solid import intersect

CASES = Path(__file__).parents[1] / "cases"
EXPECTED = json.loads((CASES / "expected.json").read_text())
angle = st.floats(-3.1, 3.1)
shift = st.floats(-2000, 2000)
model_name = st.sampled_from(sorted(EXPECTED))


def check(model, expected):
    found = partition(evaluate(model), plain_decide)
    assert is_answer(expected, found), told(found)


@settings(max_examples=40)
@given(model_name, st.tuples(angle, angle, angle), st.tuples(shift, shift, shift))
def test_a_rigid_motion_gives_the_same_answer(name, angles, shifts):
    model = read_file(str(CASES / f"{name}.csg"))
    check(moved(model, rigid(angles, shifts)), EXPECTED[name]["answer"])


@settings(max_examples=20)
@given(model_name, st.tuples(angle, angle, angle))
def test_a_mirrored_model_gives_the_same_answer(name, angles):
    model = read_file(str(CASES / f"{name}.csg"))
    check(moved(model, np.diag([-1.0, 1, 1, 1]) @ rigid(angles, (0, 0, 0))), EXPECTED[name]["answer"])


@settings(max_examples=30)
@given(model_name, st.floats(-3, 3))
def test_a_scaled_model_gives_the_scaled_answer(name, power):
    factor = 10.0**power
    model = read_file(str(CASES / f"{name}.csg"))
    check(moved(model, np.diag([factor, factor, factor, 1])), scaled_answer(EXPECTED[name]["answer"], factor))


@settings(max_examples=30)
@given(model_name, st.integers(0, 10**6))
def test_shuffled_operands_give_the_same_answer(name, seed):
    check(shuffled(read_file(str(CASES / f"{name}.csg")), seed), EXPECTED[name]["answer"])


@settings(max_examples=20)
@given(model_name, st.tuples(angle, angle, angle))
def test_a_placement_with_six_digits_gives_the_same_answer(name, angles):
    placed = rigid(angles, (12.5, -40.25, 7.75))
    rough = np.vectorize(lambda value: float(f"{value:.6g}"))(placed)
    left, _, right = np.linalg.svd(rough[:3, :3])
    rough[:3, :3] = left @ right
    check(moved(read_file(str(CASES / f"{name}.csg")), rough), EXPECTED[name]["answer"])


@pytest.mark.parametrize("name", ["i_short_touching", "egg_crate_two_by_two", "table_legs_through", "pipe_branch"])
def test_no_two_segments_share_volume(name):
    evaluated = evaluate(read_file(str(CASES / f"{name}.csg")))
    segments = partition(evaluated, plain_decide).segments
    total = sum(segment.solid.volume for segment in segments)
    assert total == pytest.approx(evaluated.solid.volume, rel=1e-6)
    for one in range(len(segments)):
        for other in range(one):
            common = intersect([segments[one].solid, segments[other].solid])
            assert common.is_empty or common.volume < 1e-9 * evaluated.solid.volume


@pytest.mark.parametrize(
    ("one", "other"), [("i_long_touching", "i_long_milled"), ("i_short_touching", "i_short_milled")]
)
def test_two_trees_of_one_solid_get_the_same_segments(one, other):
    def answer(name):
        segments = partition(evaluate(read_file(str(CASES / f"{name}.csg"))), plain_decide).segments
        return sorted(
            (s.type, round(s.thickness or 0, 6), round(s.length or 0, 6), round(s.volume, 3)) for s in segments
        )

    assert answer(one) == answer(other)


LATTICES = [
    "frame_braced",
    "frame_braced_thin",
    "frame_with_panel",
    "grillage",
    "frame_ladder_channels",
    "frame_tubes_deck",
    "truss_pratt",
    "truss_warren",
]


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.5236), (0.4, -1.1, 2.0)])
@pytest.mark.parametrize("name", LATTICES)
def test_a_frame_of_bars_in_one_plane_is_its_bars_however_it_is_turned_and_ordered(name, angles):
    model = moved(read_file(str(CASES / f"{name}.csg")), rigid(angles, (310.0, -75.5, 12.25)))
    check(model, EXPECTED[name]["answer"])
    check(shuffled(model, 3), EXPECTED[name]["answer"])
