"""OpenSCAD's .csg: what it becomes, and the one line that says why it cannot be read."""

import math

import numpy as np
import pytest
from counting import python_calls
from csg_membership import holds

from kernel.csg.reader import read_model
from kernel.csg.tree import Hull, walk
from kernel.csg.treejson import tree_to_json
from kernel.errors import ReadError

CUBE = "cube(size = [1, 2, 3], center = false);"
CYLINDER = "cylinder($fn = 0, $fa = 12, $fs = 2, h = 4, r1 = 2, r2 = 2, center = false);"
SHIFT = "multmatrix([[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]])"


def read(text):
    return read_model(text, "m.csg")


def root(text):
    return read(text).root


def kinds(text):
    return [(path, node.kind) for path, node in walk(root(text))]


def error_of(text):
    with pytest.raises(ReadError) as caught:
        read(text)
    line = str(caught.value)
    assert "\n" not in line
    return line


def extrude(inner, parameters="height = 5, center = false, convexity = 1, scale = [1, 1], $fn = 0, $fa = 12, $fs = 2"):
    return f"linear_extrude({parameters}) {{ {inner} }}"


def turn(inner, parameters="angle = 360, convexity = 2, $fn = 0, $fa = 12, $fs = 2"):
    return f"rotate_extrude({parameters}) {{ {inner} }}"


SQUARE = "square(size = [3, 4], center = false);"
CIRCLE = "circle($fn = 0, $fa = 12, $fs = 2, r = 2);"


# --- what becomes a node


def test_one_object_is_the_root_itself():
    block = root(CUBE)
    assert block.kind == "block"
    assert block.size == (1, 2, 3)
    assert str(block.place) == "m.csg:1:1"


def test_several_objects_are_their_union():
    assert kinds(CUBE + CUBE) == [("/", "union"), ("0", "block"), ("1", "block")]


def test_a_group_of_several_is_a_union_and_of_one_is_no_node():
    assert kinds(f"group() {{ {CUBE} group() {{ {CYLINDER} }} group(); group() {{ }} }}") == [
        ("/", "union"),
        ("0", "block"),
        ("1", "cylinder"),
    ]


def test_colour_render_and_placements_are_no_nodes():
    text = f"color([1, 0, 0, 1]) {{ render(convexity = 1) {{ {SHIFT} {{ {CUBE} }} }} }}"
    block = root(text)
    assert block.kind == "block"
    assert block.placement[:3, 3].tolist() == [5, 6, 7]


@pytest.mark.parametrize("operation", ["difference", "intersection", "union"])
def test_a_boolean_with_one_operand_is_no_node(operation):
    assert kinds(f"{operation}() {{ {CUBE} }}") == [("/", "block")]


def test_booleans_stay_as_the_text_has_them():
    text = f"difference() {{ union() {{ {CUBE} {CYLINDER} }} {SHIFT} {{ {CUBE} {CUBE} }} {CYLINDER} }}"
    assert [kind for _, kind in kinds(text)] == [
        "difference",
        "union",
        "block",
        "cylinder",
        "union",
        "block",
        "block",
        "cylinder",
    ]


def test_every_node_knows_its_line_and_column():
    node = root(f"difference() {{\n\t{CUBE}\n\t{SHIFT} {{\n\t\t{CYLINDER}\n\t}}\n}}\n")
    assert [str(found.place) for _, found in walk(node)] == ["m.csg:1:1", "m.csg:2:2", "m.csg:4:3"]


def test_background_and_disabled_parts_are_left_out_and_highlighted_ones_kept():
    assert kinds(f"%{CUBE} #{CYLINDER} *{CUBE}") == [("/", "cylinder")]
    assert kinds(f"union() {{ {CUBE} %group() {{ {CUBE} }} #group() {{ {CYLINDER} }} }}") == [
        ("/", "union"),
        ("0", "block"),
        ("1", "cylinder"),
    ]


def test_an_exclamation_mark_shows_that_part_alone():
    assert kinds(f"difference() {{ {CUBE} !{CYLINDER} }}") == [("/", "cylinder")]


def test_comments_and_positional_arguments_are_read_too():
    assert root("// a comment\ncube(3, true); /* and { another */").placement[:3, 3].tolist() == [-1.5, -1.5, -1.5]
    assert root("sphere(d = 6);").radius == 3
    assert root("cylinder(h = 2, d = 3);").radius == 1.5


# --- primitives


