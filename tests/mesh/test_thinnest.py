"""The thinnest wall of a body, wherever on a large face it stands."""

import numpy as np
import pytest

from kernel.csg.reader import read_model
from kernel.mesh.thinnest import halved, thinnest_wall
from kernel.solid.evaluate import evaluate

BOX = "A = BLO(60, 40, 50)\nB = BLO(50, 30, 60) AT (MOVX=5, MOVY=5, MOVZ=-5)\nC = A DIF B\n"
TUBE = "A = CYL(R=40, H=30)\nB = CYL(R=32, H=40) AT (MOVZ=-5)\nC = A DIF B\n"
SLAB = "A = BLO(100, 80, 12)\nH = CYL(R=15, H=20) AT (MOVX=40, MOVY=40, MOVZ=-4)\nC = A DIF H\n"
EGG = "A = SPH(R=30)\nB = SPH(R=24)\nC = A DIF B\n"
SLOTS = (
    "A = BLO(200, 200, 20)\nB = BLO(200, 6, 9) AT (MOVY={y}, MOVZ=11)\nC = BLO(6, 200, 9) AT (MOVX={x})\n"
    "D = A DIF B DIF C\n"
)
WEDGE = "A = WED(30, 5, 10)\n"


def thickness(text) -> float:
    return thinnest_wall(evaluate(read_model(text, "m.csg")).solid)[0]


@pytest.mark.parametrize(
    ("text", "expected"), [(BOX, 5), (TUBE, 8), (SLAB, 12), (EGG, 6), ("A = WED(30, 40, 10)\n", 10)]
)
def test_the_thinnest_wall_of_a_body_is_found_whatever_its_shape(text, expected):
    assert thickness(text) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("x", "y"), [(30, 30), (97, 97), (13, 171), (150, 77)])
def test_the_floor_between_crossing_slots_is_found_though_it_is_a_small_part_of_both_faces(x, y):
    """Slots from above and from below leave 2 where they cross, on a square of 6 of faces 200 long."""
    solid = evaluate(read_model(SLOTS.format(x=x, y=y), "m.csg")).solid
    found, place = thinnest_wall(solid)
    assert found == pytest.approx(2.0)
    assert np.abs(place - np.array([x + 3, y + 3, 10])).max() <= 3


def test_a_tapered_wall_is_thinnest_at_its_blunt_end():
    """The wedge is cut off where it is 5/3 thick."""
    blunt = WEDGE + "B = BLO(20, 10, 30) AT (MOVX=20, MOVY=-1, MOVZ=-5)\nC = A DIF B\n"
    assert 5 / 3 <= thickness(blunt) < 1.05 * 5 / 3


def test_a_wedge_that_runs_out_to_an_edge_is_no_wall_of_no_thickness():
    """It is as thick as amid its facets, a third of the way from its edge."""
    assert thickness(WEDGE) == pytest.approx(5 / 3)


def test_walls_across_a_direction_do_not_count():
    solid = evaluate(read_model("A = BLO(60, 40, 5)\n", "m.csg")).solid
    assert thinnest_wall(solid)[0] == pytest.approx(5)
    assert thinnest_wall(solid, np.array([0.0, 0.0, 1.0]))[0] == pytest.approx(40)


@pytest.mark.parametrize("most", [0, 1, 50, 3000])
def test_parts_of_triangles_cover_them_and_are_no_more_than_allowed(most):
    corners = np.random.default_rng(5).random((7, 3, 3)) * [1, 10, 100]
    parts, of_row = halved(corners, most)
    assert 7 <= len(parts) <= 7 + most

    def areas(triangles):
        return np.linalg.norm(np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0]), axis=1)

    assert np.bincount(of_row, areas(parts)) == pytest.approx(areas(corners))
    longest = np.linalg.norm(parts[:, [1, 2, 0]] - parts, axis=2).max(axis=1)
    if most == 3000:
        assert longest.max() < 0.1 * np.linalg.norm(corners[:, [1, 2, 0]] - corners, axis=2).max()


def test_triangles_that_are_points_are_not_halved():
    parts, of_row = halved(np.ones((2, 3, 3)), 10)
    assert parts.shape == (2, 3, 3) and of_row.tolist() == [0, 1]
