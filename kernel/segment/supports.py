"""Free length: how far a member runs between the contacts that support it.

A contact is where a neighbour reaches into the member's own box. It is no support where it is

    an attachment   shorter than half the section's depth, and not at an end (a rung on a rail)
    a seam          along more than half the member, from outside (a stiffener on its plate)
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

if TYPE_CHECKING:
    from kernel.segment.prism import Prism
    from kernel.solid.solid import Solid

SEAM_SHARE = 0.5
"""A contact from outside along more than this share of a member's length is a seam."""

SUPPORT_DEPTH = 0.5
"""A contact along less than this share of the section's longer side is an attachment."""

INSIDE = 0.5
"""A neighbour that fills this share of the member's box over the contact holds the member inside it."""

TIGHT = 0.999
"""A solid that fills this share of its box in some frame is that box."""


@dataclass(frozen=True, slots=True)
class Contact:
    """Where a neighbour reaches into the member's box: from start to end along it; fill: share of the box it fills."""

    start: float
    end: float
    fill: float


def free_length(solid: Solid, prism: Prism, neighbours: tuple[Solid, ...]) -> float:
    """Longest length along the prism between supports."""
    sweep = prism.sweep
    slack = 10.0 * solid.surfaces.tolerance
    axes = np.stack([prism.u, prism.v, sweep.direction], axis=1)
    supports: list[tuple[float, float]] = []
    for neighbour in neighbours:
        contact = find_contact(solid, axes, neighbour)
        if contact is None:
            continue
        length = contact.end - contact.start
        is_at_end = contact.start < sweep.start + slack or contact.end > sweep.end - slack
        is_attachment = length < SUPPORT_DEPTH * prism.long_side - slack and not is_at_end
        is_seam = length > SEAM_SHARE * sweep.length and contact.fill < INSIDE
        if not is_attachment and not is_seam:
            supports.append((contact.start, contact.end))
    free, reached = 0.0, sweep.start
    for first, last in [*sorted(supports), (sweep.end, sweep.end)]:
        free = max(free, first - reached)
        reached = max(reached, last)
    return free


def find_contact(solid: Solid, axes: NDArray[np.float64], neighbour: Solid) -> Contact | None:
    """Where `neighbour` meets the box of `solid` that stands along the columns of `axes` (3, 3), the last one along
    the member; None where it does not.
    """
    slack = 10.0 * solid.surfaces.tolerance
    low, high = _box(solid, axes)
    other_low, other_high = _box(neighbour, axes)
    start, end = np.maximum(low, other_low), np.minimum(high, other_high)
    if np.any(end < start - slack):
        return None
    if neighbour.volume > TIGHT * float(np.prod(other_high - other_low)):
        area = float(np.prod(np.maximum(end - start, 0.0)[:2]))
    else:
        box = Manifold.cube(tuple(high - low + 2.0 * slack)).translate(tuple(low - slack))
        common = neighbour.manifold ^ box.transform(np.hstack([axes, np.zeros((3, 1))]))
        if common.is_empty():
            return None
        along = np.asarray(common.to_mesh64().vert_properties)[:, :3] @ axes[:, 2]
        start[2], end[2] = max(float(along.min()), low[2]), min(float(along.max()), high[2])
        area = float(common.volume()) / max(float(end[2] - start[2]), slack)
    return Contact(float(start[2]), max(float(end[2]), float(start[2])), area / float(np.prod((high - low)[:2])))


def _box(solid: Solid, axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, 3) lowest and highest coordinates along the columns of `axes`."""
    if np.count_nonzero(axes) == 3:  # the working frame's own axes, renamed
        ends = solid.bounds @ axes
        return np.sort(ends, axis=0)
    along = solid.facets.vertices @ axes
    return np.array([along.min(axis=0), along.max(axis=0)])
