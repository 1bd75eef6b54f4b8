"""The PADL-2-like language: arithmetic, names, placements, and the one line that says what is wrong."""

import math
import re

import numpy as np
import pytest
from counting import python_calls
from csg_membership import holds
from hypothesis import given
from hypothesis import strategies as st

from kernel.csg.reader import read_model
from kernel.csg.tree import find, walk
from kernel.errors import ReadError


def read(text):
    return read_model(text, "m.csg")


def root(text):
    return read(text).root


def names(text):
    return [(path, node.kind, node.name) for path, node in walk(root(text))]


def error_of(text):
    with pytest.raises(ReadError) as caught:
        read(text)
    line = str(caught.value)
    assert "\n" not in line
    return line


# --- statements


def test_the_last_solid_is_the_model_unless_out_names_another():
    assert root("A = BLO(1, 2, 3)\nB = SPH(1)").kind == "sphere"
    assert root("A = BLO(1, 2, 3)\nB = SPH(1)\nOUT A").kind == "block"


def test_case_does_not_matter_and_names_stay_as_written():
    node = root("Top = blo(1, y=2, Z=3)\nout TOP")
    assert (node.kind, node.size, node.name) == ("block", (1, 2, 3), "Top")


def test_comments_continuations_and_blank_lines():
    text = "! a plate\n\n  A = BLO(1, & ! first\n   ! and between\n  2, 3) ! done\n\n! end"
    assert root(text).size == (1, 2, 3)
    assert root(text.replace("\n", "\r\n")).size == (1, 2, 3)


def test_units_and_materials_are_handed_on():
    model = read("UNITS in\nMATERIAL Alloy(E=10E6, NU=0.33, RHO=2.5e-4)\nMATERIAL steel()\nA = SPH(1)")
    assert (model.language, model.units) == ("padl", "in")
    assert model.materials["Alloy"] == {"E": 10e6, "NU": 0.33, "RHO": 2.5e-4}
    assert model.materials["steel"]["E"] == pytest.approx(210e9 / 6894.757, rel=1e-6)  # psi


def test_a_named_material_is_in_the_units_that_the_file_names_anywhere():
    for text in ("MATERIAL Steel()", "MATERIAL Steel", "MATERIAL Steel ! S235"):
        found = read(f"{text}\nUNITS mm\nA = SPH(1)").materials["Steel"]
        assert found == {"E": 210e3, "NU": 0.3, "RHO": 7.85e-9}


def test_a_model_without_units_says_none():
    assert read("A = SPH(1)").units is None


# --- solids


def test_the_six_primitives_stand_in_their_standard_positions():
    text = """
        A = BLO(X=2, Y=3, Z=4)
        B = CYL(R=2, H=4)
        C = WED(2, 3, 4)
        D = CON(R1=2, R2=1, H=4)
        E = SPH(R=2)
        F = TOR(RMAJ=3, RMIN=1)
        G = A UN B UN C UN D UN E UN F
    """
    solids = root(text).children
    assert [solid.kind for solid in solids] == ["block", "cylinder", "wedge", "cone", "sphere", "torus"]
    assert all(np.array_equal(solid.placement, np.eye(4)) for solid in solids)
    assert solids[3].bottom_radius == 2
    assert root("A = CON(2, 2, 5)").kind == "cylinder"
    assert root("A = CON(0, 2, 5)").kind == "cone"


def test_chains_become_one_node_and_parentheses_another():
    assert [kind for _, kind, _ in names("A = SPH(1) UN SPH(2) UN SPH(3) UN SPH(4)")] == ["union"] + ["sphere"] * 4
    assert [kind for _, kind, _ in names("A = SPH(9) DIF SPH(2) DIF SPH(3)")] == ["difference"] + ["sphere"] * 3
    assert [path for path, _, _ in names("A = (SPH(1) UN SPH(2)) UN SPH(3)")] == ["/", "0", "0.0", "0.1", "1"]


def test_intersection_binds_before_union_and_difference():
    assert [(path, kind) for path, kind, _ in names("A = SPH(1) DIF SPH(2) INT SPH(3) INT SPH(4)")] == [
        ("/", "difference"),
        ("0", "sphere"),
        ("1", "intersection"),
        ("1.0", "sphere"),
        ("1.1", "sphere"),
        ("1.2", "sphere"),
    ]


def test_names_stand_on_their_nodes_and_on_every_use():
    text = "LEG = BLO(1, 1, 9)\nTOP = BLO(9, 9, 1) AT (MOVZ=9)\nTABLE = TOP UN LEG UN LEG AT (MOVX=8)\n"
    assert names(text) == [("/", "union", "TABLE"), ("0", "block", "TOP"), ("1", "block", "LEG"), ("2", "block", "LEG")]
    assert find(root(text), "top")[0] == "0"


