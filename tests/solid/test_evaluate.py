"""Evaluated trees against closed forms and numeric integration."""

from __future__ import annotations

import math

import numpy as np
import pytest
from trees import at, difference, evaluated, intersection, turned, union

from kernel.csg.tree import (
    Block,
    Boolean,
    Cone,
    Cylinder,
    Extrusion,
    Hull,
    Polyhedron,
    Revolution,
    Sphere,
    Torus,
    Wedge,
)
from kernel.errors import GeometryError, Place
from kernel.solid.surfaces import CylinderSurface, FacetedSurface, Plane, signed_distance

RECTANGLE = (np.array([[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]]),)
SQUARE_RING = (
    np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [0.0, 4.0]]),
    np.array([[1.0, 1.0], [1.0, 3.0], [3.0, 3.0], [3.0, 1.0]]),
)
TETRAHEDRON = Polyhedron(
    points=np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]),
    faces=((0, 1, 2), (0, 2, 3), (0, 3, 1), (1, 3, 2)),
)

CLOSED_FORMS = {
    "block": (Block(size=(1, 2, 3)), 6.0),
    "wedge": (Wedge(size=(1, 2, 3)), 3.0),
    "cylinder": (Cylinder(radius=2, height=5), 20 * math.pi),
    "cylinder stretched along its axis": (
        Cylinder(radius=2, height=5, placement=np.diag([1.0, 1, 3, 1])),
        60 * math.pi,
    ),
    "frustum": (Cone(bottom_radius=2, top_radius=1, height=5), 35 * math.pi / 3),
    "blunt needle": (Cone(bottom_radius=2, top_radius=0.01, height=5), 5 * math.pi / 3 * 4.0201),
    "cone": (Cone(bottom_radius=2, top_radius=0, height=5), 20 * math.pi / 3),
    "cone on its tip": (Cone(bottom_radius=0, top_radius=2, height=5), 20 * math.pi / 3),
    "pipe": (
        difference(Cylinder(radius=2, height=5), Cylinder(radius=1.9, height=7, placement=at(z=-1))),
        5 * math.pi * (4 - 1.9**2),
    ),
    "plate with two holes": (
        difference(
            Block(size=(40, 20, 1)),
            Cylinder(radius=3, height=3, placement=at(10, 10, -1)),
            Cylinder(radius=2, height=1, placement=at(30, 10, 0)),
        ),
        800 - 13 * math.pi,
    ),
    "extruded frame": (Extrusion(loops=SQUARE_RING, height=2), 24.0),
    "pyramid": (Extrusion(loops=SQUARE_RING[:1], height=3, scale=(0.0, 0.0)), 16.0),
    "frustum of a pyramid in two layers": (
        Extrusion(loops=SQUARE_RING[:1], height=3, scale=(0.5, 0.5), slices=2),
        16 + 4 + 8,
    ),
    "ring turned": (Revolution(loops=RECTANGLE), 3 * math.pi),
    "quarter ring": (Revolution(loops=RECTANGLE, angle=90.0), 0.75 * math.pi),
    "ring of 200 degrees, placed upside down": (
        Revolution(loops=RECTANGLE, angle=200.0, placement=at(linear=np.diag([1.0, 1.0, -1.0]))),
        3 * math.pi * 200 / 360,
    ),
    "hexagonal ring": (Revolution(loops=RECTANGLE, facets=6), 3 * 6 * math.sqrt(3) / 4),
    "tetrahedron": (TETRAHEDRON, 1 / 6),
    "tetrahedron inside out": (
        Polyhedron(points=TETRAHEDRON.points, faces=tuple(face[::-1] for face in TETRAHEDRON.faces)),
        1 / 6,
    ),
    "slot as a hull": (
        Hull(members=(Cylinder(radius=1, height=2), Cylinder(radius=1, height=2, placement=at(x=4)))),
        2 * math.pi + 16,
    ),
}


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_true_volume_is_the_closed_form(name: str) -> None:
    node, volume = CLOSED_FORMS[name]
    assert evaluated(node).solid.true_volume == pytest.approx(volume, rel=1e-9)


