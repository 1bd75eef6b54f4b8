"""The service with its jobs on a dask cluster."""

import json
import re
import subprocess
import sys
import time
import urllib.error
import urllib.request

import pytest
from dask_cluster import environment

from app.cli import run

PLATE = "cube(size = [400, 300, 5], center = false);\n"
BORED = "B = SPH(R=10) DIF CYL(R=2, H=40) AT (MOVX=5, MOVZ=-20)\nOUT B\n"


@pytest.fixture(scope="module")
def url(cluster, tmp_path_factory):
    data = str(tmp_path_factory.mktemp("data"))
    command = [sys.executable, "-c", "from app.cli import main; main()", "serve", "--port", "0", "--data", data]
    with subprocess.Popen(
        [*command, "--scheduler", cluster], stderr=subprocess.PIPE, text=True, env=environment()
    ) as service:
        yield re.search(r"http://[\d.:]+", service.stderr.readline()).group()
        service.terminate()
        service.communicate(timeout=300)


def ask(url, method="GET", data=None, content_type="application/json"):
    request = urllib.request.Request(url, data, {"Content-Type": content_type}, method=method)
    with urllib.request.urlopen(request, timeout=300) as answer:
        return answer.read()


def submit(url, text, **wanted):
    model = json.loads(ask(f"{url}/v1/models?name=a.csg", "POST", text.encode(), "text/plain"))["id"]
    return json.loads(ask(f"{url}/v1/models/{model}/meshes", "POST", json.dumps(wanted).encode()))["id"]


def ended(url, job):
    for _ in range(6000):
        found = json.loads(ask(f"{url}/v1/jobs/{job}"))
        if found["state"] not in ("queued", "running"):
            return found
        time.sleep(0.05)
    raise AssertionError(found)


def test_a_job_on_the_cluster_gives_the_deck_of_the_command_line(url, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.csg").write_text(PLATE)
    assert run(["mesh", "a.csg", "-o", "a.bdf", "--size", "20"]) == 0
    job = ended(url, submit(url, PLATE, size=20))
    assert (job["state"], job["progress"]) == ("done", 1.0)
    assert ask(f"{url}/v1/meshes/{job['mesh_id']}/deck?format=nastran") == (tmp_path / "a.bdf").read_bytes()
    # an edit is done here, where the mesh is
    edit = {"edits": [{"op": "move_node", "at": [20.0, 18.75, 2.5], "to": [22.0, 20.0, 2.5]}]}
    edited = json.loads(ask(f"{url}/v1/meshes/{job['mesh_id']}/edits", "POST", json.dumps(edit).encode()))["id"]
    assert ended(url, edited)["state"] == "done"


def test_what_cannot_be_meshed_fails_with_the_reason(url):
    job = ended(url, submit(url, BORED, volumes="hex"))
    assert (job["state"], job["problem"]["status"]) == ("failed", 409)
    assert job["problem"]["detail"].startswith("s1 (/)")


def test_a_job_is_cancelled_and_the_next_one_is_done(url):
    first = submit(url, PLATE, size=1)
    ask(f"{url}/v1/jobs/{first}", "DELETE")
    assert ended(url, first)["state"] == "cancelled"
    assert ended(url, submit(url, PLATE, size=30))["state"] == "done"


def test_a_scheduler_that_is_not_there_is_named(tmp_path, capsys, monkeypatch):
    import app.cluster

    monkeypatch.setattr(app.cluster, "PATIENCE", 0.3)
    assert run(["serve", "--port", "0", "--data", str(tmp_path), "--scheduler", "tcp://127.0.0.1:1"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: no scheduler answers at tcp://127.0.0.1:1")
