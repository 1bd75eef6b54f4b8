"""Planar regions: what every mesh must satisfy, over families of regions, and how good meshes of known plates are."""

from __future__ import annotations

import math
import time
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from planar_regions import (
    assert_meshes,
    hole,
    least_angles,
    line,
    plate_with_holes,
    polygon,
    rectangle,
    region,
    scaled_jacobian,
    sides,
)

from kernel.errors import MeshError
from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region


def random_region(seed: int, is_even: bool, gap: float = 0.8) -> tuple[Region, float]:
    """A star-shaped outline with holes, slits and hard points, each `gap` sizes apart from the others at least."""
    from shapely import LineString, Point, Polygon

    random = np.random.default_rng(seed)
    angles: np.ndarray = np.array([])
    while len(angles) == 0 or np.diff(np.r_[angles, angles[0] + 2 * np.pi]).min() < 0.15:
        angles = np.sort(random.uniform(0, 2 * np.pi, random.integers(3, 14)))
        if np.diff(np.r_[angles, angles[0] + 2 * np.pi]).max() > 2.8:
            angles = np.array([])
    radius = random.uniform(40, 100, len(angles))
    corners = list(zip(radius * np.cos(angles), radius * np.sin(angles), strict=True))
    size = float(random.choice([8, 4, 2]))
    outline = Polygon(corners)
    taken: list = []

    def has_room(shape: object) -> bool:
        if not outline.contains(shape) or outline.exterior.distance(shape) < gap * size:
            return False
        return all(shape.distance(other) > gap * size for other in taken)

    rings, lines, points = [polygon(corners, size, is_even)], [], []
    for _ in range(20):
        x, y, r = *random.uniform(-90, 90, 2), random.uniform(0.4 * size, 15)
        if has_room(disc := Point(x, y).buffer(r)):
            taken.append(disc)
            rings.append(hole(x, y, r, size, is_even))
    for _ in range(3):
        start = random.uniform(-80, 80, 2)
        way = random.uniform(2 * size, 40) * np.array([math.cos(t := random.uniform(0, 6.28)), math.sin(t)])
        if has_room(slit := LineString([start, start + way])):
            taken.append(slit)
            lines.append(np.concatenate([line(tuple(start), tuple(start + way), size, is_even), [start + way]]))
    for _ in range(3):
        if has_room(spot := Point(*random.uniform(-80, 80, 2))):
            taken.append(spot)
            points.append((spot.x, spot.y))
    return region(rings, tuple(range(1, len(rings))), lines, points), size


FEW = settings(max_examples=15)


@FEW
@given(st.integers(0, 10_000))
def test_random_regions_mesh_with_quads_alone(seed: int) -> None:
    plane, size = random_region(seed, is_even=True)
    mesh = mesh_region(plane, size)
    assert_meshes(plane, mesh)
    assert len(mesh.triangles) == 0
    assert scaled_jacobian(mesh).min() >= 0.45


@FEW
@given(st.integers(0, 10_000))
def test_random_regions_mesh_with_triangles(seed: int) -> None:
    plane, size = random_region(seed, is_even=False)
    mesh = mesh_region(plane, size, "tri")
    assert_meshes(plane, mesh)
    assert np.median(least_angles(mesh)) > 45


@FEW
@given(st.integers(0, 10_000))
def test_holes_slits_and_points_that_nearly_touch_still_mesh(seed: int) -> None:
    plane, size = random_region(seed, is_even=True, gap=1 / 30)
    for faces in ("quad", "mixed", "tri"):
        assert_meshes(plane, mesh_region(plane, size, faces))


@FEW
@given(st.integers(0, 10_000))
def test_odd_curves_mesh_with_quads_and_few_triangles(seed: int) -> None:
    plane, size = random_region(seed, is_even=False)
    mesh = mesh_region(plane, size, "mixed")
    assert_meshes(plane, mesh)
    assert len(mesh.triangles) < 0.5 * len(mesh.quads)