def test_a_cylinder_with_two_radii_is_a_cone():
    cone = root("cylinder($fn = 0, h = 4, r1 = 2, r2 = 0, center = true);")
    assert (cone.kind, cone.bottom_radius, cone.top_radius, cone.height) == ("cone", 2, 0, 4)
    assert cone.placement[2, 3] == -2


@pytest.mark.parametrize(("fn", "kind"), [(0, "cylinder"), (3, "extrusion"), (11, "extrusion"), (12, "cylinder")])
def test_few_facets_are_a_prism_and_many_a_true_cylinder(fn, kind):
    assert root(f"cylinder($fn = {fn}, $fa = 12, $fs = 2, h = 1, r1 = 1, r2 = 1, center = false);").kind == kind


def test_a_prism_has_the_corners_that_openscad_gives_it():
    prism = root("cylinder($fn = 6, h = 1, r1 = 2, r2 = 2);")
    corners = [(2 * math.cos(math.radians(a)), 2 * math.sin(math.radians(a))) for a in range(0, 360, 60)]
    assert np.allclose(prism.loops[0], corners, atol=1e-15)


@pytest.mark.parametrize("radii", [(2, 1), (1, 2), (2, 0), (0, 2)])
def test_a_pyramid_tapers_the_right_way(radii):
    pyramid = root(f"cylinder($fn = 4, h = 2, r1 = {radii[0]}, r2 = {radii[1]});")
    levels = np.array([0.02, 1.98])
    for level, radius in zip(levels, radii):
        at = radii[0] + (radii[1] - radii[0]) * level / 2
        inside, outside = 0.98 * at, 1.02 * at
        assert holds(pyramid, np.array([[inside, 0, level], [outside, 0, level]])).tolist() == [True, False], radius


@pytest.mark.parametrize(("fn", "volume"), [(8, 83.1384), (5, 46.7653)])
def test_a_coarse_sphere_is_openscads_polyhedron(fn, volume):
    sphere = root(f"sphere($fn = {fn}, $fa = 12, $fs = 2, r = 3);")
    assert sphere.kind == "polyhedron"
    rings = (fn + 1) // 2
    assert len(sphere.points) == rings * fn
    top = 3 * math.cos(math.radians(90 / rings))
    assert sphere.points[:, 2].max() == pytest.approx(top)
    assert holds(sphere, np.array([[0, 0, 0.99 * top], [0, 0, 1.01 * top], [0, 0, 0.0]])).tolist() == [
        True,
        False,
        True,
    ]


def test_a_polyhedron_turned_inside_out_is_turned_back():
    points = "points = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]"
    right = root(f"polyhedron({points}, faces = [[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]], convexity = 1);")
    wrong = root(f"polyhedron({points}, faces = [[2, 1, 0], [1, 3, 0], [3, 2, 0], [2, 3, 1]], convexity = 1);")
    assert right.faces == ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2))
    inside = np.array([[0.1, 0.1, 0.1], [1, 1, 1]])
    assert holds(right, inside).tolist() == holds(wrong, inside).tolist() == [True, False]


def test_bent_faces_of_a_polyhedron_are_cut_into_triangles():
    text = (
        "polyhedron(points = [[0,0,0],[2,0,0],[2,2,0],[0,2,0],[0,0,1],[2,0,1],[2,2,2],[0,2,1]], faces = "
        "[[0,1,2,3],[4,7,6,5],[0,4,5,1],[1,5,6,2],[2,6,7,3],[3,7,4,0]]);"
    )
    faces = root(text).faces
    assert sorted(map(len, faces)) == [3, 3, 4, 4, 4, 4, 4]


# --- matrices


def test_a_six_digit_rotation_is_exact_in_the_tree():
    matrix = (
        "[[0.492404, -0.456826, 0.740843, 0], [0.586824, 0.802872, 0.10504, 0], [-0.642788, 0.383022, 0.663414, 0], "
        "[0, 0, 0, 1]]"
    )
    linear = root(f"multmatrix({matrix}) {{ {CUBE} }}").placement[:3, :3]
    assert np.abs(linear.T @ linear - np.eye(3)).max() < 1e-15
    assert linear[2, 0] == pytest.approx(-math.sin(math.radians(40)), abs=1e-15)


def test_uneven_scale_makes_a_block_bigger_and_a_sphere_an_ellipsoid():
    matrix = "multmatrix([[1, 0, 0, 0], [0, 2, 0, 0], [0, 0, 3, 0], [0, 0, 0, 1]])"
    block = root(f"{matrix} {{ {CUBE} }}")
    assert block.size == (1, 4, 9)
    sphere = root(f"{matrix} {{ sphere(r = 1); }}")
    assert sphere.kind == "sphere"
    assert np.diag(sphere.placement).tolist() == [1, 2, 3, 1]


