"""Nodes added to meshes: at the place, in a mesh that stays conforming, whole and good."""

from dataclasses import replace

import numpy as np
import pytest
from handmade import cantilever, grid, i_outline, model_of, second_order, shell_cantilever, solid_cantilever, whole_set
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.connect.audit import connected_components
from kernel.connect.checks import check_against
from kernel.connect.model import NamedSet, Property, Rbe2
from kernel.edit.edited import Edited
from kernel.edit.inserting import add_node
from kernel.edit.patch import surface_of
from kernel.edit.workpiece import Workpiece
from kernel.errors import MeshError, OptionError
from kernel.mesh.mesh import ElementBlock
from kernel.mesh.quality import mesh_quality

SHELLS = ["quad4", "tri3", "quad8", "tri6"]


def plate(kind):
    """100 x 60, elements of 10, all of it a set."""
    model = shell_cantilever(kind, 100, 60, 2, (10, 6))
    return replace(model, sets=(whole_set(model, "ALL"),))


def tube(kind, span=2 * np.pi, radius=50.0, turned=None):
    """Length 100, elements of 15 degrees by 10; nodes on the true cylinder."""
    n = round(span / np.radians(15))
    flat, quads = grid((0, 0, 0), (span, 0, 0), (0, 100, 0), n, 10)
    name = "quad4" if kind.startswith("quad") else "tri3"
    cells = quads if name == "quad4" else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    if kind not in ("quad4", "tri3"):
        flat, _, cells = second_order(flat, name, cells)
    nodes = np.column_stack([radius * np.cos(flat[:, 0]), radius * np.sin(flat[:, 0]), flat[:, 1]])
    if span > 6.28:  # close the seam
        nodes, first = np.unique(np.round(nodes, 9), axis=0, return_inverse=True)
        cells = first.reshape(-1)[cells]
    nodes = nodes if turned is None else nodes @ turned.T
    model = model_of(nodes, [ElementBlock("s1", kind, cells)], [Property("s1", "shell", "steel", thickness=2.0)])
    return replace(model, sets=(whole_set(model, "ALL"),))


def node_there(model, place):
    return float(np.linalg.norm(model.mesh.nodes - place, axis=1).min())


def assert_whole(edited, before, place):
    """A node at the place, no crack, no free node, the same mass, everything still in the set of everything."""
    model = edited.model
    checks = check_against(model, edited.reference)
    assert checks.passed, checks.failures
    assert checks.coincident_nodes == 0
    assert node_there(model, place) < 1e-6
    assert connected_components(model) == connected_components(before)
    (everything,) = model.sets
    assert len(everything.elements) == sum(len(block.connectivity) for block in model.mesh.blocks)
    assert len(everything.nodes) == model.mesh.n_node
    return min(found["scaled_jacobian"]["min"] for found in mesh_quality(model.mesh).values())


@pytest.mark.parametrize("kind", SHELLS)
@given(x=st.floats(12, 88), y=st.floats(12, 48))
@settings(max_examples=15)
def test_anywhere_inside_a_plate(kind, x, y):
    model = plate(kind)
    if node_there(model, (x, y, 0)) < 1e-3:
        return
    edited = add_node(Edited.of(model), (x, y, 0))
    assert assert_whole(edited, model, (x, y, 0)) > 0.5
    assert abs(check_against(edited.model, edited.reference).mass_error) < 1e-12
    assert set(edited.model.mesh.count()) == {kind}


@pytest.mark.parametrize("kind", SHELLS)
@given(angle=st.floats(-np.pi, np.pi), z=st.floats(12, 88), seed=st.integers(0, 9))
@settings(max_examples=8)
def test_anywhere_on_a_closed_tube_however_turned(kind, angle, z, seed):
    turned = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    model = tube(kind, turned=turned * np.sign(np.linalg.det(turned)))
    place = turned * np.sign(np.linalg.det(turned)) @ [50 * np.cos(angle), 50 * np.sin(angle), z]
    if node_there(model, place) < 1e-3:
        return
    edited = add_node(Edited.of(model), place)
    assert assert_whole(edited, model, place) > 0.5
    axis = turned[:, 2]
    out = edited.model.mesh.nodes - np.outer(edited.model.mesh.nodes @ axis, axis)
    assert np.linalg.norm(out, axis=1) == pytest.approx(50, abs=1e-7)