@pytest.mark.parametrize(
    ("node", "volume", "area"),
    [
        (Sphere(radius=3), 36 * math.pi, 36 * math.pi),
        (Torus(major_radius=5, minor_radius=2), 40 * math.pi**2, 40 * math.pi**2),
        (
            difference(Sphere(radius=3), Block(size=(6, 6, 3), placement=at(-3, -3, -3))),
            18 * math.pi,
            18 * math.pi + 9 * math.pi,
        ),
    ],
    ids=["sphere", "torus", "half a sphere"],
)
def test_doubly_curved_solids_are_near_as_facets_and_exact_with_slivers(node, volume, area) -> None:
    from kernel.solid.brep import brep_of

    solid = evaluated(node).solid
    assert solid.volume == pytest.approx(volume, rel=1.5e-3)
    assert solid.true_volume == pytest.approx(volume, rel=1e-9)
    assert sum(face.area for face in brep_of(solid).faces) == pytest.approx(area, rel=1e-9)


def test_a_drilled_pipe_has_the_volume_that_numeric_integration_gives() -> None:
    outer, inner, hole = 10.0, 9.0, 3.0
    drill = Cylinder(radius=hole, height=30, placement=at(0, 0, 25, turned([0, 1, 0], 90)))
    pipe = difference(Cylinder(radius=outer, height=50), Cylinder(radius=inner, height=52, placement=at(z=-1)), drill)
    # material under the hole: over the disc y^2 + z^2 < hole^2, the wall from sqrt(inner^2 - y^2) to outer's
    nodes, weights = np.polynomial.legendre.leggauss(200)
    angle = 0.5 * math.pi * nodes
    y = hole * np.sin(angle)
    wall = np.sqrt(outer**2 - y**2) - np.sqrt(inner**2 - y**2)
    drilled = float(np.sum(weights * 0.5 * math.pi * hole * np.cos(angle) * 2 * hole * np.cos(angle) * wall))
    expected = math.pi * 50 * (outer**2 - inner**2) - drilled
    assert evaluated(pipe).solid.true_volume == pytest.approx(expected, rel=1e-6)


def test_two_equal_crossing_cylinders_meet_in_the_steinmetz_solid() -> None:
    rods = intersection(
        Cylinder(radius=1, height=4, placement=at(z=-2)),
        Cylinder(radius=1, height=4, placement=at(x=-2, linear=turned([0, 1, 0], 90))),
    )
    assert evaluated(rods).solid.true_volume == pytest.approx(16 / 3, rel=1e-5)


def test_a_twisted_bar_keeps_its_section() -> None:
    bar = Extrusion(loops=SQUARE_RING[:1], height=3, twist=90, slices=20)
    solid = evaluated(bar).solid
    assert solid.volume == pytest.approx(48, rel=2e-3)
    assert any(isinstance(solid.surfaces.surfaces[k], FacetedSurface) for k in solid.facets.surface)


@pytest.mark.parametrize("skew", [None, turned([1, 2, 3], 40)])
def test_facet_corners_stand_on_their_surfaces(skew) -> None:
    body = difference(
        union(
            Cylinder(radius=20, height=50, placement=at(linear=skew)),
            Cone(bottom_radius=30, top_radius=12, height=40, placement=at(5, 5, 5, skew)),
            Sphere(radius=24, placement=at(-30, 0, 0)),
            Torus(major_radius=40, minor_radius=5, placement=at(0, 3, 0, turned([1, 0, 0], 25))),
        ),
        Cylinder(radius=7.3, height=200, placement=at(3, 4, -100)),
        Cylinder(radius=6.1, height=200, placement=at(-100, 0, 0, turned([0, 1, 0], 90))),
    )
    result = evaluated(body)
    facets, table = result.solid.facets, result.surfaces
    for number in np.unique(facets.surface):
        surface = table.surfaces[number]
        corners = facets.vertices[np.unique(facets.triangles[facets.surface == number])]
        off = np.abs(signed_distance(surface, corners)).max() / result.size
        # where two curved faces cross, a corner lies on a chord of one of them: within its sagitta
        assert off < (1e-9 if isinstance(surface, Plane) else 1e-3)


