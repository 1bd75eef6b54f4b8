"""Constrained Delaunay triangulations: complete, Delaunay but for the constraints, constraints kept."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.numeric.halfedge import following, preceding
from kernel.numeric.hilbert import hilbert_order
from kernel.numeric.predicates import incircle, orient
from kernel.numeric.triangulation import triangulate

NONE = np.empty(0, np.int32)
FEW = settings(max_examples=40)


def hull_free(points: np.ndarray, edges: list[tuple[int, int]] | None = None) -> tuple:
    """The triangulation of a point set without any boundary edge: only the frame is carved away."""
    ends = np.array(edges or [], np.int32).reshape(-1, 2)
    start, end = np.ascontiguousarray(ends[:, 0]), np.ascontiguousarray(ends[:, 1])
    return triangulate(points, len(points), start, end, np.full(len(start), 2, np.uint8), 0)


def assert_constrained_delaunay(corner, twin, lock, n_triangle, x, y) -> None:
    for e in range(3 * n_triangle):
        a, b, c = corner[e], corner[following(e)], corner[preceding(e)]
        assert orient(x, y, np.int64(a), np.int64(b), np.int64(c)) > 0
        f = twin[e]
        if f >= 0:
            assert twin[f] == e
            assert (corner[f], corner[following(int(f))]) == (b, a)
            if not lock[e]:
                assert incircle(x, y, a, b, c, corner[preceding(int(f))]) <= 0


@FEW
@given(st.integers(0, 10_000), st.sampled_from(["random", "lattice", "circle", "line"]), st.integers(5, 60))
def test_any_point_set_is_triangulated_delaunay(seed: int, family: str, n: int) -> None:
    random = np.random.default_rng(seed)
    if family == "random":
        points = random.random((n, 2))
    elif family == "lattice":
        points = np.unique(random.integers(0, 6, (n, 2)), axis=0).astype(float)
    elif family == "circle":
        t = 2 * np.pi * np.arange(n) / n
        points = np.column_stack([np.cos(t), np.sin(t)])
    else:
        points = np.concatenate([np.column_stack([np.arange(n), np.arange(n)]), [[0.0, n]]])
    corner, twin, lock, _, n_triangle, x, y, *_ = hull_free(points)
    assert_constrained_delaunay(corner, twin, lock, n_triangle, x, y)
    assert n_triangle >= 1


@FEW
@given(st.integers(0, 10_000))
def test_constraints_become_edges_and_the_rest_stays_delaunay(seed: int) -> None:
    random = np.random.default_rng(seed)
    x = np.sort(random.random(12))
    zigzag = np.column_stack([x, 0.3 + 0.4 * (np.arange(12) % 2)])  # edges of an x-monotone line never cross
    points = np.concatenate([zigzag, random.random((60, 2))])
    chain = [(i, i + 1) for i in range(11)]
    corner, twin, lock, _, n_triangle, gx, gy, *_, failed = hull_free(points, chain)
    assert not failed.any()
    assert_constrained_delaunay(corner, twin, lock, n_triangle, gx, gy)
    locked = {tuple(sorted((int(corner[e]), int(corner[following(e)])))) for e in range(3 * n_triangle) if lock[e] == 2}
    assert locked == set(chain)


def test_a_constraint_through_a_point_is_reported_not_divided() -> None:
    points = np.array([(0, 0), (4, 0), (4, 4), (0, 4), (2.0, 2.0)])
    *_, failed = hull_free(points, [(0, 2)])
    assert failed.tolist() == [1]


def test_crossing_constraints_are_reported() -> None:
    points = np.array([(0, 0), (4, 0), (4, 4), (0, 4.0)])
    *_, failed = hull_free(points, [(0, 2), (1, 3)])
    assert failed.tolist() == [0, 1]


def test_doubled_points_are_reported() -> None:
    points = np.array([(0, 0), (4, 0), (4, 4), (0, 4), (4.0, 4.0)])
    *_, double_of, _ = hull_free(points)
    assert np.flatnonzero(double_of >= 0).tolist() in ([4], [2])


def test_what_lies_outside_the_boundary_is_carved_away() -> None:
    outer = np.array([(0, 0), (9, 0), (9, 9), (0, 9.0)])
    inner = np.array([(3, 3), (3, 6), (6, 6), (6, 3.0)])  # clockwise: a hole
    points = np.concatenate([outer, inner])
    start = np.arange(8, dtype=np.int32)
    end = np.array([1, 2, 3, 0, 5, 6, 7, 4], np.int32)
    corner, _, _, _, n_triangle, *_ = triangulate(points, 8, start, end, np.ones(8, np.uint8), 0)
    t = points[corner[: 3 * n_triangle].reshape(-1, 3)]
    u, v = t[:, 1] - t[:, 0], t[:, 2] - t[:, 0]
    assert 0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]).sum() == pytest.approx(81 - 9)


@FEW
@given(st.integers(1, 400), st.integers(1, 6))
def test_hilbert_order_is_a_permutation_of_short_steps(n: int, bits: int) -> None:
    random = np.random.default_rng(n)
    x, y = (random.integers(0, 2**30, n) for _ in range(2))
    order = hilbert_order(x, y, np.int64(0), n, 30 - bits, bits)
    assert sorted(order.tolist()) == list(range(n))
