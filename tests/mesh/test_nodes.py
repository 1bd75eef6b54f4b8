"""The table of nodes: what was handed out stays, however far the table grows."""

from __future__ import annotations

import numpy as np

from kernel.mesh.nodes import NodeTable


def test_numbers_and_points_stay_as_the_table_grows() -> None:
    generator = np.random.default_rng(3)
    table, parts = NodeTable(), []
    for count in (1, 0, 5, 1000, 3, 4000, 1):
        before = table.points.copy()
        parts.append(generator.normal(size=(count, 3)))
        numbers = table.add(parts[-1])
        np.testing.assert_array_equal(table.points[: len(before)], before)
        np.testing.assert_array_equal(table.points[numbers], parts[-1])
    np.testing.assert_array_equal(table.points, np.concatenate(parts))


def test_one_point_is_a_row() -> None:
    assert NodeTable().add(np.zeros(3)).tolist() == [0]
