"""Tees by rigid arms: a web ends at its flange's face and hangs, node by node, from the curve in the flange."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from assembling import WHOLE, assembled, audit, cube, difference, extrusion, mesh_volume, rod, turned, union
from test_assemble_joints import JOINTS, TUBE_ON_PLATE, inclined_web

from kernel.errors import OptionError
from kernel.idealise.arms import tee_choice, unused_choices

TEE = JOINTS["tee"]


def arms_of(assembly) -> np.ndarray:
    """(n, 2) nodes that hang, and those from which they do."""
    rows = assembly.arms
    return np.unique(np.concatenate([rows[:, [0, 2]], rows[:, [1, 3]]]), axis=0)


def lengths(assembly) -> np.ndarray:
    nodes = assembly.mesh.nodes
    hanging, held = arms_of(assembly).T
    return np.linalg.norm(nodes[hanging] - nodes[held], axis=1)


@pytest.mark.parametrize("name", JOINTS)
def test_every_joint_is_one_model_without_cracks_whatever_hangs(name):
    assembly, evaluated = assembled(JOINTS[name], tee="arms")
    assert audit(assembly) == WHOLE
    ledger = sum(row.volume for row in assembly.ledger)
    is_round = any(word in name for word in ("hole", "tube", "pipe", "tank", "trough"))
    assert mesh_volume(assembly) - ledger == pytest.approx(evaluated.solid.true_volume, rel=4e-3 if is_round else 1e-9)
    thickest = max(segment.thickness or 0 for segment in assembly.segments)
    assert (lengths(assembly) < 2 * thickest).all()


def test_a_web_ends_at_its_flanges_face_and_its_mass_is_exact():
    assembly, evaluated = assembled(TEE, tee="arms")
    web = next(block for block in assembly.mesh.blocks if block.segment == "s2")
    heights = assembly.mesh.nodes @ evaluated.frame.T
    assert heights[web.connectivity][..., 2].min() == pytest.approx(4, abs=1e-9)
    assert not [row for row in assembly.ledger if row.volume]
    assert mesh_volume(assembly) == pytest.approx(evaluated.solid.true_volume, rel=1e-12)


def test_every_node_of_the_webs_edge_hangs_by_half_the_flanges_thickness():
    assembly, _ = assembled(TEE, tee="arms")
    assert len(arms_of(assembly)) == len(np.unique(assembly.arms[:, :2])) > 10
    assert lengths(assembly) == pytest.approx(2.0, abs=1e-9)


@pytest.mark.parametrize("angle", [90, 75, 60, 45])
def test_arms_of_a_leaning_web_run_along_its_mid_surface(angle):
    assembly, evaluated = assembled(inclined_web(angle, 8), tee="arms")
    assert lengths(assembly) == pytest.approx(5 / np.sin(np.radians(angle)), rel=1e-9)
    counted = sum(row.volume for row in assembly.ledger)
    assert counted == pytest.approx(0, abs=1e-9 * evaluated.solid.true_volume)


def test_the_free_edge_of_the_web_is_audited_as_one():
    assembly, _ = assembled(TEE, tee="arms")
    uses = {tuple(sorted(row[:2])): row[2] for row in assembly.curve_uses.tolist()}
    assert {uses[tuple(sorted(row[:2]))] for row in assembly.arms.tolist()} == {1}
    assert {uses[tuple(sorted(row[2:]))] for row in assembly.arms.tolist()} == {2}


def test_corners_and_crosses_keep_their_common_curve():
    for name in ("vee at 90 degrees", "cross", "three walls on one line"):
        extended, _ = assembled(JOINTS[name])
        hung, _ = assembled(JOINTS[name], tee="arms")
        assert len(hung.arms) == 0
        assert np.array_equal(extended.mesh.nodes, hung.mesh.nodes)


def test_webs_that_cross_on_a_flange_share_one_node_that_hangs():
    floor = cube(200, 200, 8, (-100, -100, -8))
    assembly, evaluated = assembled(
        union(floor, cube(160, 6, 60, (-80, -3, 0)), cube(6, 160, 60, (-3, -80, 0))), tee="arms"
    )
    nodes = assembly.mesh.nodes @ evaluated.frame.T
    at_centre = [pair for pair in arms_of(assembly) if np.abs(nodes[pair, :2]).max() < 1e-6]
    assert len(at_centre) == 1
    assert nodes[at_centre[0], 2] == pytest.approx([0, -4], abs=1e-9)


def test_webs_on_both_sides_of_a_flange_hang_from_the_same_nodes():
    webs = cube(200, 6, 60, (0, 47, 8)), cube(200, 4, 60, (0, 48, -60))
    assembly, _ = assembled(union(cube(200, 100, 8), *webs), tee="arms")
    pairs = arms_of(assembly)
    _, counts = np.unique(pairs[:, 1], return_counts=True)
    assert set(counts) == {2}
    assert audit(assembly) == WHOLE


def test_a_divider_hangs_from_the_floor_and_both_sides_and_from_their_corners():
    tray = difference(cube(300, 200, 100), cube(288, 188, 100, (6, 6, 6)))
    assembly, evaluated = assembled(union(tray, cube(6, 188, 94, (120, 6, 6))), tee="arms")
    assert audit(assembly) == WHOLE
    nodes = assembly.mesh.nodes @ evaluated.frame.T
    corners = [pair for pair in arms_of(assembly) if np.allclose(nodes[pair[0], 1:], (6, 6))]
    assert len(corners) == 1
    assert nodes[corners[0][1], 1:] == pytest.approx([3, 3])
    assert not [row for row in assembly.ledger if len(row.segments) == 2]


def test_a_tube_standing_on_a_plate_hangs_from_a_circle_in_it():
    tube = difference(rod(200, 50, (200, 150, 10)), rod(300, 45, (200, 150, -1)))
    assembly, evaluated = assembled(union(cube(400, 300, 10), tube), tee="arms")
    nodes = assembly.mesh.nodes @ evaluated.frame.T
    hanging, held = arms_of(assembly).T
    assert len(hanging) >= 16
    assert np.hypot(*(nodes[held, :2] - (200, 150)).T) == pytest.approx(47.5, abs=1e-9)
    assert nodes[hanging, 2] == pytest.approx(10, abs=1e-9)
    assert lengths(assembly) == pytest.approx(5, abs=1e-9)


def test_a_plate_around_a_tube_hangs_from_a_circle_in_the_tube():
    assembly, _ = assembled(JOINTS["tube through a plate"], tee="arms")
    assert len(arms_of(assembly)) >= 16
    assert lengths(assembly) == pytest.approx(2, abs=1e-9)


def test_a_tube_whose_bore_goes_through_the_plate_is_a_corner():
    assembly, _ = assembled(TUBE_ON_PLATE, tee="arms")
    assert len(assembly.arms) == 0


def test_one_joint_may_differ_from_the_others():
    text = union(cube(200, 150, 4), cube(200, 12, 100, (0, 30, 4)), cube(200, 12, 100, (0, 100, 4)))
    plain, _ = assembled(text)
    tees = [joint.id for joint in plain.joints]
    assert len(tees) == 2
    one, _ = assembled(text, joint_tees={tees[0]: "arms"})
    other, _ = assembled(text, tee="arms", joint_tees={tees[0]: "extend"})
    both, _ = assembled(text, tee="arms")
    assert len(one.arms) == len(other.arms) == len(both.arms) / 2 > 0
    for assembly in (one, other, both):
        assert audit(assembly) == WHOLE


def test_arms_asked_of_a_corner_are_warned_of():
    plain, _ = assembled(JOINTS["vee at 90 degrees"])
    assembly, _ = assembled(JOINTS["vee at 90 degrees"], joint_tees={plain.joints[0].id: "arms"})
    assert any("has no arms" in warning for warning in assembly.warnings)


def test_two_joints_along_one_curve_cannot_differ_but_those_on_two_curves_may():
    first, second, elsewhere = (SimpleNamespace(id=name, segments=("s1", "s2")) for name in ("j1", "j2", "j3"))
    choice = tee_choice("extend", {"j1": "arms", "j3": "extend"}, (first, second, elsewhere))
    assert choice([first]) == choice([second, first]) == "arms"
    assert choice([second]) == choice([elsewhere]) == "extend"
    with pytest.raises(OptionError, match="tee of j1 is 'arms' and of j3 'extend', but both join s1 and s2 along one"):
        choice([first, elsewhere])


def test_another_joint_on_the_curve_of_one_by_arms_is_told():
    first, second = (SimpleNamespace(id=name, kind="tee", segments=("s1", "s2")) for name in ("j1", "j2"))
    arm = SimpleNamespace(crossing=SimpleNamespace(joints=[first, second]))
    told = unused_choices({"j1": "arms"}, (first, second), [arm])
    assert told == ["j2: by arms as j1, along one curve with it"]
    assert unused_choices({}, (first, second), [arm]) == []


EDGE, CARRIER = "100,75,4", "100,75,2"


@pytest.mark.parametrize("finer", [EDGE, CARRIER])
def test_the_lesser_of_two_sizes_holds_for_an_edge_and_the_curve_that_carries_it(finer):
    assembly, _ = assembled(TEE, tee="arms", size=40, curve_sizes={EDGE: 20, CARRIER: 20, finer: 5})
    assert len(assembly.arms) >= 200 / 5


def test_two_counts_for_an_edge_and_the_curve_that_carries_it_are_refused():
    with pytest.raises(
        OptionError, match=r"tee of s2 and s1 near \(100, 75, 2\): 10 on the edge .* and 8 on the curve"
    ):
        assembled(TEE, tee="arms", size=40, seeds={EDGE: 10, CARRIER: 8})
    assembly, _ = assembled(TEE, tee="arms", size=40, seeds={EDGE: 10, CARRIER: 10})
    assert len(assembly.arms) == 10


def test_an_unknown_joint_or_way_is_refused():
    with pytest.raises(OptionError, match="no joint 'j9'"):
        assembled(TEE, joint_tees={"j9": "arms"})
    with pytest.raises(OptionError, match="tee of j1 is 'glue', expected one of extend, arms"):
        assembled(TEE, joint_tees={"j1": "glue"})
    with pytest.raises(OptionError, match="tee is 'glue'"):
        assembled(TEE, tee="glue")


@pytest.mark.parametrize("size", [2.0, 5.0, 40.0])
def test_the_size_may_be_anything_from_far_less_to_far_more_than_the_thickness(size):
    gusset = extrusion([(0, 0), (60, 0), (0, 60)], 8, (36, 10, 10), turned("z", 90) @ turned("x", 90))
    assembly, _ = assembled(union(cube(80, 100, 10), cube(80, 10, 100), gusset), tee="arms", size=size)
    assert audit(assembly) == WHOLE
    assert len(assembly.arms)


def branch(radius: float, is_open: bool) -> str:
    """A pipe of radius 60 and a branch of `radius`; open to one another, or the branch set on the whole pipe."""
    lean = turned("y", 90)
    bore, run_bore = rod(202, radius - 3, (0, 0, 150), lean), rod(302, 56, (0, 0, -1))
    if is_open:
        return difference(union(rod(300, 60), rod(200, radius, (0, 0, 150), lean)), run_bore, bore)
    return union(
        difference(rod(300, 60), run_bore),
        difference(rod(200, radius, (0, 0, 150), lean), bore, rod(302, 58, (0, 0, -1))),
    )


@pytest.mark.parametrize("radius", [30, 60])
def test_an_open_branch_is_a_corner_and_that_it_has_no_arms_is_told(radius):
    assembly, _ = assembled(branch(radius, is_open=True), tee="arms")
    assert not len(assembly.arms)
    assert sum("tee is arms, but no wall ends within another" in line for line in assembly.warnings) == 1
    assert not any("tee is arms" in line for line in assembled(branch(radius, is_open=True))[0].warnings)


def test_a_branch_set_on_a_whole_pipe_hangs_unless_its_sides_run_on_in_the_wall():
    assembly, _ = assembled(branch(30, is_open=False), tee="arms")
    assert len(assembly.arms)
    assert not any("arm" in line for line in assembly.warnings)
    assembly, _ = assembled(branch(60, is_open=False), tee="arms")
    assert not len(assembly.arms)
    assert any("pipes of nearly one radius run side by side there" in line for line in assembly.warnings)
