"""Segments of a model, the overrides that stand beside the rules, and their history."""

from __future__ import annotations

import json
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Body, HTTPException, Query, Response
from pydantic import Field, FiniteFloat

from app.api.context import Context, Ctx
from app.api.problems import documented, problem_responses
from app.schemas import Classification, Schema
from app.tables import ModelRow, OverrideRow
from kernel.errors import AmbiguousNameError, OverrideError

router = APIRouter(prefix="/v1/models/{model_id}", tags=["segments"])

RulebaseQuery = Annotated[
    str | None,
    Query(examples=["base"], description="`base` (the own one), `name` or `name@version`; default: the active one"),
]

GapQuery = Annotated[
    FiniteFloat, Query(ge=0, examples=[0.1], description="faces no further apart than this count as touching")
]

SEGMENTS_EXAMPLE = {
    "model": "bracket.csg", "units": "mm", "volume": 81234.5, "rule_base": "base 3f2a9c", "segments": [{
        "id": "s1", "node": "0.1", "name": "BASE", "type": "plate", "origin": "rule", "volume": 48000.0,
        "thickness": 6.0, "length": None, "radius": None, "holes": 2, "section": None,
        "decision": {
            "rule": "thin-block", "certainty": 0.9, "by_rule": "plate", "margin": 0.33, "conflicts": [],
            "because": "smallest in-plane side is 13.3 x the thickness (limit 10)",
            "rejected": [{"type": "beam", "rule": "long-block", "because": "slenderness 1.2, needs 10"}],
        },
    }],
    "joints": [{"id": "j1", "kind": "tee", "segments": ["s1", "s2"], "area": 360.0}],
    "checks": {"volume_of_segments": 81234.5, "mass_error": 0.0},
}  # fmt: skip

OVERRIDE_EXAMPLE = {
    "node": "0.1",
    "type": "brick",
    "author": "anna",
    "reason": "stress at the fillet is wanted",
    "created": "2026-11-22T22:47:00.000000+00:00",
}


class OverrideRequest(Schema):
    """What a user decides about a node."""

    type: Literal["beam", "plate", "cylinder_plate", "brick", "plates", "split", "auto"]
    reason: str = Field(default="", max_length=1000)
    author: str = Field(default="user", max_length=100)


class OverrideResource(Schema):
    """An override that stands."""

    node: str
    type: str
    author: str
    reason: str
    created: str


class OverrideEvent(Schema):
    """An override that was set, or taken back (`type` null)."""

    node: str
    type: str | None
    author: str
    reason: str
    created: str


@router.get(
    "/segments",
    response_model=Classification,
    responses=documented(SEGMENTS_EXAMPLE, 404, 409, 422),
)
def get_segments(model_id: str, context: Ctx, rulebase: RulebaseQuery = None, gap: GapQuery = 0.0) -> Classification:
    """What `csgmesh classify --json` gives, with the overrides that stand."""
    digests = _classify(context, context.model(model_id), rulebase, None, gap)
    return Classification.model_validate_json(context.artifacts.get(digests["answer"]))


@router.get(
    "/explanation",
    responses={
        200: {
            "content": {"application/json": {"example": {"model": "bracket.csg", "decisions": [{"node": "0.1"}]}}},
            "description": "Facts, rules and rejected alternatives of every node that was decided about",
        },
        **problem_responses(404, 409, 422),
    },
)
def get_explanation(
    model_id: str,
    context: Ctx,
    rulebase: RulebaseQuery = None,
    node: Annotated[
        str | None,
        Query(examples=["0.1"], description="path or name; then also every rule, with the numbers it was asked with"),
    ] = None,
) -> dict[str, Any]:
    """What `csgmesh classify --explain --json` gives; with `node` what `--explain NODE --json` gives."""
    if node is not None:
        payload = {**context.model_payload(context.model(model_id), rulebase), "node": node}
        about: dict[str, Any] = context.ask("explain", payload)
        return about
    digests = _classify(context, context.model(model_id), rulebase, None)
    explained: dict[str, Any] = json.loads(context.artifacts.get(digests["explanation"]))
    return explained


@router.get(
    "/segments.glb",
    response_class=Response,
    responses=documented(None, 404, 409, 422, media_type="model/gltf-binary"),
)
def get_segments_glb(model_id: str, context: Ctx, rulebase: RulebaseQuery = None) -> Response:
    """The segments' solids as binary glTF: for each its faces (named `s1`) and its edges (`s1 edges`)."""
    digests = _classify(context, context.model(model_id), rulebase, None)
    return Response(context.artifacts.get(digests["picture"]), media_type="model/gltf-binary")


