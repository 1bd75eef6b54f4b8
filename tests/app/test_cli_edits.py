"""`csgmesh merge`, `connect` and `edit`, and meshing apart, on the command line."""

import json
import re
from pathlib import Path

import pytest

from app.cli import run
from kernel.deck.jsonread import read_json_deck

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
BRACKET = str(EXAMPLES / "bracket.csg")


@pytest.fixture
def csgmesh(capsys, monkeypatch, tmp_path):
    """Run commands in an empty folder; gives status, standard output and standard error."""
    monkeypatch.chdir(tmp_path)

    def command(*arguments):
        status = run(arguments)
        printed = capsys.readouterr()
        return status, printed.out, printed.err

    return command


@pytest.fixture(scope="module")
def decks(tmp_path_factory):
    """The bracket's wall and base meshed alone, and all of it apart."""
    folder = tmp_path_factory.mktemp("decks")
    for name, options in {
        "wall": ["--only", "s1"], "base": ["--only", "s3", "--size", "12"], "apart": ["--apart"],
    }.items():  # fmt: skip
        assert run(["mesh", BRACKET, "-o", str(folder / f"{name}.json"), "--size", "10", *options]) == 0
    return folder


def test_what_is_meshed_alone_is_told(csgmesh):
    status, out, _ = csgmesh("mesh", BRACKET, "-o", "wall.json", "--only", "s1", "--size", "30")
    assert status == 0 and out.splitlines()[0].endswith("in 1 segment (s1) of 3")
    status, out, _ = csgmesh("mesh", BRACKET, "-o", "all.json", "--size", "30")
    assert status == 0 and out.splitlines()[0].endswith("in 3 segments")


def test_the_sequence_of_the_thesis(csgmesh, decks):
    status, out, err = csgmesh("merge", str(decks / "wall.json"), str(decks / "base.json"), "-o", "both.json")
    assert (status, err) == (0, "warning: the model is in 2 parts that do not touch: s1 | s3\n")
    assert "merged with bracket.csg (s3)" in out and "components: 2" in out
    status, out, err = csgmesh("connect", "both.json", "-o", "one.bdf", "--json")
    assert (status, err) == (0, "")
    answer = json.loads(out)
    assert (answer["components"], answer["checks"]["failures"]) == (1, [])
    assert re.match(r"connected: \d+ nodes became one with others, \d+ tied to elements", answer["history"][0])
    text = Path("one.bdf").read_text()
    assert "note: edited: merged with bracket.csg (s3)" in text and "note: edited: connected" in text


def test_a_deck_meshed_apart_is_connected(csgmesh, decks):
    status, out, _ = csgmesh("connect", str(decks / "apart.json"), "-o", "one.json", "--tolerance", "0.01")
    assert status == 0 and "components: 1" in out
    assert len(read_json_deck(Path("one.json").read_bytes()).properties) == 3
    status, _, err = csgmesh(
        "connect", str(decks / "apart.json"), "-o", "two.json", "--segment", "s1", "--segment", "s3"
    )
    assert status == 0 and "the model is in 2 parts that do not touch: s1 s3 | s2" in err


def test_edits_are_done_in_the_order_that_they_are_written_in(csgmesh, decks):
    Path("more.json").write_text(json.dumps([{"op": "delete_segment", "segment": "s2"}]))
    status, out, _ = csgmesh(
        "edit", str(decks / "apart.json"), "-o", "e.json",
        "connect=0.01", "add_node=133,51,5", "more.json", "move_node=133,51,5:134,51,5", "--json",
    )  # fmt: skip
    assert status == 0
    history = json.loads(out)["history"]
    assert [line.split()[0] for line in history] == ["connected", "added", "deleted", "moved"]
    model = read_json_deck(Path("e.json").read_bytes())
    assert (abs(model.mesh.nodes - (134, 51, 5)).max(axis=1) < 1e-9).sum() == 1
    assert {element.segment for element in model.properties} == {"s1", "s3"}


def test_the_same_edits_give_the_same_bytes(csgmesh, decks):
    for name in ("a.bdf", "b.bdf"):
        assert csgmesh("edit", str(decks / "apart.json"), "-o", name, "connect", "add_node=133,51,5")[0] == 0
    assert Path("a.bdf").read_bytes() == Path("b.bdf").read_bytes()


