"""Meshes, and the jobs that make them."""

from __future__ import annotations

import asyncio
import json
from collections.abc import AsyncIterator
from typing import Annotated, Any, Literal

from fastapi import APIRouter, Body, HTTPException, Query, Request, Response
from pydantic import Field, FiniteFloat
from starlette.concurrency import run_in_threadpool
from starlette.responses import StreamingResponse

from app.api.context import Context, Ctx, question_key
from app.api.problems import documented, problem_responses
from app.failure import problem
from app.meshoptions import asked, split_joints
from app.schemas import MeshAnswer, Problem, Schema
from app.tables import FINISHED, JobRow, ModelRow
from kernel.deck.deck import format_for, formats
from kernel.units import unit_set

router = APIRouter(prefix="/v1", tags=["meshes"])

POLL_EVERY = 0.1
"""Seconds between two looks at a job's row for its events."""

KEEP_ALIVE_EVERY = 15.0
"""Seconds after which a silent stream of events sends a comment, so that proxies keep it open."""

JOB_EXAMPLE = {
    "id": "0b7e9a3d2c4b6e8f7a105f1c",
    "model_id": "5f1c0b7e9a3d2c4b6e8f7a10",
    "state": "running",
    "stage": "mesh",
    "progress": 0.42,
    "created": "2026-11-22T22:47:00.000000+00:00",
    "started": "2026-11-22T22:47:00.100000+00:00",
    "finished": None,
    "mesh_id": None,
    "problem": None,
}

QUEUED: dict[int | str, dict[str, Any]] = {
    202: {
        "description": "Queued",
        "headers": {"Location": {"schema": {"type": "string"}, "description": "the job"}},
        "content": {"application/json": {"example": {**JOB_EXAMPLE, "state": "queued"}}},
    }
}
"""What is answered when a job has been taken on."""

QUALITY_EXAMPLE = {"quad4": {"scaled_jacobian": {"min": 0.62, "p5": 0.87, "mean": 0.98}}}

MESH_EXAMPLE = {
    "id": "9a3d2c4b6e8f7a105f1c0b7e", "model_id": "5f1c0b7e9a3d2c4b6e8f7a10",
    "created": "2026-11-22T22:47:01.000000+00:00",
    "model": "table.csg", "units": "mm", "volume": 24879645.9, "rule_base": "base 3f2a9c", "segments": [], "joints": [],
    "checks": {"volume_of_segments": 24879645.9, "mass_error": 0.0},
    "nodes": 425, "elements": {"quad4": 384, "line2": 40}, "couplings": {"rbe3": 4}, "components": 1,
    "quality": QUALITY_EXAMPLE, "mass": {"solid": 0.1953, "model": 0.1953, "error": 0.0}, "ledger": [], "warnings": [],
    "seconds": {"evaluate": 0.01, "segment": 0.02, "mesh": 0.1},
}  # fmt: skip


class MeshRequest(Schema):
    """How to mesh; everything has a default."""

    size: float | None = Field(default=None, description="target length of an element's edge; automatic without")
    sizes: dict[str, float] = Field(
        default_factory=dict, description="sizes of single segments, by segment id, node path or name"
    )
    curve_sizes: dict[str, float] = Field(
        default_factory=dict, description="longest element along the curves that a node, a pair A&B or a point names"
    )
    seeds: dict[str, int] = Field(default_factory=dict, description="exact number of elements on each of such curves")
    growth: float | None = Field(default=None, description="most that an element may be longer than its neighbour")
    per_circle: int | None = Field(default=None, description="fewest elements round a full circle")
    layers: int | None = Field(
        default=None, description="fewest elements through a brick and across the walls of its section"
    )
    order: Literal[1, 2] = 1
    faces: Literal["quad", "tri"] = "quad"
    volumes: Literal["auto", "hex", "tet"] = "auto"
    coupling: Literal["distributing", "rigid", "work"] = "distributing"
    tee: Literal["extend", "arms"] = Field(
        default="extend", description="walls that end in another: carried on to its mid-surface, or hung by rigid arms"
    )
    joints: dict[str, Literal["distributing", "rigid", "work", "extend", "arms", "apart"]] = Field(
        default_factory=dict,
        description="couplings or tees of single joints, by id; apart: no common nodes either",
    )
    apart: bool = Field(default=False, description="mesh every segment apart: nothing is shared or coupled")
    only: list[str] = Field(default_factory=list, description="mesh these nodes or segments alone, each apart")
    mass: Literal["plain", "exact"] = Field(default="plain", description="exact: densities scaled to the solid's mass")
    unchecked: bool = Field(default=False, description="keep the mesh even if it does not pass its own checks")
    material: str | None = Field(default=None, max_length=100)
    materials: dict[str, str] = Field(
        default_factory=dict, description="materials of single segments, by segment id, node path or name"
    )
    units: str | None = Field(default=None, max_length=10)
    rulebase: str | None = Field(default=None, max_length=200)
    gap: FiniteFloat = Field(default=0.0, ge=0, description="faces no further apart than this count as touching")


