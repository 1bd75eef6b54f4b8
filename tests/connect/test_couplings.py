"""Couplings: rigid motions free of strain, each freedom dependent once, no chains, whatever the ties."""

import numpy as np
import pytest
from handmade import grid, line_block
from hypothesis import given, settings
from hypothesis import strategies as st
from joined import block_on_plate, half_beam_half_solid, lap_of_plates, post_on_plate

from kernel.connect.arrange import defines_rotation
from kernel.connect.checks import dependence
from kernel.connect.couplings import make_couplings, nodes_with_rotations
from kernel.connect.equations import average_matrices, rigid_motion_error
from kernel.connect.model import Mpc, Rbe2, Rbe3
from kernel.errors import ConnectError, OptionError
from kernel.mesh.assembly import Tie
from kernel.mesh.mesh import ElementBlock, Mesh

JOINED = [
    *((half_beam_half_solid, kind) for kind in ("distributing", "rigid", "work")),
    *((post_on_plate, kind) for kind in ("distributing", "rigid", "work")),
]


def worst_rigid_motion(couplings, nodes) -> float:
    size = float(np.linalg.norm(np.ptp(nodes, axis=0)))
    return max(rigid_motion_error(coupling, nodes, nodes.mean(axis=0), size) for coupling in couplings)


def consistent(couplings, mesh) -> bool:
    return dependence(tuple(couplings), nodes_with_rotations(mesh)) == (0, 0)


@pytest.mark.parametrize(("make", "kind"), JOINED)
def test_no_coupling_resists_a_rigid_motion(make, kind):
    model = make(kind)
    assert worst_rigid_motion(model.couplings, model.mesh.nodes) < 1e-9
    assert consistent(model.couplings, model.mesh)


@pytest.mark.parametrize("make", [block_on_plate, lap_of_plates])
def test_blocks_and_laps_do_not_resist_a_rigid_motion(make):
    model = make()
    assert worst_rigid_motion(model.couplings, model.mesh.nodes) < 1e-9
    assert consistent(model.couplings, model.mesh)


def test_a_beam_on_a_face_follows_its_average_by_area():
    (coupling,) = post_on_plate().couplings
    assert isinstance(coupling, Rbe3)
    assert coupling.weights.max() == pytest.approx(4 * coupling.weights.min())  # inside against a corner of the foot
    assert coupling.weights.sum() == pytest.approx(400)


def test_on_request_a_beam_on_a_face_is_rigid():
    (coupling,) = post_on_plate("rigid").couplings
    assert isinstance(coupling, Rbe2)
    assert len(coupling.dependent) == 9 and coupling.components == "123456"


def test_a_rigid_face_of_a_solid_has_no_rotations_to_tie():
    (coupling,) = half_beam_half_solid("rigid").couplings
    assert coupling.components == "123"


def test_a_work_coupling_is_six_equations_on_the_beams_end():
    couplings = half_beam_half_solid("work").couplings
    assert [type(coupling) for coupling in couplings] == [Mpc] * 6
    assert [int(coupling.components[0]) for coupling in couplings] == [1, 2, 3, 4, 5, 6]


def test_work_puts_the_stresses_of_beam_theory_on_the_face_as_consistent_loads():
    """At a corner of an a x b face: the stress at the shape function's centre, b / 3 inside, times a b / 4."""
    width, height, ny, nz = 20.0, 30.0, 4, 6
    model = half_beam_half_solid("work", (200.0, width, height), (40, ny, nz))
    by_component = {int(each.components[0]): each for each in model.couplings}
    a, b = width / ny, height / nz
    for component, stress_at_corner, slope in (
        (1, 1 / (width * height), 0.0),
        (5, height / 2 / (width * height**3 / 12), 12 / (width * height**3)),
    ):
        equation = by_component[component]
        places = model.mesh.nodes[equation.nodes]
        along_x = equation.components == 1
        (corner,) = np.flatnonzero(
            along_x & (places[:, 1] == width) & (places[:, 2] == height) & (np.arange(len(places)) > 0)
        )
        share = a * b / 4 * (stress_at_corner - slope * b / 3)
        assert equation.coefficients[corner] == pytest.approx(share, rel=1e-6)


