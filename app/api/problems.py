"""Errors as RFC 9457 problem details, with the message that the command line gives; and the bound on bodies."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from fastapi import FastAPI, Request
from fastapi.exceptions import RequestValidationError
from starlette.exceptions import HTTPException
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from app.failure import failure, problem
from app.jobs import Busy
from app.schemas import Problem
from app.settings import MAX_MODEL_BYTES, MAX_REQUEST_BYTES
from kernel.errors import CsgmeshError
from kernel.words import did_you_mean

MEDIA_TYPE = "application/problem+json"
MULTIPART_SLACK = 10_000
"""Bytes that a multipart body may have around its file."""

RETRY_AFTER = "5"
"""Seconds after which a request that found the service busy may come again."""

ROUTING = {
    "Not Found": "there is no such path, expected one of those that /docs lists",
    "Method Not Allowed": "this path knows no such method, expected one of those that /docs lists",
}
"""What the router says, and what we say."""

RESPONSES = {
    400: "The request is malformed",
    401: "The request needs a token that holds",
    404: "There is no such thing",
    409: "The input is fine, but this cannot be done; the segment and the reason are named",
    413: "The body is too long",
    422: "The input is wrong",
    500: "A defect of csgmesh",
    503: "The service cannot do this now",
}


def problem_responses(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """For `responses=` of an operation: problem details with an example for each of `statuses`."""
    return {status: _documented(status) for status in statuses}


def documented(example: Any, *statuses: int, media_type: str = "application/json") -> dict[int | str, dict[str, Any]]:
    """For `responses=` of an operation: its answer with an example, and its problems."""
    content = {} if example is None else {"example": example}
    return {200: {"content": {media_type: content}}, **problem_responses(*statuses)}


def _documented(status: int) -> dict[str, Any]:
    example = plain_problem(status, RESPONSES[status]).model_dump(exclude_none=True)
    if status == 422:
        example = problem(
            {
                "class": "ReadError",
                "exit_status": 2,
                "message": "bracket.csg:3:5: unknown primitive 'cub', expected one of cube, sphere, cylinder",
                "place": {"file": "bracket.csg", "line": 3, "column": 5},
            }
        ).model_dump(exclude_none=True)
    return {
        "description": RESPONSES[status],
        "content": {MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}, "example": example}},
    }


def install(application: FastAPI) -> None:
    """Make every error of `application` a problem."""

    def known(_request: Request, error: Exception) -> JSONResponse:
        return respond(problem(failure(error)))

    def refused(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, HTTPException)
        detail = str(error.detail)
        if detail in ROUTING:  # the router's own words, which say neither what nor where
            detail = f"{request.method} {request.url.path}: {ROUTING[detail]}"
        return respond(plain_problem(error.status_code, detail), error.headers)

    def invalid(request: Request, error: Exception) -> JSONResponse:
        assert isinstance(error, RequestValidationError)
        message = invalid_message(error.errors()[0], request)
        return respond(problem({"class": "OptionError", "exit_status": 2, "message": message}))

    def busy(_request: Request, error: Exception) -> JSONResponse:
        return respond(plain_problem(503, str(error)), {"Retry-After": RETRY_AFTER})

    application.add_exception_handler(CsgmeshError, known)
    application.add_exception_handler(Busy, busy)
    application.add_exception_handler(HTTPException, refused)
    application.add_exception_handler(RequestValidationError, invalid)
    application.add_exception_handler(Exception, known)
    application.add_middleware(BodyLimit)


def invalid_message(wrong: Mapping[str, Any], request: Request) -> str:
    """What is wrong with a body or a query, by the validator's first finding, and what was expected."""
    location = [str(part) for part in wrong["loc"]]
    field = ".".join(location[1:])
    known = _fields(request)
    if wrong["type"] == "json_invalid":
        reason = wrong.get("ctx", {}).get("error", wrong["msg"])
        return f"the body is no JSON: {reason}, expected an object with {known or 'fields'}"
    if location == ["body"]:
        return f"the body is {_said(wrong['input'])}, expected an object with the fields {known}"
    if wrong["type"] == "extra_forbidden" and len(location) > 2:
        return f"unknown field {field!r}"
    if wrong["type"] == "extra_forbidden":
        near = did_you_mean(location[-1], known.split(", "))
        return f"unknown field {field!r}, expected one of {known}{near}"
    if wrong["type"] in ("union_tag_invalid", "union_tag_not_found"):  # a list of things of several kinds
        tag, tags = wrong["ctx"]["discriminator"].strip("'"), wrong["ctx"].get("expected_tags", "")
        given = wrong["input"].get(tag) if isinstance(wrong["input"], dict) else wrong["input"]
        return f"{field}.{tag} is {_said(given)}, expected {f'one of {tags}' if tags else 'one'}"
    if wrong["type"] == "missing":
        return f"{field} is missing, expected the fields {known}" if known else f"{field} is missing"
    expected = wrong["msg"].replace("Input should be", "").strip()
    return f"{field} is {_said(wrong['input'])}, expected {expected[:1].lower()}{expected[1:]}"


def _fields(request: Request) -> str:
    """Names of the fields that the body of the request's operation has."""
    route = request.scope.get("route")
    body = getattr(route, "body_field", None)
    schema = None if body is None else body.field_info.annotation
    return ", ".join(getattr(schema, "model_fields", {}))


def _said(value: Any) -> str:
    """A value as JSON, not too long."""
    text = json.dumps(value, default=str) if value is not None else "empty"
    return text if len(text) <= 60 else f"{text[:57]}..."


def respond(details: Problem, headers: Any = None) -> JSONResponse:
    """Problem details as a response."""
    content = details.model_dump(exclude_none=True)
    return JSONResponse(content, details.status, headers=headers, media_type=MEDIA_TYPE)


def plain_problem(status: int, detail: str) -> Problem:
    """Problem details of no class of ours."""
    return Problem(
        type="about:blank", title=RESPONSES.get(status, "The request is refused"), status=status, detail=detail
    )


class _TooLong(Exception):
    """The body has grown past its bound."""


class BodyLimit:
    """Refuses bodies that are too long, by their announced length or as they come in."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """One request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        takes_models = scope["path"].rstrip("/") == "/v1/models"
        bound = MAX_MODEL_BYTES + MULTIPART_SLACK if takes_models else MAX_REQUEST_BYTES
        announced = dict(scope["headers"]).get(b"content-length", b"0")
        if announced.isdigit() and int(announced) > bound:
            await respond(_too_long(bound))(scope, receive, send)
            return
        length, is_answered = 0, False

        async def bounded_receive() -> Message:
            nonlocal length
            message = await receive()
            length += len(message.get("body", b""))
            if length > bound:
                raise _TooLong
            return message

        async def watched_send(message: Message) -> None:
            nonlocal is_answered
            is_answered = True
            await send(message)

        try:
            await self.app(scope, bounded_receive, watched_send)
        except _TooLong:
            if not is_answered:
                await respond(_too_long(bound))(scope, receive, send)


def _too_long(bound: int) -> Problem:
    return plain_problem(413, f"the body is longer than {bound} bytes")