@pytest.mark.parametrize("size", [1.0, 0.5])
def test_triangles_on_a_plate_with_six_holes_are_nearly_equilateral(size: float) -> None:
    plate = plate_with_holes(size, is_even=False)
    angles = least_angles(mesh_region(plate, size, "tri"))
    assert angles.min() >= 35
    assert angles.mean() >= 58


@pytest.mark.parametrize("size", [1.0, 0.5])
def test_quads_on_a_plate_with_six_holes_are_nearly_square(size: float) -> None:
    plate = plate_with_holes(size)
    mesh = mesh_region(plate, size)
    quality = scaled_jacobian(mesh)
    assert len(mesh.triangles) == 0
    assert quality.min() >= 0.75
    assert np.percentile(quality, 5) >= 0.95
    assert quality.mean() >= 0.99
    side, use = sides(mesh)
    valence = np.bincount(side.ravel())
    is_inner = np.ones(len(valence), bool)
    is_inner[side[use == 1].ravel()] = False
    assert np.mean(valence[is_inner] != 4) < 0.01


def test_a_rectangle_is_meshed_in_squares() -> None:
    mesh = mesh_region(region([rectangle(20, 10, 1)]), 1.0)
    assert len(mesh.quads) == 200
    np.testing.assert_allclose(scaled_jacobian(mesh), 1, atol=1e-12)


@pytest.mark.parametrize("angle", [7, 17, 33, 45, 80])
def test_a_turned_plate_gets_as_good_a_mesh(angle: float) -> None:
    plate = plate_with_holes(2.0)
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    turned = Region(plate.points @ [[c, s], [-s, c]], plate.edges, plate.is_boundary, plate.is_curved)
    mesh = mesh_region(turned, 2.0)
    assert_meshes(turned, mesh)
    upright = scaled_jacobian(mesh_region(plate, 2.0))
    quality = scaled_jacobian(mesh)
    assert quality.min() >= upright.min() - 0.05
    assert quality.mean() >= upright.mean() - 0.005


@pytest.mark.parametrize(("factor", "offset"), [(1.0, 1e6), (1e-3, 0.0), (1e5, -3e6)])
def test_scale_and_place_do_not_matter(factor: float, offset: float) -> None:
    plate = plate_with_holes(4.0)
    moved = Region(plate.points * factor + offset, plate.edges, plate.is_boundary, plate.is_curved)
    mesh = mesh_region(moved, 4.0 * factor)
    assert_meshes(moved, mesh)
    assert scaled_jacobian(mesh).min() >= 0.7


@pytest.mark.parametrize("faces", ["quad", "tri", "mixed"])
def test_the_same_region_gives_the_same_bytes(faces: str) -> None:
    first, second = (mesh_region(plate_with_holes(3.0), 3.0, faces) for _ in range(2))
    assert first.points.tobytes() == second.points.tobytes()
    assert first.quads.tobytes() == second.quads.tobytes()
    assert first.triangles.tobytes() == second.triangles.tobytes()


def test_imprints_that_divide_and_cross_are_element_edges_on_both_sides() -> None:
    outer = rectangle(40, 20, 2)
    upright = np.concatenate([line((20, 0), (20, 20), 2), [(20, 20)]])
    inner = upright[1:-1]
    n = len(outer)
    bottom = int(np.flatnonzero((outer == [20, 0]).all(axis=1))[0])
    top = int(np.flatnonzero((outer == [20, 20]).all(axis=1))[0])
    chain = [bottom, *range(n, n + len(inner)), top]
    edges = np.concatenate(
        [np.column_stack([np.arange(n), np.roll(np.arange(n), -1)]), np.column_stack([chain[:-1], chain[1:]])]
    )
    plane = Region(np.concatenate([outer, inner]), edges, np.arange(len(edges)) < n, np.zeros(len(edges), bool))
    for faces in ("quad", "tri"):
        mesh = mesh_region(plane, 2.0, faces)
        assert_meshes(plane, mesh)
        side, use = sides(mesh)
        for a, b in pairwise(chain):
            assert use[(side == sorted((a, b))).all(axis=1)] == [2]


