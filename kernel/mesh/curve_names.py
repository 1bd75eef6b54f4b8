"""How curves are named, as far as the text alone shows; kernel/mesh/curve_choice.py finds them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from kernel.csg.tree import CsgNode
from kernel.errors import OptionError
from kernel.segment.addresses import check_addresses


def check_curve_names(texts: Iterable[str], root: CsgNode, what: str, ids: Sequence[str] | None = None) -> None:
    """OptionError for a text whose nodes the model does not have. ids: of the segments, None before they are known."""
    for text in texts:
        if point_of(text, f"{what} of {text!r}") is None:
            check_addresses([part.strip() for part in text.split("&")], root, what, ids)


def point_of(text: str, what: str) -> NDArray[np.float64] | None:
    """The point that the text is, None where it is none."""
    parts = text.split(",")
    if len(parts) == 1:
        return None
    try:
        values = [float(part) for part in parts]
    except ValueError:
        values = []
    if len(values) != 3 or not all(math.isfinite(value) for value in values):
        raise OptionError(f"{what}: expected a point as x,y,z, such as 10,0,25")
    return np.array(values)
