"""What touches half a thickness apart is tied as meshing both together ties it, and nothing else is."""

from dataclasses import replace

import numpy as np
import pytest
from handmade import beam_property, brick, grid, i_outline, line_block, model_of, second_order
from joined import block_on_plate, half_beam_half_solid, lap_of_plates, post_on_plate
from shapely import Point, box

from kernel.connect.audit import connected_components
from kernel.connect.checks import check_against
from kernel.connect.facing import facing_ties
from kernel.connect.model import Property
from kernel.edit.connecting import connect_model
from kernel.edit.edited import Edited
from kernel.errors import ConnectError
from kernel.mesh.mesh import ElementBlock

REACH = 1e-4


def ties_of(model, bound=(), coupled=()):
    names = [element.segment for element in model.properties]
    return facing_ties(model.mesh, model.properties, REACH, names, bound, coupled)


def shell(segment, corner, along, across, n, m, thickness, start=0, order=1):
    nodes, cells = grid(corner, along, across, n, m)
    kind = "quad4"
    if order == 2:
        nodes, kind, cells = second_order(nodes, kind, cells)
    return nodes, ElementBlock(segment, kind, cells + start), Property(segment, "shell", "steel", thickness=thickness)


def together(*parts):
    nodes = np.vstack([part[0] for part in parts])
    return model_of(nodes, [part[1] for part in parts], [part[2] for part in parts])


def turned(model):
    """The model turned about an odd axis and shifted."""
    axis = np.array([1.0, 2.0, 0.5]) / np.linalg.norm([1.0, 2.0, 0.5])
    cross = np.cross(np.eye(3), axis)
    turn = np.eye(3) + np.sin(0.7) * cross + (1 - np.cos(0.7)) * cross @ cross
    blocks = [
        block if block.orientation is None else replace(block, orientation=block.orientation @ turn)
        for block in model.mesh.blocks
    ]
    return model_of(model.mesh.nodes @ turn + [13.0, -7.0, 5.0], blocks, model.properties, model.couplings)


PLACES = pytest.mark.parametrize("place", [lambda model: model, turned], ids=["straight", "turned"])


@PLACES
def test_a_lap_is_tied_as_by_hand(place):
    model = place(lap_of_plates())
    (tie,) = ties_of(model)
    lower, upper = (set(block.connectivity.ravel().tolist()) for block in model.mesh.blocks)
    assert set(tie.dependent.tolist()) < lower and tie.has_rotations  # of two as large as each other the first
    assert len(tie.dependent) == 5 * 5
    for node, hosts, weights in zip(tie.dependent, tie.hosts, tie.host_weights, strict=True):
        assert set(hosts.tolist()) <= upper and weights.sum() == pytest.approx(1)
        arm = model.mesh.nodes[node] - weights @ model.mesh.nodes[hosts]
        assert np.linalg.norm(arm) == pytest.approx(4.0)


@PLACES
@pytest.mark.parametrize("post", [0.0, 0.3])
def test_a_beam_that_stands_on_a_plate_follows_what_its_section_covers(place, post):
    model = post_on_plate()
    model.mesh.nodes.flags.writeable = True
    model.mesh.nodes[-6:, :2] += post
    (tie,) = ties_of(place(model))
    assert (tie.kind, tie.dependent.tolist()) == ("beam_on_face", [len(model.mesh.nodes) - 6])
    assert tie.weights.sum() == pytest.approx(400)
    centre = tie.weights @ model.mesh.nodes[tie.independent] / tie.weights.sum()
    assert centre[:2] == pytest.approx([50 + post, 50 + post], abs=1e-9 if post == 0 else 0.31)


@PLACES
def test_a_beam_that_goes_on_from_a_solid_follows_its_end_face(place):
    model = half_beam_half_solid("distributing")
    (own,) = model.couplings
    (tie,) = ties_of(place(model))
    assert (tie.kind, tie.dependent.tolist()) == ("beam_on_face", [own.dependent])
    assert np.array_equal(np.sort(own.independent), tie.independent)
    order = np.argsort(own.independent)
    assert tie.weights / tie.weights.sum() == pytest.approx(own.weights[order] / own.weights.sum())


