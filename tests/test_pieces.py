"""Connected pieces: the same as by walking from thing to thing."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.pieces import connected_pieces, near_pairs


def walked(count: int, pairs: list[tuple[int, int]]) -> list[int]:
    beside: dict[int, set[int]] = {k: set() for k in range(count)}
    for a, b in pairs:
        beside[a].add(b)
        beside[b].add(a)
    labels = [-1] * count
    for start in range(count):
        waiting = [start] if labels[start] < 0 else []
        while waiting:
            here = waiting.pop()
            if labels[here] < 0:
                labels[here] = start
                waiting += beside[here]
    return labels


@pytest.mark.parametrize("links", [0, 10, 60, 200])
def test_pieces_are_those_found_by_walking(links: int) -> None:
    generator = np.random.default_rng(links)
    for _ in range(20):
        first, second = generator.integers(0, 100, (2, links))
        assert connected_pieces(100, first, second).tolist() == walked(100, list(zip(first, second)))


def test_a_long_chain_in_any_order_is_one_piece() -> None:
    order = np.random.default_rng(5).permutation(5000)
    assert not connected_pieces(5000, order[:-1], order[1:]).any()


def test_near_pairs_agree_with_counting_all():
    rng = np.random.default_rng(5)
    points = rng.integers(0, 6, (200, 3)).astype(float)
    expected = [(i, j) for i in range(200) for j in range(i + 1, 200) if np.linalg.norm(points[i] - points[j]) < 1e-3]
    assert near_pairs(points, 1e-3) == expected
