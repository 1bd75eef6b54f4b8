"""The application: its parts put together, its life, and the socket that it listens at."""

from __future__ import annotations

import errno
import ipaddress
import socket
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from fastapi import FastAPI, HTTPException
from starlette.responses import FileResponse, RedirectResponse
from starlette.staticfiles import StaticFiles

from app.api import access, edits, meshing, metrics, models, problems, rulebases, segments
from app.api.context import Context, Ctx
from app.schemas import Problem
from app.settings import Settings
from kernel.errors import OptionError

WEB = Path(__file__).parent.parent / "web"


def create_app(settings: Settings) -> FastAPI:
    """The service over `settings`; its workers start and stop with it. OptionError: the database cannot be had."""
    context = Context(settings)

    @asynccontextmanager
    async def life(_application: FastAPI) -> AsyncIterator[None]:
        context.jobs.start()
        try:
            yield
        finally:
            context.jobs.stop()
            context.store.close()

    application = FastAPI(
        title="csgmesh",
        version=version("csgmesh"),
        description="CSG solids to connected finite element models of beams, plates, cylinder-plates and bricks.",
        lifespan=life,
        docs_url=None,  # FastAPI's own pages load their scripts from another server; ours is in _add_service
        redoc_url=None,
    )
    application.state.context = context
    problems.install(application)
    for part in (models, segments, meshing, edits, rulebases):
        application.include_router(part.router)
    _add_service(application)
    access.install(application, context)
    metrics.install(application, context)
    _document_problems(application)
    return application


def run_server(settings: Settings) -> None:
    """Listen until stopped; OptionError where the address cannot be had."""
    import structlog
    import uvicorn

    from app.logs import configure_logs

    configure_logs()
    application = create_app(settings)
    listener = _listen(settings.host, settings.port)
    host, port = listener.getsockname()[:2]
    log = structlog.get_logger()
    if (
        not ipaddress.ip_address(host.partition("%")[0]).is_loopback
        and not application.state.context.store.has_tokens()
    ):
        log.warning("whoever reaches this address may do everything; `csgmesh token create NAME` closes it", host=host)
    log.info("listening", url=f"http://{host}:{port}/", data=str(settings.data))
    config = uvicorn.Config(application, log_level="warning", access_log=False, timeout_graceful_shutdown=3)
    uvicorn.Server(config).run(sockets=[listener])


def _listen(host: str, port: int) -> socket.socket:
    if not 0 <= port <= 65535:
        raise OptionError(f"cannot listen at port {port}, expected 0 to 65535")
    try:
        family = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0][0]
        return socket.create_server((host, port), family=family, backlog=128)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise OptionError(f"port {port} is in use, choose another with --port") from error
        raise OptionError(f"cannot listen at {host}:{port}: {error}") from error


def _add_service(application: FastAPI) -> None:
    ok = {200: {"content": {"application/json": {"example": {"status": "ok"}}}}}

    @application.get("/healthz", tags=["service"], responses=ok)  # type: ignore[arg-type]
    def healthz() -> dict[str, str]:
        """The process lives."""
        return {"status": "ok"}

    @application.get("/readyz", tags=["service"], responses=ok)  # type: ignore[arg-type]
    def readyz(context: Ctx) -> dict[str, str]:
        """The database answers and the data folder can be written."""
        from app.output import check_writable

        try:
            check_writable(str(context.settings.data / "probe"))
        except OptionError as error:
            raise HTTPException(503, str(error)) from error
        if not context.store.is_ready():
            raise HTTPException(503, "the database does not answer")
        return {"status": "ok"}

    @application.api_route("/", methods=["GET", "HEAD"], include_in_schema=False)
    def page() -> FileResponse:
        return FileResponse(WEB / "index.html", headers={"Cache-Control": "no-cache"})

    @application.api_route("/docs", methods=["GET", "HEAD"], include_in_schema=False)
    def operations() -> FileResponse:
        return FileResponse(WEB / "docs.html", headers={"Cache-Control": "no-cache"})

    @application.get("/favicon.ico", include_in_schema=False)
    def icon() -> RedirectResponse:
        return RedirectResponse("/web/icon.svg")

    application.mount("/web", StaticFiles(directory=WEB), name="web")


def _document_problems(application: FastAPI) -> None:
    """Put Problem's schema where the operations' responses refer to it, and in place of FastAPI's own 422."""
    own = application.openapi

    def openapi() -> dict[str, Any]:
        document = own()
        schemas = document.setdefault("components", {}).setdefault("schemas", {})
        if "HTTPValidationError" not in schemas:
            return document
        schema = Problem.model_json_schema(ref_template="#/components/schemas/{model}")
        schemas.update({**schema.pop("$defs", {}), "Problem": schema})
        for name in ("HTTPValidationError", "ValidationError"):
            schemas.pop(name, None)
        document["components"]["securitySchemes"] = {"token": {"type": "http", "scheme": "bearer"}}
        for path, operations in document["paths"].items():
            for operation in operations.values():
                if access.is_guarded(path):
                    operation["security"] = [{}, {"token": []}]  # none is needed while the service has no tokens
                    operation["responses"].setdefault("401", problems.problem_responses(401)[401])
                if "422" in operation["responses"]:
                    operation["responses"]["422"] = problems.problem_responses(422)[422]
        return document

    application.openapi = openapi  # type: ignore[method-assign]
