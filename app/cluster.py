"""Models meshed on a dask cluster: a scheduler that somebody else runs, its workers with the same csgmesh installed.

The cluster shares nothing with us but the network: what a task needs is sent along, what it makes is sent back.
"""

from __future__ import annotations

import hashlib
import secrets
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from app.artifacts import Artifacts
from app.batch import Do
from app.sources import sources_hash
from app.work import TASKS, Payload, Progress, files_task, reporter
from app.workers import Worker, WorkerDied
from kernel.errors import CsgmeshError, DefectError, OptionError

if TYPE_CHECKING:
    from distributed import Client, Future

PATIENCE = 10.0
"""Seconds that a scheduler has to answer."""

AHEAD = 2
"""Models that wait at the scheduler for each thread of its workers, that none of them waits for us."""

MOST_AHEAD = 256
"""Models that are with the scheduler at once, at most."""

FEWEST_AHEAD = 8
"""The same while it has no workers yet."""

SENT_TASKS = ("mesh",)
"""Tasks that are complete in themselves and may be long; others are done on this machine, where the artifacts are."""


def connect(address: str) -> Client:
    """A client of the scheduler at an address. OptionError: none answers there, or there is no dask here."""
    try:
        from distributed import Client
    except ImportError:
        raise OptionError(
            "a scheduler needs dask, expected it to be installed: pip install 'csgmesh[cluster]'"
        ) from None
    try:
        return Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:  # of a wrong address, and of one where nobody is
        reason = " ".join(str(error).split()) or type(error).__name__
        raise OptionError(f"no scheduler answers at {address} ({reason}), expected one, as tcp://host:8786") from error


@contextmanager
def cluster_doers(address: str, count: int) -> Iterator[list[Do]]:
    """As many as the cluster has use for, at most `count`. OptionError: as connect."""
    with connect(address) as client:
        threads = sum(client.nthreads().values())
        wanted = min(max(AHEAD * threads, FEWEST_AHEAD), MOST_AHEAD, count)

        def do(payload: Payload) -> dict[str, Any]:
            result: dict[str, Any] = client.submit(files_there, payload, sources_hash(), pure=False).result()
            return result

        yield [do] * wanted


class ClusterWorker:
    """Does one task at a time on a cluster; is to the jobs what a Worker of this machine is."""

    def __init__(self, client: Client, artifacts: Artifacts) -> None:
        self._client = client
        self._artifacts = artifacts
        self._here = Worker(artifacts.folder)
        self._change = threading.Lock()
        self._future: Future | None = None

    def call(
        self,
        task: str,
        payload: Payload,
        *,
        progress: Progress | None = None,
        deadline: float | None = None,
        may_start: Callable[[], bool] = lambda: True,
    ) -> Any:
        """Do a task and wait for it; raises what the task raises, and WorkerDied where it was stopped or got lost."""
        if task not in SENT_TASKS:
            return self._here.call(task, payload, progress=progress, deadline=deadline, may_start=may_start)
        topic = f"csgmesh-{secrets.token_hex(8)}"
        if progress is not None:
            self._client.subscribe_topic(topic, lambda event: progress(*event[1]))
        try:
            with self._change:
                future = self._future = self._client.submit(do_there, task, payload, sources_hash(), topic, pure=False)
            if not may_start():
                future.cancel()
            result, made = future.result(deadline)
        except CsgmeshError:
            raise
        except (Exception, CancelledError) as error:  # whatever dask raises: a killed worker, a lost connection
            raise WorkerDied(f"the cluster did not finish {task}: {type(error).__name__} {error}".strip()) from error
        finally:
            with self._change:
                self._future = None
            if progress is not None:
                self._client.unsubscribe_topic(topic)
        for content in made:
            self._artifacts.put(content)
        return result

    def stop(self) -> None:
        """Give the task up; a worker that has begun with it goes on to its end, and nobody hears of it."""
        self._here.stop()
        with self._change:
            future = self._future
        if future is not None:
            future.cancel()


class _Made(Artifacts):
    """Artifacts that are held in memory until they are sent back."""

    def __init__(self) -> None:
        self.contents: dict[str, bytes] = {}

    def put(self, content: bytes) -> str:
        """Hold `content`; gives its SHA-256."""
        digest = hashlib.sha256(content).hexdigest()
        self.contents[digest] = content
        return digest

    def get(self, digest: str) -> bytes:
        """What was put before."""
        if digest not in self.contents:
            raise DefectError(f"artifact {digest} was not sent along")
        return self.contents[digest]


def do_there(task: str, payload: Payload, sources: str, topic: str) -> tuple[Any, list[bytes]]:
    """What a worker of the cluster does for the service: the task's result, and the artifacts that it made."""
    from distributed import get_worker

    _check_sources(sources)
    made = _Made()
    worker = get_worker()
    result = TASKS[task](payload, made, reporter(lambda stage, share: worker.log_event(topic, (stage, share))))
    return result, list(made.contents.values())


def files_there(payload: Payload, sources: str) -> dict[str, Any]:
    """What a worker of the cluster does for a batch. OptionError: its csgmesh is not the one that asks."""
    _check_sources(sources)
    return files_task(payload, None, lambda _stage, _share: None)


def _check_sources(sources: str) -> None:
    if sources_hash() != sources:
        raise OptionError("the cluster's worker has another version of csgmesh, expected the same on all machines")
