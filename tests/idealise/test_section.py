"""Section properties against closed forms."""

import math
import subprocess
import sys

import numpy as np
import pytest
import shapely
from shapely import Polygon, affinity, box

from kernel.errors import MeshError
from kernel.idealise.closed_sections import circle, rectangle_torsion_constant, tube
from kernel.idealise.outline import moments
from kernel.idealise.section import section_properties
from kernel.idealise.torsion import solve_warping


def disc(sides: int, radius: float) -> Polygon:
    angle = 2 * np.pi * np.arange(sides) / sides
    return Polygon(np.column_stack([radius * np.cos(angle), radius * np.sin(angle)]))


def i_section(width: float = 100, height: float = 100, web: float = 6, flange: float = 8) -> Polygon:
    bars = [
        box(0, 0, width, flange),
        box(0, height - flange, width, height),
        box((width - web) / 2, 0, (width + web) / 2, height),
    ]
    return shapely.union_all(bars)


def channel(width: float, height: float, web: float, flange: float) -> Polygon:
    return box(0, 0, width, height).difference(box(web, flange, width + 1, height - flange))


def zed() -> Polygon:
    return shapely.union_all([box(0, 0, 50, 5), box(44, 0, 50, 100), box(44, 95, 94, 100)])


@pytest.mark.parametrize("ratio", [1, 2, 5, 10, 50])
def test_finite_elements_give_the_rectangle_of_timoshenko_and_goodier(ratio):
    outline = box(3, -7, 3 + ratio, -6)
    warping = solve_warping(outline, moments(outline))
    assert warping.j == pytest.approx(rectangle_torsion_constant(ratio, 1), rel=1e-3)
    assert warping.shear_area_y == pytest.approx(5 / 6 * ratio, rel=1e-3)
    assert warping.shear_area_z == pytest.approx(5 / 6 * ratio, rel=1e-3)
    assert warping.shear_centre == (0, 0)


def test_the_square_has_the_torsion_constant_of_the_handbooks():
    assert rectangle_torsion_constant(1, 1) == pytest.approx(0.140577, abs=1e-6)  # Timoshenko and Goodier, table 109
    assert rectangle_torsion_constant(10, 1) / 10 == pytest.approx(0.312, abs=5e-4)


def test_finite_elements_give_the_circle_and_the_tube():
    solid, hollow = disc(384, 10), disc(384, 10).difference(disc(384, 9))
    exact = circle({"radius": 10}, moments(solid))
    warping = solve_warping(solid, moments(solid))
    assert warping.j == pytest.approx(exact.j, rel=1e-3)
    assert warping.shear_area_z == pytest.approx(exact.shear_area_z, rel=1e-3)
    exact = tube({"radius": 10, "inner_radius": 9}, moments(hollow))
    warping = solve_warping(hollow, moments(hollow))
    assert warping.j == pytest.approx(exact.j, rel=1e-3)
    assert warping.shear_area_y == pytest.approx(exact.shear_area_y, rel=1e-3)


def test_a_polygon_of_96_sides_counts_as_the_true_circle():
    section = section_properties(affinity.translate(disc(96, 5), 20, -30))
    assert section.shape == "circle"
    assert section.dimensions == {"radius": pytest.approx(5)}
    assert section.area == pytest.approx(math.pi * 25, rel=1e-12)
    assert section.j == pytest.approx(math.pi * 625 / 2, rel=1e-12)
    assert section.centroid == (pytest.approx(20), pytest.approx(-30))


def test_thin_profiles_follow_the_thin_wall_formulas():
    # I of 2 mm: J = sum of b t^3 / 3 (lengths on mid-lines), shear along the web about web area
    section = section_properties(i_section(200, 200, 2, 2))
    assert section.j == pytest.approx((2 * 200 + 196) * 2**3 / 3, rel=0.005)
    assert section.iyy == pytest.approx((200 * 200**3 - 198 * 196**3) / 12, rel=1e-12)
    # Cowper 1966, thin-walled I at Poisson's ratio 0, on mid-lines
    m, n = 2 * 200 * 2 / (198 * 2), 200 / 198
    k = 10 * (1 + 3 * m) ** 2 / (12 + 72 * m + 150 * m**2 + 90 * m**3 + 30 * n**2 * (m + m**2))
    assert section.shear_area_z == pytest.approx(k * section.area, rel=0.01)


