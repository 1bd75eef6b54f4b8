"""The command line: what INTERFACES promises of every command."""

import base64
import json
import re
import struct
import subprocess
import sys
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from app.cli import run
from kernel.connect.couplings import COUPLINGS
from kernel.deck.deck import formats
from kernel.materials import MATERIAL_NAMES
from kernel.units import UNIT_SETS

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
TABLE = str(EXAMPLES / "table.csg")


@pytest.fixture
def csgmesh(capsys):
    """Run a command that must succeed and say nothing on standard error; gives what it printed."""

    def command(*arguments):
        status = run(arguments)
        printed = capsys.readouterr()
        assert (status, printed.err) == (0, "")
        return printed.out

    return command


def test_help_names_every_command_and_only_those_that_work(csgmesh):
    listed = re.findall(r"^  (\w+)  ", csgmesh("--help").partition("Commands:")[2], re.MULTILINE)
    assert listed == [
        "mesh",
        "batch",
        "classify",
        "tree",
        "evaluate",
        "quality",
        "serve",
        "merge",
        "connect",
        "edit",
        "rules",
        "token",
    ]
    for name in listed:
        assert "Usage: csgmesh" in csgmesh(name, "--help")
    assert csgmesh() == csgmesh("--help")


def test_every_command_has_an_example(csgmesh):
    for name in ("mesh", "batch", "classify", "tree", "evaluate", "quality", "serve", "merge", "connect", "edit"):
        assert f"Example: csgmesh {name} " in csgmesh(name, "--help")
    for name in ("create", "list", "revoke"):
        assert f"Example: csgmesh token {name}" in csgmesh("token", name, "--help")
    for name in ("check", "test", "coverage", "diff", "docs"):
        assert f"Example: csgmesh rules {name} " in csgmesh("rules", name, "--help")


def test_the_help_of_mesh_names_what_there_is_to_choose_from(csgmesh):
    shown = csgmesh("mesh", "--help")
    words = set(re.findall(r"[\w.]+", shown))
    endings = [ending for known in formats() for ending in known.endings]
    assert {*UNIT_SETS, *MATERIAL_NAMES, *COUPLINGS, *(known.name for known in formats())} <= words
    assert set(endings) <= set(re.findall(r"\.\w+", shown))


def test_the_version_is_the_installed_one(csgmesh):
    from importlib.metadata import version

    assert csgmesh("--version") == f"csgmesh {version('csgmesh')}\n"


def test_tree_shows_a_node_a_line(csgmesh):
    lines = csgmesh("tree", TABLE).splitlines()
    assert lines[0] == "/ union" and lines[1].strip().startswith("0 block (size 1500 x 800 x 25)")


def test_the_json_of_a_tree_is_a_model_again(csgmesh, tmp_path):
    path = tmp_path / "table.json"
    path.write_text(csgmesh("tree", TABLE, "--json"))
    assert csgmesh("tree", str(path)) == csgmesh("tree", TABLE)


def test_classify_json_has_the_promised_shape(csgmesh):
    answer = json.loads(csgmesh("classify", TABLE, "--json"))
    assert {"model", "units", "volume", "segments", "joints", "checks"} <= set(answer)
    assert answer["model"] == "table.csg" and answer["units"] == "mm"
    plate, *legs = answer["segments"]
    measures = {"volume", "thickness", "length", "radius", "holes", "section"}
    assert set(plate) == {"id", "node", "name", "type", "origin", "decision"} | measures
    assert (plate["type"], plate["thickness"], plate["holes"], plate["section"]) == ("plate", 25, 0, None)
    assert [leg["type"] for leg in legs] == ["beam"] * 4
    assert {"shape", "area", "iyy", "izz", "iyz", "j", "shear_area_y", "shear_area_z"} == set(legs[0]["section"])
    assert legs[0]["section"]["shape"] == "rectangle" and legs[0]["section"]["area"] == pytest.approx(2500)
    assert {"rule", "certainty", "because", "rejected"} <= set(plate["decision"])
    assert {"type", "rule", "because"} == set(plate["decision"]["rejected"][0])
    assert {"id", "kind", "segments"} <= set(answer["joints"][0])
    assert answer["checks"]["volume_of_segments"] == pytest.approx(answer["volume"], rel=1e-6)
    assert answer["checks"]["mass_error"] < 1e-6


def test_an_override_by_path_is_carried_out_and_the_rules_opinion_stays(csgmesh):
    answer = json.loads(csgmesh("classify", TABLE, "--override", "1.0.0=brick", "--json"))
    leg = next(segment for segment in answer["segments"] if segment["node"] == "1.0.0")
    assert (leg["type"], leg["origin"], leg["decision"]["by_rule"]) == ("brick", "override", "beam")


