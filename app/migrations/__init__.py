"""The database's schema, step by step: every database is brought to the newest step as it is opened.

A new step: a file in versions/ (see there), and HEAD below is its name. Tables are declared in app/tables.py; a test
holds the two against each other.
"""

from __future__ import annotations

from alembic import command
from alembic.config import Config
from alembic.runtime.migration import MigrationContext
from alembic.script import ScriptDirectory
from alembic.util import CommandError
from sqlalchemy import Connection, Engine

from kernel.errors import OptionError

LOCK = 0x6373676D657368
"""Number of PostgreSQL's advisory lock that a service holds while it changes the schema: "csgmesh" in ASCII."""


def upgrade(engine: Engine) -> None:
    """Bring the schema to the newest step; of several that start at once, one does it and the others wait.

    OptionError: the database is of a newer csgmesh.
    """
    if engine.dialect.name == "sqlite":
        # Python's SQLite would begin a transaction at the first write only, and end it at each change of the schema
        with engine.connect().execution_options(isolation_level="AUTOCOMMIT") as connection:
            connection.exec_driver_sql("BEGIN IMMEDIATE")
            try:
                _upgrade(connection)
            except BaseException:
                connection.exec_driver_sql("ROLLBACK")
                raise
            connection.exec_driver_sql("COMMIT")
        return
    with engine.begin() as connection:
        if engine.dialect.name == "postgresql":
            connection.exec_driver_sql(f"SELECT pg_advisory_xact_lock({LOCK})")
        _upgrade(connection)


def newest() -> str:
    """Name of the newest step."""
    head = ScriptDirectory.from_config(_config()).get_current_head()
    assert head is not None
    return head


def _upgrade(connection: Connection) -> None:
    config = _config()
    config.attributes["connection"] = connection
    try:
        command.upgrade(config, "head")
    except CommandError as error:
        found = MigrationContext.configure(connection).get_current_revision()
        raise OptionError(f"the database is at step {found!r}, which is of a newer csgmesh: {error}") from error


def _config() -> Config:
    config = Config()
    config.set_main_option("script_location", "app:migrations")
    return config
