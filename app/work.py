"""What a worker process does for the service: tasks over plain data, results as JSON or artifacts.

A task is a function (payload, artifacts, progress) -> result, named in TASKS. It raises what the pipeline raises.
"""

from __future__ import annotations

import contextlib
import functools
import json
import os
import pickle
import signal
import time
from collections.abc import Callable
from dataclasses import replace
from multiprocessing.connection import Connection
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

from app.artifacts import Artifacts
from app.collector import collect_rarely
from kernel.errors import DefectError

if TYPE_CHECKING:
    from app.pipeline import Classified, Meshed
    from kernel.csg.tree import CsgModel
    from rules.engine import RuleBase

Progress = Callable[[str, float], None]
Payload = dict[str, Any]

HAS_GROUPS = os.name == "posix"
"""Processes have groups here, by which a worker is stopped with its children; Windows has none."""

PROGRESS_EVERY = 0.2
"""Seconds between two reports of one stage's progress: each is a write to the database."""

STAGES = {
    "read": (0.0, 0.02),
    "rules": (0.02, 0.05),
    "evaluate": (0.05, 0.10),
    "segment": (0.10, 0.25),
    "joints": (0.25, 0.35),
    "mesh": (0.35, 0.80),
    "quality": (0.80, 0.84),
    "connect": (0.84, 0.92),
    "check": (0.92, 0.99),
}
"""From where to where a stage moves the progress of the whole; parts that are not named here are the mesher's own."""


def read_task(payload: Payload, _artifacts: Artifacts, _progress: Progress) -> dict[str, Any]:
    """Read the text; gives its language and units."""
    csg = _csg(payload)
    return {"language": csg.language, "units": payload.get("units") or csg.units or "mm"}


def tree_task(payload: Payload, _artifacts: Artifacts, _progress: Progress) -> dict[str, Any]:
    """The tree as JSON."""
    from kernel.csg.treejson import tree_to_json

    return tree_to_json(_csg(payload))


def find_task(payload: Payload, _artifacts: Artifacts, _progress: Progress) -> str:
    """The canonical path of the node that `payload["node"]` addresses."""
    from kernel.csg.tree import find

    return find(_csg(payload).root, payload["node"])[0]


def mesh_names_task(payload: Payload, _artifacts: Artifacts, _progress: Progress) -> None:
    """OptionError where a request to mesh the model names a material, node, segment or joint that there is none of.

    known: ids of segments and joints where the model is classified already, else None.
    """
    from app.meshoptions import check_materials, check_names
    from kernel.mesh.options import MeshOptions
    from kernel.units import unit_set

    csg = _csg(payload)
    materials = payload["materials_of"]
    check_materials(payload["material"], materials, csg, unit_set(payload["units"]))
    options, known = MeshOptions(**payload["options"]), payload["known"]
    check_names(options, csg, only=payload["only"], joints=payload["joints"], materials_of=materials, known=known)


def solid_task(payload: Payload, artifacts: Artifacts, _progress: Progress) -> str:
    """The solid as GLB; gives its artifact."""
    from app.report.gltf import glb
    from app.report.scenes import solid_body
    from kernel.solid.evaluate import evaluate

    return artifacts.put(glb([solid_body(evaluate(_csg(payload)))]))


def classify_task(payload: Payload, artifacts: Artifacts, progress: Progress) -> dict[str, Any]:
    """What `classify --json` gives, the explanation of every decision, and the segments as GLB; all as artifacts."""
    from app import texts
    from app.answers import classification
    from app.report.gltf import glb
    from app.report.scenes import segment_bodies

    classified = _classified(payload, _csg(payload, progress), progress)
    explained = texts.as_json(texts.explanation(classified, None))
    return {
        "answer": artifacts.put(classification(classified).model_dump_json().encode()),
        "explanation": artifacts.put(explained.encode()),
        "picture": artifacts.put(glb(segment_bodies(classified.evaluated, classified.partition.segments))),
    }


def explain_task(payload: Payload, _artifacts: Artifacts, progress: Progress) -> dict[str, Any]:
    """Every rule with its numbers for the decisions about `payload["node"]`."""
    from app import texts

    return texts.explanation(_classified(payload, _csg(payload, progress), progress), payload["node"])


def mesh_task(payload: Payload, artifacts: Artifacts, progress: Progress) -> dict[str, Any]:
    """Mesh; gives the artifacts of the answer and of the content (model and what its pictures need)."""
    from app.answers import meshed_answer
    from kernel.connect.reference import reference_of, with_solids

    meshed = _meshed(payload, _csg(payload, progress), progress)
    answer = meshed_answer(meshed).model_dump_json().encode()
    evaluated = meshed.classified.evaluated
    reference = with_solids(reference_of(meshed.assembly, evaluated), meshed.assembly, evaluated)
    return {
        "answer": artifacts.put(answer),
        "content": artifacts.put(pickle.dumps({"model": meshed.model, "reference": reference}, protocol=5)),
    }


