"""The readers' one door: text of any of the three languages to a CsgModel."""

from __future__ import annotations

import re
import sys
from pathlib import Path

from kernel.csg.source import MAX_INPUT_BYTES
from kernel.csg.tree import CsgModel
from kernel.errors import ReadError

_PADL_COMMENT = re.compile(r"![^\n]*")
_OPENSCAD_BLANK = re.compile(r'//[^\n]*|/\*.*?(?:\*/|\Z)|"(?:\\.|[^"\\])*+(?:"|\\?\Z)', re.DOTALL)
_PADL_START = re.compile(r"\s*+(?:[A-Za-z_]\w*+\s*+=(?!=)|(?:units|material|out)\b)", re.IGNORECASE)
_ASSIGNMENT = re.compile(r"\s*+\$?[A-Za-z_]\w*+\s*+=[^\n;]*+;")
_OPENSCAD_START = re.compile(r"[\s%#*!]*+\$?[A-Za-z_]\w*+\s*+\(")


def read_file(path: str) -> CsgModel:
    """The model in the file at `path`; "-" is standard input. Errors as read_model's, or the file cannot be read."""
    return read_model(read_text(path), path)


def read_text(path: str) -> str:
    """The text in the file at `path`; "-" is standard input. ReadError: there is none, too much, or no text."""
    try:
        if path == "-":
            data = sys.stdin.buffer.read(MAX_INPUT_BYTES)
        else:
            with Path(path).open("rb") as file:
                data = file.read(MAX_INPUT_BYTES)
    except OSError as error:
        raise ReadError(f"{path}: cannot be read ({error.strerror}), expected a file with a CSG model") from None
    if len(data) >= MAX_INPUT_BYTES:
        raise ReadError(f"{path}: the file is too large, expected less than {MAX_INPUT_BYTES // 1_000_000} MB")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise ReadError(f"{path}: byte {error.start} is not UTF-8, expected a text file") from None


def read_model(text: str, source: str) -> CsgModel:
    """The model that `text` describes; source: the file's name, for places in errors ("-" for standard input).

    ReadError: what is wrong, where (line and column), and what was expected.
    """
    if len(text) >= MAX_INPUT_BYTES:
        raise ReadError(f"{source}: the text is too large, expected less than {MAX_INPUT_BYTES // 1_000_000} MB")
    if not text.strip():
        raise ReadError(f"{source}: the file is empty, expected a CSG model")
    language = language_of(text)
    if language == "json":
        from kernel.csg.treejson import read_json

        return read_json(text, source)
    if language == "openscad":
        from kernel.csg.openscad import read_openscad

        return read_openscad(text, source)
    from kernel.csg.padl import read_padl

    return read_padl(text, source)


def language_of(text: str) -> str:
    """`json`, `openscad` or `padl`, told by the content alone.

    JSON begins with a brace or bracket. A PADL-2-like file begins, after `!` comments, with `NAME =` or a keyword and
    has no braces or semicolons; an OpenSCAD one has them, or begins with `name(`.
    """
    if text.lstrip()[:1] in "{[":
        return "json"
    padl = _PADL_COMMENT.sub("", text)
    if _PADL_START.match(padl) and not _ASSIGNMENT.match(padl):
        return "padl"
    openscad = _OPENSCAD_BLANK.sub("", text)
    if _OPENSCAD_START.match(openscad) and (padl.strip() == "" or _OPENSCAD_START.match(padl)):
        return "openscad"
    return "openscad" if re.search(r"[{};]", _OPENSCAD_BLANK.sub("", padl)) else "padl"
