"""The JSON tree: there and back to the last bit, and errors that point at the field."""

import json

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.csg.placement import place, rotation, translation
from kernel.csg.reader import read_model
from kernel.csg.tree import (
    Block,
    Boolean,
    Cone,
    CsgModel,
    Cylinder,
    Extrusion,
    Hull,
    Polyhedron,
    Revolution,
    Sphere,
    Torus,
    Wedge,
    frozen_array,
    walk,
)
from kernel.csg.treejson import json_to_tree, tree_to_json
from kernel.errors import Place, ReadError

# --- round trips

size = st.floats(1e-3, 1e3)
angle = st.floats(-360, 360)
label = st.one_of(st.none(), st.text(min_size=1, max_size=8))
where = st.one_of(st.none(), st.builds(Place, st.just("a.csg"), st.integers(1, 99), st.integers(1, 99)))
TETRAHEDRON = frozen_array([(0, 0, 0), (3, 0, 0), (0, 2, 0), (0, 0, 4)])
FACES = ((0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2))


def star(radii):
    turn = np.linspace(0, 2 * np.pi, len(radii), endpoint=False)
    return frozen_array(np.column_stack([np.cos(turn), np.sin(turn)]) * np.array(radii)[:, None])


outline = st.lists(size, min_size=3, max_size=7).map(star)
common = {"name": label, "place": where}
standard = st.one_of(
    st.builds(Block, size=st.tuples(size, size, size), **common),
    st.builds(Wedge, size=st.tuples(size, size, size), **common),
    st.builds(Cylinder, radius=size, height=size, **common),
    st.builds(Sphere, radius=size, **common),
    st.builds(lambda r, d, h, **c: Cone(bottom_radius=r, top_radius=r + d, height=h, **c), size, size, size, **common),
    st.builds(lambda a, b, **c: Torus(major_radius=a + b, minor_radius=b, **c), size, size, **common),
    st.builds(lambda loop, h, **c: Extrusion(loops=(loop,), height=h, **c), outline, size, **common),
    st.builds(
        lambda loop, h, t, s, **c: Extrusion(loops=(loop,), height=h, twist=t, scale=(s, s), slices=7, **c),
        outline,
        size,
        angle,
        size,
        **common,
    ),
    st.builds(
        lambda loop, a, **c: Revolution(loops=(frozen_array(loop - [loop[:, 0].min(), 0]),), angle=a, **c),
        outline,
        st.floats(1, 360),
        **common,
    ),
    st.builds(lambda **c: Polyhedron(points=TETRAHEDRON, faces=FACES, **c), **common),
)
placed = st.builds(
    lambda leaf, x, y, z, a, b, s: place(
        leaf, translation(x, y, z) @ rotation("z", a) @ rotation("x", b) @ np.diag([s, 1.0, 1.0, 1.0])
    ),
    standard,
    size,
    size,
    size,
    angle,
    angle,
    st.sampled_from((1.0, -1.0, 2.5)),
)
trees = st.recursive(
    placed,
    lambda inner: st.one_of(
        st.builds(
            lambda op, children, **c: Boolean(operation=op, children=tuple(children), **c),
            st.sampled_from(("union", "difference", "intersection")),
            st.lists(inner, min_size=2, max_size=4),
            **common,
        ),
        st.builds(
            lambda members, **c: Hull(members=tuple(members), **c), st.lists(placed, min_size=1, max_size=3), **common
        ),
    ),
    max_leaves=6,
)
models = st.builds(
    lambda root, units, materials: CsgModel(
        root=root, source="a.csg", language="json", units=units, materials=materials
    ),
    trees,
    st.sampled_from((None, "mm", "in")),
    st.sampled_from(({}, {"steel": {"E": 210000.0, "NU": 0.3, "RHO": 7.85e-9}})),
)


@settings(max_examples=150)
@given(models)
def test_a_tree_comes_back_from_json_to_the_last_bit(model):
    written = tree_to_json(model)
    back = json_to_tree(written, "a.csg")
    assert tree_to_json(back) == written
    for (path, there), (other, here) in zip(walk(model.root), walk(back.root), strict=True):
        assert (path, there.kind, there.name, there.place) == (other, here.kind, here.name, here.place)
        if there.kind not in ("union", "difference", "intersection"):
            assert np.array_equal(there.placement, here.placement)


@settings(max_examples=40)
@given(models)
def test_text_is_as_good_as_a_parsed_value(model):
    written = tree_to_json(model)
    read = read_model(json.dumps(written, indent=1), "a.csg")
    assert (read.language, read.units, read.materials) == ("json", model.units, model.materials)
    for node in (node for _, node in walk(read.root)):
        assert node.place is not None
    without = tree_to_json(CsgModel(root=read.root, source="a.csg", language="json"))
    assert without["root"]["kind"] == written["root"]["kind"]


