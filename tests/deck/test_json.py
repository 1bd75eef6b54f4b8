"""The model as JSON, written and read back: everything that a program needs, in numbers that lose nothing."""

import json
from dataclasses import fields, is_dataclass, replace

import numpy as np
import pytest
from handmade import cantilever, channel_outline, i_outline, model_of, shell_cantilever, solid_cantilever, whole_set
from hypothesis import given, settings
from hypothesis import strategies as st
from joined import block_on_plate, half_beam_half_solid, lap_of_plates, post_on_plate
from shapely import Polygon, box

from kernel.connect.model import Mpc, NamedSet, Property, Rbe2, Rbe3
from kernel.deck.deck import format_for, formats
from kernel.deck.jsonread import read_json_deck
from kernel.errors import DeckError, ReadError
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock

JSON = format_for("", "json")


def assert_same(one, other, place="model"):
    """Equal to the last bit, types and all."""
    assert type(one) is type(other), place
    if is_dataclass(one):
        for field in fields(one):
            assert_same(getattr(one, field.name), getattr(other, field.name), f"{place}.{field.name}")
    elif isinstance(one, np.ndarray):
        assert one.dtype == other.dtype and np.array_equal(one, other), place
    elif isinstance(one, dict):
        assert list(one) == list(other), place
        for key in one:
            assert_same(one[key], other[key], f"{place}[{key}]")
    elif isinstance(one, tuple):
        assert len(one) == len(other), place
        for index, pair in enumerate(zip(one, other)):
            assert_same(*pair, f"{place}[{index}]")
    else:
        assert one == other, place


@pytest.mark.parametrize(
    "make",
    [
        post_on_plate, block_on_plate, lap_of_plates, lambda: half_beam_half_solid("work"),
        lambda: cantilever(channel_outline(), 1000 / 3, 7, "line3"), lambda: shell_cantilever("quad8"),
        lambda: solid_cantilever("wedge15", divisions=(2, 1, 1)),
    ],
)  # fmt: skip
def test_a_model_comes_back_to_the_last_bit(make):
    model = make()
    model = replace(model, sets=(whole_set(model, "TOP"),), notes=("a note",))
    read = read_json_deck(JSON.write(model))
    assert_same(read, model)
    assert JSON.write(read) == JSON.write(model)


@pytest.mark.parametrize("name", [known.name for known in formats()])
def test_a_model_read_back_is_written_the_same_in_every_format(name):
    model = post_on_plate()
    read = read_json_deck(JSON.write(model))
    try:
        expected = format_for("", name).write(model)
    except DeckError:
        with pytest.raises(DeckError):
            format_for("", name).write(read)
        return
    assert format_for("", name).write(read) == expected


@pytest.mark.parametrize("name", [known.name for known in formats()])
def test_a_set_of_nothing_is_written_as_no_set(name):
    nothing = NamedSet("NOTHING", np.empty(0, np.int64), np.empty(0, np.int64))
    model = shell_cantilever("quad4", divisions=(2, 1))
    read = read_json_deck(JSON.write(replace(model, sets=(nothing, whole_set(model, "TOP")))))
    plain = format_for("", name).write(replace(model, sets=(whole_set(model, "TOP"),)))
    written = format_for("", name).write(read)
    if name in ("ansys", "ansys5", "abaqus", "calculix", "sapiv", "gmsh"):
        assert written == plain
    else:
        assert b"TOP" in written


reals = st.floats(allow_nan=False, allow_infinity=False)
sizes = st.floats(min_value=1e-3, max_value=1e3)


@st.composite
def models(draw):
    """Every kind of element on random nodes, with couplings of every kind and random properties."""
    count = draw(st.integers(20, 30))
    nodes = np.array(draw(st.lists(st.tuples(reals, reals, reals), min_size=count, max_size=count)))
    node = st.integers(0, count - 1)
    blocks, properties = [], []
    for number, kind in enumerate(draw(st.lists(st.sampled_from(sorted(ELEMENT_KINDS)), min_size=1, max_size=4))):
        element = ELEMENT_KINDS[kind]
        row = st.permutations(range(count)).map(lambda order, n=element.n_node: order[:n])
        rows = draw(st.lists(row, min_size=1, max_size=3))
        connectivity = np.array(rows, np.int64).reshape(-1, element.n_node)
        vectors = [draw(st.tuples(reals, reals, reals)) for _ in rows]
        orientation = np.array(vectors, float).reshape(-1, 3) if element.dimension == 1 else None
        blocks.append(ElementBlock(f"s{number}", kind, connectivity, orientation))
        name = {1: "beam", 2: "shell", 3: "solid"}[element.dimension]
        section = cantilever(box(0, 0, draw(sizes), draw(sizes)), 1.0).properties[0].section
        properties.append(
            Property(
                f"s{number}", name, "steel",
                thickness=draw(sizes) if name == "shell" else None,
                section=section if name == "beam" else None,
                density_factor=draw(sizes),
            )
        )  # fmt: skip
    some = st.lists(node, min_size=1, max_size=5)
    couplings = []
    for kind in draw(st.lists(st.sampled_from("abc"), max_size=4)):
        found = np.array(draw(some), np.int64)
        values = np.array([draw(reals) for _ in found])
        if kind == "a":
            couplings.append(Rbe2(draw(node), found, draw(st.sampled_from(["123", "123456"]))))
        elif kind == "b":
            couplings.append(Rbe3(draw(node), found, np.array([draw(sizes) for _ in found])))
        else:
            values[0] = draw(sizes)
            couplings.append(Mpc(found, np.array([draw(st.integers(1, 6)) for _ in found]), values))
    model = model_of(nodes, blocks, properties, couplings, units=draw(st.sampled_from(["mm", "m", "in"])))
    return replace(model, title=draw(st.text(max_size=9)), notes=tuple(draw(st.lists(st.text(max_size=9), max_size=2))))


