"""Seeded regions for the mesher's tests, and what must hold of every mesh on them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.region import Region, RegionMesh

Points = NDArray[np.float64]


def count(length: float, size: float, is_even: bool = True) -> int:
    return max(2, 2 * round(length / size / 2)) if is_even else max(1, round(length / size))


def line(a: tuple[float, float], b: tuple[float, float], size: float, is_even: bool = True) -> Points:
    """Seeds from a to b, b left out."""
    t = np.arange(n := count(math.dist(a, b), size, is_even)) / n
    return np.array(a) + t[:, None] * (np.array(b) - np.array(a))


def polygon(corners: list[tuple[float, float]], size: float, is_even: bool = True) -> Points:
    return np.concatenate([line(a, b, size, is_even) for a, b in zip(corners, corners[1:] + corners[:1], strict=True)])


def rectangle(width: float, height: float, size: float, is_even: bool = True) -> Points:
    return polygon([(0, 0), (width, 0), (width, height), (0, height)], size, is_even)


def hole(x: float, y: float, radius: float, size: float, is_even: bool = True) -> Points:
    n = max(8, count(2 * math.pi * radius, size, is_even))
    t = -2 * np.pi * np.arange(n) / n
    return np.column_stack([x + radius * np.cos(t), y + radius * np.sin(t)])


def region(
    rings: list[Points],
    curved: tuple[int, ...] = (),
    lines: list[Points] | None = None,
    points: list[tuple[float, float]] | None = None,
    period: float | None = None,
) -> Region:
    """rings: closed boundaries, of which those numbered in `curved` are round; lines: imprints, ends included."""
    all_points, edges, is_boundary, is_curved = [], [], [], []
    n = 0
    for i, ring in enumerate(rings):
        number = np.arange(len(ring)) + n
        edges.append(np.column_stack([number, np.roll(number, -1)]))
        is_boundary.append(np.ones(len(ring), bool))
        is_curved.append(np.full(len(ring), i in curved))
        all_points.append(ring)
        n += len(ring)
    for imprint in lines or []:
        number = np.arange(len(imprint)) + n
        edges.append(np.column_stack([number[:-1], number[1:]]))
        is_boundary.append(np.zeros(len(imprint) - 1, bool))
        is_curved.append(np.zeros(len(imprint) - 1, bool))
        all_points.append(imprint)
        n += len(imprint)
    if points:
        all_points.append(np.array(points, float))
    return Region(
        np.concatenate(all_points),
        np.concatenate(edges).astype(np.int64),
        np.concatenate(is_boundary),
        np.concatenate(is_curved),
        period,
    )


def plate_with_holes(size: float, is_even: bool = True) -> Region:
    """200 by 100 with six holes of diameter 12."""
    rings = [rectangle(200, 100, size, is_even)]
    rings += [hole(x, y, 6, size, is_even) for x in (50, 100, 150) for y in (100 / 3, 200 / 3)]
    return region(rings, curved=tuple(range(1, 7)))


def elements(mesh: RegionMesh) -> list[NDArray[np.int64]]:
    return [nodes for nodes in (mesh.quads, mesh.triangles) if len(nodes)]


def corners_of(mesh: RegionMesh, nodes: NDArray[np.int64], period: float | None) -> NDArray[np.float64]:
    """(n, k, 2) corners; on a cylinder each element in one piece."""
    x = mesh.points[nodes]
    if period is not None:
        dx = x[..., 0] - x[:, :1, 0]
        x = x.copy()
        x[..., 0] -= period * np.round(dx / period)
    return x


def scaled_jacobian(mesh: RegionMesh, period: float | None = None) -> NDArray[np.float64]:
    x = corners_of(mesh, mesh.quads, period)
    edge = np.roll(x, -1, 1) - x
    back = np.roll(edge, 1, 1)
    cross = back[..., 0] * edge[..., 1] - back[..., 1] * edge[..., 0]
    return (cross / (np.hypot(*np.moveaxis(edge, 2, 0)) * np.hypot(*np.moveaxis(back, 2, 0)))).min(axis=1)


def least_angles(mesh: RegionMesh, period: float | None = None) -> NDArray[np.float64]:
    """Smallest angle of each triangle, degrees."""
    x = corners_of(mesh, mesh.triangles, period)
    edge = np.roll(x, -1, 1) - x
    back = -np.roll(edge, 1, 1)
    cross = edge[..., 0] * back[..., 1] - edge[..., 1] * back[..., 0]
    return np.degrees(np.arctan2(cross, (edge * back).sum(axis=2))).min(axis=1)


def sides(mesh: RegionMesh) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Every side of the elements once, sorted, and how many elements use it."""
    pairs = [nodes[:, [k, (k + 1) % nodes.shape[1]]] for nodes in elements(mesh) for k in range(nodes.shape[1])]
    return np.unique(np.sort(np.concatenate(pairs), axis=1), axis=0, return_counts=True)


def ring_area(region: Region) -> float:
    a, b = (region.points[region.edges[region.is_boundary, k]] for k in (0, 1))
    dx = b[:, 0] - a[:, 0]
    if region.period is not None:
        dx -= region.period * np.round(dx / region.period)
    return -float((dx * (0.5 * (a[:, 1] + b[:, 1]) - region.points[0, 1])).sum())


def assert_meshes(region: Region, mesh: RegionMesh) -> None:
    """What must hold of every mesh: seeds and edges kept, conforming, every element positive, no area lost."""
    n_point = len(region.points)
    np.testing.assert_array_equal(mesh.points[:n_point], region.points)
    side, use = sides(mesh)
    assert use.max() <= 2
    own = np.unique(np.sort(region.edges[region.is_boundary], axis=1), axis=0)
    np.testing.assert_array_equal(side[use == 1], own)
    known = {tuple(pair) for pair in side.tolist()}
    assert all(tuple(sorted(edge)) in known for edge in region.edges.tolist())
    np.testing.assert_array_equal(np.unique(side), np.arange(len(mesh.points)))
    area = 0.0
    for nodes in elements(mesh):
        x = corners_of(mesh, nodes, region.period) - region.points[0]
        following = np.roll(x, -1, 1)
        areas = 0.5 * (x[..., 0] * following[..., 1] - following[..., 0] * x[..., 1]).sum(axis=1)
        assert areas.min() > 0
        area += float(areas.sum())
    assert area == ring_area(region) or abs(area / ring_area(region) - 1) < 1e-9
    n_element = sum(len(nodes) for nodes in elements(mesh))
    assert len(mesh.points) - len(side) + n_element == euler(region)
    if len(mesh.quads):
        assert scaled_jacobian(mesh, region.period).min() >= 0.2
    if region.period is not None:
        assert mesh.points[:, 0].min() >= 0 and mesh.points[:, 0].max() < region.period


def euler(region: Region) -> int:
    """Euler characteristic of a connected region: 1 minus its holes; of one round a cylinder 2 minus its rings."""
    n_ring = len(rings_of(region))
    return 2 - n_ring


def rings_of(region: Region) -> list[list[int]]:
    after = dict(region.edges[region.is_boundary].tolist())
    rings = []
    while after:
        v = next(iter(after))
        ring = []
        while v in after:
            ring.append(v)
            v = after.pop(v)
        rings.append(ring)
    return rings
