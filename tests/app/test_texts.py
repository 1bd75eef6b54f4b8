"""What `classify` prints: the measures that an analyst knows a segment by, and what is to be looked at again."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from app.cli import run
from app.texts import needs_review, quality_lines
from rules.engine import RuleBase

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"


@pytest.mark.parametrize(
    "model, options, told",
    [
        ("table.csg", [], "length 760, rectangle 50 x 50, A 2500  "),
        ("table.csg", ["--override", "1.0.0=brick"], "760 x 50 x 50, prismatic  "),
        ("table.csg", ["--units", "m"], "volume 3.76e+07 m^3, all in m\n"),
        ("bracket.csg", [], "thickness 10, 2 holes  "),
        ("i_beam.csg", [], "length 2400, i "),
        ("pipe_with_holes.csg", [], "thickness 4, radius 58, "),
    ],
)
def test_a_segment_shows_its_measures(capsys, model, options, told):
    assert run(["classify", str(EXAMPLES / model), *options]) == 0
    assert told in capsys.readouterr().out


@pytest.mark.parametrize(
    "text, told",
    [
        ("A = CYL(R=10, H=400)", "length 400, circle D 20, A 314.1"),
        ("A = CYL(R=10, H=400) DIF CYL(R=7, H=400)", "length 400, tube D 20 t 3, A 160.2"),
    ],
)
def test_a_round_section_shows_its_diameter(capsys, tmp_path, text, told):
    (tmp_path / "rod.csg").write_text(f"{text}\n")
    assert run(["classify", str(tmp_path / "rod.csg"), "--override", "/=beam"]) == 0
    assert told in capsys.readouterr().out


def test_a_decision_near_a_limit_is_marked(capsys, monkeypatch):
    decide = RuleBase.decide

    def near(self, facts):
        answer = decide(self, facts)
        return replace(answer, margin=0.04) if hasattr(answer, "margin") else answer

    monkeypatch.setattr(RuleBase, "decide", near)
    model = str(EXAMPLES / "table.csg")
    assert run(["classify", model]) == 0
    assert capsys.readouterr().out.count("(near the limit)") == 5
    assert run(["classify", model, "--json"]) == 0
    segments = json.loads(capsys.readouterr().out)["segments"]
    assert all(segment["decision"]["review"] for segment in segments)


def test_a_decision_without_a_number_needs_no_review():
    class Sure:
        margin = None

    class Decision:
        by_rule = Sure

    assert not needs_review(Decision)


def test_rounding_in_a_quality_shows_as_nought():
    (_, row) = quality_lines({"quad4": {"skew": {"min": 0.0, "p5": 6e-16, "mean": -3e-13, "p95": 0.5, "max": 0.5}}})
    assert row.split() == ["quad4", "skew", "0", "0", "0", "0.5", "0.5"]