def test_an_average_is_the_weighted_mean_and_the_best_fit_rotation():
    points = np.array([[0.0, 0, 0], [2, 0, 0], [2, 2, 0], [0, 2, 0]])
    translation, rotation = average_matrices(points, np.ones(4), np.array([1.0, 1, 0]))
    warped = np.array([[0, 0, 1.0], [0, 0, -1], [0, 0, 1], [0, 0, -1]])  # an hourglass: no mean motion
    assert np.allclose(np.einsum("inj,nj->i", translation, warped), 0)
    assert np.allclose(np.einsum("inj,nj->i", rotation, warped), 0)


def plates(n=4):
    nodes, quads = grid((0, 0, 0), (40, 0, 0), (0, 40, 0), n, n)
    return nodes, ElementBlock("s1", "quad4", quads)


def with_lines(nodes, block, *starts):
    """The plate, and a vertical line of two nodes at each start; the numbers of the lines' first nodes."""
    extra = np.concatenate([np.array([start, np.add(start, (0, 0, 30))], float) for start in starts])
    n = len(nodes)
    firsts = [n + 2 * k for k in range(len(starts))]
    lines = [line_block(f"s{k + 2}", (f, f + 1), (1, 0, 0)) for k, f in enumerate(firsts)]
    return Mesh(np.vstack([nodes, extra]), (block, *lines)), firsts


def test_a_patch_on_a_line_becomes_rigid():
    nodes, block = plates()
    mesh, (foot,) = with_lines(nodes, block, (20, 0, 0))
    line = np.flatnonzero(nodes[:, 1] == 0)
    couplings = make_couplings(
        [Tie("beam_on_face", None, np.array([foot]), line, np.ones(5))], mesh, mesh.nodes
    ).couplings
    assert [type(coupling) for coupling in couplings] == [Rbe2]
    assert worst_rigid_motion(couplings, mesh.nodes) < 1e-9


def test_what_hangs_rigidly_on_an_averaged_node_gets_the_same_average():
    nodes, block = plates()
    mesh, (foot, other) = with_lines(nodes, block, (20, 20, 2), (25, 20, 2))
    patch = np.array([6, 7, 11, 12])
    ties = [
        Tie("rigid", None, np.array([other]), np.array([foot])),
        Tie("beam_on_face", None, np.array([foot]), patch, np.ones(4)),
    ]
    for order in (ties, ties[::-1]):
        couplings = make_couplings(order, mesh, mesh.nodes).couplings
        assert [(type(c), c.dependent) for c in couplings] == [(Rbe3, foot), (Rbe3, other)]
        assert consistent(couplings, mesh)


def on_two_patches(mesh, foot, first, second):
    """The beam's first node rests on two patches of four nodes."""
    ties = [
        Tie("beam_on_face", None, np.array([foot]), np.array(patch), weight * np.ones(4))
        for patch, weight in ((first, 3.0), (second, 1.0))
    ]
    return make_couplings(ties, mesh, mesh.nodes)


def test_a_node_that_rests_on_two_patches_of_one_body_follows_the_average_of_both():
    nodes, block = plates()
    mesh, (foot,) = with_lines(nodes, block, (20, 20, 2))
    result = on_two_patches(mesh, foot, [0, 1, 5, 6], [6, 7, 11, 12])
    (coupling,) = result.couplings
    assert isinstance(coupling, Rbe3)
    assert dict(zip(coupling.independent.tolist(), coupling.weights.tolist())) == pytest.approx(
        {0: 3, 1: 3, 5: 3, 6: 4, 7: 1, 11: 1, 12: 1}
    )
    assert result.notes == ()


