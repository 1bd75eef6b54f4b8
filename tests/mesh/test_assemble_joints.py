"""Joints of walls: whatever the angle, whoever owns the corner, one mesh on shared curves and a ledger that adds up."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest
from assembling import WHOLE, assembled, audit, cube, difference, extrusion, mesh_volume, placed, rod, turned, union
from shapely.geometry import LineString, Polygon

from kernel.errors import ConnectError


def vee(angle: float, t: float = 6.0) -> str:
    """Two walls that meet at `angle`, mitred, 200 high."""
    a = math.radians(angle)
    line = LineString([(100, 0), (0, 0), (100 * math.cos(a), 100 * math.sin(a))])
    outline = line.buffer(t / 2, cap_style="flat", join_style="mitre", mitre_limit=20)
    return extrusion(list(outline.exterior.coords)[:-1], 200)


def inclined_web(angle: float, t: float) -> str:
    """A flange with a web at `angle` to it."""
    below = cube(900, 900, 100, (-50, -300, -100 + 5))
    return union(cube(300, 400, 10), difference(cube(300, t, 250, (0, 100, -30), turned("x", angle - 90)), below))


def box(x, y, z, t) -> str:
    return difference(cube(x, y, z), cube(x - 2 * t, y - 2 * t, z - 2 * t, (t, t, t)))


def tube(height, outer, inner, at=(0.0, 0.0, 0.0), turn=None) -> str:
    return placed(difference(rod(height, outer), rod(height + 2, inner, (0, 0, -1))), at, turn)


def branch(radius: float, angle: float, t: float = 3.0) -> str:
    """A pipe of radius 60 and one of `radius` that leaves it at `angle` from its axis, open to one another."""
    lean = turned("y", angle)
    return difference(
        union(rod(500, 60), rod(250, radius, (0, 0, 220), lean)),
        rod(600, 56, (0, 0, -50)),
        rod(300, radius - t, (0, 0, 220), lean),
    )


TUBE_ON_PLATE = difference(union(cube(400, 300, 10), rod(200, 50, (140, 120, 0))), rod(300, 45, (140, 120, -1)))
HULL = Polygon([(0, 0), (300, 0), (220, 200), (40, 240)])
HULL_INSIDE = HULL.buffer(-6, join_style="mitre", mitre_limit=20)

JOINTS = {
    "tee": union(cube(200, 150, 4), cube(200, 12, 100, (0, 69, 4))),
    "tee at 60 degrees": inclined_web(60, 8),
    "tee at 25 degrees": inclined_web(25, 8),
    "vee at 45 degrees": vee(45),
    "vee at 90 degrees": vee(90),
    "vee at 135 degrees": vee(135),
    "cross": union(cube(200, 8, 200, (0, 96, 0)), cube(200, 200, 6, (0, 0, 97))),
    "three walls on one line": union(
        *(cube(100, 6, 200, tuple(turned("z", a) @ (0, -3, 0)), turned("z", a)) for a in (0, 120, 240))
    ),
    "corner with a lip": union(cube(200, 150, 8), cube(200, 8, 100, (0, 15, 8))),
    "web longer than its flange": union(cube(200, 120, 10), cube(300, 8, 100, (-50, 56, 10))),
    "webs face to face, 3 apart": union(
        cube(300, 150, 10), cube(300, 8, 100, (0, 70, 10)), cube(300, 8, 100, (0, 73, -100))
    ),
    "webs face to face, 0.3 apart": union(
        cube(300, 150, 10), cube(300, 8, 100, (0, 70, 10)), cube(300, 8, 100, (0, 70.3, -100))
    ),
    "hole near the joint": difference(
        union(cube(300, 150, 10), cube(300, 8, 100, (0, 71, 10))),
        rod(20, 15, (100, 94, -5)),
        rod(40, 12, (200, 60, 30), turned("x", -90)),
    ),
    "hole across the joint": difference(
        union(cube(300, 150, 10), cube(300, 8, 100, (0, 71, 10))), rod(30, 25, (150, 75, -10))
    ),
    "hole in the flange alone": union(
        difference(cube(300, 150, 10), rod(30, 25, (150, 75, -10))), cube(300, 8, 100, (0, 71, 10))
    ),
    "egg-crate": union(
        *(cube(306, 6, 60, (0, 100 * i, 0)) for i in range(4)),
        *(cube(6, 306, 60, (100 * i, 0, 0)) for i in range(4)),
        cube(306, 306, 6),
    ),
    "hull with skew corners": difference(
        extrusion(list(HULL.exterior.coords)[:-1], 150),
        extrusion(list(HULL_INSIDE.exterior.coords)[:-1], 150, (0, 0, 6)),
    ),
    "box, turned": placed(box(400, 300, 200, 6), (10, 20, 30), turned("x", 20) @ turned("y", 35)),
    "box with a partition and a hole through it all": difference(
        union(box(300, 200, 150, 6), cube(6, 188, 138, (120, 6, 6))), rod(400, 30, (-10, 100, 75), turned("y", 90))
    ),
    "gusset with a rat hole": union(
        cube(200, 150, 10),
        cube(200, 10, 150),
        extrusion([(15, 0), (90, 0), (0, 90), (0, 15)], 8, (96, 10, 10), turned("z", 90) @ turned("x", 90)),
    ),
    "tube on a plate": TUBE_ON_PLATE,
    "tube near the plate's edge": difference(
        union(cube(400, 300, 10), rod(200, 50, (52, 120, 0))), rod(300, 45, (52, 120, -1))
    ),
    "pipe with a flange at its end": difference(
        union(rod(10, 150), rod(200, 90)),
        rod(300, 85, (0, 0, -50)),
        *(rod(20, 8, (*(120 * turned("z", a)[:2, 0]), -5)) for a in (0, 90, 180, 270)),
    ),
    "tube through a plate": union(
        difference(cube(400, 300, 10), rod(100, 48, (200, 150, -50))), tube(300, 50, 46, (200, 150, -140))
    ),
    "tube through a plate that closes it": union(cube(400, 300, 10), tube(300, 50, 46, (200, 150, -140))),
    "branch pipe": branch(30, 90),
    "branch pipe, leaning": branch(30, 60),
    "half pipe standing on a plate": union(
        difference(tube(300, 60, 56), cube(200, 100, 400, (-100, -100, -50))), cube(300, 300, 8, (-150, -100, -8))
    ),
    "fin along a pipe": union(tube(300, 60, 56), cube(100, 6, 150, (58, -3, 70))),
    "wheel with four spokes in tubes": union(
        tube(60, 150, 144),
        tube(60, 30, 26),
        *(cube(120, 6, 60, turned("z", a) @ (28, -3, 0), turned("z", a)) for a in (0, 90, 180, 270)),
    ),
    "tank with a nozzle": difference(
        union(difference(rod(300, 100), rod(288, 94, (0, 0, 6))), rod(120, 25, (60, 0, 150), turned("y", 90))),
        rod(200, 22, (60, 0, 150), turned("y", 90)),
    ),
    "trough with tangent sides": union(
        difference(tube(300, 60, 56), cube(200, 100, 400, (-100, 0, -50))),
        *(cube(4, 80, 300, (x, 0, 0)) for x in (56, -60)),
    ),
    "gusset askew, cut square": union(
        cube(200, 200, 8), cube(8, 200, 150, (0, 0, 8)), cube(6, 100, 100, (8, 60, 8), turned("z", -30))
    ),
    "lip narrower than the wall": union(cube(200, 100, 6), cube(200, 6, 30, (0, 2, 6))),
    "web on a coplanar step": union(cube(200, 100, 8), cube(200, 100, 12, (200, 0, 0)), cube(8, 100, 80, (196, 0, 12))),
    "box on a box": union(
        difference(cube(200, 200, 100), cube(188, 188, 88, (6, 6, 6))),
        difference(cube(100, 100, 80, (50, 50, 100)), cube(88, 88, 80, (56, 56, 94))),
    ),
    "beam over a plate's edge": union(cube(300, 200, 10), cube(40, 40, 600, (280, 80, 10))),
    "beam against a plate's edge": union(cube(300, 200, 10), cube(600, 40, 40, (300, 80, -15))),
    "beam along a plate's edge": union(cube(600, 200, 10), cube(600, 20, 30, (0, 200, -10))),
    "leaning column": union(
        cube(400, 400, 20, (-200, -200, -20)),
        difference(
            placed(cube(40, 40, 700, (-20, -20, -60)), turn=turned("y", 20)), cube(900, 900, 400, (-450, -450, -400))
        ),
    ),
    "round bar on a pipe": union(
        tube(600, 60, 56), difference(rod(900, 15, (0, 0, 300), turned("y", 90)), rod(800, 58, (0, 0, -50)))
    ),
    "lap with a tee under it": union(
        cube(200, 100, 8), cube(200, 100, 6, (150, 0, 8)), cube(200, 8, 80, (0, 46, -80))
    ),
    "step": union(cube(200, 100, 8), cube(200, 100, 12, (200, 0, 0))),
    "step, mid-planes level": union(cube(200, 100, 8, (0, 0, 2)), cube(200, 100, 12, (200, 0, 0))),
    "stiffener": union(cube(1000, 300, 8), cube(1000, 20, 20, (0, 140, 8))),
    "column amid a plate": union(cube(600, 600, 20), cube(60, 60, 900, (270, 270, 20))),
    "bars across": union(cube(1000, 40, 40), cube(40, 1000, 40, (480, -480, 40))),
    "bars in a tee": union(cube(1000, 40, 40), cube(40, 700, 40, (480, 40, 0))),
}  # fmt: skip


@pytest.mark.parametrize("name", JOINTS)
def test_every_joint_is_one_model_without_cracks_and_its_ledger_adds_up(name):
    assembly, evaluated = assembled(JOINTS[name])
    assert audit(assembly) == WHOLE
    solid = evaluated.solid.true_volume
    ledger = sum(row.volume for row in assembly.ledger)
    assert mesh_volume(assembly) - ledger == pytest.approx(solid, rel=1e-9)


@pytest.mark.parametrize("angle", [90, 60, 25])
def test_a_tee_counts_half_the_webs_slab_twice(angle):
    t, web, length = 10, 8, 300
    assembly, _ = assembled(inclined_web(angle, web))
    counted = sum(row.volume for row in assembly.ledger)
    assert counted == pytest.approx(t * web * length / (2 * math.sin(math.radians(angle))), rel=1e-6)


def test_a_corner_of_three_walls_lacks_a_quarter_of_its_cube():
    assembly, _ = assembled(box(400, 300, 200, 6))
    corners = [row for row in assembly.ledger if len(row.segments) == 3]
    assert [row.volume for row in corners] == pytest.approx([-(6**3) / 4] * 8)
    assert sum(abs(row.volume) for row in assembly.ledger if len(row.segments) < 3) < 1e-6


def test_the_joint_curve_of_a_tube_is_a_circle_of_its_mid_radius_in_both():
    assembly, evaluated = assembled(TUBE_ON_PLATE)
    shared = set(assembly.mesh.blocks[0].connectivity.ravel()) & set(assembly.mesh.blocks[1].connectivity.ravel())
    nodes = assembly.mesh.nodes[sorted(shared)]
    assert len(nodes) >= 16
    assert np.abs(np.hypot(*(nodes[:, :2] - (140, 120)).T) - 47.5).max() < 1e-9 * evaluated.size
    assert np.abs(nodes[:, 2] - 5).max() < 1e-9 * evaluated.size


def test_three_walls_share_the_one_line_on_which_they_meet():
    assembly, _ = assembled(JOINTS["three walls on one line"])
    often = assembly.curve_uses[:, 2]
    assert often.max() == 3
    ends = assembly.mesh.nodes[assembly.curve_uses[often == 3][:, :2].ravel()]
    assert np.abs(ends[:, :2]).max() < 1e-6


def test_material_of_a_corner_has_no_elements_but_a_row_in_the_ledger():
    heel = cube(6, 6, 200)
    sides = (difference(cube(100, 6, 200), heel), difference(cube(6, 100, 200), heel))
    assembly, _ = assembled(union(*sides, heel), {"0": "plate", "1": "plate", "2": "beam"})
    assert len(assembly.segments) == 2
    assert any("corner" in row.cause for row in assembly.ledger)
    assert any("no elements" in warning for warning in assembly.warnings)


def test_an_oblique_tube_meets_its_plate_in_an_ellipse():
    lean = turned("y", 30)
    pipe = difference(tube(300, 50, 45, (200, 200, -40), lean), cube(900, 900, 200, (-200, -200, -200)))
    assembly, evaluated = assembled(union(cube(500, 400, 10), pipe), {"0": "plate", "1": "cylinder_plate"})
    assert audit(assembly) == WHOLE
    plate, wall = (set(block.connectivity.ravel()) for block in assembly.mesh.blocks)
    nodes = assembly.mesh.nodes[sorted(plate & wall)] @ evaluated.frame.T
    axis = lean @ (0, 0, 1)
    arms = nodes - (200, 200, -40)
    radius = np.linalg.norm(arms - np.outer(arms @ axis, axis), axis=1)
    assert len(nodes) >= 16
    assert np.abs(radius - 47.5).max() < 1e-9 * evaluated.size
    assert np.abs(nodes[:, 2] - 5).max() < 1e-9 * evaluated.size


@pytest.mark.parametrize(("radius", "thickness"), [(60, 4.0), (59.94, 4.0), (60, 3.0)])
def test_pipes_of_one_radius_share_a_curve_with_two_corners(radius, thickness):
    assembly, evaluated = assembled(branch(radius, 90, t=thickness))
    assert audit(assembly) == WHOLE
    run, leaving = (set(block.connectivity.ravel()) for block in assembly.mesh.blocks)
    nodes = assembly.mesh.nodes[sorted(run & leaving)] @ evaluated.frame.T
    assert np.abs(np.hypot(nodes[:, 0], nodes[:, 1]) - 58).max() < 1e-9 * evaluated.size
    assert nodes[:, 0].min() == pytest.approx(np.sqrt(max(0.0, 58**2 - (radius - thickness / 2) ** 2)), abs=1e-6)
    assert any("as if both had the radius 58" in warning for warning in assembly.warnings) == (thickness == 3)


@pytest.mark.parametrize("angle", [90, 60, 45])
def test_a_tee_of_one_radius_counts_two_thirds_of_its_wall_cubed_twice(angle):
    assembly, evaluated = assembled(branch(60, angle, t=4.0))
    twice = sum(row.volume for row in assembly.ledger if row.kind == "joint")
    assert twice == pytest.approx(2 / 3 * 4**3 / np.sin(np.radians(angle)), rel=1e-9)
    rest = sum(row.volume for row in assembly.ledger if row.kind == "unexplained")
    assert abs(rest) < 2e-7 * evaluated.solid.true_volume


def test_pipes_that_miss_one_another_are_refused_by_name_and_place():
    with pytest.raises(ConnectError, match=r"mid-surfaces of s1 .* and s2 .* come within 1.7 of one another near"):
        assembled(branch(61.2, 90))


def test_the_place_of_a_refusal_is_in_the_models_own_coordinates():
    pattern = r"of one another near \(([^,]*), ([^,]*), ([^)]*)\)"
    places = []
    turn, shift = turned("z", 31) @ turned("x", 40), np.array([30.0, -20, 10])
    for text in (branch(61.2, 90), placed(branch(61.2, 90), tuple(shift), turn)):
        with pytest.raises(ConnectError, match=pattern) as refused:
            assembled(text)
        places.append(np.array(re.search(pattern, str(refused.value)).groups(), float))
    back = (places[1] - shift) @ turn  # the pipes are alike on their four sides
    assert np.abs(back) == pytest.approx(np.abs(places[0]), abs=1e-2)


@pytest.mark.parametrize("angle", [17.0, 71.3])
def test_turning_the_model_changes_nothing_but_its_place(angle):
    text = JOINTS["box with a partition and a hole through it all"]
    straight, _ = assembled(text)
    turned_round, evaluated = assembled(placed(text, (30, -20, 10), turned("z", angle) @ turned("x", 33)))
    assert audit(turned_round) == WHOLE
    rows = [sorted(row.volume for row in assembly.ledger) for assembly in (straight, turned_round)]
    assert rows[0] == pytest.approx(rows[1], abs=1e-6 * evaluated.solid.true_volume)