# --- extrusions


def test_extruded_squares_and_circles_are_blocks_and_cylinders():
    assert root(extrude(SQUARE)).size == (3, 4, 5)
    cylinder = root(extrude(CIRCLE))
    assert (cylinder.kind, cylinder.radius, cylinder.height) == ("cylinder", 2, 5)


def test_a_centred_extrusion_of_a_centred_square_is_centred():
    text = extrude("square(size = [3, 4], center = true);", "height = 5, center = true")
    assert root(text).placement[:3, 3].tolist() == [-1.5, -2, -2.5]


def test_an_extruded_difference_is_a_difference_of_extrusions():
    text = extrude(f"difference() {{ {SQUARE} {SHIFT} {{ {CIRCLE} }} }}")
    assert kinds(text) == [("/", "difference"), ("0", "block"), ("1", "cylinder")]
    assert root(text).children[1].placement[:3, 3].tolist() == [5, 6, 0]


def test_a_polygon_with_a_hole_is_wound_as_the_tree_wants_it():
    text = extrude(
        "polygon(points = [[0,0],[0,9],[9,9],[9,0],[2,2],[4,2],[2,4]], paths = [[0,1,2,3],[4,5,6]], convexity = 1);"
    )
    outer, hole = root(text).loops
    area = lambda p: 0.5 * np.sum(p[:, 0] * np.roll(p[:, 1], -1) - np.roll(p[:, 0], -1) * p[:, 1])  # noqa: E731
    assert (area(outer), area(hole)) == (81, -2)


def test_a_polygon_that_crosses_itself_fills_by_the_even_odd_rule():
    bow_tie = root(extrude("polygon(points = [[0, 0], [4, 4], [4, 0], [0, 4]], paths = undef, convexity = 1);"))
    assert len(bow_tie.loops) == 2
    points = np.array([[0.5, 2, 1], [3.5, 2, 1], [2, 0.5, 1], [2, 3.5, 1]])
    assert holds(bow_tie, points).tolist() == [True, True, False, False]


def test_a_tapered_circle_is_a_cone_and_a_twisted_square_keeps_its_twist():
    cone = root(extrude(CIRCLE, "height = 5, scale = [0.5, 0.5]"))
    assert (cone.kind, cone.bottom_radius, cone.top_radius) == ("cone", 2, 1)
    twisted = root(extrude(SQUARE, "height = 5, twist = 90, slices = 7, scale = [1, 1]"))
    assert (twisted.twist, twisted.slices) == (90, 7)


def test_slices_that_openscad_did_not_write_are_counted_as_it_counts_them():
    assert root(extrude(SQUARE, "height = 10, twist = 90, $fn = 0, $fa = 12, $fs = 2")).slices == 7
    assert root(extrude(SQUARE, "height = 10, twist = 90, $fn = 40, $fa = 12, $fs = 2")).slices == 10


def test_the_hull_of_extruded_circles_keeps_them_round():
    slot = root(extrude(f"hull() {{ {CIRCLE} {SHIFT} {{ {CIRCLE} }} }}"))
    assert isinstance(slot, Hull)
    assert [member.kind for member in slot.members] == ["cylinder", "cylinder"]


def test_the_hull_of_one_convex_body_is_that_body():
    assert root(f"hull() {{ {CUBE} }}").kind == "block"
    assert root(f"hull() {{ {CUBE} {CYLINDER} }}").kind == "hull"


def test_a_turned_circle_is_a_torus_a_ball_or_neither():
    shifted = f"{SHIFT} {{ {CIRCLE} }}"
    torus = root(turn(shifted))
    assert (torus.kind, torus.major_radius, torus.minor_radius, torus.placement[2, 3]) == ("torus", 5, 2, 6)
    lower = "multmatrix([[1, 0, 0, 0], [0, 1, 0, -9], [0, 0, 1, 0], [0, 0, 0, 1]])"
    half = f"intersection() {{ {CIRCLE} {lower} {{ square(size = [9, 18]); }} }}"
    assert kinds(turn(half)) == [("/", "intersection"), ("0", "sphere"), ("1", "cylinder")]
    assert root(turn(shifted, "angle = 90")).kind == "revolution"
    assert root(turn(shifted, "angle = 360, $fn = 6")).facets == 6


