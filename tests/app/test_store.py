"""The store: the job table is the truth."""

import pytest

from app.artifacts import Artifacts
from app.store import Outcome, Store
from kernel.errors import DefectError, OptionError


@pytest.fixture
def store(tmp_path):
    store = Store(f"sqlite:///{tmp_path / 'state.db'}")
    yield store
    store.close()


@pytest.fixture
def model(store):
    return store.add_model(name="a.csg", ending="csg", text="0" * 64, language="padl", units="mm").id


def test_jobs_are_claimed_once_and_in_their_order(store, model):
    first, second = (store.add_job(model, key, {"n": key}).id for key in "ab")
    assert [store.claim_job().id, store.claim_job().id] == [first, second]
    assert store.claim_job() is None


def test_a_job_that_ran_when_the_process_died_is_queued_again(store, model):
    job = store.add_job(model, "a", {}).id
    store.claim_job()
    assert store.requeue_unfinished(most_attempts=3) == 1
    assert store.job(job).state == "queued"
    assert store.claim_job().attempts == 2


def test_a_job_that_killed_the_process_too_often_fails(store, model):
    job = store.add_job(model, "a", {}).id
    store.claim_job()
    assert store.requeue_unfinished(most_attempts=1) == 0
    assert store.job(job).state == "failed" and "died" in store.job(job).problem


def test_a_cancelled_job_stays_cancelled_whatever_its_worker_says_later(store, model):
    job = store.add_job(model, "a", {}).id
    store.claim_job()
    assert store.finish_job(job, Outcome("cancelled"))
    assert not store.finish_job(job, Outcome("done", mesh="m"))
    store.report_progress(job, "mesh", 0.9)
    assert (store.job(job).state, store.job(job).mesh, store.job(job).progress) == ("cancelled", None, 0.0)


def test_a_mesh_that_is_there_already_is_not_made_twice(store, model):
    mesh = store.add_mesh(model_id=model, key="a", answer="0" * 64, content="1" * 64)
    job = store.add_job(model, "a", {})
    assert (job.state, job.mesh) == ("done", mesh.id)
    assert store.claim_job() is None


def test_history_keeps_what_was_set_and_taken_back(store, model):
    store.set_override(model, "0.1", "brick", "anna", "stress wanted")
    store.set_override(model, "0.1", "plate", "ben", "too dear")
    assert store.remove_override(model, "0.1", "anna", "done")
    assert not store.remove_override(model, "0.1", "anna", "again")
    assert [(e.type, e.author) for e in store.override_history(model)] == [
        ("brick", "anna"),
        ("plate", "ben"),
        (None, "anna"),
    ]
    assert list(store.overrides(model)) == []


def test_a_deleted_model_takes_everything_of_it_along(store, model):
    job = store.add_job(model, "a", {}).id
    store.set_override(model, "/", "brick", "anna", "")
    assert store.delete_model(model) and not store.delete_model(model)
    assert store.job(job) is None and list(store.overrides(model)) == []


def test_only_one_rule_base_is_active(store):
    store.add_rule_base("house", "v1", "0" * 64, "anna")
    store.add_rule_base("house", "v2", "1" * 64, "anna")
    store.activate_rule_base("house", "v1")
    store.activate_rule_base("house", "v2")
    assert store.active_rule_base().version == "v2"
    store.activate_rule_base(None, None)
    assert store.active_rule_base() is None


def test_the_state_outlives_the_store(tmp_path):
    url = f"sqlite:///{tmp_path / 'state.db'}"
    first = Store(url)
    model = first.add_model(name="a.csg", ending="csg", text="0" * 64, language="padl", units="mm")
    first.close()
    second = Store(url)
    assert second.model(model.id).name == "a.csg"
    second.close()


def test_artifacts_are_found_by_their_content(tmp_path):
    artifacts = Artifacts(tmp_path)
    digest = artifacts.put(b"deck")
    assert artifacts.put(b"deck") == digest and artifacts.get(digest) == b"deck"


@pytest.mark.parametrize("digest", ["../../etc/passwd", "0" * 64])
def test_an_artifact_that_is_not_there_is_a_defect(tmp_path, digest):
    with pytest.raises(DefectError):
        Artifacts(tmp_path).get(digest)


@pytest.mark.parametrize("url", ["nonsense://x", "no url", "sqlite:////missing/folder/state.db"])
def test_a_database_that_cannot_be_opened_is_a_wrong_option(url):
    with pytest.raises(OptionError, match="cannot be opened"):
        Store(url)


def test_a_password_is_not_told():
    with pytest.raises(OptionError) as caught:
        Store("nonsense://anna:secret@host/db")
    assert "secret" not in str(caught.value)
