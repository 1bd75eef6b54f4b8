"""Over families of assemblies: the ledger explains, in closed form, all that the idealised model counts twice."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from assembling import WHOLE, assembled, audit, cube, difference, extrusion, mesh_volume, placed, rod, turned, union
from hypothesis import Phase, given, settings
from hypothesis import strategies as st
from shapely import Polygon
from test_assemble_joints import JOINTS

from kernel.idealise.ledger_row import JOINT

ROUNDING = 1e-7
"""Share of the volume that vertices off by their tolerance make: not explained, and not to be."""

TEES = pytest.mark.parametrize("tee", ["extend", "arms"])
FAMILY = settings(max_examples=4, phases=(Phase.explicit, Phase.generate))

thickness = st.floats(4, 10).map(lambda t: round(t, 2))
share = st.floats(0.2, 0.8)


def explained(text: str, tee: str, overrides=None):
    """The assembly, once its ledger has been found to hold nothing that is not explained, and to add up."""
    assembly, evaluated = assembled(text, overrides, tee=tee)
    solid = evaluated.solid.true_volume
    assert audit(assembly) == WHOLE
    odd = sum(abs(row.volume) for row in assembly.ledger if row.kind == "unexplained")
    assert odd <= ROUNDING * solid, [(row.segments, row.volume) for row in assembly.ledger]
    assert mesh_volume(assembly) - sum(row.volume for row in assembly.ledger) == pytest.approx(solid, rel=1e-9)
    if tee == "arms":
        assert not [row for row in assembly.ledger if row.cause == "tee"]
    return assembly


@TEES
@FAMILY
@given(
    angle=st.sampled_from([45, 50, 65, 70, 75, 80, 90, 100, 110, 120, 130]),
    flange=st.integers(6, 10),
    web=st.integers(4, 6),
)
def test_inclined_webs(tee, angle, flange, web):
    below = cube(900, 900, 100, (-50, -300, -100 + flange / 2))
    leaning = difference(cube(300, web, 250, (0, 150, -30), turned("x", angle - 90)), below)
    assembly = explained(union(cube(300, 400, flange), leaning), tee)
    rows = [row.volume for row in assembly.ledger if row.kind == JOINT]
    expected = [] if tee == "arms" else [flange * web * 300 / (2 * math.sin(math.radians(angle)))]
    assert rows == pytest.approx(expected, rel=1e-6)


@TEES
@FAMILY
@given(angles=st.sampled_from([(110, 110), (135, 100), (95, 115), (105, 140)]), t=st.integers(5, 9))
def test_stars_of_three(tee, angles, t):
    angles = (0, angles[0], sum(angles))
    walls = [cube(150, t, 120, tuple(turned("z", a) @ (0, -t / 2, 0)), turned("z", a)) for a in angles]
    explained(union(*walls), tee, {"/": "plates"})


@TEES
@FAMILY
@given(outer=thickness, one=thickness, other=thickness, x=share, y=share, is_crossed=st.booleans())
def test_boxes_with_partitions(tee, outer, one, other, x, y, is_crossed):
    shell = difference(cube(300, 260, 200), cube(300 - 2 * outer, 260 - 2 * outer, 200 - 2 * outer, (outer,) * 3))
    walls = [cube(one, 260 - outer, 200 - outer, (round(300 * x), outer / 2, outer / 2))]
    if is_crossed:
        walls.append(cube(300 - outer, other, 200 - outer, (outer / 2, round(260 * y), outer / 2)))
    explained(union(shell, *walls), tee)


@TEES
@FAMILY
@given(t=st.tuples(thickness, thickness, thickness), count=st.tuples(st.integers(1, 3), st.integers(1, 3)))
def test_egg_crates_on_a_floor(tee, t, count):
    across = [cube(t[0], 300, 60, (300 * (k + 1) / (count[0] + 1), 0, 0)) for k in range(count[0])]
    along = [cube(300, t[1], 60, (0, 300 * (k + 1) / (count[1] + 1), 0)) for k in range(count[1])]
    explained(union(cube(300, 300, t[2]), *across, *along), tee)


@TEES
@FAMILY
@given(
    corners=st.tuples(*[st.integers(-40, 40) for _ in range(8)]),
    t=st.integers(4, 8),
    has_partition=st.booleans(),
    turn=st.sampled_from([0, 33]),
)
def test_hulls_with_skew_corners(tee, corners, t, has_partition, turn):
    square = np.array([(0, 0), (300, 0), (300, 260), (0, 260)]) + np.reshape(corners, (4, 2)).round(1)
    hull = Polygon(square)
    inside = hull.buffer(-t, join_style="mitre", mitre_limit=20)
    shell = difference(
        extrusion(list(hull.exterior.coords)[:-1], 150), extrusion(list(inside.exterior.coords)[:-1], 150, (0, 0, t))
    )
    parts = [shell]
    if has_partition:
        middle = hull.buffer(-t / 2, join_style="mitre").intersection(
            Polygon([(140, -99), (146, -99), (146, 399), (140, 399)])
        )
        parts.append(extrusion(list(middle.exterior.coords)[:-1], 120, (0, 0, t / 2)))
    explained(placed(union(*parts), (10, 20, 30), turned("x", turn)), tee)


@TEES
@FAMILY
@given(
    radius=st.integers(40, 70), wall=st.integers(4, 6), plate=thickness, kind=st.sampled_from(["on", "through", "fin"])
)
def test_plates_and_tubes(tee, radius, wall, plate, kind):
    pipe = difference(rod(240, radius, (200, 150, plate)), rod(300, radius - wall, (200, 150, -1 + plate)))
    if kind == "on":
        text = union(cube(400, 300, plate), pipe)
    elif kind == "through":
        ring = difference(cube(400, 300, plate, (0, 0, 100)), rod(300, radius - wall / 2, (200, 150, 0)))
        text = union(ring, pipe)
    else:
        text = union(pipe, cube(100, plate, 150, (200 + radius - 2, 150 - plate / 2, 50)))
    explained(text, tee)


def breadth(assembly, name: str, low: float, high: float) -> float:
    """Breadth along y of a segment between two values of x; 0 where it has no nodes there."""
    used = np.unique(np.concatenate([block.connectivity.ravel() for block in _blocks_of(assembly, name)]))
    x, y = assembly.mesh.nodes[used, :2].T
    there = y[(x > low) & (x < high)]
    return float(np.ptp(there)) if len(there) else 0.0


@TEES
@FAMILY
@given(
    at=st.sampled_from([0, 300, 700]),
    long=st.integers(60, 150),
    t=st.sampled_from([6, 9, 14]),
    turn=st.sampled_from([0, 33]),
)
def test_a_short_wall_flush_with_an_edge_leaves_the_rest_of_it_alone(tee, at, long, t, turn):
    """The flange is cut back only where the wall stands; no more, no less than the corner is counted."""
    text = union(cube(900, 200, 12, (0, 0, 300)), cube(long, t, 300, (at, 0, 0)))
    straight = explained(text, tee)
    (flange,) = (segment.id for segment in straight.segments if segment.thickness == pytest.approx(12))
    assert breadth(straight, flange, at - 100, at - 1) in (0.0, pytest.approx(200))
    assert breadth(straight, flange, at + long + 1, 900) in (0.0, pytest.approx(200))
    assert breadth(straight, flange, at + 1, at + long - 1) == pytest.approx(200 - t / 2)
    moved = explained(placed(text, (10, 20, 30), turned("x", turn)), tee)
    for assembly in (straight, moved):
        assert mesh_volume(assembly) == pytest.approx(900 * 200 * 12 + long * t * 300, rel=ROUNDING)


@TEES
@FAMILY
@given(bare=st.integers(20, 30), t=st.sampled_from([6, 8, 10, 14]))
def test_an_edge_with_little_bare_is_cut_back_all_along_and_the_ledger_says_so(tee, bare, t):
    assembly = explained(union(cube(600, 200, 12, (0, 0, 200)), cube(600 - bare, t, 200)), tee)
    (flange,) = (segment.id for segment in assembly.segments if segment.thickness == pytest.approx(12))
    assert breadth(assembly, flange, 599, 601) == pytest.approx(200 - t / 2)
    (row,) = (row for row in assembly.ledger if row.kind == JOINT)
    assert row.segments == (flange,)
    assert -12 * bare * t / 2 <= row.volume < 0


@TEES
@FAMILY
@given(t=st.integers(6, 10), wide=st.integers(150, 250))
def test_a_box_column_flush_with_the_sides_of_a_longer_flange(tee, t, wide):
    column = difference(cube(wide, 200, 300), cube(wide - 2 * t, 200 - 2 * t, 400, (t, t, -50)))
    explained(union(cube(900, 200, 12, (0, 0, 300)), column), tee)


@TEES
@pytest.mark.parametrize("name", ["tee at 60 degrees", "egg-crate", "vee at 45 degrees", "hull with skew corners"])
def test_what_is_left_when_a_segment_goes_is_explained_too(tee, name):
    assembly, _ = assembled(JOINTS[name], tee=tee)
    for kept in assembly.segments:
        corners = replace(assembly, mesh=replace(assembly.mesh, blocks=_blocks_of(assembly, kept.id)))
        counted = sum(row.shares.get(kept.id, 0.0) for row in assembly.ledger)
        assert mesh_volume(corners) - counted == pytest.approx(kept.volume, rel=1e-9)


def _blocks_of(assembly, name):
    return tuple(block for block in assembly.mesh.blocks if block.segment == name)
