"""Target sizes: bounded above by the part, below by what a solver takes."""

import pytest

from app.pipeline import classify
from kernel.csg.reader import read_model
from kernel.errors import OptionError
from kernel.mesh.options import MeshOptions
from kernel.mesh.size_field import PER_TURN, Sizes, plan_sizes


def planned(text: str, **options) -> Sizes:
    classified = classify(read_model(text, "model.csg"))
    return plan_sizes(classified.partition.segments, MeshOptions(**options), classified.evaluated)


PLATE = "A = BLO(200, 100, 5)\n"
PIPE = "A = CYL(R=50, H=300) DIF CYL(R=48, H=302) AT (MOVZ=-1)\n"
TABLE = """
TOP = BLO(1000, 600, 25) AT (MOVZ=700)
LEG1 = BLO(40, 40, 700)
LEG2 = BLO(40, 40, 700) AT (MOVX=960, MOVY=560)
LEGS = LEG1 UN LEG2
T = TOP UN LEGS
"""


def test_a_size_larger_than_the_part_is_the_parts_and_the_user_is_told():
    sizes = planned(PLATE, size=1e6)
    assert sizes.by_segment == {"s1": pytest.approx(200)}
    assert sizes.warnings == ("s1 (/): size 1e+06 is held down to 200, its largest extent",)


def test_a_size_that_no_solver_takes_is_refused_with_one_that_would_do():
    with pytest.raises(OptionError, match=r"size 1e-09 would give about 2e\+22 elements, expected a size of 0\.\d+ or"):
        planned(PLATE, size=1e-9)


def test_a_pipe_is_divided_often_enough_to_be_round():
    sizes = planned(PIPE, size=100.0)
    assert sizes.by_segment["s1"] == pytest.approx(2 * 3.14159265 * 49 / PER_TURN, rel=1e-6)
    (warning,) = sizes.warnings
    assert warning == "s1 (/): size 100 is held down to 12.83, 24 elements round its circle"


def test_the_automatic_size_tells_what_it_comes_from_and_is_bounded_without_a_warning():
    sizes = planned(PLATE)
    assert sizes.size == pytest.approx(5.6)
    assert sizes.because == "automatic: 1/40 of the model's size 223.7"
    assert planned(PIPE).warnings == ()


def test_a_segment_has_a_size_of_its_own_by_id_path_or_name():
    for address in ("A", "a", "s1", "/"):
        sizes = planned(PLATE, size=20.0, sizes={address: 7.0})
        assert sizes.by_segment == {"s1": 7.0}
        assert sizes.reasons == {"s1": f"asked for {address}"}


def test_of_nodes_the_deepest_gives_the_size_and_a_segments_id_wins_over_nodes():
    by_name = planned(TABLE, size=50.0, sizes={"/": 40, "LEGS": 30, "LEG2": 20}).by_segment
    assert sorted(by_name.values()) == [20, 30, 40]
    (leg,) = [segment for segment, size in by_name.items() if size == 20]
    assert planned(TABLE, sizes={"LEG2": 20, leg: 10}).by_segment[leg] == 10


@pytest.mark.parametrize(
    ("sizes", "complaint"),
    [
        ({"LID": 5.0}, "size of 'LID': no node 'LID' in the model, expected '/', a path such as '0.1', or a node's"),
        ({"LEG": 5.0}, "did you mean 'LEGS'"),
        ({"s9": 5.0}, "size of 's9': no node 's9' in the model.* or a segment from s1 to s3"),
        ({"LEG1": 5.0, "1.0": 6.0}, "size of 'LEG1' and of '1.0': both are node 1.0, expected one"),
        ({"TOP": 0.0}, "size of 'TOP' is 0, expected a positive number"),
        ({"TOP": float("nan")}, "size of 'TOP' is nan"),
    ],
)
def test_a_size_of_nothing_is_refused_with_what_was_expected(sizes, complaint):
    with pytest.raises(OptionError, match=complaint):
        planned(TABLE, sizes=sizes)


def test_a_block_of_a_solid_with_holes_means_the_wall_that_fills_it():
    angle = "B = BLO(160, 100, 10)\nW = BLO(10, 100, 140)\nH = CYL(R=9, H=30) AT (MOVX=80, MOVY=50, MOVZ=-2)\n"
    sizes = planned(angle + "A = (B UN W) DIF H\n", size=20.0, sizes={"/": 15.0, "B": 5.0})
    assert sorted(sizes.by_segment.values()) == [5.0, 15.0]
    (base,) = [segment for segment, reason in sizes.reasons.items() if reason == "asked for B"]
    assert sizes.by_segment[base] == 5.0


def test_a_size_of_a_hole_has_no_segment_to_be_the_size_of():
    drilled = "P = BLO(200, 100, 5)\nH = CYL(R=9, H=9) AT (MOVX=50, MOVY=50, MOVZ=-2)\nD = P DIF H\n"
    with pytest.raises(OptionError, match=r"size of 'H': node 1 has no segments of its own, expected .* \(D\)"):
        planned(drilled, sizes={"H": 2.0})


SKIN = " UN BLO(300, 300, 15) AT (MOVZ=1)"
OVERLAPPING = f"P = BLO(300, 300, 15){SKIN} UN BLO(40, 40, 800) AT (MOVX=130, MOVY=130, MOVZ=16)\n"
"""The second plate has its faces 15 apart, but all of its material save a skin is the first one's."""


def test_a_plate_of_which_another_owns_all_but_a_skin_has_no_say_in_the_size():
    overlapping, alone = planned(OVERLAPPING), planned(OVERLAPPING.replace(SKIN, ""))
    assert overlapping.by_segment["s1"] == pytest.approx(alone.by_segment["s1"], rel=0.05)
