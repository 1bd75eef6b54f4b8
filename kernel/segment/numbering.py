"""Segments of the drafts that are left in the end: numbered, named and shaped; they must fill the solid."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING

import numpy as np
from shapely.errors import GEOSException

from kernel.csg.tree import walk
from kernel.errors import DefectError, MeshError
from kernel.segment.segments import Segment
from kernel.segment.shapes import Draft, shape_of
from kernel.units import VOLUME_TOLERANCE

if TYPE_CHECKING:
    from kernel.solid.evaluate import Evaluated
    from kernel.solid.solid import Solid


@contextmanager
def named(path: str) -> Iterator[None]:
    """What areas refuse, said of the node at `path`."""
    try:
        yield
    except GEOSException as refusal:
        raise MeshError(
            f"{path}: its faces cannot be joined as areas ({refusal}); expected faces that either coincide or are "
            "further apart than rounding"
        ) from None


def check_volume(drafts: Sequence[Draft], solid: Solid) -> None:
    """DefectError where the drafts do not fill the solid."""
    total = sum(draft.solid.volume for draft in drafts)
    if abs(total - solid.volume) > VOLUME_TOLERANCE * solid.volume:
        raise DefectError(
            f"the segments' volumes sum to {total:.9g}, expected the solid's {solid.volume:.9g} "
            f"within {VOLUME_TOLERANCE:g} of it"
        )


def numbered(drafts: Sequence[Draft], evaluated: Evaluated) -> tuple[Segment, ...]:
    """Segments in the order of their paths, then of their places."""
    names = {path: node.name for path, node in walk(evaluated.model.root)}
    size = evaluated.size

    def order(draft: Draft) -> tuple:
        steps = () if draft.path == "/" else tuple(int(step) for step in draft.path.split("."))
        middle = np.round(draft.solid.bounds.mean(axis=0) / size, 6) + 0.0
        return (steps, tuple(map(float, middle)), draft.type, -draft.solid.volume)

    segments = []
    for number, draft in enumerate(sorted(drafts, key=order), 1):
        with named(draft.path):
            shape, holes = shape_of(draft)
        segments.append(
            Segment(
                id=f"s{number}",
                node=draft.path,
                name=names[draft.path],
                type=draft.type,
                origin=draft.decision.origin,
                solid=draft.solid,
                shape=shape,
                decision=draft.decision,
                volume=draft.solid.true_volume,
                holes=holes,
                sources=draft.sources or (draft.path,),
            )
        )
    return tuple(segments)
