"""What a user says about parts of a model by name, brought to the segments that it is about."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

from kernel.csg.tree import CsgNode, find
from kernel.errors import OptionError, OverrideError
from kernel.segment.segments import Segment

Value = TypeVar("Value")

_SEGMENT_ID = re.compile(r"s[1-9]\d*")


def is_under(path: str, ancestor: str) -> bool:
    """Whether the node at `path` is the one at `ancestor` or one of its descendants."""
    return ancestor == "/" or path == ancestor or path.startswith(f"{ancestor}.")


def depth(path: str) -> int:
    """How far below the root a node is; the root is at 0."""
    return 0 if path == "/" else path.count(".") + 1


def by_segment(
    wanted: Mapping[str, Value], root: CsgNode, segments: Sequence[Segment], what: str
) -> dict[str, tuple[Value, str]]:
    """(value, the address that gave it) by segment id, for the segments that an address of `wanted` is about.

    wanted: by segment id, CSG node path or name. Of two nodes that hold for a segment the deeper one wins, and the
    segment's own id over both. what: names the option in messages: "size". OptionError: an address of nothing, of no
    segment, or of the same node as another one.
    """
    ids = [segment.id for segment in segments]
    paths: dict[str, str] = {}
    for address in wanted:
        if address in ids:
            continue
        path = path_of(address, root, what, ids)
        if path in paths:
            raise OptionError(f"{what} of {paths[path]!r} and of {address!r}: both are node {path}, expected one")
        paths[path] = address
    for path, address in paths.items():
        if not any(is_under(segment.node, path) for segment in segments):
            own = ", ".join(dict.fromkeys(_node_of(segment) for segment in segments))
            raise OptionError(
                f"{what} of {address!r}: node {path} has no segments of its own, expected a node that is meshed "
                f"({own}), or a segment"
            )
    found: dict[str, tuple[Value, str]] = {}
    for segment in segments:
        above = [path for path in paths if is_under(segment.node, path)]
        address = segment.id if segment.id in wanted else paths[max(above, key=depth)] if above else ""
        if address:
            found[segment.id] = (wanted[address], address)
    return found


def path_of(address: str, root: CsgNode, what: str, ids: Sequence[str] = ()) -> str:
    """The canonical path of the node that the address means. OptionError, naming what is expected, where it is none."""
    try:
        return find(root, address)[0]
    except OverrideError as error:
        segments = f", or a segment from {ids[0]} to {ids[-1]}" if ids and _SEGMENT_ID.fullmatch(address) else ""
        raise OptionError(f"{what} of {address!r}: {error.message}{segments}") from error


def check_addresses(addresses: Iterable[str], root: CsgNode, what: str) -> None:
    """OptionError for an address that the model's text already shows to be of nothing; ids of segments come later."""
    for address in addresses:
        if not _SEGMENT_ID.fullmatch(address):
            path_of(address, root, what)


def _node_of(segment: Segment) -> str:
    return segment.name or segment.node
