"""A folder of finished tetrahedral meshes by the hash of their input, so that the same input gives the same bytes.

The mesher itself is not repeatable, not even with one thread. CSGMESH_CACHE names the folder; without it, the user's
cache folder of the platform is taken. A folder that cannot be written to only costs the repeatability.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import sys
import tempfile
import time
import zipfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Tets = tuple[NDArray[np.float64], NDArray[np.int64]]

MAX_BYTES = 1_000_000_000
"""The entries not used for longest go when the folder grows beyond this."""

PART = ".part"
"""Ending of what is not yet a whole entry."""

STALE = 86_400.0
"""Seconds after which the part of an entry is one that a killed process left."""


def cache_folder() -> Path:
    """Where finished meshes are kept; may not exist yet."""
    named = os.environ.get("CSGMESH_CACHE")
    if named:
        return Path(named) / "tets"
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA") or Path.home() / "AppData" / "Local")
    elif sys.platform == "darwin":
        base = Path.home() / "Library" / "Caches"
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    return base / "csgmesh" / "tets"


def key_of(vertices: NDArray[np.float64], triangles: NDArray[np.int64], *settings: object) -> str:
    """Hash of the exact input and settings."""
    digest = hashlib.sha256(repr(settings).encode())
    for array in (vertices, triangles):
        digest.update(repr((array.shape, array.dtype.str)).encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def load(key: str) -> Tets | None:
    """The mesh kept under `key`, or None where there is none that can be read."""
    path = cache_folder() / f"{key}.npz"
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as kept:
            tets = kept["nodes"].astype(np.float64), kept["tets"].astype(np.int64)
    except (OSError, KeyError, ValueError, zipfile.BadZipFile):
        return None
    with contextlib.suppress(OSError):
        os.utime(path)  # entries go by last use
    return tets


def keep(key: str, tets: Tets) -> Tets:
    """Keep a mesh under `key`, whole or not at all; gives what is kept there.

    Of two processes that mesh the same body at once the first one's mesh stays, and both get it.
    """
    folder = cache_folder()
    kept = tets
    with contextlib.suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        handle, name = tempfile.mkstemp(dir=folder, suffix=PART)
        entry = folder / f"{key}.npz"
        try:
            with os.fdopen(handle, "wb") as part:
                np.savez(part, nodes=tets[0], tets=tets[1])
            try:
                os.link(name, entry)  # unlike a rename, it fails where there is an entry
            except FileExistsError:
                first = load(key)
                if first is None:  # damaged on disk
                    os.replace(name, entry)
                else:
                    kept = first
            except OSError:  # a file system without links
                os.replace(name, entry)
        finally:
            Path(name).unlink(missing_ok=True)
        _prune(folder)
    return kept


def _prune(folder: Path) -> None:
    for part in folder.glob(f"*{PART}"):
        with contextlib.suppress(FileNotFoundError):
            if time.time() - part.stat().st_mtime > STALE:
                part.unlink(missing_ok=True)
    entries = sorted(
        ((entry.stat().st_mtime, entry.stat().st_size, entry) for entry in folder.glob("*.npz")),
        key=lambda row: row[:2],
    )
    total = sum(size for _, size, _ in entries)
    for _, size, entry in entries:
        if total <= MAX_BYTES:
            return
        entry.unlink(missing_ok=True)
        total -= size