def files_task(payload: Payload, _artifacts: Artifacts | None, progress: Progress) -> dict[str, Any]:
    """Mesh; gives the answer and the files themselves: the deck in `format`, and the report where `report` is true."""
    from app import pipeline
    from app.answers import meshed_answer
    from app.meshoptions import check_materials, check_names
    from app.report.page import report_page
    from kernel.mesh.options import MeshOptions

    csg = _csg(payload, progress)
    csg = replace(csg, materials={**csg.materials, **payload["materials"]})
    check_materials(payload["material"], payload["materials_of"], csg, pipeline.units_of(csg, payload["units"]))
    check_names(MeshOptions(**payload["options"]), csg, materials_of=payload["materials_of"])
    meshed = _meshed(payload, csg, progress)
    return {
        "answer": meshed_answer(meshed).model_dump(mode="json"),
        "deck": pipeline.write_deck(meshed, "", payload["format"]),
        "report": report_page(meshed).encode() if payload["report"] else None,
    }


def edit_task(payload: Payload, artifacts: Artifacts, progress: Progress) -> dict[str, Any]:
    """Edit a kept mesh; gives the artifacts of the new one's answer and content."""
    from app.editing import Subject, apply_edits, checked, edited_answer, parse_edits
    from kernel.edit.edited import Edited

    def kept(one: dict[str, Any]) -> Subject:
        content = pickle.loads(artifacts.get(one["content"]))
        edited = Edited.of(content["model"], content.get("reference"))
        return Subject(edited, json.loads(artifacts.get(one["answer"])))

    start = time.perf_counter()
    others = {one["edit"]["mesh"]: one for one in payload["edits"] if one["edit"]["op"] == "merge"}
    edits = parse_edits([one["edit"] for one in payload["edits"]])
    parent = kept(payload)
    subject = apply_edits(parent, edits, lambda mesh: kept(others[mesh]), progress)
    progress("check", 0.0)
    checks, quality = checked(subject, payload["unchecked"])
    answer = edited_answer(subject, checks, quality)
    before = parent.answer or {}
    answer |= {
        "parent": payload["parent"],
        "edits": [one["edit"] for one in payload["edits"]],
        "history": [*before.get("history", []), *answer["history"]],
        "seconds": {"edit": round(time.perf_counter() - start, 4)},
    }
    content = {"model": subject.edited.model, "reference": subject.edited.reference}
    return {
        "answer": artifacts.put(json.dumps(answer, allow_nan=False).encode()),
        "content": artifacts.put(pickle.dumps(content, protocol=5)),
    }


def deck_task(payload: Payload, artifacts: Artifacts, _progress: Progress) -> str:
    """A kept model as a deck; gives its artifact."""
    from kernel.deck.deck import format_for

    model = pickle.loads(artifacts.get(payload["content"]))["model"]
    return artifacts.put(format_for("", payload["format"]).write(model))


def mesh_glb_task(payload: Payload, artifacts: Artifacts, _progress: Progress) -> str:
    """A kept mesh as GLB, a node of the scene for each segment; gives its artifact."""
    from app.report.gltf import glb
    from app.report.quality_scene import quality_bodies
    from app.report.scenes import mesh_bodies

    model = pickle.loads(artifacts.get(payload["content"]))["model"]
    bodies = quality_bodies(model) if payload["colour"] == "quality" else mesh_bodies(model)
    return artifacts.put(glb(bodies))


def rules_load_task(payload: Payload, _artifacts: Artifacts, _progress: Progress) -> dict[str, str]:
    """Name and version of a rule base, and the text of the own one; RuleError where it is wrong."""
    base = _rules(payload["rules"])
    return {"name": base.name, "version": base.version, "text": _own_rules() if payload["rules"] is None else ""}


def rules_check_task(payload: Payload, _artifacts: Artifacts, _progress: Progress) -> dict[str, Any]:
    """What `rules check --json` gives."""
    from rules.analysis import check, check_text

    given = payload["rules"]
    return (check() if given is None else check_text(given["text"], given["name"])).to_json()


def rules_test_task(payload: Payload, _artifacts: Artifacts, _progress: Progress) -> dict[str, Any]:
    """What `rules test --json` gives."""
    from app.rulework import plan_of
    from rules.analysis import run_cases

    return run_cases(_rules(payload["rules"]), plan_of).to_json()


def rules_diff_task(payload: Payload, _artifacts: Artifacts, _progress: Progress) -> dict[str, Any]:
    """What `rules diff --json` gives."""
    from app.rulework import compare

    return compare(_rules(payload["before"]), _rules(payload["after"]), payload["models"]).to_json()


