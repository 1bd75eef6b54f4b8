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


@pytest.mark.parametrize(
    ("option", "complaint"),
    [
        (("--joint", "j2"), "expected JOINT=COUPLING"),
        (("--joint", "j2=glue"), "unknown coupling 'glue'"),
        (("--joint", "j99=rigid"), "no joint 'j99'"),
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
