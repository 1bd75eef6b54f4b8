"""Meshing apart: the same geometry, but every segment with nodes of its own; then connected by hand."""

from pathlib import Path

import numpy as np
import pytest
from test_assemble_joints import JOINTS

from app.pipeline import classify, mesh, read, segments_of
from kernel.connect.checks import check_against
from kernel.connect.reference import reference_of
from kernel.csg.reader import read_model
from kernel.edit.connecting import connect_model
from kernel.edit.edited import Edited
from kernel.edit.merging import merge_models
from kernel.errors import OptionError
from kernel.mesh.options import MeshOptions

ROOT = Path(__file__).parents[2]
WALLS = [
    "bracket_two_gussets",
    "box_of_four_plates",
    "egg_crate_two_by_two",
    "pipe_two_flanges",
    "tank_with_nozzle_hole",
]
CONTACTS = [
    "lap_of_two_plates",
    "coplanar_step",
    "table_touching",
    "stool_round",
    "beam_between_plates",
    "i_between_blocks",
    "block_with_fin",
    "boss_round",
    "rail_on_sheet",
    "portal_oblique",
    "four_bars_ring",
    "i_beside_column",
    "ladder",
    "truss_triangle",
    "truss_warren",
    "frame_with_panel",
]


def classified(name):
    return classify(read(str(ROOT / name)))


def edited(meshed):
    return Edited.of(meshed.model, reference_of(meshed.assembly, meshed.classified.evaluated))


def nodes_of(model):
    return {block.segment: set(block.connectivity.ravel().tolist()) for block in model.mesh.blocks}


@pytest.mark.parametrize("name", WALLS)
def test_walls_meshed_apart_share_nothing_and_connect_to_one_whole(name):
    base = classified(f"tests/cases/{name}.csg")
    apart = mesh(base, apart=True)
    assert apart.checks.passed, apart.checks.failures
    assert apart.checks.components == len(apart.assembly.segments)
    assert apart.model.couplings == ()
    owners = list(nodes_of(apart.model).values())
    assert sum(map(len, owners)) == len(set().union(*owners))
    whole = connect_model(edited(apart))
    checks = check_against(whole.model, whole.reference)
    assert checks.passed, checks.failures
    assert (checks.components, checks.coincident_nodes) == (1, 0)


def test_segments_meshed_alone_with_the_same_size_make_the_mesh_of_shared_curves():
    base = classified("tests/cases/box_of_four_plates.csg")
    shared = mesh(base, MeshOptions(size=20))
    parts = [mesh(base, MeshOptions(size=20), only=[segment.id]) for segment in base.partition.segments]
    for part in parts:
        assert part.checks.passed and part.checks.components == 1, part.checks.failures
        assert abs(part.checks.accounted_mass_error) < 1e-9
    joined = edited(parts[0])
    for part in parts[1:]:
        joined = merge_models(joined, edited(part)).edited
    assert check_against(joined.model, joined.reference).components == 4
    joined = connect_model(joined)
    places = [np.unique(np.round(model.mesh.nodes, 9), axis=0) for model in (joined.model, shared.model)]
    assert np.array_equal(*places)
    assert joined.model.mesh.count() == shared.model.mesh.count()


def test_one_joint_apart_leaves_the_others_as_they_are():
    base = classified("examples/table.csg")
    meshed = mesh(base, MeshOptions(size=100), joint_couplings={"j2": "apart", "j3": "rigid"})
    assert meshed.checks.passed and meshed.checks.components == 2
    assert len(meshed.model.couplings) == 3


def test_walls_apart_stay_one_model_where_a_third_joins_both():
    base = classified("tests/cases/corner_three_plates.csg")
    meshed = mesh(base, joint_couplings={base.joints[0].id: "apart"})
    assert meshed.checks.passed
    assert meshed.checks.components == 1


def test_a_joint_that_a_third_segment_holds_together_is_told():
    base = classify(read_model(JOINTS["three walls on one line"], "test"))
    joint = [joint for joint in base.joints if joint.kind == "corner"][-1]
    meshed = mesh(base, joint_couplings={joint.id: "apart"})
    first, second = joint.segments
    assert [warning for warning in meshed.warnings if "apart" in warning] == [
        f"{first} and {second} are to be apart, but a third segment holds them together on a common curve"
    ]


