"""Six-digit matrices become exact; scale and mirror go into the primitives without moving a point of the solid."""

import math
from dataclasses import replace

import numpy as np
import pytest
from csg_membership import holds
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.csg.placement import cosine, mended, mended_rigid, place, rotation, sine, translation
from kernel.csg.tree import (
    Block,
    Cone,
    Cylinder,
    Extrusion,
    Polyhedron,
    Revolution,
    Sphere,
    Torus,
    Wedge,
    frozen_array,
)

L_SHAPE = frozen_array([(0, 0), (3, 0), (3, 1), (1, 1), (1, 2), (0, 2)])
RING = frozen_array([(1, 0), (3, 0), (2, 2)])
TETRAHEDRON = Polyhedron(
    points=frozen_array([(0, 0, 0), (3, 0, 0), (0, 2, 0), (0, 0, 4)]),
    faces=((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)),
)
PRIMITIVES = {
    "block": Block(size=(3, 2, 4)),
    "cylinder": Cylinder(radius=2, height=3),
    "cone": Cone(bottom_radius=2, top_radius=1, height=3),
    "wedge": Wedge(size=(3, 2, 4)),
    "sphere": Sphere(radius=2),
    "torus": Torus(major_radius=3, minor_radius=1),
    "extrusion": Extrusion(loops=(L_SHAPE,), height=3),
    "twisted extrusion": Extrusion(loops=(L_SHAPE,), height=3, twist=70, slices=9),
    "tapered extrusion": Extrusion(loops=(L_SHAPE,), height=3, scale=(0.5, 2.0)),
    "revolution": Revolution(loops=(RING,)),
    "partial revolution": Revolution(loops=(RING,), angle=100),
    "polyhedron": TETRAHEDRON,
}
POINTS = np.random.default_rng(7).uniform(-5, 5, (400, 3))

angles = st.floats(-360, 360).map(lambda angle: round(angle, 3))
factors = st.floats(0.25, 4).map(lambda factor: round(factor, 3))
signs = st.sampled_from((1.0, -1.0))


def turned(x: float, y: float, z: float) -> np.ndarray:
    return rotation("z", z) @ rotation("y", y) @ rotation("x", x)


def six_digits(matrix: np.ndarray) -> list[list[float]]:
    return [[float(f"{value:.6g}") for value in row] for row in matrix]


@given(st.floats(-1e4, 1e4))
def test_sine_and_cosine_are_those_of_the_library(angle):
    assert sine(angle) == pytest.approx(math.sin(math.radians(angle)), abs=1e-10)
    assert cosine(angle) == pytest.approx(math.cos(math.radians(angle)), abs=1e-10)


def test_sine_and_cosine_are_exact_where_they_are_rational():
    assert [sine(a) for a in (0, 30, 90, 150, 180, 270, 360, -90)] == [0, 0.5, 1, 0.5, 0, -1, 0, -1]
    assert [cosine(a) for a in (0, 60, 90, 120, 180, 270, -90)] == [1, 0.5, 0, -0.5, -1, 0, 0]


@given(angles, angles, angles)
def test_a_rotation_printed_with_six_digits_is_found_again(x, y, z):
    exact = turned(x, y, z)
    found = mended(six_digits(exact))
    assert np.abs(found[:3, :3].T @ found[:3, :3] - np.eye(3)).max() < 1e-14
    assert np.abs(found - exact).max() < 2e-6


@given(st.integers(-720, 720).map(lambda n: n / 4), st.sampled_from("xyz"))
def test_a_rotation_about_an_axis_by_quarter_degrees_is_exact_to_the_last_digits(angle, axis):
    exact = rotation(axis, angle)
    assert np.abs(mended(six_digits(exact)) - exact).max() < 1e-15


def test_an_angle_behind_six_digits_is_recognised():
    found = mended([[0.866025, -0.5, 0, 1], [0.5, 0.866025, 0, 2], [0, 0, 1, 3], [0, 0, 0, 1]])
    assert found[0, 0] == pytest.approx(math.sqrt(3) / 2, abs=2e-16)
    assert found[:3, 3].tolist() == [1, 2, 3]


