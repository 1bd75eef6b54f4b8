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
    """Two segments share an area of one surface, touch along a cylinder, or look at one another over a stated gap.

    id: "j1", ...; kind: one of JOINT_KINDS. segments: their two ids. surface: id of the shared surface in the table.
    area: of the patch. patch: its outline in the surface's own coordinates (plane: x.u, x.v; cylinder: r*angle, z).
    centre: (3,) the patch's centroid; a point within it where the centroid is not (rings, bent strips). normal: (3,)
    unit, out of the first segment into the second at the centre. middle: (3,) the centroid itself, in the hollow of
    a tube's end too: where a beam's axis meets the contact. On surfaces other than planes and cylinders the centre.
    gap: distance of the two faces, 0 where they touch. Where they lie on two surfaces, surface and patch are the first
    segment's, and mate and mate_patch those of the second.
    """

    id: str
    kind: str
    segments: tuple[str, str]
    surface: int
    area: float
    patch: Polygon | MultiPolygon
    centre: NDArray[np.float64]
    normal: NDArray[np.float64]
    middle: NDArray[np.float64]
    gap: float = 0.0
    mate: int | None = None
    mate_patch: Polygon | MultiPolygon | None = None

    def surface_of(self, segment: str) -> int:
        """Id of the surface that the segment of that id has there."""
        return self.surface if self.mate is None or segment == self.segments[0] else self.mate

    def patch_of(self, segment: str) -> Polygon | MultiPolygon:
        """The patch in that surface's coordinates."""
        return self.patch if self.mate_patch is None or segment == self.segments[0] else self.mate_patch


def joints_by_segment(joints: Iterable[Joint]) -> dict[str, list[Joint]]:
    """The joints of each segment that has any, in their order."""
    found: dict[str, list[Joint]] = {}
    for joint in joints:
        for name in joint.segments:
            found.setdefault(name, []).append(joint)
    return found
