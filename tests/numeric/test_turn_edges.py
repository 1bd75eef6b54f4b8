"""Turning an edge between two quads moves excess edges away from a node that has too many."""

from __future__ import annotations

import numpy as np

from kernel.numeric.smooth_quads import quad_sines
from kernel.numeric.turn_edges import turn_edges


def fan(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A half disc of n quads that all meet in the middle of its straight side, and a ring of quads around."""
    t = np.linspace(0, np.pi, 2 * n + 1)
    inner = np.column_stack([np.cos(t), np.sin(t)])
    nodes = np.concatenate([[[0.0, 0.0]], inner, 2 * inner])
    a, b = 1, 1 + len(t)
    quads = [[0, a + 2 * k, a + 2 * k + 1, a + 2 * k + 2] for k in range(n)]
    quads += [[a + k, b + k, b + k + 1, a + k + 1] for k in range(2 * n)]
    is_fixed = np.zeros(len(nodes), np.uint8)
    is_fixed[[0, a, a + 2 * n]] = 1
    is_fixed[b:] = 1
    return nodes, np.array(quads, np.int32), is_fixed


def test_a_fan_of_four_quads_on_a_straight_side_loses_one() -> None:
    nodes, quads, is_fixed = fan(4)
    before = quad_sines(nodes, quads).min()
    n_quad = len(quads)
    assert turn_edges(nodes, quads, is_fixed, 0.9, 100) >= 1
    assert quad_sines(nodes, quads).min() > before + 0.01
    assert len(quads) == n_quad
    assert (quads == 0).sum() == 3


def test_fixed_nodes_and_good_quads_stay() -> None:
    nodes, quads, is_fixed = fan(2)
    places, corners = nodes.copy(), quads.copy()
    assert turn_edges(nodes, quads, is_fixed, 0.3, 100) == 0
    np.testing.assert_array_equal(nodes, places)
    np.testing.assert_array_equal(quads, corners)


def test_no_more_than_asked_are_tried() -> None:
    nodes, quads, is_fixed = fan(4)
    assert turn_edges(nodes, quads, is_fixed, 0.9, 0) == 0
