"""Walls: plates and cylinder-plates with their sheets and their own mid-sections."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely
from numpy.typing import NDArray
from shapely import Polygon

from kernel.connect.joints import Joint
from kernel.errors import MeshError
from kernel.idealise.implicit import project
from kernel.idealise.outlines import PolygonLike, Stretch, domain, trace_ring, unwrapped
from kernel.idealise.rings import middle_angle, sheet_rings
from kernel.idealise.sheets import Sheet, cylinder_sheet, plane_sheet
from kernel.idealise.topology import Topology
from kernel.segment.segments import CylinderShape, PlateShape, Segment
from kernel.solid.charts import lift
from kernel.solid.solid import Solid
from kernel.solid.surfaces import Surface, signed_distance

Array = NDArray[np.float64]
Interval = tuple[float, float]

CROSSING_SINE = 0.17
"""Mid-surfaces that meet at less than 10 degrees do not join in a curve: they lap."""

CRUMB = 1e-3
"""A wall that its own mid-surface misses is left out where it has no more than this share of the model's volume."""

SEAM_ANGLE = 0.7390851
"""Where closed cylinders are cut open, in radians from their x axis: at no angle that a model would use."""


@dataclass(slots=True, eq=False)
class Wall:
    """A plate or cylinder-plate. index: its face in the topology; own: its own mid-section, in the sheet's frame.

    known: carriers that its outline may lie on. region, outline: what is meshed, set once the walls are joined.
    """

    index: int
    segment: Segment
    sheet: Sheet
    thickness: float
    rings: list[list[Stretch]]
    own: PolygonLike
    known: list[int]
    region: PolygonLike = field(default_factory=Polygon)
    outline: list[Stretch] = field(default_factory=list)

    @property
    def surface_ids(self) -> tuple[int, int]:
        """Its two faces' ids in the surface table."""
        assert isinstance(self.segment.shape, PlateShape | CylinderShape)
        return self.segment.shape.surface_ids


def make_wall(topology: Topology, index: int, segment: Segment, beside: Sequence[Segment] = ()) -> Wall | None:
    """The wall of a plate or cylinder-plate segment, with its own mid-section; None where that does not meet its solid.

    beside: segments through which its mid-surface may be carried on. A cylinder-plate that these close to a whole tube
    is unrolled like one.
    """
    shape, table = segment.shape, segment.solid.surfaces
    sheet: Sheet
    if isinstance(shape, PlateShape):
        sheet = plane_sheet(shape, table)
        thickness = shape.thickness
    else:
        assert isinstance(shape, CylinderShape)
        sheet = cylinder_sheet(shape, table, SEAM_ANGLE, is_closed=True)
        own = sheet_rings(segment.solid, sheet)
        if own and not any(_winds(sheet, ring.points) for ring in own):
            around = [ring for other in beside for ring in sheet_rings(other.solid, sheet)]
            middle = middle_angle([*own, *around], shape.axis)
            if middle is not None:
                sheet = cylinder_sheet(shape, table, middle, is_closed=False)
        thickness = shape.thickness
    rings = section_outline(topology, segment.solid, sheet)
    if not rings:
        return None
    wall = Wall(
        index=index,
        segment=segment,
        sheet=sheet,
        thickness=thickness,
        rings=rings,
        own=domain(topology, sheet, rings),
        known=sorted({stretch.carrier for ring in rings for stretch in ring}),
    )
    wall.region = wall.own
    wall.outline = [stretch for ring in rings for stretch in ring]
    return wall


def section_outline(topology: Topology, solid: Solid, sheet: Sheet, onto: Sheet | None = None) -> list[list[Stretch]]:
    """The rings in which a solid meets a sheet, on carriers; rings that enclose nothing are left out.

    onto: another sheet on which they are laid, for a solid that has the same section there.
    """
    rings = []
    for ring in sheet_rings(solid, sheet):
        if _encloses(sheet, ring.points, topology.tolerance):
            points = ring.points if onto is None else project(ring.points, (onto.surface,))
            stretches = trace_ring(topology, solid.surfaces, onto or sheet, points, ring.labels)
            if stretches:
                rings.append(stretches)
    return rings


def _encloses(sheet: Sheet, points: Array, tolerance: float) -> bool:
    """Whether the ring winds round a closed sheet, or is wider than a sliver."""
    if _winds(sheet, points):
        return True
    flat = unwrapped(sheet, np.vstack([points, points[:1]]))
    x, y = flat[:, 0], flat[:, 1]
    area = 0.5 * abs(float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1])))
    length = float(np.linalg.norm(np.diff(flat, axis=0), axis=1).sum())
    return len(points) > 2 and area > tolerance * length


def corner_material(segments: Sequence[Segment], joints: Sequence[Joint], walls: dict[str, Wall]) -> tuple[str, ...]:
    """Ids of the segments that lie within the slabs of two walls that they touch and that stand across one another.

    Such a piece is what two walls have in common beyond their faces (the mitre of a sharp corner), already counted by
    their mid-surfaces.
    """
    touched: dict[str, list[Wall]] = {}
    for joint in joints:
        for name, other in (joint.segments, joint.segments[::-1]):
            if name not in walls and other in walls and walls[other] not in touched.setdefault(name, []):
                touched[name].append(walls[other])
    found = []
    for segment in segments:
        points = segment.solid.facets.vertices
        slack = 10 * segment.solid.surfaces.tolerance
        around = [
            wall
            for wall in touched.get(segment.id, [])
            if np.abs(signed_distance(wall.sheet.surface, points)).max() <= 0.5 * wall.thickness + slack
        ]
        normals = [wall.sheet.normals(points[:1])[0] for wall in around]
        if any(np.linalg.norm(np.cross(a, b)) > CROSSING_SINE for a in normals for b in normals):
            found.append(segment.id)
    return tuple(found)


def refuse_lost(
    segments: Sequence[Segment], lost: Sequence[str], joints: Sequence[Joint], walls: dict[str, Wall]
) -> None:
    """MeshError where one of the walls that are lost, for their mid-surfaces do not meet them, is more than a crumb.

    A crumb is a bit of a wall that others have left over beside themselves, and that touches a wall.
    """
    total = sum(segment.volume for segment in segments)
    held = {name for joint in joints for name, other in (joint.segments, joint.segments[::-1]) if other in walls}
    for segment in segments:
        if segment.id in lost and (segment.id not in held or segment.volume > CRUMB * total):
            raise MeshError(f"{segment.id} ({segment.node}): its mid-surface does not meet its own solid")


def _winds(sheet: Sheet, points: Array) -> bool:
    """Whether a ring goes round a closed sheet."""
    if sheet.turn is None:
        return False
    flat = unwrapped(sheet, np.vstack([points, points[:1]]))
    return bool(abs(flat[-1, 0] - flat[0, 0]) > 0.5 * sheet.turn)


def patch_points(surface: Surface, patch: PolygonLike) -> Array:
    """Points (n, 3) of a joint's patch: some of its outline, and one within each part."""
    flat = []
    for part in shapely.get_parts(patch):
        outline = np.asarray(part.exterior.coords)
        flat.append(outline[:: max(1, len(outline) // 16), :2])
        inner = part.representative_point()
        flat.append(np.array([[inner.x, inner.y]]))
    points = np.vstack(flat)
    return lift(surface, points)
