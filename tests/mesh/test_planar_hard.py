"""What meshers fail on, in small: holes almost touching, holes far under the size, sharp corners, strips with holes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from planar_regions import assert_meshes, hole, least_angles, polygon, rectangle, region, scaled_jacobian
from plates import arc_lengths

from kernel.mesh.gaps import SampledCurve, divide, gap_sizes
from kernel.mesh.planar import mesh_region


def seeded_by_gaps(gap: float) -> list[np.ndarray]:
    """Four round holes of radius 6 in a row, `gap` apart, seeded at a size of 2 or as their gaps ask."""
    t = np.linspace(0, -2 * np.pi, 257)
    circles = []
    for k in range(4):
        x = 10 + 6 + k * (12 + gap)
        circles.append(SampledCurve(np.column_stack([x + 6 * np.cos(t), 15 + 6 * np.sin(t)]), k, k, True, 2.0))
    rings = []
    for curve, sizes in zip(circles, gap_sizes(circles)):
        along = arc_lengths(curve.points)
        seeds = np.concatenate([[0.0], divide(along, sizes, 16, True)])
        rings.append(np.column_stack([np.interp(seeds, along, curve.points[:, k]) for k in range(2)]))
    return rings


@pytest.mark.parametrize("gap", [1.0, 0.2, 2 / 30])
def test_holes_almost_touching_mesh_well(gap: float) -> None:
    plane = region([rectangle(20 + 48 + 3 * gap, 30, 2), *seeded_by_gaps(gap)], (1, 2, 3, 4))
    mesh = mesh_region(plane, 2.0)
    assert_meshes(plane, mesh)
    assert len(mesh.triangles) == 0
    assert scaled_jacobian(mesh).min() >= 0.6
    triangles = mesh_region(plane, 2.0, "tri")
    assert_meshes(plane, triangles)
    assert least_angles(triangles).min() >= 30


def test_holes_far_under_the_size_mesh() -> None:
    holes = [hole(4.0 * i + 4, 4.0 * j + 4, 0.3, 2.0) for i in range(6) for j in range(3)]
    plane = region([rectangle(28, 16, 2), *holes], tuple(range(1, 19)))
    for faces in ("quad", "tri"):
        mesh = mesh_region(plane, 2.0, faces)
        assert_meshes(plane, mesh)
        if faces == "quad":
            assert scaled_jacobian(mesh).min() >= 0.45


@pytest.mark.parametrize("angle", [30, 15, 5])
def test_sharp_corners_are_as_good_as_they_can_be(angle: float) -> None:
    plane = region([polygon([(0, 0), (60, 0), (60, 60 * math.tan(math.radians(angle)))], 2.0)])
    mesh = mesh_region(plane, 2.0)
    assert_meshes(plane, mesh)
    if len(mesh.triangles) == 0:
        assert scaled_jacobian(mesh).min() >= 0.95 * math.sin(math.radians(angle))
    else:
        assert angle < 12  # no quad under .2 may leave: a triangle stands in the corner
    triangles = mesh_region(plane, 2.0, "tri")
    assert_meshes(plane, triangles)
    assert least_angles(triangles).min() >= 0.75 * angle


def test_a_strip_with_holes_across_most_of_it_meshes() -> None:
    holes = [hole(10.0 * k + 5, 1.5, 0.5, 0.4) for k in range(10)]
    plane = region([rectangle(100, 3, 1), *holes], tuple(range(1, 11)))
    mesh = mesh_region(plane, 3.0)
    assert_meshes(plane, mesh)
    assert scaled_jacobian(mesh).min() >= 0.7
    triangles = mesh_region(plane, 3.0, "tri")
    assert_meshes(plane, triangles)
    assert least_angles(triangles).min() >= 30


def sector(radius: float, degrees: float, size: float) -> np.ndarray:
    """From the centre along the x axis, round, and back."""
    end = math.radians(degrees)
    n = 2 * max(1, round(end * radius / size / 2), math.ceil(degrees / 30))
    arc = np.linspace(0, end, n + 1)[:-1]
    tip = radius * np.array([math.cos(end), math.sin(end)])
    straight = (polygon([(0, 0), (radius, 0)], size), polygon([(tip[0], tip[1]), (0, 0)], size))
    half = [side[: len(side) // 2] for side in straight]
    return np.concatenate([half[0], radius * np.column_stack([np.cos(arc), np.sin(arc)]), half[1]])


def corners_between_chords(mesh, plane) -> list[float]:
    """Degrees of the quads' corners between two of the region's edges."""
    sides = {frozenset(edge) for edge in plane.edges.tolist()}
    found = []
    for quad in mesh.quads.tolist():
        for before, at, after in zip(quad[-1:] + quad[:-1], quad, quad[1:] + quad[:1], strict=True):
            if {frozenset((before, at)), frozenset((at, after))} <= sides:
                u, v = mesh.points[after] - mesh.points[at], mesh.points[before] - mesh.points[at]
                found.append(math.degrees(math.atan2(u[0] * v[1] - u[1] * v[0], u @ v)) % 360)
    return found


@pytest.mark.parametrize("degrees", [105, 140, 180, 230])
@pytest.mark.parametrize("size", [3.0, 4.0, 5.0, 6.0, 8.0])
def test_no_quad_has_two_chords_of_one_arc_for_sides(degrees: float, size: float) -> None:
    """It would have a corner of 165 degrees, whatever the smoothing does."""
    plane = region([sector(20.0, degrees, size)])
    mesh = mesh_region(plane, size)
    assert_meshes(plane, mesh)
    assert len(mesh.triangles) == 0
    assert max(corners_between_chords(mesh, plane)) < 150
