"""Facts against what a drawing says: how tools stand to their head, round holes, contacts."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st
from segmenting import plain_decide

from kernel import describe
from kernel.csg.reader import read_model
from kernel.plan import Conclusion, Need
from kernel.segment.operands import operand_at
from kernel.segment.partition import partition
from kernel.segment.pieces import Piece
from kernel.segment.prism import measure, sweep_along
from kernel.segment.slices import smallest_rectangle
from kernel.solid.evaluate import evaluate


def piece_of(body: str) -> Piece:
    evaluated = evaluate(read_model(body, "model.csg"))
    root = evaluated.model.root
    return Piece(evaluated.solid, "/", "/", "root", operand=operand_at("/", root))


def tool_of(head: str, tool: str) -> dict:
    (facts,) = describe.intent(piece_of(f"difference() {{ {head} {tool} }}")).related["tools"]
    names = ("is_through", "is_coaxial", "is_concentric", "diameter")
    return {name: facts[name] for name in names if name in facts}


def holes_of(body: str) -> dict:
    facts = describe.extents(piece_of(body))
    names = ("round_hole_count", "through_hole_count", "smallest_hole", "largest_hole")
    return {name: facts[name] for name in names if name in facts}


def at(x: float, y: float, z: float, body: str) -> str:
    return f"multmatrix([[1, 0, 0, {x}], [0, 1, 0, {y}], [0, 0, 1, {z}], [0, 0, 0, 1]]) {{ {body} }}"


def lying(x: float, y: float, z: float, body: str) -> str:
    """The body's z axis turned into x."""
    return f"multmatrix([[0, 0, 1, {x}], [0, 1, 0, {y}], [-1, 0, 0, {z}], [0, 0, 0, 1]]) {{ {body} }}"


def rod(radius: float, height: float) -> str:
    return f"cylinder($fn = 0, h = {height}, r1 = {radius}, r2 = {radius}, center = false);"


def box(x: float, y: float, z: float) -> str:
    return f"cube(size = [{x}, {y}, {z}], center = false);"


PLATE = box(200, 100, 8)


@pytest.mark.parametrize(
    ("head", "tool", "expected"),
    [
        (PLATE, at(50, 50, -1, rod(6, 10)), (True, False, False, 12)),
        (PLATE, at(100, 50, -1, rod(6, 10)), (True, False, True, 12)),
        (PLATE, at(50, 50, 0, rod(6, 8)), (True, False, False, 12)),  # flush at both ends
        (PLATE, at(50, 50, 2, rod(6, 10)), (False, False, False, 12)),  # blind
        (PLATE, at(50, 500, -1, rod(6, 10)), (False, False, False, 12)),  # beside it
        (PLATE, lying(-1, 50, 4, rod(2, 202)), (True, False, True, 4)),  # along the plate
        (rod(60, 300), at(0, 0, -1, rod(56, 302)), (True, True, True, 112)),
        (rod(60, 300), at(0, 0, 10, rod(56, 302)), (False, True, True, 112)),  # a cup
        (rod(60, 300), at(1, 0, -1, rod(56, 302)), (True, False, False, 112)),
        (rod(60, 300), lying(-70, 0, -150, rod(20, 140)), (False, False, False, 40)),  # below the pipe
        (rod(60, 300), lying(-70, 0, 150, rod(20, 140)), (True, False, True, 40)),  # across the pipe
        (rod(60, 300), lying(0, 0, 150, rod(20, 140)), (False, False, True, 40)),  # through one side only
        ("sphere($fn = 0, r = 50);", at(0, 0, -60, rod(5, 120)), (True, True, True, 10)),
        ("sphere($fn = 0, r = 50);", "sphere($fn = 0, r = 40);", (None, True, True, 80)),
        (box(40, 40, 40), at(5, 5, 5, box(30, 30, 30)), (False, False, True, None)),  # closed, hollow
        (box(40, 40, 40), at(5, 5, -5, box(30, 30, 60)), (True, False, True, None)),  # a box tube
        (box(40, 40, 40), at(6, 5, -5, box(30, 30, 60)), (True, False, False, None)),
        (box(40, 40, 40), at(10, 10, 20, "sphere($fn = 0, r = 5);"), (None, False, False, 10)),
    ],
)
def test_a_tool_is_described_by_how_it_stands_to_what_it_is_taken_from(head, tool, expected):
    names = ("is_through", "is_coaxial", "is_concentric", "diameter")
    assert tool_of(head, tool) == {name: value for name, value in zip(names, expected) if value is not None}