@given(models())
@settings(max_examples=60)
def test_any_model_comes_back_to_the_last_bit(model):
    assert_same(read_json_deck(JSON.write(model)), model)


def test_a_section_with_holes_keeps_them():
    outline = Polygon(box(0, 0, 10, 20).exterior, [box(1, 1, 9, 9).exterior, box(1, 11, 9, 19).exterior])
    model = cantilever(outline, 100.0)
    assert_same(read_json_deck(JSON.write(model)).properties, model.properties)


def changed(path, value):
    document = json.loads(JSON.write(post_on_plate()))
    place = document
    for key in path[:-1]:
        place = place[key]
    place[path[-1]] = value
    return json.dumps(document)


@pytest.mark.parametrize(
    "path, value, told",
    [
        (("csgmesh",), 2, "csgmesh is 2, expected a deck of version 1"),
        (("nodes", 1), [1, 2], r"nodes is .*, expected a list of rows of 3 finite numbers"),
        (("nodes", 1), [1, 2, None], r"nodes is .*, expected a list of rows of 3 finite numbers"),
        (("nodes", 1), [1, 2, float("nan")], r"nodes is .*, expected a list of rows of 3 finite numbers"),
        (("blocks", 0, "kind"), "quad5", r"blocks\[0\]\.kind is \"quad5\", expected one of line2"),
        (("blocks", 0, "connectivity", 0, 0), 10**6, r"blocks\[0\]\.connectivity .* from 0 to"),
        (("blocks", 0, "connectivity", 0, 0), -1, r"blocks\[0\]\.connectivity .* from 0 to"),
        (("blocks", 0, "connectivity", 0, 0), 0.5, r"blocks\[0\]\.connectivity .* whole numbers"),
        (("blocks", 0, "connectivity", 0), [3, 4, 9, 3], r"blocks\[0\]\.connectivity .* each of their nodes once"),
        (("blocks", 0, "connectivity"), [], r"blocks\[0\]\.connectivity is \[\], expected one element or more"),
        (("blocks",), [], r"blocks is \[\], expected one block of elements or more"),
        (("properties", 0, "material"), "cheese", r"properties\[0\]\.material is \"cheese\", expected one of steel"),
        (("properties",), [], "properties are of , expected one for each of"),
        (("properties", 0, "segment"), "s9", "properties are of s9, .*, expected one for each of"),
        (
            ("materials", "steel", "density"),
            10**400,
            r"materials\.steel\.density is 1000.*, expected a number up to 1e\+99",
        ),
        (("materials", "steel", "poisson_ratio"), 0.5, "NU = 0.5"),
        (("couplings", 0, "kind"), "glue", r"couplings\[0\]\.kind is \"glue\", expected rbe2, rbe3 or mpc"),
        (("couplings", 0, "components"), "7", r"couplings\[0\]\.components .* 123 or 123456"),
        (("couplings", 0, "components"), "12", r"couplings\[0\]\.components .* 123 or 123456"),
        (
            ("couplings", 0, "independent_components"),
            "123456",
            r"independent_components .* expected 123",
        ),
        (("couplings", 0, "weights"), [0.0] * 9, r"couplings\[0\]\.weights .* a sum above 0"),
        (("properties", 0, "density_factor"), 0, r"properties\[0\]\.density_factor is 0, expected a number above 0"),
        (("properties", 1, "section", "j"), 0.0, r"properties\[1\]\.section\.j is 0\.0, expected a number above 0"),
        (("properties", 1, "section", "dimensions"), {"width": 20}, r"section\.dimensions\.height is missing"),
        (
            ("properties", 1, "section", "outline", 0, 0),
            [[0, 0], [20, 20], [20, 0], [0, 20], [0, 0]],
            r"section\.outline\[0\] .* rings that do not cross themselves",
        ),
        (("properties", 0, "thickness"), -1, r"properties\[0\]\.thickness is -1, expected a number above 0"),
        (("units",), "parsec", "unknown units"),
        (("title",), "\udfff", "title is .*, expected a text"),
        (("sets",), {}, "sets is {}, expected a list"),
    ],
)
def test_what_is_wrong_is_told_by_its_place(path, value, told):
    with pytest.raises(ReadError, match=rf"^deck: .*{told}"):
        read_json_deck(changed(path, value))


@pytest.mark.parametrize("text", ["", "[]", "{}", "nonsense", "[" * 100_000])
def test_what_is_no_deck_is_refused(text):
    with pytest.raises(ReadError, match=r"^model\.json: "):
        read_json_deck(text, "model.json")


def test_an_equation_needs_a_coefficient_for_what_depends():
    document = json.loads(JSON.write(lap_of_plates()))
    document["couplings"][0]["coefficients"][0] = 0.0
    with pytest.raises(ReadError, match=r"couplings\[0\]\.coefficients .* expected one above or below 0 first"):
        read_json_deck(json.dumps(document))


def test_the_section_and_its_material_are_whole():
    document = json.loads(JSON.write(cantilever(i_outline(), 1000.0, 4)))
    (element,) = document["properties"]
    assert element["section"]["j"] > 0
    assert document["materials"][element["material"]]["density"] > 0
    assert document["units"] == "mm"