def test_a_node_that_alone_holds_two_bodies_together_makes_both_rigid_and_says_so():
    """An average over both would hold the node, but not the two plates to one another."""
    nodes, block = plates()
    other, quads = grid((50, 0, 0), (40, 0, 0), (0, 40, 0), 4, 4)
    plate = ElementBlock("s9", "quad4", quads + len(nodes) + 2)
    mesh, (foot,) = with_lines(nodes, block, (45, 20, 2))
    mesh = Mesh(np.vstack([mesh.nodes, other]), (*mesh.blocks, plate))
    beyond = np.array([0, 1, 5, 6]) + len(nodes) + 2
    result = on_two_patches(mesh, foot, [3, 4, 8, 9], beyond)
    (coupling,) = result.couplings
    assert isinstance(coupling, Rbe2)
    assert len(coupling.dependent) == 8
    assert "rests on 2 faces" in result.notes[0]


def test_an_average_of_dependent_nodes_is_written_out_in_what_those_follow():
    nodes, block = plates()
    mesh, (foot, post) = with_lines(nodes, block, (20, 20, 2), (0, 0, 5))
    patch = [6, 7, 8, 11, 12, 13]
    ties = [
        Tie("beam_on_face", None, np.array([foot]), np.array(patch), np.ones(6)),
        Tie("rigid", None, np.array([6]), np.array([post])),
    ]
    result = make_couplings(ties, mesh, mesh.nodes)
    equations = [c for c in result.couplings if isinstance(c, Mpc)]
    assert [int(c.nodes[0]) for c in equations] == [foot] * 6
    assert set(equations[0].nodes[1:].tolist()) == {7, 8, 11, 12, 13, post}
    assert consistent(result.couplings, mesh)
    assert worst_rigid_motion(result.couplings, mesh.nodes) < 1e-9
    assert result.notes == ()


def following(dependent, hosts):
    """Nodes that each follow four hosts alike."""
    weights = (np.full(4, 0.25),) * len(dependent)
    return Tie(
        "interpolated", None, np.array(dependent), hosts=(np.array(hosts),) * len(dependent), host_weights=weights
    )


def test_a_patch_leaves_out_nodes_that_follow_its_own_node():
    nodes, block = plates()
    mesh, (foot,) = with_lines(nodes, block, (20, 20, 2))
    ties = [
        Tie("beam_on_face", None, np.array([foot]), np.array([6, 7, 8, 11, 12, 13]), np.ones(6)),
        following([6], [foot, 22, 23, 24]),
    ]
    result = make_couplings(ties, mesh, mesh.nodes)
    (average,) = [c for c in result.couplings if isinstance(c, Rbe3)]
    assert average.independent.tolist() == [7, 8, 11, 12, 13]
    assert consistent(result.couplings, mesh)


def test_a_patch_that_mostly_follows_its_own_node_asks_for_nothing_more():
    nodes, block = plates()
    mesh, (foot,) = with_lines(nodes, block, (20, 20, 2))
    ties = [
        Tie("beam_on_face", None, np.array([foot]), np.array([6, 7, 8, 11, 12, 13]), np.ones(6)),
        following([6, 7, 8, 11], [foot, 22, 23, 24]),
    ]
    result = make_couplings(ties, mesh, mesh.nodes)
    assert {type(c) for c in result.couplings} == {Mpc}
    assert {int(c.nodes[0]) for c in result.couplings} == {6, 7, 8, 11}
    assert consistent(result.couplings, mesh)


def test_rigid_ties_in_a_chain_become_one_body():
    nodes, block = plates()
    mesh, (a, b, c) = with_lines(nodes, block, (0, 0, 5), (0, 0, 50), (0, 0, 90))
    ties = [Tie("rigid", None, np.array([y]), np.array([x])) for x, y in ((0, a), (a + 1, b), (b + 1, c), (a, a + 1))]
    (coupling,) = make_couplings(ties, mesh, mesh.nodes).couplings[:1]
    assert consistent(make_couplings(ties, mesh, mesh.nodes).couplings, mesh)
    assert isinstance(coupling, Rbe2)


