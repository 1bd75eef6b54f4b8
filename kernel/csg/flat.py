"""Two-dimensional shapes as OpenSCAD writes them, and the solids that extruding or turning them gives.

Extruding and turning keep unions, differences and intersections, so a Boolean in the plane becomes the same Boolean
in space, and each square, circle and polygon below it a primitive of its own: a drilled profile stays a block less
true cylinders.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from kernel.csg.outline import FINE_CIRCLE, circle_polygon, facets_of, ordered_loops
from kernel.csg.placement import place, rotation, translation
from kernel.csg.source import MAX_SLICES
from kernel.csg.tree import (
    Block,
    Boolean,
    Cone,
    CsgNode,
    Cylinder,
    Extrusion,
    Hull,
    Matrix,
    Primitive,
    Revolution,
    Sphere,
    Torus,
    frozen_array,
)
from kernel.errors import Place, ReadError

_SNAP = 1e-9


@dataclass(frozen=True, eq=False)
class FlatLoops:
    """A polygon, or a square: loops (n, 2) in its own plane, put there by matrix (3, 3). size: set for a square."""

    loops: tuple[Matrix, ...]
    matrix: Matrix
    place: Place
    size: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class FlatCircle:
    """A circle about the origin of its own plane, put there by matrix (3, 3). fn, fa, fs: as OpenSCAD has them."""

    radius: float
    matrix: Matrix
    place: Place
    fn: float

    @cached_property
    def as_loops(self) -> FlatLoops:
        """The polygon that it stands for, or a fine one."""
        n_side = facets_of(self.fn) or FINE_CIRCLE
        return FlatLoops((frozen_array(circle_polygon(self.radius, n_side)),), self.matrix, self.place)


@dataclass(frozen=True, eq=False)
class FlatBoolean:
    """union, difference, intersection or hull of two or more."""

    operation: str
    children: tuple[Flat, ...]
    place: Place


Flat = FlatLoops | FlatCircle | FlatBoolean
Lift = Callable[[FlatLoops | FlatCircle], CsgNode | None]


@dataclass(frozen=True)
class Extrude:
    """The parameters of linear_extrude: matrix (4, 4) places the result, twist in degrees, slices or None."""

    matrix: Matrix
    place: Place
    height: float
    center: bool
    twist: float
    scale: tuple[float, float]
    slices: int | None
    fn: float
    fa: float
    fs: float

    @property
    def is_straight(self) -> bool:
        """Neither twisted nor tapered."""
        return self.twist == 0.0 and self.scale == (1.0, 1.0)


@dataclass(frozen=True)
class Turn:
    """The parameters of rotate_extrude: matrix (4, 4) places the result, angle in degrees, 360 for a full turn."""

    matrix: Matrix
    place: Place
    angle: float
    fn: float


def extruded(flat: Flat, how: Extrude) -> CsgNode | None:
    """The solid of linear_extrude; None where its shape has no area."""
    matrix = how.matrix @ translation(0.0, 0.0, -how.height / 2) if how.center else how.matrix

    def straight(leaf: FlatLoops | FlatCircle) -> CsgNode | None:
        primitive: Primitive
        if isinstance(leaf, FlatCircle) and not facets_of(leaf.fn):
            primitive = Cylinder(radius=leaf.radius, height=how.height, place=leaf.place)
        elif isinstance(leaf, FlatLoops) and leaf.size is not None:
            primitive = Block(size=(*leaf.size, how.height), place=leaf.place)
        else:
            loops = leaf.as_loops.loops if isinstance(leaf, FlatCircle) else leaf.loops
            if _sheared(leaf.matrix):
                return bent(leaf)
            primitive = Extrusion(loops=loops, height=how.height, place=leaf.place)
        corner = leaf.loops[0][0] if isinstance(leaf, FlatLoops) and leaf.size is not None else (0.0, 0.0)
        return place(primitive, matrix @ _in_space(leaf.matrix) @ translation(corner[0], corner[1], 0.0))

    def bent(leaf: FlatLoops | FlatCircle) -> CsgNode | None:
        if isinstance(leaf, FlatCircle):
            cone = _cone(leaf, how)
            if cone is not None:
                return place(cone, matrix)
            leaf = leaf.as_loops
        loops = _moved(leaf)
        if not loops:
            return None
        return place(
            Extrusion(
                loops=loops,
                height=how.height,
                twist=how.twist,
                scale=how.scale,
                slices=_slices(loops, how),
                place=leaf.place,
            ),
            matrix,
        )

    if how.is_straight:
        return _lifted(flat, straight, keep_hull=True)
    return _lifted(flat, bent, keep_hull=False)


def turned(flat: Flat, how: Turn) -> CsgNode | None:
    """The solid of rotate_extrude; None where its shape has no area. ReadError: the shape crosses the axis."""
    whole = _polygon(flat)
    if whole.is_empty:
        return None
    left, _, right, _ = whole.bounds
    reach = max(abs(left), abs(right))
    if left < -_SNAP * reach and right > _SNAP * reach:
        raise ReadError(
            f"rotate_extrude turns a shape that crosses its axis (x from {left:g} to {right:g}), "
            "expected it on one side of x = 0",
            place=how.place,
        )
    matrix, angle = how.matrix, how.angle
    if angle < 0:
        matrix, angle = matrix @ rotation("z", angle), -angle
    side = np.eye(3)
    if right <= _SNAP * reach:
        side[0, 0] = -1.0
        matrix = matrix @ rotation("z", 180.0)
    facets = facets_of(how.fn) if angle == 360.0 else 0

    def lift(leaf: FlatLoops | FlatCircle) -> CsgNode | None:
        return _turned_leaf(leaf, side, matrix, angle, facets)

    return _lifted(flat, lift, keep_hull=False)


def _turned_leaf(
    leaf: FlatLoops | FlatCircle, side: Matrix, matrix: Matrix, angle: float, facets: int
) -> CsgNode | None:
    local = side @ leaf.matrix
    full = angle == 360.0 and not facets
    if isinstance(leaf, FlatCircle):
        scale = _uniform_scale(local)
        if full and scale is not None and not facets_of(leaf.fn):
            radius, x, z = leaf.radius * scale, float(local[0, 2]), float(local[1, 2])
            lifted = matrix @ translation(0.0, 0.0, z)
            if abs(x) <= _SNAP * radius:
                return place(Sphere(radius=radius, place=leaf.place), lifted)
            if x > radius * (1 + _SNAP):
                return place(Torus(major_radius=x, minor_radius=radius, place=leaf.place), lifted)
        leaf = leaf.as_loops
    loops = _right_of_axis(_moved(FlatLoops(leaf.loops, local, leaf.place)))
    if not loops:
        return None
    if full and len(loops) == 1:
        simple = _cylinder_or_cone(loops[0], leaf.place)
        if simple is not None:
            return place(simple, matrix)
    return place(Revolution(loops=loops, angle=angle, facets=facets, place=leaf.place), matrix)


def _lifted(flat: Flat, leaf: Lift, *, keep_hull: bool) -> CsgNode | None:
    """The tree of `flat` with each leaf lifted; what has no area is left out."""
    if not isinstance(flat, FlatBoolean):
        return leaf(flat)
    if flat.operation == "hull" and not keep_hull:
        hull = _polygon(flat)
        if hull.is_empty:
            return None
        return leaf(FlatLoops(ordered_loops([np.array(hull.exterior.coords)[:-1]]), np.eye(3), flat.place))
    lifted = [_lifted(child, leaf, keep_hull=keep_hull) for child in flat.children]
    if flat.operation == "difference" and lifted[0] is None:
        return None
    if flat.operation == "intersection" and None in lifted:
        return None
    children = tuple(child for child in lifted if child is not None)
    if not children:
        return None
    if flat.operation == "hull":
        return Hull(members=children, place=flat.place)
    if len(children) == 1:
        return children[0]
    return Boolean(operation=flat.operation, children=children, place=flat.place)


def _polygon(flat: Flat) -> Any:
    """The region as a shapely geometry, circles as fine polygons."""
    from shapely import Polygon
    from shapely.ops import unary_union

    if isinstance(flat, FlatCircle):
        flat = flat.as_loops
    if isinstance(flat, FlatLoops):
        region = Polygon()
        for loop in _moved(flat):
            region = region.symmetric_difference(Polygon(loop))
        return region
    regions = [_polygon(child) for child in flat.children]
    if flat.operation == "difference":
        return regions[0].difference(unary_union(regions[1:]))
    if flat.operation == "intersection":
        region = regions[0]
        for other in regions[1:]:
            region = region.intersection(other)
        return region
    joined = unary_union(regions)
    return joined.convex_hull if flat.operation == "hull" else joined


def _moved(leaf: FlatLoops) -> tuple[Matrix, ...]:
    """The loops where the leaf's matrix puts them, wound as they should be."""
    linear, shift = leaf.matrix[:2, :2], leaf.matrix[:2, 2]
    moved = [loop @ linear.T + shift for loop in leaf.loops]
    if np.linalg.det(linear) < 0:
        moved = [loop[::-1] for loop in moved]
    return tuple(frozen_array(loop) for loop in moved)


