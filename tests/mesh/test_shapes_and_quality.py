"""Shape functions, volumes and quality measures of every element kind."""

import json
from pathlib import Path

import numpy as np
import pytest
from handmade import model_of, second_order, shell_cantilever, solid_cantilever
from hypothesis import given
from hypothesis import strategies as st

from kernel.errors import MeshError
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.quality import element_quality, mesh_quality
from kernel.mesh.shapes import (
    family,
    integration_rule,
    jacobians,
    measures,
    reference_nodes,
    shape_derivatives,
    shape_values,
)

SIZE = {"line": 2, "tri": 0.5, "quad": 4, "tet": 1 / 6, "wedge": 1, "hex": 8}


@pytest.mark.parametrize("kind", ELEMENT_KINDS)
def test_each_shape_function_is_one_at_its_node_and_all_add_up_to_one(kind):
    nodes = reference_nodes(kind)
    assert np.allclose(shape_values(kind, nodes), np.eye(len(nodes)))
    rule = integration_rule(kind)
    assert np.allclose(rule.values.sum(axis=1), 1)
    assert np.allclose(rule.derivatives.sum(axis=2), 0)


@pytest.mark.parametrize("kind", ELEMENT_KINDS)
def test_derivatives_are_those_of_the_values(kind):
    points = reference_nodes(kind).mean(axis=0, keepdims=True) + 0.1
    step = 1e-6
    for axis in range(points.shape[1]):
        ahead, behind = points.copy(), points.copy()
        ahead[:, axis] += step
        behind[:, axis] -= step
        slope = (shape_values(kind, ahead) - shape_values(kind, behind)) / (2 * step)
        assert np.allclose(shape_derivatives(kind, points)[:, axis], slope, atol=1e-8)


@pytest.mark.parametrize("kind", ELEMENT_KINDS)
def test_rules_measure_the_reference_element(kind):
    rule = integration_rule(kind)
    places = np.zeros((1, ELEMENT_KINDS[kind].n_node, 3))
    reference = reference_nodes(kind)
    places[0, :, : reference.shape[1]] = reference
    assert (measures(jacobians(places, rule)) * rule.weights).sum() == pytest.approx(SIZE[family(kind)])


def quality_of(kind, places):
    places = np.asarray(places, float)
    block = ElementBlock("s1", kind, np.arange(len(places))[None])
    return {name: float(value[0]) for name, value in element_quality(block, places).items()}


REGULAR = {
    "tri3": [[0, 0, 0], [1, 0, 0], [0.5, np.sqrt(3) / 2, 0]],
    "quad4": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]],
    "tet4": [[1, 1, 1], [1, -1, -1], [-1, 1, -1], [-1, -1, 1]],
}
REGULAR["tet4"] = [REGULAR["tet4"][k] for k in (0, 2, 1, 3)]
REGULAR["wedge6"] = [*REGULAR["tri3"], *[[x, y, 1] for x, y, _ in REGULAR["tri3"]]]
REGULAR["hex8"] = [*REGULAR["quad4"], *[[x, y, 1] for x, y, _ in REGULAR["quad4"]]]


@pytest.mark.parametrize("kind", REGULAR)
def test_the_regular_element_is_perfect(kind):
    found = quality_of(kind, REGULAR[kind])
    assert found["scaled_jacobian"] == pytest.approx(1)
    assert found["aspect"] == pytest.approx(1)
    nodes, second, cells = second_order(np.array(REGULAR[kind], float), kind, np.arange(len(REGULAR[kind]))[None])
    assert quality_of(second, nodes[cells[0]])["scaled_jacobian"] == pytest.approx(1)


@pytest.mark.parametrize("kind", REGULAR)
@given(st.randoms(use_true_random=False))
def test_quality_knows_no_place_turn_or_size(kind, random):
    rng = np.random.default_rng(random.getrandbits(32))
    places = np.array(REGULAR[kind], float) + rng.uniform(-0.15, 0.15, (len(REGULAR[kind]), 3))
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    turn *= np.sign(np.linalg.det(turn))
    moved = 37.5 * places @ turn.T + rng.uniform(-100, 100, 3)
    before, after = quality_of(kind, places), quality_of(kind, moved)
    for name, value in before.items():
        assert after[name] == pytest.approx(value, abs=1e-6)


