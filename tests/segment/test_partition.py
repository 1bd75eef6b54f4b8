"""The walk: what is asked, what is recorded, and what the segments are called."""

from __future__ import annotations

import sys

import pytest
from segmenting import plain_decide, segmented

from kernel.csg.source import MAX_TREE_DEPTH
from kernel.errors import RuleError
from kernel.plan import Conclusion, Need
from kernel.segment import pieces
from kernel.segment.segments import BeamShape, CylinderShape, PlateShape
from kernel.segment.slabs import decompose
from rules.engine import load_rule_base

FRAME = "P = BLO(100,100,2500) UN BLO(100,100,2500) AT(MOVX=2900) UN BLO(3000,100,140) AT(MOVZ=2360)\n"
BRACKET = (
    "BASE = BLO(160,100,10)\nBACK = BLO(10,100,130) AT(MOVZ=10)\n"
    "P = (BASE UN BACK) DIF CYL(7,20) AT(MOVX=125, MOVY=50, MOVZ=-5)\nOUT P\n"
)


def test_facts_are_measured_tier_by_tier_and_no_further_than_needed():
    asked = []

    def spy(facts):
        asked.append(facts.tier)
        return plain_decide(facts)

    segmented("P = BLO(900,40,40)\n", decide=spy)
    assert asked == ["intent", "extents", "prism"]


def test_equal_questions_are_answered_once():
    asked = []

    def spy(facts):
        asked.append(facts)
        return plain_decide(facts)

    row = " UN ".join(f"BLO(40,40,900) AT(MOVX={200 * k})" for k in range(6))
    found = segmented(f"P = {row}\n", decide=spy)
    assert len(found.segments) == 6
    assert len([facts for facts in asked if facts["role"] == "operand"]) == 3  # one question, in three tiers


def test_rules_that_ask_for_what_they_have_are_an_error():
    with pytest.raises(RuleError, match="already has"):
        segmented("P = BLO(9,8,7)\n", decide=lambda facts: Need("intent"))


def test_every_question_is_in_the_plan_in_the_order_of_the_walk():
    plan = segmented(FRAME).plan
    assert [decision.node for decision in plan.decisions] == ["/", "0", "1", "2"]
    assert plan.of("0").facts["prism_length"] == 2500


def test_segments_are_numbered_by_path_and_know_their_names():
    found = segmented(BRACKET)
    assert [segment.id for segment in found.segments] == ["s1", "s2"]
    assert {segment.type for segment in found.segments} == {"plate"}
    assert {segment.name for segment in segmented(BRACKET, {"/": "split"}).segments} == {"BASE", "BACK"}


def test_segments_are_disjoint_and_fill_the_solid():
    found = segmented(FRAME)
    assert sum(segment.volume for segment in found.segments) == pytest.approx(2 * 1e4 * 2360 + 3000 * 1.4e4, rel=1e-9)


def test_the_larger_section_owns_the_corner_and_the_others_keep_their_full_length():
    found = segmented(FRAME)
    column = found.segments[0].shape
    assert isinstance(column, BeamShape)
    assert column.end - column.start == pytest.approx(2360)
    assert column.full_end - column.full_start == pytest.approx(2500)
    assert found.segments[0].length == pytest.approx(2500)


def test_a_plate_knows_its_two_faces_and_where_they_face_one_another():
    (segment,) = segmented("P = BLO(300,200,10) DIF CYL(20,30) AT(MOVX=150, MOVY=100, MOVZ=-10)\n").segments
    shape = segment.shape
    assert isinstance(shape, PlateShape)
    assert segment.holes == 1
    assert shape.paired.area == pytest.approx(300 * 200 - 3.14159 * 400, rel=1e-3)
    surfaces = segment.solid.surfaces.surfaces
    assert [surfaces[index].offset for index in shape.surface_ids] == [shape.bottom, shape.top]


@pytest.mark.parametrize(
    ("cut", "closed"), [("", True), (" DIF BLO(200,100,400) AT(MOVX=-100, MOVY=0, MOVZ=-5)", False)]
)
def test_a_pipe_is_closed_and_half_a_pipe_is_not(cut, closed):
    (segment,) = segmented(f"P = CYL(80,300) DIF CYL(76,310) AT(MOVZ=-5){cut}\n").segments
    shape = segment.shape
    assert isinstance(shape, CylinderShape)
    assert shape.is_closed is closed
    assert (shape.z_max - shape.z_min, shape.mid_radius) == (pytest.approx(300), pytest.approx(78))


