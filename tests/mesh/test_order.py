"""Second order: shared mid-side nodes, true curves, elements that stay sound."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.errors import DefectError
from kernel.mesh.elements import ELEMENT_KINDS, SECOND_ORDER
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.order import curved, places_on, to_second_order
from kernel.mesh.shapes import corner_rule, jacobians, reference_nodes


def placed(kind: str) -> np.ndarray:
    """Corners of the reference element, in space."""
    flat = reference_nodes(kind)
    return np.hstack([flat, np.zeros((len(flat), 3 - flat.shape[1]))])


@pytest.mark.parametrize("kind", sorted(SECOND_ORDER))
def test_mid_side_nodes_stand_where_the_element_table_says(kind: str) -> None:
    corners = placed(kind)
    mesh = to_second_order(Mesh(corners, (ElementBlock("s", kind, np.arange(len(corners))[None, :]),)))
    (block,) = mesh.blocks
    assert block.kind == SECOND_ORDER[kind]
    expected = reference_nodes(block.kind)
    assert mesh.nodes[block.connectivity[0]][:, : expected.shape[1]] == pytest.approx(expected)
    assert len(mesh.nodes) == ELEMENT_KINDS[block.kind].n_node


def test_elements_of_different_kinds_and_segments_share_mid_side_nodes() -> None:
    nodes = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 0, 0]])
    mesh = Mesh(
        nodes,
        (
            ElementBlock("s1", "quad4", np.array([[0, 1, 2, 3]])),
            ElementBlock("s2", "tri3", np.array([[1, 4, 2]])),
            ElementBlock("s3", "line2", np.array([[2, 1]]), np.array([[0.0, 0, 1]])),
        ),
    )
    second = to_second_order(mesh)
    assert second.n_node == 5 + 6
    quad, tri, line = second.blocks
    assert quad.connectivity[0, 5] == tri.connectivity[0, 5] == line.connectivity[0, 2]
    assert line.orientation is not None
    assert np.array_equal(second.nodes[:5], nodes)


def test_mid_side_nodes_go_where_the_callable_puts_them() -> None:
    nodes = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 0]])
    mesh = Mesh(nodes, (ElementBlock("s", "tri3", np.array([[0, 1, 2]])),))
    arc = np.array([[np.sqrt(0.5), np.sqrt(0.5), 0.0]])
    second = to_second_order(mesh, places_on(np.array([[1, 0]]), arc))
    assert second.nodes[second.blocks[0].connectivity[0, 3:]] == pytest.approx(
        np.array([[np.sqrt(0.5), np.sqrt(0.5), 0], [0, 0.5, 0], [0.5, 0, 0]])
    )


@pytest.mark.parametrize("kind", ["tri3", "quad4", "tet4", "wedge6", "hex8"])
def test_a_curve_that_would_fold_an_element_is_drawn_back(kind: str) -> None:
    corners = placed(kind)
    mesh = Mesh(corners, (ElementBlock("s", kind, np.arange(len(corners))[None, :]),))
    far = corners.mean(axis=0)

    def bend(middles: np.ndarray, edges: np.ndarray) -> np.ndarray:
        result = middles.copy()
        first = np.flatnonzero((edges == [0, 1]).all(axis=1))
        result[first] = far + 2.0 * (far - middles[first])
        return result

    second, drawn = curved(mesh, bend)
    (block,) = second.blocks
    assert drawn == 1
    bent = jacobians(second.nodes[block.connectivity], corner_rule(block.kind))
    size = np.cross(bent[:, :, 0], bent[:, :, 1])[..., 2] if bent.shape[2] == 2 else np.linalg.det(bent)
    assert (size > 0.0).all()


def test_second_order_cannot_be_raised_again() -> None:
    mesh = to_second_order(Mesh(placed("quad4"), (ElementBlock("s", "quad4", np.arange(4)[None, :]),)))
    with pytest.raises(DefectError, match="cannot be raised"):
        to_second_order(mesh)
    with pytest.raises(DefectError, match="all finite"):
        to_second_order(
            Mesh(placed("quad4"), (ElementBlock("s", "quad4", np.arange(4)[None, :]),)),
            lambda middles, edges: middles * np.nan,
        )


def test_an_empty_mesh_stays_empty() -> None:
    assert to_second_order(Mesh(np.empty((0, 3)), ())).n_node == 0
