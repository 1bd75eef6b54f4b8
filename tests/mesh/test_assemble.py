"""From text to one mesh: every kind of member, alone and joined, is one model without cracks or strays."""

from __future__ import annotations

import numpy as np
import pytest
from assembling import (
    WHOLE,
    assembled,
    audit,
    cube,
    difference,
    extrusion,
    mesh_volume,
    placed,
    rod,
    turned,
    union,
)

from kernel.errors import MeshError

TABLE = union(cube(1500, 800, 25, (0, 0, 760)), *(cube(50, 50, 760, (x, y, 0)) for x in (30, 1420) for y in (30, 720)))
PIPE = difference(
    rod(500, 60),
    rod(600, 56, (0, 0, -50)),
    rod(400, 15, (-200, 0, 250), turned("y", 90)),
    rod(200, 10, (0, 0, 120), turned("x", 90)),
)
PLATE = difference(
    cube(240, 160, 8), rod(20, 20, (60, 80, -5)), *(rod(20, 5, (x, y, -5)) for x in (20, 220) for y in (20, 140))
)


def kinds(assembly):
    return {block.kind for block in assembly.mesh.blocks}


def test_plate_with_holes_has_its_nodes_on_the_true_circles():
    assembly, evaluated = assembled(PLATE, size=8.0)
    assert audit(assembly) == WHOLE
    radius = np.hypot(*(assembly.mesh.nodes[:, :2] - (60, 80)).T)
    assert np.count_nonzero(np.abs(radius - 20) < 1e-9 * evaluated.size) >= 16
    assert radius.min() > 20 - 1e-9 * evaluated.size
    assert np.abs(assembly.mesh.nodes[:, 2] - 4).max() < 1e-9


def test_holes_across_a_pipe_are_traced_on_both_cylinders():
    assembly, evaluated = assembled(PIPE, size=10.0)
    assert audit(assembly) == WHOLE
    x, y, z = assembly.mesh.nodes.T
    assert np.abs(np.hypot(x, y) - 58).max() < 1e-9 * evaluated.size
    on_hole = np.abs(np.hypot(y, z - 250) - 15) < 1e-9 * evaluated.size
    assert np.count_nonzero(on_hole) >= 32  # 16 where it enters, 16 where it leaves
    assert sum(row.volume for row in assembly.ledger) < 1e-3 * evaluated.solid.true_volume


def test_table_is_a_plate_on_four_beams_with_imprinted_footprints():
    assembly, evaluated = assembled(TABLE)
    assert audit(assembly) == WHOLE
    assert kinds(assembly) == {"quad4", "line2"}
    assert [tie.kind for tie in assembly.ties] == ["beam_on_face"] * 4
    for tie in assembly.ties:
        assert tie.weights.sum() == pytest.approx(50 * 50)
        foot = np.average(assembly.mesh.nodes[tie.independent], axis=0, weights=tie.weights)
        assert foot[:2] == pytest.approx(assembly.mesh.nodes[tie.dependent[0], :2])
    assert mesh_volume(assembly) == pytest.approx(evaluated.solid.true_volume)


def test_the_same_table_all_of_bricks_is_one_mesh_of_hexahedra_without_ties():
    overrides = {"0": "brick", "1": "brick", "2": "brick", "3": "brick", "4": "brick"}
    assembly, evaluated = assembled(TABLE, overrides, size=25.0)
    assert audit(assembly) == WHOLE
    assert kinds(assembly) == {"hex8"}
    assert assembly.ties == ()
    assert mesh_volume(assembly) == pytest.approx(evaluated.solid.true_volume)


def test_a_frame_of_touching_beams_is_joined_at_its_stations():
    frame = union(cube(80, 80, 2400), cube(80, 80, 2400, (3200, 0, 0)), cube(3120, 80, 120, (80, 0, 2000)))
    assembly, _ = assembled(frame)
    assert audit(assembly) == WHOLE
    assert [tie.kind for tie in assembly.ties] == ["rigid", "rigid"]
    for tie in assembly.ties:
        arm = assembly.mesh.nodes[tie.dependent[0]] - assembly.mesh.nodes[tie.independent[0]]
        assert np.abs(arm) == pytest.approx([40, 0, 0], abs=1e-9)


def test_a_boss_continues_the_plates_own_elements():
    boss = union(cube(300, 300, 10), rod(60, 35, (150, 150, 10)))
    assembly, evaluated = assembled(boss, size=15.0)
    assert audit(assembly) == WHOLE
    (tie,) = assembly.ties
    assert tie.kind == "rigid_pairs"
    arms = assembly.mesh.nodes[tie.dependent] - assembly.mesh.nodes[tie.independent]
    assert arms == pytest.approx(np.tile([0, 0, 5], (len(arms), 1)), abs=1e-9)
    assert mesh_volume(assembly) == pytest.approx(evaluated.solid.true_volume, rel=2e-2)


def test_a_stiffener_has_its_nodes_opposite_the_plates():
    assembly, _ = assembled(union(cube(1000, 300, 8), cube(1000, 20, 20, (0, 140, 8))))
    assert audit(assembly) == WHOLE
    assert {tie.kind for tie in assembly.ties} == {"rigid"}
    for tie in assembly.ties:
        arm = assembly.mesh.nodes[tie.dependent[0]] - assembly.mesh.nodes[tie.independent[0]]
        assert arm == pytest.approx([0, 0, 14], abs=1e-9)


def test_a_beam_along_another_is_tied_along_its_length():
    assembly, _ = assembled(union(cube(1000, 40, 40), cube(1000, 40, 40, (0, 0, 40))), {"0": "beam", "1": "beam"})
    assert audit(assembly) == WHOLE
    assert len(assembly.ties) > 10