def test_the_head_below_a_difference_is_meant_and_what_no_primitive_says_is_left_out():
    drilled = f"difference() {{ {rod(60, 300)} {at(0, 0, 100, box(9, 9, 9))} }}"
    first, second = describe.intent(piece_of(f"difference() {{ {drilled} {at(0, 0, -1, rod(5, 302))} }}")).related[
        "tools"
    ]
    assert first["is_coaxial"] is True and first["is_through"] is True
    assert second["is_coaxial"] is False and second["is_through"] is False
    joined = f"union() {{ {rod(5, 20)} {at(2, 0, 0, rod(5, 20))} }}"
    assert tool_of(PLATE, joined) == {}


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        (PLATE, (0, 0)),
        (rod(10, 40), (0, 0)),
        (f"difference() {{ {PLATE} {at(50, 50, -1, rod(6, 10))} {at(90, 50, -1, rod(4, 10))} }}", (2, 2, 8, 12)),
        (f"difference() {{ {PLATE} {at(50, 50, 2, rod(6, 10))} }}", (1, 0, 12, 12)),
        (f"difference() {{ {PLATE} {at(50, 0, -1, rod(6, 10))} }}", (0, 0)),  # half a hole at the edge
        (f"difference() {{ {rod(60, 300)} {at(0, 0, -1, rod(56, 302))} }}", (1, 1, 112, 112)),
        (f"difference() {{ {box(40, 40, 40)} {at(20, 20, 5, rod(10, 30))} }}", (0, 0)),  # a closed void
        (  # a counterbore: the narrow part is through, the wide one ends on a step
            f"difference() {{ {box(40, 40, 40)} {at(20, 20, -1, rod(5, 60))} {at(20, 20, 30, rod(9, 20))} }}",
            (2, 1, 10, 18),
        ),
        (  # one drill through both walls of a box tube
            f"difference() {{ {box(40, 40, 90)} {at(3, 3, -1, box(34, 34, 92))} {lying(-1, 20, 45, rod(5, 42))} }}",
            (2, 2, 10, 10),
        ),
    ],
)  # fmt: skip
def test_round_holes_are_counted_with_their_diameters_and_whether_they_are_through(body, expected):
    names = ("round_hole_count", "through_hole_count", "smallest_hole", "largest_hole")
    assert holes_of(body) == dict(zip(names, expected))


def test_round_holes_are_the_same_however_the_solid_was_written():
    one = f"difference() {{ {PLATE} {at(50, 50, -1, rod(6, 10))} }}"
    halves = f"union() {{ {box(100, 100, 8)} {at(100, 0, 0, box(100, 100, 8))} }}"
    other = f"intersection() {{ {box(300, 300, 8)} difference() {{ {halves} {at(50, 50, -9, rod(6, 50))} }} }}"
    assert holes_of(one) == holes_of(other) == holes_of(lying(7, 8, 9, one))


def test_contacts_of_a_member_are_counted_where_neighbours_reach_it():
    """A beam on three posts, and a fourth that ends below it."""
    posts = "".join(at(x, 0, -500, box(40, 40, 500)) for x in (0, 400, 960)) + at(700, 0, -500, box(40, 40, 499))
    evaluated = evaluate(read_model(f"union() {{ {box(1000, 40, 40)} {posts} }}", "model.csg"))
    counted = {}

    def decide(facts):
        if facts["role"] == "root":
            return Conclusion("split", "r", 1.0, "")
        if "contact_count" not in facts:
            return Need("prism")
        if facts["role"] == "operand":
            counted.setdefault(facts["prism_length"], facts["contact_count"])
        return Conclusion("brick", "r", 1.0, "")

    partition(evaluated, decide)
    assert counted == {1000.0: 3, 500.0: 1, 499.0: 0}


def test_strips_of_a_flat_wall_are_measured_between_its_edges():
    drilled = describe.walls(piece_of(f"difference() {{ {PLATE} {at(50, 50, -1, box(60, 40, 10))} }}"))
    assert drilled["outline_fill"] == pytest.approx(1 - 60 * 40 / (200 * 100), rel=1e-5)
    assert drilled["strip_ratio"] == pytest.approx(2 * (20000 - 2400) / (600 + 200) / 8, rel=1e-5)
    whole = describe.walls(piece_of(PLATE))
    assert (whole["outline_fill"], whole["strip_ratio"]) == (1.0, pytest.approx(2 * 20000 / 600 / 8, rel=1e-5))


def test_a_part_without_flat_walls_has_no_strips():
    pipe = describe.walls(piece_of(f"difference() {{ {rod(60, 300)} {at(0, 0, -1, rod(56, 302))} }}"))
    assert pipe["cylinder_wall_count"] == 1
    assert not {"outline_fill", "strip_ratio"} & set(pipe)


