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

from app.work import Payload, Progress, serve_tasks
from kernel.errors import DefectError, MeshError

PATIENCE = 2.0
"""Seconds that a stopped worker has to clean up behind itself."""


class WorkerDied(DefectError):
    """The process went away in the middle of a task: it crashed, ran out of memory, or was stopped."""


class Worker:
    """One process that does one task at a time; made at the first task, made anew after a crash.

    body: what the process runs, a function (connection, artifacts folder).
    """

    def __init__(self, artifacts_folder: Path, body: Callable[[Connection, str], None] = serve_tasks) -> None:
        self._folder = str(artifacts_folder)
        self._body = body
        self._turn = threading.Lock()
        self._change = threading.Lock()
        self._process: SpawnProcess | None = None
        self._connection: Connection | None = None
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
            end = None if deadline is None else time.monotonic() + deadline
            try:
                connection.send((task, payload))
                while True:
                    if end is not None and not connection.poll(max(end - time.monotonic(), 0.0)):
                        self.stop()
                        raise MeshError(f"{task} took longer than {deadline:g} s and was stopped")
                    message = connection.recv()
                    if message[0] == "done":
                        return message[1]
                    if message[0] == "failed":
                        raise message[1]
                    if progress is not None:
                        progress(message[1], message[2])
            except (EOFError, OSError) as error:
                process = self._process
                self.stop()
                how = f" with status {process.exitcode}" if process is not None and process.exitcode is not None else ""
                raise WorkerDied(f"the worker process died{how} at {task}") from error

    def stop(self) -> None:
        """Stop the process and its children; a task that it was doing fails with WorkerDied."""
        with self._change:
            process, connection = self._process, self._connection
            self._process = self._connection = None
        if process is None or connection is None:
            return
        _signal_group(process, signal.SIGTERM)
        process.join(PATIENCE)
        _signal_group(process, signal.SIGKILL)
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


def _signal_group(process: SpawnProcess, number: signal.Signals) -> None:
    """Signal the worker's group, or the worker alone while it has not made its group yet."""
    pid = process.pid
    if pid is None:
        return
    with contextlib.suppress(ProcessLookupError, PermissionError):
        if os.getpgid(pid) == pid:
            os.killpg(pid, number)
        else:
            os.kill(pid, number)