@pytest.mark.parametrize("kind", SHELLS)
@pytest.mark.parametrize("place", [(33, 0, 0), (100, 34, 0), (0, 7, 0), (4, 60, 0)])
def test_on_the_rim_of_a_plate(kind, place):
    model = plate(kind)
    edited = add_node(Edited.of(model), place)
    assert assert_whole(edited, model, place) > 0.3
    count = edited.model.mesh.count()
    assert sum(n for name, n in count.items() if name[:3] == "tri") <= (3 if kind.startswith("quad") else 999)


def test_on_the_rim_of_a_tube_the_node_lies_on_the_circle():
    model = tube("quad4")
    angle = np.radians(40)
    place = (50 * np.cos(angle), 50 * np.sin(angle), 0)
    assert assert_whole(add_node(Edited.of(model), place), model, place) > 0.3


@pytest.mark.parametrize("kind", ["quad4", "tri3", "quad8"])
def test_on_a_curve_that_three_plates_share(kind):
    along = (0, 60, 0)
    parts = [grid((0, 0, 0), reach, along, 5, 6) for reach in ((-50, 0, 0), (50, 0, 0), (0, 0, 50))]
    nodes, blocks, start = [], [], 0
    for number, (points, quads) in enumerate(parts, start=1):
        name = "tri3" if kind.startswith("tri") else "quad4"
        cells = quads if name == "quad4" else np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
        if kind == "quad8":
            points, name, cells = second_order(points, name, cells)
        blocks.append(ElementBlock(f"s{number}", name, cells + start))
        nodes.append(points)
        start += len(points)
    unique, first = np.unique(np.vstack(nodes), axis=0, return_inverse=True)
    blocks = [replace(block, connectivity=first.reshape(-1)[block.connectivity]) for block in blocks]
    properties = [Property(f"s{k}", "shell", "steel", thickness=2.0) for k in (1, 2, 3)]
    model = model_of(unique, blocks, properties)
    model = replace(model, sets=(whole_set(model, "ALL"),))
    edited = add_node(Edited.of(model), (0, 23, 0))
    assert assert_whole(edited, model, (0, 23, 0)) > 0.3
    assert edited.history[0].startswith("added a node at (0, 23, 0) in the curve of s1 and s2 and s3")
    number = int(np.argmin(np.linalg.norm(edited.model.mesh.nodes - (0, 23, 0), axis=1)))
    assert {b.segment for b in edited.model.mesh.blocks if number in b.connectivity} == {"s1", "s2", "s3"}


@pytest.mark.parametrize("kind", ["line2", "line3"])
def test_a_beams_element_is_split(kind):
    model = cantilever(i_outline(), 1000.0, 4, kind)
    model = replace(model, sets=(whole_set(model, "ALL"),))
    edited = add_node(Edited.of(model), (333, 0, 0))
    checks = check_against(edited.model, edited.reference)
    assert checks.passed and abs(checks.mass_error) < 1e-12
    (block,) = edited.model.mesh.blocks
    assert len(block.connectivity) == len(block.orientation) == 5
    corners = edited.model.mesh.nodes[block.connectivity[:, :2], 0]
    assert corners.tolist() == [[0, 250], [250, 333], [333, 500], [500, 750], [750, 1000]]
    if kind == "line3":
        assert edited.model.mesh.nodes[block.connectivity[:, 2], 0] == pytest.approx(corners.mean(axis=1))


def test_nodes_that_couplings_hold_stay():
    model = plate("quad4")
    held = int(np.flatnonzero((model.mesh.nodes == (40, 30, 0)).all(axis=1))[0])
    far = int(np.flatnonzero((model.mesh.nodes == (80, 30, 0)).all(axis=1))[0])
    model = replace(model, couplings=(Rbe2(held, np.array([far])),))
    edited = add_node(Edited.of(model), (44, 33, 0))
    (coupling,) = edited.model.couplings
    assert edited.model.mesh.nodes[coupling.independent].tolist() == [40, 30, 0]
    assert edited.model.mesh.nodes[coupling.dependent[0]].tolist() == [80, 30, 0]
    assert check_against(edited.model, edited.reference).free_nodes == 0


