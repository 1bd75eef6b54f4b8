"""Settings of the service: from the command line, else from CSGMESH_* in the environment, else these defaults."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from kernel.errors import OptionError

MAX_MODEL_BYTES = 50_000_000
"""A model's text may be this long over HTTP, as on the command line."""

CLUSTER_JOBS = 32
"""Jobs that are with a cluster at once, where CSGMESH_WORKERS does not say."""

MAX_REQUEST_BYTES = 1_000_000
"""Any other request's body may be this long."""


@dataclass(frozen=True, slots=True)
class Settings:
    """data: folder of artifacts and, by default, of the database. database: an SQLAlchemy URL.

    workers: jobs that are done at once. scheduler: address of a dask cluster that does them, None for this machine.
    """

    data: Path
    database: str
    workers: int
    host: str = "127.0.0.1"
    port: int = 8000
    scheduler: str | None = None

    @property
    def artifacts(self) -> Path:
        """Folder of the content-addressed files."""
        return self.data / "artifacts"


def load_settings(
    *,
    data: str | None = None,
    database: str | None = None,
    host: str | None = None,
    port: int | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
) -> Settings:
    """Settings from what is given, then the environment, then the defaults; makes the data folder.

    OptionError: a number that is none, or a data folder that cannot be made.
    """
    folder = Path(data or os.environ.get("CSGMESH_DATA") or Path.home() / ".local" / "share" / "csgmesh").expanduser()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OptionError(f"cannot make the data folder {folder}: {error.strerror}") from error
    scheduler = scheduler or os.environ.get("CSGMESH_SCHEDULER")
    return Settings(
        data=folder,
        database=database or os.environ.get("CSGMESH_DATABASE") or f"sqlite:///{folder / 'csgmesh.db'}",
        workers=workers or _number("CSGMESH_WORKERS", CLUSTER_JOBS if scheduler else os.cpu_count() or 1),
        host=host or os.environ.get("CSGMESH_HOST") or "127.0.0.1",
        port=port if port is not None else _number("CSGMESH_PORT", 8000),
        scheduler=scheduler,
    )


def _number(variable: str, default: int) -> int:
    text = os.environ.get(variable)
    if text is None:
        return default
    if not text.isdecimal() or int(text) == 0:
        raise OptionError(f"{variable} is {text!r}, expected a positive whole number")
    return int(text)