def test_a_beam_in_several_pieces_keeps_its_full_ends_only_outside():
    text = (
        "P = BLO(200,200,200) AT(MOVX=-100, MOVY=-100, MOVZ=-100) &\n"
        " UN BLO(2000,30,30) AT(MOVX=-1000, MOVY=-15, MOVZ=-15)\n"
    )
    found = segmented(text)
    beams = sorted((s for s in found.segments if s.type == "beam"), key=lambda s: s.shape.start)
    assert [(s.shape.full_start, s.shape.full_end) for s in beams] == [
        (pytest.approx(-1000), pytest.approx(-100)),
        (pytest.approx(100), pytest.approx(1000)),
    ]


def test_a_beam_that_loses_a_side_keeps_the_section_that_is_left():
    found = segmented("P = BLO(8, 1000, 400) UN BLO(38, 1000, 10) AT (MOVZ=390)\n")
    beam = next(segment for segment in found.segments if segment.type == "beam")
    assert isinstance(beam.shape, BeamShape)
    assert beam.shape.outline.area == pytest.approx(30 * 10)
    assert beam.volume == pytest.approx(beam.shape.outline.area * beam.length)


def test_pieces_that_were_combined_are_all_named():
    row = "BLO(500,50,50) UN BLO(700,50,50) AT(MOVX=500)"
    found = segmented(f"P = {row} UN BLO(900,600,10) AT(MOVX=1300)\n")
    beam = next(segment for segment in found.segments if segment.type == "beam")
    assert beam.sources == ("0", "1")
    assert beam.length == pytest.approx(1200)


@pytest.mark.parametrize("order", ["PL UN LUG", "LUG UN PL"])
@pytest.mark.parametrize("turn", ["", " AT (ROTX=31, ROTZ=17)"])
@pytest.mark.parametrize("depth", [0.5, 5.0, 9.9])
def test_a_brick_let_into_a_plate_leaves_the_plate_whole(order, turn, depth):
    found = segmented(
        "PL = BLO(400,200,10)\n"
        f"LUG = BLO(60,60,60) AT (MOVX=100, MOVY=70, MOVZ={10 - depth})\n"
        f"P = ({order}){turn}\nOUT P\n"
    )
    volume = {segment.type: segment.solid.volume for segment in found.segments}
    assert volume == {
        "plate": pytest.approx(400 * 200 * 10, rel=1e-9),
        "brick": pytest.approx(60 * 60 * (60 - depth), rel=1e-9),
    }


@pytest.mark.parametrize("depth", [10.0, 14.0])
def test_a_brick_right_through_a_plate_goes_through_its_hole(depth):
    found = segmented(
        f"PL = BLO(400,200,10)\nLUG = BLO(60,60,60) AT (MOVX=100, MOVY=70, MOVZ={10 - depth})\nP = PL UN LUG\nOUT P\n"
    )
    plate = next(segment for segment in found.segments if segment.type == "plate")
    assert plate.solid.volume == pytest.approx(400 * 200 * 10 - 60 * 60 * 10, rel=1e-9)


@pytest.mark.parametrize("at", [194.0, 191.0])
def test_a_brick_let_into_a_tube_leaves_the_tube_whole(at):
    found = segmented(
        "RIM = CYL(200,40) DIF CYL(190,40)\n"
        f"LUG = BLO(60,20,60) AT (MOVX={at}, MOVY=-10, MOVZ=-10)\nP = RIM UN LUG\nOUT P\n"
    )
    tube = next(segment for segment in found.segments if isinstance(segment.shape, CylinderShape))
    assert tube.holes == 0
    alone = segmented("P = CYL(200,40) DIF CYL(190,40)\n").segments[0]
    assert tube.solid.volume == pytest.approx(alone.solid.volume, rel=1e-6)


