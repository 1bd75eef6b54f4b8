"""Bad input: one line that says what is wrong and where, the right exit status, and nothing half-written."""

import os
import socket
import subprocess
import sys

import pytest

from app.cli import run

BLOCK = "cube(size = [100, 60, 5], center = false);\n"
SPHERE = "sphere($fn = 0, $fa = 12, $fs = 2, r = 10);\n"
CONE = "cylinder($fn = 0, $fa = 12, $fs = 2, h = 20, r1 = 10, r2 = 0, center = false);\n"


@pytest.fixture
def attempt(tmp_path, capsys, monkeypatch):
    """Mesh a text in an empty folder; gives (exit status, the one line, what is in the folder afterwards)."""
    monkeypatch.chdir(tmp_path)

    def mesh(text, *options, output="deck.bdf"):
        (tmp_path / "model.csg").write_text(text)
        status = run(["mesh", "model.csg", "-o", output, *options])
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err.startswith("error: ") and printed.err.count("\n") == 1
        assert "Traceback" not in printed.err
        return status, printed.err.strip(), sorted(os.listdir(tmp_path))

    return mesh


@pytest.mark.parametrize(
    "name, text, place, complaint",
    [
        ("unknown primitive", f"{BLOCK}kube(size = [1, 1, 1]);", "2:1", "kube"),
        ("missing brace", "union() {\n\tcube(size = [1, 1, 1], center = false);\n", "1:9", "never closed"),
        ("negative radius", "cylinder($fn = 0, h = 5, r1 = -1, r2 = -1, center = false);", "1:", "r1 is -1"),
        ("zero-size block", "cube(size = [0, 1, 1], center = false);", "1:6", "[0, 1, 1]"),
        ("NaN", "cube(size = [nan, 1, 1], center = false);", "1:6", "nan"),
        ("PADL's unknown primitive", "A = BOX(1, 2, 3)\nOUT A\n", "1:5", "BOX"),
        ("PADL's negative radius", "A = CYL(R=-5, H=10)\nOUT A\n", "1:9", "R is -5"),
        ("PADL's division by zero", "A = BLO(1/0, 2, 3)\nOUT A\n", "1:10", "divided by 0"),
        ("deep nesting", "union() {" * 10_000 + BLOCK + "}" * 10_000, "1:", "nested too deeply"),
    ],
)
def test_a_text_that_cannot_be_read_is_refused_with_its_place(attempt, name, text, place, complaint):
    status, line, files = attempt(text)
    assert status == 2
    assert line.startswith(f"error: model.csg:{place}")
    assert complaint.lower() in line.lower()
    assert files == ["model.csg"]


def test_an_empty_difference_is_refused(attempt):
    text = "difference() {\n\tcube(size = [1, 1, 1], center = false);\n\tcube(size = [3, 3, 3], center = true);\n}\n"
    status, line, files = attempt(text)
    assert (status, files) == (2, ["model.csg"])
    assert "empty" in line or "nothing" in line


def test_a_file_of_fifty_megabytes_is_refused(attempt):
    status, line, files = attempt(BLOCK * (50_000_000 // len(BLOCK) + 1))
    assert (status, files) == (2, ["model.csg"])
    assert "50 MB" in line


@pytest.mark.parametrize(
    "override, complaint",
    [
        ("0.7=brick", "no node '0.7'"),
        ("LEG=brick", "no node 'LEG'"),
        ("/=wood", "unknown type"),
        ("brick", "expected NODE=TYPE"),
        ("=brick", "expected NODE=TYPE"),
    ],
)
def test_an_override_of_an_unknown_node_or_type_is_refused(attempt, override, complaint):
    status, line, files = attempt(BLOCK, "--override", override)
    assert (status, files) == (2, ["model.csg"])
    assert complaint in line


def test_two_overrides_of_one_node_are_refused(attempt):
    status, line, _ = attempt(BLOCK, "--override", "/=brick", "--override", "/=plate")
    assert status == 2 and "twice" in line


def test_an_override_that_cannot_be_is_refused_with_the_reason(attempt):
    status, line, files = attempt(SPHERE, "--override", "/=beam")
    assert (status, files) == (2, ["model.csg"])
    assert "beam" in line


def test_what_cannot_be_meshed_is_named_and_has_its_own_status(attempt):
    status, line, files = attempt(CONE, "--override", "/=brick", "--volumes", "hex")
    assert (status, files) == (3, ["model.csg"])
    assert "s1" in line


@pytest.mark.parametrize("output", ["missing/deck.bdf", ".", "/proc/deck.bdf"])
def test_an_unwritable_output_is_refused(attempt, output):
    status, line, files = attempt(BLOCK, "--format", "nastran", output=output)
    assert (status, files) == (2, ["model.csg"])
    assert output in line


def test_an_existing_deck_stays_as_it_was(attempt, tmp_path):
    (tmp_path / "deck.bdf").write_text("precious")
    attempt("kube();")
    assert (tmp_path / "deck.bdf").read_text() == "precious"


@pytest.mark.parametrize(
    "options, complaint",
    [
        (["--size", "0"], "size is 0"),
        (["--size", "-3"], "size is -3"),
        (["--size", "nan"], "size is nan"),
        (["--size", "big"], "--size"),
        (["--order", "3"], "order is 3"),
        (["--faces", "hexagons"], "faces is 'hexagons'"),
        (["--volumes", "ice"], "volumes is 'ice'"),
        (["--units", "furlong"], "unknown units"),
        (["--material", "cheese"], "cheese"),
        (["--coupling", "glue"], "glue"),
        (["--format", "word"], "unknown format"),
        (["--rules", "missing.yaml"], "missing.yaml"),
        (["--report", "deck.bdf"], "one file"),
        (["--colour", "red"], "--colour"),
    ],
)
def test_a_wrong_option_is_refused(attempt, options, complaint):
    status, line, files = attempt(BLOCK, *options)
    assert (status, files) == (2, ["model.csg"])
    assert complaint in line


def test_a_missing_file_is_refused(capsys, tmp_path):
    assert run(["tree", str(tmp_path / "none.csg")]) == 2
    assert "none.csg" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["mesh"], ["dance"], ["mesh", "a.csg"], ["tree", "--explain"]])
