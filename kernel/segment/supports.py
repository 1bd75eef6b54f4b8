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


def contacts_along(solid: Solid, prism: Prism, neighbours: tuple[Solid, ...]) -> list[Contact]:
    """Where the neighbours meet the box that stands along the prism."""
    return find_contacts(solid, np.stack([prism.u, prism.v, prism.sweep.direction], axis=1), neighbours)


def free_length(solid: Solid, prism: Prism, contacts: list[Contact]) -> float:
    """Longest length along the prism between supports."""
    sweep = prism.sweep
    slack = 10.0 * solid.surfaces.tolerance
    supports: list[tuple[float, float]] = []
    for contact in contacts:
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


def find_contacts(solid: Solid, axes: NDArray[np.float64], neighbours: tuple[Solid, ...]) -> list[Contact]:
    """Where each neighbour meets the box of `solid` that stands along the columns of `axes` (3, 3), the last one along
    the member; those that do not meet it are left out.
    """
    if not neighbours:
        return []
    slack = 10.0 * solid.surfaces.tolerance
    low, high = _boxes((solid,), axes)[0]
    boxes = _boxes(neighbours, axes)
    starts, ends = np.maximum(low, boxes[:, 0]), np.minimum(high, boxes[:, 1])
    section = float(np.prod((high - low)[:2]))
    areas = np.prod(np.maximum(ends - starts, 0.0)[:, :2], axis=1)
    room = np.prod(boxes[:, 1] - boxes[:, 0], axis=1)
    contacts = []
    for index in np.nonzero((ends >= starts - slack).all(axis=1))[0]:
        neighbour = neighbours[index]
        start, end, area = float(starts[index, 2]), float(ends[index, 2]), float(areas[index])
        if neighbour.volume <= TIGHT * float(room[index]):
            box = Manifold.cube(tuple(high - low + 2.0 * slack)).translate(tuple(low - slack))
            common = neighbour.manifold ^ box.transform(np.hstack([axes, np.zeros((3, 1))]))
            if common.is_empty():
                continue
            along = np.asarray(common.to_mesh64().vert_properties)[:, :3] @ axes[:, 2]
            start, end = max(float(along.min()), float(low[2])), min(float(along.max()), float(high[2]))
            area = float(common.volume()) / max(end - start, slack)
        contacts.append(Contact(start, max(start, end), area / section))
    return contacts


def _boxes(solids: tuple[Solid, ...], axes: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 2, 3) lowest and highest coordinates of each solid along the columns of `axes`."""
    if np.count_nonzero(axes) == 3:  # the working frame's own axes, renamed
        return np.sort(np.array([solid.bounds for solid in solids]) @ axes, axis=1)
    along = [solid.facets.vertices @ axes for solid in solids]
    return np.array([(points.min(axis=0), points.max(axis=0)) for points in along])
