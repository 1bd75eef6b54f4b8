"""The service's state, in SQL: models, overrides with their history, jobs, meshes, rule bases.

The job table is the truth: what it calls queued or running when the service starts has to be run (again).
Values leave this module as rows of app/tables.py, loaded and cut off from the database.
"""

from __future__ import annotations

import datetime
import json
import re
import secrets
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from sqlalchemy import (
    Engine,
    create_engine,
    delete,
    event,
    func,
    select,
    text,
    update,
)
from sqlalchemy.exc import SQLAlchemyError
from sqlalchemy.orm import Session
from sqlalchemy.pool import NullPool

from app.failure import failure
from app.tables import (
    ENDED,
    FINISHED,
    JobRow,
    MeshRow,
    ModelRow,
    OverrideEventRow,
    OverrideRow,
    RuleBaseRow,
    TokenRow,
)
from kernel.errors import DefectError, OptionError

SCHEMA = "0001"
"""The newest step of app/migrations: a database that is at it needs none."""


@dataclass(frozen=True, slots=True)
class Counts:
    """What is on record; jobs by state."""

    models: int
    meshes: int
    jobs: dict[str, int]


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a job ended: `mesh` where it is done, `problem` (JSON) where it failed."""

    state: str
    mesh: str | None = None
    problem: str | None = None


class Store:
    """All reading and writing of the state; safe to use from several threads.

    OptionError: the database cannot be opened.
    """

    def __init__(self, database: str) -> None:
        try:
            self._engine = _engine(database)
            try:
                if _schema_of(self._engine) != SCHEMA:
                    from app.migrations import upgrade

                    upgrade(self._engine)
            except BaseException:
                self._engine.dispose()
                raise
        except (SQLAlchemyError, ImportError) as error:
            reason = str(error).splitlines()[0]
            raise OptionError(f"the database {_without_password(database)} cannot be opened: {reason}") from error

    def close(self) -> None:
        """Let go of the database."""
        self._engine.dispose()

    def is_ready(self) -> bool:
        """The database answers."""
        with self._session() as session:
            return session.scalar(select(1)) == 1

    def counts(self) -> Counts:
        """How many models, meshes and jobs there are."""
        with self._session() as session:
            models, meshes = (session.scalar(select(func.count()).select_from(row)) or 0 for row in (ModelRow, MeshRow))
            jobs = {
                row[0]: row[1] for row in session.execute(select(JobRow.state, func.count()).group_by(JobRow.state))
            }
        return Counts(models, meshes, jobs)

    # models

    def add_model(self, *, name: str, ending: str, text: str, language: str, units: str) -> ModelRow:
        """Keep a model; `text` is its artifact."""
        row = ModelRow(new_id(), name, ending, text, language, units, now())
        with self._session() as session:
            session.add(row)
        return row

    def model(self, model_id: str) -> ModelRow | None:
        """One model."""
        with self._session() as session:
            return session.get(ModelRow, model_id)

    def models(self) -> Sequence[ModelRow]:
        """All models, oldest first."""
        with self._session() as session:
            return session.scalars(select(ModelRow).order_by(ModelRow.created, ModelRow.id)).all()

    def delete_model(self, model_id: str) -> bool:
        """Forget a model, its overrides, jobs and meshes; False where there is none."""
        with self._session() as session:
            return _changed(session.execute(delete(ModelRow).where(ModelRow.id == model_id)))

    # overrides

    def overrides(self, model_id: str) -> Sequence[OverrideRow]:
        """The overrides that stand, by path."""
        with self._session() as session:
            query = select(OverrideRow).where(OverrideRow.model == model_id).order_by(OverrideRow.node)
            return session.scalars(query).all()

    def set_override(self, model_id: str, node: str, kind: str, author: str, reason: str) -> OverrideRow:
        """Pin `node`; the history keeps what stood before."""
        row = OverrideRow(model_id, node, kind, author, reason, now())
        with self._session() as session:
            session.merge(row)
            session.add(OverrideEventRow(model_id, node, kind, author, reason, row.created))
        return row

    def remove_override(self, model_id: str, node: str, author: str, reason: str) -> bool:
        """Take the override of `node` back; False where there is none."""
        query = delete(OverrideRow).where(OverrideRow.model == model_id, OverrideRow.node == node)
        with self._session() as session:
            removed = _changed(session.execute(query))
            if removed:
                session.add(OverrideEventRow(model_id, node, None, author, reason, now()))
            return removed

    def override_history(self, model_id: str) -> Sequence[OverrideEventRow]:
        """Everything that was set and taken back, oldest first."""
        with self._session() as session:
            query = select(OverrideEventRow).where(OverrideEventRow.model == model_id).order_by(OverrideEventRow.id)
            return session.scalars(query).all()

    # jobs

    def add_job(self, model_id: str, key: str, request: dict[str, Any]) -> JobRow:
        """Queue a job; where a mesh of this key is there already, the job is done at once."""
        with self._session() as session:
            found = session.scalar(select(MeshRow).where(MeshRow.key == key, MeshRow.model == model_id))
            last = session.scalar(select(JobRow.sequence).order_by(JobRow.sequence.desc()).limit(1)) or 0
            text = json.dumps(request) if found is None else ENDED
            job = JobRow(new_id(), model_id, key, text, "queued", now(), last + 1)
            if found is not None:
                job.state, job.mesh, job.progress, job.finished = "done", found.id, 1.0, now()
            session.add(job)
        return job

    def job(self, job_id: str) -> JobRow | None:
        """One job."""
        with self._session() as session:
            return session.get(JobRow, job_id)

    def count_unfinished(self) -> int:
        """How many jobs have not ended, of all models."""
        with self._session() as session:
            query = select(func.count()).select_from(JobRow).where(JobRow.state.not_in(FINISHED))
            return session.scalar(query) or 0

    def unfinished_jobs(self, model_id: str) -> Sequence[str]:
        """Ids of the jobs of a model that have not ended."""
        query = select(JobRow.id).where(JobRow.model == model_id, JobRow.state.not_in(FINISHED))
        with self._session() as session:
            return session.scalars(query.order_by(JobRow.sequence)).all()

    def claim_job(self) -> JobRow | None:
        """The oldest queued job, now running; None where none is queued. No two callers get the same one."""
        with self._session() as session:
            query = select(JobRow).where(JobRow.state == "queued").order_by(JobRow.sequence, JobRow.id).limit(1)
            job = session.scalar(query.with_for_update(skip_locked=True))  # which SQLite leaves out, and need not have
            if job is None:
                return None
            taken = update(JobRow).where(JobRow.id == job.id, JobRow.state == "queued")
            if not _changed(session.execute(taken.values(state="running", started=now(), attempts=job.attempts + 1))):
                return None
            session.refresh(job, ["state", "started", "attempts", "request"])
            return job

    def report_progress(self, job_id: str, stage: str, progress: float) -> None:
        """What a running job is at."""
        running = update(JobRow).where(JobRow.id == job_id, JobRow.state == "running")
        with self._session() as session:
            session.execute(running.values(stage=stage, progress=progress))

    def finish_job(self, job_id: str, outcome: Outcome) -> bool:
        """End a job that has not ended; False where it had (it was cancelled, say)."""
        values: dict[str, Any] = {"state": outcome.state, "mesh": outcome.mesh, "problem": outcome.problem}
        values["finished"], values["request"] = now(), ENDED
        if outcome.state == "done":
            values["progress"] = 1.0
        unfinished = update(JobRow).where(JobRow.id == job_id, JobRow.state.not_in(FINISHED))
        with self._session() as session:
            return _changed(session.execute(unfinished.values(**values)))

    def requeue_unfinished(self, most_attempts: int) -> int:
        """At start: queue what was running when the process died; fail what has died `most_attempts` times.

        Gives the number of jobs that wait.
        """
        problem = json.dumps(failure(DefectError(f"the process died {most_attempts} times at this job")))
        running = update(JobRow).where(JobRow.state == "running")
        with self._session() as session:
            tired = running.where(JobRow.attempts >= most_attempts)
            session.execute(tired.values(state="failed", problem=problem, finished=now(), request=ENDED))
            session.execute(running.values(state="queued", stage="", progress=0.0, started=None))
            return len(session.scalars(select(JobRow.id).where(JobRow.state == "queued")).all())

    # meshes

    def add_mesh(self, *, model_id: str, key: str, answer: str, content: str) -> MeshRow:
        """Keep a finished mesh; `answer` and `content` are artifacts."""
        row = MeshRow(new_id(), model_id, key, answer, content, now())
        with self._session() as session:
            session.add(row)
        return row

    def mesh(self, mesh_id: str) -> MeshRow | None:
        """One mesh."""
        with self._session() as session:
            return session.get(MeshRow, mesh_id)

    # rule bases

    def add_rule_base(self, name: str, version: str, text: str, author: str) -> RuleBaseRow:
        """Keep a version; the same content twice is the same version."""
        with self._session() as session:
            row = session.get(RuleBaseRow, (name, version))
            if row is None:
                row = RuleBaseRow(name, version, text, author, now())
                session.add(row)
            return row

    def rule_bases(self) -> Sequence[RuleBaseRow]:
        """Every version of every rule base."""
        with self._session() as session:
            return session.scalars(select(RuleBaseRow).order_by(RuleBaseRow.name, RuleBaseRow.created)).all()

    def rule_base(self, name: str, version: str | None = None) -> RuleBaseRow | None:
        """One version of a rule base, the newest where none is said."""
        query = select(RuleBaseRow).where(RuleBaseRow.name == name)
        if version is not None:
            query = query.where(RuleBaseRow.version == version)
        with self._session() as session:
            return session.scalar(query.order_by(RuleBaseRow.created.desc()).limit(1))

    def active_rule_base(self) -> RuleBaseRow | None:
        """The version that decides where a request names none; None for the own rule base."""
        with self._session() as session:
            return session.scalar(select(RuleBaseRow).where(RuleBaseRow.is_active))

    def activate_rule_base(self, name: str | None, version: str | None) -> None:
        """Make one version the active one; None for the own rule base."""
        chosen = update(RuleBaseRow).where(RuleBaseRow.name == name, RuleBaseRow.version == version)
        with self._session() as session:
            session.execute(update(RuleBaseRow).values(is_active=False))
            session.execute(chosen.values(is_active=True))

    # tokens

    def add_token(self, name: str, digest: str, expires: str | None) -> TokenRow:
        """Keep a token's hash."""
        row = TokenRow(new_id(), name, digest, now(), expires)
        with self._session() as session:
            session.add(row)
        return row

    def tokens(self) -> Sequence[TokenRow]:
        """Every token, revoked and expired ones too, oldest first."""
        with self._session() as session:
            return session.scalars(select(TokenRow).order_by(TokenRow.created, TokenRow.id)).all()

    def has_tokens(self) -> bool:
        """Whether there ever was a token."""
        with self._session() as session:
            return session.scalar(select(TokenRow.id).limit(1)) is not None

    def token_of(self, digest: str) -> TokenRow | None:
        """The token with this hash."""
        with self._session() as session:
            return session.scalar(select(TokenRow).where(TokenRow.digest == digest))

    def revoke_token(self, token_id: str) -> TokenRow:
        """Revoke a token that is there; gives it as it is now."""
        with self._session() as session:
            row = session.get_one(TokenRow, token_id)
            row.revoked = row.revoked or now()
            return row

    def note_use(self, token_id: str) -> None:
        """A token was used now."""
        with self._session() as session:
            session.execute(update(TokenRow).where(TokenRow.id == token_id).values(used=now()))

    @contextmanager
    def _session(self) -> Iterator[Session]:
        with Session(self._engine, expire_on_commit=False) as session, session.begin():
            yield session


