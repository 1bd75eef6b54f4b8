"""Cuts, sections, cutters and the boundary representation."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from trees import at, difference, evaluated, turned, union

from kernel.csg.tree import Block, Cylinder, Sphere
from kernel.errors import OptionError
from kernel.segment.faces import Faces
from kernel.solid.brep import brep_of
from kernel.solid.export import ENDINGS, ending_of, solid_bytes
from kernel.solid.section import area_within, face_polygon, section
from kernel.solid.solid import half_space_cut, intersect, prism, subtract, tube, unite
from kernel.solid.surfaces import CylinderSurface, Plane, plane_frame

X, Y, Z = np.eye(3)
DRILLED = difference(Block(size=(10, 10, 1)), Cylinder(radius=2, height=5, placement=at(5, 5, -1)))


def test_a_section_names_the_surface_that_trims_each_edge() -> None:
    result = evaluated(DRILLED)
    cut = section(result.solid, Z, 0.5)
    outer, hole = sorted(cut.rings, key=lambda ring: len(ring[0]))
    (number,) = set(hole[1].tolist())
    assert isinstance(result.surfaces.surfaces[number], CylinderSurface)
    assert np.abs(np.hypot(*(hole[0] - 5.0).T) - 2.0).max() < 1e-14
    assert len(set(outer[1].tolist())) == 4
    for (a, b), number in zip(zip(outer[0], np.roll(outer[0], -1, axis=0)), outer[1]):
        plane = result.surfaces.surfaces[number]
        assert isinstance(plane, Plane)
        for point in (a, b):
            assert point @ [plane.normal @ cut.u, plane.normal @ cut.v] == pytest.approx(plane.offset)
    assert cut.polygon.area == pytest.approx(100 - 48 * 4 * math.sin(2 * math.pi / 96), rel=1e-9)


def test_rings_run_with_the_section_on_their_left() -> None:
    for normal in (Z, -Z, X, np.array([1.0, 1.0, 0.2])):
        cut = section(evaluated(DRILLED).solid, normal, float(np.array([5, 2.0, 0.5]) @ normal))
        signed = sum(shapely.Polygon(p).area * (1 if shapely.LinearRing(p).is_ccw else -1) for p, _ in cut.rings)
        assert signed == pytest.approx(cut.polygon.area, rel=1e-8)


def test_a_section_adds_nothing_to_the_table() -> None:
    result = evaluated(DRILLED)
    before = len(result.surfaces.surfaces)
    assert section(result.solid, X, 3.3).area == pytest.approx(10 - 0.0 - 2 * math.sqrt(4 - 1.7**2), rel=1e-2)
    assert section(result.solid, X, 30.0).polygon.is_empty
    assert len(result.surfaces.surfaces) == before


def test_a_cut_on_a_face_leaves_no_sheet() -> None:
    result = evaluated(union(Block(size=(4, 4, 1)), Block(size=(1, 1, 5))))
    upper = half_space_cut(result.solid, Z, 1.0)
    assert upper.volume == pytest.approx(4.0)
    assert upper.area == pytest.approx(2 + 16)
    lower = half_space_cut(result.solid, -Z, -1.0)
    assert lower.volume == pytest.approx(16.0)
    assert lower.area == pytest.approx(32 + 16)
    plane = result.surfaces.find_plane(Z, 1.0)
    assert plane in upper.facets.surface and plane in lower.facets.surface


def test_cutting_what_lies_on_one_side_changes_nothing_or_leaves_nothing() -> None:
    solid = evaluated(Block(size=(1, 1, 1))).solid
    assert half_space_cut(solid, Z, 0.0) is solid
    assert half_space_cut(solid, Z, 1.0).is_empty


def test_the_parts_of_an_oblique_cut_make_up_the_whole() -> None:
    result = evaluated(difference(Sphere(radius=5), Cylinder(radius=1, height=20, placement=at(z=-10))))
    normal = np.array([1.0, 2.0, 3.0])
    parts = [half_space_cut(result.solid, sign * normal, sign * 1.5) for sign in (1.0, -1.0)]
    assert sum(part.volume for part in parts) == pytest.approx(result.solid.volume, rel=1e-12)
    shared = [set(part.facets.surface) for part in parts]
    cut = result.surfaces.find_plane(normal, 1.5)
    assert cut in shared[0] and cut in shared[1]


def test_a_tube_of_the_table_fits_the_pipe_exactly() -> None:
    pipe = difference(Cylinder(radius=10, height=50), Cylinder(radius=9, height=50))
    skew = turned([1, 2, 3], 33)
    result = evaluated(
        difference(*(type(node)(radius=node.radius, height=50, placement=at(4, 5, 6, skew)) for node in pipe.children))
    )
    table = result.surfaces
    axis_id = next(s.axis_id for s in table.surfaces if isinstance(s, CylinderSurface))
    along = result.solid.facets.vertices @ table.axes[axis_id].direction
    whole = tube(table, axis_id, 9.0, 10.0, along.min(), along.max())
    assert intersect([result.solid, whole]).volume == pytest.approx(result.solid.volume, rel=1e-12)
    left = subtract(result.solid, [whole])
    assert left.is_empty or left.volume < 1e-9 * result.solid.volume
    assert tube(table, axis_id, 0.0, 10.0, 0.0, 3.0).true_volume == pytest.approx(300 * math.pi)


@pytest.mark.parametrize("normal", [X, Y, Z, -Z, np.array([1.0, 2.0, 2.0]) / 3.0])
def test_a_prism_stands_on_its_frame(normal) -> None:
    result = evaluated(Block(size=(1, 1, 1)))
    region = shapely.box(0, 0, 4, 3).difference(shapely.box(1, 1, 2, 2)).union(shapely.box(10, 0, 11, 1))
    frame = plane_frame(normal)
    body = prism(result.surfaces, region, frame, -1.0, 2.0)
    assert body.volume == pytest.approx(36.0)
    along = body.facets.vertices @ frame.normal
    assert (along.min(), along.max()) == pytest.approx((-1.0, 2.0))
    across = np.stack([body.facets.vertices @ frame.u, body.facets.vertices @ frame.v])
    assert across.min() == pytest.approx(0.0, abs=1e-12) and across.max() == pytest.approx(11.0)
    assert all(isinstance(result.surfaces.surfaces[k], Plane) for k in body.facets.surface)


def test_an_empty_region_gives_an_empty_prism() -> None:
    table = evaluated(Block(size=(1, 1, 1))).surfaces
    assert prism(table, shapely.Polygon(), plane_frame(Z), 0.0, 1.0).is_empty


def test_uniting_one_solid_is_that_solid() -> None:
    solid = evaluated(Block(size=(1, 1, 1))).solid
    assert unite([solid]) is solid


def test_a_face_polygon_has_its_holes() -> None:
    result = evaluated(DRILLED)
    facets = result.solid.facets
    top = face_polygon(facets, facets.normals[:, 2] > 0.5, X, Y)
    assert len(top.interiors) == 1
    assert top.bounds == (0, 0, 10, 10)
    assert len(top.exterior.coords) == 5


def test_the_brep_of_a_drilled_plate() -> None:
    brep = brep_of(evaluated(DRILLED).solid)
    assert [type(face.surface).__name__ for face in brep.faces] == ["Plane"] * 6 + ["CylinderSurface"]
    assert [face.side for face in brep.faces] == [-1, 1, -1, 1, -1, 1, -1]
    assert brep.faces[5].area == pytest.approx(100 - 4 * math.pi, rel=1e-12)
    assert brep.faces[6].area == pytest.approx(4 * math.pi, rel=1e-9)
    assert len(brep.edges) == 14
    assert sum(edge.is_closed for edge in brep.edges) == 2
    assert all(edge.turn == pytest.approx(math.pi / 2, abs=1e-6) for edge in brep.edges)


def test_concave_edges_turn_the_other_way() -> None:
    brep = brep_of(evaluated(union(Block(size=(4, 4, 1)), Block(size=(1, 4, 5)))).solid)
    concave = [edge for edge in brep.edges if edge.turn < 0.0]
    assert [edge.length for edge in concave] == [4.0]


@pytest.mark.parametrize("ending", ENDINGS)
def test_exports_read_back_with_the_same_volume(ending, tmp_path) -> None:
    import trimesh

    result = evaluated(DRILLED)
    path = tmp_path / f"solid.{ending}"
    path.write_bytes(solid_bytes(result, ending))
    loaded = trimesh.load(path, force="mesh")
    loaded.merge_vertices()
    assert loaded.is_watertight
    assert loaded.volume == pytest.approx(result.solid.volume, rel=1e-5)


@pytest.mark.parametrize("path", ["part.step", "part", "stl", "part.stl.gz"])
def test_other_endings_are_refused(path) -> None:
    with pytest.raises(OptionError, match=r"expected one of \.stl \.glb \.3mf \.ply"):
        ending_of(path)


def test_boundaries_that_lie_on_one_another_enclose_what_they_run_round() -> None:
    """A post on a frame's lower chord, its end not one with the chord: two loops share a line, without its vertices."""
    outer = [(0, 0), (100, 0), (100, 50), (0, 50)]
    hole = [(10, 10), (10, 40), (90, 40), (90, 10)]
    post = [(40, 10), (44, 10), (44, 40), (40, 40)]
    loops = np.concatenate([np.stack([loop, np.roll(loop, -1, axis=0)], axis=1) for loop in (outer, hole, post)])
    for degrees in (0.0, 30.0, 77.0):
        turn = turned(Z, degrees)[:2, :2]
        region = area_within(loops @ turn.T, 1e-7)
        assert region.area == pytest.approx(100 * 50 - 80 * 30 + 4 * 30, rel=1e-9)
        assert region.covers(shapely.Point(turn @ (42.0, 25.0)))
        assert not region.covers(shapely.Point(turn @ (20.0, 25.0)))