def test_a_beam_ends_on_a_brick_with_the_areas_of_its_faces():
    assembly, _ = assembled(union(cube(200, 200, 200), cube(40, 40, 800, (60, 90, 200))), {"0": "brick"}, size=25.0)
    assert audit(assembly) == WHOLE
    (tie,) = assembly.ties
    assert tie.kind == "beam_on_face"
    assert tie.weights.sum() == pytest.approx(1600)


def test_a_plates_edge_on_a_brick_follows_its_face_turning_too():
    model = union(cube(100, 200, 200), cube(300, 200, 8, (100, 0, 96)))
    assembly, _ = assembled(model, {"0": "brick"}, size=20.0)
    assert audit(assembly) == WHOLE
    assert {tie.kind for tie in assembly.ties} == {"beam_on_face"}
    assert sum(tie.weights.sum() for tie in assembly.ties) == pytest.approx(200 * 8)


def test_bricks_with_meshes_that_differ_are_interpolated():
    model = union(cube(120, 120, 120), extrusion([(0, 0), (60, 0), (30, 50)], 80, (120, 30, 20), turned("y", 90)))
    assembly, _ = assembled(model, {"0": "brick", "1": "brick"}, size=20.0, volumes="tet")
    assert audit(assembly) == WHOLE
    (tie,) = assembly.ties
    assert tie.kind == "interpolated"
    for node, hosts, weights in zip(tie.dependent, tie.hosts, tie.host_weights):
        assert weights @ assembly.mesh.nodes[hosts] == pytest.approx(assembly.mesh.nodes[node], abs=1e-6)


def test_a_lap_follows_the_larger_plate():
    assembly, _ = assembled(union(cube(220, 100, 8), cube(200, 100, 6, (170, 0, 8))))
    assert audit(assembly) == WHOLE
    (tie,) = assembly.ties
    assert tie.kind == "interpolated"
    assert np.allclose([weights.sum() for weights in tie.host_weights], 1.0)


@pytest.mark.parametrize("faces", ["quad", "tri"])
def test_faces_are_of_the_kind_asked_for(faces):
    assembly, _ = assembled(PLATE, size=10.0, faces=faces)
    assert kinds(assembly) == {"quad4" if faces == "quad" else "tri3"}
    assert audit(assembly) == WHOLE


def test_second_order_puts_middles_on_true_curves_and_into_ties():
    boss = union(cube(300, 300, 10), rod(60, 35, (150, 150, 10)))
    first, _ = assembled(boss, size=15.0)
    second, evaluated = assembled(boss, size=15.0, order=2)
    assert kinds(second) == {"quad8", "hex20"}
    assert audit(second).components == 1
    assert len(second.ties[0].dependent) > 2 * len(first.ties[0].dependent)
    middles = second.mesh.nodes[first.mesh.n_node :]
    radius = np.hypot(*(middles[:, :2] - (150, 150)).T)
    assert np.count_nonzero(np.abs(radius - 35) < 1e-9 * evaluated.size) >= 16


def test_hexahedra_only_are_refused_where_a_brick_cannot_be_swept():
    flattened = difference(
        "sphere($fn=0,$fa=6,$fs=1,r=50);", cube(100, 100, 100, (30, -50, -50)), rod(200, 9, (0, 0, -99))
    )
    with pytest.raises(MeshError, match=r"s1 \(/\) cannot be meshed with hexahedra only: .* the sphere near \("):
        assembled(flattened, {"/": "brick"}, size=20.0, volumes="hex")


def test_a_segments_own_size_holds_along_its_curves():
    model = union(cube(200, 120, 10), cube(200, 8, 100, (0, 56, 10)))
    coarse, _ = assembled(model, size=20.0)
    fine, _ = assembled(model, size=20.0, sizes={"s2": 5.0})
    assert audit(fine) == WHOLE
    assert len(fine.mesh.blocks[1].connectivity) > 10 * len(coarse.mesh.blocks[1].connectivity)
    assert len(fine.mesh.blocks[0].connectivity) > len(coarse.mesh.blocks[0].connectivity)


def test_the_same_text_gives_the_same_mesh():
    once, _ = assembled(TABLE)
    again, _ = assembled(TABLE)
    assert np.array_equal(once.mesh.nodes, again.mesh.nodes)
    for one, other in zip(once.mesh.blocks, again.mesh.blocks):
        assert np.array_equal(one.connectivity, other.connectivity)


def test_progress_is_told_up_to_the_end():
    told: list[tuple[str, float]] = []
    assembled(TABLE, progress=lambda stage, share: told.append((stage, share)))
    shares = [share for _, share in told]
    assert shares == sorted(shares)
    assert shares[-1] == 1.0


@pytest.mark.parametrize("lean", [0, 30])
def test_a_hollow_member_meets_another_where_its_axis_does(lean):
    # the contact is a ring: its middle lies in the hollow, no part of it
    hollow = difference(cube(60, 60, 1600, (-30, -30, -300)), cube(52, 52, 1600, (-26, -26, -300)))
    below = cube(4000, 4000, 4000, (-2000, -2000, -4000))
    rail = difference(cube(3000, 60, 60, (-1000, -30, -60)), cube(3000, 52, 52, (-1000, -26, -56)))
    post = difference(placed(hollow, turn=turned("y", lean)), below)
    result, evaluated = assembled(union(rail, post), size=100)
    (tie,) = result.ties
    ends = [int(tie.dependent[0]), int(tie.independent[0])]
    places = sorted((result.mesh.nodes[ends] @ evaluated.frame.T).tolist(), key=lambda place: place[2])
    assert np.array(places) == pytest.approx(np.array([[0, 0, -30], [0, 0, 0]]), abs=1e-9)
