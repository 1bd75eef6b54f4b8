"""The labelled models in tests/cases: every one gets the segments that an analyst would choose."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from segmenting import is_answer, told

from kernel.csg.reader import read_file
from kernel.segment.partition import partition
from kernel.solid.evaluate import evaluate

CASES = Path(__file__).parents[1] / "cases"
EXPECTED = json.loads((CASES / "expected.json").read_text())


def test_every_model_has_an_answer_and_every_answer_a_model():
    assert {path.stem for path in CASES.glob("*.csg")} == set(EXPECTED)
    assert len(EXPECTED) >= 80


@pytest.mark.parametrize("name", sorted(EXPECTED))
def test_a_labelled_model_gets_the_segments_that_an_analyst_chooses(name, decide):
    found = partition(evaluate(read_file(str(CASES / f"{name}.csg"))), decide)
    assert is_answer(EXPECTED[name]["answer"], found), told(found)


def test_the_geometry_decides_and_the_tree_breaks_ties(decide):
    exact = 0
    for name, expected in EXPECTED.items():
        evaluated = evaluate(read_file(str(CASES / f"{name}.csg")))
        exact += is_answer(expected["answer"], partition(evaluated, decide, use_tree=False))
    frames = [name for name in EXPECTED if name.startswith(("frame_", "truss_"))]
    assert len(frames) == 8  # only the tree tells members that meet askew, and members from walls
    assert exact >= 0.9 * (len(EXPECTED) - len(frames))
