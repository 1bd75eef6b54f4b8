"""Solid: an evaluated body whose every triangle knows its analytic surface, and the Booleans on solids.

Cuts are made by subtracting the complement: intersecting with a half-space where a face already lies on the plane
leaves a two-sided sheet of no thickness.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Protocol

import numpy as np
from manifold3d import Manifold, OpType
from numpy.typing import NDArray

from kernel.csg.tree import frozen_array
from kernel.errors import DefectError
from kernel.solid.facets import Facets, facets_of, joined, shells_of, solid_angle
from kernel.solid.lathe import layer, turn, unit_circle
from kernel.solid.round import lathe_surface
from kernel.solid.slivers import sliver_volume
from kernel.solid.square import BLOCK_TRIANGLES
from kernel.solid.surfaces import Plane, Vector, plane_frame
from kernel.solid.table import SurfaceTable
from kernel.solid.tracked import NotSolidError, check_status, tracked_manifold

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

__all__ = [
    "Facets",
    "Solid",
    "half_space_cut",
    "intersect",
    "prism",
    "subtract",
    "tube",
    "unite",
]


class Frame(Protocol):
    """Anything with two unit vectors and their normal: a Plane, a PlaneFrame, a Section."""

    @property
    def u(self) -> Vector:
        """First direction."""

    @property
    def v(self) -> Vector:
        """Second direction."""

    @property
    def normal(self) -> Vector:
        """u x v."""


@dataclass(frozen=True, eq=False)
class Solid:
    """manifold: the body; surfaces: the table that its triangles' face ids point into. May be empty."""

    manifold: Manifold
    surfaces: SurfaceTable

    @cached_property
    def facets(self) -> Facets:
        """The triangles."""
        return facets_of(self.manifold, self.surfaces)

    @cached_property
    def is_empty(self) -> bool:
        """No triangles at all. DefectError where the Boolean kernel failed."""
        try:
            check_status(self.manifold)
        except NotSolidError as error:
            raise DefectError(f"a Boolean failed: {error}") from error
        return bool(self.manifold.is_empty())

    @cached_property
    def volume(self) -> float:
        """Volume within the facets."""
        return float(self.manifold.volume())

    @cached_property
    def true_volume(self) -> float:
        """Volume within the true surfaces: that of the facets and of the slivers outside (or inside) them."""
        return self.volume + sliver_volume(self.facets, self.surfaces)

    @cached_property
    def area(self) -> float:
        """Area of the facets."""
        return float(self.manifold.surface_area())

    @cached_property
    def bounds(self) -> NDArray[np.float64]:
        """(2, 3) lowest and highest coordinates; zeros where empty."""
        if self.is_empty:
            return frozen_array(np.zeros((2, 3)))
        return frozen_array(np.reshape(self.manifold.bounding_box(), (2, 3)))

    @cached_property
    def size(self) -> float:
        """Diagonal of the bounds."""
        return float(np.linalg.norm(self.bounds[1] - self.bounds[0]))

    def components(self) -> tuple[Solid, ...]:
        """The separate pieces, each with the voids inside it; a piece that touches another by a face is one with it.

        In a stable order: by lowest corner of the bounds, then by volume. Flakes thinner than the table's tolerance,
        which Booleans of skew faces leave, are rounding: they are no components.
        """
        if self.is_empty:
            return ()
        thin = 0.5 * self.surfaces.tolerance
        pieces = [piece for piece in self.manifold.decompose() if abs(piece.volume()) > thin * piece.surface_area()]
        if not pieces:
            return ()
        if len(pieces) == 1:
            return (self,) if pieces[0].volume() == self.volume else (Solid(pieces[0], self.surfaces),)
        shells = [Solid(piece, self.surfaces) for piece in pieces if piece.volume() > 0.0]
        voids = [Solid(piece, self.surfaces) for piece in pieces if piece.volume() < 0.0]
        shells.sort(key=lambda shell: (*shell.bounds.ravel().round(9).tolist(), shell.volume))
        inside: list[list[Manifold]] = [[shell.manifold] for shell in shells]
        for void in voids:
            inside[_shell_of(void, shells)].append(void.manifold)
        return tuple(
            shell if len(group) == 1 else Solid(joined(group), self.surfaces)
            for shell, group in zip(shells, inside, strict=True)
        )

    def flakes(self) -> tuple[Solid, ...]:
        """Pieces thinner than the table's tolerance, which are no components, in the same order."""
        thin = 0.5 * self.surfaces.tolerance
        found = [
            Solid(piece, self.surfaces)
            for piece in self.manifold.decompose()
            if 0.0 < piece.volume() <= thin * piece.surface_area()
        ]
        return tuple(sorted(found, key=lambda flake: (*flake.bounds.ravel().round(9).tolist(), flake.volume)))

    def count_components(self) -> int:
        """How many `components` there are, without making them: for each, and each void, manifold copies all of it."""
        if self.is_empty:
            return 0
        facets = self.facets
        own = shells_of(facets)
        arms = facets.vertices - facets.vertices.mean(axis=0)
        a, b, c = (arms[facets.triangles[:, k]] for k in range(3))
        volume = np.bincount(own, np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0)
        area = np.bincount(own, facets.areas)
        is_piece = np.abs(volume) > 0.5 * self.surfaces.tolerance * area
        return int(np.count_nonzero(is_piece & (volume > 0.0)))


