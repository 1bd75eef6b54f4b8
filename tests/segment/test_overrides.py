"""What the user says is carried out, or refused with the geometric reason."""

from __future__ import annotations

import pytest
from segmenting import kinds, segmented

from kernel.errors import OverrideError, RuleError
from kernel.plan import Conclusion

I_LONG = "P = BLO(3000,150,12) UN BLO(3000,150,12) AT(MOVZ=188) UN BLO(3000,8,176) AT(MOVY=71, MOVZ=12)\n"
PIPE = "P = CYL(60,500) DIF CYL(56,502) AT(MOVZ=-1)\n"
TABLE = "P = BLO(1200,700,20) AT(MOVZ=700) UN BLO(45,45,700) UN BLO(45,45,700) AT(MOVX=1155)\n"


def test_an_i_beam_becomes_one_plate_across_its_axis():
    (segment,) = segmented(I_LONG, {"/": "plate"}).segments
    assert (segment.type, segment.thickness, segment.holes) == ("plate", pytest.approx(3000), 0)


def test_an_i_beam_becomes_its_three_walls():
    found = segmented(I_LONG, {"/": "plates"})
    assert sorted(round(segment.thickness, 6) for segment in found.segments) == [8, 12, 12]


def test_a_pipe_becomes_a_beam_a_plate_a_brick():
    (beam,) = segmented(PIPE, {"/": "beam"}).segments
    assert beam.length == pytest.approx(500)
    assert beam.shape.outline.area == pytest.approx(3.14159265 * (60**2 - 56**2), rel=1e-4)
    (plate,) = segmented(PIPE, {"/": "plate"}).segments
    assert (plate.thickness, plate.holes) == (pytest.approx(500), 1)
    assert kinds(PIPE, {"/": "brick"}) == ["brick"]


def test_a_thick_pipe_can_be_a_cylinder_plate_when_the_user_says_so():
    (segment,) = segmented("P = CYL(70,150) DIF CYL(40,152) AT(MOVZ=-1)\n", {"/": "cylinder_plate"}).segments
    assert (segment.thickness, segment.radius) == (pytest.approx(30), pytest.approx(55))


def test_what_the_rules_would_have_said_stays_visible():
    decision = segmented(PIPE, {"/": "brick"}).plan.of("/")
    assert (decision.type, decision.origin, decision.by_rule.type) == ("brick", "override", "cylinder_plate")


def test_an_override_on_one_leg_leaves_the_others_alone():
    assert kinds(TABLE, {"1": "brick"}) == ["beam", "brick", "plate"]


def test_an_override_inside_a_member_splits_what_is_above_it():
    found = segmented(I_LONG, {"2": "plate"})
    assert [segment.type for segment in found.segments if segment.node == "2"] == ["plate"]
    root = found.plan.of("/")
    assert (root.type, root.origin, root.by_rule.type) == ("split", "override", "beam")
    assert "2" in root.override.reason


def test_an_override_reaches_an_operand_below_a_difference():
    text = f"{TABLE.replace('P =', 'P = (').rstrip()}) DIF CYL(5,900) AT(MOVX=22, MOVY=22, MOVZ=-5)\n"
    assert kinds(text, {"0.1": "brick"}) == ["beam", "brick", "plate"]


def test_split_gives_the_operands_each_on_its_own():
    assert len(segmented(I_LONG, {"/": "split"}).segments) == 3


def test_auto_takes_an_override_back():
    assert kinds(I_LONG, {"/": "auto"}) == ["beam"]


def test_the_head_of_a_difference_is_the_difference():
    assert kinds(PIPE, {"0": "brick"}) == ["brick"]


@pytest.mark.parametrize(
    ("text", "path", "type_", "reason"),
    [
        ("P = SPH(40)\n", "/", "beam", "not prismatic"),
        ("P = CON(40, 10, 500)\n", "/", "beam", "of its nine sections 8 differ .* expected no more than 3"),
        ("P = SPH(40)\n", "/", "plate", "neither one wall nor a prism"),
        ("P = BLO(9,8,7)\n", "/", "cylinder_plate", "no pair of coaxial cylinders encloses it"),
        ("P = BLO(9,8,7)\n", "/", "plates", "no walls were found"),
        ("P = BLO(9,8,7)\n", "/", "split", "no operands"),
        (PIPE, "1", "brick", "taken away by the difference at /"),
        ("P = BLO(9,8,7) INT SPH(6)\n", "1", "brick", "intersection at /"),
        (TABLE, "7", "brick", "no node '7'"),
        (TABLE, "0", "shell", "unknown type 'shell'"),
    ],
)
def test_an_override_that_cannot_be_is_refused_with_the_reason(text, path, type_, reason):
    with pytest.raises(OverrideError, match=reason) as caught:
        segmented(text, {path: type_})
    assert path in caught.value.message


def test_a_short_member_cut_askew_is_a_beam_where_an_analyst_says_so():
    box = "(BLO(60,60,1200) DIF BLO(52,52,1200) AT(MOVX=4,MOVY=4))"
    cut = f"P = {box} DIF BLO(900,900,900) AT(MOVX=-400,MOVY=-400,MOVZ=-900,ROTY=40,MOVZ=700)\n"
    assert kinds(cut) == ["plate"] * 4
    (beam,) = segmented(cut, {"/": "beam"}).segments
    assert beam.type == "beam" and beam.shape.outline.area == pytest.approx(60**2 - 52**2)


def test_overrides_that_contradict_one_another_are_refused():
    with pytest.raises(OverrideError, match="overridden as brick"):
        segmented(TABLE, {"/": "brick", "1": "beam"})
    with pytest.raises(OverrideError, match="same material"):
        segmented(PIPE, {"/": "brick", "0": "beam"})


def test_a_conclusion_of_the_rules_that_cannot_be_names_the_rule():
    def wrong(facts):
        return Conclusion("beam", "everything-is-a-beam", 1.0, "because")

    with pytest.raises(RuleError, match="everything-is-a-beam concludes beam"):
        segmented("P = SPH(40)\n", decide=wrong)
