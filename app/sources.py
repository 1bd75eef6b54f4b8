"""What a result depends on besides its input: the sources that compute it."""

from __future__ import annotations

import functools
import hashlib
from pathlib import Path

PACKAGES = ("kernel", "rules")
MODULES = ("pipeline", "work", "answers", "schemas")
"""Modules of app that results, and the form in which they are kept, come from."""

ENDINGS = (".py", ".yaml")


@functools.cache
def sources_hash() -> str:
    """SHA-256 of the sources at the first call (30 ms), for keys of what outlives the process."""
    return hash_of(Path(__file__).resolve().parent.parent)


def hash_of(root: Path) -> str:
    """SHA-256 of the names, sizes and contents of the sources in `root`, the folder that holds the packages."""
    paths = [path for package in PACKAGES for path in (root / package).rglob("*") if path.suffix in ENDINGS]
    paths += [root / "app" / f"{module}.py" for module in MODULES]
    total = hashlib.sha256()
    for name, path in sorted((path.relative_to(root).as_posix(), path) for path in paths):
        content = path.read_bytes()
        total.update(f"{name}\0{len(content)}\0".encode())
        total.update(content)
    return total.hexdigest()
