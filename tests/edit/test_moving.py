"""Nodes moved along what they stand on; refused, with the reason and the nearest place, where they would leave it."""

from dataclasses import replace

import numpy as np
import pytest
from handmade import (
    cantilever,
    grid,
    i_outline,
    model_of,
    second_order,
    shell_cantilever,
    solid_cantilever,
)

from kernel.connect.checks import check_against
from kernel.connect.model import Property
from kernel.edit.edited import Edited
from kernel.edit.moving import move_node
from kernel.errors import MeshError
from kernel.mesh.mesh import ElementBlock


def moved(model, at, to, **reference):
    edited = Edited.of(model)
    return move_node(replace(edited, reference=replace(edited.reference, **reference)), at, to)


def turn():
    """An inclined frame: rotation (3, 3)."""
    turned = np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]
    return turned * np.sign(np.linalg.det(turned))


def tube(kind="quad4", frame=None):
    """Radius 50, length 100, elements of 15 degrees by 10; nodes and mid-side nodes on the true cylinder."""
    flat, quads = grid((0, 0, 0), (2 * np.pi, 0, 0), (0, 100, 0), 24, 10)
    if kind == "quad8":
        flat, _, quads = second_order(flat, "quad4", quads)
    places = np.column_stack([50 * np.cos(flat[:, 0]), 50 * np.sin(flat[:, 0]), flat[:, 1]])
    places, first = np.unique(np.round(places, 9), axis=0, return_inverse=True)
    places = places if frame is None else places @ frame.T
    return model_of(
        places,
        [ElementBlock("s1", kind, first.reshape(-1)[quads])],
        [Property("s1", "shell", "steel", thickness=2.0)],
    )


def on_tube(degrees, z, frame=None):
    place = np.array([50 * np.cos(np.radians(degrees)), 50 * np.sin(np.radians(degrees)), z])
    return place if frame is None else frame @ place


def tee():
    """A plate of 100 x 60 in z = 0 (s1) and one of 100 x 20 that stands on it along y = 30 (s2)."""
    nodes, quads = grid((0, 0, 0), (100, 0, 0), (0, 60, 0), 10, 6)
    upper, standing = grid((0, 30, 0), (100, 0, 0), (0, 0, 20), 10, 2)
    places, number = np.unique(np.vstack([nodes, upper]), axis=0, return_inverse=True)
    number = number.reshape(-1)
    blocks = [ElementBlock("s1", "quad4", number[quads]), ElementBlock("s2", "quad4", number[len(nodes) + standing])]
    return model_of(places, blocks, [Property(name, "shell", "steel", thickness=2.0) for name in ("s1", "s2")])


# ---------------------------------------------------------------- surfaces


def test_a_node_does_not_leave_its_plate():
    model = shell_cantilever("quad4", 100, 60, 2, (10, 6))
    with pytest.raises(MeshError, match=r"at \(40, 30, 0\) would leave the surface of s1 by 3, .* is \(42, 31, 0\)"):
        moved(model, (40, 30, 0), (42, 31, 3))


def test_a_node_of_a_turned_tube_stays_on_its_cylinder():
    frame = turn()
    model = tube(frame=frame)
    at, to = on_tube(30, 40, frame), on_tube(34, 43, frame)
    assert np.linalg.norm(moved(model, at, to).model.mesh.nodes - to, axis=1).min() < 1e-9
    with pytest.raises(MeshError, match="would leave the surface of s1 by 1,"):
        moved(model, at, frame @ (np.array([51, 51, 1]) * (frame.T @ to) / [50, 50, 1]))


def test_mid_side_nodes_beside_it_stay_on_the_cylinder_and_on_its_rim():
    for z, to_z in ((40, 43), (0, 0)):
        edited = moved(tube("quad8"), on_tube(30, z), on_tube(34, to_z))
        assert np.hypot(*edited.model.mesh.nodes[:, :2].T) == pytest.approx(50.0, abs=1e-6)
        assert check_against(edited.model, edited.reference).cracks == 0
    between = np.degrees(np.arctan2(*edited.model.mesh.nodes[:, 1::-1].T))
    on_rim = np.sort(between[np.abs(edited.model.mesh.nodes[:, 2]) < 1e-9])
    np.testing.assert_allclose(on_rim[(on_rim > 14) & (on_rim < 46)], [15, 24.5, 34, 39.5, 45], atol=1e-6)


