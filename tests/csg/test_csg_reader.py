"""The one door: languages told apart, files bounded, errors in one line."""

import io
import json
import sys

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kernel.csg import reader
from kernel.csg.reader import language_of, read_file, read_model
from kernel.errors import ReadError


@pytest.mark.parametrize(
    ("text", "language"),
    [
        ('{"root": {}}', "json"),
        ("\n  [1]", "json"),
        ("cube(size = [1, 1, 1], center = false);", "openscad"),
        ("cube(size = [1, 1, 1])", "openscad"),
        ("// a = 3\ndifference() {\n}", "openscad"),
        ("/* A = BLO(1, 1, 1)\n*/ cube(3);", "openscad"),
        ("!cube(size = [1, 1, 1]);", "openscad"),
        ("%cube(3); #sphere(r = 1);", "openscad"),
        ("a = 3; cube(a);", "openscad"),
        ("A = BLO(1, 1, 1)", "padl"),
        ("! cube(3); {braces}\nA = BLO(1, 1, 1)", "padl"),
        ("units mm\nA = BLO(1, 1, 1)", "padl"),
        ("OUT A", "padl"),
        ("! only a comment", "padl"),
        ("unitsize(3);", "openscad"),
    ],
)
def test_the_content_tells_the_language(text, language):
    assert language_of(text) == language


@pytest.mark.parametrize("text", ["", "  \n\t\n"])
def test_an_empty_file_is_an_error(text):
    with pytest.raises(ReadError) as caught:
        read_model(text, "m.csg")
    assert str(caught.value) == "m.csg: the file is empty, expected a CSG model"


def test_a_file_is_read_whatever_its_ending_and_with_a_byte_order_mark(tmp_path):
    path = tmp_path / "model.txt"
    path.write_bytes(b"\xef\xbb\xbfA = BLO(1, 2, 3)\r\n")
    model = read_file(str(path))
    assert (model.language, model.root.kind, model.source) == ("padl", "block", str(path))


def test_a_dash_is_standard_input(monkeypatch):
    monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(b"sphere(r = 2);")))
    model = read_file("-")
    assert (model.root.radius, model.source, str(model.root.place)) == (2, "-", "-:1:1")


def test_a_missing_file_and_a_folder_are_errors(tmp_path):
    with pytest.raises(ReadError) as caught:
        read_file(str(tmp_path / "none.csg"))
    assert str(caught.value) == (
        f"{tmp_path}/none.csg: cannot be read (No such file or directory), expected a file with a CSG model"
    )
    with pytest.raises(ReadError, match="cannot be read"):
        read_file(str(tmp_path))


def test_a_file_that_is_no_text_is_an_error(tmp_path):
    path = tmp_path / "m.csg"
    path.write_bytes(b"cube(\xff);")
    with pytest.raises(ReadError) as caught:
        read_file(str(path))
    assert str(caught.value) == f"{path}: byte 5 is not UTF-8, expected a text file"


def test_a_file_of_fifty_megabytes_is_refused(tmp_path):
    path = tmp_path / "m.csg"
    with path.open("wb") as file:
        file.truncate(reader.MAX_INPUT_BYTES)
    with pytest.raises(ReadError) as caught:
        read_file(str(path))
    assert str(caught.value) == f"{path}: the file is too large, expected less than 50 MB"


TEXTS = (
    "difference() {\n\tcube(size = [4, 4, 1], center = false);\n\tcylinder($fn = 0, h = 3, r1 = 1, r2 = 1);\n}\n",
    "! plate\nUNITS mm\nX = 3 * (1 + SIN(30))\nA = BLO(X, 4, 1) DIF CYL(R=1, H=3) AT (ROTX=90)\n",
    '{"root": {"kind": "union", "operands": [{"kind": "sphere", "radius": 1}, {"kind": "block", "size": [1, 2, 3]}]}}',
)
pieces = st.sampled_from(
    [
        "",
        "-",
        "0",
        "1e999",
        "nan",
        "[",
        "]",
        "{",
        "}",
        "(",
        ")",
        ";",
        ",",
        "=",
        "&",
        "!",
        "*",
        '"',
        "\n",
        "cube",
        "UN",
        "\\",
    ]
)
edits = st.lists(st.tuples(st.floats(0, 1), st.integers(0, 6), pieces), min_size=1, max_size=4)


@settings(max_examples=300)
@given(st.sampled_from(TEXTS), edits)
def test_a_spoilt_text_gives_a_model_or_one_line_that_says_why(text, changes):
    for share, length, piece in changes:
        start = int(share * len(text))
        text = text[:start] + piece + text[start + length :]
    try:
        read_model(text, "m.csg")
    except ReadError as error:
        line = str(error)
        assert line.startswith("m.csg:")
        assert "expected" in line
        assert "\n" not in line


@pytest.mark.parametrize(
    "piece", ["/* ", '"\\"', "//\n", "\n", "! ;\n", ";", " ", "a", "a=", "% ", "[1,", "union(){", "A=1\n"]
)
def test_no_text_takes_more_than_linear_time(piece):
    with pytest.raises(ReadError):
        read_model(piece * 30_000, "m.csg")  # a quadratic scan of this takes minutes


def test_the_same_solid_reads_alike_in_the_three_languages():
    openscad = read_model("difference() { cube(size = [4, 4, 1]); cylinder(h = 3, r1 = 1, r2 = 1); }", "a")
    padl = read_model("A = BLO(4, 4, 1) DIF CYL(1, 3)", "b")
    tree = {
        "root": {
            "kind": "difference",
            "operands": [{"kind": "block", "size": [4, 4, 1]}, {"kind": "cylinder", "radius": 1, "height": 3}],
        }
    }
    parsed = read_model(json.dumps(tree), "c")
    for model in (openscad, padl, parsed):
        block, cylinder = model.root.children
        assert (model.root.kind, block.size, cylinder.radius, cylinder.height) == ("difference", (4, 4, 1), 1, 3)
