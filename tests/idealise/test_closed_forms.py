"""What walls count twice on a line and in a point, against figures worked out by hand and by polygons."""

from __future__ import annotations

import numpy as np
import pytest
from shapely import Polygon
from shapely.affinity import rotate
from shapely.ops import unary_union

from kernel.idealise.closed_forms import corner_share
from kernel.idealise.stars import star_excess, star_moment

ONE = [[0, 0], [0, 1]]
UPPER = [[0, 1], [0, 1]]
ALL = [[1, 1], [1, 1]]


def excess(degrees, thicknesses) -> float:
    found = star_excess(np.radians(degrees)[:, None], np.array(thicknesses, float)[:, None])
    return float(found[0])


@pytest.mark.parametrize("angle", [25.0, 60.0, 90.0, 135.0])
def test_a_corner_counts_nothing_twice_at_any_angle(angle):
    assert excess([0, angle], [8, 5]) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("angle", [25.0, 60.0, 90.0, 135.0])
def test_a_tee_counts_half_the_common_piece_twice_and_a_cross_all_of_it(angle):
    common = 8 * 5 / np.sin(np.radians(angle))
    assert excess([0, 180, angle], [8, 8, 5]) == pytest.approx(common / 2)
    assert excess([0, 180, angle, angle + 180], [8, 8, 5, 5]) == pytest.approx(common)


def test_a_ray_that_passes_the_half_turn_from_star_to_star_stays_in_its_place():
    angles = np.radians([[0, 0], [179.99999, -179.99999], [90, 90]])
    found = star_excess(angles, np.array([8.0, 8.0, 5.0])[:, None])
    assert found == pytest.approx(8 * 5 / 2)


def test_stars_of_rays_too_near_have_no_excess_and_others_keep_theirs():
    found = star_excess(np.radians([[0, 0], [5, 90]]), np.array([[8.0, 8.0], [5.0, 5.0]]))
    assert np.isnan(found[0])
    assert found[1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("angles", [(0, 120, 240), (0, 90, 225), (10, 80, 150, 230, 300)])
def test_a_star_counts_twice_what_its_strips_have_in_common(angles):
    strip = Polygon([(0, -3), (200, -3), (200, 3), (0, 3)])
    strips = [rotate(strip, angle, origin=(0, 0)) for angle in angles]
    material = unary_union(strips).intersection(Polygon([(-90, -90), (90, -90), (90, 90), (-90, 90)]).buffer(50))
    window = Polygon([(-90, -90), (90, -90), (90, 90), (-90, 90)]).buffer(50)
    counted = sum(each.intersection(window).area for each in strips)
    # where neighbours open by more than a right angle the strips' square ends leave no notch: others fill it
    assert excess(list(angles), [6] * len(angles)) == pytest.approx(counted - material.area, rel=1e-9)


def test_the_moment_of_a_tee_is_that_of_half_the_common_piece():
    rays = np.array([[1.0, 0], [-1, 0], [0, 1]])
    # the web, 4 thick, is counted twice from the flange's middle to its face, 5 off
    assert star_moment(rays, np.array([10.0, 10, 4])) == pytest.approx([0, 4 * 5 * 2.5], abs=1e-9)
    assert star_moment(np.vstack([rays, [[0, -1]]]), np.array([10.0, 10, 4, 4])) == pytest.approx([0, 0], abs=1e-9)


@pytest.mark.parametrize(
    ("quadrants", "share"),
    [
        ((ONE, ONE, ONE), -1 / 4),
        ((ONE, UPPER, UPPER), -1 / 4),
        ((ONE, UPPER, ALL), -1 / 4),
        ((UPPER, UPPER, ALL), -1 / 2),
        ((ALL, ALL, ALL), -1),
        ((ONE, ONE, ALL), 0),
    ],
    ids=[
        "a corner of a box",
        "a web in the corner of two walls",
        "a web between a web and a flange",
        "webs that cross on a flange",
        "three walls that cross",
        "a corner of webs on a flange",
    ],
)
def test_three_walls_in_a_point_correct_their_curves_rows(quadrants, share):
    assert corner_share(np.array(quadrants, dtype=bool)) == pytest.approx(share)
