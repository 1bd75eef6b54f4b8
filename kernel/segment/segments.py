"""Segments: disjoint parts of the solid, each to be meshed one way, with the shape that its type needs.

All vectors are in the working frame of the evaluated solid (kernel/solid/evaluate.py); lengths in model units.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.plan import Decision

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

    from kernel.solid.solid import Solid
    from kernel.solid.surfaces import Axis

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class BeamShape:
    """Swept along `direction` from start to end (offsets along it: start < end), with a section in the (u, v) plane.

    u, v: unit vectors with u x v = direction. outline: the gross section, in coordinates (x.u, x.v) of the frame's
    origin; circles in it are fine polygons. full_start, full_end: before other segments trimmed the member.
    """

    direction: Vector
    u: Vector
    v: Vector
    start: float
    end: float
    full_start: float
    full_end: float
    outline: Polygon | MultiPolygon


@dataclass(frozen=True, slots=True, eq=False)
class PlateShape:
    """Between the planes normal . x = bottom and = top; u x v = normal.

    paired: the region where both faces are really there, in coordinates (x.u, x.v).
    surface_ids: the two faces' ids in the surface table, bottom and top; -1 where a face is no tracked plane.
    """

    normal: Vector
    u: Vector
    v: Vector
    bottom: float
    top: float
    paired: Polygon | MultiPolygon
    surface_ids: tuple[int, int]

    @property
    def thickness(self) -> float:
        """Distance of the two faces."""
        return self.top - self.bottom

    @property
    def mid_offset(self) -> float:
        """Offset of the mid-surface along the normal."""
        return 0.5 * (self.bottom + self.top)


@dataclass(frozen=True, slots=True, eq=False)
class CylinderShape:
    """Between two coaxial cylinders; z runs along the axis's direction from the axis's point.

    is_closed: goes all the way round. surface_ids: inner and outer cylinder's ids in the surface table.
    """

    axis: Axis
    axis_id: int
    inner_radius: float
    outer_radius: float
    z_min: float
    z_max: float
    is_closed: bool
    surface_ids: tuple[int, int]

    @property
    def thickness(self) -> float:
        """Outer less inner radius."""
        return self.outer_radius - self.inner_radius

    @property
    def mid_radius(self) -> float:
        """Radius of the mid-surface."""
        return 0.5 * (self.inner_radius + self.outer_radius)


@dataclass(frozen=True, slots=True, eq=False)
class BrickShape:
    """A solid; `sweep` is the unit direction along which it is exactly prismatic, or None."""

    sweep: Vector | None


Shape = BeamShape | PlateShape | CylinderShape | BrickShape


@dataclass(frozen=True, slots=True, eq=False)
class Segment:
    """A part meshed one way.

    id: "s1", "s2", ... in a stable order. node: path of the CSG node it comes from; name: that node's, or None.
    type: one of plan.SEGMENT_TYPES. origin: "rule" or "override". volume: of the solid, true surfaces.
    holes: inner boundary loops of a plate's or cylinder-plate's domain, else None.
    """

    id: str
    node: str
    name: str | None
    type: str
    origin: str
    solid: Solid
    shape: Shape
    decision: Decision
    volume: float
    holes: int | None = None
    sources: tuple[str, ...] = ()
    """Paths of the CSG nodes that were combined into it; one of them is `node` unless several were."""

    @property
    def thickness(self) -> float | None:
        """Of a plate or cylinder-plate."""
        return self.shape.thickness if isinstance(self.shape, PlateShape | CylinderShape) else None

    @property
    def radius(self) -> float | None:
        """Mid-surface radius of a cylinder-plate."""
        return self.shape.mid_radius if isinstance(self.shape, CylinderShape) else None

    @property
    def length(self) -> float | None:
        """Axis length of a beam."""
        return self.shape.full_end - self.shape.full_start if isinstance(self.shape, BeamShape) else None
