"""The first schema: models, overrides and their history, jobs, meshes, rule bases, tokens.

Databases made before there were steps have these tables but the last; only what is missing is made.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None
branch_labels = None
depends_on = None


def _text(name: str, nullable: bool = False, primary_key: bool = False) -> sa.Column:
    return sa.Column(name, sa.String(), nullable=nullable, primary_key=primary_key)


def _model(primary_key: bool = False) -> sa.Column:
    return sa.Column(
        "model",
        sa.String(),
        sa.ForeignKey("models.id", ondelete="CASCADE"),
        nullable=False,
        primary_key=primary_key,
    )


def upgrade() -> None:
    """Make the tables."""
    there = set(sa.inspect(op.get_bind()).get_table_names())

    def make(name: str, *columns: sa.Column | sa.UniqueConstraint, indices: tuple[str, ...] = ()) -> None:
        if name in there:
            return
        op.create_table(name, *columns)
        for column in indices:
            op.create_index(f"ix_{name}_{column}", name, [column])

    make(
        "models",
        _text("id", primary_key=True),
        *map(_text, ("name", "ending", "text", "language", "units", "created")),
    )
    make(
        "overrides",
        _model(primary_key=True),
        _text("node", primary_key=True),
        *map(_text, ("type", "author", "reason", "created")),
    )
    make(
        "override_events",
        sa.Column("id", sa.Integer(), primary_key=True),
        _model(),
        _text("node"),
        _text("type", nullable=True),
        *map(_text, ("author", "reason", "created")),
        indices=("model",),
    )
    make(
        "jobs",
        _text("id", primary_key=True),
        _model(),
        *map(_text, ("key", "request", "state", "created")),
        sa.Column("sequence", sa.Integer(), nullable=False),
        _text("stage"),
        sa.Column("progress", sa.Float(), nullable=False),
        sa.Column("attempts", sa.Integer(), nullable=False),
        *(_text(name, nullable=True) for name in ("started", "finished", "problem", "mesh")),
        indices=("model", "state"),
    )
    make(
        "meshes",
        _text("id", primary_key=True),
        _model(),
        *map(_text, ("key", "answer", "content", "created")),
        indices=("model", "key"),
    )
    make(
        "rule_bases",
        _text("name", primary_key=True),
        _text("version", primary_key=True),
        *map(_text, ("text", "author", "created")),
        sa.Column("is_active", sa.Boolean(), nullable=False),
    )
    make(
        "tokens",
        _text("id", primary_key=True),
        *map(_text, ("name", "digest", "created")),
        *(_text(name, nullable=True) for name in ("expires", "revoked", "used")),
        sa.UniqueConstraint("digest", name="uq_tokens_digest"),
    )