@PLACES
def test_a_block_on_a_plate_follows_it(place):
    model = block_on_plate()
    (tie,) = ties_of(place(model))
    assert (tie.kind, tie.has_rotations, len(tie.dependent)) == ("interpolated", False, 9)
    assert (model.mesh.nodes[tie.dependent, 2] == 2.5).all()


@PLACES
@pytest.mark.parametrize("order", [1, 2])
def test_the_edge_of_a_plate_on_a_solid_follows_the_strip_of_its_thickness(place, order):
    nodes, hexes = brick((50, 60, 40), (3, 4, 5))
    block = (nodes, ElementBlock("s1", "hex8", hexes), Property("s1", "solid", "steel"))
    fin = shell("s2", (50, 0, 20), (80, 0, 0), (0, 60, 0), 5, 3, 6.0, len(nodes), order)
    ties = ties_of(place(together(block, fin)))
    rim = np.flatnonzero(np.isclose(fin[0][:, 0], 50)) + len(nodes)
    assert sorted(int(tie.dependent[0]) for tie in ties) == rim.tolist()
    assert sum(tie.weights.sum() for tie in ties) == pytest.approx(60 * 6)
    assert {tie.kind for tie in ties} == {"beam_on_face"}


@PLACES
def test_solids_whose_meshes_do_not_match_are_tied_in_their_contact(place):
    nodes, hexes = brick((100, 60, 40), (5, 4, 3))
    more, others = brick((30, 40, 20), (2, 5, 3))
    model = model_of(
        np.vstack([nodes, more + [100, 10, 10]]),
        [ElementBlock("s1", "hex8", hexes), ElementBlock("s2", "hex8", others + len(nodes))],
        [Property("s1", "solid", "steel"), Property("s2", "solid", "steel")],
    )
    (tie,) = ties_of(place(model))
    assert len(tie.dependent) == 6 * 4 and (model.mesh.nodes[tie.dependent, 0] == 100).all()


def test_plates_of_unlike_thickness_that_butt_flush_are_tied_rim_to_rim():
    left = shell("s1", (0, 0, 4), (100, 0, 0), (0, 60, 0), 5, 4, 8.0)
    right = shell("s2", (100, 0, 6), (80, 0, 0), (0, 60, 0), 5, 3, 12.0, len(left[0]))
    (tie,) = ties_of(together(left, right))
    assert sorted(tie.dependent.tolist()) == list(range(len(left[0]), len(left[0]) + 4))