def test_corners_of_a_primitive_alone_are_on_its_surface_to_rounding() -> None:
    solid = evaluated(Cylinder(radius=20, height=50, placement=at(1e3, -2e3, 5, turned([1, 2, 3], 40)))).solid
    side = next(k for k in np.unique(solid.facets.surface) if isinstance(solid.surfaces.surfaces[k], CylinderSurface))
    corners = solid.facets.vertices[solid.facets.triangles[solid.facets.surface == side].ravel()]
    assert np.abs(signed_distance(solid.surfaces.surfaces[side], corners)).max() < 1e-9 * solid.size


def test_touching_blocks_are_one_body_with_joined_faces() -> None:
    from kernel.solid.brep import brep_of

    solid = evaluated(union(Block(size=(1, 1, 1)), Block(size=(2, 1, 1), placement=at(x=1)))).solid
    assert len(solid.components()) == 1
    assert sorted(round(face.area, 12) for face in brep_of(solid).faces) == [1, 1, 3, 3, 3, 3]


def test_six_digit_gaps_close() -> None:
    third = union(Block(size=(333.333, 10, 10)), Block(size=(333.333, 10, 10), placement=at(x=333.334)))
    for language, count in (("openscad", 1), ("json", 2)):
        solid = evaluated(third, language).solid
        assert len(solid.components()) == solid.count_components() == count


def test_a_row_of_closed_rooms_is_one_body_however_many_voids_it_has() -> None:
    rooms = [Block(size=(8, 8, 8), placement=at(1 + 9 * k, 1, 1)) for k in range(40)]
    row = evaluated(difference(Block(size=(361, 10, 10)), *rooms)).solid
    apart = evaluated(union(*(Block(size=(8, 8, 8), placement=at(9 * k, 0, 0)) for k in range(40)))).solid
    assert (row.count_components(), apart.count_components()) == (1, 40)
    assert (len(row.components()), len(apart.components())) == (1, 40)


def test_voids_belong_to_their_shell() -> None:
    hollow = difference(Block(size=(10, 10, 10)), Sphere(radius=3, placement=at(5, 5, 5)))
    other = Block(size=(1, 1, 1), placement=at(20, 0, 0))
    inner = Block(size=(1, 1, 1), placement=at(5, 5, 5))
    whole = evaluated(union(hollow, other, inner)).solid
    parts = whole.components()
    assert whole.count_components() == 3
    assert sorted(round(part.true_volume, 6) for part in parts) == [1.0, 1.0, round(1000 - 36 * math.pi, 6)]


def test_a_sheared_cylinder_becomes_facets_between_planes() -> None:
    shear = np.array([[1.0, 0, 0.5], [0, 1, 0], [0, 0, 1]])
    result = evaluated(Cylinder(radius=2, height=5, placement=at(linear=shear)))
    kinds = sorted(type(result.surfaces.surfaces[k]).__name__ for k in np.unique(result.solid.facets.surface))
    assert kinds == ["FacetedSurface", "Plane", "Plane"]
    assert result.solid.volume == pytest.approx(20 * math.pi, rel=1e-3)


def test_a_sheared_block_keeps_planes() -> None:
    shear = np.array([[1.0, 0.2, 0.5], [0, 1, 0], [0, 0, 1]])
    result = evaluated(Block(size=(1, 2, 3), placement=at(linear=shear)))
    assert result.solid.volume == pytest.approx(6.0, rel=1e-12)
    assert all(isinstance(result.surfaces.surfaces[k], Plane) for k in result.solid.facets.surface)


def test_a_mirrored_wedge_is_not_inside_out() -> None:
    mirrored = Wedge(size=(1, 2, 3), placement=at(linear=np.diag([-1.0, 1.0, 1.0])))
    assert evaluated(mirrored).solid.volume == pytest.approx(3.0)


def test_a_rotated_frame_is_evaluated_square() -> None:
    rotation = turned([1, 2, 3], 40)
    frame = union(
        Block(size=(100, 5, 5), placement=at(linear=rotation)),
        Block(size=(5, 5, 80), placement=at(*(rotation @ [0, 0, 5]), rotation)),
        Cylinder(radius=1, height=3, placement=at(50, 50, 50)),
    )
    result = evaluated(frame)
    assert np.abs(result.frame @ result.frame.T - np.eye(3)).max() < 1e-12
    blocks = np.isin(result.solid.facets.source, [0, 1])
    normals = np.abs(result.solid.facets.normals[blocks])
    assert set(np.unique(normals)) == {0.0, 1.0}
    world = result.solid.facets.vertices @ result.frame.T
    assert np.abs(world - np.zeros(3)).sum(axis=1).min() < 1e-12


