"""Target sizes: bounded above by the part, below by what a solver takes."""

import pytest

from app.pipeline import classify
from kernel.csg.reader import read_model
from kernel.errors import OptionError
from kernel.mesh.options import MeshOptions
from kernel.mesh.size_field import PER_TURN, segment_sizes


def segments_of(text: str):
    return classify(read_model(text, "model.csg")).partition.segments


PLATE = "A = BLO(200, 100, 5)\n"
PIPE = "A = CYL(R=50, H=300) DIF CYL(R=48, H=302) AT (MOVZ=-1)\n"


def test_a_size_larger_than_the_part_is_the_parts():
    assert segment_sizes(segments_of(PLATE), MeshOptions(), 1e6) == {"s1": pytest.approx(200)}


def test_a_size_that_no_solver_takes_is_refused_with_one_that_would_do():
    with pytest.raises(OptionError, match=r"size 1e-09 would give about 2e\+22 elements, expected a size of 0\.\d+ or"):
        segment_sizes(segments_of(PLATE), MeshOptions(), 1e-9)


def test_a_pipe_is_divided_often_enough_to_be_round():
    (size,) = segment_sizes(segments_of(PIPE), MeshOptions(), 100.0).values()
    assert size == pytest.approx(2 * 3.14159265 * 49 / PER_TURN, rel=1e-6)


def test_a_segment_has_a_size_of_its_own_by_id_or_name():
    segments = segments_of(PLATE)
    assert segment_sizes(segments, MeshOptions(segment_sizes={"A": 7.0}), 20.0) == {"s1": 7.0}
    assert segment_sizes(segments, MeshOptions(segment_sizes={"s1": 8.0}), 20.0) == {"s1": 8.0}
