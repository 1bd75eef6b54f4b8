"""How a brick was meshed, and why so, in words: what the user reads beside each brick."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.brick import SweepGroup, SweptBrick
from kernel.places import place_text
from kernel.segment.prism import sweeps
from kernel.segment.segments import Segment
from kernel.segment.stack import obstacle

Array = NDArray[np.float64]

ALONG_AXIS = 1e-9
"""A unit vector's component that is nearer to 1 than this: the vector is the axis."""


def swept_text(group: SweepGroup, brick: SweptBrick, kinds: Sequence[str], n_layer: int, frame: Array) -> str:
    """`hexahedra swept along z, 12 layers, a stack of 3 prisms`. frame: (3, 3), working frame to the user's."""
    words = [f"{_elements(kinds)} swept along {axis_text(frame @ group.direction)}"]
    words.append("1 layer" if n_layer == 1 else f"{n_layer} layers")
    if len(brick.pieces) > 1:
        words.append(f"a stack of {len(brick.pieces)} prisms")
    if group.host is not None:
        words.append(f"on the elements of {group.host[0].segment.id}")
    return ", ".join(words)


def turned_text(axis: Array, kinds: Sequence[str], n_turn: int, frame: Array) -> str:
    """`hexahedra turned about z, 48 to a turn`."""
    return f"{_elements(kinds)} turned about {axis_text(frame @ axis)}, {n_turn} to a turn"


def _elements(kinds: Sequence[str]) -> str:
    names = {"hex8": "hexahedra", "wedge6": "wedges"}
    return " and ".join(names[kind] for kind in names if kind in kinds)


def not_a_stack(segment: Segment, frame: Array) -> str:
    """Why the segment is not swept: the face that is most in the way, and along what."""
    found = obstacle(segment.solid, [sweep.direction for sweep in sweeps(segment.solid)])
    if found is None:
        return "not a stack of prisms"
    axis, place = axis_text(frame @ found.direction), place_text(frame @ found.place)
    return f"not a stack of prisms: along {axis} the {found.what} near {place} is in the way"


def axis_text(direction: Array) -> str:
    """`z`, or the unit vector's components."""
    for name, value in zip("xyz", direction):
        if abs(value) > 1.0 - ALONG_AXIS:
            return name
    return f"({', '.join(f'{value + 0.0:.4g}' for value in np.round(direction, 6))})"