@pytest.mark.parametrize("width", [0.1, 1.0, 3.0, 12.0])
def test_thin_strips_mesh(width: float) -> None:
    strip = region([rectangle(1000, width, 10)])
    mesh = mesh_region(strip, 10.0)
    assert_meshes(strip, mesh)
    assert scaled_jacobian(mesh).min() > 0.99


def test_a_long_oblique_strip_costs_no_more_than_an_upright_one() -> None:
    strip = region([rectangle(4000, 20, 5), hole(2000, 10, 4, 2)], (1,))
    c = math.sqrt(0.5)
    oblique = Region(strip.points @ [[c, c], [-c, c]], strip.edges, strip.is_boundary, strip.is_curved)
    mesh_region(oblique, 5.0)
    seconds = []
    for plane in (strip, oblique):
        start = time.process_time()
        n_quad = len(mesh_region(plane, 5.0).quads)
        seconds.append(time.process_time() - start)
        assert 3000 < n_quad < 3600
    assert seconds[1] < 4 * seconds[0] + 0.02


def test_ten_thousand_holes_mesh() -> None:
    centres = [(10 * i + 5.0, 10 * j + 5.0) for i in range(100) for j in range(100)]
    plane = region([rectangle(1000, 1000, 5), *(hole(x, y, 2, 1.5) for x, y in centres)], tuple(range(1, 10_001)))
    mesh = mesh_region(plane, 3.0)
    assert scaled_jacobian(mesh).min() >= 0.2
    assert len(np.unique(mesh.quads)) == len(mesh.points)


def test_an_odd_curve_is_refused_with_its_place() -> None:
    with pytest.raises(MeshError, match=r"curve through \(.*\) is divided into an odd number of edges"):
        mesh_region(region([polygon([(0, 0), (9, 0), (0, 9)], 3, is_even=False)[1:]]), 3.0)


def test_crossing_rings_are_refused_with_their_place() -> None:
    with pytest.raises(MeshError, match=r"meets another edge or point near \("):
        mesh_region(region([rectangle(10, 10, 1), hole(9.3, 5.1, 2, 1)]), 1.0, "tri")


def test_coinciding_points_are_refused_with_their_place() -> None:
    with pytest.raises(MeshError, match=r"coincide at \(5, 5\)"):
        mesh_region(region([rectangle(10, 10, 1)], points=[(5, 5), (5, 5)]), 1.0)


def test_a_point_outside_is_refused_with_its_place() -> None:
    with pytest.raises(MeshError, match=r"\(50, 5\) of the region is not inside"):
        mesh_region(region([rectangle(10, 10, 1)], points=[(50, 5)]), 1.0)


def test_an_open_boundary_is_refused_with_its_place() -> None:
    square = region([rectangle(10, 10, 1)])
    opened = Region(square.points, square.edges[1:], square.is_boundary[1:], square.is_curved[1:])
    with pytest.raises(MeshError, match=r"not closed at \("):
        mesh_region(opened, 1.0)


def test_a_boundary_that_runs_the_wrong_way_is_refused() -> None:
    with pytest.raises(MeshError, match="region on their left"):
        mesh_region(region([rectangle(10, 10, 1)[::-1]]), 1.0)


def test_values_without_sense_are_refused() -> None:
    square = region([rectangle(10, 10, 1)])
    with pytest.raises(MeshError, match=r"would take some 1e.10 elements"):
        mesh_region(square, 1e-4)
    with pytest.raises(MeshError, match="expected a positive number"):
        mesh_region(square, 0.0)
    with pytest.raises(MeshError, match="expected one of"):
        mesh_region(square, 1.0, "hex")
    broken = Region(
        np.where(square.points > 9, np.nan, square.points), square.edges, square.is_boundary, square.is_curved
    )
    with pytest.raises(MeshError, match="nan"):
        mesh_region(broken, 1.0)


