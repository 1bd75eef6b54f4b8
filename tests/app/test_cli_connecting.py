"""What the command line says about couplings and masses."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

TABLE = str(Path(__file__).parents[2] / "examples" / "table.csg")
BRACKET = str(Path(__file__).parents[2] / "examples" / "bracket.csg")


def csgmesh(*arguments: str) -> subprocess.CompletedProcess[str]:
    code = "import sys; from app.cli import main; sys.argv[0] = 'csgmesh'; main()"
    return subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, text=True, check=False)


def test_one_joint_is_coupled_as_asked(tmp_path):
    deck = tmp_path / "table.bdf"
    done = csgmesh("mesh", TABLE, "-o", str(deck), "--joint", "j2=rigid")
    assert done.returncode == 0, done.stderr
    text = deck.read_text()
    assert text.count("\nRBE2") == 1
    assert text.count("\nRBE3") == 3


def test_tees_by_arms_need_nothing_to_make_up_for(tmp_path):
    deck = tmp_path / "bracket.bdf"
    done = csgmesh("mesh", BRACKET, "-o", str(deck), "--json", "--tee", "arms")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert abs(answer["mass"]["error"]) < 5e-4
    assert answer["checks"]["loose_arms"] == 0
    assert answer["couplings"]["rbe2"] == deck.read_text().count("\nRBE2") > 10


def test_one_tee_is_made_as_asked(tmp_path):
    deck = tmp_path / "bracket.bdf"
    done = csgmesh("classify", BRACKET, "--json")
    tee = next(joint["id"] for joint in json.loads(done.stdout)["joints"] if joint["kind"] == "tee")
    done = csgmesh("mesh", BRACKET, "-o", str(deck), "--joint", f"{tee}=arms")
    assert done.returncode == 0, done.stderr
    assert deck.read_text().count("\nRBE2") > 3


def test_exact_mass_makes_up_for_corners(tmp_path):
    deck = tmp_path / "bracket.bdf"
    done = csgmesh("mesh", BRACKET, "-o", str(deck), "--mass", "exact", "--json")
    assert done.returncode == 0, done.stderr
    assert abs(json.loads(done.stdout)["mass"]["error"]) < 1e-9


def test_a_node_may_be_of_another_material(tmp_path):
    deck = tmp_path / "table.bdf"
    done = csgmesh("mesh", TABLE, "-o", str(deck), "--material-of", "0=aluminium")
    assert done.returncode == 0, done.stderr
    assert deck.read_text().count("\nMAT1") == 2


def test_a_node_may_have_elements_of_another_size_and_the_answer_says_so(tmp_path):
    deck = tmp_path / "table.bdf"
    counts = {}
    for more in ((), ("--size-of", "0=20")):
        done = csgmesh("mesh", TABLE, "-o", str(deck), "--size", "100", "--json", *more)
        assert done.returncode == 0, done.stderr
        answer = json.loads(done.stdout)
        counts[more] = answer["elements"]
    assert counts["--size-of", "0=20"]["quad4"] > 8 * counts[()]["quad4"]
    assert counts["--size-of", "0=20"]["line2"] == counts[()]["line2"]
    assert answer["size"] == {
        "value": 100.0,
        "automatic": False,
        "because": "as asked",
        "segments": [{"segment": "s1", "size": 20.0, "because": "asked for 0"}],
    }


@pytest.mark.parametrize(
    ("option", "complaint"),
    [
        (("--joint", "j2"), "expected JOINT=HOW"),
        (("--joint", "j2=glue"), "unknown coupling 'glue'"),
        (("--joint", "j99=arms"), "no joint 'j99'"),
        (("--tee", "glue"), "tee is 'glue', expected one of extend, arms"),
        (("--joint", "j99=rigid"), "no joint 'j99'"),
        (("--size-of", "0"), "--size-of '0': expected NODE=SIZE, such as TOP=20"),
        (("--size-of", "0=fine"), "--size-of 0=fine: 'fine' is wrong, expected a number"),
        (("--size-of", "0=-1"), "size of '0' is -1, expected a positive number"),
        (("--size-of", "LID=5"), "size of 'LID': no node 'LID' in the model, expected '/'"),
        (("--size-of", "s77=5"), "size of 's77': no node 's77' in the model"),
        (("--curve-size", "0"), "--curve-size '0': expected CURVES=SIZE, such as HOLE=2"),
        (("--seeds", "0=4.5"), "--seeds 0=4.5: '4.5' is wrong, expected a whole number"),
        (("--seeds", "0&LID=4"), "seeds of 'LID': no node 'LID' in the model"),
        (("--seeds", "9000,0,0=4"), "seeds of '9000,0,0': the nearest curve, through (1500, 400, 772.5) of s1, is 7"),
        (("--growth", "1"), "growth is 1, expected a ratio above 1"),
        (("--per-circle", "2"), "per_circle is 2, expected a whole number from 4"),
        (("--layers", "none"), "--layers: 'none' is wrong, expected a whole number"),
        (("--material-of", "0"), "expected NODE=NAME"),
        (("--material-of", "0=cheese"), "unknown material 'cheese'"),
        (("--material-of", "7.7=steel"), "no node '7.7'"),
        (("--mass", "light"), "unknown mass 'light'"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(option, complaint, tmp_path):
    deck = tmp_path / "table.bdf"
    done = csgmesh("mesh", TABLE, "-o", str(deck), *option)
    assert done.returncode == 2
    assert complaint in done.stderr
    assert done.stderr.count("\n") == 1
    assert not deck.exists()


NEARLY = """UNITS mm
P = BLO(300,300,10) UN BLO(30,30,400) AT (MOVX=135, MOVY=135, MOVZ=10.2)
"""


def test_a_stated_gap_joins_what_is_no_further_apart(tmp_path):
    model = tmp_path / "nearly.csg"
    model.write_text(NEARLY)
    apart = json.loads(csgmesh("classify", str(model), "--json").stdout)
    assert apart["joints"] == []
    joined = json.loads(csgmesh("classify", str(model), "--json", "--gap", "0.25").stdout)
    assert [(joint["kind"], joint["area"]) for joint in joined["joints"]] == [("end_on", pytest.approx(900))]
    assert joined["joints"][0]["gap"] == pytest.approx(0.2)
    deck = tmp_path / "nearly.bdf"
    done = csgmesh("mesh", str(model), "-o", str(deck), "--json", "--gap", "0.25")
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["components"] == 1
    assert answer["couplings"] == {"rbe3": 1}


def test_without_it_the_small_gap_is_told(tmp_path):
    model = tmp_path / "nearly.csg"
    model.write_text(NEARLY)
    done = csgmesh("mesh", str(model), "-o", str(tmp_path / "nearly.bdf"))
    assert "s1 and s2 are 0.2 apart over an area of 900: they are not joined" in done.stderr


@pytest.mark.parametrize("gap", ["-1", "10", "nan"])
def test_a_gap_that_no_model_can_have_is_refused(tmp_path, gap):
    model = tmp_path / "nearly.csg"
    model.write_text(NEARLY)
    done = csgmesh("classify", str(model), f"--gap={gap}")
    assert done.returncode == 2
    assert done.stderr.startswith("error: gap is ")
