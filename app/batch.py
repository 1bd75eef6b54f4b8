"""Many models to decks, each on its own: one that fails stops no other, and what is done is not done again.

    tasks = plan(models, folder, request)       a task a model: its files' names, and the key of all that decides them
    for record in run(tasks, folder, ...):      in worker processes here, or on a dask cluster
        ...

What became of each model stands in FOLDER/batch.jsonl, a JSON object a line, written as soon as it is known: a batch
that was stopped goes on where it was (`resume`).
"""

from __future__ import annotations

import hashlib
import json
import os
import queue
import threading
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from app.failure import failure
from app.output import check_writable, write_files
from app.sources import sources_hash
from app.work import Payload
from app.workers import Worker
from kernel.csg.reader import read_text
from kernel.errors import CsgmeshError, OptionError

RECORDS = "batch.jsonl"
"""Name of the file of records in the batch's folder."""

Record = dict[str, Any]
"""What became of one model: model, deck, report, key, status ("done" or "failed"), then sha256, nodes, elements,
components, mass_error, warnings and seconds, or problem as app/failure.py has it."""

Do = Callable[[Payload], dict[str, Any]]
"""Meshes one model, somewhere: gives what work.files_task gives, raises what it raises."""


@dataclass(frozen=True, slots=True)
class Task:
    """A model to mesh. deck, report: names in the folder. key: SHA-256 of all that the files depend on.

    problem: why it cannot even be begun (the file cannot be read), else None.
    """

    model: str
    deck: str
    report: str | None
    key: str
    payload: Payload
    problem: CsgmeshError | None = None


def plan(models: Sequence[str], request: Payload, ending: str) -> list[Task]:
    """A task for each model, in the order given; request: what work.files_task wants, without text and name.

    ending: of the decks, as ".bdf". OptionError: two models would be written to one file, or one is standard input.
    """
    tasks: list[Task] = []
    writers: dict[str, str] = {}
    settings = json.dumps(request, sort_keys=True, default=lambda base: base.version).encode()  # of a rule base
    for model in models:
        if model == "-":
            raise OptionError("-: standard input is no model of a batch, expected files")
        stem = Path(model).stem
        deck, report = f"{stem}{ending}", f"{stem}.html" if request["report"] else None
        # file systems may take names that differ in case for one
        name = stem.casefold()
        if name in writers:
            raise OptionError(
                f"{writers[name]} and {model} would both be written to {deck}, expected names that differ"
            )
        writers[name] = model
        payload, problem, text = {**request, "name": model}, None, ""
        try:
            payload["text"] = text = read_text(model)
        except CsgmeshError as error:
            problem = error
        total = hashlib.sha256(sources_hash().encode())
        for part in (settings, os.path.basename(model).encode(), text.encode()):
            total.update(len(part).to_bytes(8, "big") + part)
        tasks.append(Task(model, deck, report, total.hexdigest(), payload, problem))
    return tasks


def open_folder(folder: str) -> Path:
    """The folder of a batch, made where there is none. OptionError where nothing can be written in it."""
    place = Path(folder)
    try:
        place.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise OptionError(f"{folder}: cannot be made, {error.strerror}, expected a folder for the decks") from error
    check_writable(str(place / RECORDS))
    return place


def records_of(folder: Path) -> dict[str, Record]:
    """What is on record in a folder, by model, the last word on each; a line that was cut off says nothing."""
    found: dict[str, Record] = {}
    try:
        lines = (folder / RECORDS).read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        return found
    for line in lines:
        try:
            record = json.loads(line)
            found[record["model"]] = record
        except (ValueError, KeyError, TypeError, RecursionError):
            continue
    return found


def is_kept(task: Task, folder: Path, record: Record | None) -> bool:
    """Whether the files of a task are there just as they would be made again."""
    if record is None or record.get("key") != task.key or record.get("status") != "done":
        return False
    wanted = {task.deck: record.get("sha256"), task.report: record.get("report_sha256")}
    return all(_hash_of(folder / name) == digest for name, digest in wanted.items() if name is not None)


