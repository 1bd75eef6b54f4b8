"""Each primitive of the CSG tree as a tracked manifold, its faces on canonical surfaces.

Flat-faced primitives may be placed by any affine map. What turns about an axis stays analytic where the map keeps it
round (similar, or only stretched along the axis for cylinders and cones); otherwise its curved faces are facets.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from manifold3d import Manifold
from numpy.typing import NDArray

from kernel.csg.tree import (
    Block,
    Cone,
    Cylinder,
    Extrusion,
    Polyhedron,
    Primitive,
    Revolution,
    Sphere,
    Torus,
    Wedge,
)
from kernel.solid.flat import flat_faces, polyhedron_mesh
from kernel.solid.frame import SQUARE, Placed
from kernel.solid.lathe import END_CAP, SEGMENTS_PER_TURN, START_CAP, Loop, layer, turn, unit_circle
from kernel.solid.surfaces import Axis
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import NotSolidError, tracked_manifold

SPHERE_ROWS = 80
"""Rows of facets from pole to pole; with 96 around, a sphere's facets enclose .9989 of its volume."""

TUBE_SEGMENTS = 96
"""Facets around a torus's tube."""

FLAT = 1e-12
"""A profile edge whose rise (or whose change of radius) is below this share of the profile's size has none."""

BLOCK_TRIANGLES = np.array(
    [[0, 4, 6], [0, 6, 2], [1, 3, 7], [1, 7, 5], [0, 1, 5], [0, 5, 4], [2, 6, 7], [2, 7, 3], [0, 2, 3], [0, 3, 1],
     [4, 5, 7], [4, 7, 6]]
)  # fmt: skip
"""Corner k of a block stands at x: k & 1, y: k & 2, z: k & 4; two triangles a side in the order -x +x -y +y -z +z."""


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """Where a primitive is built: the table, its placement, its index among the primitives."""

    table: SurfaceTable
    placed: Placed
    source: int

    def to_working(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Points (n, 3) or (3,) from the family's coordinates to the working frame."""
        return points if self.placed.family is None else self.placed.family.to_working(points)

    @property
    def mirrors(self) -> bool:
        """The placement turns the inside out."""
        return float(np.linalg.det(self.placed.linear)) < 0.0

    def solid(
        self,
        vertices: NDArray[np.float64],
        triangles: NDArray[np.int64],
        surface: NDArray[np.int64],
        *,
        inside_out: bool = False,
    ) -> Manifold:
        """The tracked manifold of this primitive."""
        return tracked_manifold(self.table, vertices, triangles, surface, self.source, inside_out=inside_out)

    def flat(self, vertices: NDArray[np.float64], triangles: NDArray[np.int64], group: NDArray[np.int64]) -> Manifold:
        """Vertices in the family's coordinates; triangles of one group make one flat face."""
        points = self.to_working(vertices)
        surface = flat_faces(self.table, points, triangles, group)
        return self.solid(points, triangles, surface, inside_out=self.mirrors)


def build(primitive: Primitive, setting: Setting) -> Manifold:
    """The primitive as a tracked manifold. NotSolidError: it has no volume, or its faces do not close."""
    linear = setting.placed.linear
    if not (np.isfinite(linear).all() and np.isfinite(setting.placed.origin).all()):
        raise NotSolidError("its placement is not finite")
    scale = np.linalg.norm(linear, axis=0)
    if abs(float(np.linalg.det(linear))) <= FLAT * float(np.prod(scale)):
        raise NotSolidError("its placement flattens it")
    builder = _BUILDERS.get(type(primitive))
    if builder is None:
        raise NotSolidError(f"a {primitive.kind} cannot be built from a placement alone")
    return builder(primitive, setting)


def _positive(**sizes: float) -> None:
    for name, size in sizes.items():
        if not 0.0 < size < math.inf:
            raise NotSolidError(f"its {name.replace('_', ' ')} is {size:g}, expected a positive number")


# ---- flat faces


def _block(block: Block, setting: Setting) -> Manifold:
    _positive(x_size=block.size[0], y_size=block.size[1], z_size=block.size[2])
    corners = np.array([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)]) * np.array(block.size)
    group = np.repeat(np.arange(6), 2)
    placed = setting.placed
    points = corners @ placed.linear.T + placed.origin
    if placed.is_square and placed.family is not None:
        points = _snap_columns(setting, points, corners)
        if placed.family.is_main:
            return _square_block(points, setting)
    return setting.flat(points, BLOCK_TRIANGLES, group)


