"""Models laid beside each other, then connected."""

from dataclasses import replace

import numpy as np
import pytest
from handmade import (
    beam_property,
    brick,
    cantilever,
    grid,
    i_outline,
    line_block,
    model_of,
    shell_cantilever,
    solid_cantilever,
)
from joined import half_beam_half_solid, post_on_plate
from shapely import box

from kernel.connect.audit import connected_components
from kernel.connect.checks import check_against
from kernel.connect.model import Mpc, NamedSet, Property, Rbe2
from kernel.edit.connecting import connect_model
from kernel.edit.edited import Edited
from kernel.edit.merging import merge_models
from kernel.edit.moving import move_node
from kernel.edit.removing import delete_segment
from kernel.errors import ConnectError, MeshError, OptionError
from kernel.materials import named_material
from kernel.mesh.mesh import ElementBlock
from kernel.units import unit_set


def plate(segment="s1", start=0.0, divisions=(5, 3), material=None, units="mm", title="handmade"):
    """100 x 60 x 5 from x = start."""
    nodes, quads = grid((start, 0, 0), (100, 0, 0), (0, 60, 0), *divisions)
    properties = [Property(segment, "shell", "steel", thickness=5.0)]
    steel = material or named_material("steel", unit_set(units))
    model = model_of(nodes, [ElementBlock(segment, "quad4", quads)], properties, units=units, materials=(steel,))
    sets = (
        NamedSet("PART", np.arange(len(nodes)), np.arange(len(quads))),
        NamedSet(segment, np.arange(len(nodes)), np.arange(len(quads))),
    )
    return replace(model, sets=sets, title=title)


def merged(*models):
    edited = Edited.of(models[0])
    for model in models[1:]:
        edited = merge_models(edited, Edited.of(model)).edited
    return edited


def checks(edited):
    return check_against(edited.model, edited.reference)


def test_merged_models_lie_side_by_side_with_all_that_is_theirs():
    edited = merged(plate(), plate("s2", 100))
    model = edited.model
    assert [element.segment for element in model.properties] == ["s1", "s2"]
    assert connected_components(model) == 2
    assert checks(edited).passed and checks(edited).coincident_nodes == 4
    by_name = {named.name: named for named in model.sets}
    assert len(by_name["PART"].elements) == 30 and by_name["s2"].nodes.tolist() == list(range(24, 48))
    assert edited.history == ("merged with handmade (s2)",)
    assert model.notes == ("edited: merged with handmade (s2)",)


def test_a_segment_whose_id_is_taken_gets_the_next_one():
    edited = merged(plate(), plate(start=100, title="other"))
    assert [block.segment for block in edited.model.mesh.blocks] == ["s1", "s2"]
    assert {named.name for named in edited.model.sets} == {"PART", "s1", "PART_2", "s2"}
    assert edited.history == ("merged with other (s1), its s1 called s2",)


def test_a_wrong_thickness_still_fails_under_the_name_that_the_segment_gets():
    wrong = Edited.of(plate(start=200))
    wrong = replace(wrong, reference=replace(wrong.reference, misfits={"s1": "is 5 thick, and its material 4"}))
    both = merge_models(Edited.of(plate()), wrong).edited
    assert checks(both).failures == ("s2 is 5 thick, and its material 4",)
    assert checks(delete_segment(both, "s2")).passed


def test_another_material_of_the_same_name_gets_a_name_of_its_own():
    softer = replace(named_material("steel", unit_set("mm")), elastic_modulus=1000.0)
    model = merged(plate(), plate("s2", 100, material=softer)).model
    assert [element.material for element in model.properties] == ["steel", "steel_2"]
    assert (model.materials["steel_2"].elastic_modulus, model.materials["steel_2"].name) == (1000.0, "steel_2")
    assert list(merged(plate(), plate("s2", 100)).model.materials) == ["steel"]


def test_other_units_are_refused():
    with pytest.raises(OptionError, match="is in mm and handmade in m, expected the same units"):
        merged(plate(), plate("s2", 100, units="m"))


def test_couplings_come_along():
    edited = merged(plate(), post_on_plate())
    (coupling,) = edited.model.couplings
    (own,) = post_on_plate().couplings
    assert coupling.dependent == own.dependent + 24
    assert checks(edited).coupling_error < 1e-9


def test_connected_models_pass_their_checks():
    edited = connect_model(merged(plate(), plate("s2", 100)))
    assert edited.history[-1] == "connected: 4 nodes became one with others, 0 tied to elements"
    assert checks(edited).passed
    assert (checks(edited).components, checks(edited).coincident_nodes, checks(edited).cracks) == (1, 0, 0)
    by_name = {named.name: named for named in edited.model.sets}
    assert set(by_name["s1"].nodes) & set(by_name["s2"].nodes) == {20, 21, 22, 23}


def test_meshes_that_do_not_match_are_tied_and_pass_their_checks():
    edited = connect_model(merged(plate(), plate("s2", 100, (5, 4))))
    assert all(isinstance(coupling, Mpc) for coupling in edited.model.couplings)
    assert checks(edited).passed and checks(edited).components == 1
    assert edited.model.couplings[0].nodes[0] in np.flatnonzero(edited.model.mesh.nodes[:, 0] == 100)


def test_a_gap_is_bridged_only_within_the_tolerance():
    apart = merged(plate(), plate("s2", 100.5))
    with pytest.raises(
        ConnectError, match=r"nothing to connect: no nodes of the segments touch within the tolerance of"
    ):
        connect_model(apart, 0.1)
    assert connected_components(connect_model(apart, 1.0).model) == 1
    with pytest.raises(OptionError, match="tolerance is -1, expected a positive length"):
        connect_model(apart, -1.0)