def _right_of_axis(loops: tuple[Matrix, ...]) -> tuple[Matrix, ...]:
    """What of the region lies at x >= 0, points next to the axis put on it."""
    reach = max(float(np.abs(loop).max()) for loop in loops)
    snapped = [np.array(loop) for loop in loops]
    for loop in snapped:
        loop[np.abs(loop[:, 0]) <= _SNAP * reach, 0] = 0.0
    if all((loop[:, 0] >= 0).all() for loop in snapped):
        return tuple(frozen_array(loop) for loop in snapped)
    from shapely import Polygon, box

    region = Polygon()
    for loop in snapped:
        region = region.symmetric_difference(Polygon(loop))
    region = region.intersection(box(0.0, -2 * reach, 2 * reach, 2 * reach))
    rings: list[Matrix] = []
    for polygon in getattr(region, "geoms", [region]):
        if polygon.geom_type == "Polygon" and not polygon.is_empty:
            rings += [np.array(ring.coords)[:-1] for ring in (polygon.exterior, *polygon.interiors)]
    return ordered_loops(rings) if rings else ()


def _cylinder_or_cone(loop: Matrix, where: Place) -> Primitive | None:
    """The cylinder or cone that turning a triangle or trapezium on the axis gives, else None."""
    on_axis = loop[:, 0] == 0.0
    if len(loop) not in (3, 4) or on_axis.sum() not in (1, 2):
        return None
    low, high = float(loop[:, 1].min()), float(loop[:, 1].max())
    if not np.isin(loop[:, 1], (low, high)).all() or set(loop[on_axis, 1].tolist()) != {low, high}:
        return None
    bottom = float(loop[loop[:, 1] == low, 0].max())
    top = float(loop[loop[:, 1] == high, 0].max())
    placement = translation(0.0, 0.0, low)
    if bottom == top:
        return Cylinder(radius=bottom, height=high - low, placement=placement, place=where)
    return Cone(bottom_radius=bottom, top_radius=top, height=high - low, placement=placement, place=where)


