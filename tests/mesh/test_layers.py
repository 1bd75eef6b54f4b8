"""Layers: at least so many elements through bricks, along their sweep and across the walls of their section."""

import numpy as np
import pytest
import shapely
from assembling import WHOLE, assembled, audit, cube, placed, turned

from kernel.errors import OptionError

BOX = "A = BLO(60, 40, 50)\nB = BLO(50, 30, 60) AT (MOVX=5, MOVY=5, MOVZ=-5)\nC = A DIF B\n"
TUBE = "A = CYL(R=40, H=30)\nB = CYL(R=32, H=40) AT (MOVZ=-5)\nC = A DIF B\n"
SLAB = "A = BLO(100, 80, 12)\nH = CYL(R=15, H=20) AT (MOVX=40, MOVY=40, MOVZ=-4)\nC = A DIF H\n"


def across(assembly, evaluated, start, end) -> int:
    """Hexes that the line from start to end, amid a layer, passes through."""
    (hexes,) = [block.connectivity for block in assembly.mesh.blocks if block.kind == "hex8"]
    nodes = assembly.mesh.nodes @ evaluated.frame.T
    start, end = np.array(start, float), np.array(end, float)
    normal = np.array([0.0, 0.0, 1.0])
    low, high = (nodes[hexes] @ normal).min(axis=1), (nodes[hexes] @ normal).max(axis=1)
    level = start @ normal
    held = hexes[(low < level) & (level < high)]
    line = shapely.LineString([start[:2], end[:2]])
    hulls = [shapely.MultiPoint(nodes[one][:, :2]).convex_hull for one in held]
    return sum(hull.intersection(line).length > 1e-6 for hull in hulls)


@pytest.mark.parametrize("layers", [1, 2, 3, 5])
def test_a_swept_box_has_the_layers_across_its_walls_and_along_its_sweep(layers):
    assembly, evaluated = assembled(BOX, {"/": "brick"}, size=20.0, layers=layers)
    assert audit(assembly) == WHOLE
    assert assembly.mesh.count().keys() == {"hex8"}
    for y in (11.3, 20.7, 28.9):
        assert layers <= across(assembly, evaluated, (-1, y, 1e-3), (6, y, 1e-3)) <= 2 * layers + 2
    assert len(np.unique((assembly.mesh.nodes @ evaluated.frame.T)[:, 2].round(6))) - 1 >= layers


@pytest.mark.parametrize("layers", [1, 2, 4])
def test_a_swept_tube_has_the_layers_across_its_wall(layers):
    assembly, evaluated = assembled(TUBE, {"/": "brick"}, size=20.0, layers=layers)
    for angle in (0.1, 1.3, 3.0):
        out = np.array([np.cos(angle), np.sin(angle), 0.0])
        assert layers <= across(assembly, evaluated, 31 * out + (0, 0, 1e-3), 41 * out + (0, 0, 1e-3)) <= 2 * layers + 2


def test_layers_count_through_a_thin_piece_of_a_stack():
    shaft = "A = CYL(R=40, H=6)\nB = CYL(R=15, H=60) AT (MOVZ=6)\nC = A UN B\n"
    assembly, evaluated = assembled(shaft, {"/": "brick"}, size=12.0, layers=3)
    levels = np.unique((assembly.mesh.nodes @ evaluated.frame.T)[:, 2].round(6))
    assert (levels <= 6).sum() == 4
    assert (levels >= 6).sum() == 6


@pytest.mark.slow
def test_tetrahedra_are_held_down_to_the_layers_and_the_user_is_told():
    assembly, _ = assembled(SLAB, {"/": "brick"}, size=15.0, volumes="tet", layers=2)
    (warning,) = [line for line in assembly.warnings if "held down" in line]
    assert warning.startswith("s1 (/): size 15 is held down to 6: 2 layers of tetrahedra across its thinnest wall of")
    coarse, _ = assembled(SLAB, {"/": "brick"}, size=15.0, volumes="tet")
    assert assembly.mesh.count()["tet10"] > 3 * coarse.mesh.count()["tet10"]


