"""Tubes of one axis and radii: many where there is nothing between them, one where another wall runs through it."""

from __future__ import annotations

import pytest
from solids import cube, difference, placed, rod, tube, turned, union

from app.pipeline import classify
from kernel.csg.reader import read_model
from kernel.segment.segments import CylinderShape, PlateShape

SHELL = tube(1200, 300, 294)
TURNS = [None, turned("x", 31.0) @ turned("y", 17.0)]


def segments_of(text: str, turn=None):
    return classify(read_model(placed(text, turn=turn), "stretches")).partition.segments


@pytest.mark.parametrize("turn", TURNS, ids=["straight", "turned"])
@pytest.mark.parametrize("inner, outer", [(298, 350), (260, 296)], ids=["outside", "inside"])
def test_rings_on_a_shell_are_plates_of_their_width(turn, inner, outer):
    found = segments_of(union(SHELL, *(tube(8, outer, inner, (0, 0, z)) for z in (300, 600, 900))), turn)
    rings = [segment for segment in found if isinstance(segment.shape, PlateShape)]
    assert [ring.thickness for ring in rings] == pytest.approx([8.0] * 3)
    assert [segment.thickness for segment in found if segment not in rings] == pytest.approx([6.0])


@pytest.mark.parametrize("turn", TURNS, ids=["straight", "turned"])
def test_sleeves_of_one_size_are_one_each(turn):
    sleeves = [tube(150, 310, 300, (0, 0, z)) for z in (100, 500, 900)]
    found = segments_of(union(SHELL, *sleeves), turn)
    shapes = [segment.shape for segment in found if isinstance(segment.shape, CylinderShape)]
    assert len(shapes) == len(found) == 4
    assert sorted(shape.z_max - shape.z_min for shape in shapes) == pytest.approx([150] * 3 + [1200])


@pytest.mark.parametrize("turn", TURNS, ids=["straight", "turned"])
@pytest.mark.parametrize(
    "through",
    [rod(6, 400, (0, 0, 597)), difference(cube(900, 900, 6, (-450, -450, 597)), rod(900, 200, (0, 0, 300)))],
    ids=["disc", "pierced plate"],
)
def test_a_shell_with_a_wall_through_it_is_one(turn, through):
    found = segments_of(union(SHELL, through), turn)
    assert sorted(segment.type for segment in found) == ["cylinder_plate", "plate"]


def test_a_shell_cut_right_through_is_two():
    found = segments_of(difference(SHELL, cube(900, 900, 30, (-450, -450, 590))))
    assert [segment.type for segment in found] == ["cylinder_plate", "cylinder_plate"]
