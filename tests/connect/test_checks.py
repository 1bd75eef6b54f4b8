"""What the checks count, on models with a known fault, and masses against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from handmade import cantilever, grid, i_outline, model_of, shell_cantilever, solid_cantilever
from joined import block_on_plate, half_beam_half_solid, lap_of_plates, post_on_plate

from kernel.connect.audit import coincident_nodes, connected_components, edge_cracks, loose_arms
from kernel.connect.checks import dependence
from kernel.connect.couplings import nodes_with_rotations
from kernel.connect.mass import block_moments, solid_moments, total
from kernel.connect.model import Mpc, Property, Rbe2
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.order import middle_nodes, to_second_order


@pytest.mark.parametrize("make", [post_on_plate, block_on_plate, lap_of_plates, lambda: half_beam_half_solid("work")])
def test_couplings_count_as_connections(make):
    model = make()
    assert connected_components(model) == 1
    assert connected_components(replace(model, couplings=())) == 2


def test_many_pieces_are_all_counted():
    nodes, quads = grid((0, 0, 0), (30, 0, 0), (0, 1, 0), 30, 1)
    model = model_of(nodes, [ElementBlock("s1", "quad4", quads[::2])], [Property("s1", "shell", "steel", 1.0)])
    assert connected_components(model) == 15


def test_a_long_chain_is_one_piece():
    nodes = np.column_stack([np.arange(5000.0), np.zeros((5000, 2))])
    order = np.random.default_rng(3).permutation(5000)
    lines = np.column_stack([order[:-1], order[1:]])
    assert connected_components(model_of(nodes, [ElementBlock("s1", "line2", lines)], [])) == 1


def test_coincident_nodes_count_unless_a_coupling_ties_them():
    nodes, quads = grid((0, 0, 0), (10, 0, 0), (0, 10, 0), 2, 2)
    both = np.vstack([nodes, nodes + [10, 0, 0]])
    blocks = [ElementBlock("s1", "quad4", quads), ElementBlock("s2", "quad4", quads + 9)]
    model = model_of(both, blocks, [])
    assert coincident_nodes(model, 1e-6) == 3
    tied = replace(model, couplings=(Rbe2(6, np.array([9])),))
    assert coincident_nodes(tied, 1e-6) == 2


def two_hexes(step):
    """Two unit cubes, the second one moved by `step`."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], float)
    blocks = [ElementBlock("s1", "hex8", np.arange(8)[None]), ElementBlock("s2", "hex8", np.arange(8, 16)[None])]
    return model_of(np.vstack([corners, corners + step]), blocks, [])


def test_solids_without_a_joint_may_touch_along_a_line_but_not_over_a_face():
    on_a_line, on_a_face = two_hexes([1, 0, 1]), two_hexes([1, 0, 0])
    assert coincident_nodes(on_a_line, 1e-6) == 2
    assert coincident_nodes(on_a_line, 1e-6, joined={("s1", "s2")}) == 2
    assert coincident_nodes(on_a_line, 1e-6, joined=set()) == 0
    assert coincident_nodes(on_a_face, 1e-6, joined=set()) == 4


def test_nodes_at_one_place_that_follow_the_same_node_are_tied():
    model = two_hexes([1, 0, 1])
    first, second = ((1 + 4, 8), (2 + 4, 11))

    def follows(node, other):
        return tuple(Mpc(np.array([node, other]), np.array([k, k]), np.array([-1.0, 1.0])) for k in (1, 2, 3))

    by_a_third = (*follows(first[0], 0), *follows(first[1], 0))
    assert coincident_nodes(replace(model, couplings=by_a_third), 1e-6) == 1
    apart = (*follows(first[0], 0), *follows(first[1], 14), *follows(second[0], 14), *follows(second[1], 14))
    assert coincident_nodes(replace(model, couplings=apart), 1e-6) == 1


def test_the_crack_audit_knows_each_edge():
    nodes, quads = grid((0, 0, 0), (10, 0, 0), (0, 10, 0), 2, 2)
    mesh = model_of(nodes, [ElementBlock("s1", "quad4", quads)], []).mesh
    rim = [(0, 1), (1, 2), (2, 5), (5, 8), (8, 7), (7, 6), (6, 3), (3, 0)]
    good = np.array([(*edge, 1) for edge in rim])
    assert edge_cracks(mesh, good) == 0
    assert edge_cracks(mesh, good[:-1]) == 1  # an edge used once that no curve knows
    assert edge_cracks(mesh, np.vstack([good, [(4, 5, 3)]])) == 1  # two elements where three faces meet
    assert edge_cracks(mesh, np.vstack([good, [(0, 8, 2)]])) == 1  # a curve's edge that no element has


