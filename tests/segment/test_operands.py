from kernel.csg.reader import read_model
from kernel.segment.operands import operand_at, operands_of


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