def _square_block(points: NDArray[np.float64], setting: Setting) -> Manifold:
    """A block along the working frame's axes: the planes are known without measuring the faces."""
    low, high = points.min(axis=0), points.max(axis=0)
    corners = np.where([[k & 1, k >> 1 & 1, k >> 2 & 1] for k in range(8)], high, low)
    ids = [setting.table.plane(np.eye(3)[axis], float(value[axis])) for axis in range(3) for value in (low, high)]
    return setting.solid(corners, BLOCK_TRIANGLES, np.repeat(ids, 2))


def _snap_columns(setting: Setting, points: NDArray[np.float64], local: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points of a square placement, every coordinate snapped; equal local coordinates stay equal."""
    placed = setting.placed
    assert placed.family is not None
    snapped = points.copy()
    for column in range(3):
        axis = int(np.argmax(np.abs(placed.linear[:, column])))
        for value in np.unique(local[:, column]):
            rows = local[:, column] == value
            snapped[rows, axis] = placed.family.snap(axis, float(points[rows, axis][0]))
    _still_thick(points, snapped)
    return snapped


def _still_thick(points: NDArray[np.float64], snapped: NDArray[np.float64]) -> None:
    if ((np.ptp(points, axis=0) > 0.0) & (np.ptp(snapped, axis=0) <= 0.0)).any():
        raise NotSolidError("it is thinner than the precision of the model's coordinates")


def _wedge(wedge: Wedge, setting: Setting) -> Manifold:
    x, y, z = wedge.size
    _positive(x_size=x, y_size=y, z_size=z)
    return _extrude([np.array([[0.0, 0.0], [x, 0.0], [0.0, y]])], z, setting)


def _extrude(loops: list[Loop], height: float, setting: Setting) -> Manifold:
    """A right prism: loops in z=0, swept to z=height."""
    flat = np.concatenate(loops)
    local = np.concatenate([np.insert(flat, 2, 0.0, axis=1), np.insert(flat, 2, height, axis=1)])
    triangles, group = layer(loops, 1)
    placed = setting.placed
    points = local @ placed.linear.T + placed.origin
    if placed.family is not None:
        columns = [2, *(_straight_columns(loops) if placed.is_square else [])]
        points = _snap_faces(setting, points, local, columns, loops)
    return setting.flat(points, triangles, group)


def _straight_columns(loops: list[Loop]) -> list[int]:
    """Columns (0: x, 1: y) along which some edge of the loops stands square, so that it makes a square face."""
    return [column for column in (0, 1) if any(len(_square_points(loop, column)) for loop in loops)]


def _square_points(loop: Loop, column: int) -> NDArray[np.int64]:
    """Indices of the loop's points at an end of an edge along which the column does not change."""
    same = loop[:, column] == np.roll(loop[:, column], -1)
    return np.nonzero(same | np.roll(same, 1))[0]


def _snap_faces(
    setting: Setting,
    points: NDArray[np.float64],
    local: NDArray[np.float64],
    columns: list[int],
    loops: list[Loop],
) -> NDArray[np.float64]:
    """Points of a prism with the coordinates of its square faces snapped, other points left where they are."""
    placed = setting.placed
    assert placed.family is not None
    snapped = points.copy()
    for column in columns:
        axis = int(np.argmax(np.abs(placed.linear[:, column])))
        if column == 2:
            values = np.unique(local[:, 2])
        else:
            values = np.unique(np.concatenate([loop[_square_points(loop, column), column] for loop in loops]))
        for value in values:
            rows = local[:, column] == value
            snapped[rows, axis] = placed.family.snap(axis, float(points[rows, axis][0]))
    _still_thick(points, snapped)
    return snapped


def _extrusion(extrusion: Extrusion, setting: Setting) -> Manifold:
    _positive(height=extrusion.height)
    loops = [np.asarray(loop, dtype=np.float64) for loop in extrusion.loops]
    if extrusion.twist == 0.0 and extrusion.scale == (1.0, 1.0):
        return _extrude(loops, extrusion.height, setting)
    sx, sy = extrusion.scale
    if min(sx, sy) < 0.0 or (min(sx, sy) == 0.0 and max(sx, sy) > 0.0):
        raise NotSolidError(f"its scale is ({sx:g}, {sy:g}), expected two positive factors or two zeros")
    layers = max(int(extrusion.slices), 1)
    to_point = sx == 0.0 and sy == 0.0
    if to_point:
        layers = 1 if extrusion.twist == 0.0 else layers
    flat = np.concatenate(loops)
    levels = []
    for level in range(layers + 1):
        share = level / layers
        if to_point and level == layers:
            levels.append(np.array([[0.0, 0.0, extrusion.height]]))
            continue
        turned = -math.radians(extrusion.twist) * share
        turn_matrix = np.array([[math.cos(turned), -math.sin(turned)], [math.sin(turned), math.cos(turned)]])
        scaled = flat * np.array([1.0 + (sx - 1.0) * share, 1.0 + (sy - 1.0) * share])
        levels.append(np.insert(scaled @ turn_matrix.T, 2, extrusion.height * share, axis=1))
    local = np.concatenate(levels)
    triangles, group = layer(loops, layers, to_point=to_point)
    points = local @ setting.placed.linear.T + setting.placed.origin
    if extrusion.twist != 0.0:
        return _twisted(setting, points, triangles, group)
    if sx == sy:
        group = np.where(group > 1, 2 + (group - 2) % len(flat), group)  # one plane through all layers
    else:
        group = np.where(group > 1, 2 + np.arange(len(group)), group)  # sides are not flat: triangle by triangle
    return setting.flat(points, triangles, group)


def _twisted(
    setting: Setting, points: NDArray[np.float64], triangles: NDArray[np.int64], group: NDArray[np.int64]
) -> Manifold:
    """Flat ends, and one faceted surface for all sides."""
    working = setting.to_working(points)
    surface = np.full(len(triangles), setting.table.other("side of a twisted extrusion"))
    ends = group < 2
    surface[ends] = flat_faces(setting.table, working, triangles[ends], group[ends])
    return setting.solid(working, triangles, surface, inside_out=setting.mirrors)


def _polyhedron(polyhedron: Polyhedron, setting: Setting) -> Manifold:
    placed = setting.placed
    points, triangles, group = polyhedron_mesh(
        np.asarray(polyhedron.points, dtype=np.float64), polyhedron.faces, setting.table.size
    )
    return setting.flat(points @ placed.linear.T + placed.origin, triangles, group)


# ---- what turns about an axis


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
        for axis in range(3):
            if axis != placed.axis_of_z:
                origin[axis] = placed.family.snap(axis, float(origin[axis]))
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
        bool(float(np.cross(x, y) @ axis.direction) > 0.0),
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
        _still_thick(loop, points)
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


def _cylinder(cylinder: Cylinder, setting: Setting) -> Manifold:
    _positive(radius=cylinder.radius, height=cylinder.height)
    r, h = cylinder.radius, cylinder.height
    return _lathe([np.array([[0.0, 0.0], [r, 0.0], [r, h], [0.0, h]])], setting)


def _cone(cone: Cone, setting: Setting) -> Manifold:
    bottom, top, h = cone.bottom_radius, cone.top_radius, cone.height
    _positive(height=h, larger_radius=max(bottom, top))
    if min(bottom, top) < 0.0:
        raise NotSolidError(f"a radius is {min(bottom, top):g}, expected none below 0")
    profile = [[0.0, 0.0], [bottom, 0.0], [top, h], [0.0, h]]
    if bottom == 0.0:
        profile = profile[1:]
    elif top == 0.0:
        profile = profile[:3]
    return _lathe([np.array(profile)], setting)


def _revolution(revolution: Revolution, setting: Setting) -> Manifold:
    if not 0.0 < revolution.angle <= 360.0:
        raise NotSolidError(f"its angle is {revolution.angle:g}, expected more than 0 and at most 360 degrees")
    loops = [np.asarray(loop, dtype=np.float64) for loop in revolution.loops]
    if min(float(loop[:, 0].min()) for loop in loops) < 0.0:
        raise NotSolidError("its profile crosses the axis, expected x >= 0 throughout")
    if revolution.facets > 0:
        return _faceted_lathe(loops, setting, revolution.facets, revolution.angle, curved=None)
    return _lathe(loops, setting, revolution.angle)


def _sphere(sphere: Sphere, setting: Setting) -> Manifold:
    _positive(radius=sphere.radius)
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


def _torus(torus: Torus, setting: Setting) -> Manifold:
    _positive(minor_radius=torus.minor_radius, major_radius=torus.major_radius)
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


_BUILDERS: dict[type, Callable[..., Manifold]] = {
    Block: _block,
    Wedge: _wedge,
    Extrusion: _extrusion,
    Polyhedron: _polyhedron,
    Cylinder: _cylinder,
    Cone: _cone,
    Revolution: _revolution,
    Sphere: _sphere,
    Torus: _torus,
}
