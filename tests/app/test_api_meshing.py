"""Segments, overrides, jobs and meshes over HTTP: the same answers as the command line gives."""

import json
import time

import pytest

from app.cli import run

TEXT = {"Content-Type": "text/plain"}
TABLE = """\
UNITS MM
TOP = BLO(X=1500, Y=800, Z=25) AT (MOVZ=735)
LEG1 = BLO(X=50, Y=50, Z=735)
LEG2 = BLO(X=50, Y=50, Z=735) AT (MOVX=1450)
LEG3 = BLO(X=50, Y=50, Z=735) AT (MOVY=750)
LEG4 = BLO(X=50, Y=50, Z=735) AT (MOVX=1450, MOVY=750)
TABLE = TOP UN LEG1 UN LEG2 UN LEG3 UN LEG4
OUT TABLE
"""
BALL = "BALL = SPH(R=10)\nOUT BALL\n"


def send(client, text, name="table.csg"):
    return client.post(f"/v1/models?name={name}", content=text, headers=TEXT).json()["id"]


def wait_for(client, job_url, seconds=300):
    for _ in range(seconds * 20):
        job = client.get(job_url).json()
        if job["state"] in ("done", "failed", "cancelled"):
            return job
        time.sleep(0.05)
    raise AssertionError(f"the job still is {job}")


@pytest.fixture(scope="module")
def table(client):
    return send(client, TABLE)


@pytest.fixture(scope="module")
def mesh(client, table):
    answer = client.post(f"/v1/models/{table}/meshes", json={"size": 50})
    assert answer.status_code == 202
    job = wait_for(client, answer.headers["location"])
    assert job["state"] == "done", job
    return client.get(f"/v1/meshes/{job['mesh_id']}").json()


def test_segments_are_what_the_command_line_says(client, table, tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "table.csg").write_text(TABLE)
    assert run(["classify", "table.csg", "--json"]) == 0
    assert client.get(f"/v1/models/{table}/segments").json() == json.loads(capsys.readouterr().out)


def test_the_explanation_has_a_decision_for_every_segment(client, table):
    segments = client.get(f"/v1/models/{table}/segments").json()["segments"]
    decisions = client.get(f"/v1/models/{table}/explanation").json()["decisions"]
    assert {s["node"] for s in segments} <= {d["node"] for d in decisions}
    assert all(d["because"] and d["facts"] for d in decisions)


def test_the_explanation_of_a_node_shows_every_rule_as_the_command_line_does(
    client, table, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "table.csg").write_text(TABLE)
    assert run(["classify", "table.csg", "--explain", "TOP", "--json"]) == 0
    explained = client.get(f"/v1/models/{table}/explanation?node=TOP").json()
    assert explained == json.loads(capsys.readouterr().out)
    assert explained["decisions"][0]["rules"][0]["conditions"]
    assert client.get(f"/v1/models/{table}/explanation?node=NOWHERE").status_code in (404, 422)


def test_an_override_shows_its_author_and_reason_beside_what_the_rules_say(client):
    model = send(client, TABLE)
    client.put(f"/v1/models/{model}/overrides/TOP", json={"type": "brick", "reason": "stress", "author": "anna"})
    top = next(s for s in client.get(f"/v1/models/{model}/segments").json()["segments"] if s["name"] == "TOP")
    assert top["decision"]["override"] == {"type": "brick", "author": "anna", "reason": "stress"}
    assert top["decision"]["by_rule"] == "plate"
    (explained,) = client.get(f"/v1/models/{model}/explanation?node=TOP").json()["decisions"]
    assert explained["because_of"] == "override by anna: stress; the rules say plate"


def test_an_override_changes_the_segment_and_its_removal_changes_it_back(client):
    model = send(client, TABLE)
    answer = client.put(
        f"/v1/models/{model}/overrides/LEG1", json={"type": "brick", "reason": "stress", "author": "anna"}
    )
    assert answer.status_code == 200, answer.text
    path = answer.json()["node"]
    assert client.get(f"/v1/models/{model}/overrides").json() == [answer.json()]
    assert client.get(f"/v1/models/{model}/overrides/{path}").json()["reason"] == "stress"

    def leg():
        segments = client.get(f"/v1/models/{model}/segments").json()["segments"]
        return next(s for s in segments if s["name"] == "LEG1")

    assert (leg()["type"], leg()["origin"], leg()["decision"]["by_rule"]) == ("brick", "override", "beam")
    assert client.delete(f"/v1/models/{model}/overrides/{path}?author=ben").status_code == 204
    assert (leg()["type"], leg()["origin"]) == ("beam", "rule")
    history = client.get(f"/v1/models/{model}/overrides/history").json()
    assert [(e["type"], e["author"]) for e in history] == [("brick", "anna"), (None, "ben")]