def new_id() -> str:
    """A name that cannot be guessed: 96 random bits."""
    return secrets.token_hex(12)


def now(later: datetime.timedelta = datetime.timedelta(0)) -> str:
    """UTC, ISO 8601, microseconds; `later` than now, which may be before it."""
    return (datetime.datetime.now(datetime.UTC) + later).isoformat(timespec="microseconds")


def _without_password(database: str) -> str:
    return re.sub(r"(://[^:/@]*):[^@]*@", r"\1:...@", database)


def _changed(result: Any) -> bool:
    return bool(result.rowcount)


def _schema_of(engine: Engine) -> str | None:
    """The step that a database is at, None where it has no tables of ours."""
    with engine.connect() as connection:
        if not engine.dialect.has_table(connection, "alembic_version"):
            return None
        return connection.scalar(text("SELECT version_num FROM alembic_version"))


def _engine(database: str) -> Engine:
    if not database.startswith("sqlite"):
        return create_engine(database, pool_pre_ping=True)
    # A connection a session: SQLite opens in microseconds, and no connection is shared between threads.
    engine = create_engine(database, poolclass=NullPool, connect_args={"timeout": 30})

    @event.listens_for(engine, "connect")
    def _configure(connection: Any, _record: Any) -> None:
        connection.execute("PRAGMA journal_mode=WAL")
        connection.execute("PRAGMA synchronous=NORMAL")
        connection.execute("PRAGMA foreign_keys=ON")

    return engine
