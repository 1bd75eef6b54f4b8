"""OpenSCAD's own primitives: cube, sphere, cylinder, polyhedron in space; square, circle, polygon in the plane."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from kernel.csg.flat import Flat, FlatCircle, FlatLoops
from kernel.csg.outline import circle_polygon, facets_of, ordered_loops
from kernel.csg.parameters import Parameters
from kernel.csg.placement import cosine, place, rotation, sine, translation
from kernel.csg.polyhedra import closed_polyhedron
from kernel.csg.statements import Statement
from kernel.csg.tree import (
    Block,
    Cone,
    CsgNode,
    Cylinder,
    Extrusion,
    Matrix,
    Polyhedron,
    Primitive,
    Sphere,
    frozen_array,
)


def _cube(statement: Statement, source: str, matrix: Matrix) -> CsgNode:
    given = Parameters(statement, source, ("size", "center"))
    x, y, z = given.sizes("size", 3)
    if given.flag("center"):
        matrix = matrix @ translation(-x / 2, -y / 2, -z / 2)
    return place(Block(size=(x, y, z), place=statement.place(source)), matrix)


def _radius(given: Parameters, radius: str, diameter: str) -> float:
    return given.positive(diameter) / 2 if given.has(diameter) else given.positive(radius, 1.0)


def _sphere(statement: Statement, source: str, matrix: Matrix) -> CsgNode:
    given = Parameters(statement, source, ("r",), ("d",))
    radius = _radius(given, "r", "d")
    n_side = facets_of(given.number("$fn", 0.0))
    if not n_side:
        return place(Sphere(radius=radius, place=statement.place(source)), matrix)
    n_ring = (n_side + 1) // 2
    latitudes = [180.0 * (ring + 0.5) / n_ring for ring in range(n_ring)]
    unit = circle_polygon(1.0, n_side)
    points = np.vstack(
        [np.column_stack([unit * radius * sine(a), np.full(n_side, radius * cosine(a))]) for a in latitudes]
    )
    faces = [tuple(reversed(range(n_side))), tuple(range((n_ring - 1) * n_side, n_ring * n_side))]
    for ring in range(n_ring - 1):
        for side in range(n_side):
            upper, next_upper = ring * n_side + side, ring * n_side + (side + 1) % n_side
            faces.append((upper, next_upper, next_upper + n_side, upper + n_side))
    polyhedron = Polyhedron(points=frozen_array(points), faces=tuple(faces), place=statement.place(source))
    return place(polyhedron, matrix)


def _cylinder(statement: Statement, source: str, matrix: Matrix) -> CsgNode:
    given = Parameters(statement, source, ("h", "r1", "r2", "center"), ("r", "d", "d1", "d2"))
    where = statement.place(source)
    height = given.positive("h", 1.0)
    both = _radius(given, "r", "d")
    bottom, top = (
        given.number(diameter) / 2 if given.has(diameter) else given.number(radius, both)
        for radius, diameter in (("r1", "d1"), ("r2", "d2"))
    )
    for radius, value in (("r1", bottom), ("r2", top)):
        if value < 0 or (value == 0 and bottom == top):
            raise given.wrong(radius, "a number over 0" if bottom == top else "a number of 0 or more")
    if given.flag("center"):
        matrix = matrix @ translation(0.0, 0.0, -height / 2)
    n_side = facets_of(given.number("$fn", 0.0))
    primitive: Primitive
    if n_side:
        if bottom == 0:
            matrix = matrix @ translation(0.0, 0.0, height) @ rotation("x", 180.0)
            bottom, top = top, bottom
        loops = (frozen_array(circle_polygon(bottom, n_side)),)
        primitive = Extrusion(loops=loops, height=height, scale=(top / bottom, top / bottom), place=where)
    elif bottom == top:
        primitive = Cylinder(radius=bottom, height=height, place=where)
    else:
        primitive = Cone(bottom_radius=bottom, top_radius=top, height=height, place=where)
    return place(primitive, matrix)


def _polyhedron(statement: Statement, source: str, matrix: Matrix) -> CsgNode:
    given = Parameters(statement, source, ("points", "faces", "convexity"), ("triangles",))
    points = given.points("points", 3)
    faces = given.index_lists("triangles" if given.has("triangles") else "faces", len(points))
    return place(closed_polyhedron(points, faces, statement.place(source)), matrix)


def _plane(matrix: Matrix) -> Matrix:
    """What (4, 4) does in the plane z = 0, as (3, 3)."""
    return matrix[np.ix_((0, 1, 3), (0, 1, 3))]


def _square(statement: Statement, source: str, matrix: Matrix) -> Flat:
    given = Parameters(statement, source, ("size", "center"))
    x, y = given.sizes("size", 2)
    x0, y0 = (-x / 2, -y / 2) if given.flag("center") else (0.0, 0.0)
    loop = frozen_array([(x0, y0), (x0 + x, y0), (x0 + x, y0 + y), (x0, y0 + y)])
    return FlatLoops((loop,), _plane(matrix), statement.place(source), size=(x, y))


def _circle(statement: Statement, source: str, matrix: Matrix) -> Flat:
    given = Parameters(statement, source, ("r",), ("d",))
    return FlatCircle(_radius(given, "r", "d"), _plane(matrix), statement.place(source), given.number("$fn", 0.0))


def _polygon(statement: Statement, source: str, matrix: Matrix) -> Flat:
    given = Parameters(statement, source, ("points", "paths", "convexity"))
    points = given.points("points", 2)
    if len(points) < 3:
        raise given.wrong("points", "three points or more")
    paths = given.index_lists("paths", len(points)) if given.has("paths") else [list(range(len(points)))]
    loops = ordered_loops([points[path] for path in paths])
    if not loops:
        raise given.wrong("points", "an outline that encloses some area")
    return FlatLoops(loops, _plane(matrix), statement.place(source))


SOLID_LEAVES: dict[str, Callable[[Statement, str, Matrix], CsgNode]] = {
    "cube": _cube,
    "sphere": _sphere,
    "cylinder": _cylinder,
    "polyhedron": _polyhedron,
}
FLAT_LEAVES: dict[str, Callable[[Statement, str, Matrix], Flat]] = {
    "square": _square,
    "circle": _circle,
    "polygon": _polygon,
}