def test_two_walls_may_each_have_an_edge_between_the_nodes_in_which_they_cross() -> None:
    """Two squares over the same four nodes, each cut along the same diagonal; in one wall that would be a fold."""
    nodes = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float)
    halves = np.array([[0, 1, 2], [0, 2, 3]])
    rim = np.array([(0, 1, 2), (1, 2, 2), (2, 3, 2), (0, 3, 2)])
    two = Mesh(nodes, (ElementBlock("s1", "tri3", halves), ElementBlock("s2", "tri3", halves)))
    assert edge_cracks(two, rim) == 0
    folded = Mesh(nodes, (ElementBlock("s1", "tri3", np.concatenate([halves, halves])),))
    assert edge_cracks(folded, rim) == 1


def test_a_freedom_that_depends_twice_or_in_a_chain_is_counted():
    model = shell_cantilever("quad4", divisions=(4, 1))
    turning = nodes_with_rotations(model.mesh)
    twice = (Rbe2(0, np.array([1]), "123"), Rbe2(2, np.array([1]), "12"))
    assert dependence(twice, turning) == (2, 0)
    chain = (Rbe2(0, np.array([1])), Rbe2(1, np.array([2])))
    assert dependence(chain, turning) == (0, 6)


def moments_of(model):
    elements = {element.segment: element for element in model.properties}
    return total([block_moments(b, model.mesh.nodes, elements[b.segment], 1.0) for b in model.mesh.blocks])


@pytest.mark.parametrize("kind", ["hex8", "hex20", "wedge6", "wedge15", "tet4", "tet10"])
def test_a_block_of_solids_has_the_inertia_of_the_block(kind):
    found = moments_of(solid_cantilever(kind, (100, 10, 20), (4, 2, 2)))
    mass = 100 * 10 * 20
    assert found.mass == pytest.approx(mass)
    assert found.centre == pytest.approx([50, 5, 10])
    expected = mass / 12 * np.array([10**2 + 20**2, 100**2 + 20**2, 100**2 + 10**2])
    assert found.inertia == pytest.approx(np.diag(expected), rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("kind", ["tri3", "tri6", "quad4", "quad8"])
def test_a_plate_has_the_inertia_of_its_thickness_too(kind):
    found = moments_of(shell_cantilever(kind, 100, 10, 4, (4, 2)))
    mass = 100 * 10 * 4
    expected = mass / 12 * np.array([10**2 + 4**2, 100**2 + 4**2, 100**2 + 10**2])
    assert found.inertia == pytest.approx(np.diag(expected), rel=1e-9, abs=1e-6)


@pytest.mark.parametrize("kind", ["line2", "line3"])
def test_a_beam_has_the_inertia_of_its_section_too(kind):
    model = cantilever(i_outline(), 1000.0, 4, kind)
    section = model.properties[0].section
    found = moments_of(model)
    about_x = 1000 * (section.iyy + section.izz)
    about_y = 1000 * section.iyy + section.area * 1000**3 / 12
    assert found.inertia[0, 0] == pytest.approx(about_x)
    assert found.inertia[1, 1] == pytest.approx(about_y)


def test_a_closed_surface_has_the_inertia_of_its_body():
    corners = np.array([[x, y, z] for x in (0.0, 100) for y in (0.0, 10) for z in (0.0, 20)]) + [1e4, -5, 7]
    triangles = np.array(
        [
            [0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
            [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3],
        ]
    )  # fmt: skip
    found = solid_moments(corners, triangles, 20000.0)
    assert found.centre == pytest.approx([10050, 0, 17])
    expected = 20000 / 12 * np.array([10**2 + 20**2, 100**2 + 20**2, 100**2 + 10**2])
    assert found.inertia == pytest.approx(np.diag(expected), rel=1e-9, abs=1e-4)


def test_nodes_that_should_hang_and_do_not_are_counted_mid_sides_too():
    nodes, quads = grid((0, 0, 0), (10, 0, 0), (0, 10, 0), 2, 2)
    both = np.vstack([nodes, nodes + [0, -25, 0]])
    mesh = to_second_order(
        model_of(both, [ElementBlock("s1", "quad4", quads), ElementBlock("s2", "quad4", quads + 9)], []).mesh
    )
    middle = middle_nodes(mesh)
    arms = np.array([(0, 1, 15, 16), (1, 2, 16, 17)])
    pairs = [(0, 15), (1, 16), (2, 17), (middle[0, 1], middle[15, 16]), (middle[1, 2], middle[16, 17])]
    held = tuple(Rbe2(independent, np.array([node])) for node, independent in pairs)
    model = replace(model_of(both, [], []), mesh=mesh, couplings=held)
    assert loose_arms(model, arms) == 0
    assert loose_arms(replace(model, couplings=held[1:]), arms) == 1
    assert loose_arms(replace(model, couplings=held[:-1]), arms) == 1
    hinge = Rbe2(15, np.array([0]), "123")
    assert loose_arms(replace(model, couplings=(hinge, *held[1:])), arms) == 1