def test_wrong_usage_is_one_line_too(capsys, arguments):
    assert run(arguments) == 2
    err = capsys.readouterr().err
    assert err.startswith("error: ") and err.count("\n") == 1


def test_a_defect_is_one_line_with_its_traceback_in_a_file(capsys, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr("app.cli._read", lambda model: 1 / 0)
    assert run(["tree", "a.csg"]) == 1
    line = capsys.readouterr().err
    assert line.startswith("error: defect: ZeroDivisionError") and line.count("\n") == 1
    (log,) = (tmp_path / "csgmesh").iterdir()
    assert "Traceback" in log.read_text() and str(log) in line


def test_a_reader_that_goes_away_is_no_error(tmp_path):
    model = tmp_path / "many.csg"
    model.write_text("group() {\n" + BLOCK * 3000 + "}\n")
    command = f"{sys.executable} -c 'from app.cli import main; main()' tree {model} | head -1"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, check=True)
    assert done.stderr == "" and done.stdout == "/ union\n"


@pytest.mark.parametrize(
    "arguments, line",
    [
        (["mesh"], "MODEL is missing, expected csgmesh mesh MODEL -o DECK [OPTIONS] (more by csgmesh mesh --help)"),
        (["mesh", "a.csg"], "-o DECK is missing, expected csgmesh mesh MODEL -o DECK [OPTIONS] (more by csgmesh"),
        (["mesh", "a.csg", "-o", "a.bdf", "--size", "abc"], "--size: 'abc' is wrong, expected a number"),
        (["mesh", "a.csg", "-o", "a.bdf", "--size=abc"], "--size: 'abc' is wrong, expected a number"),
        (["serve", "--port", "http"], "--port: 'http' is wrong, expected a whole number"),
        (["mesch", "a.csg"], "unknown command 'mesch', expected one of mesh, batch, classify"),
        (["mesh", "a.csg", "--siz", "3"], "unknown option --siz, expected csgmesh mesh MODEL"),
        (["rules", "chek"], "unknown command 'chek', expected one of check, test"),
        (["rules", "check", "nofile.yaml"], "there is no rule base nofile.yaml, expected a YAML file, a folder"),
        (["mesh", "a.csg", "-o", "a.xyz"], "no format for the ending of 'a.xyz', expected one of nastran (.bdf .nas"),
        (["mesh", "a.csg", "-o", "/proc/x.bdf"], "/proc/x.bdf: cannot be written, "),
    ],
)
def test_wrong_usage_says_what_was_expected(capsys, arguments, line):
    assert run(arguments) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith(f"error: {line}") and printed.out == ""
    assert "expected" in printed.err and printed.err.count("\n") == 1


def test_a_format_without_an_ending_says_how_it_is_had(capsys):
    assert run(["mesh", "a.csg", "-o", "a.xyz"]) == 2
    assert "abaqus (only by --format)" in capsys.readouterr().err


def test_a_misspelt_name_is_put_right(attempt):
    text = "PLATE = BLO(X=100, Y=60, Z=5)\nLEG = BLO(X=5, Y=5, Z=60)\nPART = PLATE UN LEG\nOUT PART\n"
    _, line, _ = attempt(text, "--override", "PLAET=brick")
    assert "did you mean 'PLATE'? (csgmesh tree shows them)" in line


def test_a_port_in_use_is_named(capsys, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        assert run(["serve", "--port", str(port), "--data", str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"error: port {port} is in use, choose another with --port\n"
