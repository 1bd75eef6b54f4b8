"""Smoothing never makes the worst element worse, and leaves what is fixed where it is."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.mesh.smoothing import smooth
from kernel.numeric.match import quad_scaled_jacobian
from kernel.numeric.smooth_quads import quad_sines, smooth_quads

FEW = settings(max_examples=40)


def grid(n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes, quads and which nodes lie on the rim of an n by n square of unit quads."""
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0))
    nodes = np.column_stack([x.ravel(), y.ravel()])
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.column_stack(
        [number[:-1, :-1].ravel(), number[:-1, 1:].ravel(), number[1:, 1:].ravel(), number[1:, :-1].ravel()]
    )
    is_rim = ((nodes == 0) | (nodes == n)).any(axis=1)
    return nodes, quads.astype(np.int32), is_rim


@FEW
@given(st.integers(0, 10_000), st.floats(0.0, 0.45))
def test_smoothing_quads_raises_the_worst(seed: int, disorder: float) -> None:
    nodes, quads, is_rim = grid(6)
    shift = np.random.default_rng(seed).uniform(-disorder, disorder, nodes.shape)
    nodes[~is_rim] += shift[~is_rim]
    before, rim = quad_sines(nodes, quads).min(), nodes[is_rim].copy()
    smooth(nodes, quads, is_rim)
    after = quad_sines(nodes, quads).min()
    assert after >= min(before, 0.85) - 1e-12
    np.testing.assert_array_equal(nodes[is_rim], rim)


def test_a_disordered_square_becomes_regular_again() -> None:
    nodes, quads, is_rim = grid(8)
    nodes[~is_rim] += np.random.default_rng(3).uniform(-0.4, 0.4, nodes.shape)[~is_rim]
    smooth(nodes, quads, is_rim)
    assert quad_sines(nodes, quads).min() > 0.9


def test_scaled_jacobian_of_known_quads() -> None:
    assert quad_scaled_jacobian(0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0) == 1
    assert abs(quad_scaled_jacobian(0.0, 0.0, 2.0, 0.0, 3.0, 1.0, 1.0, 1.0) - np.sqrt(0.5)) < 1e-15
    assert quad_scaled_jacobian(0.0, 0.0, 1.0, 0.0, 0.2, 0.2, 0.0, 1.0) < 0


def test_the_pattern_search_moves_the_middle_of_a_star_home() -> None:
    nodes, quads, is_rim = grid(2)
    nodes[~is_rim] += [0.3, -0.35]
    smooth_quads(nodes, quads, is_rim.astype(np.uint8), 0, 0, 6, 0.97, 0.85, 0.9, 2.0, 1)
    assert quad_sines(nodes, quads).min() > 0.98