def test_a_turned_square_is_a_cylinder_at_the_axis_and_a_ring_off_it():
    assert (root(turn(SQUARE)).radius, root(turn(SQUARE)).height) == (3, 4)
    assert root(turn(f"{SHIFT} {{ {SQUARE} }}")).kind == "revolution"
    cone = root(turn("polygon(points = [[0, 1], [3, 1], [2, 4], [0, 4]], paths = undef);"))
    assert (cone.kind, cone.bottom_radius, cone.top_radius, cone.placement[2, 3]) == ("cone", 3, 2, 1)


@pytest.mark.parametrize(("angle", "inside"), [(90, 45), (-90, -45), (270, 200)])
def test_a_part_turn_goes_the_way_of_its_angle(angle, inside):
    part = root(turn(f"{SHIFT} {{ {SQUARE} }}", f"angle = {angle}"))
    at = lambda degrees: [6 * math.cos(math.radians(degrees)), 6 * math.sin(math.radians(degrees)), 7]  # noqa: E731
    assert holds(part, np.array([at(inside), at(inside + 180 if abs(angle) == 90 else 315)])).tolist() == [True, False]


def test_an_outline_left_of_the_axis_is_turned_as_well():
    left = "multmatrix([[-1, 0, 0, -5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])"
    part = root(turn(f"{left} {{ {SQUARE} }}", "angle = 90"))
    assert holds(part, np.array([[-4.3, -4.3, 1], [4.3, 4.3, 1]])).tolist() == [True, False]


# --- refusals, each its one line

REFUSED = ["minkowski", "import", "surface", "projection", "resize", "roof", "fill", "offset", "text"]


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_be_read_is_refused_by_name(name):
    body = f"{name}() {{ {SQUARE if name in ('fill', 'offset', 'roof') else CUBE} }}"
    text = extrude(body) if name in ("fill", "offset", "text") else body
    line = error_of("\n " + text)
    assert line.startswith(f"m.csg:2:{text.index(name) + 2}: {name} (")
    assert line.endswith("cannot be read, expected it to be modelled otherwise")