def test_the_root_is_overridden_as_a_slash(client):
    model = send(client, TABLE)
    assert client.put(f"/v1/models/{model}/overrides/%2F", json={"type": "brick"}).json()["node"] == "/"
    segments = client.get(f"/v1/models/{model}/segments").json()["segments"]
    assert [s["type"] for s in segments] == ["brick"]


def test_an_override_that_cannot_be_is_refused_and_not_kept(client):
    model = send(client, BALL, "ball.csg")
    answer = client.put(f"/v1/models/{model}/overrides/%2F", json={"type": "beam"})
    assert answer.status_code == 422 and "beam" in answer.json()["detail"]
    assert answer.headers["content-type"] == "application/problem+json"
    assert client.get(f"/v1/models/{model}/overrides").json() == []


@pytest.mark.parametrize(
    "node, body, status",
    [("0.9", {"type": "brick"}, 404), ("%2F", {"type": "wood"}, 422), ("%2F", {"kind": "brick"}, 422)],
)
def test_a_wrong_override_is_a_problem(client, table, node, body, status):
    answer = client.put(f"/v1/models/{table}/overrides/{node}", json=body)
    assert (answer.status_code, answer.headers["content-type"]) == (status, "application/problem+json")


def test_a_mesh_is_connected_and_as_heavy_as_the_solid(mesh):
    assert mesh["components"] == 1 and mesh["checks"]["failures"] == []
    assert set(mesh["elements"]) == {"quad4", "line2"}
    assert abs(mesh["mass"]["error"]) < 1e-3


def test_a_tee_hangs_by_arms_where_that_is_asked(client):
    model = send(client, "TEE = BLO(200, 100, 4) UN (BLO(200, 6, 60) AT (MOVY=47, MOVZ=4))\nOUT TEE\n", "tee.csg")
    (joint,) = client.get(f"/v1/models/{model}/segments").json()["joints"]
    for wanted in ({"tee": "arms"}, {"joints": {joint["id"]: "arms"}}):
        answer = client.post(f"/v1/models/{model}/meshes", json={"size": 20, **wanted})
        job = wait_for(client, answer.headers["location"])
        mesh = client.get(f"/v1/meshes/{job['mesh_id']}").json()
        assert mesh["couplings"]["rbe2"] >= 10
        assert abs(mesh["mass"]["error"]) < 1e-9
    assert client.post(f"/v1/models/{model}/meshes", json={"tee": "glue"}).status_code == 422


@pytest.mark.parametrize(
    "name, start, ending",
    [("nastran", b"$", ".bdf"), ("gmsh", b"$MeshFormat", ".msh"), ("vtu", b"<?xml", ".vtu")],
)
def test_a_deck_is_there_in_every_format(client, mesh, name, start, ending):
    answer = client.get(f"/v1/meshes/{mesh['id']}/deck?format={name}")
    assert answer.status_code == 200 and answer.content.startswith(start)
    assert f'filename="table{ending}"' in answer.headers["content-disposition"]


def test_the_deck_is_the_one_that_the_command_line_writes(client, mesh, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "table.csg").write_text(TABLE)
    assert run(["mesh", "table.csg", "-o", "table.bdf", "--size", "50"]) == 0
    assert client.get(f"/v1/meshes/{mesh['id']}/deck").content == (tmp_path / "table.bdf").read_bytes()


def test_an_unknown_format_is_refused(client, mesh):
    answer = client.get(f"/v1/meshes/{mesh['id']}/deck?format=word")
    assert answer.status_code == 422 and "nastran" in answer.json()["detail"]


@pytest.mark.parametrize(
    "path", ["/v1/models/{model_id}/solid.glb", "/v1/models/{model_id}/segments.glb", "/v1/meshes/{id}/mesh.glb"]
)
def test_pictures_are_binary_gltf_that_others_read(client, mesh, path):
    import io

    import trimesh

    answer = client.get(path.format(**mesh))
    assert answer.headers["content-type"] == "model/gltf-binary"
    scene = trimesh.load(io.BytesIO(answer.content), file_type="glb")
    assert scene.extents == pytest.approx([1500, 800, 760 if "mesh" not in path else 747.5], abs=13)


def test_quality_is_a_part_of_the_mesh(client, mesh):
    assert client.get(f"/v1/meshes/{mesh['id']}/quality").json() == mesh["quality"]


def test_events_end_with_the_job(client, table):
    job = client.post(f"/v1/models/{table}/meshes", json={"size": 60}).headers["location"]
    with client.stream("GET", f"{job}/events") as stream:
        assert stream.headers["content-type"].startswith("text/event-stream")
        lines = [line for line in stream.iter_lines() if line]
    names = [line.removeprefix("event: ") for line in lines if line.startswith("event: ")]
    jobs = [json.loads(line.removeprefix("data: ")) for line in lines if line.startswith("data: ")]
    assert names[-1] == "done" and jobs[-1]["progress"] == 1.0
    assert [j["progress"] for j in jobs] == sorted(j["progress"] for j in jobs)


