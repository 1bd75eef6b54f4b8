"""POST /v1/meshes/{id}/edits: a job that makes another mesh of one, with its parent and its history."""

import pytest
from test_api_meshing import send, wait_for

ANGLE = """\
UNITS MM
BASE = BLO(X=100, Y=60, Z=5)
WALL = BLO(X=5, Y=60, Z=85)
ANGLE = BASE UN WALL
OUT ANGLE
"""


def meshed(client, model, **options):
    job = wait_for(client, client.post(f"/v1/models/{model}/meshes", json=options).headers["location"])
    assert job["state"] == "done", job
    return client.get(f"/v1/meshes/{job['mesh_id']}").json()


def edit(client, mesh, *edits, **options):
    answer = client.post(f"/v1/meshes/{mesh}/edits", json={"edits": list(edits), **options})
    assert answer.status_code == 202, answer.text
    return wait_for(client, answer.headers["location"])


def edited(client, mesh, *edits, **options):
    job = edit(client, mesh, *edits, **options)
    assert job["state"] == "done", job
    return client.get(f"/v1/meshes/{job['mesh_id']}").json()


@pytest.fixture(scope="module")
def angle(client):
    return send(client, ANGLE, "angle.csg")


@pytest.fixture(scope="module")
def apart(client, angle):
    return meshed(client, angle, size=10, apart=True)


def test_meshed_apart_and_connected(client, angle, apart):
    assert (apart["components"], apart["checks"]["failures"], apart["parent"]) == (2, [], None)
    mesh = edited(client, apart["id"], {"op": "connect", "tolerance": 0.01})
    assert (mesh["components"], mesh["checks"]["failures"]) == (1, [])
    assert (mesh["parent"], mesh["model_id"]) == (apart["id"], angle)
    assert mesh["edits"] == [{"op": "connect", "tolerance": 0.01, "segments": None}]
    assert mesh["history"][0].startswith("connected within 0.01: ")
    assert abs(mesh["mass"]["error"]) < 1e-3
    assert client.get(f"/v1/meshes/{apart['id']}").json() == apart  # the parent stays as it is
    deck = client.get(f"/v1/meshes/{mesh['id']}/deck?format=nastran")
    assert b"note: edited: connected within 0.01" in deck.content and 'filename="angle.bdf"' in str(deck.headers)
    assert client.get(f"/v1/meshes/{mesh['id']}/mesh.glb").content[:4] == b"glTF"
    assert client.get(f"/v1/meshes/{mesh['id']}/quality").json() == mesh["quality"]


def test_parts_meshed_alone_are_merged_and_connected_and_edited_on(client, angle):
    base, wall = (meshed(client, angle, size=size, only=[name]) for name, size in (("s1", 10), ("s2", 7)))
    assert base["components"] == wall["components"] == 1
    both = edited(client, base["id"], {"op": "merge", "mesh": wall["id"]})
    assert both["components"] == 2 and both["nodes"] == base["nodes"] + wall["nodes"]
    one = edited(client, both["id"], {"op": "connect"})
    assert (one["components"], one["checks"]["failures"]) == (1, [])
    assert one["couplings"].keys() == {"mpc"}
    more = edited(client, one["id"], {"op": "add_node", "at": [61, 33, 2.5]})
    assert [line.split()[0].strip(":") for line in more["history"]] == ["merged", "connected", "added"]
    assert more["mass"]["error"] == pytest.approx(one["mass"]["error"], abs=1e-9)


def test_another_model_is_merged_with_its_segments_renamed(client, apart):
    other = send(client, "BOX = BLO(X=40, Y=30, Z=20) AT (MOVX=500)\nOUT BOX\n", "box.csg")
    box = meshed(client, other, size=10)
    mesh = edited(client, apart["id"], {"op": "merge", "mesh": box["id"]})
    assert [segment["id"] for segment in mesh["segments"]] == ["s1", "s2", "s3"]
    assert mesh["model"] == "angle.csg + box.csg"
    assert mesh["volume"] == pytest.approx(apart["volume"] + 24000)
    gone = edited(client, mesh["id"], {"op": "delete_segment", "segment": "s3"})
    assert [segment["id"] for segment in gone["segments"]] == ["s1", "s2"]
    assert gone["mass"]["model"] == pytest.approx(apart["mass"]["model"])


