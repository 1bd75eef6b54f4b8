"""Large results as files named by the hash of their content: written once, never changed."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from app.output import write_files
from kernel.errors import DefectError


class Artifacts:
    """A folder of content-addressed files, fanned out by the first two digits of the hash."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def put(self, content: bytes) -> str:
        """Keep `content`; gives its SHA-256, by which it is found again."""
        digest = hashlib.sha256(content).hexdigest()
        path = self._path(digest)
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            write_files({str(path): content})
        return digest

    def get(self, digest: str) -> bytes:
        """The content; DefectError where the file has gone."""
        try:
            return self._path(digest).read_bytes()
        except OSError as error:
            raise DefectError(f"artifact {digest} is missing from the data folder") from error

    def _path(self, digest: str) -> Path:
        if not re.fullmatch(r"[0-9a-f]{64}", digest):
            raise DefectError(f"{digest!r} is no artifact's hash")
        return self.folder / digest[:2] / digest