def test_some_segments_are_connected_and_others_wait():
    three = merged(plate(), plate("s2", 100), plate("s3", 200))
    edited = connect_model(three, segments=["s1", "s2"])
    assert checks(edited).components == 2 and checks(edited).passed
    assert checks(connect_model(edited)).components == 1


def test_a_coupling_whose_patch_is_tied_later_is_written_out():
    """The plate under the post hangs on a coarser one: what the post's end averages depends on that one."""
    post = post_on_plate()
    nodes, quads = grid((60, 0, 0), (0, 0, 50), (0, 100, 0), 1, 3)
    beside = model_of(nodes, [ElementBlock("s9", "quad4", quads)], [Property("s9", "shell", "steel", thickness=5.0)])
    edited = connect_model(merged(post, beside), 1e-3)
    found = checks(edited)
    assert (found.doubly_dependent, found.chained) == (0, 0)
    assert found.coupling_error < 1e-9
    assert connected_components(edited.model) == 1


def test_a_hinge_is_refused():
    """A beam along the edge of a solid: its axis lies in no section that touches a face."""
    nodes, hexes = brick((100, 60, 5), (5, 3, 1))
    solid = model_of(nodes, [ElementBlock("s1", "hex8", hexes)], [Property("s1", "solid", "steel")])
    line = np.column_stack([np.linspace(0, 100, 6), np.zeros(6), np.zeros(6)])
    beam = model_of(line, [line_block("s2", range(6), (0, 1, 0))], [beam_property("s2", box(0, 0, 20, 30))])
    with pytest.raises(ConnectError, match=r"at \(0, 0, 0\) a node of beams or shells lies on a node of solids"):
        connect_model(merged(solid, plate("s3", 100, (5, 4)), plate("s4", 200, (5, 4)), beam))


def test_a_deleted_segment_takes_its_nodes_sets_and_couplings_along():
    edited = connect_model(merged(plate(), plate("s2", 100, (5, 4)), plate("s3", 200, (5, 4))))
    edited = delete_segment(edited, "s3")
    assert [element.segment for element in edited.model.properties] == ["s1", "s2"]
    assert checks(edited).passed and checks(edited).free_nodes == 0
    assert {named.name for named in edited.model.sets} == {"PART", "s1", "s2"}
    alone = delete_segment(edited, "s1")
    assert alone.model.couplings == () and checks(alone).passed
    assert alone.model.mesh.n_node == 30
    with pytest.raises(OptionError, match="s2 is the only segment"):
        delete_segment(alone, "s2")
    with pytest.raises(OptionError, match="no segment 's1' in the mesh, expected one of s2"):
        delete_segment(alone, "s1")


def test_a_rigid_coupling_goes_on_with_what_is_left():
    model = merged(plate(), plate("s2", 100), plate("s3", 300)).model
    model = replace(model, couplings=(Rbe2(0, np.array([47, 71])), Rbe2(70, np.array([1]))))
    edited = delete_segment(Edited.of(model), "s3")
    (coupling,) = edited.model.couplings
    assert (coupling.independent, coupling.dependent.tolist()) == (0, [47])


def test_the_mass_that_is_left_is_checked_too():
    edited = delete_segment(Edited.of(half_beam_half_solid("distributing")), "s1")
    assert checks(edited).passed and abs(checks(edited).mass_error) < 1e-12


@pytest.mark.parametrize("kind", ["quad4", "quad8", "tri6"])
def test_a_node_moves_and_its_neighbours_half_as_far(kind):
    model = shell_cantilever(kind, 100, 60, 2, (10, 6))
    edited = move_node(Edited.of(model), (40, 30, 0), (42, 33, 0))
    moved = np.linalg.norm(edited.model.mesh.nodes - model.mesh.nodes, axis=1)
    step = np.hypot(2, 3)
    assert np.count_nonzero(np.isclose(moved, step)) == 1
    assert np.count_nonzero(np.isclose(moved, step / 2)) == {"quad4": 0, "quad8": 4, "tri6": 6}[kind]
    assert checks(edited).passed


def test_a_node_of_solids_moves_too():
    edited = move_node(Edited.of(solid_cantilever("hex8")), (50, 5, 10), (52, 5, 10))
    assert checks(edited).passed


def test_a_node_that_cannot_move_is_told():
    model = shell_cantilever("quad4", 100, 60, 2, (10, 6))
    with pytest.raises(OptionError, match=r"no node at \(41, 30, 0\), the nearest is at \(40, 30, 0\)"):
        move_node(Edited.of(model), (41, 30, 0), (42, 33, 0))
    with pytest.raises(MeshError, match="inverted"):
        move_node(Edited.of(model), (40, 30, 0), (65, 30, 0))
    tied = connect_model(merged(plate(), plate("s2", 100, (5, 4))))
    with pytest.raises(MeshError, match="stands in an equation"):
        move_node(tied, (100, 30, 0), (100, 31, 0))


def test_beams_on_one_node_are_connected_stiffly():
    lower = cantilever(i_outline(), 1000.0, 4)
    nodes = np.column_stack([np.full(5, 1000.0), np.zeros(5), np.linspace(0, 500, 5)])
    upper = model_of(nodes, [line_block("s2", range(5), (0, 1, 0))], [replace(lower.properties[0], segment="s2")])
    edited = connect_model(merged(lower, upper))
    assert checks(edited).passed and checks(edited).components == 1


@pytest.mark.parametrize("blocks", [(), (ElementBlock("s1", "quad4", np.empty((0, 4), np.int64)),)])
def test_a_model_without_elements_cannot_be_edited(blocks):
    empty = model_of(np.empty((0, 3)), list(blocks), [])
    with pytest.raises(OptionError, match="handmade has no elements, expected some to edit"):
        Edited.of(empty)