def test_the_same_edits_of_the_same_mesh_are_the_same_mesh(client, apart):
    first, second = (edit(client, apart["id"], {"op": "connect", "tolerance": 0.02}) for _ in range(2))
    assert first["id"] != second["id"] and first["mesh_id"] == second["mesh_id"]


def test_an_edit_that_fails_fails_its_job_with_the_edits_number(client, apart):
    job = edit(client, apart["id"], {"op": "connect"}, {"op": "add_node", "at": [0, 0, 999]})
    assert job["state"] == "failed" and job["mesh_id"] is None
    assert (job["problem"]["status"], job["problem"]["detail"][:19]) == (422, "edit 2 (add_node): ")
    job = edit(client, apart["id"], {"op": "connect", "tolerance": 6})
    assert job["problem"]["status"] == 409 and "under half of that" in job["problem"]["detail"]


def test_a_mesh_that_does_not_pass_its_checks_is_kept_only_on_request(client):
    text = "P = BLO(200, 200, 10)\nB = CYL(R=60, H=60) AT (MOVX=100, MOVY=100, MOVZ=10)\nC = P UN B\n"
    boss = send(client, text, "boss.csg")
    coarse = meshed(client, boss, size=60, per_circle=8, unchecked=True)
    assert coarse["checks"]["failures"]  # chords of 45 degrees cut off more mass than the check allows
    job = edit(client, coarse["id"], {"op": "add_node", "at": [20, 30, 5]})
    assert job["state"] == "failed" and "does not pass its checks: the mass" in job["problem"]["detail"]
    mesh = edited(client, coarse["id"], {"op": "add_node", "at": [20, 30, 5]}, unchecked=True)
    assert mesh["checks"]["failures"]


@pytest.mark.parametrize(
    "body, status, told",
    [
        ({"edits": []}, 422, "edits is \\[\\]"),
        ({"edits": [{"op": "paint"}]}, 422, "edits.0.op is \"paint\", expected one of 'merge', 'connect', 'add_node'"),
        ({"edits": [{"op": "connect", "tolerance": 0}]}, 422, "tolerance is 0, expected greater than 0"),
        ({"edits": [{"op": "connect", "segments": ["s1"]}]}, 422, "segments"),
        ({"edits": [{"op": "connect", "tol": 1}]}, 422, "unknown field 'edits.0.connect.tol'"),
        ({"edits": [{"op": "add_node", "at": [1, 2]}]}, 422, "at"),
        ({"edits": [{"op": "add_node", "at": [1, 2, "x"]}]}, 422, 'at.2 is "x"'),
        ({"edits": [{"op": "merge", "mesh": "nowhere"}]}, 404, "no mesh 'nowhere'"),
        ({"edit": []}, 422, "edit"),
    ],
)
def test_a_wrong_request_is_refused_before_it_is_queued(client, apart, body, status, told):
    import re

    answer = client.post(f"/v1/meshes/{apart['id']}/edits", json=body)
    assert answer.status_code == status, answer.text
    assert answer.headers["content-type"] == "application/problem+json"
    assert re.search(told, answer.json()["detail"]), answer.text


def test_more_edits_than_the_meshes_nodes_allow_are_refused_before_they_are_queued(client, apart, monkeypatch):
    monkeypatch.setattr("app.editing.MOST_WORK", 3 * apart["nodes"])
    edits = [{"op": "add_node", "at": [61, 33, 2.5]}] * 4
    answer = client.post(f"/v1/meshes/{apart['id']}/edits", json={"edits": edits})
    assert answer.status_code == 422
    assert f"4 edits of {apart['nodes']} nodes, expected at most 3 in one request" in answer.json()["detail"]
    merged = client.post(f"/v1/meshes/{apart['id']}/edits", json={"edits": [{"op": "merge", "mesh": apart["id"]}] * 2})
    assert "expected at most 1 in one request" in merged.json()["detail"]


def test_no_mesh_no_edits(client):
    assert client.post("/v1/meshes/nowhere/edits", json={"edits": [{"op": "connect"}]}).status_code == 404