class JobResource(Schema):
    """A mesh being made. `state`: queued, running, done, failed or cancelled."""

    id: str
    model_id: str
    state: str
    stage: str
    progress: float
    created: str
    started: str | None
    finished: str | None
    mesh_id: str | None
    problem: Problem | None


class MeshResource(MeshAnswer):
    """What `csgmesh mesh --json` gives, under an id."""

    id: str
    model_id: str
    created: str
    parent: str | None = Field(default=None, description="the mesh that this one was edited from")
    edits: list[dict[str, Any]] = Field(default_factory=list, description="what was asked for then")
    history: list[str] = Field(default_factory=list, description="what all edits did since it was meshed, a line each")


@router.post(
    "/models/{model_id}/meshes",
    status_code=202,
    response_model=JobResource,
    responses={**QUEUED, **problem_responses(404, 422)},
)
def create_mesh(
    model_id: str,
    response: Response,
    context: Ctx,
    wanted: Annotated[MeshRequest, Body(examples=[{"size": 25, "order": 1, "coupling": "distributing"}])],
) -> JobResource:
    """Mesh a model as it stands, with its overrides, as a job."""
    model = context.model(model_id)
    units = unit_set(wanted.units or model.units)
    # checked here already, so that what is wrong is refused before it is queued
    couplings, tees = split_joints(wanted.joints)
    options = {**asked(wanted), "joint_tees": tees}
    about = {
        **context.text_payload(model),
        "material": wanted.material,
        "materials_of": wanted.materials,
        "units": units.name,
        "options": options,
        "only": wanted.only,
        "joints": sorted(couplings),
        "known": _known_ids(context, model, wanted),
    }
    context.ask("mesh_names", about)
    payload = {
        **context.model_payload(model, wanted.rulebase, wanted.units, wanted.gap),
        "options": options,
        "material": wanted.material,
        "materials_of": wanted.materials,
        "coupling": wanted.coupling,
        "joints": couplings,
        "mass": wanted.mass,
        "apart": wanted.apart,
        "only": wanted.only,
        "unchecked": wanted.unchecked,
    }
    job = context.jobs.submit(model.id, question_key("mesh", payload), payload)
    response.headers["Location"] = f"/v1/jobs/{job.id}"
    return job_resource(job)


def _known_ids(context: Context, model: ModelRow, wanted: MeshRequest) -> tuple[list[str], list[str]] | None:
    """Ids of segments and joints where somebody has asked for the model's segments as they stand, else None.

    A model is not classified for it: that takes as long as it takes, and the job does it anyway.
    """
    digests = context.remembered("classify", context.model_payload(model, wanted.rulebase, gap=wanted.gap))
    if digests is None:
        return None
    answer = json.loads(context.artifacts.get(digests["answer"]))
    return [segment["id"] for segment in answer["segments"]], [joint["id"] for joint in answer["joints"]]


@router.get(
    "/jobs/{job_id}",
    response_model=JobResource,
    responses=documented(JOB_EXAMPLE, 404),
)
def get_job(job_id: str, context: Ctx) -> JobResource:
    """How far a job is, and where its mesh is once it is done."""
    return job_resource(context.job(job_id))


@router.delete("/jobs/{job_id}", status_code=204, responses=problem_responses(404, 409))
def cancel_job(job_id: str, context: Ctx) -> None:
    """Cancel a job; the process that works on it is stopped at once."""
    job = context.job(job_id)
    if not context.jobs.cancel(job_id):
        raise HTTPException(409, f"job {job_id} has ended already: {context.job(job.id).state}")


