"""`csgmesh batch`: many models, each on its own."""

import json
import subprocess
import sys
from pathlib import Path

import pytest
from dask_cluster import environment

from app.batch import RECORDS, exit_status, plan, records_of, run
from app.cli import run as command
from app.workers import WorkerDied
from kernel.errors import MeshError

PLATE = "cube(size = [100, 60, 5], center = false);\n"
BAR = "cube(size = [200, 10, 10], center = false);\n"


@pytest.fixture
def models(tmp_path, monkeypatch):
    """A folder with a plate, a bar and a text that is no model; it is the working folder."""
    monkeypatch.chdir(tmp_path)
    for name, text in (("plate", PLATE), ("bar", BAR), ("broken", "cube([1, 2")):
        Path(f"{name}.csg").write_text(text)
    return tmp_path


def test_each_deck_is_what_mesh_writes_and_a_wrong_model_stops_none(models, capsys):
    status = command(["batch", "broken.csg", "plate.csg", "bar.csg", "-o", "decks", "--size", "10", "--workers", "1"])
    printed = capsys.readouterr()
    assert status == 2
    assert printed.err == "error: broken.csg:1:6: '[' is never closed, expected ']'\n"
    assert printed.out.splitlines()[-1] == "3 models: 2 meshed, 1 failed"
    assert sorted(path.name for path in Path("decks").iterdir()) == ["bar.bdf", RECORDS, "plate.bdf"]
    for name in ("plate", "bar"):
        assert command(["mesh", f"{name}.csg", "-o", "one.bdf", "--size", "10"]) == 0
        assert Path("one.bdf").read_bytes() == Path(f"decks/{name}.bdf").read_bytes()
    assert [json.loads(line)["model"] for line in Path("decks", RECORDS).read_text().splitlines()] == [
        "broken.csg",
        "plate.csg",
        "bar.csg",
    ]


def test_resume_does_again_only_what_is_not_there_as_it_would_be(models, capsys):
    base = ["batch", "plate.csg", "bar.csg", "-o", "decks", "--workers", "1", "--json"]

    def kept(*more):
        assert command([*base, *more]) == 0
        return [record["kept"] for record in json.loads(capsys.readouterr().out)]

    assert kept() == [False, False]
    assert kept() == [False, False]
    assert kept("--resume") == [True, True]
    assert kept("--resume", "--size", "9") == [False, False]
    assert kept("--resume", "--size", "9") == [True, True]
    Path("decks/bar.bdf").write_text("spoilt")
    assert kept("--resume", "--size", "9") == [True, False]
    Path("plate.csg").write_text(BAR)
    assert kept("--resume", "--size", "9") == [False, True]
    with Path("decks", RECORDS).open("a") as stream:
        stream.write('{"model": "bar.csg", "key"')  # a run that was killed as it wrote
    assert kept("--resume", "--size", "9") == [True, True]
    lines = Path("decks", RECORDS).read_text().splitlines()
    assert [json.loads(line)["status"] for line in lines] == ["done", "done"]


