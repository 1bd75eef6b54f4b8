"""Placements that take a primitive out of its family, and extrusions that twist and taper."""

from math import pi

import pytest

from kernel.csg.reader import read_model
from kernel.solid.evaluate import evaluate


def solid_of(text: str):
    return evaluate(read_model(text, "model.csg")).solid


def test_a_stretched_sphere_is_an_ellipsoid():
    solid = solid_of(
        "multmatrix([[2, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) { sphere($fn = 0, r = 10); }"
    )
    assert solid.volume == pytest.approx(2 * 4 / 3 * pi * 1000, rel=2e-3)


def test_an_extrusion_turns_before_it_tapers_as_openscad_does():
    solid = solid_of(
        "linear_extrude(height = 20, center = false, convexity = 1, twist = 90, slices = 40, scale = [2, 0.5])"
        " { square(size = [10, 4], center = false); }"
    )
    # OpenSCAD 2021.01 writes these bounds for the same input
    assert solid.bounds[1] == pytest.approx([14.8492, 4, 20], abs=1e-4)
    assert solid.bounds[0] == pytest.approx([0, -5.79154, 0], abs=1e-4)