def test_nodes_without_a_place_of_their_own_stand_where_their_braces_open():
    text = (
        '{\n "root": {"kind": "union", "operands": [\n  {"kind": "sphere", "radius": 1},\n'
        '   {"kind": "block", "size": [1, 2, 3]}]}}'
    )
    assert [str(node.place) for _, node in walk(read_model(text, "m.json").root)] == [
        "m.json:2:10",
        "m.json:3:3",
        "m.json:4:4",
    ]


# --- what may be written


def model_of(node, **more):
    return json_to_tree({"root": node, **more}, "m.json")


def test_a_placement_may_be_rows_or_numbers_row_by_row():
    rows = [[0, -1, 0, 1], [1, 0, 0, 2], [0, 0, 1, 3]]
    flat = [number for row in rows for number in row]
    for value in (rows, [*rows, [0, 0, 0, 1]], flat, [*flat, 0, 0, 0, 1]):
        placement = model_of({"kind": "sphere", "radius": 1, "placement": value}).root.placement
        assert placement[:3].tolist() == rows


def test_the_placement_of_a_boolean_goes_down_to_its_primitives():
    leaf = {"kind": "sphere", "radius": 1, "placement": [[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 0]]}
    node = {"kind": "union", "operands": [leaf, leaf], "placement": [[0, -1, 0, 0], [1, 0, 0, 0], [0, 0, 1, 5]]}
    assert [child.placement[:3, 3].tolist() for child in model_of(node).root.children] == [[0, 1, 5], [0, 1, 5]]


def test_a_placement_of_six_digits_is_made_rigid():
    rows = [[0.866025, -0.5, 0, 0], [0.5, 0.866025, 0, 0], [0, 0, 1, 0]]
    linear = model_of({"kind": "sphere", "radius": 1, "placement": rows}).root.placement[:3, :3]
    assert np.abs(linear.T @ linear - np.eye(3)).max() < 1e-15


# --- errors


def error_of(content):
    with pytest.raises(ReadError) as caught:
        json_to_tree(content, "m.json")
    line = str(caught.value)
    assert "\n" not in line
    return line


BALL = {"kind": "sphere", "radius": 1}