def tube_with_doubler(n):
    """A shell round an axis, radius 50, and a patch of another division outside it."""

    def part(segment, radius, start, angles, n_along, first):
        t, z = np.meshgrid(angles, np.linspace(0, 60, n_along + 1), indexing="ij")
        nodes = np.column_stack([radius * np.cos(t).ravel(), radius * np.sin(t).ravel(), z.ravel()])
        index = np.arange(t.size).reshape(t.shape)
        quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], -1).reshape(-1, 4) + first
        return nodes, ElementBlock(segment, "quad4", quads), Property(segment, "shell", "steel", thickness=start)

    host = part("s1", 50.0, 4.0, np.linspace(-1.5, 1.5, n + 1), 4, 0)
    return together(host, part("s2", 53.0, 2.0, np.linspace(-0.61, 0.57, n // 2), 5, len(host[0])))


@PLACES
@pytest.mark.parametrize("n", [8, 20, 61])
def test_a_doubler_on_a_tube_follows_it_though_its_nodes_lie_a_little_off_the_chords(place, n):
    (tie,) = ties_of(place(tube_with_doubler(n)))
    assert len(tie.dependent) == n // 2 * 6


@PLACES
def test_a_rail_along_a_plate_follows_it(place):
    plate = shell("s1", (0, 0, 0), (100, 0, 0), (0, 60, 0), 5, 4, 6.0)
    rail = np.column_stack([np.linspace(10, 90, 8), np.full(8, 31.0), np.full(8, 3.0 + 10.0)])
    beam = (
        rail,
        line_block("s2", range(len(plate[0]), len(plate[0]) + 8), (0, 1, 0)),
        beam_property("s2", box(0, 0, 8, 20)),
    )
    (tie,) = ties_of(place(together(plate, beam)))
    assert len(tie.dependent) == 8 and tie.has_rotations


@PLACES
@pytest.mark.parametrize(("at", "kind"), [(500.0, "rigid"), (430.0, "interpolated")])
def test_a_beam_that_ends_on_the_side_of_another_follows_it(place, at, kind):
    rail = np.column_stack([np.linspace(0, 1000, 5), np.zeros(5), np.zeros(5)])
    rung = np.column_stack([np.full(4, at), np.linspace(25, 300, 4), np.zeros(4)])
    model = model_of(
        np.vstack([rail, rung]),
        [line_block("s1", range(5), (0, 1, 0)), line_block("s2", range(5, 9), (1, 0, 0))],
        [beam_property("s1", box(0, 0, 50, 30)), beam_property("s2", Point(0, 0).buffer(12))],
    )
    (tie,) = ties_of(place(model))
    assert (tie.kind, tie.dependent.tolist()) == (kind, [5])


@PLACES
def test_beams_side_by_side_are_tied_along(place):
    one = np.column_stack([np.linspace(0, 400, 5), np.zeros(5), np.zeros(5)])
    other = np.column_stack([np.linspace(100, 300, 4), np.full(4, 25.0), np.zeros(4)])
    model = model_of(
        np.vstack([one, other]),
        [line_block("s1", range(5), (0, 1, 0)), line_block("s2", range(5, 9), (0, 1, 0))],
        [beam_property("s1", box(0, 0, 20, 30)), beam_property("s2", box(0, 0, 30, 10))],
    )
    assert sum(len(tie.dependent) for tie in ties_of(place(model))) in (3, 4)


@PLACES
def test_the_rim_of_a_plate_on_the_side_of_a_beam_follows_it(place):
    panel = shell("s1", (0, 10, 0), (100, 0, 0), (0, 60, 0), 5, 3, 6.0)
    rail = np.column_stack([np.linspace(-20, 120, 8), np.zeros(8), np.zeros(8)])
    n = len(panel[0])
    beam = (rail, line_block("s2", range(n, n + 8), (0, 1, 0)), beam_property("s2", box(0, 0, 20, 30)))
    model = together(panel, beam)
    ties = ties_of(place(model))
    dependents = [int(tie.dependent[0]) for tie in ties]
    assert dependents == np.flatnonzero(panel[0][:, 1] == 10).tolist()


@PLACES
def test_a_stiffener_between_flanges_follows_the_beam_with_its_three_edges(place):
    n = 7
    rail = np.column_stack([np.linspace(-300, 300, n), np.zeros(n), np.zeros(n)])
    beam = (rail, line_block("s1", range(n), (0, 1, 0)), beam_property("s1", i_outline()))
    stiffener = shell("s2", (0, 3, -42), (0, 47, 0), (0, 0, 84), 4, 8, 6.0, n)
    ties = ties_of(place(together(beam, stiffener)))
    on_beam = np.isclose(stiffener[0][:, 1], 3) | np.isclose(np.abs(stiffener[0][:, 2]), 42)
    assert [int(tie.dependent[0]) for tie in ties] == (np.flatnonzero(on_beam) + n).tolist()


@pytest.mark.parametrize("n", [8, 12, 20])
def test_the_rim_of_a_hole_on_a_shaft_follows_it_though_their_chords_differ(n):
    shaft = ring_of_bricks(20.0, 40.0, 16)
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(n)])
    rim = np.arange(n) + len(shaft[0])
    quads = np.column_stack([rim, rim + n, np.roll(rim, -1) + n, np.roll(rim, -1)])
    nodes = np.vstack([20 * circle, 60 * circle]) + [0, 0, 17.0]
    disc = (nodes, ElementBlock("s2", "quad4", quads), Property("s2", "shell", "steel", thickness=6.0))
    ties = ties_of(together(shaft, disc))
    assert [int(tie.dependent[0]) for tie in ties] == rim.tolist()


def ring_of_bricks(radius, height, n):
    """A hollow shaft of hexahedra, n to a turn, its outside on the radius."""
    turn = np.linspace(0, 2 * np.pi, n, endpoint=False)
    circle = np.column_stack([np.cos(turn), np.sin(turn), np.zeros(n)])
    nodes = np.vstack([r * circle + [0, 0, z] for z in (0, height / 2, height) for r in (radius / 2, radius)])
    inner, after = np.arange(n), np.roll(np.arange(n), -1)
    low = np.column_stack([inner, inner + n, after + n, after])
    hexes = np.vstack([np.hstack([low + 2 * n * k, low + 2 * n * (k + 1)]) for k in (0, 1)])
    return nodes, ElementBlock("s1", "hex8", hexes), Property("s1", "solid", "steel")


# ---------------------------------------------------------------- what does not touch


@pytest.mark.parametrize("gap", [-0.5, 0.01, 2.0])
def test_a_gap_or_bodies_in_one_another_are_no_contact(gap):
    for make, segment in ((lap_of_plates, 1), (post_on_plate, 1), (block_on_plate, 1)):
        model = make()
        nodes = model.mesh.nodes.copy()
        nodes[np.unique(model.mesh.blocks[segment].connectivity)] += [0, 0, gap]
        apart = model_of(nodes, model.mesh.blocks, model.properties)
        assert ties_of(apart) == ()


def test_a_web_whose_rows_stand_as_high_as_a_lap_is_no_lap():
    """A tee: rows of the web are (6 + 6) / 2 apart."""
    flange = shell("s1", (0, 0, 0), (100, 0, 0), (0, 60, 0), 5, 4, 6.0)
    web = shell("s2", (0, 31, 6), (100, 0, 0), (0, 0, 60), 5, 10, 6.0, len(flange[0]))
    assert ties_of(together(flange, web)) == ()


def test_a_beam_that_leads_away_through_a_plate_does_not_stand_on_it():
    model = post_on_plate()
    nodes = model.mesh.nodes.copy()
    nodes[-6:, 2] = 2.5 - np.linspace(0, 50, 6)
    assert ties_of(model_of(nodes, model.mesh.blocks, model.properties)) == ()


def test_what_is_coupled_or_depends_already_is_left_alone():
    model = lap_of_plates()
    assert ties_of(model, coupled=[frozenset(("s1", "s2"))]) == ()
    (tie,) = ties_of(model)
    (rest,) = ties_of(model, bound=tie.dependent[:10].tolist())
    assert set(rest.dependent.tolist()) == set(tie.dependent[10:].tolist())


# ---------------------------------------------------------------- connected


@pytest.mark.parametrize("make", [lap_of_plates, post_on_plate, block_on_plate, lambda: half_beam_half_solid("rigid")])
def test_connected_models_pass_their_checks_and_are_connected_once(make):
    model = make()
    bare = Edited.of(model_of(model.mesh.nodes, model.mesh.blocks, model.properties))
    edited = connect_model(bare)
    checks = check_against(edited.model, edited.reference)
    assert checks.passed, checks.failures
    assert connected_components(edited.model) == 1
    with pytest.raises(ConnectError, match="nothing to connect"):
        connect_model(edited)


def test_an_i_on_a_plate_is_a_weighted_average_still():
    plate = shell("s1", (0, 0, 0), (300, 0, 0), (0, 200, 0), 12, 8, 10.0)
    post = np.column_stack([np.full(5, 150.0), np.full(5, 100.0), 5 + np.linspace(0, 800, 5)])
    n = len(plate[0])
    beam = (post, line_block("s2", range(n, n + 5), (1, 0, 0)), beam_property("s2", i_outline()))
    edited = connect_model(Edited.of(together(plate, beam)))
    (coupling,) = edited.model.couplings
    assert coupling.dependent == n
    assert coupling.weights.sum() == pytest.approx(beam[2].section.area)
