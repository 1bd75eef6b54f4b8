"""The tables of the service's state, as rows: what is kept of models, overrides, jobs, meshes, rule bases, tokens.

Times are UTC, ISO 8601.
"""

from __future__ import annotations

from sqlalchemy import Float, ForeignKey, UniqueConstraint
from sqlalchemy.orm import DeclarativeBase, Mapped, MappedAsDataclass, mapped_column

FINISHED = ("done", "failed", "cancelled")
"""States in which nothing more becomes of a job."""

STATES = ("queued", "running", *FINISHED)
"""Of a job."""

ENDED = "{}"
"""The request of a job that has ended."""


class Table(MappedAsDataclass, DeclarativeBase):
    """Base of the tables."""


class ModelRow(Table):
    """A CSG model; `text` is the artifact with what was sent, `ending` how a file of it ends."""

    __tablename__ = "models"
    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str]
    ending: Mapped[str]
    text: Mapped[str]
    language: Mapped[str]
    units: Mapped[str]
    created: Mapped[str]


class OverrideRow(Table):
    """An override that stands; `node` is a canonical path."""

    __tablename__ = "overrides"
    model: Mapped[str] = mapped_column(ForeignKey("models.id", ondelete="CASCADE"), primary_key=True)
    node: Mapped[str] = mapped_column(primary_key=True)
    type: Mapped[str]
    author: Mapped[str]
    reason: Mapped[str]
    created: Mapped[str]


class OverrideEventRow(Table):
    """An override that was set or taken back, kept for good; `type` is None where it was taken back."""

    __tablename__ = "override_events"
    id: Mapped[int] = mapped_column(primary_key=True, init=False)
    model: Mapped[str] = mapped_column(ForeignKey("models.id", ondelete="CASCADE"), index=True)
    node: Mapped[str]
    type: Mapped[str | None]
    author: Mapped[str]
    reason: Mapped[str]
    created: Mapped[str]


class JobRow(Table):
    """A mesh to be made: queued, running, done, failed or cancelled.

    `request` is JSON, complete in itself, with the model's whole text: read by `claim_job` alone, and dropped once the
    job has ended.
    """

    __tablename__ = "jobs"
    id: Mapped[str] = mapped_column(primary_key=True)
    model: Mapped[str] = mapped_column(ForeignKey("models.id", ondelete="CASCADE"), index=True)
    key: Mapped[str]
    request: Mapped[str] = mapped_column(deferred=True)
    state: Mapped[str] = mapped_column(index=True)
    created: Mapped[str]
    sequence: Mapped[int]
    stage: Mapped[str] = mapped_column(default="")
    progress: Mapped[float] = mapped_column(Float, default=0.0)
    attempts: Mapped[int] = mapped_column(default=0)
    started: Mapped[str | None] = mapped_column(default=None)
    finished: Mapped[str | None] = mapped_column(default=None)
    problem: Mapped[str | None] = mapped_column(default=None)
    mesh: Mapped[str | None] = mapped_column(default=None)


class MeshRow(Table):
    """A finished mesh: its answer (JSON) and its connected model (pickle of ours), both artifacts."""

    __tablename__ = "meshes"
    id: Mapped[str] = mapped_column(primary_key=True)
    model: Mapped[str] = mapped_column(ForeignKey("models.id", ondelete="CASCADE"), index=True)
    key: Mapped[str] = mapped_column(index=True)
    answer: Mapped[str]
    content: Mapped[str]
    created: Mapped[str]


class RuleBaseRow(Table):
    """One version of a rule base that users sent; the own one is never here."""

    __tablename__ = "rule_bases"
    name: Mapped[str] = mapped_column(primary_key=True)
    version: Mapped[str] = mapped_column(primary_key=True)
    text: Mapped[str]
    author: Mapped[str]
    created: Mapped[str]
    is_active: Mapped[bool] = mapped_column(default=False)


class TokenRow(Table):
    """A token that opens the service; `digest` is all that is kept of it. expires: None for good."""

    __tablename__ = "tokens"
    __table_args__ = (UniqueConstraint("digest", name="uq_tokens_digest"),)
    id: Mapped[str] = mapped_column(primary_key=True)
    name: Mapped[str]
    digest: Mapped[str]
    created: Mapped[str]
    expires: Mapped[str | None] = mapped_column(default=None)
    revoked: Mapped[str | None] = mapped_column(default=None)
    used: Mapped[str | None] = mapped_column(default=None)
