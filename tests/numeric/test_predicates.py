"""Exact tests agree with Python's unbounded integers, on every degenerate family."""

from __future__ import annotations

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.numeric.predicates import incircle, orient

GRID = st.integers(0, 2**30)
FEW = settings(max_examples=300)


def sign(value: int) -> int:
    return (value > 0) - (value < 0)


def exact_incircle(points: list[tuple[int, int]]) -> int:
    (ax, ay), (bx, by), (cx, cy), (dx, dy) = points
    rows = [(x - dx, y - dy, (x - dx) ** 2 + (y - dy) ** 2) for x, y in ((ax, ay), (bx, by), (cx, cy))]
    (a, b, c), (d, e, f), (g, h, i) = rows
    return sign(a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g))


def arrays(points: list[tuple[int, int]]) -> tuple[np.ndarray, np.ndarray]:
    x, y = zip(*points, strict=True)
    return np.array(x, np.int64), np.array(y, np.int64)


@FEW
@given(st.lists(st.tuples(GRID, GRID), min_size=3, max_size=3))
def test_orientation_is_exact(points: list[tuple[int, int]]) -> None:
    (ax, ay), (bx, by), (cx, cy) = points
    assert sign(int(orient(*arrays(points), 0, 1, 2))) == sign((bx - ax) * (cy - ay) - (by - ay) * (cx - ax))


@FEW
@given(st.lists(st.tuples(GRID, GRID), min_size=4, max_size=4))
def test_incircle_is_exact_anywhere(points: list[tuple[int, int]]) -> None:
    assert incircle(*arrays(points), 0, 1, 2, 3) == exact_incircle(points)


@FEW
@given(st.integers(0, 2**29), st.integers(0, 2**29), st.integers(1, 2**29), st.tuples(*[st.integers(-1, 1)] * 2))
def test_incircle_is_exact_next_to_a_circle(x: int, y: int, side: int, nudge: tuple[int, int]) -> None:
    square = [(x, y), (x + side, y), (x + side, y + side), (max(0, x + nudge[0]), max(0, y + side + nudge[1]))]
    assert incircle(*arrays(square), 0, 1, 2, 3) == exact_incircle(square)


def test_four_points_of_a_circle_are_on_it() -> None:
    circle = [(5 * 10**7, 0), (4 * 10**7, 3 * 10**7), (3 * 10**7, 4 * 10**7), (0, 5 * 10**7)]
    assert incircle(*arrays(circle), 0, 1, 2, 3) == 0