@pytest.mark.parametrize(
    "edits, status, told",
    [
        (["paint=red"], 2, "paint=red: expected add_node=X,Y,Z"),
        (["add_node=1,2"], 2, "'1,2' is 2 numbers, expected three"),
        (["add_node=1,2,x"], 2, "'x' is wrong, expected a number"),
        (["add_node=1,2,nan"], 2, "edit 1: at.2 is nan, expected a finite number"),
        (["move_node=1,2,3"], 2, "expected move_node=X,Y,Z:X,Y,Z"),
        (["connect=-1"], 2, "edit 1: tolerance is -1.0, expected greater than 0"),
        (["connect", "add_node=1000,0,0"], 2, "edit 2 (add_node): (1000, 0, 0) lies 840 beside s3"),
        (["delete_segment=s9"], 2, "no segment 's9' in the mesh, expected one of s1, s2, s3"),
        (["merge=nowhere.json"], 2, "nowhere.json: cannot be read, no such file"),
        (["merge=deck.bdf"], 2, "deck.bdf: cannot be edited, expected a JSON deck"),
        (["connect=4"], 3, "expected a tolerance under half of that"),
        (["nothere.json"], 2, "nothere.json: cannot be read"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line_and_nothing_is_written(csgmesh, decks, edits, status, told):
    found, _, err = csgmesh("edit", str(decks / "apart.json"), "-o", "e.json", *edits)
    assert (found, err.count("\n")) == (status, 1), err
    assert told in err
    assert not Path("e.json").exists()


@pytest.mark.parametrize(
    "given, told",
    [
        ("[]", "is no JSON deck|expected an object"),
        ('[{"op": "paint"}]', "edit 1: op is 'paint', expected one of merge, connect"),
        ('[{"op": "connect", "tol": 1}]', "edit 1: unknown field 'tol'"),
        ('[{"op": "add_node"}]', "edit 1: at is missing"),
        ("[3]", "edit 1: it is 3, expected an object"),
        ("{", "edits.json: is no JSON"),
        ("[" * 100_000, "edits.json: is no JSON"),
    ],
)
def test_a_file_of_edits_is_checked_before_anything_is_done(csgmesh, decks, given, told):
    Path("edits.json").write_text(given)
    deck = "edits.json" if given == "[]" else str(decks / "apart.json")
    status, _, err = csgmesh("edit", deck, "-o", "e.json", "edits.json")
    assert status == 2 and re.search(told, err), err


def test_one_deck_alone_is_not_merged(csgmesh, decks):
    assert csgmesh("merge", str(decks / "base.json"), "-o", "e.json")[0] == 2


def test_a_joint_is_left_apart(csgmesh):
    status, out, _ = csgmesh("mesh", str(EXAMPLES / "table.csg"), "-o", "t.bdf", "--size", "100", "--joint", "j1=apart")
    assert status == 0 and "components: 2" in out


def test_plates_meshed_apart_alike_become_what_they_are_meshed_together(csgmesh):
    # every edge of the webs falls on edges inside the others: read from a deck, those are on no curve yet
    lines = (
        "P = BLO(1000,600,10)",
        "G = BLO(12,600,200) AT (MOVX=494,MOVZ=10)",
        "S = BLO(1000,10,100) AT (MOVY=295,MOVZ=10)",
    )
    Path("crossing.csg").write_text("\n".join((*lines, "A = P UN G UN S\n")))
    size = ("--size", "50", "--json")
    assert csgmesh("mesh", "crossing.csg", "-o", "apart.json", "--apart", *size)[0] == 0
    status, out, err = csgmesh("connect", "apart.json", "-o", "joined.json", "--json")
    assert (status, err) == (0, "")
    _, together, _ = csgmesh("mesh", "crossing.csg", "-o", "together.json", *size)
    joined, meshed = json.loads(out), json.loads(together)
    assert joined["nodes"] == meshed["nodes"]
    assert joined["couplings"] == meshed["couplings"] == {}
    assert joined["components"] == 1
