import pytest

from kernel.csg.reader import read_model
from kernel.segment.operands import operand_at, operand_count, operands_of


def split(text: str):
    root = read_model(f"P = {text}", "model.csg").root
    return operand_at("/", root), operands_of(operand_at("/", root))


def test_a_union_splits_into_its_operands():
    _, operands = split("BLO(1,1,1) UN BLO(2,2,2) AT(MOVX=1) UN CYL(1,4)\n")
    assert [operand.path for operand in operands] == ["0", "1", "2"]
    assert all(operand.cuts == () for operand in operands)


def test_a_difference_reaches_into_the_union_that_it_drills():
    _, operands = split("(BLO(1,1,1) UN BLO(2,2,2) AT(MOVX=1)) DIF CYL(1,4)\n")
    assert [operand.path for operand in operands] == ["0.0", "0.1"]
    assert [cut.operation for cut in operands[0].cuts] == ["difference"]


def test_an_intersection_reaches_into_whichever_operand_is_a_union():
    _, operands = split("CYL(1,4) INT (BLO(1,1,1) UN BLO(2,2,2) AT(MOVX=1))\n")
    assert [operand.path for operand in operands] == ["1.0", "1.1"]


def test_differences_within_differences_keep_every_cut():
    _, operands = split("((BLO(1,1,1) UN BLO(2,2,2)) DIF CYL(1,4)) DIF SPH(1)\n")
    assert [len(operand.cuts) for operand in operands] == [2, 2]


def test_a_drilled_block_is_one_solid_that_answers_to_two_paths():
    operand, operands = split("BLO(9,9,1) DIF CYL(1,4)\n")
    assert operands == ()
    assert operand.aliases == ("/", "0")


def test_a_primitive_does_not_split():
    _, operands = split("SPH(3)\n")
    assert operands == ()


@pytest.mark.parametrize(
    "text, count",
    [
        ("BLO(1,1,1) UN BLO(2,2,2) UN CYL(1,4)\n", 3),
        ("(BLO(1,1,1) UN BLO(2,2,2)) UN (CYL(1,4) UN (SPH(1) UN SPH(2)))\n", 5),
        ("((BLO(1,1,1) UN (BLO(2,2,2) DIF SPH(1))) DIF SPH(1)) INT BLO(9,9,9)\n", 2),
        ("BLO(9,9,1) DIF (CYL(1,4) UN CYL(2,4))\n", 1),
    ],
)
def test_operands_are_counted_however_their_unions_nest(text, count):
    operand, _ = split(text)
    assert operand_count(operand.node) == count
