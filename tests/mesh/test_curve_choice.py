"""Curves named by node, by pair, by segment or by point; each gets exactly the seeds that are asked for it."""

import numpy as np
import pytest
from assembling import WHOLE, assembled, audit, cube, union

from kernel.errors import OptionError

DRILLED = """
PLATE = BLO(200, 120, 6)
HOLE1 = CYL(R=12, H=10) AT (MOVX=60, MOVY=60, MOVZ=-2)
HOLE2 = CYL(R=8, H=10) AT (MOVX=140, MOVY=60, MOVZ=-2)
HOLES = HOLE1 UN HOLE2
DRILLED = PLATE DIF HOLES
"""

ANGLE = """
BASE = BLO(160, 100, 10)
WALL = BLO(10, 100, 140)
BORE = CYL(R=15, H=20) AT (ROTY=90, MOVX=-5, MOVY=50, MOVZ=80)
ANGLE = (BASE UN WALL) DIF BORE
"""

TABLE = """
TOP = BLO(400, 300, 12) AT (MOVZ=300)
LEG1 = BLO(20, 20, 300) AT (MOVX=40, MOVY=40)
LEG2 = BLO(20, 20, 300) AT (MOVX=340, MOVY=240)
T = TOP UN LEG1 UN LEG2
"""

SHAFT = """
THICK = CYL(R=30, H=40)
THIN = CYL(R=15, H=60) AT (MOVZ=40)
SHAFT = THICK UN THIN
"""

TILTED = "AT (ROTX=20, ROTY=35, ROTZ=50, MOVX=7, MOVY=-3, MOVZ=11)"


def world(assembly, evaluated) -> np.ndarray:
    """Nodes in the model's own coordinates."""
    return assembly.mesh.nodes @ evaluated.frame.T


def edges_with(assembly, is_on: np.ndarray) -> int:
    """Edges of curves between two nodes that are on something."""
    edges = assembly.curve_uses[:, :2]
    return int((is_on[edges[:, 0]] & is_on[edges[:, 1]]).sum())


def edges_round(assembly, evaluated, centre, radius) -> int:
    """Edges on the circle of a hole along z."""
    away = np.hypot(*(world(assembly, evaluated)[:, :2] - centre).T)
    return edges_with(assembly, np.abs(away - radius) < 1e-9 * evaluated.size)


@pytest.mark.parametrize("count", [6, 7, 16, 18, 33, 50])
def test_a_hole_has_exactly_the_seeds_asked_for(count):
    assembly, evaluated = assembled(DRILLED, size=15.0, seeds={"HOLE1": count})
    assert audit(assembly) == WHOLE
    assert edges_round(assembly, evaluated, (60, 60), 12) == count
    assert edges_round(assembly, evaluated, (140, 60), 8) >= 16
    assert bool(assembly.warnings) == bool(count % 2)
    kinds = assembly.mesh.count()
    assert ("tri3" in kinds) == bool(count % 2)


def test_a_node_of_several_holes_means_the_rims_of_all_and_a_deeper_one_wins():
    assembly, evaluated = assembled(DRILLED, size=15.0, seeds={"HOLES": 20, "HOLE2": 12})
    assert edges_round(assembly, evaluated, (60, 60), 12) == 20
    assert edges_round(assembly, evaluated, (140, 60), 8) == 12


def test_a_point_means_the_one_curve_nearest_to_it_in_the_users_frame():
    for placed in ("", TILTED):
        text = DRILLED.replace("PLATE DIF HOLES", f"(PLATE DIF HOLES) {placed}")
        _, evaluated = assembled(text)
        turn, shift = placement() if placed else (np.eye(3), np.zeros(3))
        point = turn @ np.array([100.0, 0.0, 6.0]) + shift
        address = ",".join(f"{value:.9f}" for value in point)
        assembly, evaluated = assembled(text, size=15.0, seeds={address: 26})
        assert audit(assembly) == WHOLE
        local = (world(assembly, evaluated) - shift) @ turn
        assert edges_with(assembly, np.abs(local[:, 1]) < 1e-6) == 26
        assert edges_with(assembly, np.abs(local[:, 1] - 120) < 1e-6) == 14


def placement() -> tuple[np.ndarray, np.ndarray]:
    """What TILTED does: a rotation and a shift."""

    def about(axis, degrees):
        c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
        k, i, j = axis, (axis + 1) % 3, (axis + 2) % 3
        turn = np.zeros((3, 3))
        turn[k, k], turn[i, i], turn[j, j], turn[i, j], turn[j, i] = 1, c, c, -s, s
        return turn

    return about(2, 50) @ about(1, 35) @ about(0, 20), np.array([7.0, -3.0, 11.0])


