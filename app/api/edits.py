"""Edits of a mesh: each gives a new mesh, with its parent and what was done."""

from __future__ import annotations

import json
from typing import Annotated, Any

from fastapi import APIRouter, Body, Response
from pydantic import Field

from app.api.context import Context, Ctx, question_key
from app.api.meshing import QUEUED, JobResource, job_resource
from app.api.problems import problem_responses
from app.editing import MOST_EDITS, Edit, MergeEdit, refuse_too_much
from app.schemas import Schema
from app.tables import MeshRow

router = APIRouter(prefix="/v1", tags=["meshes"])

EDITS_EXAMPLE = {
    "edits": [
        {"op": "merge", "mesh": "9a3d2c4b6e8f7a105f1c0b7e"},
        {"op": "connect", "tolerance": 0.01},
        {"op": "add_node", "at": [120, 40, 2.5]},
    ]
}


class EditsRequest(Schema):
    """What to do, in this order."""

    edits: list[Edit] = Field(min_length=1, max_length=MOST_EDITS)
    unchecked: bool = Field(default=False, description="keep the mesh even if it does not pass its own checks")


@router.post(
    "/meshes/{mesh_id}/edits",
    status_code=202,
    response_model=JobResource,
    responses={**QUEUED, **problem_responses(404, 422)},
)
def edit_mesh(
    mesh_id: str,
    response: Response,
    context: Ctx,
    wanted: Annotated[EditsRequest, Body(examples=[EDITS_EXAMPLE])],
) -> JobResource:
    """Edit a mesh as a job: merge, connect, add_node, move_node, delete_segment. The mesh itself stays as it is.

    The new mesh belongs to the same model; `parent` names the mesh that it came from, `edits` and `history` what was
    done.
    """
    row = context.mesh(mesh_id)
    others = [context.mesh(edit.mesh) for edit in wanted.edits if isinstance(edit, MergeEdit)]
    refuse_too_much(len(wanted.edits), sum(_n_node(context, each) for each in (row, *others)))
    payload = {
        "task": "edit",
        "parent": row.id,
        **_contents(row),
        "edits": [_resolved(edit, context) for edit in wanted.edits],
        "unchecked": wanted.unchecked,
    }
    job = context.jobs.submit(row.model, question_key("edit", payload), payload)
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    return job_resource(job)


def _n_node(context: Context, row: MeshRow) -> int:
    return int(json.loads(context.artifacts.get(row.answer))["nodes"])


def _contents(row: MeshRow) -> dict[str, str]:
    return {"content": row.content, "answer": row.answer}


def _resolved(edit: Edit, context: Context) -> dict[str, Any]:
    """The edit as the worker wants it: the other mesh of a merge with its artifacts. 404 where it is not there."""
    plain = edit.model_dump(mode="json")
    if isinstance(edit, MergeEdit):
        return {"edit": plain, **_contents(context.mesh(edit.mesh))}
    return {"edit": plain}
