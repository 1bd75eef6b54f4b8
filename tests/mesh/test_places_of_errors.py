"""Where a face or a section cannot be meshed: the place is told in space, in the user's frame, not in the sheet's."""

from __future__ import annotations

import math
import pickle

import numpy as np
import pytest
from assembling import assembled, cube, placed, turned
from planar_regions import hole, rectangle, region
from shapely import Point

from kernel.errors import MeshError
from kernel.idealise import idealise
from kernel.idealise.brick import Piece
from kernel.idealise.sheets import CylinderSheet, PlaneSheet
from kernel.mesh import faces
from kernel.mesh.planar import mesh_region
from kernel.mesh.region import RegionError
from kernel.solid.surfaces import Axis, CylinderSurface, Plane

CROSSING = region([rectangle(10, 10, 1), hole(9.3, 5.1, 2, 1)])
DOUBLE = region([rectangle(10, 10, 1)], points=[(6, 4), (6, 4)])
TURNED_FRAME = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
"""User's (x, y, z) = working (z, x, y)."""


def inclined() -> PlaneSheet:
    """Through (0, 0, 3), its u and v in a plane turned by 30 degrees about x and then by 40 about z."""
    turn = turned("z", 40) @ turned("x", 30)
    u, v, normal = np.asarray(turn)[:3, :3].T
    offset = 3.0 * normal[2]
    return PlaneSheet(0, Plane(normal, offset, u, v), normal, offset, u, v)


def place_in(message: str) -> np.ndarray:
    return np.array([float(x) for x in message[message.rindex("(") + 1 : message.rindex(")")].split(",")])


def test_on_an_inclined_plate_the_place_is_in_space() -> None:
    sheet = inclined()
    task = faces.FaceTask("s1 (/0)", sheet, DOUBLE, np.arange(len(DOUBLE.points)), 1.0, "quad", None, TURNED_FRAME)
    with pytest.raises(MeshError, match=r"^s1 \(/0\): two points of the region coincide at \(") as caught:
        task.mesh()
    working = TURNED_FRAME.T @ place_in(caught.value.message)
    assert working @ sheet.normal == pytest.approx(sheet.offset, abs=1e-4)
    np.testing.assert_allclose(sheet.flat(working[None])[0], [6.0, 4.0], atol=1e-4)


def test_on_an_unrolled_cylinder_the_place_is_in_space() -> None:
    axis = Axis(np.zeros(3), np.array([0.0, 0.0, 1.0]), np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0]))
    sheet = CylinderSheet(0, CylinderSurface(axis, 0, 20.0), axis, 20.0, 0.0, is_closed=False)
    task = faces.FaceTask("s2", sheet, DOUBLE, np.arange(len(DOUBLE.points)), 1.0, "tri", None, np.eye(3))
    with pytest.raises(MeshError) as caught:
        task.mesh()
    expected = [20 * math.cos(0.3), 20 * math.sin(0.3), 4.0]
    np.testing.assert_allclose(place_in(caught.value.message), expected, atol=1e-3)


def test_a_region_by_itself_tells_its_own_coordinates_and_survives_a_process() -> None:
    with pytest.raises(RegionError, match=r"near \(") as caught:
        mesh_region(CROSSING, 1.0, "tri")
    assert np.hypot(*(caught.value.at - [10.0, 5.1])) < 2.0
    again = pickle.loads(pickle.dumps(caught.value))
    assert type(again) is RegionError
    assert str(again) == str(caught.value)
    assert again.told("(1, 2, 3)") == "an edge of the region meets another edge or point near (1, 2, 3)"


# ---------------------------------------------------------------- bricks that cannot be swept

LEANING = placed(cube(60, 40, 20), (10, 20, 30), turned("x", 20) @ turned("y", 35))


@pytest.fixture
def with_a_sliver(monkeypatch: pytest.MonkeyPatch) -> None:
    """A brick's stack with one more piece, narrower than any element, near the middle of its first outline."""
    group_bricks = idealise.group_bricks

    def slivered(*given):
        groups, outlines = group_bricks(*given)
        (brick,) = groups[0].bricks
        first = brick.pieces[0]
        x, y = first.outline.centroid.coords[0]
        sliver = Point(x + 3.3, y + 1.7).buffer(1e-9)  # not about the point that tells what is in the cell
        groups[0].bricks[0] = type(brick)(brick.segment, (*brick.pieces, Piece(first.start, first.end, sliver)))
        return groups, outlines

    monkeypatch.setattr(idealise, "group_bricks", slivered)


@pytest.mark.usefixtures("with_a_sliver")
def test_a_group_with_a_piece_that_holds_no_element_is_meshed_with_tetrahedra_and_said() -> None:
    assembly, _ = assembled(LEANING, {"/": "brick"}, size=15.0)
    assert set(assembly.mesh.count()) == {"tet10"}
    (said,) = [text for text in assembly.warnings if "tetrahedra" in text]
    assert "is not swept but meshed with tetrahedra: a piece of s1" in said
    turn = turned("x", 20) @ turned("y", 35)
    on_box = np.sort(np.abs(turn.T @ (place_in(said) - [10, 20, 30]) - [30, 20, 10]))
    np.testing.assert_allclose(on_box, [0.0, 1.7, 3.3], atol=1e-3)


@pytest.mark.usefixtures("with_a_sliver")
def test_a_group_with_a_piece_that_holds_no_element_is_refused_where_hexahedra_alone_are_asked_for() -> None:
    with pytest.raises(MeshError, match=r"^s1 .* cannot be meshed with hexahedra only: a piece of s1 .* near \("):
        assembled(LEANING, {"/": "brick"}, size=15.0, volumes="hex")
