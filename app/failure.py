"""Errors as plain data: from a worker to the job table, and from there to problem details."""

from __future__ import annotations

from typing import Any

from app.schemas import ErrorPlace, Problem
from kernel.errors import CsgmeshError

STATUS_OF_EXIT = {2: 422, 3: 409, 1: 500}
"""HTTP status by exit status, as kernel/errors.py draws them."""

TITLES = {
    "ReadError": "The model cannot be read",
    "GeometryError": "The model describes no usable solid",
    "OverrideError": "The override cannot be",
    "AmbiguousNameError": "The name is of several nodes",
    "RuleError": "The rule base is wrong",
    "OptionError": "An option is wrong",
    "MeshError": "A segment cannot be meshed",
    "ConnectError": "A joint cannot be connected",
    "CheckError": "The model does not pass its checks",
    "DeckError": "The format cannot carry the model",
    "DefectError": "A defect of csgmesh",
    "WorkerDied": "The process that did the work died",
}


def failure(error: BaseException) -> dict[str, Any]:
    """What is kept of an error: {"class", "exit_status", "message", "place"}; message as on the command line."""
    if not isinstance(error, CsgmeshError):
        message = f"defect: {type(error).__name__}: {' '.join(str(error).split())}"
        return {"class": "DefectError", "exit_status": 1, "message": message, "place": None}
    place = error.place
    return {
        "class": type(error).__name__,
        "exit_status": error.exit_status,
        "message": f"defect: {error}" if error.exit_status == 1 else str(error),
        "place": None if place is None else {"file": place.file, "line": place.line, "column": place.column},
    }


def problem(failed: dict[str, Any]) -> Problem:
    """RFC 9457 problem details of a kept error."""
    place = failed.get("place")
    return Problem(
        type=f"urn:csgmesh:problem:{failed['class']}",
        title=TITLES.get(failed["class"], "The input is wrong"),
        status=STATUS_OF_EXIT[failed["exit_status"]],
        detail=failed["message"],
        place=None if place is None else ErrorPlace(**place),
    )
