"""The job runner: threads that take queued jobs from the store and have workers do them.

store.add_job -> queued -> claimed by a thread -> running in that thread's worker -> done | failed | cancelled
"""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import structlog
from sqlalchemy.exc import SQLAlchemyError

from app.artifacts import Artifacts
from app.failure import failure
from app.store import Outcome, Store
from app.tables import JobRow
from app.work import Payload
from app.workers import Worker
from kernel.errors import CsgmeshError, DefectError

if TYPE_CHECKING:
    from distributed import Client

    from app.cluster import ClusterWorker

MOST_ATTEMPTS = 3
"""A job during which the service died this often is not tried again."""

INTERACTIVE_WORKERS = 2
"""Workers for what requests wait for: a long one must not hold up every other."""

INTERACTIVE_DEADLINE = 120.0
"""Seconds that a request may keep an interactive worker busy."""

MOST_QUEUED = 1000
"""Jobs that may wait: each keeps its model's text until it has ended."""

MOST_WAITING = 20
"""Requests that may wait for an interactive worker: half of the server's threads, so that answers which need no worker
(a job's state, whether the service lives) come however many ask for long work."""

IDLE_WAIT = 1.0
"""Seconds after which an idle thread looks into the store unasked."""

log = structlog.get_logger()


class Busy(Exception):
    """So many requests wait for a worker, or so many jobs, that one more is to come again later."""


class Jobs:
    """`n_worker` workers for jobs, and INTERACTIVE_WORKERS more for what requests wait for.

    scheduler: address of a dask cluster that does the jobs; None to do them in processes of this machine.
    """

    def __init__(self, store: Store, artifacts: Artifacts, n_worker: int, scheduler: str | None = None) -> None:
        self._store = store
        self._artifacts = artifacts
        self._wake = threading.Condition()
        self._is_stopping = False
        self._client: Client | None = None
        self._workers: Sequence[Worker | ClusterWorker]
        if scheduler is None:
            self._workers = [Worker(artifacts.folder) for _ in range(n_worker)]
        else:
            from app.cluster import ClusterWorker, connect

            self._client = client = connect(scheduler)
            self._workers = [ClusterWorker(client, artifacts) for _ in range(n_worker)]
        self._interactive = [Worker(artifacts.folder) for _ in range(INTERACTIVE_WORKERS)]
        self._idle: queue.LifoQueue[Worker] = queue.LifoQueue()  # the last one used comes first: it is warm
        for worker in self._interactive:
            self._idle.put(worker)
        self._waiting = threading.BoundedSemaphore(MOST_WAITING + INTERACTIVE_WORKERS)
        self._doing: dict[str, Worker | ClusterWorker] = {}
        self._threads = [
            threading.Thread(target=self._take_jobs, args=(worker,), name=f"jobs-{k}", daemon=True)
            for k, worker in enumerate(self._workers)
        ]

    def start(self) -> None:
        """Queue again what an earlier process left unfinished, and begin."""
        waiting = self._store.requeue_unfinished(MOST_ATTEMPTS)
        if waiting:
            log.info("jobs wait from an earlier run", jobs=waiting)
        for thread in self._threads:
            thread.start()

    def stop(self) -> None:
        """Stop every worker; jobs that were running stay `running` in the store and run again at the next start."""
        with self._wake:
            self._is_stopping = True
            self._wake.notify_all()
        for worker in [*self._workers, *self._interactive]:
            worker.stop()
        for thread in self._threads:
            if thread.is_alive():
                thread.join(5.0)
        if self._client is not None:
            self._client.close()

    def submit(self, model_id: str, key: str, request: dict[str, Any]) -> JobRow:
        """Queue a job (done at once where its mesh is there already). Busy: too many wait."""
        if self._store.count_unfinished() >= MOST_QUEUED:
            raise Busy(f"{MOST_QUEUED} jobs wait already, expected to come again later")
        job = self._store.add_job(model_id, key, request)
        with self._wake:
            self._wake.notify()
        return job

    def cancel(self, job_id: str) -> bool:
        """Cancel a job that has not ended; False where it had."""
        if not self._store.finish_job(job_id, Outcome("cancelled")):
            return False
        with self._wake:  # held while stopping: the worker must not begin its next job in between
            worker = self._doing.get(job_id)
            if worker is not None:
                worker.stop()
        return True

    def call(self, task: str, payload: Payload) -> Any:
        """Do a short task in an interactive worker and wait for it; raises what it raises. Busy: too many wait."""
        if not self._waiting.acquire(blocking=False):
            raise Busy(f"{MOST_WAITING} requests wait for a worker already, expected to come again later")
        try:
            worker = self._idle.get()
            try:
                return worker.call(task, payload, deadline=INTERACTIVE_DEADLINE)
            finally:
                self._idle.put(worker)
        finally:
            self._waiting.release()

    def occupied(self) -> tuple[int, int]:
        """(workers that do a job, workers for jobs)."""
        with self._wake:
            return len(self._doing), len(self._workers)

    def _take_jobs(self, worker: Worker | ClusterWorker) -> None:
        while not self._is_stopping:
            try:
                job = self._store.claim_job()
                if job is not None:
                    self._do(worker, job)
                    continue
            except SQLAlchemyError as error:
                log.error("the database did not answer", error=str(error))
            with self._wake:
                if not self._is_stopping:
                    self._wake.wait(IDLE_WAIT)

    def _do(self, worker: Worker | ClusterWorker, job: JobRow) -> None:
        logger = log.bind(job=job.id, model=job.model)
        logger.info("job started", attempt=job.attempts)
        with self._wake:
            self._doing[job.id] = worker
        try:
            request = json.loads(job.request)
            result = worker.call(
                request.get("task", "mesh"),
                request,
                progress=lambda stage, share: self._report(job.id, stage, share),
                may_start=lambda: self._is_running(job.id),
            )
            mesh = self._store.add_mesh(
                model_id=job.model, key=job.key, answer=result["answer"], content=result["content"]
            )
            outcome = Outcome("done", mesh=mesh.id)
        except CsgmeshError as error:
            outcome = Outcome("failed", problem=json.dumps(failure(error)))
        except Exception as error:  # noqa: BLE001  a thread of the server must outlive whatever one job does
            outcome = Outcome("failed", problem=json.dumps(failure(DefectError(f"{type(error).__name__}: {error}"))))
        finally:
            with self._wake:
                del self._doing[job.id]
        if self._is_stopping and outcome.state == "failed":
            return
        if self._store.finish_job(job.id, outcome):
            logger.info("job ended", state=outcome.state)

    def _report(self, job_id: str, stage: str, share: float) -> None:
        """Note how far a job is; where the database does not answer, the job goes on and the next report is newer."""
        try:
            self._store.report_progress(job_id, stage, share)
        except SQLAlchemyError as error:
            log.warning("progress was not noted", job=job_id, stage=stage, error=str(error))

    def _is_running(self, job_id: str) -> bool:
        job = self._store.job(job_id)
        return job is not None and job.state == "running" and not self._is_stopping