@pytest.mark.parametrize(
    ("content", "line"),
    [
        ([], "m.json: the document is [], expected an object"),
        ({}, "m.json: the document has no 'root', expected the tree's root node"),
        (
            {"root": BALL, "rot": 1},
            "m.json: /rot is no field of a model, expected root, units or materials, did you mean 'root'?",
        ),
        ({"root": BALL, "units": "inch"}, "m.json: /units is 'inch', expected mm, cm, m, in or ft"),
        ({"root": 3}, "m.json: /root is 3, expected an object"),
        (
            {"root": {"size": [1, 1, 1]}},
            "m.json: /root has no 'kind', expected one of block, cylinder, cone, wedge, sphere, torus, extrusion, "
            "revolution, polyhedron, hull, union, difference, intersection",
        ),
        (
            {"root": {"kind": "blok"}},
            "m.json: /root/kind is 'blok', expected one of block, cylinder, cone, wedge, sphere, torus, extrusion, "
            "revolution, polyhedron, hull, union, difference, intersection, did you mean 'block'?",
        ),
        ({"root": {"kind": "sphere"}}, "m.json: /root has no 'radius', expected it on a sphere"),
        ({"root": {"kind": "sphere", "radius": -1}}, "m.json: /root/radius is -1, expected a number over 0"),
        ({"root": {"kind": "sphere", "radius": "1"}}, "m.json: /root/radius is '1', expected a finite number"),
        ({"root": {"kind": "sphere", "radius": True}}, "m.json: /root/radius is true, expected a finite number"),
        ({"root": {"kind": "sphere", "radius": float("nan")}}, "m.json: /root/radius is nan, expected a finite number"),
        ({"root": {"kind": "sphere", "radius": 10**400}}, "m.json: /root/radius is inf, expected a finite number"),
        (
            {"root": {"kind": "sphere", "radius": 1, "height": 2}},
            "m.json: /root/height is no field of a sphere, expected kind, name, placement, place or radius",
        ),
        ({"root": {**BALL, "name": ""}}, "m.json: /root/name is '', expected a text or nothing"),
        ({"root": {**BALL, "name": "a\ud800"}}, "m.json: /root/name is 'a\\ud800', expected a text or nothing"),
        (
            {"root": {**BALL, "place": {"line": 0, "column": 1}}},
            "m.json: /root/place/line is 0, expected a whole number from 1 to 9007199254740992",
        ),
        ({"root": {"kind": "block", "size": [1, 2]}}, "m.json: /root/size is [1, 2], expected 3 finite numbers"),
        (
            {"root": {"kind": "block", "size": [1, 2, 0]}},
            "m.json: /root/size is [1, 2, 0], expected three numbers over 0",
        ),
        (
            {"root": {"kind": "torus", "major_radius": 1, "minor_radius": 1}},
            "m.json: /root/minor_radius is 1, expected less than major_radius (1)",
        ),
        (
            {"root": {"kind": "cone", "bottom_radius": 0, "top_radius": 0, "height": 1}},
            "m.json: /root/bottom_radius and top_radius are both 0, expected one of them over 0",
        ),
        (
            {"root": {"kind": "union", "operands": [BALL]}},
            "m.json: /root/operands has 1 nodes, expected a list of 2 or more",
        ),
        (
            {"root": {"kind": "union", "operands": [BALL, {**BALL, "radius": 0}]}},
            "m.json: /root/operands/1/radius is 0, expected a number over 0",
        ),
        ({"root": {"kind": "hull", "members": []}}, "m.json: /root/members has 0 nodes, expected a list of 1 or more"),
        (
            {"root": {**BALL, "placement": [[1, 0, 0, 0]]}},
            "m.json: /root/placement is [[1, 0, 0, 0]], expected four rows of four finite numbers, or 12 numbers row "
            "by row",
        ),
        (
            {"root": {**BALL, "placement": [[1, 0, 0, 0], [0, 1, 0, "a"], [0, 0, 1, 0]]}},
            "m.json: /root/placement/1/3 is 'a', expected a finite number",
        ),
        (
            {"root": {**BALL, "placement": [[0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 1, 0]]}},
            "m.json: /root/placement flattens the solid, expected a matrix that keeps its volume",
        ),
        (
            {"root": {"kind": "extrusion", "height": 1, "loops": [[[0, 0], [1, 1], [2, 2]]]}},
            "m.json: /root/loops encloses nothing, expected outlines with some area",
        ),
        (
            {"root": {"kind": "revolution", "loops": [[[-1, 0], [1, 0], [1, 1]]]}},
            "m.json: /root/loops has a point at x < 0, expected the outline on one side of the axis",
        ),
        (
            {"root": {"kind": "polyhedron", "points": TETRAHEDRON.tolist(), "faces": [[0, 1, 2]]}},
            "m.json: /root cannot be: polyhedron is not closed: the edge between points 0 and 1 belongs to 1 face, "
            "expected two that run opposite ways",
        ),
        (
            {"root": BALL, "materials": {"a/b": {"E": 1}}},
            "m.json: /materials/a~1b lacks NU and RHO, expected E, NU and RHO",
        ),
        (
            {"root": BALL, "materials": {"a/b": {"NU": 0.7}}},
            "m.json: /materials/a~1b/NU cannot be: a material's NU is 0.7, expected a number over -1 and under 0.5",
        ),
    ],
)
def test_an_error_is_one_line_with_its_pointer(content, line):
    assert error_of(content) == line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ('{"root": {"kind": "sphere", "radius": 1}', "m.json:1:1: '{' is never closed, expected '}'"),
        ('{"root": {"kind": "sphere}', "m.json:1:19: a string is never closed, expected '\"'"),
        ('{"root": {"kind": "sphere" "radius": 1}}', "m.json:1:28: found no comma, expected ',' or a closing bracket"),
        ('{\n "root": }', "m.json:2:10: found no value, expected one"),
        ('{"root": {"kind": "sphere", "radius": NaN}}', "m.json:1:39: found NaN, expected a finite number"),
        ('{"root": 1, "root": 2}', "m.json: the key 'root' stands twice in one object, expected it once"),
        ('{"root": 1} 3', "m.json:1:13: found more text after the model, expected the end of the file"),
        (
            '{"root":\n  {"kind": "union", "operands": [{"kind": "sphere", "radius": 1},\n'
            '  {"kind": "sphere", "radius": -1}]}}',
            "m.json:3:32: /root/operands/1/radius is -1, expected a number over 0",
        ),
        ('{"root": {"kind": "sphere"}}', "m.json:1:10: /root has no 'radius', expected it on a sphere"),
        ("[" * 10_000, "m.json:1:509: nested too deeply, expected at most 508 brackets inside each other"),
    ],
)
def test_a_text_gives_line_and_column_too(text, line):
    with pytest.raises(ReadError) as caught:
        read_model(text, "m.json")
    assert str(caught.value) == line


def test_a_value_nested_too_deeply_is_refused():
    node = BALL
    for _ in range(300):
        node = {"kind": "union", "operands": [BALL, node]}
    assert error_of({"root": node}).endswith("is nested too deeply, expected at most 250 nodes inside each other")