def test_an_override_keeps_its_author_and_its_reason_beside_what_the_rules_say(csgmesh):
    given = ("classify", TABLE, "--override", "1.0.0=brick:stress at the foot", "--override", "0=brick")
    leg = next(item for item in json.loads(csgmesh(*given, "--json"))["segments"] if item["node"] == "1.0.0")
    assert leg["decision"]["override"] == {"type": "brick", "author": "user", "reason": "stress at the foot"}
    assert leg["decision"]["rule"] == "slender-prism-is-beam"
    assert "override by user: stress at the foot; the rules say beam" in csgmesh(*given)
    explained = csgmesh(*given, "--explain", "1.0.0")
    assert explained.startswith("1.0.0: brick (override by user: stress at the foot; the rules say beam)")
    (decision,) = json.loads(csgmesh(*given, "--explain", "0", "--json"))["decisions"]
    assert decision["override"] == {"type": "brick", "author": "user", "reason": ""}
    assert decision["by_rule"] == "plate"


def test_explain_says_which_condition_failed_and_by_how_much(csgmesh):
    (decision,) = json.loads(csgmesh("classify", TABLE, "--explain", "0", "--json"))["decisions"]
    beam = next(rule for rule in decision["rules"] if rule.get("segment") == "beam")
    failed = [item for item in beam["conditions"] if item["state"] == "fails" and item["strength"] is not None]
    assert beam["state"] == "fails" and all(item["strength"] < 0 for item in failed) and failed
    assert decision["nearest"].endswith(f"(rule {decision['rule']})") and decision["margin"] > 0
    assert {"review", "conflicts", "rejected"} <= set(decision)


def test_explain_gives_the_facts_and_the_numbers_of_every_rule(csgmesh):
    text = csgmesh("classify", TABLE, "--explain", "0")
    assert "wall_slenderness = 32" in text and "rejected:" in text
    (decision,) = json.loads(csgmesh("classify", TABLE, "--explain", "0", "--json"))["decisions"]
    assert decision["type"] == "plate" and decision["facts"]["wall_count"] == 1 and decision["rules"]


def test_explain_without_a_node_explains_all(csgmesh):
    first = csgmesh("classify", TABLE, "--explain").splitlines()[0]
    assert first.startswith("/: split")
    assert len(json.loads(csgmesh("classify", "--json", TABLE, "--explain"))["decisions"]) > 5


def test_a_node_that_was_not_decided_about_cannot_be_explained(capsys):
    bracket = str(EXAMPLES / "bracket.csg")
    assert run(["classify", bracket, "--explain", "1.0"]) == 2
    assert "was not decided about" in capsys.readouterr().err


@pytest.mark.parametrize("ending, start", [("stl", b""), ("glb", b"glTF"), ("3mf", b"PK"), ("ply", b"ply")])
def test_evaluate_writes_the_solid(csgmesh, tmp_path, ending, start):
    path = tmp_path / f"table.{ending}"
    answer = json.loads(csgmesh("evaluate", TABLE, "-o", str(path), "--json"))
    assert path.read_bytes().startswith(start) and path.stat().st_size > 500
    assert answer["volume"] == pytest.approx(1500 * 800 * 25 + 4 * 50 * 50 * 760)
    assert answer["bounds"][1] == pytest.approx([1500, 800, 785])


def test_mesh_json_adds_counts_checks_quality_mass_and_seconds(csgmesh, tmp_path):
    answer = json.loads(csgmesh("mesh", TABLE, "-o", str(tmp_path / "table.bdf"), "--size", "50", "--json"))
    added = {"nodes", "elements", "couplings", "components", "quality", "mass", "seconds"}
    assert added <= set(answer)
    assert set(answer["elements"]) == {"quad4", "line2"} and answer["couplings"] == {"rbe3": 4}
    assert answer["components"] == 1 and answer["checks"]["failures"] == []
    assert {"min", "p5", "mean"} <= set(answer["quality"]["quad4"]["scaled_jacobian"])
    assert {"solid", "model", "error"} == set(answer["mass"])
    measured = json.loads(csgmesh("quality", str(tmp_path / "table.bdf"), "--json"))
    assert measured["elements"] == answer["elements"]
    found, written = (q["quality"]["quad4"]["scaled_jacobian"] for q in (measured, answer))
    assert found["min"] == pytest.approx(written["min"], rel=1e-6)


def test_two_runs_write_the_same_bytes_wherever_the_model_lies(csgmesh, tmp_path):
    (tmp_path / "table.csg").write_bytes(Path(TABLE).read_bytes())
    for model, deck in ((TABLE, "a.bdf"), (str(tmp_path / "table.csg"), "b.bdf")):
        csgmesh("mesh", model, "-o", str(tmp_path / deck))
    assert (tmp_path / "a.bdf").read_bytes() == (tmp_path / "b.bdf").read_bytes()


def test_standard_input_is_a_model_too(tmp_path):
    command = [sys.executable, "-m", "app.cli", "mesh", "-", "-o", str(tmp_path / "plate.msh")]
    text = "cube(size = [100, 60, 5], center = false);\n"
    done = subprocess.run(command, input=text, capture_output=True, text=True, check=True)
    assert "warning" not in done.stderr and "quad4" in done.stdout
    assert (tmp_path / "plate.msh").read_text().startswith("$MeshFormat")


