"""The size field: short edges' lengths grow, long edges' shrink, neither faster than the growth asked for."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.numeric.size_grid import base_grid, bilinear, size_grid, spread

FEW = settings(max_examples=25)


def chain(x: np.ndarray, y: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Points along y and the edges between them."""
    number = np.arange(len(x), dtype=np.int32)
    return np.column_stack([x, np.full(len(x), y)]), number[:-1].copy(), number[1:].copy()


@FEW
@given(st.integers(0, 10_000), st.floats(0.1, 0.6))
def test_spread_leaves_no_step_beyond_the_growth(seed: int, growth: float) -> None:
    random = np.random.default_rng(seed)
    n_x, n_y, cell = 23, 17, 0.5
    given_sizes = np.full(n_x * n_y, 10.0)
    places = random.integers(0, n_x * n_y, 5)
    given_sizes[places] = random.uniform(0.1, 5, 5)
    wanted = given_sizes.copy()
    spread(wanted, cell, n_x, n_y, growth)
    assert (wanted <= given_sizes).all()
    field = wanted.reshape(n_y, n_x)
    for axis in (0, 1):
        assert np.abs(np.diff(field, axis=axis)).max() <= growth * cell * (1 + 1e-12)
    assert wanted.min() == given_sizes.min()


@FEW
@given(st.floats(1.3, 10.0), st.floats(0.2, 0.6))
def test_long_edges_are_met_and_left_behind(length: float, growth: float) -> None:
    points, start, end = chain(np.arange(0.0, 41.0, length), 0.0)
    corners = np.array([(0.0, -40.0), (40.0, 60.0)])
    base, is_graded, *place = base_grid(np.concatenate([points, corners]), start, end, 1.0, growth)
    assert is_graded
    assert abs(bilinear(0.5 * length, 0.0, base, *place) - length) <= growth * place[0]
    far = (length - 1) / growth + 3.0
    assert bilinear(20.0, far, base, *place) < 1.2
    assert base.min() >= 1.0
    assert base.max() <= length * (1 + 1e-12)


def test_short_edges_win_where_both_meet() -> None:
    fine, start, end = chain(np.linspace(0, 10, 51), 0.0)  # .2 long, beside one edge of 5
    points = np.concatenate([fine, [(15.0, 0.0), (15.0, 20.0), (0.0, 20.0)]])
    start = np.concatenate([start, np.array([50], np.int32)])
    end = np.concatenate([end, np.array([51], np.int32)])
    wanted, cell, n_x, n_y, is_graded = size_grid(points, start, end, 1.0, -2.0, -2.0, 18.0, 23.0, 0.3)
    assert is_graded
    at = [bilinear(x, y, wanted, cell, -2.0, -2.0, n_x, n_y) for x, y in ((5.0, 0.0), (5.0, 1.0), (5.0, 19.0))]
    assert at[0] < 0.35
    assert at[0] < at[1] < 0.7
    assert at[2] == 1.0
    beside_long = bilinear(12.5, 0.0, wanted, cell, -2.0, -2.0, n_x, n_y)
    assert beside_long > 2.0  # half of it is blended with the finer cells about


def test_edges_of_about_the_size_grade_nothing() -> None:
    points, start, end = chain(np.arange(0.0, 10.0), 0.0)
    wanted, *_, is_graded = size_grid(points, start, end, 1.0, -2.0, -2.0, 12.0, 3.0, 0.3)
    assert not is_graded
    assert (wanted == 1.0).all()
