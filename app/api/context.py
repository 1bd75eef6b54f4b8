"""What every operation needs: the store, the artifacts, the jobs; and the look-ups that answer 404."""

from __future__ import annotations

import hashlib
import json
from collections import OrderedDict
from threading import Lock
from typing import Annotated, Any, TypeVar

from fastapi import Depends, HTTPException, Request

from app.artifacts import Artifacts
from app.jobs import Jobs
from app.settings import Settings
from app.sources import sources_hash
from app.store import Store
from app.tables import JobRow, MeshRow, ModelRow, RuleBaseRow

REMEMBERED = 512
"""Answers of short tasks that are kept in memory, by the hash of their question."""

OWN_RULES = "base"
"""Name of the rule base that comes with csgmesh."""


T = TypeVar("T")


class Context:
    """The service's parts, made once."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.store = Store(settings.database)
        self.artifacts = Artifacts(settings.artifacts)
        self.jobs = Jobs(self.store, self.artifacts, settings.workers, settings.scheduler)
        self._answers: OrderedDict[str, Any] = OrderedDict()
        self._lock = Lock()

    def ask(self, task: str, payload: dict[str, Any]) -> Any:
        """A short task's result, remembered: tasks are functions of their payload."""
        key = question_key(task, payload)
        with self._lock:
            if key in self._answers:
                self._answers.move_to_end(key)
                return self._answers[key]
        result = self.jobs.call(task, payload)
        with self._lock:
            self._answers[key] = result
            while len(self._answers) > REMEMBERED:
                self._answers.popitem(last=False)
        return result

    def remembered(self, task: str, payload: dict[str, Any]) -> Any:
        """A short task's result where it was asked for before, else None."""
        with self._lock:
            return self._answers.get(question_key(task, payload))

    def model(self, model_id: str) -> ModelRow:
        """One model; 404 where there is none."""
        return found(self.store.model(model_id), f"no model {model_id!r}")

    def job(self, job_id: str) -> JobRow:
        """One job; 404 where there is none."""
        return found(self.store.job(job_id), f"no job {job_id!r}")

    def mesh(self, mesh_id: str) -> MeshRow:
        """One mesh; 404 where there is none."""
        return found(self.store.mesh(mesh_id), f"no mesh {mesh_id!r}")

    def rule_base(self, wanted: str | None) -> RuleBaseRow | None:
        """`name` or `name@version`; the active one for None, and None for the own one; 404 where there is none."""
        if wanted is None:
            return self.store.active_rule_base()
        if wanted == OWN_RULES:
            return None
        name, _, version = wanted.partition("@")
        return found(self.store.rule_base(name, version or None), f"no rule base {wanted!r}")

    def text_payload(self, model: ModelRow) -> dict[str, Any]:
        """A model's text, as tasks want it."""
        return {"text": self.artifacts.get(model.text).decode(), "name": model.name}

    def model_payload(
        self, model: ModelRow, rulebase: str | None, units: str | None = None, gap: float = 0.0
    ) -> dict[str, Any]:
        """A model with its overrides and the rule base that decides, as tasks want it: complete in itself."""
        rules = self.rule_base(rulebase)
        overrides = self.store.overrides(model.id)
        return {
            **self.text_payload(model),
            "units": units,
            "gap": gap,
            "rules": None
            if rules is None
            else {"name": rules.name, "version": rules.version, "text": self.artifacts.get(rules.text).decode()},
            "overrides": [{"node": o.node, "type": o.type, "author": o.author, "reason": o.reason} for o in overrides],
        }


def question_key(task: str, payload: dict[str, Any]) -> str:
    """SHA-256 of a task with its payload, and of the version and the sources of csgmesh that would answer."""
    from importlib.metadata import version

    text = json.dumps([version("csgmesh"), sources_hash(), task, payload], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def found(row: T | None, message: str) -> T:
    """`row`, or 404 with `message`."""
    if row is None:
        raise HTTPException(404, message)
    return row


def context_of(request: Request) -> Context:
    """The service's context."""
    context: Context = request.app.state.context
    return context


Ctx = Annotated[Context, Depends(context_of)]