# ---------------------------------------------------------------- curves


def test_a_node_on_a_joint_slides_along_it_and_leaves_it_not():
    edited = moved(tee(), (40, 30, 0), (43, 30, 0))
    assert check_against(edited.model, edited.reference).passed
    with pytest.raises(MeshError, match=r"would leave the surface of s2 by 2, .* the nearest is \(40, 30, 0\)"):
        moved(tee(), (40, 30, 0), (40, 32, 0))
    with pytest.raises(MeshError, match="would leave the surface of s1 by 2"):
        moved(tee(), (40, 30, 0), (40, 30, 2))


@pytest.mark.parametrize("kind", ["quad4", "tri3", "quad8"])
def test_a_node_on_a_rim_slides_along_it_and_leaves_it_not(kind):
    model = shell_cantilever(kind, 100, 60, 2, (10, 6))
    edited = moved(model, (40, 0, 0), (42, 0, 0))
    assert abs(check_against(edited.model, edited.reference).mass_error) < 1e-12
    with pytest.raises(MeshError, match=r"would leave the curve .* by 1, .* the nearest is \(42, 0, 0\)"):
        moved(model, (40, 0, 0), (42, 1, 0))
    with pytest.raises(MeshError, match="would pass its neighbour on the curve"):
        moved(model, (40, 0, 0), (55, 0, 0))


def test_a_corner_stays_where_it_is_and_so_does_the_end_of_a_joint():
    model = shell_cantilever("quad4", 100, 60, 2, (10, 6))
    with pytest.raises(MeshError, match=r"at \(100, 60, 0\) is a corner"):
        moved(model, (100, 60, 0), (98, 60, 0))
    with pytest.raises(MeshError, match="is where 4 curves meet"):
        moved(tee(), (100, 30, 0), (98, 30, 0))


def test_a_node_on_a_round_rim_slides_along_the_circle():
    edited = moved(tube(), on_tube(30, 0), on_tube(35, 0))
    assert np.linalg.norm(edited.model.mesh.nodes - on_tube(35, 0), axis=1).min() < 1e-9
    with pytest.raises(MeshError, match="would leave the curve"):
        moved(tube(), on_tube(30, 0), on_tube(30, 2))
    with pytest.raises(MeshError, match="would pass its neighbour"):
        moved(tube(), on_tube(30, 0), on_tube(50, 0))


def test_a_node_of_a_beam_slides_along_its_axis_but_its_end_stays():
    model = cantilever(i_outline(), 1000.0, 10)
    assert np.isclose(moved(model, (400, 0, 0), (430, 0, 0)).model.mesh.nodes[:, 0], 430).any()
    with pytest.raises(MeshError, match="would leave the curve"):
        moved(model, (400, 0, 0), (400, 5, 0))
    with pytest.raises(MeshError, match="is the end of a curve"):
        moved(model, (1000, 0, 0), (990, 0, 0))


def test_a_node_that_carries_rigid_arms_stays():
    model = shell_cantilever("quad4", 100, 60, 2, (10, 6))
    node = int(np.argmin(np.linalg.norm(model.mesh.nodes - (40, 30, 0), axis=1)))
    with pytest.raises(MeshError, match=r"at \(40, 30, 0\) hangs by a rigid arm, or carries one"):
        moved(model, (40, 30, 0), (42, 31, 0), arms=np.array([[0, 1, node, node + 1]]))


# ---------------------------------------------------------------- solids


@pytest.mark.parametrize("kind", ["hex8", "tet4", "hex20"])
def test_a_node_of_solids_moves_within_and_in_its_face_and_along_its_edge(kind):
    model = solid_cantilever(kind)
    for at, to in (((50, 5, 5), (51, 5.5, 4.5)), ((50, 5, 10), (51, 5.5, 10)), ((50, 0, 10), (51, 0, 10))):
        edited = moved(model, at, to)
        assert abs(check_against(edited.model, edited.reference).mass_error) < 1e-12
    for at, to in (((50, 5, 10), (50, 5, 10.5)), ((50, 0, 10), (50, 0.5, 10)), ((100, 0, 10), (99.5, 0, 10))):
        with pytest.raises(MeshError, match=r"would leave the flat outer face of s1 by 0.5, .* the nearest is \("):
            moved(model, at, to)
