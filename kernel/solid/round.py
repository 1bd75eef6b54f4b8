"""Primitives that turn about an axis: cylinder, cone, sphere, torus, revolution.

They stay analytic where the placement keeps them round (similar, or only stretched along the axis for all but sphere
and torus): their facets' corners then stand on the canonical surfaces, in steps that all coaxial surfaces share.
Otherwise the curved faces are facets without an analytic form.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from kernel.csg.tree import Cone, Cylinder, Revolution, Sphere, Torus
from kernel.solid.flat import flat_faces
from kernel.solid.frame import SQUARE
from kernel.solid.lathe import END_CAP, SEGMENTS_PER_TURN, START_CAP, Loop, turn, unit_circle
from kernel.solid.setting import FLAT, Setting, positive, still_thick
from kernel.solid.surfaces import Axis, cross
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import NotSolidError

SPHERE_ROWS = 80
"""Rows of facets from pole to pole; with 96 around, a sphere's facets enclose .9989 of its volume."""

TUBE_SEGMENTS = 96
"""Facets around a torus's tube."""


@dataclass(frozen=True, slots=True, eq=False)
class Spindle:
    """The canonical axis of a round placement, and how its z and its angle run along the axis.

    at(z) = base + rise * z is the axial distance; radii are stretched by `stretch`; the primitive's angle a is
    start + a where `is_forward`, start - a where not.
    """

    axis: Axis
    axis_id: int
    base: float
    rise: float
    stretch: float
    start: float
    is_forward: bool


def _is_round(linear: NDArray[np.float64]) -> bool:
    """x and y are stretched alike, and all three columns are perpendicular."""
    scale = np.linalg.norm(linear, axis=0)
    unit = linear / scale
    square = np.abs(unit.T @ unit - np.eye(3)).max() < SQUARE
    return bool(square and abs(scale[0] / scale[1] - 1.0) < SQUARE)


def _is_similar(linear: NDArray[np.float64]) -> bool:
    scale = np.linalg.norm(linear, axis=0)
    return _is_round(linear) and abs(scale[2] / scale[0] - 1.0) < SQUARE


def _spindle(setting: Setting) -> Spindle:
    """The canonical axis through a round placement's origin along its z; coordinates across the axis are snapped."""
    placed, table = setting.placed, setting.table
    origin, along = placed.origin.copy(), placed.linear[:, 2]
    if placed.family is not None and placed.axis_of_z >= 0:
        for column in range(3):
            if column != placed.axis_of_z:
                origin[column] = placed.family.snap(column, float(origin[column]))
    working = setting.to_working(origin)
    direction = setting.to_working(along)
    axis_id = table.axis(working, direction)
    axis = table.axes[axis_id]
    x = setting.to_working(placed.linear[:, 0])
    y = setting.to_working(placed.linear[:, 1])
    sign = 1.0 if float(direction @ axis.direction) > 0.0 else -1.0
    stretch = math.sqrt(float(x @ x))
    return Spindle(
        axis,
        axis_id,
        float(working @ axis.direction),
        sign * _tidy(math.sqrt(float(direction @ direction))),
        _tidy(stretch),
        math.atan2(float(x @ axis.y), float(x @ axis.x)),
        bool(float(cross(x, y) @ axis.direction) > 0.0),
    )


def _tidy(factor: float) -> float:
    return 1.0 if abs(factor - 1.0) < FLAT else factor


def _along(spindle: Spindle, setting: Setting, values: NDArray[np.float64]) -> NDArray[np.float64]:
    """Axial distances of the primitive's z `values`, snapped where the axis is parallel to one of the family's."""
    at = spindle.base + spindle.rise * values
    placed = setting.placed
    if placed.family is None or placed.axis_of_z < 0:
        return at
    column = setting.to_working(np.eye(3)[placed.axis_of_z])
    sign = 1.0 if float(column @ spindle.axis.direction) > 0.0 else -1.0
    return np.array([sign * placed.family.snap(placed.axis_of_z, sign * float(value)) for value in at])