def test_only_the_patch_changes():
    model = shell_cantilever("quad4", 200, 120, 2, (20, 12))
    edited = add_node(Edited.of(model), (44, 33, 0))
    before = {tuple(map(tuple, places)) for places in model.mesh.nodes[model.mesh.blocks[0].connectivity].tolist()}
    after = edited.model.mesh.nodes[edited.model.mesh.blocks[0].connectivity].tolist()
    changed = [places for places in after if tuple(map(tuple, places)) not in before]
    assert 4 <= len(changed) <= 50
    assert np.abs(np.array(changed)[:, :, :2] - (44, 33)).max() < 40


def test_a_set_of_a_part_keeps_to_its_part():
    model = plate("tri3")
    left = np.flatnonzero(model.mesh.nodes[model.mesh.blocks[0].connectivity].mean(axis=1)[:, 0] < 50)
    nodes = np.unique(model.mesh.blocks[0].connectivity[left])
    model = replace(model, sets=(NamedSet("LEFT", nodes, left),))
    edited = add_node(Edited.of(model), (20, 33, 0))
    (named,) = edited.model.sets
    places = edited.model.mesh.nodes[edited.model.mesh.blocks[0].connectivity].mean(axis=1)
    assert named.elements.tolist() == np.flatnonzero(places[:, 0] < 50).tolist()
    assert edited.model.mesh.nodes[named.nodes, 0].max() == 50


def test_the_same_edit_gives_the_same_mesh():
    one, other = (add_node(Edited.of(plate("quad4")), (44, 33, 0)).model.mesh for _ in range(2))
    assert np.array_equal(one.nodes, other.nodes)
    assert np.array_equal(one.blocks[0].connectivity, other.blocks[0].connectivity)


@pytest.mark.parametrize(
    "place, told",
    [
        ((40, 30, 0), r"there is a node at \(40, 30, 0\) already"),
        ((44, 33, 1), r"\(44, 33, 1\) lies 1 beside the mid-surface of s1, .* the nearest is \(44, 33, 0\)"),
        ((44, 0.2, 0), r"lies 0.2 beside an edge of s1, expected a place on it, such as \(44, 0, 0\)"),
        ((120, 33, 0), r"\(120, 33, 0\) lies 20 beside s1, .* the nearest is \(100, 33, 0\)"),
    ],
)
def test_a_place_that_is_not_in_the_mesh_is_told_with_the_nearest(place, told):
    with pytest.raises(OptionError, match=told):
        add_node(Edited.of(plate("quad4")), place)


def test_a_place_beside_the_mesh_is_brought_onto_it_within_the_tolerance():
    edited = add_node(Edited.of(plate("quad4")), (44, 33, 1), tolerance=1.5)
    assert node_there(edited.model, (44, 33, 0)) < 1e-9


def test_solids_and_free_form_shells_are_refused():
    with pytest.raises(OptionError, match="in solids move the nearest node instead"):
        add_node(Edited.of(solid_cantilever("hex8")), (51, 3, 3))
    model = plate("quad4")
    bent = model.mesh.nodes + np.outer(np.sin(model.mesh.nodes[:, 0] / 20) * model.mesh.nodes[:, 1] / 20, [0, 0, 1])
    wavy = replace(model, mesh=replace(model.mesh, nodes=bent))
    place = bent[wavy.mesh.blocks[0].connectivity[22]].mean(axis=0)
    with pytest.raises(MeshError, match="s1 is neither plane nor a cylinder"):
        add_node(Edited.of(wavy), place)


def test_the_nearest_place_that_is_told_of_a_tube_is_on_its_true_surface():
    model = tube("quad4")
    with pytest.raises(OptionError, match=r"the nearest is \(\S+, \S+, \S+\)") as refused:
        add_node(Edited.of(model), (70 * np.cos(0.4), 70 * np.sin(0.4), 33))
    told = tuple(float(word) for word in str(refused.value).rpartition("(")[2].rstrip(")").split(","))
    assert np.hypot(told[0], told[1]) == pytest.approx(50, rel=1e-5)
    assert node_there(add_node(Edited.of(model), told, tolerance=0.01).model, told) < 0.01


def test_a_place_on_the_axis_of_a_tube_is_refused_with_the_nearest_on_it():
    edited = Edited.of(tube("quad4"))
    axis = surface_of(Workpiece(edited.model, edited.reference), "s1", np.array([50.0, 0, 45])).origin
    with pytest.raises(OptionError, match=r"\(0, 0, 50\) lies .* beside s1, expected a place on it: the nearest is"):
        add_node(edited, axis)
