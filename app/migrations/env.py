"""Run by Alembic for each change of the schema, over the connection that app/migrations/__init__.py gives."""

from alembic import context

from app.tables import Table

context.configure(
    connection=context.config.attributes["connection"],
    target_metadata=Table.metadata,
    render_as_batch=True,  # SQLite cannot change a column where it stands
)
with context.begin_transaction():
    context.run_migrations()
