"""`csgmesh token`: who may use the service."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app import texts
from app.cli_arguments import JsonOption

if TYPE_CHECKING:
    from app.store import Store
    from app.tables import TokenRow

app = typer.Typer(name="token", help="Tokens that open the service.", rich_markup_mode=None)

DataOption = Annotated[str | None, typer.Option("--data", metavar="FOLDER", help="The service's folder.")]
DatabaseOption = Annotated[
    str | None, typer.Option("--database", metavar="URL", help="The service's database; SQLite in FOLDER by default.")
]


@app.command(epilog="Example: csgmesh token create anna --days 90")
def create(
    name: Annotated[str, typer.Argument(help="Whose it is, or what for.")],
    days: Annotated[int | None, typer.Option(help="Days that it holds; for good by default.")] = None,
    data: DataOption = None,
    database: DatabaseOption = None,
    as_json: JsonOption = False,
) -> None:
    """Make a token and print it, this once: only its hash is kept. From the first one on, the service asks for one."""
    from app.tokens import create_token

    with _store(data, database) as store:
        secret, row = create_token(store, name, days)
    if as_json:
        texts.show(texts.as_json({**_shown(row), "token": secret}))
        return
    until = "for good" if row.expires is None else f"until {row.expires}"
    sys.stderr.write(f"token {name}, holds {until}; it is not kept and cannot be shown again\n")
    texts.show(secret)


@app.command("list", epilog="Example: csgmesh token list")
def list_tokens(data: DataOption = None, database: DatabaseOption = None, as_json: JsonOption = False) -> None:
    """Show every token by id and name, and whether it holds; never the tokens themselves."""
    with _store(data, database) as store:
        rows = [_shown(row) for row in store.tokens()]
    if as_json:
        texts.show(texts.as_json(rows))
        return
    head = ("id", "name", "state", "created", "expires", "used")
    shown = [[str(row[field] or "never") for field in head] for row in rows]
    texts.show(texts.table(head, shown) if shown else "no tokens: the service is open to whoever reaches its address")


@app.command(epilog="Example: csgmesh token revoke anna")
def revoke(
    which: Annotated[str, typer.Argument(metavar="ID|NAME", help="As `csgmesh token list` shows it.")],
    data: DataOption = None,
    database: DatabaseOption = None,
    as_json: JsonOption = False,
) -> None:
    """Take a token back: requests with it are refused from now on."""
    from app.tokens import revoke_token

    with _store(data, database) as store:
        row = revoke_token(store, which)
    texts.show(texts.as_json(_shown(row)) if as_json else f"token {row.name} ({row.id}) is revoked")


@contextmanager
def _store(data: str | None, database: str | None) -> Iterator[Store]:
    from app.settings import load_settings
    from app.store import Store

    store = Store(load_settings(data=data, database=database).database)
    try:
        yield store
    finally:
        store.close()


def _shown(row: TokenRow) -> dict[str, Any]:
    """All of a token but its hash."""
    from app.tokens import state_of

    state = state_of(row)
    fields = {name: getattr(row, name) for name in ("id", "name", "created", "expires", "revoked", "used")}
    return {**fields, "state": state}