def test_a_name_for_a_named_solid_is_the_new_one_and_its_place_the_new_line():
    node = root("LEG = BLO(1, 1, 9)\nLEG2 = LEG AT (MOVX=3)")
    assert (node.name, str(node.place), node.placement[0, 3]) == ("LEG2", "m.csg:2:1", 3)


def test_moves_apply_in_written_order_about_the_global_axes():
    there = root("A = BLO(1, 2, 3) AT (MOVX=5, ROTZ=90)")
    assert there.placement[:3, 3].tolist() == [0, 5, 0]
    back = root("A = BLO(1, 2, 3) AT (ROTZ=90, MOVX=5)")
    assert back.placement[:3, 3].tolist() == [5, 0, 0]
    twice = root("A = BLO(1, 2, 3) AT (ROTZ=90) AT (MOVX=5)")
    assert np.array_equal(twice.placement, back.placement)
    assert there.placement[:3, :3].tolist() == [[0, -1, 0], [1, 0, 0], [0, 0, 1]]


def test_placing_a_boolean_places_its_operands():
    node = root("A = SPH(1) UN SPH(1) AT (MOVY=2)\nB = A AT (ROTX=90, MOVX=1)")
    assert [child.placement[:3, 3].tolist() for child in node.children] == [[1, 0, 0], [1, 0, 2]]


def test_the_wedge_is_the_right_triangle_under_its_slope():
    wedge = root("W = WED(2, 4, 6)")
    assert holds(wedge, np.array([[0.9, 1.9, 5], [1.1, 2.1, 5], [0.1, 0.1, 6.1]])).tolist() == [True, False, False]


# --- numbers

leaf = st.one_of(
    st.integers(0, 20).map(lambda n: (str(n), float(n))),
    st.floats(0.01, 20).map(lambda x: (f"{x:.4f}", float(f"{x:.4f}"))),
    st.just(("PI", math.pi)),
)


def _joined(parts):
    (left, a), operator, (right, b) = parts
    if operator == "/":
        return (f"({left}) / (({right}) * ({right}) + 1)", a / (b * b + 1))
    return (f"({left}) {operator} ({right})", {"+": a + b, "-": a - b, "*": a * b}[operator])


def _function(parts):
    name, (text, value) = parts
    if name == "SQRT":
        return (f"SQRT(({text}) ** 2)", math.sqrt(value**2))
    reduced = math.fmod(value, 360.0)
    return (f"{name}({text})", {"SIN": math.sin, "COS": math.cos}[name](math.radians(reduced)))


expression = st.recursive(
    leaf,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from("+-*/"), inner).map(_joined),
        inner.map(lambda e: (f"-({e[0]})", -e[1])),
        st.tuples(st.sampled_from(("SIN", "COS", "SQRT")), inner).map(_function),
    ),
    max_leaves=12,
)


def value_of(text):
    return root(f"X = {text}\nA = SPH(1) AT (MOVX=X)").placement[0, 3]


@given(expression)
def test_arithmetic_agrees_with_python(pair):
    text, value = pair
    assert value_of(text) == pytest.approx(value, rel=1e-9, abs=1e-9)


@given(st.lists(st.tuples(st.sampled_from(("+", "-", "*", "/", "**")), st.integers(1, 4)), min_size=1, max_size=6))
def test_precedence_without_parentheses_is_pythons(steps):
    text = "3" + "".join(f" {operator} {number}" for operator, number in steps)
    try:
        value = float(eval(re.sub(r"\d+", r"\g<0>.0", text)))  # the text is ours: digits and operators
    except OverflowError:
        value = math.inf
    if abs(value) < 1e12:
        assert value_of(text) == pytest.approx(value, rel=1e-9)
    elif math.isfinite(value):
        assert value_of(f"({text}) / 1e200 / 1e100") == pytest.approx(value / 1e200 / 1e100, rel=1e-9)
    else:
        assert "is too large" in error_of(f"X = {text}\nA = SPH(1)")


@pytest.mark.parametrize(
    ("text", "value"),
    [("-2**2", -4), ("2**-1", 0.5), ("2**3**2", 512), ("--3", 3), ("2 - -3", 5), ("10-4-3", 3), (".5 + 1.", 1.5)],
)
def test_signs_and_powers_bind_as_in_python(text, value):
    assert value_of(text) == value


def test_angles_are_degrees_and_exact_where_they_can_be():
    assert value_of("COS(60) + SIN(30) + SIN(180)") == 1.0
    assert value_of("TAN(45)") == pytest.approx(1.0, abs=1e-15)


# --- errors, each its one line