def test_two_nodes_mean_the_curve_that_they_share_seeded_once_for_both():
    assembly, evaluated = assembled(ANGLE, size=15.0, seeds={"BASE&WALL": 24})
    assert audit(assembly) == WHOLE
    x, _, z = world(assembly, evaluated).T
    assert edges_with(assembly, (np.abs(x - 5) < 1e-6) & (np.abs(z - 5) < 1e-6)) == 24
    assert edges_with(assembly, np.abs(x - 160) < 1e-6) < 12
    other, _ = assembled(ANGLE, size=15.0, seeds={"WALL & BASE": 24})
    assert np.array_equal(other.mesh.nodes, assembly.mesh.nodes)


def test_the_order_of_operands_does_not_matter():
    one, _ = assembled(ANGLE, size=15.0, seeds={"BORE": 40}, curve_sizes={"BASE": 9.0})
    other, _ = assembled(
        ANGLE.replace("BASE UN WALL", "WALL UN BASE"), size=15.0, seeds={"BORE": 40}, curve_sizes={"BASE": 9.0}
    )
    assert one.mesh.count() == other.mesh.count()
    assert np.allclose(np.sort(one.mesh.nodes, axis=0), np.sort(other.mesh.nodes, axis=0))


def test_a_segment_means_its_outline():
    assembly, evaluated = assembled(DRILLED, size=15.0, seeds={"s1": 10})
    on_rim = edges_round(assembly, evaluated, (60, 60), 12) + edges_round(assembly, evaluated, (140, 60), 8)
    assert on_rim == 20
    assert len(assembly.curve_uses) == 60


def test_a_beam_is_divided_by_count_and_its_footprint_by_the_pair():
    assembly, evaluated = assembled(TABLE, size=60.0, seeds={"LEG1": 7, "LEG2": 3, "LEG1&TOP": 4})
    assert audit(assembly) == WHOLE
    assert assembly.mesh.count()["line2"] == 10
    x, y, _ = world(assembly, evaluated).T
    foot = (np.abs(np.abs(x - 50) - 10) < 1e-6) & (np.abs(y - 50) < 10.1)
    foot |= (np.abs(np.abs(y - 50) - 10) < 1e-6) & (np.abs(x - 50) < 10.1)
    assert edges_with(assembly, foot) == 16


def test_the_longest_element_of_a_sized_curve_is_as_long_as_asked():
    for size in (1.7, 3.3, 9.0):
        assembly, evaluated = assembled(DRILLED, size=15.0, curve_sizes={"HOLE1": size, "0,60,3": size})
        nodes = world(assembly, evaluated)
        for on_it in (np.abs(np.hypot(*(nodes[:, :2] - (60, 60)).T) - 12) < 1e-6, np.abs(nodes[:, 0]) < 1e-6):
            edges = assembly.curve_uses[:, :2]
            edges = edges[on_it[edges].all(axis=1)]
            assert np.linalg.norm(nodes[edges[:, 0]] - nodes[edges[:, 1]], axis=1).max() <= size * (1 + 1e-9)


def test_a_brick_is_divided_round_its_section_and_along_its_sweep():
    assembly, evaluated = assembled(SHAFT, {"/": "brick"}, size=10.0, seeds={"THIN": 28})
    nodes = world(assembly, evaluated)
    on_rim = (np.abs(np.hypot(*nodes[:, :2].T) - 15) < 1e-6) & (np.abs(nodes[:, 2] - 100) < 1e-6)
    assert on_rim.sum() == 28
    block = "B = BLO(40, 30, 20)\n"
    for point, axis in (("0,0,10", 2), ("20,0,20", 0), ("0,15,0", 1)):
        assembly, evaluated = assembled(block, {"/": "brick"}, size=10.0, seeds={point: 6})
        ends = {"0,0,10": [(0, 0), (1, 0)], "20,0,20": [(1, 0), (2, 20)], "0,15,0": [(0, 0), (2, 0)]}[point]
        nodes = world(assembly, evaluated)
        on_edge = np.all([np.abs(nodes[:, k] - value) < 1e-9 for k, value in ends], axis=0)
        assert on_edge.sum() == 7
        assert np.allclose(np.diff(np.sort(nodes[on_edge, axis])), np.ptp(nodes[:, axis]) / 6)


