"""The front's bins: looking about a node never leaves the grid, however long the step."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.numeric import front


@pytest.mark.parametrize(("x", "y"), [(0.5, 0.5), (3.5, 0.5), (0.5, 2.5), (3.5, 2.5)])
def test_a_reach_past_the_border_sees_the_nodes_inside_and_nothing_else(x, y):
    nodes = np.array([[2.0, 1.5]])
    head, successor = np.full(12, -1, np.int32), np.full(1, -1, np.int32)
    head[1 * 4 + 2] = 0
    is_taken = front._is_taken.py_func
    assert is_taken(x, y, 5.0, nodes, head, successor, 0.0, 0.0, 1.0, 4, 3)
    nodes[0] += 100.0
    assert not is_taken(x, y, 5.0, nodes, head, successor, 0.0, 0.0, 1.0, 4, 3)