def test_the_report_is_one_page_with_its_pictures_inside(csgmesh, tmp_path):
    report = tmp_path / "table.html"
    csgmesh("mesh", TABLE, "-o", str(tmp_path / "table.bdf"), "--report", str(report))
    page = report.read_text()
    pictures = [base64.b64decode(data) for data in re.findall(r"data:image/png;base64,([^\"]+)", page)]
    assert [struct.unpack(">II", picture[16:24]) for picture in pictures] == [(900, 640)] * 4
    assert re.findall(r"(?:src|href)=\"(?!data:)", page) == []
    for told in (
        "end_on",
        "beam",
        "scaled jacobian",
        "All checks hold",
        "as wide as thick",
        "It is not a beam",
        "centre of gravity of the model",
    ):
        assert told in page, told
    assert "0 block" in page and "holes 0" not in page and "0 holes" not in page
    assert page.count("1500 x 800 x 785 mm along x, y, z") == 8  # under each of four pictures, and instead of it


@pytest.mark.parametrize("units, density", [("mm", 7.85e-9), ("m", 7850.0)])
def test_units_and_material_arrive_in_the_deck(csgmesh, tmp_path, units, density):
    deck = tmp_path / "table.bdf"
    csgmesh("mesh", TABLE, "-o", str(deck), "--units", units, "--material", "steel", "--size", "100")
    (material,) = re.findall(r"^MAT1\*.*\n\*(.{7})(.{16})", deck.read_text(), re.MULTILINE)
    assert float(material[1]) == pytest.approx(density)


def test_a_material_from_a_file_arrives_in_the_deck(csgmesh, tmp_path):
    (tmp_path / "timber.yaml").write_text("{name: C24, E: 11000, NU: 0.3, RHO: 4.2e-10}\n")
    deck = tmp_path / "table.bdf"
    csgmesh("mesh", TABLE, "-o", str(deck), "--material", str(tmp_path / "timber.yaml"), "--size", "100")
    assert "11000." in deck.read_text() and "C24" in deck.read_text()


@pytest.mark.parametrize(
    "text", ["{E: 1}", "{name: A, E: -1, NU: 0.3, RHO: 1}", "[1]", "{name: A, E: x, NU: 0.3, RHO: 1}", "{"]
)
def test_a_wrong_material_file_is_refused(capsys, tmp_path, text):
    (tmp_path / "bad.yaml").write_text(text)
    assert run(["mesh", TABLE, "-o", str(tmp_path / "a.bdf"), "--material", str(tmp_path / "bad.yaml")]) == 2
    err = capsys.readouterr().err
    assert "bad.yaml" in err and err.count("\n") == 1


def test_the_light_commands_load_no_heavy_library():
    heavy = ["numba", "fastapi", "scipy", "trimesh", "experta", "shapely", "rich", "sqlalchemy"]
    code = f"import sys, app.cli; app.cli.run(['tree', sys.argv[1]]); print([m for m in {heavy} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code, TABLE], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_a_common_mesh_waits_for_no_scipy(tmp_path):
    heavy = ["scipy.spatial", "scipy.sparse"]
    code = f"import sys, app.cli; app.cli.run(sys.argv[1:]); print([m for m in {heavy} if m in sys.modules])"
    given = ["mesh", TABLE, "-o", str(tmp_path / "a.bdf"), "--size", "100"]
    done = subprocess.run([sys.executable, "-c", code, *given], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_the_service_listens_until_it_is_stopped_and_leaves_nothing_running(tmp_path):
    command = [
        sys.executable,
        "-c",
        "from app.cli import main; main()",
        "serve",
        "--port",
        "0",
        "--data",
        str(tmp_path),
    ]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as service:
        line = service.stderr.readline()
        url = re.search(r"http://[\d.:]+/", line).group()
        assert urllib.request.urlopen(f"{url}healthz", timeout=10).status == 200
        with pytest.raises(urllib.error.HTTPError, match="404"):
            urllib.request.urlopen(f"{url}v1/models/x", timeout=10)
        service.terminate()
        assert service.wait(20) in (0, 128 + 15, -15)


@pytest.mark.parametrize(
    "options, complaint",
    [
        (["--port", "99999"], "cannot listen"),
        (["--database", "nonsense://x"], "cannot be opened"),
        (["--data", "/proc/none"], "data folder"),
    ],
)
def test_a_service_that_cannot_start_says_why(capsys, tmp_path, options, complaint):
    assert run(["serve", "--data", str(tmp_path), *options]) == 2
    err = capsys.readouterr().err
    assert complaint in err and err.count("\n") == 1 and "Traceback" not in err


def test_the_program_loads_where_there_are_no_signals_of_unix():
    script = (
        "import signal; del signal.SIGPIPE, signal.SIGKILL; import app.cli, app.workers; app.cli.run(['--version'])"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert (done.returncode, done.stdout[:8]) == (0, "csgmesh "), done.stderr
