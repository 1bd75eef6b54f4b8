"""Logs: structured lines on standard error, one a happening; never on standard output."""

from __future__ import annotations

import contextlib
import os
import sys
import tempfile
import traceback
from pathlib import Path


def configure_logs(as_json: bool = False) -> None:
    """Send structlog's lines to standard error, from the level in CSGMESH_LOG (default "info")."""
    import logging

    import structlog

    level = logging.getLevelNamesMapping().get(os.environ.get("CSGMESH_LOG", "info").upper(), logging.INFO)
    last = structlog.processors.JSONRenderer() if as_json else structlog.dev.ConsoleRenderer(colors=sys.stderr.isatty())
    structlog.configure(
        processors=[
            structlog.contextvars.merge_contextvars,
            structlog.processors.add_log_level,
            structlog.processors.TimeStamper(fmt="iso", utc=True),
            structlog.processors.format_exc_info,
            last,
        ],
        wrapper_class=structlog.make_filtering_bound_logger(level),
        logger_factory=_StandardError,
        cache_logger_on_first_use=False,
    )


class _StandardError:
    """Writes lines to standard error as it is now; nobody listening there must not stop the work."""

    def __init__(self, *_: object) -> None:
        pass

    def msg(self, message: str) -> None:
        """One line."""
        with contextlib.suppress(OSError, ValueError):
            sys.stderr.write(message + "\n")
            sys.stderr.flush()

    log = debug = info = warn = warning = error = critical = exception = fatal = msg


def record_defect(error: BaseException) -> str:
    """Write the traceback of a defect to a file of its own; gives that file's path, "" where none can be written."""
    try:
        folder = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state") / "csgmesh"
        folder.mkdir(parents=True, exist_ok=True)
        handle, path = tempfile.mkstemp(prefix="defect-", suffix=".log", dir=folder)
        with os.fdopen(handle, "w", encoding="utf-8") as stream:
            stream.writelines(traceback.format_exception(error))
    except OSError:
        return ""
    return path