def turned_solid(
    setting: Setting, spindle: Spindle, loops: list[Loop], surface_of: Callable[[int], int] | None, angle: float = 360.0
) -> Manifold:
    """Loops of (radius, axial distance), counter-clockwise, turned about the spindle's axis.

    surface_of: the surface's id for every profile edge; None where lathe_surface is to tell it from the edge.
    """
    axis = spindle.axis
    is_closed = angle >= 360.0
    cosine, sine = unit_circle() if is_closed else _arc(spindle, angle)
    turned = turn(loops, len(cosine), is_closed=is_closed)
    profile = np.concatenate(loops)
    radius, height = profile[turned.ring, 0], profile[turned.ring, 1]
    out = cosine[turned.step][:, None] * axis.x + sine[turned.step][:, None] * axis.y
    points = axis.point + height[:, None] * axis.direction + radius[:, None] * out
    surface = np.empty(len(turned.triangles), np.int64)
    following = np.concatenate([np.roll(np.arange(len(loop)), -1) + first for first, loop in _numbered(loops)])
    for edge in np.unique(turned.edge[turned.edge >= 0]):
        if surface_of is not None:
            surface[turned.edge == edge] = surface_of(int(edge))
        else:
            surface[turned.edge == edge] = lathe_surface(
                setting.table,
                spindle.axis_id,
                profile[edge],
                profile[following[edge]],
                float(np.ptp(profile, axis=0).max()),
            )
    caps = turned.edge < 0
    if caps.any():
        for cap, which in ((START_CAP, 0), (END_CAP, -1)):
            normal = cosine[which] * axis.y - sine[which] * axis.x
            own = turned.edge == cap
            surface[own] = setting.table.plane(normal, 0.0, through=points[turned.triangles[own].ravel()])
    return setting.solid(points, turned.triangles, surface)


def _numbered(loops: list[Loop]) -> list[tuple[int, Loop]]:
    starts = np.cumsum([0, *(len(loop) for loop in loops)])
    return [(int(start), loop) for start, loop in zip(starts, loops)]


def lathe_surface(
    table: SurfaceTable, axis_id: int, start: NDArray[np.float64], end: NDArray[np.float64], size: float
) -> int:
    """Id of what the profile edge from (radius, axial distance) `start` to `end` turns into."""
    (r0, z0), (r1, z1) = start, end
    axis = table.axes[axis_id]
    if abs(z1 - z0) <= FLAT * size:
        return table.plane(axis.direction, float(z0 + axis.direction @ axis.point))
    if abs(r1 - r0) <= FLAT * size:
        return table.cylinder(axis_id, float(r0))
    slope = float((r1 - r0) / (z1 - z0))
    return table.cone(axis_id, float(z0 - r0 / slope), slope)


