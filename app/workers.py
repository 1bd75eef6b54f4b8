"""Worker processes: started by spawn, kept warm, stopped with all their children, replaced when they crash."""

from __future__ import annotations

import atexit
import contextlib
import multiprocessing
import os
import signal
import threading
import time
from collections.abc import Callable
from multiprocessing.connection import Connection
from multiprocessing.context import SpawnProcess
from pathlib import Path
from typing import Any

from app.work import HAS_GROUPS, Payload, Progress, serve_tasks
from kernel.errors import DefectError, MeshError

PATIENCE = 2.0
"""Seconds that a stopped worker has to clean up behind itself."""


class WorkerDied(DefectError):
    """The process went away in the middle of a task: it crashed, ran out of memory, or was stopped."""


class Worker:
    """One process that does one task at a time; made at the first task, made anew after a crash.

    body: what the process runs, a function (connection, artifacts folder). A call leaves the process idle or stopped:
    whatever else goes wrong in between, no answer is left over for the next call.
    """

    def __init__(self, artifacts_folder: Path, body: Callable[[Connection, str], None] = serve_tasks) -> None:
        self._folder = str(artifacts_folder)
        self._body = body
        self._turn = threading.Lock()
        self._change = threading.Lock()
        self._process: SpawnProcess | None = None
        self._connection: Connection | None = None
        self._number = 0
        atexit.register(self.stop)

    def call(
        self,
        task: str,
        payload: Payload,
        *,
        progress: Progress | None = None,
        deadline: float | None = None,
        may_start: Callable[[], bool] = lambda: True,
    ) -> Any:
        """Do a task and wait for it; raises what the task raises.

        deadline: seconds after which the process is stopped and MeshError raised. may_start: asked once the process
        stands and could be stopped; where it says no, WorkerDied is raised and nothing done.
        """
        with self._turn:
            connection = self._started()
            if not may_start():
                raise WorkerDied("the task was stopped before it started")
            self._number += 1
            try:
                connection.send((self._number, task, payload))
                kind, result = self._answer(connection, task, progress, deadline)
            except (EOFError, OSError) as error:
                process = self._process
                self.stop()
                how = f" with status {process.exitcode}" if process is not None and process.exitcode is not None else ""
                raise WorkerDied(f"the worker process died{how} at {task}") from error
            except BaseException:
                self.stop()
                raise
        if kind == "failed":
            raise result
        return result

    def _answer(
        self, connection: Connection, task: str, progress: Progress | None, deadline: float | None
    ) -> tuple[str, Any]:
        """("done", result) or ("failed", error) of the task that was sent last; MeshError where it takes too long."""
        end = None if deadline is None else time.monotonic() + deadline
        while True:
            if end is not None and not connection.poll(max(end - time.monotonic(), 0.0)):
                raise MeshError(f"{task} took longer than {deadline:g} s and was stopped")
            number, kind, *content = connection.recv()
            if number != self._number:
                raise DefectError(f"the worker process answered task {number}, expected {self._number}, {task}")
            if kind != "progress":
                return kind, content[0]
            if progress is not None:
                progress(*content)

    def stop(self) -> None:
        """Stop the process and its children; a task that it was doing fails with WorkerDied."""
        with self._change:
            process, connection = self._process, self._connection
            self._process = self._connection = None
        if process is None or connection is None:
            return
        _end(process, at_once=False)
        process.join(PATIENCE)
        _end(process, at_once=True)
        process.join()
        with contextlib.suppress(OSError):
            connection.close()

    def _started(self) -> Connection:
        with self._change:
            if self._connection is None or self._process is None or not self._process.is_alive():
                context = multiprocessing.get_context("spawn")
                ours, theirs = context.Pipe()
                # not daemonic: a daemonic process may have no children, and tetrahedra are made in one
                process = context.Process(target=self._body, args=(theirs, self._folder), name="csgmesh-worker")
                process.start()
                theirs.close()
                self._process, self._connection = process, ours
            return self._connection


def _end(process: SpawnProcess, *, at_once: bool) -> None:
    """End the worker's group, or the worker alone while it has not made its group yet or where there are no groups."""
    pid = process.pid
    if pid is None:
        return
    if not HAS_GROUPS:
        process.kill() if at_once else process.terminate()
        return
    number = signal.SIGKILL if at_once else signal.SIGTERM
    with contextlib.suppress(ProcessLookupError, PermissionError):
        if os.getpgid(pid) == pid:
            os.killpg(pid, number)
        else:
            os.kill(pid, number)
