"""The store: the job table is the truth."""

import json
import threading

import pytest
from alembic.autogenerate import compare_metadata
from alembic.runtime.migration import MigrationContext
from sqlalchemy import create_engine, inspect, select, text
from sqlalchemy.orm import Session

from app.artifacts import Artifacts
from app.migrations import newest
from app.store import SCHEMA, Outcome, Store
from app.tables import JobRow, ModelRow, Table
from kernel.errors import DefectError, OptionError


@pytest.fixture
def store(database):
    store = Store(database)
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


def test_a_jobs_request_is_read_when_it_is_claimed_and_dropped_when_it_has_ended(store, model):
    job = store.add_job(model, "a", {"text": "cube();"}).id
    assert "request" in inspect(store.job(job)).unloaded
    assert json.loads(store.claim_job().request) == {"text": "cube();"}
    assert store.requeue_unfinished(most_attempts=3) == 1
    assert json.loads(store.claim_job().request) == {"text": "cube();"}
    assert store.count_unfinished() == 1
    store.finish_job(job, Outcome("failed", problem="{}"))
    assert store.count_unfinished() == 0
    with Session(store._engine) as session:
        assert session.scalars(select(JobRow.request)).all() == ["{}"]


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


def test_the_state_outlives_the_store(database):
    first = Store(database)
    model = first.add_model(name="a.csg", ending="csg", text="0" * 64, language="padl", units="mm")
    first.close()
    second = Store(database)
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


def at_once(count, work):
    """Run work(k) in `count` threads; gives the results, and raises what one of them raised."""
    results, errors = [None] * count, []

    def run(k):
        try:
            results[k] = work(k)
        except Exception as error:  # noqa: BLE001  the test raises it
            errors.append(error)

    threads = [threading.Thread(target=run, args=(k,)) for k in range(count)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    if errors:
        raise errors[0]
    return results


def test_no_two_claim_one_job(store, model):
    jobs = {store.add_job(model, str(k), {}).id for k in range(24)}

    def claim(_):
        taken = []
        while len(taken) < 24:
            job = store.claim_job()
            if job is None and not any(store.job(name).state == "queued" for name in jobs):
                return taken
            taken += [] if job is None else [job.id]
        return taken

    claimed = [job for taken in at_once(4, claim) for job in taken]
    assert sorted(claimed) == sorted(jobs)


def test_counts_are_of_what_is_there(store, model):
    store.add_job(model, "a", {})
    store.add_job(model, "b", {})
    store.claim_job()
    store.add_mesh(model_id=model, key="c", answer="0" * 64, content="1" * 64)
    counts = store.counts()
    assert (counts.models, counts.meshes, counts.jobs) == (1, 1, {"queued": 1, "running": 1})


def test_the_schema_is_what_the_tables_say(store, database):
    assert newest() == SCHEMA
    engine = create_engine(database)
    with engine.connect() as connection:
        assert compare_metadata(MigrationContext.configure(connection), Table.metadata) == []
    engine.dispose()


def test_a_database_of_before_the_steps_is_brought_up_and_keeps_what_it_has(database):
    engine = create_engine(database)
    tables = [table for table in Table.metadata.sorted_tables if table.name != "tokens"]
    Table.metadata.create_all(engine, tables=tables)
    with engine.begin() as connection:
        values = dict.fromkeys(("id", "name", "ending", "text", "language", "units", "created"), "old")
        connection.execute(ModelRow.__table__.insert(), values)
    engine.dispose()
    store = Store(database)
    assert store.model("old").name == "old"
    assert not store.has_tokens()
    store.close()


def test_several_that_open_a_new_database_at_once_all_get_it(database):
    for store in at_once(4, lambda _: Store(database)):
        assert store.is_ready()
        store.close()


def test_a_database_of_a_newer_version_is_refused_and_left_alone(database):
    Store(database).close()
    engine = create_engine(database)
    with engine.begin() as connection:
        connection.execute(text("UPDATE alembic_version SET version_num = '9999'"))
    with pytest.raises(OptionError, match="'9999', which is of a newer csgmesh"):
        Store(database)
    with engine.connect() as connection:
        assert connection.scalar(text("SELECT version_num FROM alembic_version")) == "9999"
    engine.dispose()