@pytest.mark.parametrize(
    ("text", "line"),
    [
        (
            "A = BLOC(1, 2, 3)",
            "m.csg:1:5: unknown primitive 'BLOC', expected BLO, CYL, WED, CON, SPH or TOR, did you mean 'BLO'?",
        ),
        ("A = BLO(1, 2, 3", "m.csg:1:8: '(' is never closed, expected ')'"),
        ("A = BLO(1, 2, 3))", "m.csg:1:17: ')' closes nothing, expected its opening bracket before it"),
        ("A = BLO(1, 0, 3)", "m.csg:1:12: BLO's Y is 0, expected a number over 0"),
        ("A = CYL(R=-1, H=2)", "m.csg:1:9: CYL's R is -1, expected a number over 0"),
        ("A = CON(R1=-1, R2=2, H=2)", "m.csg:1:9: CON's R1 is -1, expected a number of 0 or more"),
        ("A = CON(0, 0, 1)", "m.csg:1:9: CON's R1 and R2 are both 0, expected one of them over 0"),
        ("A = TOR(2, 2)", "m.csg:1:12: TOR's RMIN is 2, expected less than RMAJ (2)"),
        ("A = CYL(R=1)", "m.csg:1:5: CYL lacks H, expected R, H"),
        ("A = CYL(1, 2, 3)", "m.csg:1:15: CYL has more numbers than it takes, expected R, H"),
        ("A = CYL(RAD=1, H=2)", "m.csg:1:9: CYL has no parameter 'RAD', expected R or H"),
        ("A = CYL(R=1, R=2)", "m.csg:1:14: CYL has its parameter 'R' twice, expected it once"),
        (
            "LEG = SPH(1)\nA = LEGG UN LEG",
            "m.csg:2:5: unknown name 'LEGG', expected one that is given before its use, did you mean 'LEG'?",
        ),
        ("A = B\nB = SPH(1)", "m.csg:1:5: unknown name 'B', expected one that is given before its use"),
        ("A = A UN SPH(1)", "m.csg:1:5: unknown name 'A', expected one that is given before its use"),
        ("A = BLO", "m.csg:1:5: BLO stands alone, expected BLO(X, Y, Z)"),
        ("A = SPH(1)\na = SPH(2)", "m.csg:2:1: the name 'a' is already given on line 1, expected another name"),
        ("UN = SPH(1)", "m.csg:1:1: 'UN' is a word of the language, expected another name"),
        (
            "A = SPH(3) UN SPH(2) DIF SPH(1)",
            "m.csg:1:22: UN and DIF are mixed, expected parentheses that say which comes first",
        ),
        ("A = SPH(1) UN 3", "m.csg:1:15: found the number 3, expected a solid"),
        ("A = 3 AT (MOVX=1)\nB = SPH(1)", "m.csg:1:5: AT follows the number 3, expected a solid before it"),
        ("A = SPH(1)\nB = A + 2", "m.csg:2:5: found a solid, expected a number"),
        (
            "A = SPH(1) AT (MOVE=1)",
            "m.csg:1:16: AT has 'MOVE', expected MOVX=, MOVY=, MOVZ=, ROTX=, ROTY= or ROTZ=, did you mean 'MOVZ'?",
        ),
        (
            "A = SPH(1) AT (1)",
            "m.csg:1:16: AT has a number without a key, expected MOVX=, MOVY=, MOVZ=, ROTX=, ROTY= or ROTZ=",
        ),
        ("X = 1 / (2 - 2)\nA = SPH(1)", "m.csg:1:7: 1 is divided by 0, expected a divisor other than 0"),
        ("X = 10 ** 999\nA = SPH(1)", "m.csg:1:8: 10 ** 999 is too large, expected a number under 1.8e308"),
        ("X = 9e307 * 10\nA = SPH(1)", "m.csg:1:11: 9e+307 * 10 is too large, expected a number under 1.8e308"),
        ("X = 1e999\nA = SPH(1)", "m.csg:1:5: the number is too large, expected one under 1.8e308"),
        (
            "X = (0 - 8) ** 0.5\nA = SPH(1)",
            "m.csg:1:13: -8 ** 0.5 has no value, expected a base over 0 or a whole exponent",
        ),
        ("X = 0 ** -1\nA = SPH(1)", "m.csg:1:7: 0 ** -1 has no value, expected a base over 0 or a whole exponent"),
        ("X = SQRT(-1)\nA = SPH(1)", "m.csg:1:5: SQRT(-1) has no value, expected a number of 0 or more"),
        ("X = TAN(90)\nA = SPH(1)", "m.csg:1:5: TAN(90) has no value, expected an angle other than 90 degrees"),
        ("A = SPH(1e13)", "m.csg:1:9: SPH's R is 1e+13, expected a number up to 1e+12"),
        ("A = SPH(1e-13)", "m.csg:1:9: SPH's R is 1e-13, expected a number of 1e-12 or more"),
        ("A = SPH(1) AT (MOVX=2e12)", "m.csg:1:16: MOVX is 2e+12, expected a number up to 1e+12"),
        ("X = SIN(1, 2)\nA = SPH(1)", "m.csg:1:5: SIN has 2 arguments, expected one number"),
        ("X = 3", "m.csg: there is no solid in the file, expected one such as A = BLO(1, 1, 1)"),
        ("! nothing", "m.csg: there is no solid in the file, expected one such as A = BLO(1, 1, 1)"),
        ("X = 3\nA = SPH(1)\nOUT X", "m.csg:3:5: OUT names the number 'X', expected a solid"),
        ("A = SPH(1)\nOUT A\nOUT A", "m.csg:3:5: OUT stands twice, expected it once"),
        ("UNITS inch\nA = SPH(1)", "m.csg:1:7: unknown units 'inch', expected mm, cm, m, in or ft, did you mean 'in'?"),
        ("UNITS mm\nUNITS mm\nA = SPH(1)", "m.csg:2:7: UNITS stands twice, expected it once"),
        ("MATERIAL S(E=-1)\nA = SPH(1)", "m.csg:1:12: a material's E is -1, expected a number over 0"),
        (
            "MATERIAL S(E=1, NU=0.5)\nA = SPH(1)",
            "m.csg:1:17: a material's NU is 0.5, expected a number over -1 and under 0.5",
        ),
        ("MATERIAL S(E=1, NU=0)\nA = SPH(1)", "m.csg:1:10: the material 'S' lacks RHO, expected E, NU and RHO"),
        (
            "MATERIAL steel()\nA = SPH(1)",
            "m.csg:1:10: the material 'steel' has no numbers, expected them, or UNITS to look it up in",
        ),
        (
            "UNITS mm\nMATERIAL steal\nA = SPH(1)",
            "m.csg:2:10: unknown material 'steal', expected steel, stainless, aluminium, titanium or concrete, or its "
            "E, NU and RHO, did you mean 'steel'?",
        ),
        (
            "UNITS mm\nMATERIAL steal()\nA = SPH(1)",
            "m.csg:2:10: unknown material 'steal', expected steel, stainless, aluminium, titanium or concrete, or its "
            "E, NU and RHO, did you mean 'steel'?",
        ),
        ("MATERIAL S(G=1)\nA = SPH(1)", "m.csg:1:12: a material has no property 'G', expected E, NU or RHO"),
        (
            "A = BLO(1,\n2, 3)",
            "m.csg:1:11: found the end of the line (& there goes on in the next), expected '(', a number or a name",
        ),
        ("A = SPH(1) SPH(2)", "m.csg:1:12: found 'SPH', expected the end of the line, UN, DIF or INT"),
        ("A = SPH(1) UN", "m.csg:1:14: the file ends here, expected '(', a number or a name"),
        ("= SPH(1)", "m.csg:1:1: found '=', expected the end of the line, a name, UNITS or MATERIAL"),
        ("A = SPH(#1)", "m.csg:1:9: found '#', expected ')', '(', a number or a name"),
    ],
)
def test_an_error_is_one_line_with_place_and_what_was_expected(text, line):
    assert error_of(text) == line


