"""What a user says about parts of a model by name, brought to the segments that it is about."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, TypeVar

from kernel.csg.tree import CsgNode, find
from kernel.errors import OptionError, OverrideError
from kernel.segment.segments import Segment

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated

Value = TypeVar("Value")

MOST = 0.5
"""A segment of a node is one of a node within that too where more than this share of its volume lies in its solid."""

_SEGMENT_ID = re.compile(r"s[1-9]\d*")


def is_under(path: str, ancestor: str) -> bool:
    """Whether the node at `path` is the one at `ancestor` or one of its descendants."""
    return ancestor == "/" or path == ancestor or path.startswith(f"{ancestor}.")


def depth(path: str) -> int:
    """How far below the root a node is; the root is at 0."""
    return 0 if path == "/" else path.count(".") + 1


def by_segment(
    wanted: Mapping[str, Value], evaluated: Evaluated, segments: Sequence[Segment], what: str
) -> dict[str, tuple[Value, str]]:
    """(value, the address that gave it) by segment id, for the segments that an address of `wanted` is about.

    wanted: by segment id, CSG node path or name. Of two nodes that hold for a segment the deeper one wins, and the
    segment's own id over both. what: names the option in messages: "size". OptionError: an address of nothing, of no
    segment, or of the same node as another one.
    """
    ids = [segment.id for segment in segments]
    paths: dict[str, str] = {}
    of_path: dict[str, set[str]] = {}
    for address in wanted:
        if address in ids:
            continue
        path, node = node_of(address, evaluated.model.root, f"{what} of {address!r}", ids)
        if path in paths:
            raise OptionError(f"{what} of {paths[path]!r} and of {address!r}: both are node {path}, expected one")
        paths[path] = address
        of_path[path] = set(segments_of(path, node, evaluated, segments))
        if not of_path[path]:
            own = ", ".join(dict.fromkeys(segment.name or segment.node for segment in segments))
            raise OptionError(
                f"{what} of {address!r}: node {path} has no segments of its own, expected a node that is meshed "
                f"({own}), or a segment"
            )
    found: dict[str, tuple[Value, str]] = {}
    for name in ids:
        about = [path for path in paths if name in of_path[path]]
        address = name if name in wanted else paths[max(about, key=depth)] if about else ""
        if address:
            found[name] = (wanted[address], address)
    return found


def segments_of(path: str, node: CsgNode, evaluated: Evaluated, segments: Sequence[Segment]) -> list[str]:
    """Ids of the segments at or under a node; and of those of a node above it, by which most of it is filled.

    The plates of an angle with holes are segments of the difference, since no operand of it is meshed by itself; each
    lies in the block that it comes from all the same.
    """
    from kernel.solid.solid import intersect  # not needed where all names are segments' own

    found = []
    for segment in segments:
        if is_under(segment.node, path):
            found.append(segment.id)
        elif is_under(path, segment.node):
            solid = evaluated.solid_of(node)
            (low, high), (own_low, own_high) = solid.bounds, segment.solid.bounds
            if (own_low < high).all() and (low < own_high).all():
                if intersect([segment.solid, solid]).volume > MOST * segment.solid.volume:
                    found.append(segment.id)
    return found


def node_of(address: str, root: CsgNode, what: str, ids: Sequence[str] = ()) -> tuple[str, CsgNode]:
    """The (path, node) that the address means. OptionError, naming what is expected, where it is none."""
    try:
        return find(root, address)
    except OverrideError as error:
        segments = f", or a segment from {ids[0]} to {ids[-1]}" if ids and _SEGMENT_ID.fullmatch(address) else ""
        raise OptionError(f"{what}: {error.message}{segments}") from error


def check_addresses(addresses: Iterable[str], root: CsgNode, what: str, ids: Sequence[str] | None = None) -> None:
    """OptionError for an address that is already known to be of nothing. ids: of the segments, None before they are
    known: then whatever looks like one passes.
    """
    for address in addresses:
        is_segment = _SEGMENT_ID.fullmatch(address) is not None if ids is None else address in ids
        if not is_segment:
            node_of(address, root, f"{what} of {address!r}", ids or ())