def _arc(spindle: Spindle, angle: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(cos, sin) of a part turn: its two ends and the full turn's angles between them."""
    first = spindle.start if spindle.is_forward else spindle.start - math.radians(angle)
    last = first + math.radians(angle)
    step = 2.0 * math.pi / SEGMENTS_PER_TURN
    inner = np.arange(math.floor(first / step) + 1, math.ceil(last / step))
    inner = inner[(inner * step - first > 1e-3 * step) & (last - inner * step > 1e-3 * step)]
    cosine, sine = unit_circle()
    ends = np.array([_sharp(math.cos(first)), _sharp(math.cos(last))])
    ends_sine = np.array([_sharp(math.sin(first)), _sharp(math.sin(last))])
    return (
        np.concatenate([ends[:1], cosine[inner % SEGMENTS_PER_TURN], ends[1:]]),
        np.concatenate([ends_sine[:1], sine[inner % SEGMENTS_PER_TURN], ends_sine[1:]]),
    )


def _sharp(value: float) -> float:
    """A sine or cosine with rounding noise about 0 and 1 taken off."""
    for exact in (0.0, 1.0, -1.0):
        if abs(value - exact) < 1e-15 * 8:
            return exact
    return value


def _lathe(loops: list[Loop], setting: Setting, angle: float = 360.0) -> Manifold:
    """Profile loops of (radius, z) in the primitive's own position, counter-clockwise, turned about z."""
    if not _is_round(setting.placed.linear):
        return _faceted_lathe(loops, setting, SEGMENTS_PER_TURN, angle, curved="a stretched or sheared round surface")
    spindle = _spindle(setting)
    size = max(float(np.ptp(np.concatenate(loops), axis=0).max()), 1e-300)
    mapped = []
    for loop in loops:
        radius = np.array([_canonical_radius(setting, spindle, value) for value in loop[:, 0] * spindle.stretch])
        radius[loop[:, 0] <= FLAT * size] = 0.0
        points = np.stack([radius, _along(spindle, setting, loop[:, 1])], axis=1)
        still_thick(loop, points)
        mapped.append(points if spindle.rise > 0.0 else points[::-1])
    return turned_solid(setting, spindle, mapped, None, angle)


def _canonical_radius(setting: Setting, spindle: Spindle, radius: float) -> float:
    """The radius of the table's cylinder about the axis that is within the tolerance, or `radius`."""
    known = setting.table.find_cylinder(spindle.axis_id, radius)
    return radius if known is None else known


def _faceted_lathe(loops: list[Loop], setting: Setting, facets: int, angle: float, curved: str | None) -> Manifold:
    """Turned in the primitive's own position and then mapped; curved: the reason, None where facets are meant flat."""
    is_closed = angle >= 360.0
    if is_closed:
        cosine, sine = unit_circle(facets)
    else:
        steps = max(1, math.ceil(facets * angle / 360.0 - 1e-9))
        angles = np.radians(angle) * np.arange(steps + 1) / steps
        cosine, sine = np.cos(angles), np.sin(angles)
    turned = turn(loops, len(cosine), is_closed=is_closed)
    profile = np.concatenate(loops)
    radius, height = profile[turned.ring, 0], profile[turned.ring, 1]
    local = np.stack([radius * cosine[turned.step], radius * sine[turned.step], height], axis=1)
    points = setting.to_working(local @ setting.placed.linear.T + setting.placed.origin)
    following = np.concatenate([np.roll(np.arange(len(loop)), -1) + first for first, loop in _numbered(loops)])
    rises = np.abs(profile[following, 1] - profile[:, 1]) > FLAT * float(np.ptp(profile, axis=0).max())
    edge = turned.edge
    curved_edge = (edge >= 0) & rises[edge]
    group = np.where(edge < 0, edge, edge + 2)
    if curved is None:
        group = np.where(
            curved_edge, (edge + 2) * (facets + 2) + _facet_of(turned.triangles, turned.step, facets), group
        )
        surface = flat_faces(setting.table, points, turned.triangles, group)
    else:
        surface = np.empty(len(edge), np.int64)
        surface[~curved_edge] = flat_faces(setting.table, points, turned.triangles[~curved_edge], group[~curved_edge])
        for number in np.unique(edge[curved_edge]):
            surface[edge == number] = setting.table.other(curved)
    return setting.solid(points, turned.triangles, surface, inside_out=setting.mirrors)


def _facet_of(triangles: NDArray[np.int64], step: NDArray[np.int64], facets: int) -> NDArray[np.int64]:
    """(m,) which sector every triangle is in: the lower of its two steps, the last sector wrapping round to 0."""
    steps = step[triangles]
    low, high = steps.min(axis=1), steps.max(axis=1)
    return np.where((low == 0) & (high == facets - 1) & (facets > 2), facets, np.maximum(low, high - 1))


def build_cylinder(cylinder: Cylinder, setting: Setting) -> Manifold:
    """Cylinder; elliptical where the placement stretches it across."""
    positive(radius=cylinder.radius, height=cylinder.height)
    r, h = cylinder.radius, cylinder.height
    return _lathe([np.array([[0.0, 0.0], [r, 0.0], [r, h], [0.0, h]])], setting)


def build_cone(cone: Cone, setting: Setting) -> Manifold:
    """Cone, or frustum of a cone."""
    bottom, top, h = cone.bottom_radius, cone.top_radius, cone.height
    positive(height=h, larger_radius=max(bottom, top))
    if min(bottom, top) < 0.0:
        raise NotSolidError(f"a radius is {min(bottom, top):g}, expected none below 0")
    profile = [[0.0, 0.0], [bottom, 0.0], [top, h], [0.0, h]]
    if bottom == 0.0:
        profile = profile[1:]
    elif top == 0.0:
        profile = profile[:3]
    return _lathe([np.array(profile)], setting)


def build_revolution(revolution: Revolution, setting: Setting) -> Manifold:
    """Profile turned through 360 degrees or less; NotSolidError where it crosses the axis."""
    if not 0.0 < revolution.angle <= 360.0:
        raise NotSolidError(f"its angle is {revolution.angle:g}, expected more than 0 and at most 360 degrees")
    loops = [np.asarray(loop, dtype=np.float64) for loop in revolution.loops]
    if min(float(loop[:, 0].min()) for loop in loops) < 0.0:
        raise NotSolidError("its profile crosses the axis, expected x >= 0 throughout")
    if revolution.facets > 0:
        return _faceted_lathe(loops, setting, revolution.facets, revolution.angle, curved=None)
    return _lathe(loops, setting, revolution.angle)


def build_sphere(sphere: Sphere, setting: Setting) -> Manifold:
    """Sphere, its rows of facets about the placement's z axis."""
    positive(radius=sphere.radius)
    # a quarter circle by exact symmetry: row k of SPHERE_ROWS stands at the angle k of a half turn
    cosine, sine = unit_circle(2 * SPHERE_ROWS)
    rows = np.stack([sine[: SPHERE_ROWS + 1], -cosine[: SPHERE_ROWS + 1]], axis=1)
    rows[[0, -1], 0] = 0.0
    if not _is_similar(setting.placed.linear):
        loop = rows * sphere.radius
        return _faceted_lathe([loop], setting, SEGMENTS_PER_TURN, 360.0, curved="a stretched or sheared sphere")
    spindle, centre_at = _centred(setting)
    axis = spindle.axis
    number = setting.table.sphere(axis.point + centre_at * axis.direction, sphere.radius * spindle.stretch)
    radius = setting.table.surfaces[number].radius  # type: ignore[union-attr]
    loop = rows * radius + np.array([0.0, centre_at])
    return turned_solid(setting, spindle, [loop], lambda _: number)


def build_torus(torus: Torus, setting: Setting) -> Manifold:
    """Torus; NotSolidError where its tube closes the hole."""
    positive(minor_radius=torus.minor_radius, major_radius=torus.major_radius)
    if torus.minor_radius >= torus.major_radius:
        raise NotSolidError(
            f"its minor radius {torus.minor_radius:g} is not less than its major radius {torus.major_radius:g}"
        )
    circle = np.stack(unit_circle(TUBE_SEGMENTS), axis=1)
    if not _is_similar(setting.placed.linear):
        loop = circle * torus.minor_radius + np.array([torus.major_radius, 0.0])
        return _faceted_lathe([loop], setting, SEGMENTS_PER_TURN, 360.0, curved="a stretched or sheared torus")
    spindle, centre_at = _centred(setting)
    major, minor = torus.major_radius * spindle.stretch, torus.minor_radius * spindle.stretch
    number = setting.table.torus(spindle.axis_id, centre_at, major, minor)
    surface = setting.table.surfaces[number]
    loop = circle * surface.minor_radius + np.array([surface.major_radius, centre_at])  # type: ignore[union-attr]
    return turned_solid(setting, spindle, [loop], lambda _: number)


def _centred(setting: Setting) -> tuple[Spindle, float]:
    """The spindle of a primitive that is centred at its origin, and its centre's axial distance."""
    spindle = _spindle(setting)
    return spindle, float(_along(spindle, setting, np.zeros(1))[0])
