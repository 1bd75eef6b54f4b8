"""Jobs outlive the server, and the server outlives a crash."""

import threading
import time

import pytest
from fastapi.testclient import TestClient
from sqlalchemy.exc import OperationalError

from app.api.server import create_app
from app.jobs import INTERACTIVE_WORKERS, MOST_ATTEMPTS
from app.settings import load_settings
from app.store import Store

PLATE = "cube(size = [400, 300, 5], center = false);\n"
TEXT = {"Content-Type": "text/plain"}


def wait_until(condition, seconds=300.0):
    for _ in range(int(seconds * 50)):
        if condition():
            return
        time.sleep(0.02)
    raise AssertionError("it did not happen")


def submit(client, size):
    model = client.post("/v1/models", content=PLATE, headers=TEXT).json()["id"]
    return client.post(f"/v1/models/{model}/meshes", json={"size": size}).headers["location"]


def state(client, job):
    return client.get(job).json()["state"]


@pytest.fixture
def settings(tmp_path):
    return load_settings(data=str(tmp_path), workers=1)


def test_what_was_queued_or_running_when_the_server_stopped_is_done_by_the_next(tmp_path, database):
    settings = load_settings(data=str(tmp_path), database=database, workers=1)
    with TestClient(create_app(settings)) as client:
        running, queued = submit(client, 20), submit(client, 25)
        wait_until(lambda: state(client, running) == "running")
    with TestClient(create_app(settings)) as client:
        wait_until(lambda: state(client, running) == state(client, queued) == "done")


def test_a_crashed_worker_fails_its_job_and_the_next_job_is_done(settings):
    with TestClient(create_app(settings)) as client:
        first, second = submit(client, 20), submit(client, 25)
        wait_until(lambda: state(client, first) == "running")
        worker = client.app.state.context.jobs._workers[0]
        wait_until(lambda: worker._process is not None)
        worker._process.kill()
        wait_until(lambda: state(client, first) == "failed")
        problem = client.get(first).json()["problem"]
        assert problem["status"] == 500 and "died" in problem["detail"]
        wait_until(lambda: state(client, second) == "done")


def test_a_job_that_cannot_be_done_says_why(settings):
    with TestClient(create_app(settings)) as client:
        cone = "cylinder($fn = 0, $fa = 12, $fs = 2, h = 20, r1 = 10, r2 = 0, center = false);\n"
        model = client.post("/v1/models?name=cone.csg", content=cone, headers=TEXT).json()["id"]
        job = client.post(f"/v1/models/{model}/meshes", json={"volumes": "hex"}).headers["location"]
        wait_until(lambda: state(client, job) == "failed")
        problem = client.get(job).json()["problem"]
        assert problem["status"] == 409 and "s1" in problem["detail"]


def test_a_job_that_killed_the_service_too_often_says_so(settings):
    store = Store(settings.database)
    model = store.add_model(name="a.csg", ending="csg", text="0" * 64, language="padl", units="mm").id
    job = store.add_job(model, "a", {}).id
    for _ in range(MOST_ATTEMPTS):
        store.claim_job()
        store.requeue_unfinished(MOST_ATTEMPTS)
    store.close()
    with TestClient(create_app(settings)) as client:
        answer = client.get(f"/v1/jobs/{job}")
        assert answer.status_code == 200 and answer.json()["state"] == "failed"
        problem = answer.json()["problem"]
        assert problem["status"] == 500 and problem["detail"] == "defect: the process died 3 times at this job"


def test_progress_that_cannot_be_noted_does_not_fail_the_job(settings, monkeypatch):
    def locked(*_):
        raise OperationalError("UPDATE jobs", {}, Exception("database is locked"))

    monkeypatch.setattr(Store, "report_progress", locked)
    with TestClient(create_app(settings)) as client:
        job = submit(client, 50)
        wait_until(lambda: state(client, job) in ("done", "failed"))
        assert state(client, job) == "done"


def test_a_long_request_holds_up_neither_another_nor_an_answer_that_is_known(settings):
    other = PLATE.replace("5]", "6]")
    with TestClient(create_app(settings)) as client:
        context = client.app.state.context
        model = client.post("/v1/models", content=PLATE, headers=TEXT).headers["location"]
        assert client.get(f"{model}/tree").status_code == 200
        held = [context.jobs._idle.get() for _ in range(INTERACTIVE_WORKERS - 1)]
        assert client.post("/v1/models", content=other, headers=TEXT).status_code == 201
        held.append(context.jobs._idle.get())
        assert client.get(f"{model}/tree").status_code == 200
        answers = []
        unknown = {"text": other.replace("6]", "7]"), "name": "c.csg"}
        waiting = threading.Thread(target=lambda: answers.append(context.ask("read", unknown)))
        waiting.start()
        waiting.join(0.2)
        assert waiting.is_alive() and answers == []
        for worker in held:
            context.jobs._idle.put(worker)
        waiting.join(30)
        assert answers[0]["language"] == "openscad"


def test_too_many_requests_for_long_work_are_told_to_come_again_and_others_are_answered(settings, monkeypatch):
    monkeypatch.setattr("app.jobs.MOST_WAITING", 1)
    with TestClient(create_app(settings)) as client:
        jobs = client.app.state.context.jobs
        model = client.post("/v1/models", content=PLATE, headers=TEXT).headers["location"]
        held = [jobs._idle.get() for _ in range(INTERACTIVE_WORKERS)]
        calls = [threading.Thread(target=jobs.call, args=("read", {"text": PLATE, "name": "a"})) for _ in range(3)]
        for call in calls:  # as many as there are workers, and one that may wait
            call.start()
        wait_until(lambda: jobs._waiting._value == 0)
        refused = client.get(f"{model}/segments")
        assert refused.status_code == 503 and refused.headers["retry-after"] == "5"
        assert refused.headers["content-type"] == "application/problem+json"
        assert "1 requests wait" in refused.json()["detail"]
        assert client.get("/healthz").status_code == client.get(model).status_code == 200
        for worker in held:
            jobs._idle.put(worker)
        for call in calls:
            call.join(60)
        assert client.get(f"{model}/segments").status_code == 200


def test_more_jobs_than_may_wait_are_told_to_come_again(settings, monkeypatch):
    monkeypatch.setattr("app.jobs.MOST_QUEUED", 2)
    with TestClient(create_app(settings)) as client:
        model = client.post("/v1/models", content=PLATE, headers=TEXT).headers["location"]
        first, second, refused = (client.post(f"{model}/meshes", json={"size": size}) for size in (20, 25, 30))
        assert (first.status_code, second.status_code, refused.status_code) == (202, 202, 503)
        assert "2 jobs wait already" in refused.json()["detail"] and refused.headers["retry-after"] == "5"
        assert client.delete(second.headers["location"]).status_code == 204
        assert client.post(f"{model}/meshes", json={"size": 30}).status_code == 202