@pytest.mark.parametrize("name", ["translate", "for", "module_call_of_mine"])
def test_source_instead_of_csg_and_unknown_names_are_told_apart(name):
    line = error_of(f"{name}([1, 2, 3]) {{ {CUBE} }}")
    assert ("belongs to OpenSCAD's source" in line) == (name != "module_call_of_mine")


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "\n  cub(size = [1, 1, 1]);",
            "m.csg:2:3: unknown primitive or operation 'cub', expected one of OpenSCAD's .csg such as cube or union, "
            "did you mean 'cube'?",
        ),
        (f"union() {{\n {CUBE}\n", "m.csg:1:9: '{' is never closed, expected '}'"),
        (f"{CUBE}\n}}", "m.csg:2:1: '}' closes nothing, expected its opening bracket before it"),
        ("cube(size = [1, 1, 1};", "m.csg:1:21: found '}', expected ']' for the '[' of line 1"),
        (
            "cube(size = [1, 1, 1])\nsphere(r = 1);",
            "m.csg:1:1: cube has children, expected none, or a ';' before what begins at line 2, column 1",
        ),
        (
            "cube(size = [1, 1, 1])",
            "m.csg:1:23: the file ends here, expected ';', '{' or a name such as cube or union",
        ),
        ("sphere(r = 1);\n/* open\n", "m.csg:2:1: a comment is never closed, expected '*/'"),
        ('sphere("r);', "m.csg:1:8: a string is never closed, expected '\"'"),
        ("sphere(r = -1);", "m.csg:1:8: sphere's r is -1, expected a number over 0"),
        ("sphere(r = nan);", "m.csg:1:8: sphere's r is nan, expected a finite number"),
        (
            "cube(size = [0, 1, 1], center = false);",
            "m.csg:1:6: cube's size is [0, 1, 1], expected 3 finite numbers over 0",
        ),
        (
            "cube(size = [inf, inf, inf]);",
            "m.csg:1:6: cube's size is [inf, inf, inf], expected 3 finite numbers over 0",
        ),
        ("cube(size = [1, 1]);", "m.csg:1:6: cube's size is [1, 1], expected 3 finite numbers over 0"),
        ("cube(size = 1e400);", "m.csg:1:6: cube's size is inf, expected 3 finite numbers over 0"),
        ("cube(size = 2e12);", "m.csg:1:6: cube's size is 2e+12, expected a number up to 1e+12"),
        ("cube(size = [1, 1, 1e-13]);", "m.csg:1:6: cube's size is [1, 1, 1e-13], expected a number of 1e-12 or more"),
        (
            extrude(SQUARE, "height = 5, twist = 90, slices = 20000"),
            "m.csg:1:40: linear_extrude's slices is 20000, expected a whole number from 1 to 10000",
        ),
        (
            extrude(SQUARE, "height = 5, twist = 1e9, $fn = 100"),
            "m.csg:1:1: linear_extrude's twist of 1e+09 degrees takes 277777778 slices, expected at most 10000",
        ),
        (
            "multmatrix([[1e9, 0, 0, 0], [0, 1e9, 0, 0], [0, 0, 1e9, 0], [0, 0, 0, 1]]) { " * 2 + CUBE + "}}",
            "m.csg:1:155: placements scale or move the block out of all bounds, expected factors of 1e-12 to 1e+12 and "
            "shifts up to 1e+12 in all",
        ),
        ("cylinder(h = 0, r1 = 1, r2 = 1);", "m.csg:1:10: cylinder's h is 0, expected a number over 0"),
        ("cylinder(h = 1, r1 = 0, r2 = 0);", "m.csg:1:17: cylinder's r1 is 0, expected a number over 0"),
        ("cylinder(h = 1, r1 = 1, r2 = -2);", "m.csg:1:25: cylinder's r2 is -2, expected a number of 0 or more"),
        (
            "cylinder(h = 1, rad = 1);",
            "m.csg:1:17: cylinder has no parameter 'rad', expected h, r1, r2, center, r, d, d1 or d2",
        ),
        ("sphere(r = 1, r = 2);", "m.csg:1:15: sphere has its parameter 'r' twice, expected it once"),
        ("sphere(1, 2);", "m.csg:1:1: sphere has 2 positional arguments, expected 1"),
        ('cube(size = "big");', 'm.csg:1:6: cube\'s size is "big", expected 3 finite numbers over 0'),
        ("cube(size = 1, center = 3);", "m.csg:1:16: cube's center is 3, expected true or false"),
        (
            f"sphere(r = 1) {{ {CUBE} }}",
            "m.csg:1:1: sphere has children, expected none, or a ';' before what begins at line 1, column 17",
        ),
        ("difference() { }", "m.csg:1:1: difference has no operand, expected a solid and what is cut from it"),
        ("difference();", "m.csg:1:1: difference has no operand, expected a solid and what is cut from it"),
        (
            f"difference() {{ group(); {CUBE} }}",
            "m.csg:1:1: difference cuts from nothing, expected its first operand to hold a solid",
        ),
        (
            f"intersection() {{ {CUBE} group(); }}",
            "m.csg:1:1: operand 1 of intersection is empty, expected every operand to hold a solid",
        ),
        ("group() { }", "m.csg: there is no solid in the file, expected at least one"),
        (f"%{CUBE}", "m.csg: there is no solid in the file, expected at least one"),
        (SQUARE, "m.csg:1:1: square is flat, expected it inside linear_extrude or rotate_extrude to make a solid"),
        (extrude(CUBE), "m.csg:1:105: cube is a solid inside an extrusion, expected square, circle or polygon"),
        (
            extrude(extrude(SQUARE)),
            "m.csg:1:105: linear_extrude inside an extrusion, expected square, circle or polygon",
        ),
        (
            turn(CIRCLE),
            "m.csg:1:1: rotate_extrude turns a shape that crosses its axis (x from -2 to 2), expected it on one side "
            "of x = 0",
        ),
        (turn(SQUARE, "angle = 0"), "m.csg:1:16: rotate_extrude's angle is 0, expected a number other than 0"),
        (extrude(SQUARE, "height = -5"), "m.csg:1:16: linear_extrude's height is -5, expected a number over 0"),
        (
            extrude(SQUARE, "height = 5, scale = [0, 1]"),
            "m.csg:1:28: linear_extrude's scale is [0, 1], expected two numbers over 0, or both 0 for a point",
        ),
        (
            extrude("polygon(points = [[0, 0], [1, 1], [2, 2]], paths = undef);"),
            "m.csg:1:113: polygon's points is [[0, 0], [1, 1], [2, 2]], expected an outline that encloses some area",
        ),
        (
            extrude("polygon(points = [[0, 0], [1, 1], [nan, 2]], paths = undef);"),
            "m.csg:1:113: polygon's point 2 is [nan, 2], expected 2 finite numbers",
        ),
        (
            extrude("polygon(points = [[0, 0], [1, 1], [0, 2]], paths = [[0, 1, 3]]);"),
            "m.csg:1:148: entry 0 of polygon's paths has 3, expected point numbers from 0 to 2",
        ),
        (
            f"multmatrix([[0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]) {{ {CUBE} }}",
            "m.csg:1:1: multmatrix flattens its children, expected a matrix that keeps their volume",
        ),
        (
            f"multmatrix([[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 1, 1]]) {{ {CUBE} }}",
            "m.csg:1:1: multmatrix's last row is [0, 0, 1, 1], expected [0, 0, 0, 1]",
        ),
        (
            f"multmatrix([[1, 0, 0], [0, 1, 0], [0, 0, 1]]) {{ {CUBE} }}",
            "m.csg:1:12: multmatrix's m is [[1, 0, 0], [0, 1, 0], [0, 0, 1]], expected four rows of four finite "
            "numbers",
        ),
        (
            extrude(f"multmatrix([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]]) {{ {SQUARE} }}"),
            "m.csg:1:105: multmatrix tilts a flat shape out of its plane, expected it to stay flat",
        ),
        (
            "polyhedron(points = [[0,0,0],[1,0,0],[0,1,0],[0,0,1]], faces = [[0,1,2],[0,3,1],[0,2,3]]);",
            "m.csg:1:1: polyhedron is not closed: the edge between points 1 and 2 belongs to 1 face, expected two "
            "that run opposite ways",
        ),
        (
            "cube(size = [1, 2, oops]);",
            "m.csg:1:20: found 'oops', expected ']', a number, a list '[...]' or true, false or undef",
        ),
        (
            "a = 5; cube(a);",
            "m.csg:1:3: found an assignment, which belongs to OpenSCAD's source and not to what `openscad -o "
            "model.csg` writes, expected '('",
        ),
    ],
)
def test_an_error_is_one_line_with_place_and_what_was_expected(text, line):
    assert error_of(text) == line