def test_the_same_mesh_is_not_made_twice(client, table, mesh):
    job = client.post(f"/v1/models/{table}/meshes", json={"size": 50}).json()
    assert (job["state"], job["mesh_id"]) == ("done", mesh["id"])


def test_a_node_may_have_a_size_of_its_own(client, table):
    job = client.post(f"/v1/models/{table}/meshes", json={"size": 100, "sizes": {"0": 40}}).headers["location"]
    with client.stream("GET", f"{job}/events") as stream:
        assert list(stream.iter_lines())
    size = client.get(f"/v1/meshes/{client.get(job).json()['mesh_id']}").json()["size"]
    assert size["value"] == 100
    assert size["segments"] == [{"segment": "s1", "size": 40, "because": "asked for 0"}]


def test_curves_are_seeded_over_http_as_on_the_command_line(client, table, tmp_path, monkeypatch, capsys):
    wanted = {"size": 100, "seeds": {"TOP&LEG2": 6, "LEG1": 9}, "curve_sizes": {"750,0,760": 20}, "growth": 1.3,
              "per_circle": 20, "layers": 2}  # fmt: skip
    job = client.post(f"/v1/models/{table}/meshes", json=wanted).headers["location"]
    with client.stream("GET", f"{job}/events") as stream:
        assert list(stream.iter_lines())
    mesh = client.get(job).json()["mesh_id"]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "table.csg").write_text(TABLE)
    given = ["--seeds", "TOP&LEG2=6", "--seeds", "LEG1=9", "--curve-size", "750,0,760=20", "--growth", "1.3"]
    given += ["--per-circle", "20", "--layers", "2", "--size", "100"]
    assert run(["mesh", "table.csg", "-o", "table.bdf", *given]) == 0
    assert client.get(f"/v1/meshes/{mesh}/deck").content == (tmp_path / "table.bdf").read_bytes()


def test_a_request_has_every_option_of_a_mesh():
    from app.api.meshing import MeshRequest
    from app.meshoptions import ASKED

    assert set(ASKED) <= set(MeshRequest.model_fields)


@pytest.mark.parametrize(
    "body, complaint",
    [
        ({"size": 0}, "size is 0"),
        ({"size": "big"}, "size"),
        ({"order": 3}, "order"),
        ({"sizes": {"0": -1}}, "size of '0' is -1, expected a positive number"),
        ({"sizes": {"0": "fine"}}, "fine"),
        ({"sizes": {"LID": 5}}, "size of 'LID': no node 'LID' in the model, expected '/'"),
        ({"curve_sizes": {"0": 0}}, "curve size of '0' is 0, expected a positive number"),
        ({"curve_sizes": {"1,2": 5}}, "curve size of '1,2': expected a point as x,y,z, such as 10,0,25"),
        ({"seeds": {"0&LID": 8}}, "seeds of 'LID': no node 'LID' in the model"),
        ({"seeds": {"0": 2.5}}, "2.5"),
        ({"seeds": {"0": 0}}, "seeds of '0' is 0, expected a whole number from 1"),
        ({"only": ["LID"]}, "only of 'LID': no node 'LID' in the model"),
        ({"joints": {"LID": "rigid"}}, "no joint 'LID'"),
        ({"joints": {"LID": "arms"}}, "no joint 'LID'"),
        ({"growth": 1}, "growth is 1, expected a ratio above 1, such as 1.2"),
        ({"per_circle": 2}, "per_circle is 2, expected a whole number from 4"),
        ({"layers": 0}, "layers is 0, expected a whole number from 1"),
        ({"material": "cheese"}, "cheese"),
        ({"material": "/etc/passwd"}, "/etc/passwd"),
        ({"units": "furlong"}, "furlong"),
        ({"colour": "red"}, "colour"),
    ],
)
def test_a_wrong_request_is_refused_before_it_is_queued(client, table, body, complaint):
    answer = client.post(f"/v1/models/{table}/meshes", json=body)
    assert answer.status_code == 422 and complaint in answer.json()["detail"]