TASKS: dict[str, Callable[[Payload, Artifacts, Progress], Any]] = {
    "read": read_task,
    "tree": tree_task,
    "find": find_task,
    "mesh_names": mesh_names_task,
    "solid": solid_task,
    "classify": classify_task,
    "explain": explain_task,
    "mesh": mesh_task,
    "files": files_task,
    "edit": edit_task,
    "deck": deck_task,
    "mesh_glb": mesh_glb_task,
    "rules_load": rules_load_task,
    "rules_check": rules_check_task,
    "rules_test": rules_test_task,
    "rules_diff": rules_diff_task,
}


def serve_tasks(connection: Connection, artifacts_folder: str) -> None:
    """Body of a worker process: (number, task, payload) in; (number, "progress", stage, share)..., then
    (number, "done", result) or (number, "failed", error) out. Ends where the service goes away.
    """
    if HAS_GROUPS:
        os.setsid()  # a group of its own, so that the children of a task can be stopped with it
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, _stop)
    collect_rarely()
    artifacts = Artifacts(Path(artifacts_folder))
    with contextlib.suppress(EOFError, BrokenPipeError, ConnectionResetError):
        while True:
            number, task, payload = connection.recv()
            report = reporter(functools.partial(_send_progress, connection, number))
            connection.send((number, *_run(task, payload, artifacts, report)))


def _run(task: str, payload: Payload, artifacts: Artifacts, progress: Progress) -> tuple[str, Any]:
    try:
        return "done", TASKS[task](payload, artifacts, progress)
    except BrokenPipeError:
        raise
    except Exception as error:  # noqa: BLE001  the edge of the process: whatever it is, the service hears of it
        from app.logs import record_defect
        from kernel.errors import CsgmeshError

        if isinstance(error, CsgmeshError):
            return "failed", error
        record_defect(error)
        return "failed", DefectError(f"{type(error).__name__}: {error}")


def _send_progress(connection: Connection, number: int, stage: str, share: float) -> None:
    connection.send((number, "progress", stage, share))


def reporter(send: Progress) -> Progress:
    """What the pipeline reports to: sends a stage, and how much of the whole is done, not too often."""
    last_stage, last_time = "", 0.0

    def report(stage: str, share: float) -> None:
        nonlocal last_stage, last_time
        moment = time.monotonic()
        if stage == last_stage and moment - last_time < PROGRESS_EVERY:
            return
        last_stage, last_time = stage, moment
        start, end = STAGES.get(stage, STAGES["mesh"])
        send(stage, start + (end - start) * min(max(share, 0.0), 1.0))

    return report


def _csg(payload: Payload, progress: Progress | None = None) -> CsgModel:
    from kernel.csg.reader import read_model

    if progress is not None:
        progress("read", 0.0)
    return read_model(payload["text"], payload["name"])


def _meshed(payload: Payload, csg: CsgModel, progress: Progress) -> Meshed:
    """The connected model that is asked for; CheckError where it does not pass its checks and has to."""
    from app import pipeline
    from kernel.mesh.options import MeshOptions

    meshed = pipeline.mesh(
        _classified(payload, csg, progress),
        MeshOptions(**payload["options"]),
        material=payload["material"],
        coupling=payload["coupling"],
        joint_couplings=payload.get("joints", {}),
        materials_of=payload.get("materials_of", {}),
        mass=payload["mass"],
        apart=payload.get("apart", False),
        only=payload.get("only", ()),
        progress=progress,
    )
    if not payload["unchecked"]:
        pipeline.refuse_failed(meshed)
    return meshed


def _classified(payload: Payload, csg: CsgModel, progress: Progress) -> Classified:
    from app import pipeline
    from kernel.plan import Override

    overrides = {o["node"]: Override(o["type"], o["author"], o["reason"]) for o in payload["overrides"]}
    rules = _rules(payload["rules"])
    return pipeline.classify(
        csg, overrides=overrides, rules=rules, units=payload["units"], gap=payload.get("gap", 0.0), progress=progress
    )


def _rules(given: dict[str, str] | RuleBase | None) -> RuleBase:
    """A rule base that was sent, as text or as itself; the own one for None."""
    from rules.engine import RuleBase, load_rule_base, rule_base_from_text

    if isinstance(given, RuleBase):
        return given
    return load_rule_base() if given is None else rule_base_from_text(given["text"], given["name"])


def _own_rules() -> str:
    import rules

    files = sorted((Path(rules.__file__).parent / "base").glob("*.yaml"))
    return "\n".join(f"# {file.name}\n{file.read_text(encoding='utf-8')}" for file in files)


def _stop(_signal: int, _frame: object) -> NoReturn:
    raise SystemExit(128 + signal.SIGTERM)
