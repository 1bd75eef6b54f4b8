"""Regions that imprints run right through are meshed cell by cell, so that simple cells get structured meshes."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planar_regions import assert_meshes, hole, line, polygon, rectangle, scaled_jacobian, sides

from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region
from kernel.mesh.region_cells import cells_of_region


def with_lines(
    rings: list[np.ndarray], lines: list[np.ndarray], period: float | None = None, curved: tuple[int, ...] = ()
) -> Region:
    """Rings and imprinted lines (ends included) whose points at one place are one point."""
    chains = [np.concatenate([ring, ring[:1]]) for ring in rings] + lines
    flat = np.concatenate(chains)
    if period is not None:
        flat[:, 0] %= period
    _, first, number = np.unique(np.round(flat, 6), axis=0, return_index=True, return_inverse=True)
    edges, boundary, round_ones, at = [], [], [], 0
    for index, chain in enumerate(chains):
        own = number.ravel()[at : at + len(chain)]
        edges.append(np.column_stack([own[:-1], own[1:]]))
        boundary.append(np.full(len(chain) - 1, index < len(rings)))
        round_ones.append(np.full(len(chain) - 1, index in curved))
        at += len(chain)
    return Region(flat[first], np.concatenate(edges), np.concatenate(boundary), np.concatenate(round_ones), period)


def chain(*corners: tuple[float, float], size: float = 1.0) -> np.ndarray:
    """Seeds along a chain of corners, both ends included."""
    return np.concatenate([*(line(a, b, size) for a, b in pairwise(corners)), [corners[-1]]])


def divided(corners: list[tuple[float, float]], size: float = 1.0) -> np.ndarray:
    return polygon(corners, size)


def n_irregular(region: Region, mesh) -> int:
    """Nodes inside cells that have other than four neighbours."""
    side, _ = sides(mesh)
    valence = np.bincount(side.ravel(), minlength=len(mesh.points))
    return int((valence[len(region.points) :] != 4).sum())


def test_a_plate_with_ribs_through_it_is_a_grid() -> None:
    outline = divided([(0, 0), (14, 0), (30, 0), (30, 10), (14, 10), (0, 10)])
    plate = with_lines([outline], [chain((14, 0), (14, 10))])
    cells = cells_of_region(plate)
    assert cells is not None and [len(cell.region.points) for cell in cells] == [48, 52]
    mesh = mesh_region(plate, 1.0)
    assert_meshes(plate, mesh)
    assert len(mesh.quads) == 300
    assert scaled_jacobian(mesh).min() > 1 - 1e-9


def test_what_hangs_together_by_a_point_is_meshed_part_by_part() -> None:
    left = divided([(0, 0), (8, 0), (14, 6), (8, 12), (0, 12)])
    right = divided([(14, 6), (20, 0), (30, 0), (30, 12), (20, 12)])
    plate = with_lines([left, right], [])
    cells = cells_of_region(plate)
    assert cells is not None and len(cells) == 2
    mesh = mesh_region(plate, 1.0)
    assert len(mesh.quads) == sum(len(mesh_region(cell.region, 1.0).quads) for cell in cells)
    for cell in cells:
        assert_meshes(cell.region, mesh_region(cell.region, 1.0))


def test_ribs_that_cross_part_a_plate_in_four() -> None:
    outline = divided([(0, 0), (14, 0), (30, 0), (30, 4), (30, 10), (14, 10), (0, 10), (0, 4)])
    lines = [chain((14, 0), (14, 4), (14, 10)), chain((0, 4), (14, 4), (30, 4))]
    plate = with_lines([outline], lines)
    cells = cells_of_region(plate)
    assert cells is not None and len(cells) == 4
    mesh = mesh_region(plate, 1.0)
    assert_meshes(plate, mesh)
    assert len(mesh.quads) == 300
    assert n_irregular(plate, mesh) == 0


def test_a_footprint_is_a_cell_in_a_cell_with_a_hole() -> None:
    foot = chain((4, 4), (8, 4), (8, 8), (4, 8), (4, 4))
    inner = chain((5, 5), (7, 5), (7, 7), (5, 7), (5, 5))
    plate = with_lines([rectangle(20, 12, 1.0)], [foot, inner])
    cells = cells_of_region(plate)
    assert cells is not None and len(cells) == 3
    assert all(cell.region.is_boundary.all() for cell in cells)
    assert_meshes(plate, mesh_region(plate, 1.0))


def test_a_rib_that_ends_inside_parts_nothing_and_stays_an_imprint() -> None:
    outline = divided([(0, 0), (14, 0), (30, 0), (30, 10), (0, 10)])
    plate = with_lines([outline], [chain((14, 0), (14, 6))])
    assert cells_of_region(plate) is None
    parted = with_lines(
        [divided([(0, 0), (14, 0), (20, 0), (30, 0), (30, 10), (20, 10), (0, 10)])],
        [chain((14, 0), (14, 6)), chain((20, 0), (20, 10))],
    )
    cells = cells_of_region(parted)
    assert cells is not None and [int((~cell.region.is_boundary).sum()) for cell in cells] == [6, 0]
    assert_meshes(parted, mesh_region(parted, 1.0))


def test_hard_points_go_with_their_cells() -> None:
    outline = divided([(0, 0), (14, 0), (30, 0), (30, 10), (14, 10), (0, 10)])
    plate = with_lines([outline], [chain((14, 0), (14, 10))])
    n = len(plate.points)
    points = np.concatenate([plate.points, [(20.3, 4.4)]])
    spotted = Region(points, plate.edges, plate.is_boundary, plate.is_curved)
    cells = cells_of_region(spotted)
    assert cells is not None and [n in cell.numbers for cell in cells] == [False, True]
    assert_meshes(spotted, mesh_region(spotted, 1.0))


ROUND = 24.0


def tube(lines: list[np.ndarray], holes: tuple[np.ndarray, ...] = (), height: float = 12.0) -> Region:
    x = np.arange(24.0)
    rings = [np.column_stack([x, 0 * x]), np.column_stack([x[::-1], 0 * x + height]), *holes]
    return with_lines(rings, lines, ROUND, tuple(range(2, len(rings))))


def test_a_pipe_with_rings_falls_into_bands() -> None:
    x = np.arange(25.0)
    pipe = tube([np.column_stack([x, 0 * x + 4.0]), np.column_stack([x[::-1], 0 * x + 8.0])])
    cells = cells_of_region(pipe)
    assert cells is not None and len(cells) == 3
    assert all(cell.region.period == ROUND for cell in cells)
    mesh = mesh_region(pipe, 1.0)
    assert_meshes(pipe, mesh)
    assert len(mesh.quads) == 24 * 12
    assert n_irregular(pipe, mesh) == 0


@pytest.mark.parametrize("places", [(0.0,), (5.0,), (0.0, 9.0), (7.0, 23.0), (3.0, 11.0, 19.0)])
def test_a_pipe_with_fins_falls_into_panels_cut_free_of_the_cylinder(places) -> None:
    pipe = tube([chain((x, 0.0), (x, 12.0)) for x in places])
    cells = cells_of_region(pipe)
    assert cells is not None and len(cells) == len(places)
    assert all(cell.region.period is None for cell in cells)
    mesh = mesh_region(pipe, 1.0)
    assert_meshes(pipe, mesh)
    assert len(mesh.quads) == 24 * 12
    assert n_irregular(pipe, mesh) == 0


def test_a_pipe_with_a_ring_and_a_hole_and_a_patch_over_its_seam() -> None:
    x = np.arange(25.0)
    patch = chain((22.0, 9.0), (26.0, 9.0), (26.0, 11.0), (22.0, 11.0), (22.0, 9.0))
    pipe = tube([np.column_stack([x, 0 * x + 7.0]), patch], (hole(0.4, 3.0, 1.6, 0.6),))
    cells = cells_of_region(pipe)
    assert cells is not None and len(cells) == 3
    assert sorted(cell.region.period is None for cell in cells) == [False, False, True]
    assert_meshes(pipe, mesh_region(pipe, 1.0))


@settings(max_examples=25)
@given(
    st.lists(st.integers(1, 14), unique=True, min_size=1, max_size=4),
    st.lists(st.integers(1, 9), unique=True, max_size=3),
    st.floats(0, 6.28),
)
def test_any_grid_of_ribs_is_a_grid_of_cells_however_it_is_turned(xs, ys, angle) -> None:
    xs, ys = sorted(2.0 * x for x in xs), sorted(2.0 * y for y in ys)
    bottom = [(0.0, 0.0), *((x, 0.0) for x in xs), (30.0, 0.0), *((30.0, y) for y in ys)]
    top = [(30.0, 20.0), *((x, 20.0) for x in reversed(xs)), (0.0, 20.0), *((0.0, y) for y in reversed(ys))]
    lines = [chain((x, 0.0), *((x, y) for y in ys), (x, 20.0)) for x in xs]
    lines += [chain((0.0, y), *((x, y) for x in xs), (30.0, y)) for y in ys]
    flat = with_lines([divided(bottom + top)], lines)
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    plate = Region(flat.points @ turn, flat.edges, flat.is_boundary, flat.is_curved)
    cells = cells_of_region(plate)
    assert cells is not None and len(cells) == (len(xs) + 1) * (len(ys) + 1)
    mesh = mesh_region(plate, 1.0)
    assert_meshes(plate, mesh)
    assert len(mesh.quads) == 600
    assert n_irregular(plate, mesh) == 0