@pytest.mark.parametrize(
    "text",
    [
        "union() {" * 10_000 + CUBE + "}" * 10_000,
        "union() {" * 10_000,
        "cube(size = " + "[" * 10_000 + "]" * 10_000 + ");",
    ],
)
def test_a_depth_bomb_is_refused_with_its_place_before_it_is_parsed(text):
    error_of("kube();")  # the parser is made
    calls = python_calls(lambda: error_of(text))
    assert error_of(text).endswith("nested too deeply, expected at most 1000 brackets inside each other")
    assert calls < 1000


def test_deep_groups_are_read_and_deep_booleans_refused():
    assert root("group() {" * 900 + CUBE + "}" * 900).kind == "block"
    deep = f"difference() {{ {CUBE} " * 300 + CUBE + "}" * 300
    assert "Booleans nested too deeply, expected at most 250 inside each other" in error_of(deep)
    flat = extrude(f"difference() {{ {SQUARE} " * 300 + SQUARE + "}" * 300)
    assert "Booleans nested too deeply, expected at most 250 inside each other" in error_of(flat)


def test_ten_thousand_leaves_are_one_union():
    leaf = f"\t{SHIFT} {{\n\t\t{CYLINDER}\n\t}}\n"
    assert len(root("union() {\n" + leaf * 10_000 + "}\n").children) == 10_000


@pytest.mark.parametrize("size", ["[1,\u2028 2, 3]", "[1, 2,\u00a03]", "[1, 2, \u0663]", "[1,\f2, 3]"])
def test_blanks_and_digits_that_json_does_not_know_are_read_too(size):
    assert root(f"cube(size = {size}, center = false);").size == (1.0, 2.0, 3.0)
    matrix = "[[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7], [0, 0,\u2003 0, 1]]"
    assert root(f"multmatrix({matrix}) {{ {CUBE} }}").placement[:3, 3].tolist() == [5.0, 6.0, 7.0]


def test_a_single_child_needs_no_braces() -> None:
    moved = "multmatrix([[1, 0, 0, 5], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])"
    braced = f"difference() {{ {CUBE} {moved} {{ %group() {{ {CUBE} }} {CUBE} }} }}"
    bare = braced.replace("%group() { " + CUBE + " }", "%group()   " + CUBE + "  ")
    assert bare != braced
    assert tree_to_json(read_model(bare, "m.csg")) == tree_to_json(read_model(braced, "m.csg"))
    assert root(f"{moved} union() {CUBE}").placement[:3, 3].tolist() == [5, 0, 0]