@pytest.mark.parametrize(
    ("text", "options", "complaint"),
    [
        (DRILLED, {"seeds": {"HOLE": 8}}, "seeds of 'HOLE': no node 'HOLE' in the model.*did you mean 'HOLE"),
        (DRILLED, {"seeds": {"1,2": 8}}, "seeds of '1,2': expected a point as x,y,z, such as 10,0,25"),
        (DRILLED, {"curve_sizes": {"1,2,x": 8.0}}, "curve size of '1,2,x': expected a point"),
        (DRILLED, {"seeds": {"A&B&C": 8}}, "expected a node, two as A&B, or a point x,y,z"),
        (DRILLED, {"seeds": {"HOLE1&": 8}}, "expected a node, two as A&B"),
        (DRILLED, {"seeds": {"HOLE1&HOLE2": 8}}, r"they share no curve; expected HOLE1 with one of s1 \(/\)"),
        (DRILLED, {"seeds": {"900,0,0": 8}}, r"the nearest curve, through \(200, 60, 3\) of s1, is 700 away"),
        (DRILLED, {"seeds": {"0,0,3": 8}}, "as near to the curve through .* as to the one through .* a point amid one"),
        (DRILLED, {"seeds": {"HOLE1": 2}}, "is closed: expected at least 3"),
        (DRILLED, {"seeds": {"HOLE1": 0}}, "seeds of 'HOLE1' is 0, expected a whole number from 1 to"),
        (DRILLED, {"seeds": {"HOLE1": 2.5}}, "seeds of 'HOLE1' is 2.5, expected a whole number"),
        (DRILLED, {"curve_sizes": {"HOLE1": -1.0}}, "curve size of 'HOLE1' is -1, expected a positive number"),
        (
            DRILLED,
            {"seeds": {"60,72,3": 8, "60,48,3": 10}},
            r"are both of the curve through .* expected one of 8 and 10",
        ),
        (DRILLED, {"curve_sizes": {"HOLE1": 1e-6}}, "is 75.4 long: expected 0.00075 or more"),
        (DRILLED, {"seeds": {"HOLE1": 100_000}, "growth": 1.005}, r"edges would give about 2e\+07 elements"),
        (TABLE, {"seeds": {"LEG1": 0}}, "expected a whole number"),
    ],
)
def test_what_names_no_curve_is_refused_with_what_was_expected(text, options, complaint):
    with pytest.raises(OptionError, match=complaint):
        assembled(text, size=20.0, **options)


def test_a_node_whose_surfaces_are_all_gone_is_refused_with_its_neighbours():
    buried = "A = BLO(100, 60, 5)\nB = BLO(20, 20, 3) AT (MOVX=40, MOVY=20, MOVZ=1)\nC = A UN B\n"
    with pytest.raises(
        OptionError, match=r"no curve of the mesh lies on the surfaces of node 1, expected a node such as A"
    ):
        assembled(buried, size=20.0, seeds={"B": 8})


def test_a_brick_that_is_not_swept_has_no_curves_to_name():
    ball = "BALL = SPH(R=20)\n"
    with pytest.raises(OptionError, match=r"s1 \(/\): a brick that is not swept has no curves to name, only a size"):
        assembled(ball, size=20.0, seeds={"BALL": 8})


def test_an_edge_that_hangs_by_arms_is_seeded_with_the_joint_curve_that_it_hangs_from():
    tee = "FLANGE = BLO(160, 100, 10)\nWEB = BLO(8, 100, 90) AT (MOVX=76, MOVZ=10)\nTEE = FLANGE UN WEB\n"
    assembly, evaluated = assembled(tee, size=15.0, tee="arms", seeds={"FLANGE&WEB": 22})
    assert audit(assembly) == WHOLE
    x, _, z = world(assembly, evaluated).T
    for level in (5, 10):
        assert edges_with(assembly, (np.abs(x - 80) < 1e-6) & (np.abs(z - level) < 1e-6)) == 22


def test_an_edge_that_a_joint_only_points_at_is_one_curve():
    rib = "RIB = WED(90, 80, 8) AT (ROTX=90, MOVX=10, MOVY=54, MOVZ=10)\nANGLE = "
    ribbed = ANGLE.replace("ANGLE = ", rib).replace("BASE UN WALL", "BASE UN WALL UN RIB")
    assembly, evaluated = assembled(ribbed, size=15.0, seeds={"160,50,10": 22})
    assert audit(assembly) == WHOLE
    nodes = world(assembly, evaluated)
    on_it = np.abs(nodes[:, 0] - 160) < 1e-6
    assert on_it.sum() == 23
    assert np.allclose(np.diff(np.sort(nodes[on_it, 1])), 100 / 22)


def test_seeds_of_one_stiffener_are_not_those_of_another_in_line_with_it():
    text = union(cube(300, 100, 6), cube(120, 6, 6, (10, 47, 6)), cube(120, 6, 6, (170, 47, 6)))
    pinned = {"1": "beam", "2": "beam"}

    def elements(**seeds):
        assembly, _ = assembled(text, pinned, size=30, **seeds)
        return {block.segment: len(block.connectivity) for block in assembly.mesh.blocks if block.kind == "line2"}

    usual = elements()
    assert usual["s2"] != 10
    assert elements(seeds={"s2&s1": 10}) == {**usual, "s2": 10}
    assert elements(seeds={"s3&s1": 10}) == {**usual, "s3": 10}