def test_the_shear_centre_of_a_thin_channel_is_behind_its_web():
    b, h, t = 50 - 0.25, 100 - 0.5, 0.5  # mid-lines
    section = section_properties(channel(50, 100, 0.5, 0.5))
    behind_web = 3 * b**2 / (6 * b + h)  # Timoshenko, Strength of Materials, part I, uniform thickness
    web_middle = 0.25 - section.centroid[0]
    assert section.shear_centre[0] == pytest.approx(web_middle - behind_web, rel=0.005)
    assert section.shear_centre[1] == 0
    assert section.j == pytest.approx((2 * b + h) * t**3 / 3, rel=0.005)


def test_the_shear_centre_of_a_thin_angle_is_at_its_heel():
    section = section_properties(box(0, 0, 80, 80).difference(box(1, 1, 81, 81)))
    heel = 0.5 - np.asarray(section.centroid)
    assert np.asarray(section.shear_centre) == pytest.approx(heel, abs=0.02)


def test_a_thin_box_twists_as_bredt_says():
    section = section_properties(box(0, 0, 100, 60).difference(box(0.25, 0.25, 99.75, 59.75)))
    area, length = 99.75 * 59.75, 2 * (99.75 + 59.75)
    open_part = length * 0.25**3 / 3  # the walls' own b t^3 / 3
    assert section.j == pytest.approx(4 * area**2 / length * 0.25 + open_part, rel=0.005)
    assert section.shape == "box"


@pytest.mark.parametrize("angle", [0, 30, 90, 211])
@pytest.mark.parametrize(
    ("outline", "shape", "dimensions"),
    [
        (box(0, 0, 10, 20), "rectangle", {"width", "height"}),
        (i_section(), "i", {"width": 100, "height": 100, "web": 6, "flange": 8}),
        (channel(50, 100, 5, 7), "channel", {"width": 50, "height": 100, "web": 5, "flange": 7}),
        (box(0, 0, 100, 10) | box(47, 0, 53, 80), "tee", {"width": 100, "height": 80, "web": 6, "flange": 10}),
        (zed(), "zed", {"width": 94, "height": 100, "web": 6, "flange": 5}),
        (box(0, 0, 50, 80) - box(5, 7, 60, 93), "angle", {"width", "height", "web", "flange"}),
        (disc(96, 5) - disc(96, 4), "tube", {"radius": 5, "inner_radius": 4, "thickness": 1}),
        (box(0, 40, 100, 60) | box(40, 0, 60, 100), "general", set()),
        (disc(24, 5), "general", set()),
        (box(0, 0, 100, 60) - disc(96, 5).buffer(0), "general", set()),
    ],
)
def test_a_profile_is_recognised_whatever_its_tilt(outline, shape, dimensions, angle):
    section = section_properties(affinity.rotate(outline, angle))
    assert section.shape == shape
    assert set(section.dimensions) == set(dimensions)
    if isinstance(dimensions, dict):
        assert section.dimensions == {key: pytest.approx(value) for key, value in dimensions.items()}


@pytest.mark.parametrize("outline", [i_section(), channel(50, 100, 5, 7), zed(), box(0, 0, 10, 20)])
def test_turning_the_outline_changes_no_invariant(outline):
    still, turned = section_properties(outline), section_properties(affinity.rotate(outline, 25))
    assert turned.j == pytest.approx(still.j, rel=1e-4)
    assert turned.iyy + turned.izz == pytest.approx(still.iyy + still.izz, rel=1e-9)
    determinant = still.iyy * still.izz - still.iyz**2
    assert turned.iyy * turned.izz - turned.iyz**2 == pytest.approx(determinant, rel=1e-9)
    assert math.hypot(*turned.shear_centre) == pytest.approx(math.hypot(*still.shear_centre), abs=1e-3)


def test_second_moments_do_not_suffer_from_a_far_origin():
    section = section_properties(affinity.translate(box(0, 0, 3, 4), 1e6, -1e6))
    assert section.iyy == pytest.approx(3 * 4**3 / 12, rel=1e-6)


def test_a_section_in_two_pieces_is_refused():
    with pytest.raises(MeshError, match="in 2 pieces"):
        section_properties(box(0, 0, 1, 1) | box(5, 5, 6, 6))


def test_rectangles_and_circles_do_not_import_scipy():
    code = (
        "import sys; from shapely import box, Point; from kernel.idealise.section import section_properties as s;"
        "s(box(0, 0, 1, 2)); s(Point(0, 0).buffer(1, quad_segs=24)); sys.exit('scipy' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
