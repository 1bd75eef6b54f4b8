"""Worker processes: errors come back as they were, crashes and cancellations hit one task only."""

import os
import threading
import time

import pytest

from app.workers import Worker, WorkerDied
from kernel.errors import DefectError, MeshError, Place, ReadError


def body(connection, _folder):
    """A worker for tests: does what the task's name says."""
    os.setsid()
    while True:
        try:
            number, task, payload = connection.recv()
        except EOFError:
            return
        if task == "echo":
            connection.send((number, "progress", "half", 0.5))
            connection.send((number, "done", payload))
        elif task == "refuse":
            connection.send((number, "failed", ReadError("wrong", place=Place("a.csg", 3, 5))))
        elif task == "stale":
            connection.send((number - 1, "done", "of another call"))
        elif task == "crash":
            os._exit(139)
        elif task == "sleep":
            if os.fork() == 0:
                time.sleep(60)
                os._exit(0)
            connection.send((number, "progress", "sleeping", 0.1))
            time.sleep(60)


@pytest.fixture(scope="module")
def worker(tmp_path_factory):
    worker = Worker(tmp_path_factory.mktemp("artifacts"), body)
    yield worker
    worker.stop()


def test_a_task_reports_progress_and_gives_its_result(worker):
    seen = []
    assert worker.call("echo", {"a": 1}, progress=lambda stage, share: seen.append((stage, share))) == {"a": 1}
    assert seen == [("half", 0.5)]


def test_an_error_comes_back_with_its_place(worker):
    with pytest.raises(ReadError) as caught:
        worker.call("refuse", {})
    assert str(caught.value) == "a.csg:3:5: wrong"


def test_a_crash_fails_its_task_and_the_next_task_is_done(worker):
    with pytest.raises(WorkerDied, match="died"):
        worker.call("crash", {})
    assert worker.call("echo", {"b": 2}) == {"b": 2}


def test_a_stopped_task_ends_at_once_with_its_children(worker):
    started = threading.Event()
    outcome = []

    def work():
        try:
            worker.call("sleep", {}, progress=lambda *_: started.set())
        except WorkerDied as error:
            outcome.append(error)

    thread = threading.Thread(target=work)
    thread.start()
    assert started.wait(30)
    group = worker._process.pid
    worker.stop()
    thread.join(30)  # the task alone would take sixty
    assert outcome and not thread.is_alive()
    for _ in range(300):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            break
        time.sleep(0.1)
    else:
        raise AssertionError("a child of the task still lives")


def test_a_task_past_its_deadline_is_stopped_and_says_so(worker):
    with pytest.raises(MeshError, match=r"longer than 0\.5 s"):
        worker.call("sleep", {}, deadline=0.5)


def test_a_report_that_fails_leaves_no_answer_for_the_next_task(worker):
    def locked(_stage, _share):
        raise ValueError("database is locked")

    with pytest.raises(ValueError, match="locked"):
        worker.call("echo", {"of": "first"}, progress=locked)
    assert worker.call("echo", {"of": "second"}) == {"of": "second"}


def test_an_answer_of_another_call_is_never_taken(worker):
    with pytest.raises(DefectError, match="answered task"):
        worker.call("stale", {})
    assert worker.call("echo", {"c": 3}) == {"c": 3}


def test_an_error_of_a_task_keeps_its_process(worker):
    worker.call("echo", {})
    process = worker._process
    with pytest.raises(ReadError):
        worker.call("refuse", {})
    assert worker._process is process


def test_a_worker_is_stopped_where_there_are_no_process_groups(tmp_path, monkeypatch):
    monkeypatch.setattr("app.workers.HAS_GROUPS", False)
    worker = Worker(tmp_path, body)
    worker.call("echo", {})
    process = worker._process
    worker.stop()
    assert not process.is_alive()
