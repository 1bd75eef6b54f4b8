"""Solids whose section changes at levels along an axis: one hex mesh of shared nodes, whatever the tree says."""

from __future__ import annotations

import math

import numpy as np
import pytest
from assembling import WHOLE, assembled, audit, cube, difference, extrusion, mesh_volume, placed, rod, turned, union

from kernel.errors import MeshError
from kernel.mesh.bricks import outer_faces
from kernel.mesh.quality import mesh_quality


def bolts(count: int, radius: float, circle: float, height: float) -> list[str]:
    """Drills on a bolt circle."""
    angles = 2 * math.pi * np.arange(count) / count
    return [rod(height + 2, radius, (circle * math.cos(a), circle * math.sin(a), -1)) for a in angles]


SLOT = union(rod(40, 10, (30, 30, 15)), rod(40, 10, (70, 30, 15)), cube(40, 20, 40, (30, 20, 15)))
BOSS = union(cube(100, 80, 20), rod(40, 20, (50, 40, 0)))
STACKS = {
    "two diameters, touching": union(rod(50, 10), rod(40, 6, (0, 0, 50))),
    "two diameters, overlapping": union(rod(60, 10), rod(40, 6, (0, 0, 50))),
    "five diameters": union(*(rod(30, r, (0, 0, 25 * k)) for k, r in enumerate((10, 20, 30, 26, 13)))),
    "two diameters that nearly agree": union(rod(50, 10), rod(40, 10.01, (0, 0, 50))),
    "a bored shaft": difference(union(rod(60, 10), rod(40, 6, (0, 0, 50))), rod(100, 3, (0, 0, -1))),
    "a plate with a round boss": BOSS,
    "a plate with a square boss": union(cube(100, 80, 20), cube(30, 30, 20, (35, 25, 20))),
    "a boss, turned": placed(BOSS, (10, 20, 30), turned("x", 20) @ turned("y", 35)),
    "a flange with a hub and bolt holes": difference(
        union(rod(20, 80), rod(60, 40)), rod(100, 25, (0, 0, -1)), *bolts(6, 7, 60, 20)
    ),
    "a counterbored plate": difference(
        cube(100, 80, 30),
        *(rod(40, 8, (x, y, -5)) for x in (25, 75) for y in (20, 60)),
        *(rod(40, 14, (x, y, 18)) for x in (25, 75) for y in (20, 60)),
    ),
    "a block with a blind hole": difference(cube(60, 60, 40), rod(40, 12, (30, 30, 15))),
    "a block with a pocket": difference(cube(60, 60, 40), cube(20, 30, 30, (20, 15, 15))),
    "a block with a round-ended slot": difference(cube(100, 60, 40), SLOT),
    "a shaft cut from a block": difference(
        cube(60, 60, 100), difference(cube(70, 70, 60, (-5, -5, 50)), rod(100, 20, (30, 30, 0)))
    ),
}


@pytest.mark.parametrize("name", STACKS)
def test_a_stack_of_prisms_as_one_brick_is_meshed_with_hexes_alone(name):
    assembly, evaluated = assembled(STACKS[name], {"/": "brick"}, volumes="hex")
    assert [segment.type for segment in assembly.segments] == ["brick"]
    assert set(assembly.mesh.count()) == {"hex8"}
    assert mesh_quality(assembly.mesh)["hex8"]["scaled_jacobian"]["min"] >= 0.5
    assert audit(assembly) == WHOLE
    assert mesh_volume(assembly) == pytest.approx(evaluated.solid.true_volume, rel=0.005)


@pytest.mark.parametrize("name", STACKS)
def test_its_outer_faces_close(name):
    assembly, _ = assembled(STACKS[name], {"/": "brick"})
    _, quads = outer_faces(assembly.mesh.blocks)
    edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all()


def test_the_mid_side_nodes_of_a_stack_stand_on_its_cylinders():
    assembly, evaluated = assembled(STACKS["five diameters"], {"/": "brick"}, order=2)
    radii = np.hypot(assembly.mesh.nodes[:, 0], assembly.mesh.nodes[:, 1])
    for radius in (10, 20, 30, 26, 13):
        assert (np.abs(radii - radius) < 1e-9 * evaluated.size).sum() > 100
    assert mesh_quality(assembly.mesh)["hex20"]["scaled_jacobian"]["min"] > 0.3


def test_the_tree_does_not_matter():
    block = difference(cube(60, 60, 40), rod(40, 12, (30, 30, 15)))
    split = union(cube(60, 60, 15), difference(cube(60, 60, 25, (0, 0, 15)), rod(40, 12, (30, 30, 10))))
    counts = [assembled(text, {"/": "brick"}, size=4)[0].mesh.count() for text in (block, split)]
    assert counts[0] == counts[1]


def test_a_section_that_changes_between_its_levels_is_no_stack():
    wedge = extrusion([(0, 0), (40, 0), (40, 20), (0, 40)], 30, turn=turned("x", 90))
    drilled = difference(wedge, rod(100, 5, (20, -15, -1)))
    expected = r"hexahedra only: not a stack of prisms: along y the cylinder across it near \(15.0036, -15"
    with pytest.raises(MeshError, match=expected):
        assembled(drilled, {"/": "brick"}, volumes="hex")


def test_shapes_of_hex_meshes_do_not_depend_on_the_frame():
    counts = [
        assembled(STACKS[name], {"/": "brick"}, size=4)[0].mesh.count()
        for name in ("a plate with a round boss", "a boss, turned")
    ]
    assert counts[0] == counts[1]


def test_what_was_done_with_each_brick_is_said_in_the_users_frame():
    turned_boss, _ = assembled(STACKS["a boss, turned"], {"/": "brick"}, size=8)
    assert turned_boss.bricks["s1"].startswith("hexahedra swept along (0.5736, -0.2802, 0.7698), ")
    assert turned_boss.bricks["s1"].endswith("layers, a stack of 2 prisms")
    cube_alone, _ = assembled(cube(10, 10, 10), size=5)
    assert cube_alone.bricks["s1"].startswith("hexahedra swept along ")
    tets, _ = assembled(cube(10, 10, 10), size=5, volumes="tet")
    assert tets.bricks["s1"].startswith("tetrahedra: asked for")


NEARLY = union(rod(50, 20), rod(40, 20, (0.2, 0, 45)))
"""Two cylinders of one radius, 0.2 apart: their outlines part the section into crescents."""


def test_outlines_that_nearly_touch_are_not_swept_and_the_place_is_said():
    with pytest.raises(MeshError, match=r"hexahedra only: its section .* near \(-?\d"):
        assembled(NEARLY, {"/": "brick"}, volumes="hex")


def test_where_hexahedra_are_not_insisted_on_tetrahedra_take_their_place_with_a_warning():
    assembly, _ = assembled(NEARLY, {"/": "brick"}, size=10)
    assert set(assembly.mesh.count()) == {"tet10"}
    assert any("is not swept but meshed with tetrahedra: its section" in warning for warning in assembly.warnings)
    assert audit(assembly) == WHOLE
