"""Equal regions get one mesh, wherever they lie and however they are numbered."""

from __future__ import annotations

import numpy as np
import pytest
from planar_regions import assert_meshes, hole, line, rectangle, region

from kernel.mesh.congruent import Meshes, standard_region
from kernel.mesh.planar import mesh_region
from kernel.mesh.region import Region, RegionError, RegionMesh

HARD = 2
"""Points inside the region, the last ones of it."""


def plate() -> Region:
    """Three curves and two hard points, with a hole so near to a side that ties would show."""
    return region(
        [rectangle(17, 11, 1), hole(4, 5.5, 1.5, 1)],
        curved=(1,),
        lines=[np.vstack([line((9, 3), (9, 8), 1), [[9.0, 8.0]]])],
        points=[(12.0, 4.0), (13.0, 6.0)],
    )


def moved(plane: Region, by: tuple[float, float], seed: int) -> tuple[Region, np.ndarray]:
    """The region elsewhere, its points and edges numbered anew; and the old number of each point."""
    random = np.random.default_rng(seed)
    n_curve = len(plane.points) - HARD
    order = np.concatenate([random.permutation(n_curve), n_curve + random.permutation(HARD)])
    number = np.argsort(order)
    rank = random.permutation(len(plane.edges))
    edges = number[plane.edges]
    turned = ~plane.is_boundary & (random.random(len(edges)) < 0.5)
    edges[turned] = edges[turned][:, ::-1]
    return Region(plane.points[order] + by, edges[rank], plane.is_boundary[rank], plane.is_curved[rank]), order


def places(mesh: RegionMesh, by: tuple[float, float]) -> set[tuple[tuple[float, ...], ...]]:
    """Every element by its corners' places, moved back, from its lowest corner on."""
    points = np.round(mesh.points - by, 6)
    found = set()
    for element in [*mesh.quads.tolist(), *mesh.triangles.tolist()]:
        corners = [tuple(points[node].tolist()) for node in element]
        first = corners.index(min(corners))
        found.add(tuple(corners[first:] + corners[:first]))
    return found


@pytest.mark.parametrize("faces", ["quad", "tri", "mixed"])
@pytest.mark.parametrize("by", [(0.0, 0.0), (1234.5, -77.7), (-1e4 / 3, 2e4 / 7)])
def test_a_region_that_is_moved_and_numbered_anew_has_the_same_mesh_there(faces: str, by: tuple[float, float]) -> None:
    plane = plate()
    other, order = moved(plane, by, seed=7)
    mesh, there = mesh_region(plane, 1.0, faces), mesh_region(other, 1.0, faces)
    assert_meshes(other, there)
    assert np.array_equal(there.points[: len(order)], other.points)
    assert places(there, by) == places(mesh, (0.0, 0.0))


def test_a_mesh_is_the_same_bytes_whether_its_like_was_met_before_or_not() -> None:
    planes = [moved(plate(), (60.0 * k / 7, 31.0 * k), seed=k)[0] for k in range(5)]
    alone = [mesh_region(plane, 1.0) for plane in planes]
    for order in (range(5), range(4, -1, -1)):
        known: Meshes = {}
        together = {k: mesh_region(planes[k], 1.0, known=known) for k in order}
        assert len(known) == 1
        for k in range(5):
            assert together[k].points.tobytes() == alone[k].points.tobytes()
            assert together[k].quads.tobytes() == alone[k].quads.tobytes()


def test_cells_between_imprints_are_meshed_once_each_kind() -> None:
    rungs = [np.vstack([line((x, 0), (x, 7), 1), [[float(x), 7.0]]]) for x in (5, 10, 15)]
    outline = rectangle(20, 7, 1)
    number = {tuple(point): k for k, point in enumerate(outline.tolist())}
    ladder = region([outline], lines=rungs)
    same = np.array([number.get(tuple(point), k) for k, point in enumerate(ladder.points.tolist())])
    used = np.unique(same)
    edges = np.searchsorted(used, same[ladder.edges])
    joined = Region(ladder.points[used], edges, ladder.is_boundary, ladder.is_curved)
    known: Meshes = {}
    mesh = mesh_region(joined, 1.0, known=known)
    assert_meshes(joined, mesh)
    assert len(known) == 1


def test_regions_of_another_size_kind_or_growth_are_not_taken_for_each_other() -> None:
    known: Meshes = {}
    for size, faces, growth in ((1.0, "quad", 0.3), (1.5, "quad", 0.3), (1.0, "tri", 0.3), (1.0, "quad", 0.1)):
        mesh_region(plate(), size, faces, growth, known)
    assert len(known) == 4


def test_the_standard_region_is_the_same_bytes_though_coordinates_are_rounded_differently() -> None:
    plane = plate()
    for k, by in enumerate([(1e3 / 3, 2e3 / 7), (5e3 / 9, -1e3 / 11)]):
        there = standard_region(moved(plane, by, seed=k)[0]).region
        assert not np.array_equal(moved(plane, by, seed=k)[0].points[0] - by, plane.points[0])
        here = standard_region(plane).region
        assert here.points.tobytes() == there.points.tobytes()
        assert here.edges.tobytes() == there.edges.tobytes()


def test_an_error_names_the_place_in_the_region_itself() -> None:
    crossing = region([rectangle(10, 10, 1), hole(9.3, 5.1, 2, 1)])
    with pytest.raises(RegionError) as here:
        mesh_region(crossing, 1.0)
    by = np.array([100.0, 1000.0])
    with pytest.raises(RegionError) as there:
        mesh_region(Region(crossing.points + by, crossing.edges, crossing.is_boundary, crossing.is_curved), 1.0)
    assert np.allclose(there.value.at, here.value.at + by, atol=1e-6)
    assert there.value.said == here.value.said