def test_parentheses_too_deep_are_refused_at_their_place():
    assert error_of("A = " + "(" * 10_000 + "SPH(1)" + ")" * 10_000) == (
        "m.csg:1:55: nested too deeply, expected at most 50 brackets inside each other"
    )
    assert root("A = " + "(" * 48 + "SPH(1)" + ")" * 48).kind == "sphere"


def test_names_that_multiply_are_bounded_before_they_are_built():
    text = "A0 = SPH(1)\n" + "\n".join(f"A{n} = A{n - 1} UN A{n - 1}" for n in range(1, 60))
    root("A = SPH(1)")  # the parser is made
    calls = python_calls(lambda: error_of(text))
    assert error_of(text) == "m.csg:18:11: too many nodes in the tree, expected at most 200000"
    assert calls < 100_000


def test_names_that_stack_are_bounded_by_depth():
    text = "A0 = SPH(1)\n" + "\n".join(f"A{n} = A{n - 1} DIF SPH(1)" for n in range(1, 300))
    assert error_of(text) == "m.csg:252:13: Booleans nested too deeply, expected at most 250 inside each other"


def test_long_chains_and_many_moves_do_not_nest():
    assert len(root("A = SPH(1)" + " UN SPH(1)" * 5000).children) == 5001
    assert root("A = SPH(1)" + " AT (MOVX=1)" * 5000).placement[0, 3] == 5000
    assert value_of("1" + " + 1" * 5000) == 5001
    assert value_of("-" * 5000 + "1") == 1
