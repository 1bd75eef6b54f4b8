"""Rule bases by command line and over HTTP: the same reports."""

import json
from pathlib import Path

import pytest

from app.cli import run

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
STRICTER = "name: stricter\nextends: base\nparameters:\n  beam_slenderness: {value: 16}\n"
WRONG = "name: wrong\nextends: base\nrules:\n  - id: bad\n    when: [slendernes >= 10]\n    then: {segment: beam}\n"
TEXT = {"Content-Type": "text/plain"}


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "stricter.yaml").write_text(STRICTER)
    (tmp_path / "wrong.yaml").write_text(WRONG)
    return tmp_path


@pytest.fixture
def rules(capsys, files):
    """Run a `rules` command; gives (status, standard output, standard error)."""

    def command(*arguments):
        status = run(["rules", *arguments])
        printed = capsys.readouterr()
        return status, printed.out, printed.err

    return command


@pytest.mark.parametrize("command", ["check", "test", "coverage", "docs"])
def test_the_own_rule_base_is_in_order(rules, command):
    status, out, err = rules(command)
    assert (status, err) == (0, "") and out
    status, out, err = rules(command, "--json")
    assert (status, err) == (0, "") and isinstance(json.loads(out), dict)


def test_a_wrong_rule_base_is_reported_with_places_and_fails(rules):
    status, out, err = rules("check", "wrong.yaml")
    assert status == 2 and err == "error: wrong.yaml: wrong, expected no errors\n"
    assert "wrong.yaml:5:" in out and "did you mean 'slenderness'" in out


def test_a_missing_rule_file_is_one_line(rules):
    status, out, err = rules("test", "none.yaml")
    assert (status, out) == (2, "") and "none.yaml" in err and err.count("\n") == 1


def test_diff_names_the_nodes_that_change(rules):
    status, out, err = rules("diff", "base", "stricter.yaml", str(EXAMPLES / "table.csg"), "--json")
    assert (status, err) == (0, "")
    changed = [change for change in json.loads(out)["changes"] if change["before"] == "beam"]
    assert len(changed) == 4


def test_diff_over_a_folder_takes_its_models_and_says_how_each_node_changes(rules, tmp_path):
    folder = tmp_path / "models"
    folder.mkdir()
    (folder / "table.csg").write_text((EXAMPLES / "table.csg").read_text())
    (folder / "cube.json").write_text('{"root": {"kind": "block", "size": [9, 9, 9]}}')
    (folder / "answers.json").write_text('{"table": []}')
    status, out, err = rules("diff", "base", "stricter.yaml", str(folder))
    assert (status, err) == (0, "")
    head, *lines = out.splitlines()
    assert head.startswith("base ") and "nodes change" in head
    legs = [line for line in lines if "table.csg" in line and "beam (slender-prism-is-beam) -> brick (" in line]
    assert len(legs) == 4
    status, out, err = rules("diff", "base", "stricter.yaml", str(folder), "--json")
    report = json.loads(out)
    assert report["ok"] is False and len(report["changes"]) == len(lines)
    assert {"node", "before", "after", "rule_before", "rule_after", "because"} == set(report["changes"][0])


def test_diff_over_a_folder_without_models_is_refused(rules, tmp_path):
    (tmp_path / "empty").mkdir()
    status, out, err = rules("diff", "base", "stricter.yaml", str(tmp_path / "empty"))
    assert (status, out) == (2, "") and "no models in this folder" in err and err.count("\n") == 1


def test_diff_without_models_asks_the_cases(rules):
    status, out, err = rules("diff", "base", "base")
    assert (status, err) == (0, "") and "0 of" in out


def test_a_rule_base_decides_where_it_is_asked_for(rules, capsys):
    assert run(["classify", str(EXAMPLES / "table.csg"), "--rules", "stricter.yaml", "--json"]) == 0
    types = [segment["type"] for segment in json.loads(capsys.readouterr().out)["segments"]]
    assert "beam" not in types


def test_a_sent_rule_base_is_kept_checked_tested_compared_and_activated(client):
    sent = client.post("/v1/rulebases", json={"text": STRICTER, "author": "anna"})
    assert sent.status_code == 201
    where, version = sent.headers["location"], sent.json()["version"]
    assert client.get(where).json()["text"] == STRICTER
    assert client.post(f"{where}/validate").json()["ok"]
    assert client.post(f"{where}/test").status_code == 200
    table = (EXAMPLES / "table.csg").read_text()
    model = client.post("/v1/models?name=table.csg", content=table, headers=TEXT).json()["id"]
    changes = client.post(f"{where}/diff", json={"against": "base", "models": [model]}).json()["changes"]
    assert len([change for change in changes if change["before"] == "beam"]) == 4

    def types(query=""):
        return {s["type"] for s in client.get(f"/v1/models/{model}/segments{query}").json()["segments"]}

    assert "beam" in types() and "beam" not in types("?rulebase=stricter")
    assert "beam" not in types(f"?rulebase=stricter@{version}")
    listed = client.post(f"{where}/activate").json()
    assert [(b["name"], b["is_active"]) for b in listed] == [("base", False), ("stricter", True)]
    assert "beam" not in types() and "beam" in types("?rulebase=base")
    own = listed[0]["version"]
    assert client.post(f"/v1/rulebases/base/versions/{own}/activate").json()[0]["is_active"]
    assert "rules:" in client.get(f"/v1/rulebases/base/versions/{own}").json()["text"]
    assert "beam" in types()


@pytest.mark.parametrize("name", ["a/b", "a@b", ".."])
def test_a_rule_base_whose_name_no_address_could_hold_is_not_kept(client, name):
    answer = client.post("/v1/rulebases", json={"text": f"name: '{name}'\nextends: base\n"})
    assert answer.status_code == 422 and f"the name {name!r} cannot stand in an address" in answer.json()["detail"]
    assert name not in [base["name"] for base in client.get("/v1/rulebases").json()]


def test_a_wrong_rule_base_is_not_kept_and_its_place_is_named(client):
    answer = client.post("/v1/rulebases", json={"text": WRONG})
    assert answer.status_code == 422 and answer.json()["place"]["line"] == 5
    assert "wrong" not in [base["name"] for base in client.get("/v1/rulebases").json()]
    report = client.post("/v1/rulebases/validate", json={"text": WRONG}).json()
    assert not report["ok"] and report["findings"][0]["line"] == 5


def test_the_own_name_is_taken_and_unknown_versions_are_not_found(client):
    assert client.post("/v1/rulebases", json={"text": "name: base\nextends: base\n"}).status_code in (409, 422)
    assert client.get("/v1/rulebases/base/versions/0").status_code == 404
    assert client.get("/v1/rulebases/none/versions/0").status_code == 404