def test_boundaries_that_cross_one_another_within_the_rounding_enclose_something() -> None:
    """Lines of a section through four leaning plates, of which no chain makes valid rings."""
    chains = (
        [(60456, 7111), (502, 7111), (5, 5026), (0, 5004), (126, 4961), (2015, 4666), (12320, 0), (59396, 5910)]
        + [(59564, 5942), (60456, 7111)],
        [(59564, 5942), (499, 7096), (0, 5004)],
        [(50952, 6937), (27217, 7111), (15924, 5689), (50952, 6937)],
    )
    lines = [np.stack([np.array(chain[:-1]), np.array(chain[1:])], axis=1) for chain in chains]
    region = area_within(np.concatenate(lines).astype(float), 1.0)
    assert region.is_valid
    assert region.covers(shapely.Point(30000.0, 6000.0))


def test_faces_of_a_skew_braced_frame_have_the_area_of_their_triangles() -> None:
    """Bars that touch in a frame of their own, askew to what says where the axes are."""
    bars = (
        ((304, 4, 4), (0, 0, 0)),
        ((304, 4, 4), (0, 0, 100)),
        ((4, 4, 96), (0, 0, 4)),
        ((4, 4, 96), (300, 0, 4)),
    )
    brace = Block(size=(3, 3, 135), placement=at(2, 0.5, 2, turned(Y, 45)))
    anchor = Block(size=(400, 400, 400), placement=at(-1000, 0, 0, turned(Y, 45)))
    frame = [Block(size=size, placement=at(*corner)) for size, corner in bars]
    faces = Faces(evaluated(union(*frame, brace, anchor)).solid)
    for (number, side), area in faces.areas.items():
        if isinstance(faces.table.surfaces[number], Plane):
            assert faces.polygon(number, side).area == pytest.approx(area, rel=1e-6)