def test_triangles_lead_back_to_their_primitive() -> None:
    result = evaluated(difference(Block(size=(10, 10, 1)), Cylinder(radius=2, height=5, placement=at(5, 5, -1))))
    facets = result.solid.facets
    kinds = {result.leaves[k].kind for k in facets.source[facets.surface == facets.surface.max()]}
    assert kinds == {"cylinder"}


def test_parts_of_the_tree_are_evaluated_in_the_same_frame_and_table() -> None:
    inner = difference(Block(size=(4, 4, 4)), Cylinder(radius=1, height=4, placement=at(2, 2, 0)))
    root = union(inner, Block(size=(1, 1, 9), placement=at(x=4)))
    result = evaluated(root)
    assert result.solid_of(inner).true_volume == pytest.approx(64 - 4 * math.pi)
    assert result.solid_of(inner) is result.solid_of(inner)
    assert result.solid_of_operands("union", inner.children).volume == pytest.approx(64.0)
    assert result.solid_of(inner).surfaces is result.surfaces


def test_a_tree_a_thousand_deep_is_evaluated() -> None:
    node = Block(size=(1, 1, 1))
    for k in range(1, 1000):
        operation = "union" if k % 7 else "difference"
        other = Block(size=(1, 1, 1), placement=at(x=k if k % 7 else -5 * k))
        node = Boolean(operation=operation, children=(node, other))
    assert evaluated(node).solid.volume == pytest.approx(1000 - 142)


HERE = Place("model.csg", 3, 5)


@pytest.mark.parametrize(
    ("node", "message"),
    [
        (Block(size=(0, 1, 1), place=HERE), "model.csg:3:5: the block at / is no solid: its x size is 0, expected"),
        (Cylinder(radius=-1, height=1, place=HERE), "its radius is -1, expected a positive number"),
        (Cone(bottom_radius=0, top_radius=0, height=1, place=HERE), "its larger radius is 0"),
        (Torus(major_radius=1, minor_radius=2, place=HERE), "is not less than its major radius"),
        (Sphere(radius=float("nan"), place=HERE), "its radius is nan, expected finite numbers"),
        (Block(size=(1, 1, 1), placement=at(linear=np.diag([1.0, 1, 0])), place=HERE), "its placement flattens it"),
        (Block(size=(1, 1, 1), placement=at(x=float("inf")), place=HERE), "its placement is not finite"),
        (
            Polyhedron(points=TETRAHEDRON.points, faces=TETRAHEDRON.faces[:3], place=HERE),
            "its surface is not closed, or not consistently oriented",
        ),
        (Polyhedron(points=TETRAHEDRON.points, faces=((0, 1, 9),), place=HERE), "a face names point 9"),
        (Revolution(loops=(np.array([[-1.0, 0], [1, 0], [1, 1]]),), place=HERE), "crosses the axis"),
        (
            Boolean(operation="difference", children=(Block(size=(1, 1, 1)), Block(size=(1, 1, 1))), place=HERE),
            "model.csg:3:5: the difference at / is empty, expected a solid",
        ),
        (
            union(
                Boolean(
                    operation="intersection",
                    children=(Block(size=(1, 1, 1)), Block(size=(1, 1, 1), placement=at(x=3))),
                    name="GAP",
                    place=HERE,
                ),
                difference(Block(size=(1, 1, 1)), Block(size=(2, 2, 2))),
            ),
            "model.csg:3:5: the intersection at 0 (GAP) is empty, expected a solid",
        ),
    ],
)
def test_what_is_no_solid_is_refused_with_its_place(node, message: str) -> None:
    with pytest.raises(GeometryError) as raised:
        evaluated(node)
    assert message in str(raised.value)


def test_the_working_frame_is_that_of_most_volume_however_far_a_slender_bar_reaches() -> None:
    """The brace's box along the axes is many times its volume; the frame's bars hold more of it."""
    brace = Block(size=(30, 30, 1350), placement=at(20, 5, 20, turned((0, 1, 0), 45)))
    bars = union(Block(size=(3040, 40, 40)), Block(size=(40, 40, 1000)), brace)
    assert np.array_equal(evaluated(bars).frame, np.eye(3))