@pytest.mark.parametrize(
    "body, complaint",
    [
        ({"only": ["s9"]}, "only of 's9': no node 's9' in the model"),
        ({"sizes": {"s9": 5}}, "or a segment from s1 to s"),
        ({"seeds": {"s1&s9": 4}}, "or a segment from s1 to s"),
        ({"joints": {"j99": "rigid"}}, "no joint 'j99' in the model, expected one of j1, j2"),
        ({"joints": {"j99": "arms"}}, "no joint 'j99' in the model, expected one of j1, j2"),
        ({"joints": {"j99": "apart"}}, "no joint 'j99' in the model, expected one of j1, j2"),
    ],
)
def test_ids_of_no_segment_and_no_joint_are_refused_before_they_are_queued_once_the_model_is_classified(
    client, body, complaint
):
    name = "".join(letter for letter in json.dumps(body) if letter.isalnum())
    own = send(client, TABLE, f"{name}.csg")
    unknown = client.post(f"/v1/models/{own}/meshes", json={**body, "size": 60})
    assert unknown.status_code == 202  # nobody knows its segments yet: the job says the same
    with client.stream("GET", f"{unknown.headers['location']}/events") as stream:
        assert list(stream.iter_lines())
    job = client.get(unknown.headers["location"]).json()
    assert job["problem"]["status"] == 422
    assert client.get(f"/v1/models/{own}/segments").status_code == 200
    answer = client.post(f"/v1/models/{own}/meshes", json=body)
    assert answer.status_code == 422 and complaint in answer.json()["detail"]
    assert client.post(f"/v1/models/{own}/meshes", json={"only": ["s1"], "size": 60}).status_code == 202


def test_a_cancelled_job_stays_cancelled_and_the_next_one_is_done(client, table):
    first, second = (client.post(f"/v1/models/{table}/meshes", json={"size": s}).headers["location"] for s in (2, 70))
    assert client.delete(first).status_code == 204
    assert client.get(first).json()["state"] == "cancelled"
    again = client.delete(first)
    assert again.status_code == 409 and "cancelled" in again.json()["detail"]
    assert wait_for(client, second)["state"] == "done"


def test_an_unknown_rule_base_is_not_found(client, table):
    assert client.get(f"/v1/models/{table}/segments?rulebase=house").status_code == 404
    assert client.get(f"/v1/models/{table}/segments?rulebase=base").status_code == 200


def test_a_node_called_history_is_overridden_by_its_path(client):
    model = send(client, "history = BLO(X=100, Y=60, Z=5)\nOUT history\n")
    assert client.put(f"/v1/models/{model}/overrides/%2F", json={"type": "brick"}).status_code == 200
    assert client.get(f"/v1/models/{model}/overrides/%2F").json()["type"] == "brick"
    assert [event["node"] for event in client.get(f"/v1/models/{model}/overrides/history").json()] == ["/"]


def test_a_stated_gap_joins_what_is_no_further_apart(client):
    nearly = "UNITS mm\nP = BLO(300,300,10) UN BLO(30,30,400) AT (MOVX=135, MOVY=135, MOVZ=10.2)\n"
    model = send(client, nearly, "nearly.csg")
    assert client.get(f"/v1/models/{model}/segments").json()["joints"] == []
    (joint,) = client.get(f"/v1/models/{model}/segments?gap=0.25").json()["joints"]
    assert (joint["kind"], joint["gap"]) == ("end_on", pytest.approx(0.2))
    answer = client.post(f"/v1/models/{model}/meshes", json={"size": 30, "gap": 0.25})
    job = wait_for(client, answer.headers["location"])
    assert job["state"] == "done", job
    assert client.get(f"/v1/meshes/{job['mesh_id']}").json()["components"] == 1


def test_a_gap_wider_than_a_wall_is_a_problem(client, table):
    answer = client.get(f"/v1/models/{table}/segments?gap=30")
    assert answer.status_code == 422
    assert "gap is 30, but s1 is only 25 thick" in answer.json()["detail"]


def test_a_segment_gets_a_material_of_its_own(client, table):
    answer = client.post(f"/v1/models/{table}/meshes", json={"size": 100, "materials": {"TOP": "aluminium"}})
    job = wait_for(client, answer.headers["location"])
    deck = client.get(f"/v1/meshes/{job['mesh_id']}/deck?format=nastran").text
    materials = [line for line in deck.splitlines() if line.startswith("MAT1")]
    assert len(materials) == 2
    heavy = client.post(f"/v1/models/{table}/meshes", json={"size": 100})
    whole = wait_for(client, heavy.headers["location"])
    light, steel = (client.get(f"/v1/meshes/{j['mesh_id']}").json()["mass"]["model"] for j in (job, whole))
    top = 1500 * 800 * 25 * 1e-9
    assert steel - light == pytest.approx(top * (7.85 - 2.7), rel=1e-6)


@pytest.mark.parametrize(
    ("materials", "said"), [({"TOP": "cheese"}, "unknown material 'cheese'"), ({"LID": "steel"}, "'LID'")]
)
def test_a_material_or_node_of_none_is_refused_at_once(client, table, materials, said):
    answer = client.post(f"/v1/models/{table}/meshes", json={"materials": materials})
    assert answer.status_code == 422
    assert said in answer.json()["detail"]
