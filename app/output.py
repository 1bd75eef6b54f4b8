"""Output files: all of it or nothing, never half-written."""

from __future__ import annotations

import os
import secrets
import stat
import tempfile
from collections.abc import Mapping
from pathlib import Path

from kernel.errors import OptionError

EXPECTED = "a path in a folder that files can be written to"

NEW = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_CLOEXEC", 0) | getattr(os, "O_BINARY", 0)

NEW_MODE = 0o666
"""Of a new file, less what the process's umask takes: asking for the umask would set it for all threads."""

OWN_MODE = 0o600
"""Of a file that is to replace another, until it gets that one's."""


def check_writable(path: str) -> None:
    """OptionError where a file at `path` could not be written; asked before the work starts."""
    target = Path(os.path.realpath(path))
    if target.is_dir():
        raise OptionError(f"{path}: is a folder, expected a file to write")
    folder = target.parent
    if not folder.is_dir():
        raise OptionError(f"{path}: there is no folder {folder}, expected {EXPECTED}")
    if target.exists() and not os.access(target, os.W_OK):
        raise OptionError(f"{path}: cannot be written, permission denied, expected {EXPECTED}")
    if not _is_special(target):
        try:
            tempfile.TemporaryFile(dir=folder).close()  # some folders say that they can be written to, and cannot
        except OSError as error:
            reason = (error.strerror or str(error)).lower()
            raise OptionError(f"{path}: cannot be written, {reason}, expected {EXPECTED}") from error


def write_files(contents: Mapping[str, bytes]) -> None:
    """Write every file of `contents` (path -> bytes): beside its place first, then all moved there.

    A link is followed; a device or pipe (/dev/stdout) is written to directly. OptionError where writing fails.
    """
    waiting: list[tuple[str, Path]] = []
    path = ""
    try:
        for path, content in contents.items():
            target = Path(os.path.realpath(path))
            if _is_special(target):
                target.write_bytes(content)
                continue
            mode = stat.S_IMODE(target.stat().st_mode) if target.exists() else None
            temporary = str(target.parent / f".{target.name[:40]}.{secrets.token_hex(8)}.part")
            handle = os.open(temporary, NEW, NEW_MODE if mode is None else OWN_MODE)
            waiting.append((temporary, target))
            with os.fdopen(handle, "wb") as stream:
                stream.write(content)
                stream.flush()
                os.fsync(stream.fileno())
            if mode is not None:
                os.chmod(temporary, mode)
        while waiting:
            temporary, target = waiting[0]
            path = str(target)
            os.replace(temporary, target)
            waiting.pop(0)
    except BrokenPipeError:
        raise
    except OSError as error:
        raise OptionError(f"{path}: cannot be written, {error.strerror or error}, expected {EXPECTED}") from error
    finally:
        for temporary, _ in waiting:
            Path(temporary).unlink(missing_ok=True)


def _is_special(target: Path) -> bool:
    return target.exists() and not stat.S_ISREG(target.stat().st_mode)
