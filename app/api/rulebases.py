"""Rule bases: kept by version, checked, tested, compared, and one of them active."""

from __future__ import annotations

import re
from typing import Annotated, Any

from fastapi import APIRouter, Body, HTTPException, Response
from pydantic import Field

from app.api.context import OWN_RULES, Context, Ctx
from app.api.problems import documented, problem_responses
from app.schemas import Schema
from app.tables import RuleBaseRow

router = APIRouter(prefix="/v1/rulebases", tags=["rule bases"])

MAX_RULE_TEXT = 500_000

ADDRESSABLE = re.compile(r"\w[\w .-]*")
"""Names of rule bases that paths and `name@version` can hold."""

RULES_EXAMPLE = """\
name: house
extends: base
parameters:
  beam_slenderness: {value: 12}
"""

BASE_EXAMPLE = {
    "name": "house",
    "version": "3f2a9c41d0e7",
    "author": "anna",
    "created": "2026-11-22T22:47:00.000000+00:00",
    "is_active": False,
}
CHECK_EXAMPLE = {"name": "house", "version": "3f2a9c41d0e7", "rules": 21, "ok": True, "findings": []}
TEST_EXAMPLE = {"name": "house", "version": "3f2a9c41d0e7", "ok": True, "cases": [], "not_run": []}
DIFF_EXAMPLE = {
    "a": "base 749de4a14156",
    "b": "house 3f2a9c41d0e7",
    "nodes": 12,
    "changes": [{"node": "table.csg 1.0.0", "before": "beam", "after": "brick"}],
}


class RuleText(Schema):
    """A rule base as its author writes it; its name stands in it."""

    text: str = Field(max_length=MAX_RULE_TEXT)
    author: str = Field(default="user", max_length=100)


class DiffRequest(Schema):
    """against: `base`, `name` or `name@version`. models: ids; without any, the rule bases' own cases."""

    against: str = Field(default=OWN_RULES, max_length=300)
    models: list[str] = Field(default_factory=list, max_length=200)


class RuleBaseResource(Schema):
    """One version of a rule base."""

    name: str
    version: str
    author: str
    created: str
    is_active: bool


class RuleBaseText(RuleBaseResource):
    """The same with its text."""

    text: str


TextBody = Annotated[RuleText, Body(examples=[{"text": RULES_EXAMPLE, "author": "anna"}])]


@router.get("", response_model=list[RuleBaseResource], responses=documented([BASE_EXAMPLE]))
def list_rule_bases(context: Ctx) -> list[RuleBaseResource]:
    """Every version of every rule base, the own one first."""
    own = context.ask("rules_load", {"rules": None})
    is_active = context.store.active_rule_base() is None
    first = RuleBaseResource(name=OWN_RULES, version=own["version"], author="csgmesh", created="", is_active=is_active)
    return [first, *map(_resource, context.store.rule_bases())]


@router.post(
    "",
    status_code=201,
    response_model=RuleBaseResource,
    responses={
        201: {
            "description": "Kept",
            "headers": {"Location": {"schema": {"type": "string"}, "description": "the version"}},
            "content": {"application/json": {"example": BASE_EXAMPLE}},
        },
        **problem_responses(409, 422),
    },
)
def create_rule_base(response: Response, context: Ctx, sent: TextBody) -> RuleBaseResource:
    """Keep a version of a rule base; refused with the place where it is wrong."""
    base = context.ask("rules_load", {"rules": {"name": "-", "text": sent.text}})
    if base["name"] == OWN_RULES:
        raise HTTPException(409, f"the name {OWN_RULES!r} is that of the rule base that comes with csgmesh")
    if not ADDRESSABLE.fullmatch(base["name"]):
        raise HTTPException(
            422, f"the name {base['name']!r} cannot stand in an address, expected letters, digits, blanks, _ . and -"
        )
    text = context.artifacts.put(sent.text.encode())
    row = context.store.add_rule_base(base["name"], base["version"], text, sent.author)
    response.headers["Location"] = f"/v1/rulebases/{row.name}/versions/{row.version}"
    return _resource(row)


