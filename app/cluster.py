"""Models meshed on a dask cluster: a scheduler that somebody else runs, its workers with the same csgmesh installed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from app.batch import Do
from app.work import Payload, files_task
from kernel.errors import OptionError

PATIENCE = 10.0
"""Seconds that a scheduler has to answer."""

AHEAD = 2
"""Models that wait at the scheduler for each thread of its workers, that none of them waits for us."""

MOST_AHEAD = 256
"""Models that are with the scheduler at once, at most."""

FEWEST_AHEAD = 8
"""The same while it has no workers yet."""


@contextmanager
def cluster_doers(address: str, count: int) -> Iterator[list[Do]]:
    """As many as the cluster has use for, at most `count`. OptionError: no scheduler answers, or no dask here."""
    try:
        from distributed import Client
    except ImportError:
        raise OptionError(
            "a scheduler needs dask, expected it to be installed: pip install 'csgmesh[cluster]'"
        ) from None
    from app.sources import sources_hash

    try:
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:  # of a wrong address, and of one where nobody is
        reason = " ".join(str(error).split()) or type(error).__name__
        raise OptionError(f"no scheduler answers at {address} ({reason}), expected one, as tcp://host:8786") from error
    with client:
        threads = sum(client.nthreads().values())
        wanted = min(max(AHEAD * threads, FEWEST_AHEAD), MOST_AHEAD, count)

        def do(payload: Payload) -> dict[str, Any]:
            result: dict[str, Any] = client.submit(mesh_there, payload, sources_hash(), pure=False).result()
            return result

        yield [do] * wanted


def mesh_there(payload: Payload, sources: str) -> dict[str, Any]:
    """What a worker of the cluster does. OptionError: its csgmesh is not the one that asks."""
    from app.sources import sources_hash

    if sources_hash() != sources:
        raise OptionError("the cluster's worker has another version of csgmesh, expected the same on all machines")
    return files_task(payload, None, lambda _stage, _share: None)
