"""Models over HTTP: sent in three ways, read at once, refused with the command line's message."""

import json

import pytest

PADL = """\
TOP = BLO(X=100, Y=60, Z=5)
HOLE = CYL(R=8, H=20) AT (MOVX=50, MOVY=30, MOVZ=-5)
PLATE = TOP DIF HOLE
OUT PLATE
"""
TEXT = {"Content-Type": "text/plain"}


def test_a_text_is_read_and_kept_where_location_says(client):
    answer = client.post("/v1/models?name=plate.csg", content=PADL, headers=TEXT)
    assert answer.status_code == 201
    kept = client.get(answer.headers["location"]).json()
    assert (kept["name"], kept["language"], kept["units"]) == ("plate.csg", "padl", "mm")
    assert kept in client.get("/v1/models").json()


def test_a_file_is_taken_by_its_name_without_its_folders(client):
    answer = client.post("/v1/models", files={"file": ("../../plate.csg", PADL)})
    assert answer.status_code == 201 and answer.json()["name"] == "plate.csg"


def test_a_tree_that_was_given_is_a_tree_that_is_taken(client):
    first = client.post("/v1/models", content=PADL, headers=TEXT).json()["id"]
    tree = client.get(f"/v1/models/{first}/tree").json()
    second = client.post("/v1/models", json=tree)
    assert second.status_code == 201 and second.json()["language"] == "json"
    assert client.get(f"/v1/models/{second.json()['id']}/tree").json()["root"] == tree["root"]


def test_the_text_comes_back_as_it_was_sent(client):
    model = client.post("/v1/models", content=PADL, headers=TEXT).json()["id"]
    assert client.get(f"/v1/models/{model}/text").text == PADL


def test_a_wrong_text_is_a_problem_with_its_place(client):
    answer = client.post("/v1/models?name=a.csg", content="cube(size = [1, 1, 1]);\nkube();\n", headers=TEXT)
    assert answer.status_code == 422
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json()["place"] == {"file": "a.csg", "line": 2, "column": 1}
    assert answer.json()["detail"].startswith("a.csg:2:1: ") and "\n" not in answer.json()["detail"]


@pytest.mark.parametrize(
    "content, headers, status",
    [
        (b"\xff\xfe", TEXT, 422),
        (b"", TEXT, 422),
        (b"{", {"Content-Type": "application/json"}, 422),
        (b"x", {"Content-Type": "image/png"}, 415),
        (b"x", {"Content-Type": "multipart/form-data; boundary=b"}, 400),
    ],
)
def test_what_is_no_model_is_refused(client, content, headers, status):
    answer = client.post("/v1/models", content=content, headers=headers)
    assert (answer.status_code, answer.headers["content-type"]) == (status, "application/problem+json")


def test_a_body_past_the_bound_is_refused_announced_or_not(client):
    def endless():
        for _ in range(60):
            yield b"!" * 1_000_000

    assert client.post("/v1/models", content=endless(), headers=TEXT).status_code == 413
    assert client.post("/v1/models", content=b"!" * 50_020_000, headers=TEXT).status_code == 413


def test_a_deleted_model_is_gone(client, block):
    assert client.delete(f"/v1/models/{block}").status_code == 204
    answer = client.get(f"/v1/models/{block}")
    assert answer.status_code == 404 and block in answer.json()["detail"]


def test_what_is_not_there_is_a_problem_too(client):
    for path in ("/v1/models/x", "/v1/jobs/x", "/v1/meshes/x", "/v1/nothing"):
        answer = client.get(path)
        assert (answer.status_code, answer.headers["content-type"]) == (404, "application/problem+json")


def test_the_service_says_that_it_lives(client):
    assert client.get("/healthz").json() == client.get("/readyz").json() == {"status": "ok"}


def test_every_operation_is_documented_with_an_example(client):
    document = client.get("/openapi.json").json()
    for path, operations in document["paths"].items():
        for method, operation in operations.items():
            where = f"{method} {path}"
            assert operation.get("description") or operation.get("summary"), where
            for kind, content in operation.get("requestBody", {}).get("content", {}).items():
                schema = content.get("schema", {})
                assert "example" in content or "examples" in content or "examples" in schema, f"{where} body {kind}"
            for status, response in operation["responses"].items():
                for kind, content in response.get("content", {}).items():
                    binary = kind == "model/gltf-binary"
                    assert binary or "example" in content, f"{where} {status} {kind}"
            for parameter in operation.get("parameters", []):
                if parameter["in"] == "query":
                    assert parameter["schema"].get("examples") or parameter.get("examples"), f"{where} {parameter}"
    assert "Problem" in document["components"]["schemas"]


@pytest.mark.parametrize(
    "body, told",
    [
        ({"sise": 3}, "unknown field 'sise', expected one of size, sizes, "),
        ({"sise": 3}, "did you mean 'size'?"),
        ({"order": 3}, "order is 3, expected 1 or 2"),
        ({"size": "abc"}, 'size is "abc", expected a valid number'),
        ('{"gap": Infinity}', "gap is Infinity, expected a finite number"),
        ([1, 2], "the body is [1, 2], expected an object with the fields size, sizes, "),
        ("{", "the body is no JSON: "),
    ],
)
def test_a_wrong_body_says_which_fields_it_may_have(client, block, body, told):
    content = body if isinstance(body, str) else json.dumps(body)
    answer = client.post(f"/v1/models/{block}/meshes", content=content, headers={"Content-Type": "application/json"})
    assert answer.status_code == 422 and told in answer.json()["detail"]


def test_an_unknown_path_is_named(client):
    answer = client.get("/v1/modles")
    assert answer.status_code == 404 and answer.json()["detail"].startswith("GET /v1/modles: there is no such path")
    assert client.patch("/v1/models").json()["detail"].startswith("PATCH /v1/models: this path knows no such method")


def test_a_name_of_several_nodes_cannot_be_overridden(client):
    feet = [{"kind": "block", "name": "FOOT", "size": size} for size in ([10, 10, 100], [10, 90, 10])]
    text = json.dumps({"root": {"kind": "union", "operands": feet}})
    model = client.post("/v1/models", content=text, headers={"Content-Type": "application/json"}).json()["id"]
    answer = client.put(f"/v1/models/{model}/overrides/FOOT", json={"type": "brick"})
    assert answer.status_code == 422 and "expected one of the paths 0, 1" in answer.json()["detail"]
    assert client.put(f"/v1/models/{model}/overrides/FEET", json={"type": "brick"}).status_code == 404
