"""The renderer: what is in front hides what is behind, and the file is a PNG."""

import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest
from handmade import model_of

from app.report.quality_scene import RAMP, quality_bodies
from app.report.render import Scene, png, render
from app.report.scenes import COUPLING_COLOURS, mesh_bodies
from kernel.connect.model import Mpc, Property, Rbe2, Rbe3
from kernel.mesh.mesh import ElementBlock

RED, BLUE, BLACK = (255, 0, 0), (0, 0, 255), (0, 0, 0)
FROM_ABOVE = (0.0, 0.0, 1.0)


def square(z, half=1.0):
    corners = np.array([(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)])
    return corners[[[0, 1, 2], [0, 2, 3]]]


def scene(*squares, lines=()):
    triangles = np.concatenate([square(z, half) for z, half, _ in squares])
    colours = np.repeat(np.array([colour for *_, colour in squares], np.uint8), 2, axis=0)
    drawn = np.array(lines, float).reshape(-1, 2, 3)
    return Scene(triangles, colours, drawn, np.tile(np.array(BLACK, np.uint8), (len(drawn), 1)))


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_square_hides_the_farther_one_whatever_their_order(order):
    squares = [(0.0, 1.0, RED), (0.5, 0.5, BLUE)]
    image = render(scene(*(squares[k] for k in order)), 100, 100, FROM_ABOVE)
    assert image[50, 50, 2] > 150 and image[50, 50, 0] == 0
    assert image[50, 10, 0] > 150 and image[50, 10, 2] == 0


def test_a_line_on_a_face_is_seen_and_one_behind_it_is_not():
    on, behind = [(-1, 0, 0), (1, 0, 0)], [(-1, 0.5, -0.5), (1, 0.5, -0.5)]
    image = render(scene((0.0, 1.0, RED), lines=[on, behind]), 100, 100, FROM_ABOVE)
    assert image[48:52, 50].min() < 10
    assert image[20:35, 50, 0].min() > 150


def test_a_mark_behind_a_face_is_seen():
    hidden = scene((0.0, 1.0, RED))
    marks = np.array([[(-1, 0.5, -0.5), (1, 0.5, -0.5)]], float)
    image = render(replace(hidden, marks=marks, mark_colours=np.array([BLUE], np.uint8)), 100, 100, FROM_ABOVE)
    assert image[20:35, 50, 2].max() > 100


def test_couplings_are_marks_from_the_node_that_stands_alone():
    nodes = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
    block = ElementBlock("s1", "tri3", np.array([[0, 1, 2]]))
    couplings = (
        Rbe3(3, np.array([0, 1]), np.ones(2)),
        Rbe2(0, np.array([3])),
        Mpc(np.array([2, 3, 3]), np.array([1, 1, 2]), np.array([1.0, -0.5, -0.5])),
    )
    model = replace(model_of(nodes, [block], [Property("s1", "shell", "steel", thickness=1.0)]), couplings=couplings)
    marks = {body.name: body for body in mesh_bodies(model) if body.is_mark}
    assert {name: body.line_colour for name, body in marks.items()} == COUPLING_COLOURS
    assert marks["rbe3"].lines.tolist() == [[[0, 0, 1], [0, 0, 0]], [[0, 0, 1], [1, 0, 0]]]
    assert marks["rbe2"].lines.tolist() == [[[0, 0, 0], [0, 0, 1]]]
    assert marks["mpc"].lines.tolist() == [[[0, 1, 0], [0, 0, 1]]]


def test_a_face_turned_away_from_the_light_is_darker():
    corners = np.array([(0, 0, 0), (1, 0, 0), (1, 0, 1), (0, 0, 1), (1, 1, 0), (1, 1, 1), (0, 1, 1)], float)
    triangles = corners[[[0, 1, 2], [0, 2, 3], [1, 4, 5], [1, 5, 2], [3, 2, 5], [3, 5, 6]]]
    image = render(Scene(triangles, np.full((6, 3), 200, np.uint8)), 200, 200)
    shades = {int(value) for value in np.unique(image[..., 0]) if value < 250 and (image[..., 0] == value).sum() > 500}
    assert len(shades) == 3


def test_elements_are_coloured_by_their_scaled_jacobian():
    square_and_rhombus = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [2, 1, 0], [2, 2, 0]], float)
    block = ElementBlock("s1", "quad4", np.array([[0, 1, 2, 3], [1, 4, 5, 2]]))
    model = model_of(square_and_rhombus, [block], [Property("s1", "plate", "steel", thickness=1.0)])
    bodies = quality_bodies(model)
    assert [(body.name, body.colour) for body in bodies] == [("s1 0.7", RAMP[7]), ("s1 0.9", RAMP[9])]
    assert [len(body.triangles) for body in bodies] == [2, 2]


def test_an_empty_scene_is_a_white_picture():
    assert render(Scene(np.empty((0, 3, 3)), np.empty((0, 3), np.uint8)), 20, 10).min() == 255


def test_the_picture_survives_the_png():
    image = np.random.default_rng(1).integers(0, 256, (7, 5, 3), np.uint8)
    content = png(image)
    assert content.startswith(b"\x89PNG\r\n\x1a\n") and content.endswith(b"IEND\xaeB`\x82")
    assert struct.unpack(">II", content[16:24]) == (5, 7)
    length = struct.unpack(">I", content[33:37])[0]
    rows = np.frombuffer(zlib.decompress(content[41 : 41 + length]), np.uint8).reshape(7, 16)
    assert (rows[:, 0] == 2).all()
    assert (np.cumsum(rows[:, 1:], axis=0, dtype=np.uint8).reshape(7, 5, 3) == image).all()
