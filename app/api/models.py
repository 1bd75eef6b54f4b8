"""Models: a CSG text or tree that was sent, its tree and its solid."""

from __future__ import annotations

from typing import Annotated, Any

from fastapi import APIRouter, HTTPException, Query, Request, Response
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import UploadFile

from app.api.context import Context, Ctx
from app.api.problems import documented, problem_responses
from app.schemas import Schema
from app.tables import ModelRow
from kernel.errors import ReadError

router = APIRouter(prefix="/v1/models", tags=["models"])

PADL_EXAMPLE = """\
UNITS MM
TOP = BLO(X=1200, Y=800, Z=25) AT (MOVZ=700)
LEG = CYL(R=20, H=700) AT (MOVX=60, MOVY=60)
TABLE = TOP UN LEG
OUT TABLE
"""
"""The csgmesh language, as the documentation of the operation shows it."""

TREE_EXAMPLE = {
    "units": "mm",
    "root": {
        "kind": "difference",
        "operands": [{"kind": "block", "size": [100, 60, 5]}, {"kind": "cylinder", "radius": 8, "height": 5}],
    },
}

MODEL_EXAMPLE = {
    "id": "5f1c0b7e9a3d2c4b6e8f7a10",
    "name": "table.csg",
    "language": "padl",
    "units": "mm",
    "created": "2026-11-22T22:47:00.000000+00:00",
}


class ModelResource(Schema):
    """A model that the service keeps."""

    id: str
    name: str
    language: str
    units: str
    created: str


MODEL_BODY = {
    "requestBody": {
        "required": True,
        "content": {
            "text/plain": {"schema": {"type": "string"}, "example": PADL_EXAMPLE},
            "application/json": {"schema": {"type": "object"}, "example": TREE_EXAMPLE},
            "multipart/form-data": {
                "schema": {
                    "type": "object",
                    "required": ["file"],
                    "properties": {"file": {"type": "string", "format": "binary"}},
                },
                "example": {"file": PADL_EXAMPLE},
            },
        },
    }
}


@router.post(
    "",
    status_code=201,
    response_model=ModelResource,
    openapi_extra=MODEL_BODY,
    responses={
        201: {
            "description": "Read and kept",
            "headers": {"Location": {"schema": {"type": "string"}, "description": "the model"}},
            "content": {"application/json": {"example": MODEL_EXAMPLE}},
        },
        **problem_responses(413, 422),
    },
)
async def create_model(
    request: Request,
    response: Response,
    context: Ctx,
    name: Annotated[
        str | None,
        Query(
            max_length=200,
            examples=["table.csg"],
            description="name of the model; else the uploaded file's own, else model.csg or model.json",
        ),
    ] = None,
) -> ModelResource:
    """Read a model and keep it: a tree as JSON, a .csg text (text/plain), or a file (multipart, field `file`)."""
    text, ending, given_name = await _body(request)
    name = _clean(name or given_name or f"model.{ending}")
    row = await run_in_threadpool(_keep, context, text, ending, name)
    response.headers["Location"] = f"/v1/models/{row.id}"
    return model_resource(row)


@router.get("", response_model=list[ModelResource], responses=documented([MODEL_EXAMPLE]))
def list_models(context: Ctx) -> list[ModelResource]:
    """All models, oldest first."""
    return [model_resource(row) for row in context.store.models()]


@router.get("/{model_id}", response_model=ModelResource, responses=documented(MODEL_EXAMPLE, 404))
def get_model(model_id: str, context: Ctx) -> ModelResource:
    """One model."""
    return model_resource(context.model(model_id))


@router.delete("/{model_id}", status_code=204, responses=problem_responses(404))
def delete_model(model_id: str, context: Ctx) -> None:
    """Forget a model with its overrides, jobs and meshes; what is running for it is stopped."""
    context.model(model_id)
    for job_id in context.store.unfinished_jobs(model_id):
        context.jobs.cancel(job_id)
    context.store.delete_model(model_id)


@router.get("/{model_id}/tree", responses=documented(TREE_EXAMPLE, 404, 422))
def get_tree(model_id: str, context: Ctx) -> dict[str, Any]:
    """The CSG tree."""
    tree: dict[str, Any] = context.ask("tree", context.text_payload(context.model(model_id)))
    return tree


@router.get(
    "/{model_id}/text", response_class=Response, responses=documented(PADL_EXAMPLE, 404, media_type="text/plain")
)
def get_text(model_id: str, context: Ctx) -> Response:
    """The text as it was sent."""
    return Response(context.artifacts.get(context.model(model_id).text), media_type="text/plain; charset=utf-8")


@router.get(
    "/{model_id}/solid.glb",
    response_class=Response,
    responses=documented(None, 404, 422, media_type="model/gltf-binary"),
)
def get_solid(model_id: str, context: Ctx) -> Response:
    """The evaluated solid, as binary glTF."""
    digest = context.ask("solid", context.text_payload(context.model(model_id)))
    return Response(context.artifacts.get(digest), media_type="model/gltf-binary")


def model_resource(row: ModelRow) -> ModelResource:
    """A model as JSON."""
    return ModelResource(id=row.id, name=row.name, language=row.language, units=row.units, created=row.created)


def _keep(context: Context, content: bytes, ending: str, name: str) -> ModelRow:
    try:
        text = content.decode()
    except UnicodeDecodeError as error:
        raise ReadError(f"{name}: not UTF-8 text, byte {error.start} is 0x{content[error.start]:02x}") from error
    read = context.jobs.call("read", {"text": text, "name": name})
    return context.store.add_model(
        name=name, ending=ending, text=context.artifacts.put(content), language=read["language"], units=read["units"]
    )


async def _body(request: Request) -> tuple[bytes, str, str | None]:
    """The text sent, the ending that a file of it has, and the file's own name if one was sent."""
    kind = request.headers.get("content-type", "text/plain").partition(";")[0].strip().lower()
    if kind == "multipart/form-data":
        async with request.form(max_files=1, max_fields=8) as form:
            file = form.get("file")
            if not isinstance(file, UploadFile):
                raise HTTPException(400, "no file in the form's field `file`")
            name = file.filename or "model.csg"
            return await file.read(), "json" if name.lower().endswith(".json") else "csg", name
    if kind == "application/json" or kind.endswith("+json"):
        return await request.body(), "json", None
    if kind in ("text/plain", "application/octet-stream"):
        return await request.body(), "csg", None
    raise HTTPException(415, f"content type {kind!r}, expected text/plain, application/json or multipart/form-data")


def _clean(name: str) -> str:
    """The last part of a path, without control characters: a name to show, never a path to open."""
    last = name.replace("\\", "/").rpartition("/")[2]
    return "".join(letter for letter in last if letter.isprintable())[:200] or "model.csg"