def run(
    tasks: Sequence[Task], folder: Path, doers: Sequence[Do], *, resume: bool = False
) -> Generator[Record, None, None]:
    """Do the tasks, as many at once as there are doers; gives the records in the order of the tasks.

    Files and records are written as tasks end; at the end the records are written anew, in the order of the tasks.
    """
    before = records_of(folder) if resume else {}
    kept = {task.model: before[task.model] for task in tasks if is_kept(task, folder, before.get(task.model))}
    _write_records(folder, list(kept.values()))
    with _pool([task for task in tasks if task.model not in kept], folder, doers) as ended:
        records: list[Record] = []
        for task in tasks:
            records.append(kept.get(task.model) or ended(task))
            yield {**records[-1], "kept": task.model in kept}
    _write_records(folder, records)


@contextmanager
def _pool(tasks: Sequence[Task], folder: Path, doers: Sequence[Do]) -> Iterator[Callable[[Task], Record]]:
    """A function that waits for the record of a task; threads, one a doer, see to the tasks in their order."""
    idle: queue.SimpleQueue[Do] = queue.SimpleQueue()
    for do in doers:
        idle.put(do)
    writing = threading.Lock()
    is_stopping = threading.Event()

    def work(task: Task) -> Record:
        do = idle.get()
        try:
            record = _done(task, folder, do)
        finally:
            idle.put(do)
        with writing:
            if not is_stopping.is_set():
                _append_record(folder, record)
        return record

    executor = ThreadPoolExecutor(len(doers))
    futures = {task.model: executor.submit(work, task) for task in tasks}
    try:
        yield lambda task: futures[task.model].result()
    finally:
        is_stopping.set()
        executor.shutdown(wait=False, cancel_futures=True)


def _done(task: Task, folder: Path, do: Do) -> Record:
    """Mesh one model and write its files; the record of it. OptionError where the files cannot be written."""
    start = time.perf_counter()
    record = {"model": task.model, "deck": task.deck, "report": task.report, "key": task.key}
    try:
        if task.problem is not None:
            raise task.problem
        result = do(task.payload)
    except Exception as error:  # noqa: BLE001  whatever one model does, the others go on; the record says what it was
        return {**record, "status": "failed", "problem": failure(error)}
    contents = {task.deck: result["deck"]}
    if task.report is not None:
        contents[task.report] = result["report"]
    write_files({str(folder / name): content for name, content in contents.items()})
    hashes = {name: hashlib.sha256(content).hexdigest() for name, content in contents.items()}
    answer = result["answer"]
    return {
        **record,
        "status": "done",
        "sha256": hashes[task.deck],
        "report_sha256": hashes.get(task.report or ""),
        **{name: answer[name] for name in ("nodes", "elements", "couplings", "components")},
        "segments": len(answer["segments"]),
        "mass_error": answer["mass"]["error"],
        "warnings": answer["warnings"],
        "seconds": round(time.perf_counter() - start, 3),
    }


@contextmanager
def local_doers(count: int, scratch: Path) -> Iterator[list[Do]]:
    """`count` worker processes of this machine; they end with the block. scratch: a folder that they may use."""
    workers = [Worker(scratch) for _ in range(count)]

    def by(worker: Worker) -> Do:
        return lambda payload: worker.call("files", payload)

    try:
        yield [by(worker) for worker in workers]
    finally:
        for worker in workers:
            worker.stop()


def exit_status(records: Sequence[Record]) -> int:
    """0 where all is done, else the worst: a defect (1), a model that cannot be meshed (3), wrong input (2)."""
    found = {record["problem"]["exit_status"] for record in records if record["status"] == "failed"}
    return next((status for status in (1, 3, 2) if status in found), 0)


def _hash_of(path: Path) -> str | None:
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return None


def _append_record(folder: Path, record: Record) -> None:
    path = folder / RECORDS
    try:
        with path.open("a", encoding="utf-8") as stream:
            stream.write(_line(record))
    except OSError as error:
        raise OptionError(f"{path}: cannot be written, {error.strerror}") from error


def _write_records(folder: Path, records: Sequence[Record]) -> None:
    write_files({str(folder / RECORDS): "".join(map(_line, records)).encode()})


def _line(record: Record) -> str:
    return json.dumps(record, ensure_ascii=False, allow_nan=False) + "\n"
