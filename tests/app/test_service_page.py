"""docs/service.md: its walk is walked, so that it stays true."""

from pathlib import Path

import pytest
from test_api_meshing import wait_for

from app.api.meshing import MeshRequest

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "service.md").read_text()


def test_every_field_of_a_mesh_request_is_named():
    for field in MeshRequest.model_fields:
        assert f"`{field}`" in PAGE or f'"{field}"' in PAGE, field


def test_the_walk_from_a_model_to_its_deck(client):
    with (ROOT / "examples" / "table.padl.csg").open("rb") as file:
        sent = client.post("/v1/models", files={"file": file})
    assert sent.status_code == 201 and sent.json()["name"] == "table.padl.csg"
    model = sent.headers["location"]
    for segment in client.get(f"{model}/segments").json()["segments"]:
        decision = segment["decision"]["because"]
        assert f"{segment['id']} {segment['node']} {segment['name']} {segment['type']} {decision}" in PAGE
    decided = client.put(f"{model}/overrides/LEG1", json={"type": "brick", "reason": "bolted foot", "author": "anna"})
    assert decided.json()["node"] == "1"
    job = client.post(f"{model}/meshes", json={"size": 50}).headers["location"]
    state = wait_for(client, job)
    assert state["state"] == "done", state
    mesh = client.get(f"/v1/meshes/{state['mesh_id']}").json()
    assert set(mesh["elements"]) == {"quad4", "hex8", "line2"} and mesh["components"] == 1
    deck = client.get(f"/v1/meshes/{state['mesh_id']}/deck?format=nastran").text
    for line in deck.splitlines()[:3]:
        assert f"    {line}\n" in PAGE
    refused = client.post(f"{model}/meshes", json={"sise": 50})
    assert refused.status_code == 422 and "did you mean 'size'?" in refused.json()["detail"]


@pytest.mark.parametrize("path", ["/docs", "/openapi.json", "/v1/formats", "/"])
def test_the_paths_that_it_names_are_there(client, path):
    assert client.get(path).status_code == 200