def test_layers_that_no_computer_holds_are_refused_with_how_many_it_does():
    with pytest.raises(OptionError, match=r"layers: 500 in s1 \(/\) across its thinnest wall of 12 at .*: \d\d layers"):
        assembled(SLAB, {"/": "brick"}, size=15.0, volumes="tet", layers=500)
    with pytest.raises(OptionError, match="layers is 0, expected a whole number from 1"):
        assembled(SLAB, layers=0)


def test_a_boss_has_its_layers_in_the_elements_of_the_plate_that_it_continues():
    boss = (
        "A = BLO(90, 80, 8)\nB = CYL(R=22, H=30) AT (MOVX=45, MOVY=40, MOVZ=8)\n"
        "H = CYL(R=12, H=60) AT (MOVX=45, MOVY=40, MOVZ=-5)\nC = (A UN B) DIF H\n"
    )
    for layers in (1, 3):
        assembly, evaluated = assembled(boss, size=15.0, layers=layers)
        assert audit(assembly) == WHOLE
        assert {"quad4", "hex8"} == assembly.mesh.count().keys()
        for angle in (0.2, 2.0, 4.4):
            out = np.array([np.cos(angle), np.sin(angle), 0.0])
            ends = [np.array([45, 40, 20.001]) + radius * out for radius in (11, 23)]
            assert across(assembly, evaluated, *ends) >= layers


def test_layers_without_a_brick_are_told_of():
    assembly, _ = assembled("A = BLO(90, 80, 2)\n", size=15.0, layers=3)
    assert assembly.warnings == ("layers: no segment is a brick, so there is nothing to have layers",)


@pytest.mark.parametrize("layers", [1, 2, 4])
def test_a_turned_solid_has_the_layers_in_its_profile(layers):
    vase = "A = CON(R1=30, R2=50, H=60)\nB = CON(R1=24, R2=44, H=60)\nC = A DIF B\n"
    assembly, evaluated = assembled(vase, {"/": "brick"}, size=20.0, layers=layers)
    assert "turned" in assembly.bricks["s1"]
    nodes = assembly.mesh.nodes @ evaluated.frame.T
    at_foot = nodes[np.abs(nodes[:, 2]) < 1e-6]
    assert len(np.unique(np.hypot(*at_foot[:, :2].T).round(6))) - 1 >= layers


def test_seeds_along_a_sweep_that_leave_fewer_layers_are_told_with_the_segment():
    block = placed(cube(60, 40, 20), (5, 6, 7), turned("y", 30))
    point = ",".join(f"{value:.9f}" for value in (np.array([5, 6, 7]) + turned("y", 30) @ [30, 0, 0]))
    seeded, _ = assembled(block, {"/": "brick"}, size=20.0, layers=4, seeds={point: 2})
    (told,) = [text for text in seeded.warnings if "layers" in text]
    assert told.startswith("s1 (/): 2 elements of the 4 asked for by the layers stand along (0.866, 0, -0.5)")
    enough, _ = assembled(block, {"/": "brick"}, size=20.0, layers=4, seeds={point: 4})
    assert not [text for text in enough.warnings if "layers" in text]


def test_curves_of_a_host_seeded_coarser_than_the_layers_need_are_told_with_the_wall():
    boss = (
        "A = BLO(90, 80, 8)\nB = CYL(R=22, H=30) AT (MOVX=45, MOVY=40, MOVZ=8)\n"
        "H = CYL(R=12, H=60) AT (MOVX=45, MOVY=40, MOVZ=-5)\nC = (A UN B) DIF H\n"
    )
    for size, is_told in ((12.0, True), (0.8, False)):
        assembly, _ = assembled(boss, size=15.0, layers=3, curve_sizes={"H": size})
        told = [text for text in assembly.warnings if "may have fewer" in text]
        assert bool(told) == is_told
        assert all("elements of 12 are asked for along the curve through (" in text for text in told)
        assert all(text.startswith("s") for text in told)