@pytest.mark.parametrize("base", [0.0, 25.0])
def test_webs_in_line_on_both_sides_of_a_plate_keep_to_their_sides(base):
    """A girder's web over a column's: neither takes material of the other, however thick plates elsewhere are."""
    extra = f" UN (BLO(300,300,{base}) AT (MOVX=-150,MOVY=-150,MOVZ=-{base}))" if base else ""
    found = segmented(
        "COLUMN = BLO(7,180,500) AT (MOVX=-3.5,MOVY=-90)\n"
        "CAP = BLO(600,200,12) AT (MOVX=-100,MOVY=-100,MOVZ=500)\n"
        "GIRDER = BLO(600,8,276) AT (MOVX=-100,MOVY=-4,MOVZ=512)\n"
        f"P = COLUMN UN CAP UN GIRDER{extra}\nOUT P\n"
    )
    volumes = {segment.thickness: segment.solid.volume for segment in found.segments}
    assert volumes[7] == pytest.approx(7 * 180 * 500, rel=1e-9)
    assert volumes[8] == pytest.approx(8 * 600 * 276, rel=1e-9)


def nested(solids: list[str]) -> str:
    """A union of a union of a union, one solid more at each level."""
    lines = [f"U0 = {solids[0]}", *(f"U{k} = U{k - 1} UN {solid}" for k, solid in enumerate(solids[1:], 1))]
    return "\n".join([*lines, f"OUT U{len(solids) - 1}"]) + "\n"


def test_a_tree_as_deep_as_can_be_read_is_taken_apart():
    limit = sys.getrecursionlimit()

    def split_unions(facts):
        return Conclusion("split" if facts["operand_count"] > 1 else "brick", "plain", 1.0, "it is a test")

    found = segmented(
        nested([f"BLO(10,10,300) AT(MOVX={100 * k})" for k in range(MAX_TREE_DEPTH)]), decide=split_unions
    )
    assert len(found.segments) == MAX_TREE_DEPTH
    assert sys.getrecursionlimit() == limit


def test_with_an_override_far_below_walls_are_not_looked_for_anew_at_every_level(monkeypatch):
    text = nested(
        [f"((BLO(40,40,600) DIF BLO(32,32,602) AT(MOVX=4, MOVY=4, MOVZ=-1)) AT(MOVX={40 * k}))" for k in range(6)]
    )
    asked = []
    monkeypatch.setattr(pieces, "decompose", lambda solid: asked.append(solid) or decompose(solid))
    assert [segment.type for segment in segmented(text).segments] == ["beam"] * 6
    plain = len(asked)
    found = segmented(text, {"0.0.0.0.0": "brick"})
    assert sorted(segment.type for segment in found.segments) == ["beam"] * 5 + ["brick"]
    assert len(asked) - plain <= 2 * plain


def test_a_tube_that_its_neighbours_make_short_is_walls_however_the_unions_nest():
    """1000 long and 60 wide, held at 400 to 460: 540 is free."""
    posts = [f"((BLO(60,60,1000) DIF BLO(52,52,1002) AT(MOVX=4, MOVY=4, MOVZ=-1)) AT(MOVX={x}))" for x in (0, 300)]
    rail = "((BLO(240,60,60) DIF BLO(242,52,52) AT(MOVX=-1, MOVY=4, MOVZ=4)) AT(MOVX=60, MOVZ=400))"
    for text in (nested([posts[0], rail, posts[1]]), f"P = {posts[0]} UN {rail} UN {posts[1]}\n"):
        assert {segment.type for segment in segmented(text, decide=load_rule_base().decide).segments} == {"plate"}


def test_thin_rods_through_bars_are_beams_and_no_crumbs_of_the_bars():
    bars = " UN ".join(f"BLO(562,10,57) AT(MOVY={103 * k})" for k in range(4))
    rods = " UN ".join(f"CYL(4,319) AT(ROTX=-90, MOVX={x}, MOVZ=28.5)" for x in (50, 281, 512))
    found = segmented(f"P = {bars} UN {rods}\n", decide=load_rule_base().decide)
    plates = [segment for segment in found.segments if segment.type == "plate"]
    beams = [segment for segment in found.segments if segment.type == "beam"]
    assert (len(found.segments), len(plates), len(beams)) == (13, 4, 9)
    assert [segment.volume for segment in plates] == pytest.approx([562 * 10 * 57] * 4)
    assert [segment.length for segment in beams] == pytest.approx([93] * 9)
