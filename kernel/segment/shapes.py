"""Drafts: segments in the making, and the shape that each ends up with.

A draft knows the solid that it was decided on (`whole`) and the solid that it may keep (`solid`), which shrinks
where others own the overlap.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import shapely

from kernel.segment.faces import Region, closes, faces_of, periodic_holes
from kernel.segment.prism import Prism, sweeps
from kernel.segment.segments import BeamShape, BrickShape, CylinderShape, PlateShape, Shape
from kernel.segment.slices import parts_of, slice_loops, slice_polygon
from kernel.segment.walls import PlaneWall, TubeWall, Wall
from kernel.solid.section import section
from kernel.solid.surfaces import CylinderSurface

if TYPE_CHECKING:
    from kernel.plan import Decision
    from kernel.solid.solid import Solid

SMALLEST_HOLE = 1e-6
"""A loop of less than this many thicknesses squared is rounding, no hole."""

ARC_DIVISIONS = 8
"""Chords that replace each facet of a circle in a beam's outline: 768 to a turn, area within 1.2e-5."""


@dataclass(frozen=True, slots=True, eq=False)
class Draft:
    """One segment in the making.

    path: CSG node; sources: paths of the nodes that were combined into it. prism: for beams, as measured on `whole`.
    wall: for plates and cylinder-plates. reach: full start and end of a beam along its direction, before trimming.
    """

    path: str
    name: str | None
    type: str
    decision: Decision
    solid: Solid
    whole: Solid
    prism: Prism | None = None
    wall: Wall | None = None
    reach: tuple[float, float] | None = None
    sources: tuple[str, ...] = ()

    @property
    def is_pinned(self) -> bool:
        """The user decided it."""
        return self.decision.origin == "override"

    @property
    def section_area(self) -> float:
        """Of a beam; 0 otherwise."""
        return self.prism.area if self.prism is not None and self.type == "beam" else 0.0


def wall_type(wall: Wall) -> str:
    """The segment type that a wall becomes."""
    return "cylinder_plate" if isinstance(wall, TubeWall) else "plate"


def shape_of(draft: Draft) -> tuple[Shape, int | None]:
    """The draft's shape, and the number of its holes (plates and cylinder-plates)."""
    if draft.type == "beam":
        return _beam_shape(draft), None
    if isinstance(draft.wall, PlaneWall):
        return _plate_shape(draft, draft.wall), wall_holes(draft.wall, draft.solid)
    if isinstance(draft.wall, TubeWall):
        return _cylinder_shape(draft, draft.wall), wall_holes(draft.wall, draft.solid)
    exact = [sweep.direction for sweep in sweeps(draft.solid) if sweep.is_exact]
    return BrickShape(exact[0] if exact else None), None


# ---------------------------------------------------------------- beams


def _beam_shape(draft: Draft) -> BeamShape:
    prism = draft.prism
    assert prism is not None
    direction = prism.sweep.direction
    along = draft.solid.facets.vertices @ direction
    start, end = float(along.min()), float(along.max())
    full_start, full_end = draft.reach or (prism.sweep.start, prism.sweep.end)
    return BeamShape(
        direction=direction,
        u=prism.u,
        v=prism.v,
        start=start,
        end=end,
        full_start=min(full_start, start),
        full_end=max(full_end, end),
        outline=_true_outline(draft.whole, prism),
    )


def _true_outline(solid: Solid, prism: Prism) -> Region:
    """The median section with its circles drawn fine."""
    direction = prism.sweep.direction
    if not any(
        isinstance(surface := solid.surfaces.surfaces[index], CylinderSurface)
        and abs(float(surface.axis.direction @ direction)) > 1.0 - 1e-9
        for index in np.unique(solid.facets.surface)
    ):
        return prism.section.simplify(1e-9 * solid.size)
    cut = section(solid, direction, prism.section_offset)
    rings = []
    for points, surfaces in cut.rings:
        drawn: list[np.ndarray] = []
        for k in range(len(points)):
            start, end = points[k], points[(k + 1) % len(points)]
            drawn.append(start[None])
            surface = solid.surfaces.surfaces[surfaces[k]]
            if isinstance(surface, CylinderSurface) and abs(float(surface.axis.direction @ direction)) > 1.0 - 1e-9:
                centre = np.array([surface.axis.point @ cut.u, surface.axis.point @ cut.v])
                drawn.append(_arc(start - centre, end - centre) + centre)
        rings.append(np.concatenate(drawn) @ _turn(cut.u, cut.v, prism))
    outline = shapely.build_area(shapely.multilinestrings([np.vstack([ring, ring[:1]]) for ring in rings]))
    return outline