def _cone(circle: FlatCircle, how: Extrude) -> Primitive | None:
    """The cone or cylinder that a circle on the axis gives, evenly scaled and whatever its twist."""
    scale = _uniform_scale(circle.matrix)
    if scale is None or facets_of(circle.fn) or how.scale[0] != how.scale[1]:
        return None
    radius = circle.radius * scale
    if np.abs(circle.matrix[:2, 2]).max() > _SNAP * radius:
        return None
    if how.scale == (1.0, 1.0):
        return Cylinder(radius=radius, height=how.height, place=circle.place)
    return Cone(bottom_radius=radius, top_radius=radius * how.scale[0], height=how.height, place=circle.place)


def _uniform_scale(matrix: Matrix) -> float | None:
    linear = matrix[:2, :2]
    gram = linear.T @ linear
    if abs(gram[0, 1]) > _SNAP * gram[0, 0] or abs(gram[1, 1] - gram[0, 0]) > _SNAP * gram[0, 0]:
        return None
    return float(f"{math.sqrt(gram[0, 0]):.12g}")


def _sheared(matrix: Matrix) -> bool:
    linear = matrix[:2, :2]
    gram = linear.T @ linear
    return bool(abs(gram[0, 1]) > _SNAP * math.sqrt(gram[0, 0] * gram[1, 1]))


def _in_space(matrix: Matrix) -> Matrix:
    """(3, 3) of the plane as (4, 4) of space."""
    lifted = np.eye(4)
    lifted[:2, :2] = matrix[:2, :2]
    lifted[:2, 3] = matrix[:2, 2]
    return lifted


def _slices(loops: tuple[Matrix, ...], how: Extrude) -> int:
    """Layers of a twisted extrusion: as written, else as OpenSCAD's get_helix_slices counts them."""
    if how.slices is not None:
        return how.slices
    twist = abs(how.twist)
    if twist == 0.0:
        return 1
    wanted = twist / 360.0 * how.fn
    if how.fn <= 0:
        radius = max(float(np.linalg.norm(loop, axis=1).max()) for loop in loops)
        arc = math.hypot(math.radians(twist) * radius, how.height)
        wanted = min(twist / how.fa, arc / how.fs)
    wanted = max(wanted, twist / 120.0)
    if wanted > MAX_SLICES:
        raise ReadError(
            f"linear_extrude's twist of {how.twist:g} degrees takes {wanted:.0f} slices, expected at most {MAX_SLICES}",
            place=how.place,
        )
    return max(1, math.ceil(wanted))
