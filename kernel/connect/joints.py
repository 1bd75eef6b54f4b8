"""Joints: where two segments meet."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

JOINT_KINDS = ("edge", "corner", "tee", "cross", "lap", "step", "end_on", "along", "face", "pipe")


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """Two segments share an area of one surface.

    id: "j1", ...; kind: one of JOINT_KINDS. segments: their two ids. surface: id of the shared surface in the table.
    area: of the patch. patch: its outline in the surface's own coordinates (plane: x.u, x.v; cylinder: r*angle, z).
    centre: (3,) the patch's centroid. normal: (3,) unit, out of the first segment into the second at the centre.
    """

    id: str
    kind: str
    segments: tuple[str, str]
    surface: int
    area: float
    patch: Polygon | MultiPolygon
    centre: NDArray[np.float64]
    normal: NDArray[np.float64]


def joints_by_segment(joints: Iterable[Joint]) -> dict[str, list[Joint]]:
    """The joints of each segment that has any, in their order."""
    found: dict[str, list[Joint]] = {}
    for joint in joints:
        for name in joint.segments:
            found.setdefault(name, []).append(joint)
    return found