@router.get(
    "/overrides",
    response_model=list[OverrideResource],
    responses=documented([OVERRIDE_EXAMPLE], 404),
)
def list_overrides(model_id: str, context: Ctx) -> list[OverrideResource]:
    """The overrides that stand, by path."""
    context.model(model_id)
    return [_resource(row) for row in context.store.overrides(model_id)]


@router.get(
    "/overrides/history",
    response_model=list[OverrideEvent],
    responses=documented([OVERRIDE_EXAMPLE], 404),
)
def get_history(model_id: str, context: Ctx) -> list[OverrideEvent]:
    """Every override that was ever set or taken back, oldest first; a node named `history` is addressed by its path."""
    context.model(model_id)
    return [
        OverrideEvent(node=row.node, type=row.type, author=row.author, reason=row.reason, created=row.created)
        for row in context.store.override_history(model_id)
    ]


@router.get(
    "/overrides/{node:path}",
    response_model=OverrideResource,
    responses=documented(OVERRIDE_EXAMPLE, 404, 422),
)
def get_override(model_id: str, node: str, context: Ctx) -> OverrideResource:
    """The override of one node, by path (the root as %2F) or name (a node named `history` by path only)."""
    model = context.model(model_id)
    path = _path(context, model, node)
    for row in context.store.overrides(model_id):
        if row.node == path:
            return _resource(row)
    raise HTTPException(404, f"node {path} is not overridden")


@router.put(
    "/overrides/{node:path}",
    response_model=OverrideResource,
    responses=documented(OVERRIDE_EXAMPLE, 404, 422),
)
def put_override(
    model_id: str,
    node: str,
    context: Ctx,
    wanted: Annotated[OverrideRequest, Body(examples=[{"type": "brick", "reason": "stress at the fillet is wanted"}])],
) -> OverrideResource:
    """Decide a node yourself; refused, with the reason, where the node cannot be that. `auto` takes it back."""
    model = context.model(model_id)
    path = _path(context, model, node)
    if wanted.type == "auto":
        context.store.remove_override(model_id, path, wanted.author, wanted.reason)
        return OverrideResource(node=path, type="auto", author=wanted.author, reason=wanted.reason, created="")
    new = {"node": path, "type": wanted.type, "author": wanted.author, "reason": wanted.reason}
    _classify(context, model, None, new)
    return _resource(context.store.set_override(model_id, path, wanted.type, wanted.author, wanted.reason))


@router.delete("/overrides/{node:path}", status_code=204, responses=problem_responses(404, 422))
def delete_override(
    model_id: str,
    node: str,
    context: Ctx,
    reason: Annotated[str, Query(max_length=1000, examples=["no longer wanted"])] = "",
    author: Annotated[str, Query(max_length=100, examples=["anna"])] = "user",
) -> None:
    """Take the override of a node back: the rules decide again."""
    model = context.model(model_id)
    path = _path(context, model, node)
    if not context.store.remove_override(model_id, path, author, reason):
        raise HTTPException(404, f"node {path} is not overridden")


def _classify(
    context: Context, model: ModelRow, rulebase: str | None, new: dict[str, str] | None, gap: float = 0.0
) -> dict[str, str]:
    """Artifacts of the classification, with one override more where `new` is given."""
    payload = context.model_payload(model, rulebase, gap=gap)
    if new is not None:
        kept = [o for o in payload["overrides"] if o["node"] != new["node"]]
        payload["overrides"] = sorted([*kept, new], key=lambda o: str(o["node"]))
    digests: dict[str, str] = context.ask("classify", payload)
    return digests


def _path(context: Context, model: ModelRow, node: str) -> str:
    """The canonical path of a path or name; 404 where nothing has that address, 422 where several nodes have it."""
    try:
        path: str = context.ask("find", {**context.text_payload(model), "node": node})
    except AmbiguousNameError:
        raise
    except OverrideError as error:
        raise HTTPException(404, str(error)) from error
    return path


def _resource(row: OverrideRow) -> OverrideResource:
    return OverrideResource(node=row.node, type=row.type, author=row.author, reason=row.reason, created=row.created)