@router.get(
    "/jobs/{job_id}/events",
    response_class=StreamingResponse,
    responses={
        200: {
            "description": "Server-sent events: `progress` at every change, then `done`, `failed` or `cancelled`",
            "content": {"text/event-stream": {"example": 'event: progress\ndata: {"state": "running"}\n\n'}},
        },
        **problem_responses(404),
    },
)
async def get_events(job_id: str, request: Request, context: Ctx) -> StreamingResponse:
    """The job, sent again whenever it changes, until it ends."""
    await run_in_threadpool(context.job, job_id)

    async def events() -> AsyncIterator[str]:
        sent, silent = "", 0.0
        while not await request.is_disconnected():
            job = await run_in_threadpool(context.store.job, job_id)
            if job is None:
                return
            data = job_resource(job).model_dump_json()
            if data != sent:
                name = job.state if job.state in FINISHED else "progress"
                yield f"event: {name}\ndata: {data}\n\n"
                sent, silent = data, 0.0
            if job.state in FINISHED:
                return
            await asyncio.sleep(POLL_EVERY)
            silent += POLL_EVERY
            if silent >= KEEP_ALIVE_EVERY:
                silent = 0.0
                yield ": still here\n\n"

    return StreamingResponse(events(), media_type="text/event-stream", headers={"Cache-Control": "no-store"})


@router.get(
    "/meshes/{mesh_id}",
    response_model=MeshResource,
    responses=documented(MESH_EXAMPLE, 404),
)
def get_mesh(mesh_id: str, context: Ctx) -> MeshResource:
    """Counts, checks, quality and mass of a mesh."""
    row = context.mesh(mesh_id)
    answer = json.loads(context.artifacts.get(row.answer))
    return MeshResource(id=row.id, model_id=row.model, created=row.created, **answer)


@router.get(
    "/meshes/{mesh_id}/quality",
    responses=documented(QUALITY_EXAMPLE, 404),
)
def get_quality(mesh_id: str, context: Ctx) -> dict[str, Any]:
    """Element quality by kind."""
    quality: dict[str, Any] = json.loads(context.artifacts.get(context.mesh(mesh_id).answer))["quality"]
    return quality


@router.get(
    "/meshes/{mesh_id}/deck",
    response_class=Response,
    responses={
        200: {"description": "The deck", "content": {"text/plain": {"example": "SOL 101\nCEND\nBEGIN BULK\n"}}},
        **problem_responses(404, 409, 422),
    },
)
def get_deck(
    mesh_id: str,
    context: Ctx,
    deck_format: Annotated[
        str, Query(alias="format", examples=["nastran"], description="name of a format")
    ] = "nastran",
) -> Response:
    """The mesh as a deck, in the format asked for."""
    row = context.mesh(mesh_id)
    chosen = format_for("", deck_format)
    name = context.model(row.model).name.rpartition(".")[0] or "model"
    digest = context.ask("deck", {"content": row.content, "format": chosen.name})
    safe = "".join(letter if letter.isascii() and (letter.isalnum() or letter in "-_.") else "_" for letter in name)
    headers = {"Content-Disposition": f'attachment; filename="{safe}{chosen.endings[0]}"'}
    return Response(context.artifacts.get(digest), media_type=chosen.media_type, headers=headers)


@router.get(
    "/meshes/{mesh_id}/mesh.glb",
    response_class=Response,
    responses=documented(None, 404, media_type="model/gltf-binary"),
)
def get_mesh_glb(
    mesh_id: str,
    context: Ctx,
    colour: Annotated[
        Literal["segment", "quality"], Query(examples=["quality"], description="what the colours tell apart")
    ] = "segment",
) -> Response:
    """The mesh as binary glTF: for each segment its faces (by name `s1`) and its element edges (`s1 edges`).

    By quality: for each segment and tenth of the scaled Jacobian (`s1 0.9`: 0.9 to 1), and their edges.
    """
    digest = context.ask("mesh_glb", {"content": context.mesh(mesh_id).content, "colour": colour})
    return Response(context.artifacts.get(digest), media_type="model/gltf-binary")


@router.get("/formats", responses=documented([{"name": "nastran", "title": "NASTRAN bulk data", "endings": [".bdf"]}]))
def list_formats() -> list[dict[str, Any]]:
    """The formats that a deck can have."""
    return [{"name": f.name, "title": f.title, "endings": list(f.endings)} for f in formats()]


def job_resource(job: JobRow) -> JobResource:
    """A job as JSON."""
    return JobResource(
        id=job.id,
        model_id=job.model,
        state=job.state,
        stage=job.stage,
        progress=round(job.progress, 4),
        created=job.created,
        started=job.started,
        finished=job.finished,
        mesh_id=job.mesh,
        problem=None if job.problem is None else problem(json.loads(job.problem)),
    )
