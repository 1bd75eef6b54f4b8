"""Who may ask: tokens as `Authorization: Bearer ...`, or in a cookie that the page gets for one.

The page, its files, /docs, /openapi.json, /healthz and /readyz hold no data and are open; all else asks for a token as
soon as the store has one.
"""

from __future__ import annotations

from http.cookies import CookieError, SimpleCookie
from typing import Annotated

from fastapi import APIRouter, Body, FastAPI, HTTPException, Request, Response
from pydantic import Field
from starlette.concurrency import run_in_threadpool
from starlette.types import ASGIApp, Receive, Scope, Send

from app.api.context import Context, Ctx
from app.api.problems import plain_problem, problem_responses, respond
from app.schemas import Schema
from app.tokens import admitted

COOKIE = "csgmesh_token"

GUARDED = ("/v1", "/metrics")
"""Paths that need a token, with all below them."""

SESSION = "/v1/session"
"""Where the page gives its token; open."""

SAID = (
    "this service needs a token (`csgmesh token create NAME`), expected one that holds as `Authorization: Bearer ...`"
)

router = APIRouter(prefix="/v1", tags=["service"])


class SessionRequest(Schema):
    """What the page sends once."""

    token: str = Field(max_length=200)


@router.post("/session", status_code=204, responses=problem_responses(401, 422))
def open_session(
    request: Request,
    response: Response,
    context: Ctx,
    wanted: Annotated[SessionRequest, Body(examples=[{"token": "csgmesh_..."}])],
) -> None:
    """Give a token once, and have it kept as a cookie that scripts cannot read."""
    if admitted(context.store, wanted.token) is None:
        raise HTTPException(401, SAID)
    is_secure = request.url.scheme == "https"
    response.set_cookie(COOKIE, wanted.token, httponly=True, samesite="strict", secure=is_secure, path="/")


@router.delete("/session", status_code=204)
def close_session(response: Response) -> None:
    """Forget the cookie."""
    response.delete_cookie(COOKIE, path="/")


class Access:
    """Refuses requests without a token that holds, once there is one."""

    def __init__(self, app: ASGIApp, context: Context) -> None:
        self._app = app
        self._context = context

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] == "http" and is_guarded(scope["path"]):
            if not await run_in_threadpool(self._is_admitted, scope):
                refusal = respond(plain_problem(401, SAID), {"WWW-Authenticate": "Bearer"})
                await refusal(scope, receive, send)
                return
        await self._app(scope, receive, send)

    def _is_admitted(self, scope: Scope) -> bool:
        store = self._context.store
        return any(admitted(store, secret) is not None for secret in _secrets(scope)) or not store.has_tokens()


def install(application: FastAPI, context: Context) -> None:
    """Guard `application`."""
    application.include_router(router)
    application.add_middleware(Access, context=context)


def is_guarded(path: str) -> bool:
    """Whether requests to a path need a token, once there is one."""
    return path != SESSION and any(path == start or path.startswith(f"{start}/") for start in GUARDED)


def _secrets(scope: Scope) -> list[str]:
    """The tokens that a request brings: of its header, then of its cookie."""
    found = []
    for name, value in scope["headers"]:
        text = value.decode("latin-1")
        if name == b"authorization" and text[:7].lower() == "bearer ":
            found.append(text[7:].strip())
    for name, value in scope["headers"]:
        if name == b"cookie":
            try:
                cookie = SimpleCookie(value.decode("latin-1")).get(COOKIE)
            except CookieError:
                continue
            if cookie is not None:
                found.append(cookie.value)
    return found