def test_an_interpolated_node_on_dependent_hosts_reaches_through_to_what_they_follow():
    nodes, block = plates()
    mesh, (post, other) = with_lines(nodes, block, (5, 5, 5), (5, 5, 60))
    ties = [
        Tie("rigid", None, np.array([0]), np.array([post])),
        Tie(
            "interpolated", None, np.array([other]),
            hosts=(np.array([0, 1, 6, 5]),), host_weights=(np.full(4, 0.25),),
        ),
    ]  # fmt: skip
    couplings = make_couplings(ties, mesh, mesh.nodes).couplings
    assert consistent(couplings, mesh)
    assert worst_rigid_motion(couplings, mesh.nodes) < 1e-9
    equations = [c for c in couplings if isinstance(c, Mpc)]
    assert len(equations) == 6
    assert all(0 not in c.nodes and post in c.nodes for c in equations)


def test_interpolations_that_go_round_in_a_ring_are_one_rigid_body():
    nodes, block = plates()
    mesh, (a, b, c) = with_lines(nodes, block, (5, 5, 5), (15, 5, 5), (25, 5, 5))
    hosts = (np.array([b, 1, 6]), np.array([a, 1, 6]), np.array([a, 12, 13]))
    weights = (np.full(3, 1 / 3),) * 3
    tie = Tie("interpolated", None, np.array([a, b, c]), hosts=hosts, host_weights=weights)
    result = make_couplings([tie], mesh, mesh.nodes)
    assert consistent(result.couplings, mesh)
    assert worst_rigid_motion(result.couplings, mesh.nodes) < 1e-9
    assert any("in a ring" in note for note in result.notes)
    (body,) = [coupling for coupling in result.couplings if isinstance(coupling, Rbe2)]
    assert {body.independent, *body.dependent.tolist()} == {a, b, 1, 6}


def test_an_unknown_coupling_is_refused():
    nodes, block = plates()
    with pytest.raises(OptionError, match="expected one of distributing, rigid, work"):
        make_couplings([], Mesh(nodes, (block,)), nodes, "glue")


@pytest.mark.parametrize(
    ("points", "weights", "does"),
    [
        ([[0, 0, 0], [1, 0, 0]], [1, 1], False),
        ([[0, 0, 0], [1, 0, 0], [2, 0, 0], [5, 0, 0]], [1, 2, 1, 1], False),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [1, 1, 1], True),
        ([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [1, 1, 1e-9], False),
        ([[0, 0, 0]], [1], False),
    ],
)
def test_translations_on_a_line_define_no_rotation(points, weights, does):
    assert defines_rotation(np.array(points, float), np.array(weights, float)) is does


@settings(max_examples=60)
@given(st.data())
def test_any_heap_of_ties_ends_consistent_or_is_refused(data):
    """Rigid ties, averages and interpolations between random nodes of a plate and of posts on it."""
    nodes, block = plates(3)
    mesh, firsts = with_lines(nodes, block, (5, 5, 3), (30, 5, 3), (20, 30, 3))
    posts = [n for first in firsts for n in (first, first + 1)]
    node = st.integers(0, len(nodes) - 1)
    ties = []
    for _ in range(data.draw(st.integers(1, 5))):
        kind = data.draw(st.sampled_from(["rigid", "beam_on_face", "interpolated"]))
        post = data.draw(st.sampled_from(posts))
        if kind == "rigid":
            ties.append(Tie(kind, None, np.array([post]), np.array([data.draw(node)])))
        elif kind == "beam_on_face":
            patch = np.array(sorted(data.draw(st.sets(node, min_size=1, max_size=6))))
            ties.append(Tie(kind, None, np.array([post]), patch, np.ones(len(patch))))
        else:
            quad = block.connectivity[data.draw(st.integers(0, len(block.connectivity) - 1))]
            ties.append(Tie(kind, None, np.array([post]), hosts=(quad,), host_weights=(np.full(4, 0.25),)))
    try:
        couplings = make_couplings(ties, mesh, mesh.nodes).couplings
    except ConnectError:
        return
    assert consistent(couplings, mesh)
    if couplings:
        assert worst_rigid_motion(couplings, mesh.nodes) < 1e-9