@pytest.mark.parametrize("faces", ["quad", "tri", "mixed"])
def test_read_only_strided_or_narrow_arrays_give_the_same_mesh_and_compile_nothing(faces: str) -> None:
    from kernel.numeric.triangulation import triangulate

    plate = plate_with_holes(5.0)
    expected = mesh_region(plate, 5.0, faces)
    points = np.asfortranarray(np.repeat(plate.points, 2, axis=0))[::2]
    edges = plate.edges.astype(np.int32)
    for array in (points, edges):
        array.flags.writeable = False
    mesh = mesh_region(Region(points, edges, plate.is_boundary, plate.is_curved), 5.0, faces)
    np.testing.assert_array_equal(mesh.points, expected.points)
    assert mesh.quads.dtype == mesh.triangles.dtype == np.int64
    assert len(triangulate.signatures) == 1


@pytest.mark.parametrize("n", [3, 4, 5, 6, 8])
@pytest.mark.parametrize("faces", ["quad", "mixed", "tri"])
def test_holes_of_very_few_seeds_mesh(n: int, faces: str) -> None:
    t = -2 * np.pi * np.arange(n) / n
    plane = region([rectangle(10, 10, 1), np.column_stack([5 + 0.7 * np.cos(t), 5 + 0.7 * np.sin(t)])], (1,))
    if faces == "quad" and n % 2:
        with pytest.raises(MeshError, match="odd number"):
            mesh_region(plane, 1.0, faces)
        return
    assert_meshes(plane, mesh_region(plane, 1.0, faces))


@pytest.mark.parametrize("faces", ["quad", "mixed", "tri"])
@pytest.mark.parametrize("n", [4, 6, 8])
def test_regions_without_room_for_an_inner_node_mesh(n: int, faces: str) -> None:
    t = 2 * np.pi * np.arange(n) / n
    plane = region([np.column_stack([np.cos(t), np.sin(t)])])
    assert_meshes(plane, mesh_region(plane, 1.0, faces))
    ell = region([np.array([(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2.0)])])
    assert_meshes(ell, mesh_region(ell, 1.0, faces))


def test_an_imprinted_lens_of_two_short_curves_keeps_all_its_edges() -> None:
    outer = rectangle(12, 12, 1)
    n = len(outer)
    lens = np.array([(5.0, 6.0), (7.0, 6.0), (6.0, 6.6), (6.0, 5.4)])
    imprint = [(n, n + 2), (n + 2, n + 1), (n, n + 3), (n + 3, n + 1)]
    edges = np.concatenate([np.column_stack([np.arange(n), np.roll(np.arange(n), -1)]), imprint])
    plane = Region(np.concatenate([outer, lens]), edges, np.arange(len(edges)) < n, np.zeros(len(edges), bool))
    for faces in ("quad", "mixed", "tri"):
        assert_meshes(plane, mesh_region(plane, 1.0, faces))


@pytest.mark.parametrize("faces", ["quad", "tri"])
def test_a_smaller_growth_gives_more_elements_about_a_finely_seeded_hole(faces: str) -> None:
    plane = region([rectangle(100, 100, 4), hole(50, 50, 5, 0.5)], (1,))
    counts = []
    for growth in (0.6, 0.3, 0.1):
        mesh = mesh_region(plane, 4.0, faces, growth)
        assert_meshes(plane, mesh)
        counts.append(len(mesh.quads) + len(mesh.triangles))
    assert counts[0] < counts[1] < counts[2]


@pytest.mark.parametrize("growth", [0.0, -1.0, math.nan])
def test_a_growth_without_sense_is_refused(growth: float) -> None:
    with pytest.raises(MeshError, match="growth is"):
        mesh_region(region([rectangle(10, 10, 1)]), 1.0, "quad", growth)
