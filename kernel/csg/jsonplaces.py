"""Where the values of a JSON text stand: line and column for a JSON pointer (RFC 6901)."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator

_TOKENS = re.compile(r'"(?:\\.|[^"\\])*"|[{}\[\],:]|[^\s{}\[\],:"]+')


def pointer(path: tuple[str | int, ...]) -> str:
    """`/a/0/b~1c` for ("a", 0, "b/c")."""
    return "".join("/" + str(part).replace("~", "~0").replace("/", "~1") for part in path)


def values_of(text: str, *, objects_only: bool) -> Iterator[tuple[tuple[str | int, ...], int]]:
    """(path, offset) of each value, or of each object, of a well-formed JSON text, in its order."""
    path: list[str | int] = []
    is_object: list[bool] = []
    expects_key = False
    for match in _TOKENS.finditer(text):
        token = match.group()
        if token == ",":
            if is_object[-1]:
                expects_key = True
            else:
                path[-1] += 1  # type: ignore[operator]
        elif token == ":":
            expects_key = False
        elif token in "}]":
            path.pop()
            is_object.pop()
        elif expects_key:
            path[-1] = json.loads(token)
        else:
            if token == "{" or not objects_only:
                yield tuple(path), match.start()
            if token in "{[":
                is_object.append(token == "{")
                path.append("" if token == "{" else 0)
        if token in "{}[]":
            expects_key = token == "{"


def offset_of(text: str, path: tuple[str | int, ...]) -> int:
    """Where the value at `path` starts, or the nearest value around it that there is."""
    best, depth = 0, -1
    for found, offset in values_of(text, objects_only=False):
        if len(found) > depth and found == path[: len(found)]:
            best, depth = offset, len(found)
            if depth == len(path):
                break
    return best
