"""Two adjoining plates, meshed apart: merged, then connected."""

import numpy as np
import pytest
from handmade import STEEL, grid, model_of, second_order
from verification.solvers import run_mystran

from kernel.connect.audit import connected_components
from kernel.connect.couplings import make_couplings
from kernel.connect.equations import rigid_motion_error
from kernel.connect.merge import connect, merge
from kernel.connect.model import Property
from kernel.deck.nastran import nastran_self_weight
from kernel.errors import ConnectError
from kernel.mesh.mesh import ElementBlock, Mesh


def plate(segment: str, start: float, divisions: tuple[int, int]) -> Mesh:
    """100 x 60 from x = start."""
    nodes, quads = grid((start, 0, 0), (100, 0, 0), (0, 60, 0), *divisions)
    return Mesh(nodes, (ElementBlock(segment, "quad4", quads),))


def model(mesh: Mesh, couplings=()):
    properties = [Property(block.segment, "shell", "steel", thickness=5.0) for block in mesh.blocks]
    return model_of(mesh.nodes, mesh.blocks, properties, couplings)


def test_merged_plates_lie_side_by_side_and_are_still_two():
    mesh = merge([plate("s1", 0, (5, 3)), plate("s2", 100, (5, 3))])
    assert mesh.n_node == 2 * 24
    assert connected_components(model(mesh)) == 2


def test_connected_plates_share_the_nodes_of_their_common_edge():
    found = connect(merge([plate("s1", 0, (5, 3)), plate("s2", 100, (5, 3))]))
    assert found.n_joined == 4
    assert found.ties == ()
    assert connected_components(model(found.mesh)) == 1


@pytest.mark.parametrize(("left", "right"), [(6, 3), (3, 6), (5, 3), (4, 7)])
def test_plates_whose_meshes_do_not_match_are_tied_along_the_edge(left, right, tmp_path):
    found = connect(merge([plate("s1", 0, (6, left)), plate("s2", 100, (6, right))]))
    (tie,) = found.ties
    dependents = found.mesh.nodes[tie.dependent]
    assert dependents[:, 0] == pytest.approx(100)
    couplings = make_couplings(found.ties, found.mesh, found.mesh.nodes).couplings
    whole = model(found.mesh, couplings)
    assert connected_components(whole) == 1
    assert max(rigid_motion_error(c, whole.mesh.nodes, np.zeros(3), 200.0) for c in couplings) < 1e-9
    solved = run_mystran(
        nastran_self_weight(whole, np.flatnonzero(whole.mesh.nodes[:, 0] == 0)), tmp_path, whole.mesh.n_node
    )
    assert solved.epsilon < 1e-6
    load = STEEL.density * 9806.65 * 60 * 5
    sag = load * 200**4 / (8 * STEEL.elastic_modulus * 60 * 5**3 / 12)
    assert -solved.displacements[:, 2].min() == pytest.approx(sag, rel=0.06)


def test_the_finer_side_follows_the_coarser():
    found = connect(merge([plate("s1", 0, (5, 3)), plate("s2", 100, (5, 6))]))
    (tie,) = found.ties
    owner = {int(n) for block in found.mesh.blocks if block.segment == "s2" for n in block.connectivity.ravel()}
    assert set(tie.dependent.tolist()) <= owner
    assert len(tie.dependent) == 3


def test_a_web_on_a_plate_is_tied_in_its_middle():
    web, quads = grid((33, 0, 0), (0, 60, 0), (0, 0, 40), 6, 4)
    found = connect(merge([plate("s1", 0, (5, 3)), Mesh(web, (ElementBlock("s2", "quad4", quads),))]))
    assert sum(len(tie.dependent) for tie in found.ties) == 7
    couplings = make_couplings(found.ties, found.mesh, found.mesh.nodes).couplings
    assert connected_components(model(found.mesh, couplings)) == 1


def test_quadratic_edges_connect_too():
    left, right = plate("s1", 0, (2, 2)), plate("s2", 100, (2, 2))
    meshes = []
    for mesh in (left, right):
        nodes, kind, cells = second_order(mesh.nodes, "quad4", mesh.blocks[0].connectivity)
        meshes.append(Mesh(nodes, (ElementBlock(mesh.blocks[0].segment, kind, cells),)))
    assert connect(merge(meshes)).n_joined == 5


def test_plates_apart_stay_apart():
    found = connect(merge([plate("s1", 0, (5, 3)), plate("s2", 101, (5, 3))]))
    assert found.n_joined == 0
    assert found.ties == ()


def test_one_segment_in_two_meshes_is_refused():
    with pytest.raises(ConnectError, match="segment s1 is in two meshes"):
        merge([plate("s1", 0, (5, 3)), plate("s1", 100, (5, 3))])


def test_a_tolerance_that_swallows_elements_is_refused():
    both = merge([plate("s1", 0, (5, 3)), plate("s2", 100, (5, 3))])
    with pytest.raises(ConnectError, match="segment s1 has nodes 20 apart, expected a tolerance under half of that"):
        connect(both, tolerance=10.0)


def test_a_slit_in_a_segment_stays_open():
    slit = merge([plate("s1", 0, (5, 3)), plate("s2", 100, (5, 3))])
    one = Mesh(slit.nodes, (*slit.blocks[:1], ElementBlock("s1", "quad4", slit.blocks[1].connectivity)))
    assert connect(one).n_joined == 0


def test_only_the_segments_asked_for_are_connected():
    three = merge([plate("s1", 0, (5, 3)), plate("s2", 100, (5, 3)), plate("s3", 200, (5, 6))])
    found = connect(three, segments=["s1", "s2"])
    assert (found.n_joined, found.ties) == (4, ())
    with pytest.raises(ConnectError, match="no segment 's9' in the mesh, expected one of s1, s2, s3"):
        connect(three, segments=["s9"])


def test_the_new_numbers_lead_from_the_old_nodes_to_the_same_places():
    both = merge([plate("s1", 0, (5, 3)), plate("s2", 100 + 1e-3, (5, 3))])
    found = connect(both, tolerance=0.01)
    assert np.abs(found.mesh.nodes[found.numbers] - both.nodes).max() == pytest.approx(1e-3)
    assert found.n_joined == 4


def test_a_beams_end_follows_the_plate_it_stands_on():
    nodes = np.array([[33.0, 31.0, 100.0], [33.0, 31.0, 50.0], [33.0, 31.0, 0.0]])
    post = Mesh(nodes, (ElementBlock("s2", "line2", np.array([[0, 1], [1, 2]]), np.tile([1.0, 0, 0], (2, 1))),))
    (tie,) = connect(merge([plate("s1", 0, (5, 3)), post])).ties
    assert tie.dependent.tolist() == [26]
