"""GET /metrics: what Prometheus reads."""

import time

import pytest
from fastapi.testclient import TestClient
from prometheus_client.parser import text_string_to_metric_families

from app.api.server import create_app
from app.settings import load_settings

BLOCK = "cube(size = [100, 60, 5], center = false);\n"


@pytest.fixture
def client(tmp_path):
    with TestClient(create_app(load_settings(data=str(tmp_path), workers=1)), raise_server_exceptions=False) as client:
        yield client


def samples(client):
    answer = client.get("/metrics")
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/plain")
    return {
        (sample.name, *sorted(sample.labels.items())): sample.value
        for family in text_string_to_metric_families(answer.text)
        for sample in family.samples
    }


def requests(route, status, method="GET"):
    return ("csgmesh_requests_total", ("method", method), ("route", route), ("status", str(status)))


def test_requests_are_counted_by_route_and_not_by_path(client):
    model = client.post("/v1/models?name=a.csg", content=BLOCK, headers={"Content-Type": "text/plain"}).json()["id"]
    for path in (f"/v1/models/{model}", "/v1/models/one", "/v1/models/two", "/never", "/neither", "/web/style.css"):
        client.get(path)
    seen = samples(client)
    assert seen[requests("/v1/models", 201, "POST")] == 1
    assert seen[requests("/v1/models/{model_id}", 200)] == 1
    assert seen[requests("/v1/models/{model_id}", 404)] == 2
    assert seen[requests("none", 404)] == 2
    assert seen[("csgmesh_request_seconds_count", ("method", "GET"), ("route", "/v1/models/{model_id}"))] == 3
    assert not any("/never" in str(key) for key in seen)
    assert seen[("csgmesh_models",)] == 1


def test_jobs_and_workers_are_counted_as_they_are(client):
    seen = samples(client)
    assert {seen[("csgmesh_jobs", ("state", state))] for state in ("queued", "running", "done", "failed")} == {0}
    assert seen[("csgmesh_workers", ("state", "idle"))] == 1
    store = client.app.state.context.store
    model = store.add_model(name="a", ending=".csg", text="0" * 64, language="openscad", units="mm")
    job = store.add_job(model.id, "key", {"task": "nothing that is done"})
    for _ in range(6000):
        if store.job(job.id).state == "failed":
            break
        time.sleep(0.05)
    seen = samples(client)
    assert seen[("csgmesh_jobs", ("state", "failed"))] == 1
    assert seen[("csgmesh_meshes",)] == 0


def test_two_services_in_one_process_count_apart(client, tmp_path):
    client.get("/healthz")
    other = create_app(load_settings(data=str(tmp_path / "other"), workers=1))
    with TestClient(other) as second:
        assert requests("/healthz", 200) not in samples(second)
    assert samples(client)[requests("/healthz", 200)] == 1