VERDICT = json.loads((Path(__file__).parent / "verdict_values.json").read_text())["elements"]


@pytest.mark.parametrize("element", VERDICT, ids=lambda element: element["kind"])
def test_measures_of_random_elements_are_verdicts(element):
    found = quality_of(element["kind"], element["nodes"])
    known = {name: value for name, value in element.items() if name not in ("kind", "nodes")}
    assert set(found) == set(known)
    for name, value in known.items():
        assert found[name] == pytest.approx(value, rel=1e-9, abs=1e-9), name


def test_the_aspect_of_a_hex_is_its_longest_over_its_shortest_edge():
    places = np.array(REGULAR["hex8"], float) * [3, 1, 2]
    places[6] += [0.5, 0, 0]
    assert quality_of("hex8", places)["aspect"] == pytest.approx(3.5)


def test_measures_of_a_quad_by_hand():
    found = quality_of("quad4", [[0, 0, 0], [4, 0, 0], [5, 1, 0], [1, 1, 0]])  # a parallelogram, 45 degrees
    assert found["min_angle"] == pytest.approx(45)
    assert found["max_angle"] == pytest.approx(135)
    assert found["scaled_jacobian"] == pytest.approx(np.sin(np.radians(45)))
    assert found["skew"] == pytest.approx(np.cos(np.radians(45)))
    assert found["aspect"] == pytest.approx(4 * (8 + 2 * np.sqrt(2)) / (4 * 4))
    assert found["warpage"] == pytest.approx(0)


def test_a_quad_bent_by_a_right_angle_is_fully_warped():
    found = quality_of("quad4", [[0, 0, 0], [1, 0, 0], [1, 1, 1], [0, 1, 0]])
    assert 0 < found["warpage"] <= 1


def test_a_dented_quad_and_a_folded_hex_have_negative_jacobians():
    assert quality_of("quad4", [[0, 0, 0], [1, 0, 0], [0.2, 0.2, 0], [0, 1, 0]])["scaled_jacobian"] < 0
    flipped = REGULAR["hex8"][4:] + REGULAR["hex8"][:4]
    assert quality_of("hex8", flipped)["scaled_jacobian"] == pytest.approx(-1)


def test_a_mid_side_node_too_far_off_shows_in_the_scaled_jacobian():
    nodes, kind, cells = second_order(np.array(REGULAR["tri3"], float), "tri3", np.array([[0, 1, 2]]))
    nodes[3] += (0, 0.2, 0)
    assert quality_of(kind, nodes[cells[0]])["scaled_jacobian"] < 0.6


@pytest.mark.parametrize("kind", ["hex8", "hex20", "wedge6", "wedge15", "tet4", "tet10"])
def test_the_summary_has_the_documented_shape(kind):
    summary = mesh_quality(solid_cantilever(kind, divisions=(4, 2, 2)).mesh)
    assert set(summary) == {kind}
    assert {"min", "p5", "mean"} <= set(summary[kind]["scaled_jacobian"])
    assert summary[kind]["scaled_jacobian"]["min"] > 0


def test_inverted_elements_are_refused_with_segment_and_place():
    model = shell_cantilever("quad4", divisions=(2, 1))
    cells = model.mesh.blocks[0].connectivity.copy()
    nodes = model.mesh.nodes.copy()
    nodes[cells[1][2]] = nodes[cells[1][0]] + [1, 1, 0]
    broken = Mesh(nodes, (ElementBlock("s7", "quad4", cells),))
    with pytest.raises(MeshError, match=r"segment s7: 1 of 2 quad4 elements are inverted, the first at \("):
        mesh_quality(broken)
    assert mesh_quality(broken, allow_inverted=True)["quad4"]["scaled_jacobian"]["min"] < 0


def test_elements_at_no_place_are_refused_as_inverted_ones_are():
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [1, np.nan, 0], [0, 1, 0]])
    with pytest.raises(MeshError, match="segment s1: 1 of 1 quad4 elements are inverted"):
        mesh_quality(Mesh(nodes, (ElementBlock("s1", "quad4", np.array([[0, 1, 2, 3]])),)))


def test_an_empty_mesh_has_no_quality():
    assert mesh_quality(model_of(np.empty((0, 3)), [], []).mesh) == {}
