"""Lone triangles joined: the polygon that they span keeps its rim, and only quads are in it afterwards."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.mesh.constrained import Edges, constrained
from kernel.numeric.halfedge import find_edge
from kernel.numeric.join_lone import _N_WAY, _WAYS, join_lone
from kernel.numeric.match import match_triangles

FEW = settings(max_examples=40)


def polygon(points: np.ndarray):
    """The constrained triangulation of a ring of points."""
    number = np.arange(len(points), dtype=np.int32)
    edges = Edges(number, np.roll(number, -1), np.ones(len(points), np.uint8))
    return constrained(points, len(points), edges, 0)


def cells(corner: np.ndarray, twin: np.ndarray, mate: np.ndarray) -> list[tuple[int, ...]]:
    """Corners of every quad and lone triangle."""
    found = []
    for t, e in enumerate(mate.tolist()):
        if e < 0:
            found.append(tuple(corner[3 * t : 3 * t + 3].tolist()))
        elif twin[e] > e:
            f = int(twin[e])
            ahead = [3 * (h // 3) + (h % 3 + k) % 3 for h, k in ((e, 1), (e, 2), (f, 1), (f, 2))]
            found.append(tuple(corner[ahead].tolist()))
    return found


def assert_half_edges(corner: np.ndarray, twin: np.ndarray, leaving: np.ndarray, n_triangle: int) -> None:
    following = np.arange(3 * n_triangle) + np.tile([1, 1, -2], n_triangle)
    for e in range(3 * n_triangle):
        if twin[e] >= 0:
            assert twin[twin[e]] == e
            assert corner[twin[e]] == corner[following[e]]
    for node, e in enumerate(leaving.tolist()):
        assert e < 0 or corner[e] == node


def test_the_ways_to_cut_a_polygon_are_all_different_and_cover_it() -> None:
    assert _N_WAY.tolist() == [1, 3, 12]
    for k, n_way in enumerate(_N_WAY.tolist()):
        ways = {tuple(sorted(map(tuple, _WAYS[k, w, : k + 1].tolist()))) for w in range(n_way)}
        assert len(ways) == n_way
        for way in ways:
            sides = [(quad[i], quad[(i + 1) % 4]) for quad in way for i in range(4)]
            rim = [(i, (i + 1) % (2 * k + 4)) for i in range(2 * k + 4)]
            assert set(rim) <= set(sides)
            assert all((b, a) in sides for a, b in set(sides) - set(rim))


@pytest.mark.parametrize("n_side", [6, 8])
def test_two_triangles_at_the_ends_of_quads_become_quads(n_side: int) -> None:
    # a strip of two squares (or three), slanted ends: triangle, quads, triangle
    n = n_side // 2 - 1
    low = [(0.5 + k, 0.0) for k in range(n)]
    high = [(n - 0.5 - k, 1.0) for k in range(n)]
    points = np.array([*low, (n + 0.0, 0.5), *high, (0.0, 0.5)]) * [1.0, 1.3]
    mesh = polygon(points)
    mate = match_triangles(points, *mesh.half_edges[:3], mesh.n_triangle, 0.65, 8)
    mate[:] = -1  # pair the middle ones alone: quads between two nodes below and two above
    corner, twin, lock, leaving = mesh.half_edges
    for k in range(n - 1):
        ends = (k, n + 1 + n - 1 - k), (k + 1, n + 1 + n - 2 - k)
        for a, b in ((ends[0][0], ends[1][1]), (ends[0][1], ends[1][0])):
            e = int(find_edge(corner, twin, leaving, np.int64(a), np.int64(b)))
            if e >= 0 and twin[e] >= 0:
                mate[e // 3], mate[twin[e] // 3] = e, twin[e]
    assert (mate < 0).sum() == 2
    joined = join_lone(points, corner, twin, lock, leaving, mate, mesh.n_triangle)
    assert joined == 1
    assert (mate >= 0).all()
    found = cells(corner, twin, mate)
    assert [len(cell) for cell in found] == [4] * (n_side // 2 - 1)
    sides = {(cell[i], cell[(i + 1) % 4]) for cell in found for i in range(4)}
    assert {(i, (i + 1) % n_side) for i in range(n_side)} <= sides
    assert_half_edges(corner, twin, leaving, mesh.n_triangle)


@FEW
@given(st.integers(0, 10_000))
def test_joining_on_scattered_nodes_keeps_half_edges_and_area(seed: int) -> None:
    random = np.random.default_rng(seed)
    rim = np.array([(x, 0.0) for x in range(8)] + [(8.0, y) for y in range(8)])
    rim = np.concatenate([rim, 8 - rim])
    inner = np.array([(x + 0.5, y + 0.5) for x in range(1, 7) for y in range(1, 7)]) + random.uniform(
        -0.3, 0.3, (36, 2)
    )
    number = np.arange(len(rim), dtype=np.int32)
    edges = Edges(number, np.roll(number, -1), np.ones(len(rim), np.uint8))
    points = np.concatenate([rim, inner])
    mesh = constrained(points, len(rim), edges, 0)
    corner, twin, lock, leaving = mesh.half_edges
    n = mesh.n_triangle
    mate = match_triangles(points, corner, twin, lock, n, 0.65, 8)
    before = int((mate < 0).sum())
    joined = join_lone(points, corner, twin, lock, leaving, mate, n)
    assert (mate < 0).sum() == before - 2 * joined
    assert_half_edges(corner, twin, leaving, n)
    area = 0.0
    for cell in cells(corner, twin, mate):
        x, y = points[list(cell)].T
        area += 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())
    assert abs(area - 64) < 1e-9
    assert all(mate[twin[e] // 3] == twin[e] for e in mate[mate >= 0].tolist())
