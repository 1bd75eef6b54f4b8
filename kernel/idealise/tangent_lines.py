"""Lines along which a plate lies on the outside of a tube: imprinted in both, so that their nodes can be tied there.

Their mid-surfaces do not meet. Each gets the line of contact, brought onto it along its own normal: a row of nodes, as
under a weld.
"""

from __future__ import annotations

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.idealise.implicit import project
from kernel.idealise.imprints import Candidate
from kernel.idealise.outlines import stretch_between
from kernel.idealise.parts import Parts
from kernel.idealise.walls import Wall
from kernel.solid.charts import lift
from kernel.solid.surfaces import CylinderSurface, Plane

Array = NDArray[np.float64]


def is_tangent(parts: Parts, joint: Joint) -> bool:
    """Whether a plate lies on a tube there, face to face."""
    if joint.kind != "lap":
        return False
    first, second = (parts.walls[name].sheet.surface for name in joint.segments)
    return isinstance(first, Plane) != isinstance(second, Plane)


def tangent_candidates(parts: Parts) -> list[Candidate]:
    """The line of contact of each such joint, in both walls: once for each part of its patch.

    Where the two have no more than that line in common, a warning says so.
    """
    found = []
    for joint in parts.joints:
        if is_tangent(parts, joint):
            for ends in _lines(parts, joint):
                found += [_laid(parts, parts.walls[name], ends) for name in joint.segments]
            if joint.mate is not None and not joint.gap:
                first, second = joint.segments
                parts.warnings.append(f"{first} and {second} touch along a line ({joint.id}): tied there, as by a weld")
    return found


def _lines(parts: Parts, joint: Joint) -> list[Array]:
    """The ends (2, 3) of the lines, on the plane's face or near it."""
    first, second = (parts.walls[name] for name in joint.segments)
    plane, cylinder = first.sheet.surface, second.sheet.surface
    if isinstance(cylinder, Plane):
        plane, cylinder = cylinder, plane
    assert isinstance(plane, Plane)
    assert isinstance(cylinder, CylinderSurface)
    axis = cylinder.axis
    out = plane.normal * np.sign(plane.offset - float(plane.normal @ axis.point))
    across = np.cross(axis.direction, out)
    surface = first.segment.solid.surfaces.surfaces[joint.surface]
    lines = []
    for part in shapely.get_parts(joint.patch):
        arms = lift(surface, np.asarray(part.exterior.coords)[:, :2]) - axis.point
        away = float(np.clip(0.0, (arms @ across).min(), (arms @ across).max()))
        heights = arms @ axis.direction
        foot = axis.point + away * across + float((arms @ out).max()) * out
        lines.append(foot + np.outer([heights.min(), heights.max()], axis.direction))
    return lines


def _laid(parts: Parts, wall: Wall, ends: Array) -> Candidate:
    """A line of the wall's sheet between the places of two points (2, 3) on it."""
    points = project(ends, (wall.sheet.surface,))
    number = parts.topology.carriers.line(points[0], points[1] - points[0])
    return Candidate(wall, stretch_between(parts.topology, number, points[0], points[1], points.mean(axis=0)[None]))