def test_one_of_two_joints_of_the_same_walls_is_not_apart_alone_and_that_is_told():
    base = classify(read_model(JOINTS["cross"], "test"))
    assert [joint.segments for joint in base.joints] == [("s1", "s2")] * 2
    half = mesh(base, joint_couplings={"j1": "apart"})
    assert half.checks.components == 1
    assert "j1 is not apart, for s1 and s2 are joined by j2 too; expected all of them apart" in half.warnings
    both = mesh(base, joint_couplings={"j1": "apart", "j2": "apart"})
    assert both.checks.components == 2 and not both.warnings


def test_arms_asked_of_joints_that_are_apart_are_told():
    base = classified("tests/cases/bracket_two_gussets.csg")
    told = "no arms, for nothing hangs across what is meshed apart"
    tees = [joint.id for joint in base.joints if joint.kind == "tee"]
    whole = mesh(base, MeshOptions(tee="arms"))
    assert len(whole.assembly.arms) and not [warning for warning in whole.warnings if told in warning]
    apart = mesh(base, MeshOptions(tee="arms"), apart=True)
    (line,) = [warning for warning in apart.warnings if told in warning]
    assert line.startswith(f"{', '.join(tees)}:")
    one = mesh(base, MeshOptions(joint_tees={tees[0]: "arms"}), apart=True)
    assert [w for w in one.warnings if "arms" in w] == [line.replace(", ".join(tees), tees[0])]


def test_couplings_asked_of_joints_that_are_apart_are_told():
    base = classified("tests/cases/table_touching.csg")
    apart = mesh(base, MeshOptions(size=30), joint_couplings={"j1": "rigid"}, apart=True)
    assert apart.warnings == (
        "j1 (rigid): no coupling, for what meets there is meshed apart; expected a coupling or apart, not both",
    )
    assert mesh(base, MeshOptions(size=30), joint_couplings={"j1": "rigid"}).warnings == ()


@pytest.mark.parametrize("name", ["shaft_stepped_stout", "block_with_fin", "i_between_blocks", "table_touching"])
def test_bricks_and_beams_are_meshed_apart_too(name):
    base = classified(f"tests/cases/{name}.csg")
    meshed = mesh(base, MeshOptions(size=None if name.startswith("shaft") else 30), apart=True)
    assert meshed.checks.passed, meshed.checks.failures
    assert meshed.model.couplings == ()
    assert meshed.checks.components == len(meshed.assembly.segments)


@pytest.mark.parametrize("name", CONTACTS)
def test_what_touches_half_a_thickness_apart_is_found_by_hand_too(name):
    base = classified(f"tests/cases/{name}.csg")
    together, apart = mesh(base), mesh(base, apart=True)
    assert apart.checks.components == len(apart.assembly.segments) and apart.model.couplings == ()
    whole = connect_model(edited(apart))
    checks = check_against(whole.model, whole.reference)
    assert checks.passed, checks.failures
    assert (checks.components, checks.coincident_nodes) == (together.checks.components, 0)


@pytest.mark.parametrize("order", [1, 2])
def test_contacts_of_parts_meshed_alone_with_sizes_of_their_own_are_found(order):
    base = classified("tests/cases/block_with_fin.csg")
    parts = [
        edited(mesh(base, MeshOptions(size=size, order=order), only=[segment.id]))
        for segment, size in zip(base.partition.segments, (25, 17), strict=True)
    ]
    whole = connect_model(merge_models(*parts).edited)
    checks = check_against(whole.model, whole.reference)
    assert checks.passed and checks.components == 1, checks.failures


def test_names_that_are_none_are_refused():
    base = classified("examples/table.csg")
    with pytest.raises(OptionError, match="no joint 'j9' in the model, expected one of j1, j2, j3, j4"):
        mesh(base, joint_couplings={"j9": "apart"})
    with pytest.raises(OptionError, match="no joint 'j9' in the model"):
        mesh(base, only=["s1"], joint_couplings={"j9": "apart"})
    with pytest.raises(OptionError, match=r"only of '7\.7': .*no node '7\.7'"):
        mesh(base, only=["7.7"])


def test_a_node_below_a_difference_that_is_meshed_whole_means_the_segments_within_it():
    base = classified("tests/cases/bracket_two_gussets.csg")
    assert {segment.node for segment in base.partition.segments} == {"/"}
    assert segments_of(base, ["0.1"]) == ["s1"]
    assert segments_of(base, ["0.3", "s1", "0.0"]) == ["s1", "s3", "s4"]
    with pytest.raises(OptionError, match="only of '1': node 1 has no segments of its own"):
        segments_of(base, ["1"])
