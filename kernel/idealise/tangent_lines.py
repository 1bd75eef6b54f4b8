"""Lines along which a plate lies on a tube, or two tubes side by side: imprinted in both, for their nodes to be tied.

Their mid-surfaces do not meet. Each gets the line of contact, brought onto it along its own normal: a row of nodes, as
under a weld.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.connect.side_by_side import parallel_apart
from kernel.idealise.implicit import project
from kernel.idealise.imprints import Candidate
from kernel.idealise.outlines import stretch_between
from kernel.idealise.parts import Parts
from kernel.idealise.walls import Wall
from kernel.solid.charts import lift
from kernel.solid.surfaces import Axis, CylinderSurface, Plane, Surface

Array = NDArray[np.float64]


def is_tangent(parts: Parts, joint: Joint) -> bool:
    """Whether a plate lies on a tube there, or two tubes of parallel axes side by side, face to face."""
    if joint.kind != "lap":
        return False
    first, second = (parts.walls[name].sheet.surface for name in joint.segments)
    if isinstance(first, CylinderSurface) and isinstance(second, CylinderSurface):
        return first.axis_id != second.axis_id
    return isinstance(first, Plane) != isinstance(second, Plane)


def tangent_candidates(parts: Parts) -> list[Candidate]:
    """The line of contact of each such joint, in both walls: once for each part of its patch."""
    found = []
    for joint in parts.joints:
        if is_tangent(parts, joint):
            for ends in _lines(parts, joint):
                found += [_laid(parts, parts.walls[name], ends) for name in joint.segments]
    return found


def line_notes(parts: Parts) -> list[str]:
    """A line for each two segments that lie along one another and have no more than a line in common."""
    return [
        f"{' and '.join(joint.segments)} touch along a line ({joint.id}): tied there, as by a weld"
        for joint in parts.joints
        if joint.kind in ("lap", "along") and joint.mate is not None and not joint.gap
    ]


def _lines(parts: Parts, joint: Joint) -> list[Array]:
    """The ends (2, 3) of the lines, on the face of the first segment or near it."""
    first, second = (parts.walls[name] for name in joint.segments)
    axis, out = _towards(first.sheet.surface, second.sheet.surface)
    across = np.cross(axis.direction, out)
    surface = first.segment.solid.surfaces.surfaces[joint.surface]
    lines = []
    for part in shapely.get_parts(joint.patch):
        arms = lift(surface, np.asarray(part.exterior.coords)[:, :2]) - axis.point
        away = float(np.clip(0.0, (arms @ across).min(), (arms @ across).max()))
        heights = arms @ axis.direction
        depths = arms @ out
        depth = float(depths.max() if depths.sum() > 0 else depths.min())
        foot = axis.point + away * across + depth * out
        lines.append(foot + np.outer([heights.min(), heights.max()], axis.direction))
    return lines


def _towards(first: Surface, second: Surface) -> tuple[Axis, Array]:
    """The axis of a tube, and from there the direction (3,) square to the plane that is tangent to it, or to the other
    tube's axis. The line of contact lies in it, one way or the other.
    """
    if isinstance(first, CylinderSurface) and isinstance(second, CylinderSurface):
        apart = parallel_apart(first, second)
        return first.axis, apart / np.linalg.norm(apart)
    plane, tube = (first, second) if isinstance(first, Plane) else (second, first)
    assert isinstance(plane, Plane)
    assert isinstance(tube, CylinderSurface)
    return tube.axis, plane.normal * np.sign(plane.offset - float(plane.normal @ tube.axis.point))


def _laid(parts: Parts, wall: Wall, ends: Array) -> Candidate:
    """A line of the wall's sheet between the places of two points (2, 3) on it."""
    points = project(ends, (wall.sheet.surface,))
    number = parts.topology.carriers.line(points[0], points[1] - points[0])
    return Candidate(wall, stretch_between(parts.topology, number, points[0], points[1], points.mean(axis=0)[None]))