@router.post("/validate", responses=documented(CHECK_EXAMPLE, 422))
def validate_text(context: Ctx, sent: TextBody) -> dict[str, Any]:
    """What `csgmesh rules check --json` says of a text that is not kept (yet)."""
    report: dict[str, Any] = context.ask("rules_check", {"rules": {"name": "-", "text": sent.text}})
    return report


@router.get(
    "/{name}/versions/{version}",
    response_model=RuleBaseText,
    responses=documented({**BASE_EXAMPLE, "text": RULES_EXAMPLE}, 404),
)
def get_rule_base(name: str, version: str, context: Ctx) -> RuleBaseText:
    """One version with its text."""
    row = _row(context, name, version)
    if row is None:
        own = context.ask("rules_load", {"rules": None})
        is_active = context.store.active_rule_base() is None
        return RuleBaseText(
            name=OWN_RULES, version=version, author="csgmesh", created="", is_active=is_active, text=own["text"]
        )
    return RuleBaseText(**_resource(row).model_dump(), text=context.artifacts.get(row.text).decode())


@router.post("/{name}/versions/{version}/validate", responses=documented(CHECK_EXAMPLE, 404))
def validate(name: str, version: str, context: Ctx) -> dict[str, Any]:
    """What `csgmesh rules check --json` says."""
    report: dict[str, Any] = context.ask("rules_check", _payload(context, name, version))
    return report


@router.post("/{name}/versions/{version}/test", responses=documented(TEST_EXAMPLE, 404))
def test(name: str, version: str, context: Ctx) -> dict[str, Any]:
    """What `csgmesh rules test --json` says."""
    report: dict[str, Any] = context.ask("rules_test", _payload(context, name, version))
    return report


@router.post("/{name}/versions/{version}/diff", responses=documented(DIFF_EXAMPLE, 404, 422))
def diff(
    name: str,
    version: str,
    context: Ctx,
    wanted: Annotated[DiffRequest, Body(examples=[{"against": "base", "models": ["5f1c0b7e9a3d2c4b6e8f7a10"]}])],
) -> dict[str, Any]:
    """Which nodes of the models would be decided differently than by the rule base `against`."""
    other = context.rule_base(wanted.against)
    models = [context.model(model_id) for model_id in wanted.models]
    payload = {
        "before": None if other is None else _rules(context, other),
        "after": _payload(context, name, version)["rules"],
        "models": {f"{model.name} {model.id}": context.text_payload(model)["text"] for model in models},
    }
    report: dict[str, Any] = context.ask("rules_diff", payload)
    return report


@router.post(
    "/{name}/versions/{version}/activate",
    response_model=list[RuleBaseResource],
    responses=documented([{**BASE_EXAMPLE, "is_active": True}], 404),
)
def activate(name: str, version: str, context: Ctx) -> list[RuleBaseResource]:
    """Let this version decide wherever a request names none."""
    row = _row(context, name, version)
    if row is None:
        context.store.activate_rule_base(None, None)
    else:
        context.store.activate_rule_base(row.name, row.version)
    return list_rule_bases(context)


def _row(context: Context, name: str, version: str) -> RuleBaseRow | None:
    """The version's row, None for the own rule base; 404 where there is none."""
    if name != OWN_RULES:
        return context.rule_base(f"{name}@{version}")
    own = context.ask("rules_load", {"rules": None})["version"]
    if version != own:
        raise HTTPException(404, f"no version {version!r} of the own rule base, which is {own}")
    return None


def _payload(context: Context, name: str, version: str) -> dict[str, Any]:
    row = _row(context, name, version)
    return {"rules": None if row is None else _rules(context, row)}


def _rules(context: Context, row: RuleBaseRow) -> dict[str, str]:
    return {"name": row.name, "text": context.artifacts.get(row.text).decode()}


def _resource(row: RuleBaseRow) -> RuleBaseResource:
    return RuleBaseResource(
        name=row.name, version=row.version, author=row.author, created=row.created, is_active=row.is_active
    )
