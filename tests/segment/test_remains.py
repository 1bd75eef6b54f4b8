"""What others leave of a beam or plate is as thick, and of as large a section, as it is taken to be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solids import cube, placed, turned, union

from app.pipeline import classify
from kernel.csg.reader import read_model
from kernel.segment.segments import BeamShape, PlateShape, Segment
from kernel.segment.slices import slice_polygon

LIMIT = 0.1
"""What a segment may have too much or too little of: crumbs, holes and bevels; less than 5 % of it is a wall's own."""


def segments_of(text: str) -> tuple[Segment, ...]:
    return classify(read_model(text, "remains")).partition.segments


def stands_for(segment: Segment) -> float:
    """The volume that the segment's section and length, or thickness and mid-section, stand for; over its own."""
    shape = segment.shape
    if isinstance(shape, BeamShape):
        return shape.outline.area * (shape.end - shape.start) / segment.volume
    assert isinstance(shape, PlateShape)
    middle = slice_polygon(segment.solid.facets, shape.normal, shape.mid_offset, shape.u, shape.v)
    return middle.area * shape.thickness / segment.volume


@settings(max_examples=25)
@given(
    depth=st.floats(0.5, 19.5),
    thickness=st.floats(3.0, 8.0),
    axis=st.sampled_from("xyz"),
    angle=st.floats(-180.0, 180.0),
)
def test_a_post_cut_along_by_a_panel_keeps_the_section_that_is_left(depth, thickness, axis, angle):
    post, panel = cube(20, 20, 600), cube(300, thickness, 500, (-140, 20 - depth, 0))
    for segment in segments_of(placed(union(post, panel), (3, 5, 7), turned(axis, angle))):
        if segment.type != "brick":
            assert stands_for(segment) == pytest.approx(1.0, abs=LIMIT)


@settings(max_examples=25)
@given(depth=st.floats(0.01, 9.99), inset=st.floats(-60.0, 60.0), angle=st.floats(-180.0, 180.0))
def test_a_plate_let_into_another_is_as_thick_as_what_is_left_of_it(depth, inset, angle):
    """Beside a post, so that the plates are operands; one over the other's edge where the inset is negative."""
    lower = union(cube(300, 300, 10), cube(25, 25, 500, (200, 200, 10)))
    upper = cube(120, 100, 10, (inset, 40, 10 - depth))
    segments = segments_of(placed(union(lower, upper), (3, 5, 7), turned("y", angle)))
    for segment in segments:
        if segment.type != "brick":
            assert stands_for(segment) == pytest.approx(1.0, abs=LIMIT)
    total = 300 * 300 * 10 + 25 * 25 * 500 + 120 * 100 * 10 - depth * (120 + min(inset, 0.0)) * 100
    assert sum(segment.volume for segment in segments) == pytest.approx(total, rel=1e-6)


@pytest.mark.parametrize("gap", [0.004, 0.01, 0.02])
def test_walls_a_hair_apart_leave_nothing_of_a_wall_that_crosses_both(gap):
    webs = (cube(400, 4, 100, (0, 199, 6)), cube(400, 4, 80, (0, 203 + gap, 6)))
    text = union(cube(400, 400, 6), *webs, cube(4, 400, 80, (199, 0, 0)))
    assert [segment.type for segment in segments_of(text)] == ["plate"] * 4


def test_a_plate_that_goes_on_beyond_the_one_beside_it_is_not_of_both_thicknesses():
    text = union(cube(270, 190, 5), cube(270, 5, 100, (0, 95, 5)), cube(270, 5, 80, (0, 99.999, 5)))
    thicknesses = sorted(segment.thickness for segment in segments_of(text))
    assert np.allclose(thicknesses, [5.0, 5.0, 9.999], atol=2e-3)
