"""Tokens that open the service: random, shown once, kept as their hash only.

While the store holds none, the service is open to whoever reaches its address. From the first one on, revoked and
expired ones included, every request needs a token that holds: a service does not open again because a token went.
"""

from __future__ import annotations

import datetime
import hashlib
import secrets

from app.store import Store, now
from app.tables import TokenRow
from kernel.errors import OptionError

PREFIX = "csgmesh_"
"""How a token begins, so that what searches for secrets that leaked knows one."""

MAX_NAME = 100
"""Letters that the name of a token may have."""

MAX_DAYS = 3650
"""Days that a token may hold."""

USE_NOTED_EVERY = datetime.timedelta(minutes=1)
"""A use is noted no more often than this: requests must not wait for writes."""


def create_token(store: Store, name: str, days: int | None = None) -> tuple[str, TokenRow]:
    """A new token and its row. days: that it holds, None for good. OptionError: the name or the days are wrong."""
    if not name.strip() or len(name) > MAX_NAME or not name.isprintable():
        raise OptionError(f"a token's name {name!r}, expected 1 to {MAX_NAME} letters that can be printed")
    if any(row.name == name and holds(row) for row in store.tokens()):
        raise OptionError(f"there is a token {name!r} already, expected another name, or that one to be revoked first")
    if days is not None and not 1 <= days <= MAX_DAYS:
        raise OptionError(f"a token for {days} days, expected 1 to {MAX_DAYS}")
    secret = PREFIX + secrets.token_urlsafe(32)
    expires = None if days is None else now(datetime.timedelta(days=days))
    return secret, store.add_token(name, digest_of(secret), expires)


def revoke_token(store: Store, which: str) -> TokenRow:
    """Revoke the token of an id, or of a name. OptionError: no token of it holds."""
    for row in store.tokens():
        if which in (row.id, row.name) and row.revoked is None:
            return store.revoke_token(row.id)
    raise OptionError(
        f"there is no token {which!r} to revoke, expected an id or a name that `csgmesh token list` shows"
    )


def admitted(store: Store, secret: str) -> TokenRow | None:
    """The token that holds, None where there is none; its use is noted."""
    row = store.token_of(digest_of(secret))
    if row is None or not holds(row):
        return None
    if row.used is None or row.used < now(-USE_NOTED_EVERY):
        store.note_use(row.id)
    return row


def holds(row: TokenRow) -> bool:
    """Neither revoked nor expired."""
    return row.revoked is None and (row.expires is None or now() < row.expires)


def state_of(row: TokenRow) -> str:
    """`revoked`, `expired` or `holds`."""
    if row.revoked is not None:
        return "revoked"
    return "holds" if holds(row) else "expired"


def digest_of(secret: str) -> str:
    """SHA-256; a random secret of 256 bits needs no salt and no slow hash."""
    return hashlib.sha256(secret.encode("utf-8", "surrogateescape")).hexdigest()