def _shell_of(void: Solid, shells: Sequence[Solid]) -> int:
    """Index of the smallest shell around the void (manifold gives voids back as bodies of their own, inside out)."""
    point = void.facets.vertices[0]
    around = [
        index
        for index, shell in enumerate(shells)
        if (shell.bounds[0] <= void.bounds[0]).all() and (shell.bounds[1] >= void.bounds[1]).all()
    ]
    around.sort(key=lambda index: shells[index].volume)
    for index in around:
        if index == around[-1] or solid_angle(shells[index].facets, point) > 0.5:
            return index
    raise DefectError("a void lies in no shell")


# ---- Booleans


def unite(solids: Sequence[Solid]) -> Solid:
    """Union of one or more solids of one table."""
    return _fold(solids, OpType.Add)


def subtract(solid: Solid, tools: Sequence[Solid]) -> Solid:
    """`solid` less all tools."""
    return _fold([solid, *tools], OpType.Subtract)


def intersect(solids: Sequence[Solid]) -> Solid:
    """What is in every one of the solids."""
    return _fold(solids, OpType.Intersect)


def _fold(solids: Sequence[Solid], operation: OpType) -> Solid:
    if not solids:
        raise DefectError("a Boolean of no solids")
    if len(solids) == 1:
        return solids[0]
    if any(solid.surfaces is not solids[0].surfaces for solid in solids):
        raise DefectError("a Boolean of solids from different surface tables")
    return Solid(Manifold.batch_boolean([solid.manifold for solid in solids], operation), solids[0].surfaces)


# ---- cutters


def half_space_cut(solid: Solid, normal: Vector, offset: float) -> Solid:
    """The part with normal . x >= offset; the cut face has the id of the canonical plane and lies exactly on it."""
    table = solid.surfaces
    plane = table.plane(normal, offset)
    value = table.surfaces[plane]
    assert isinstance(value, Plane)
    if float(np.dot(normal, value.normal)) > 0.0:
        return cut_by(solid, value.normal, value.offset, plane)
    return cut_by(solid, -value.normal, -value.offset, plane)


_SIDES = np.array([(1 if k & 1 else -1, 1 if k & 2 else -1, 0 if k & 4 else 1) for k in range(8)], dtype=np.float64)
"""Of each corner of a half-space's block: the side along u and v, and whether it lies deep below the plane."""


