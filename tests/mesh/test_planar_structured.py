"""Simple regions get structured meshes, as regular as their shape allows."""

from __future__ import annotations

import math

import numpy as np
import pytest
from planar_regions import assert_meshes, hole, polygon, rectangle, region, scaled_jacobian, sides

from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region
from kernel.mesh.structured import structured_mesh


def circle(radius: float, n: int, turn: float = 0.0) -> np.ndarray:
    t = 2 * np.pi * np.arange(n) / n + turn
    return radius * np.column_stack([np.cos(t), np.sin(t)])


def irregular(mesh: object) -> int:
    """Inner nodes with other than four quads' sides."""
    side, use = sides(mesh)
    valence = np.bincount(side.ravel(), minlength=len(mesh.points))
    is_inner = np.ones(len(valence), bool)
    is_inner[side[use == 1].ravel()] = False
    return int((valence[is_inner] != 4).sum())


@pytest.mark.parametrize("corners", [[(0, 0), (9, 0), (10, 6), (-1, 6.0)], [(0, 0), (12, 3), (10, 11), (-2, 8.0)]])
def test_a_quadrilateral_with_sides_divided_alike_has_no_irregular_node(corners: list[tuple[float, float]]) -> None:
    parts = [10, 6, 10, 6]
    ring = np.concatenate(
        [
            np.array(a) + np.arange(n)[:, None] / n * (np.array(b) - np.array(a))
            for a, b, n in zip(corners, corners[1:] + corners[:1], parts, strict=True)
        ]
    )
    plane = region([ring])
    mesh = mesh_region(plane, 1.0)
    assert_meshes(plane, mesh)
    assert len(mesh.quads) == 60
    assert irregular(mesh) == 0


@pytest.mark.parametrize("top", [(5, 8), (2, 9), (8, 7), (6, 12)])
def test_a_triangle_has_one_irregular_node(top: tuple[float, float]) -> None:
    plane = region([polygon([(0, 0), (10, 0), top], 1)])
    mesh = mesh_region(plane, 1.0)
    assert_meshes(plane, mesh)
    assert irregular(mesh) == 1
    assert scaled_jacobian(mesh).min() > 0.6


@pytest.mark.parametrize("n", [8, 12, 16, 22, 40, 64])
@pytest.mark.parametrize("turn", [0.0, 0.3])
def test_a_disc_has_a_core_with_four_irregular_nodes(n: int, turn: float) -> None:
    disc = region([circle(10, n, turn)], (0,))
    mesh = mesh_region(disc, 2 * math.pi * 10 / n)
    assert_meshes(disc, mesh)
    assert irregular(mesh) == 4
    assert scaled_jacobian(mesh).min() > 0.7


def test_a_tube_with_rings_divided_alike_is_meshed_in_layers() -> None:
    tube = region([circle(10, 32), circle(7, 32, 0.1)[::-1]], (0, 1))
    mesh = mesh_region(tube, 1.5)
    assert_meshes(tube, mesh)
    assert len(mesh.quads) == 64
    assert irregular(mesh) == 0


def test_a_band_round_a_cylinder_is_meshed_in_rows_whatever_way_its_ends_are_given() -> None:
    x = np.arange(20.0)
    rings = [np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + 7])]
    for order in (rings, rings[::-1]):
        band = region(order, period=20.0)
        mesh = mesh_region(band, 1.0)
        assert_meshes(band, mesh)
        assert len(mesh.quads) == 140
        np.testing.assert_allclose(scaled_jacobian(mesh, 20.0), 1, atol=1e-12)


def test_what_is_not_simple_is_left_to_the_general_mesher() -> None:
    assert structured_mesh(region([rectangle(20, 10, 1), hole(5, 5, 2, 1)], (1,)), 1.0) is None
    assert structured_mesh(region([rectangle(20, 10, 1)], points=[(5.2, 5.1)]), 1.0) is None
    notched = polygon([(0, 0), (10, 0), (10, 4), (4, 4), (4, 10), (0, 10)], 1)
    assert structured_mesh(region([notched]), 1.0) is None
    square = region([rectangle(6, 6, 1)])
    crossed = Region(square.points, np.concatenate([square.edges, [[3, 15]]]),
                     np.append(square.is_boundary, False), np.append(square.is_curved, False))  # fmt: skip
    assert structured_mesh(crossed, 1.0) is None
