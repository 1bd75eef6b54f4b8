"""A model that does not pass its own checks is refused; what an analyst should look at is said."""

import json
import re
from dataclasses import replace
from pathlib import Path

import pytest

from app.artifacts import Artifacts
from app.cli import run
from app.work import mesh_task
from kernel.connect import checks
from kernel.errors import CheckError
from kernel.idealise import ledger

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TABLE = str(EXAMPLES / "table.csg")
TWO_PLATES = "cube(size = [100, 60, 5], center = false);\nmultmatrix([[1,0,0,0],[0,1,0,0],[0,0,1,50],[0,0,0,1]]) {\n\
cube(size = [100, 60, 5], center = false);\n}\n"
PAYLOAD = {
    "text": "cube(size = [100, 60, 5], center = false);\n",
    "name": "plate.csg",
    "units": None,
    "rules": None,
    "overrides": [],
    "options": {"size": 20},
    "material": None,
    "coupling": "distributing",
    "joints": {},
    "mass": "plain",
}


@pytest.fixture
def failing(monkeypatch):
    """Checks that find two things wrong with every model."""
    holds = checks.check_model
    failures = ("3 nodes belong to nothing", "2 freedoms depend on two couplings")
    monkeypatch.setattr(checks, "check_model", lambda *given: replace(holds(*given), failures=failures))


def test_a_model_that_fails_its_checks_is_refused_and_nothing_is_written(failing, capsys, tmp_path):
    given = ["mesh", TABLE, "-o", str(tmp_path / "a.bdf"), "--report", str(tmp_path / "a.html"), "--size", "100"]
    assert run(given) == 3
    printed = capsys.readouterr()
    assert printed.err.startswith("error: the model does not pass its checks: 3 nodes belong to nothing; 2 freedoms")
    assert printed.err.count("\n") == 1 and printed.out == "" and list(tmp_path.iterdir()) == []


def test_unchecked_writes_it_and_warns_of_every_failure(failing, capsys, tmp_path):
    assert run(["mesh", TABLE, "-o", str(tmp_path / "a.bdf"), "--size", "100", "--unchecked"]) == 0
    warnings = capsys.readouterr().err.splitlines()
    assert warnings[0] == "warning: check failed: 3 nodes belong to nothing" and len(warnings) == 2
    assert (tmp_path / "a.bdf").exists()


def test_the_services_job_fails_likewise_unless_told_otherwise(failing, tmp_path):
    artifacts = Artifacts(tmp_path)
    with pytest.raises(CheckError, match="3 nodes belong to nothing"):
        mesh_task({**PAYLOAD, "unchecked": False}, artifacts, lambda *_: None)
    result = mesh_task({**PAYLOAD, "unchecked": True}, artifacts, lambda *_: None)
    assert json.loads(artifacts.get(result["answer"]))["checks"]["failures"][0] == "3 nodes belong to nothing"


def test_parts_that_do_not_touch_are_named(capsys, tmp_path):
    (tmp_path / "two.csg").write_text(TWO_PLATES)
    given = ["mesh", str(tmp_path / "two.csg"), "-o", str(tmp_path / "a.bdf"), "--report", str(tmp_path / "a.html")]
    assert run([*given, "--json"]) == 0
    printed = capsys.readouterr()
    warning = "the model is in 2 parts that do not touch: s1 | s2"
    assert printed.err == f"warning: {warning}\n" and json.loads(printed.out)["warnings"] == [warning]
    assert warning in (tmp_path / "a.html").read_text()


def test_the_mass_has_its_unit_and_says_what_the_corners_weigh(capsys, tmp_path):
    bracket = ["mesh", str(EXAMPLES / "bracket.csg"), "-o", str(tmp_path / "a.bdf"), "--size", "8"]
    assert run(bracket) == 0
    (line,) = re.findall(r"mass: .*", capsys.readouterr().out)
    assert re.match(
        r"mass: solid 0\.00257\d+ t, model 0\.0026\d+ t \(\+2\.\d\d %, of which \+2\.\d\d % counted twice", line
    )
    assert run([*bracket, "--mass", "exact"]) == 0
    (line,) = re.findall(r"mass: .*", capsys.readouterr().out)
    assert line.endswith("t (+0.00 %)")


def pocketed(tmp_path, floor: float) -> list[str]:
    """A plate 10 thick with four pockets whose floors are below its middle."""
    pockets = (f" &\n DIF BLO(80,80,20) AT(MOVX={x},MOVY={y},MOVZ={floor})" for x in (20, 120) for y in (20, 120))
    (tmp_path / "plate.csg").write_text(f"P = BLO(400,400,10){''.join(pockets)}\nOUT P\n")
    return ["mesh", str(tmp_path / "plate.csg"), "-o", str(tmp_path / "a.bdf"), "--size", "40"]


def test_a_plate_whose_thickness_is_not_its_materials_is_refused(capsys, tmp_path, monkeypatch):
    """Countersinks take more than the holes that the mid-surface has."""
    monkeypatch.setattr(ledger, "MISFIT", 0.005)
    sinks = (f" &\n DIF CON(10,30,10) AT(MOVX={50 + 100 * k},MOVY={50 + 100 * j})" for k in range(4) for j in range(4))
    (tmp_path / "plate.csg").write_text(f"P = BLO(400,400,10){''.join(sinks)}\nOUT P\n")
    given = ["mesh", str(tmp_path / "plate.csg"), "-o", str(tmp_path / "a.bdf"), "--size", "20"]
    assert run(given) != 0
    said = capsys.readouterr().err
    assert re.search(
        r"s1 \(/\) is 10 thick as a plate, and its material 9\.\d+ on average \(\+1\.\d% of its volume\)", said
    )
    assert not (tmp_path / "a.bdf").exists()
    assert run([*given, "--unchecked"]) == 0
    assert "check failed: s1" in capsys.readouterr().err


def test_a_plate_with_pockets_is_its_floors_and_what_is_round_them(capsys, tmp_path):
    assert run([*pocketed(tmp_path, 4.0), "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert sorted(segment["thickness"] for segment in answer["segments"]) == pytest.approx([4.0] * 4 + [10.0])
    assert answer["mass"]["error"] == pytest.approx(0.0, abs=1e-9)


def test_an_analyst_may_say_that_it_is_a_plate_and_is_warned(capsys, tmp_path):
    assert run([*pocketed(tmp_path, 4.0), "--override", "/=plate"]) == 0
    printed = capsys.readouterr()
    assert "warning: s1 (/) is 10 thick as a plate" in printed.err
    assert re.search(r"of which -7\.\d\d % less than the segments' own shapes", printed.out)


def test_what_straight_edges_cut_off_is_not_told_as_joints(capsys, tmp_path):
    (tmp_path / "disc.csg").write_text("P = CYL(150, 4)\nOUT P\n")
    given = ["mesh", str(tmp_path / "disc.csg"), "-o", str(tmp_path / "a.bdf"), "--size", "30", "--per-circle", "40"]
    assert run(given) == 0
    (line,) = re.findall(r"mass: .*", capsys.readouterr().out)
    assert "of which -0.41 % cut off by straight edges" in line and "where segments meet" not in line