def test_options_overrides_and_the_users_material_reach_every_model(models):
    Path("m.yaml").write_text("{name: S355, E: 210000, NU: 0.3, RHO: 7.85e-9}")
    options = ["--override", "/=brick", "--material", "m.yaml", "--format", "abaqus", "--order", "2"]
    assert command(["batch", "plate.csg", "bar.csg", "-o", "decks", "--report", "--workers", "1", *options]) == 0
    for name in ("plate", "bar"):
        deck = Path(f"decks/{name}.inp").read_text()
        assert "S355" in deck
        assert "C3D20" in deck
        assert Path(f"decks/{name}.html").read_text().startswith("<!doctype html>")


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["plate.csg", "sub/plate.csg"], "plate.csg and sub/plate.csg would both be written to plate.bdf"),
        (["plate.csg", "plate.csg"], "plate.csg and plate.csg would both be written to plate.bdf"),
        (["-"], "standard input is no model of a batch"),
        (["plate.csg", "--format", "dwg"], "unknown format 'dwg'"),
        (["plate.csg", "--coupling", "glue"], "unknown coupling 'glue'"),
        (["plate.csg", "--order", "3"], "order"),
        (["plate.csg", "--scheduler", "tcp://127.0.0.1:1", "--workers", "2"], "expected one of them"),
    ],
)
def test_wrong_options_are_refused_before_anything_is_done(models, capsys, arguments, said):
    assert command(["batch", *arguments, "-o", "decks"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: ")
    assert error.count("\n") == 1
    assert said in error
    assert not Path("decks", RECORDS).exists()


def test_a_folder_that_is_a_file_is_refused(models, capsys):
    assert command(["batch", "plate.csg", "-o", "bar.csg"]) == 2
    assert "bar.csg: cannot be made" in capsys.readouterr().err


def request():
    return {"report": False, "format": "nastran"}


def result(payload):
    answer = {"nodes": 1, "elements": {}, "couplings": {}, "components": 1, "segments": [], "warnings": []}
    return {"answer": {**answer, "mass": {"error": 0.0}}, "deck": payload["text"].encode(), "report": None}


def test_a_worker_that_dies_fails_its_model_alone(models):
    def do(payload):
        if payload["name"] == "plate.csg":
            raise WorkerDied("the worker process died with status -9 at files")
        return result(payload)

    tasks = plan(["plate.csg", "bar.csg"], request(), ".bdf")
    records = list(run(tasks, models, [do, do]))
    assert [record["status"] for record in records] == ["failed", "done"]
    assert records[0]["problem"]["message"] == "defect: the worker process died with status -9 at files"
    assert exit_status(records) == 1


def test_records_are_there_as_soon_as_a_model_is_done(models):
    tasks = plan(["plate.csg", "bar.csg"], request(), ".bdf")
    batch = run(tasks, models, [result])
    next(batch)
    assert records_of(models)["plate.csg"]["status"] == "done"
    batch.close()
    again = [record["kept"] for record in run(tasks, models, [result], resume=True)]
    assert again[0]


def test_the_exit_status_is_that_of_the_worst(models):
    def do(payload):
        if payload["name"] == "plate.csg":
            raise MeshError("s1 (/): cannot be")
        return result(payload)

    assert exit_status(list(run(plan(["plate.csg", "broken.csg"], request(), ".bdf"), models, [do]))) == 3
    assert exit_status(list(run(plan(["bar.csg", "none.csg"], request(), ".bdf"), models, [do]))) == 2
    assert exit_status(list(run(plan(["bar.csg"], request(), ".bdf"), models, [do]))) == 0


def test_a_dask_cluster_writes_the_same_decks(models, cluster):
    assert command(["batch", "plate.csg", "bar.csg", "-o", "here", "--workers", "1"]) == 0
    there = subprocess.run(
        [sys.executable, "-m", "app.cli", "batch", "plate.csg", "broken.csg", "bar.csg", "-o", "there"]
        + ["--scheduler", cluster],
        capture_output=True,
        text=True,
        env=environment(),
        timeout=300,
    )
    assert there.stderr == "error: broken.csg:1:6: '[' is never closed, expected ']'\n"
    assert there.returncode == 2
    for name in ("plate.bdf", "bar.bdf"):
        assert Path("here", name).read_bytes() == Path("there", name).read_bytes()


def test_a_scheduler_that_is_not_there_is_named(models, capsys, monkeypatch):
    pytest.importorskip("distributed")
    import app.cluster

    monkeypatch.setattr(app.cluster, "PATIENCE", 0.3)
    assert command(["batch", "plate.csg", "-o", "decks", "--scheduler", "tcp://127.0.0.1:1"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: no scheduler answers at tcp://127.0.0.1:1")
    assert error.count("\n") == 1


def test_another_version_at_the_cluster_is_refused():
    from app.cluster import files_there
    from kernel.errors import OptionError

    with pytest.raises(OptionError, match="another version of csgmesh"):
        files_there({}, "of another")
