"""Sweeps of meshed regions: volumes, orientation, stacked levels, full turns, folds."""

from __future__ import annotations

import numpy as np
import pytest

from kernel.errors import MeshError
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.order import to_second_order
from kernel.mesh.region import RegionMesh
from kernel.mesh.shapes import corner_rule, integration_rule, jacobians, measures
from kernel.mesh.sweep import LevelWish, divide_levels, sweep

# two quads and two triangles:   3--4--5
#                                |  | /|   the unit square twice
#                                0--1--2
SECTION = RegionMesh(
    points=np.array([[0.0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]]),
    quads=np.array([[0, 1, 4, 3]]),
    triangles=np.array([[1, 2, 5], [1, 5, 4]]),
)


def straight(points: np.ndarray, level: float) -> np.ndarray:
    return np.insert(points, 2, level, axis=1)


def volumes(kind: str, nodes: np.ndarray, elements: np.ndarray) -> np.ndarray:
    rule = integration_rule(kind)
    return (measures(jacobians(nodes[elements], rule)) * rule.weights).sum(axis=1)


def outer_faces(elements: np.ndarray, kind: str) -> dict[frozenset[int], int]:
    from kernel.mesh.elements import ELEMENT_KINDS

    counts: dict[frozenset[int], int] = {}
    for element in elements:
        for face in ELEMENT_KINDS[kind].faces:
            key = frozenset(int(element[k]) for k in face)
            counts[key] = counts.get(key, 0) + 1
    return counts


def test_quads_become_hexes_and_triangles_wedges_of_the_right_volume() -> None:
    nodes, hexes, wedges = sweep(SECTION, straight, np.array([0.0, 0.5, 2.0]))
    assert (len(nodes), len(hexes), len(wedges)) == (18, 2, 4)
    assert volumes("hex8", nodes, hexes).tolist() == pytest.approx([0.5, 1.5])
    assert volumes("wedge6", nodes, wedges).tolist() == pytest.approx([0.25, 0.25, 0.75, 0.75])
    assert np.array_equal(nodes[2 * 6 + 4], [1.0, 1.0, 2.0])


@pytest.mark.parametrize(
    "lift",
    [
        lambda points, level: np.insert(points, 2, -level, axis=1),
        lambda points, level: np.insert(points[:, ::-1], 2, level, axis=1),
    ],
    ids=["downwards", "mirrored"],
)
def test_a_lift_that_mirrors_still_gives_positive_volumes(lift) -> None:
    nodes, hexes, wedges = sweep(SECTION, lift, np.array([0.0, 1.0]))
    for kind, elements in (("hex8", hexes), ("wedge6", wedges)):
        assert (measures(jacobians(nodes[elements], corner_rule(kind))) > 0.0).all()


def test_a_full_turn_closes_without_nodes_of_its_own() -> None:
    def ring(points: np.ndarray, angle: float) -> np.ndarray:
        radius = 3.0 + points[:, 0]
        return np.stack([radius * np.cos(angle), radius * np.sin(angle), points[:, 1]], axis=1)

    angles = 2 * np.pi * np.arange(64) / 64
    nodes, hexes, wedges = sweep(SECTION, ring, angles, is_closed=True)
    assert len(nodes) == 64 * 6
    total = volumes("hex8", nodes, hexes).sum() + volumes("wedge6", nodes, wedges).sum()
    assert total == pytest.approx(np.pi * (25 - 9), rel=2e-3)
    second = to_second_order(
        Mesh(nodes, (ElementBlock("s", "hex8", hexes), ElementBlock("s", "wedge6", wedges))),
        lambda middles, edges: _onto_circles(middles, nodes, edges),
    )
    total = sum(volumes(block.kind, second.nodes, block.connectivity).sum() for block in second.blocks)
    assert total == pytest.approx(np.pi * (25 - 9), rel=1e-6)


def _onto_circles(middles: np.ndarray, nodes: np.ndarray, edges: np.ndarray) -> np.ndarray:
    radius = np.hypot(nodes[:, 0], nodes[:, 1])[edges].mean(axis=1)
    return middles * np.stack([*(2 * [radius / np.hypot(middles[:, 0], middles[:, 1])]), np.ones(len(middles))], axis=1)


def test_stacked_bodies_share_the_layers_between_them() -> None:
    levels = divide_levels([0.0, 1.0, 3.0], 0.6)
    assert levels.tolist() == pytest.approx([0.0, 0.5, 1.0, 1 + 2 / 3, 1 + 4 / 3, 3.0])
    present = np.array([[True, True, True]] * 2 + [[True, False, False]] * 3)  # a step: only the quad goes on
    nodes, hexes, wedges = sweep(SECTION, straight, levels, present=present)
    assert (len(hexes), len(wedges)) == (5, 4)
    assert len(nodes) == 3 * 6 + 3 * 4
    assert volumes("hex8", nodes, hexes).sum() + volumes("wedge6", nodes, wedges).sum() == pytest.approx(4.0)
    assert len(np.unique(np.concatenate([hexes.ravel(), wedges.ravel()]))) == len(nodes)
    assert max(outer_faces(hexes, "hex8").values()) == 2


def test_levels_keep_every_break_once() -> None:
    assert divide_levels([2.0, 0.0, 2.0 + 1e-12, 1.0], 10.0).tolist() == [0.0, 1.0, 2.0]
    with pytest.raises(MeshError, match="expected two breaks"):
        divide_levels([1.0], 1.0)


def test_folded_and_flat_sweeps_are_refused() -> None:
    with pytest.raises(MeshError, match="flat or inverted"):
        sweep(SECTION, straight, np.array([0.0, 0.0]))
    with pytest.raises(MeshError, match="flat or inverted"):
        sweep(SECTION, straight, np.array([0.0, 2.0, 1.0]))
    with pytest.raises(MeshError, match="expected at least two"):
        sweep(SECTION, straight, np.array([0.0]))


def test_a_fold_among_many_elements_is_found_whatever_the_chunk() -> None:
    n = 70
    x, y = np.meshgrid(np.arange(n + 1.0), np.arange(n + 1.0))
    points = np.column_stack([x.ravel(), y.ravel()])
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    quads = np.column_stack(
        [part.ravel() for part in (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])]
    )
    flat = RegionMesh(points, quads, np.empty((0, 3), np.int64))
    nodes, hexes, _ = sweep(flat, straight, np.array([0.0, 1.0, 2.0]))
    assert len(hexes) == 2 * n * n
    assert volumes("hex8", nodes, hexes).sum() == pytest.approx(2 * n * n)
    points[number[60, 60]] += [1.5, 0.0]  # beyond its neighbour
    with pytest.raises(MeshError, match=r"^4 of 9800 swept hex8 elements would be flat") as caught:
        sweep(flat, straight, np.array([0.0, 1.0, 2.0]))
    assert caught.value.at == pytest.approx([60.0, 59.5, 0.5], abs=1.0)


@pytest.mark.parametrize("order", [1, -1])
def test_layers_of_a_long_piece_take_none_from_a_short_one_within_it(order):
    wishes = [LevelWish(0.0, 1.0, least=10), LevelWish(0.0, 10.0, least=12)]
    levels = divide_levels([0.0, 1.0, 10.0], 20.0, wishes[::order])
    assert (levels <= 1.0 + 1e-12).sum() - 1 >= 10
    assert len(levels) - 1 >= 12