@given(angles, angles, angles, factors, factors, factors)
def test_a_rotation_with_factors_keeps_exact_right_angles(x, y, z, sx, sy, sz):
    scale = np.diag([sx, sy, sz, 1.0])
    columns = mended(six_digits(turned(x, y, z) @ scale))[:3, :3]
    gram = columns.T @ columns
    assert np.abs(gram - np.diag(np.diag(gram))).max() < 1e-13
    rows = mended(six_digits(scale @ turned(x, y, z)))[:3, :3]
    gram = rows @ rows.T
    if max(sx, sy, sz) / min(sx, sy, sz) > 1.001:
        assert np.abs(gram - np.diag(np.diag(gram))).max() < 1e-13


def test_a_matrix_with_shear_stays_as_it_is():
    sheared = [[1, 0.2, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
    assert mended(sheared).tolist() == sheared


def test_mending_a_rigid_matrix_touches_no_exact_one():
    exact = turned(10, 20, 30)
    assert mended_rigid(exact) is exact
    assert (
        np.abs(
            mended_rigid(np.array(six_digits(exact)))[:3, :3].T @ mended_rigid(np.array(six_digits(exact)))[:3, :3]
            - np.eye(3)
        ).max()
        < 1e-14
    )


@pytest.mark.parametrize("name", PRIMITIVES)
@settings(max_examples=25)
@given(angles, angles, angles, factors, factors, factors, signs, st.booleans())
def test_no_point_of_a_solid_moves_when_scale_and_mirror_go_into_it(name, x, y, z, sx, sy, sz, sign, is_uniform):
    primitive = PRIMITIVES[name]
    sy, sz = (sx, sx) if is_uniform else (sy, sz)
    matrix = translation(1, -2, 0.5) @ turned(x, y, z) @ np.diag([sx * sign, sy, sz, 1.0])
    placed = place(primitive, matrix)
    world = POINTS @ matrix[:3, :3].T + matrix[:3, 3]
    assert np.array_equal(holds(placed, world), holds(primitive, POINTS))
    assert np.linalg.det(placed.placement[:3, :3]) > 0
    if is_uniform:
        assert np.abs(placed.placement[:3, :3].T @ placed.placement[:3, :3] - np.eye(3)).max() < 1e-8


def test_a_block_scaled_along_its_axes_is_a_bigger_block():
    placed = place(Block(size=(1, 2, 3)), rotation("z", 90) @ np.diag([2.0, 3.0, 4.0, 1.0]))
    assert isinstance(placed, Block)
    assert placed.size == (2, 6, 12)
    assert np.array_equal(placed.placement, rotation("z", 90))


def test_a_stretched_cylinder_stays_one_only_along_and_across_its_axis():
    longer = place(Cylinder(radius=1, height=2), np.diag([3.0, 3.0, 5.0, 1.0]))
    assert (longer.radius, longer.height) == (3, 10)
    oval = place(Cylinder(radius=1, height=2), np.diag([3.0, 2.0, 5.0, 1.0]))
    assert (oval.radius, oval.height) == (1, 2)
    assert np.array_equal(oval.placement, np.diag([3.0, 2.0, 5.0, 1.0]))


def test_a_mirrored_block_stands_where_its_image_does_and_is_placed_by_a_rotation():
    placed = place(Block(size=(1, 2, 3)), np.diag([-1.0, 1.0, 1.0, 1.0]))
    assert np.linalg.det(placed.placement[:3, :3]) == pytest.approx(1)
    assert holds(placed, np.array([[-0.5, 1, 1], [0.5, 1, 1]])).tolist() == [True, False]


def test_placing_twice_is_placing_once():
    primitive = replace(PRIMITIVES["wedge"], placement=translation(1, 2, 3))
    once = place(primitive, turned(10, 20, 30))
    assert np.allclose(once.placement, turned(10, 20, 30) @ translation(1, 2, 3), atol=1e-15)