def test_what_operands_would_be_by_themselves_is_measured_on_their_beams():
    tube = f"difference() {{ {box(40, 40, 600)} {at(4, 4, -1, box(32, 32, 602))} }}"
    asked = []

    def decide(facts):
        asked.append(facts)
        return plain_decide(facts)

    lying = f"difference() {{ {at(40, 0, 0, box(600, 40, 40))} {at(39, 4, 4, box(602, 32, 32))} }}"
    partition(evaluate(read_model(f"union() {{ {tube} {lying} {at(0, 0, -8, box(640, 300, 8))} }}", "m.csg")), decide)
    (root,) = (facts for facts in asked if facts.tier == "members" and facts["operand_count"] == 3)
    beams = 2 * (40 * 40 - 32 * 32) * 600
    assert root["beam_share"] == pytest.approx(beams / (beams + 640 * 300 * 8), rel=1e-5)
    assert root["beam_fill"] == pytest.approx(1 - 0.8**2, rel=1e-5)
    assert root["cut_beam_count"] == 0


@pytest.mark.parametrize("shift", [0.0, 0.1, 1000 / 7])
def test_of_equally_empty_walls_the_one_with_the_narrowest_strips_tells_wherever_they_stand(shift):
    """In one of these places rounding makes the share that the thicker one fills the greater by 1e-16."""
    thin, thick = (f"difference() {{ {box(200, 100, t)} {at(50, 20, -1, box(100, 60, 20))} }}" for t in (8, 12))
    places = [(shift, 1.7 * shift, 0.0), (3 * shift, shift / 3, 300.0)]
    for first, second in (places, places[::-1]):
        found = describe.walls(piece_of(f"union() {{ {at(*first, thin)} {at(*second, thick)} }}"))
        assert found["strip_ratio"] == pytest.approx(2 * (20000 - 6000) / (600 + 320) / 12, rel=1e-5)


@given(
    st.floats(0.01, 100.0),
    st.floats(0.01, 100.0),
    st.floats(0.0, math.pi),
    st.lists(st.tuples(st.floats(0.0, 1.0), st.floats(0.0, 1.0), st.floats(0.0, 1e-12)), max_size=12),
)
def test_the_smallest_rectangle_of_a_rectangle_is_itself(long, short, angle, inner) -> None:
    """Whatever else lies in it, and on its sides but for rounding."""
    corners = np.array([(0, 0), (long, 0), (long, short), (0, short)])
    beside = [(x * long, 0.0 if k % 2 else y * short) for k, (x, y, _) in enumerate(inner)]
    off = np.array([(0.0, 0.0)] * 4 + [(0.0, -e * short) for _, _, e in inner])
    points = np.concatenate([corners, np.array(beside).reshape(-1, 2)]) + off
    turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
    sides = smallest_rectangle(shapely.multipoints(points @ turn.T))
    assert sides == pytest.approx((max(long, short), min(long, short)), rel=1e-6)


def test_a_hull_with_sides_of_rounding_has_a_rectangle_too() -> None:
    """What is left of a hopper's wall, along its edge: GEOS gives a line for it."""
    seen = [
        (75.6126549378146, 0.43032444688855825), (75.61265493781461, 0.43032444688855687),
        (75.61265493781539, 0.43032444688939836), (80.50545431158801, -1.5098579890945847),
        (80.505454311588, -1.5098579890945825), (200.0875735193064, 125.56323363161626),
        (200.0875735193064, 125.56323363161628), (204.98037141422716, 137.902026939357),
        (204.98037141422714, 137.90202693935692),
    ]  # fmt: skip
    points = shapely.multipoints(seen)
    long, short = smallest_rectangle(points)
    assert short > 1.0
    assert points.convex_hull.area <= long * short <= 2.0 * points.convex_hull.area


def test_points_in_line_have_no_rectangle() -> None:
    assert smallest_rectangle(shapely.multipoints([(0, 0), (1, 1), (2, 2)])) == (0.0, 0.0)


def test_a_fork_is_no_member_along_its_prongs() -> None:
    """Most of its sections are in two pieces; with the slot filled it is a member."""
    bar = "cube(size = [20, 4, 200], center = false);"
    slot = at(5, -1, 20, "cube(size = [10, 6, 200], center = false);")
    fork, whole = (piece_of(body).solid for body in (f"difference() {{ {bar} {slot} }}", bar))
    along = np.array([0.0, 0.0, 1.0])
    assert measure(fork, sweep_along(fork, along)) is None
    assert measure(whole, sweep_along(whole, along)) is not None