def _turn(u: np.ndarray, v: np.ndarray, prism: Prism) -> np.ndarray:
    """(2, 2) that takes coordinates in (u, v) to coordinates in the prism's (u, v)."""
    return np.array([[u @ prism.u, u @ prism.v], [v @ prism.u, v @ prism.v]])


def _arc(start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Points between two points of a circle about the origin, the short way."""
    first = math.atan2(start[1], start[0])
    sweep = math.atan2(start[0] * end[1] - start[1] * end[0], float(start @ end))
    angles = first + sweep * np.arange(1, ARC_DIVISIONS) / ARC_DIVISIONS
    return float(np.hypot(*start)) * np.stack([np.cos(angles), np.sin(angles)], axis=1)


# ---------------------------------------------------------------- plates


def _plate_shape(draft: Draft, wall: PlaneWall) -> PlateShape:
    paired = wall.paired
    if draft.solid is not draft.whole or len(parts_of(wall.paired)) > 1:
        paired = _within(wall.paired, _mid_section(wall, draft.solid))
    return PlateShape(
        normal=wall.normal,
        u=wall.u,
        v=wall.v,
        bottom=wall.bottom,
        top=wall.top,
        paired=paired,
        surface_ids=wall.surface_ids,
    )


def _mid_section(wall: PlaneWall, solid: Solid) -> Region:
    return slice_polygon(solid.facets, wall.normal, 0.5 * (wall.bottom + wall.top), wall.u, wall.v)


def _within(paired: Region, own: Region) -> Region:
    """The paired region where the segment still is; the whole section where nothing of it is left."""
    size = max(own.bounds[2] - own.bounds[0], own.bounds[3] - own.bounds[1]) if not own.is_empty else 1.0
    common = shapely.intersection(paired, own, grid_size=1e-9 * size)
    parts = [part for part in parts_of(common) if part.area > 1e-9 * own.area]
    if not parts:
        return own
    return parts[0] if len(parts) == 1 else shapely.multipolygons(parts)


def wall_holes(wall: Wall, solid: Solid) -> int:
    """Inner boundary loops of the wall's domain: of the mid-section, or of the unrolled faces."""
    if isinstance(wall, PlaneWall):
        smallest = SMALLEST_HOLE * wall.thickness**2
        loops = slice_loops(solid.facets, wall.normal, 0.5 * (wall.bottom + wall.top), wall.u, wall.v)
        return int((loops < -smallest).sum())
    smallest = SMALLEST_HOLE * (wall.thickness / wall.mid_radius) ** 2 * wall.mid_radius
    return sum(hole.area > smallest for hole in periodic_holes(_unrolled(wall, solid)))


# ---------------------------------------------------------------- cylinder-plates


def _cylinder_shape(draft: Draft, wall: TubeWall) -> CylinderShape:
    along = (draft.solid.facets.vertices - wall.axis.point) @ wall.axis.direction
    return CylinderShape(
        axis=wall.axis,
        axis_id=wall.axis_id,
        inner_radius=wall.inner_radius,
        outer_radius=wall.outer_radius,
        z_min=float(along.min()),
        z_max=float(along.max()),
        is_closed=closes(_unrolled(wall, draft.solid)),
        surface_ids=wall.surface_ids,
    )


def _unrolled(wall: TubeWall, solid: Solid) -> Region:
    """Where the solid has both of the wall's faces, in (angle, z)."""
    faces = faces_of(solid)
    inner, outer = wall.surface_ids
    return faces.unrolled(inner, -1).intersection(faces.unrolled(outer, 1))
