"""Hulls: flat faces are planes, and what follows the members' round faces stays round."""

from __future__ import annotations

import math
from collections import Counter
from itertools import product

import numpy as np
import pytest
from trees import at, difference, evaluated, turned

from kernel.csg.tree import Block, Cone, CsgNode, Cylinder, Hull, Sphere
from kernel.errors import GeometryError
from kernel.solid.brep import brep_of


def kinds(node: CsgNode) -> dict[str, int]:
    return dict(Counter(type(face.surface).__name__ for face in brep_of(evaluated(node).solid).faces))


def test_a_rounded_box_has_planes_cylinders_and_spheres() -> None:
    balls = [Sphere(radius=2, placement=at(x, y, z)) for x, y, z in product((0, 30), (0, 20), (0, 10))]
    box = Hull(members=tuple(balls))
    volume = 32 * math.pi / 3 + 4 * math.pi * 60 + 6000 + 4 * (600 + 300 + 200)
    assert evaluated(box).solid.true_volume == pytest.approx(volume, rel=1e-9)
    assert kinds(box) == {"Plane": 6, "CylinderSurface": 12, "SphereSurface": 8}


def test_a_capsule_is_two_half_spheres_and_a_cylinder() -> None:
    capsule = Hull(members=(Sphere(radius=5), Sphere(radius=5, placement=at(20))))
    assert evaluated(capsule).solid.true_volume == pytest.approx(500 * math.pi / 3 + 500 * math.pi, rel=1e-9)
    assert kinds(capsule) == {"SphereSurface": 2, "CylinderSurface": 1}


def test_a_rounded_plate_with_a_hole() -> None:
    posts = [Cylinder(radius=3, height=2, placement=at(x, y)) for x, y in product((0, 30), (0, 20))]
    plate = difference(Hull(members=tuple(posts)), Cylinder(radius=4, height=4, placement=at(15, 10, -1)))
    volume = 2 * (600 + 2 * 3 * 50 + 9 * math.pi - 16 * math.pi)
    assert evaluated(plate).solid.true_volume == pytest.approx(volume, rel=1e-9)
    assert kinds(plate) == {"Plane": 6, "CylinderSurface": 5}


def test_a_ball_on_a_cylinder_has_no_seam_of_flats() -> None:
    dome = Hull(members=(Cylinder(radius=3, height=4), Sphere(radius=3, placement=at(z=9))))
    assert evaluated(dome).solid.true_volume == pytest.approx(81 * math.pi + 18 * math.pi, rel=1e-9)
    assert kinds(dome) == {"Plane": 1, "CylinderSurface": 1, "SphereSurface": 1}


def test_the_hull_of_a_cone_is_the_cone() -> None:
    cone = Hull(members=(Cone(bottom_radius=3, top_radius=0, height=5), Block(size=(1, 1, 1))))
    assert evaluated(cone).solid.true_volume == pytest.approx(15 * math.pi, rel=1e-9)
    assert kinds(cone) == {"Plane": 1, "ConeSurface": 1}


@pytest.mark.parametrize("linear", [turned([1, 2, 3], 40), np.diag([1.0, 1.0, -1.0])])
def test_hulls_of_blocks_are_flat(linear) -> None:
    blocks = (
        Block(size=(4, 4, 1), placement=at(linear=linear)),
        Block(size=(2, 2, 1), placement=at(*(linear @ [1, 1, 4]), linear)),
    )
    assert kinds(Hull(members=blocks)) == {"Plane": 10}


def test_a_hull_without_volume_is_refused() -> None:
    nothing = difference(Block(size=(1, 1, 1)), Block(size=(1, 1, 1)))
    with pytest.raises(GeometryError, match="the hull at / is no solid: its members are empty"):
        evaluated(Hull(members=(nothing,)))