def cut_by(solid: Solid, normal: Vector, offset: float, face: int) -> Solid:
    """The part with normal . x >= offset (unit normal), its cut face given the id `face`."""
    if solid.is_empty:
        return solid
    low, high = solid.bounds
    centre, half = 0.5 * (low + high), 0.5 * (high - low)
    at, reach = float(centre @ normal), float(half @ np.abs(normal))
    if at - reach >= offset:
        return solid
    if at + reach <= offset:
        return Solid(Manifold(), solid.surfaces)
    frame = plane_frame(normal)
    span = 2.0 * float(np.linalg.norm(half))
    depth = (offset - (at - reach)) + span
    foot = centre - normal * (at - offset)
    axis = int(np.argmax(np.abs(normal)))
    corners = (
        foot + frame.u * (span * _SIDES[:, :1]) + frame.v * (span * _SIDES[:, 1:2]) - normal * (depth * _SIDES[:, 2:])
    )
    if abs(normal[axis]) == 1.0:
        corners[4:, axis] = offset * normal[axis]
    surface = np.full(12, face, np.int64)
    below = tracked_manifold(solid.surfaces, corners, BLOCK_TRIANGLES, surface)
    return Solid(solid.manifold - below, solid.surfaces)


def tube(table: SurfaceTable, axis_id: int, inner: float, outer: float, z0: float, z1: float) -> Solid:
    """What lies between the coaxial cylinders `inner` < `outer` (inner 0: a full cylinder), z0 <= z <= z1.

    z: distance along the axis from its point. The cylinders and end planes are those of the table, so that radii
    and ends within its tolerance of known ones become those.
    """
    axis = table.axes[axis_id]
    base = float(axis.direction @ axis.point)
    loop = np.array([[inner, z0], [outer, z0], [outer, z1], [inner, z1]], dtype=np.float64)
    surfaces = [lathe_surface(table, axis_id, loop[k], loop[(k + 1) % 4], 1.0) for k in range(3)]
    surfaces.append(table.cylinder(axis_id, inner) if inner > 0.0 else surfaces[1])
    for column, edges in ((0, (1, 3)), (1, (0, 2))):
        for edge in edges:
            if column == 0 and edge == 3 and inner <= 0.0:
                continue
            value = table.surfaces[surfaces[edge]]
            rows = [edge, (edge + 1) % 4]
            loop[rows, column] = value.offset - base if isinstance(value, Plane) else value.radius  # type: ignore[union-attr]
    cosine, sine = unit_circle()
    turned = turn([loop], len(cosine), is_closed=True)
    out = cosine[turned.step][:, None] * axis.x + sine[turned.step][:, None] * axis.y
    radius, height = loop[turned.ring, 0][:, None], loop[turned.ring, 1][:, None]
    points = axis.point + height * axis.direction + radius * out
    return Solid(tracked_manifold(table, points, turned.triangles, np.array(surfaces)[turned.edge]), table)


def prism(table: SurfaceTable, polygon: Polygon | MultiPolygon, frame: Frame, a: float, b: float) -> Solid:
    """`polygon`, in coordinates (x.u, x.v) of the frame, swept from normal . x = a to b (a < b).

    Every face is a canonical plane of the table. Empty where the polygon is.
    """
    from shapely import get_parts

    parts = [
        _prism_part(table, part, frame, a, b)
        for part in get_parts(polygon)
        if part.geom_type == "Polygon" and part.area > 0.0
    ]
    return unite(parts) if parts else Solid(Manifold(), table)


def _prism_part(table: SurfaceTable, polygon: Polygon, frame: Frame, a: float, b: float) -> Solid:
    from kernel.solid.flat import flat_faces

    rings = [np.asarray(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    loops = [
        np.ascontiguousarray(ring if _signed_area(ring) * (1 if k == 0 else -1) > 0.0 else ring[::-1])[:, :2]
        for k, ring in enumerate(rings)
    ]
    flat = np.concatenate(loops)
    base = flat[:, :1] * frame.u + flat[:, 1:2] * frame.v
    levels = []
    for height in (a, b):
        level = base + frame.normal * height
        axis = int(np.argmax(np.abs(frame.normal)))
        if abs(frame.normal[axis]) == 1.0:
            level[:, axis] = height * frame.normal[axis]
        levels.append(level)
    triangles, group = layer(loops, 1)
    points = np.concatenate(levels)
    return Solid(tracked_manifold(table, points, triangles, flat_faces(table, points, triangles, group)), table)


def _signed_area(ring: NDArray[np.float64]) -> float:
    x, y = ring[:, 0], ring[:, 1]
    return 0.5 * float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)))
