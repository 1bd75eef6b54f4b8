"""Boxes found by place: the same as by comparing each with each."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.solid.boxes import BoxIndex


def boxes(count: int, seed: int, flat: int | None = None) -> np.ndarray:
    generator = np.random.default_rng(seed)
    low = generator.uniform(0, 10, (count, 3))
    high = low + generator.uniform(0, 1, (count, 3))
    if flat is not None:
        low[:, flat] = high[:, flat] = 3.0
    return np.stack([low, high], axis=1)


@pytest.mark.parametrize("flat", [None, 0, 1, 2])
def test_finds_the_pairs_that_comparing_each_with_each_finds(flat: int | None) -> None:
    held, asked = boxes(300, 1, flat), boxes(200, 2, flat)
    low = np.maximum(asked[:, None, 0], held[None, :, 0])
    high = np.minimum(asked[:, None, 1], held[None, :, 1])
    expected = np.argwhere((low <= high).all(axis=2))
    assert len(expected) > 20
    assert BoxIndex(held).pairs(asked) == [tuple(pair) for pair in expected.tolist()]


def test_boxes_that_touch_in_a_corner_are_near() -> None:
    index = BoxIndex([np.array([[0, 0, 0], [1, 1, 1.0]]), np.array([[2, 2, 2], [3, 3, 3.0]])])
    assert index.near(np.array([1, 1, 1.0]), np.array([2, 2, 1.5])) == [0]


def test_nothing_is_near_where_there_are_no_boxes() -> None:
    assert BoxIndex([]).near(np.zeros(3), np.ones(3)) == []
