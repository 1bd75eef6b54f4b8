"""Every error in a rule file: its exact text, its line and its column."""

from __future__ import annotations

import pickle

import pytest

from kernel.errors import InputError, RuleError
from rules.engine import load_rule_base, rule_base_from_text
from rules.problems import RuleProblems

DEFAULT = "\n  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: x}}"


def problems_in(text: str) -> list[str]:
    with pytest.raises(RuleProblems) as caught:
        rule_base_from_text(text, "r.yaml")
    return [str(problem) for problem in caught.value.problems]


def problem_in_condition(condition: str) -> str:
    """The one problem of a rule with this `when`, which stands in line 3 from column 11."""
    (problem,) = problems_in(
        f"rules:\n  - id: r\n    when: {condition}\n    then: {{segment: beam, certainty: 0.9, because: x}}{DEFAULT}"
    )
    return problem.removeprefix("r.yaml:3:")


@pytest.mark.parametrize(
    ("condition", "problem"),
    [
        ("slendernes >= 10", "11: unknown name 'slendernes', did you mean 'slenderness'?"),
        ("fill > 1 and slendernes >= 10", "24: unknown name 'slendernes', did you mean 'slenderness'?"),
        ("xyzzy >= 10", "11: unknown name 'xyzzy'"),
        (
            "slenderness >= 10 mm",
            "29: unexpected 'mm', expected an operator (and, or, <, <=, ==, >, >=, !=, +, -, *, /)",
        ),
        ("slenderness => 10", "23: unexpected '=', write >="),
        ("slenderness = 10", "23: unexpected '=', write == to compare"),
        ("slenderness && flatness", "23: unexpected '&', write and"),
        ("fill > 5%", "19: unexpected '%', write a share such as 0.05"),
        ("prism_length >= 10", "24: a length compared with a ratio"),
        ("section_area >= prism_length", "24: an area compared with a length"),
        ("prism_length + slenderness >= 1", "24: a length + a ratio, expected the same dimension on both sides"),
        ("min(fill, volume) > 2", "21: min of a ratio and a volume, expected the same dimension"),
        ("min(fill) > 2", "11: min takes two or more values, found 1"),
        ("sqrt(fill, fill) > 2", "11: sqrt takes one value, found 2"),
        ("sqroot(slenderness) > 2", "11: unknown function 'sqroot', did you mean 'sqrt'?"),
        ("slenderness ** flatness > 2", "26: a power, expected a plain number from -6 to 6"),
        ("kind == blok", "19: unknown value 'blok', did you mean 'block'?"),
        ("kind not in [block, cylindr]", "31: unknown value 'cylindr', did you mean 'cylinder'?"),
        ('"kind in [block, cylindr]"', "28: unknown value 'cylindr', did you mean 'cylinder'?"),
        ("kind > block", "16: texts compared by >, expected == or !="),
        ("kind == fill + 1", "16: a text compared with a ratio"),
        ("slenderness", "11: slenderness is a ratio, expected a comparison such as slenderness >= 10"),
        ("1 + 2", "11: a ratio alone, expected a comparison such as slenderness >= 10"),
        (
            "is_prismatic == true",
            "27: 'true' is not needed: write the truth value alone, or `not` before it",
        ),
        ("is_prismatic == is_named", "24: a truth value compared, write is_prismatic or not is_prismatic"),
        ("flatness >", "21: the expression ends too early, expected a value"),
        ('""', "12: an empty condition, expected a comparison such as slenderness >= 10"),
        ("and > 2", "11: 'and' is a word of the language, expected a name"),
        ("node.fill > 1", "11: unknown name 'node.fill': node. is for conditions inside a quantifier"),
        ("1e400 > fill", "11: the number 1e400 is too large"),
        ("{anny: [is_prismatic]}", "12: unknown word 'anny' in a condition, did you mean 'any'?"),
        ("{any: is_prismatic}", "17: `any` needs a list of conditions"),
        ("{some toool: is_prismatic}", "12: unknown thing 'toool', did you mean 'tool'?"),
        (
            "{some tool: {some tool: is_prismatic}}",
            "24: a quantifier inside a quantifier, expected conditions on the item's own facts",
        ),
        (
            "{not: is_named, any: [is_named]}",
            "11: 2 keys in one condition, expected one: any, all, not, or a quantifier",
        ),
    ],
)
def test_conditions_that_are_wrong(condition, problem):
    assert problem_in_condition(condition) == problem


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        (
            "",
            "1:1: no default, expected a rule with `priority: default` and no `when`, "
            "for nodes of which no rule speaks",
        ),
        (
            "[1]",
            "1:1: no keys at the top of the file, "
            "expected about, cases, extends, name, parameters, quantities, remove, rules",
        ),
        ("ruls: []\nrules:" + DEFAULT, "1:1: unknown key 'ruls', did you mean 'rules'?"),
        ("rules:" + DEFAULT + DEFAULT, "3:10: the rule d stands twice, first in r.yaml:2:10"),
        (
            "parameters: {x: {value: 5, unit: furlong}}\nrules:" + DEFAULT,
            "1:34: unknown unit 'furlong', expected 1 or one of mm, cm, m, in, ft, also with ^2 or ^3",
        ),
        (
            "parameters: {x: {value: 5, range: [6, 7]}}\nrules:" + DEFAULT,
            "1:25: x = 5 is outside its range 6 to 7",
        ),
        (
            "parameters: {x: {value: 5, range: [7, 6]}}\nrules:" + DEFAULT,
            "1:35: a range, expected two numbers such as [5, 30], the smaller first",
        ),
        ("parameters: {x: {value: five}}\nrules:" + DEFAULT, "1:25: the parameter 'x' is no number"),
        ("parameters: {fill: 5}\nrules:" + DEFAULT, "1:14: the name 'fill' is a fact, expected another"),
        ("parameters: {and: 5}\nrules:" + DEFAULT, "1:14: the name 'and' is a word of the language, expected another"),
        (
            "quantities: {a: b + 1, b: a + 1}\nrules:" + DEFAULT,
            "1:14: quantities define one another in a circle: a, b",
        ),
        ("quantities: {a: kind}\nrules:" + DEFAULT, "1:17: a text, expected a number"),
        (
            "extends: ../x.yaml\nrules:" + DEFAULT,
            "1:10: extends '../x.yaml', expected `base`: a rule base sent as text cannot reach files",
        ),
        (
            "extends: base\nremove: [unionissplit]",
            "2:10: no rule 'unionissplit' to remove, did you mean 'union-is-split'?",
        ),
        (
            "extends: base\nparameters: {beam_slenderness: 99}",
            "2:32: beam_slenderness = 99 is outside its range 4 to 30",
        ),
        (
            "rules:\n  - {id: r, when: v, then: {word: w, because: x}}"
            "\n  - {id: s, when: w, then: {word: v, because: x}}" + DEFAULT,
            "3:10: words conclude one another in a circle: v, w",
        ),
        (
            "rules:\n  - {when: is_named}" + DEFAULT,
            "2:5: a rule without `id`, expected a short name that no other rule has",
        ),
        (
            "rules:\n  - {id: r, when: is_named}" + DEFAULT,
            "2:10: the rule 'r' has no `then`, expected {segment: ..., certainty: ..., because: ...}",
        ),
        (
            "rules:\n  - {id: r, applies_to: blok, then: {segment: beam, certainty: 1, because: x}}" + DEFAULT,
            "2:25: unknown kind 'blok', did you mean 'block'?",
        ),
        (
            "rules:\n  - {id: r, when: is_named, then: {word: w, certainty: 1, because: x}}" + DEFAULT,
            "2:45: a word is concluded without certainty, expected none here",
        ),
    ],
)
def test_files_that_are_wrong(text, problem):
    assert problems_in(text) == [f"r.yaml:{problem}"]


def test_all_errors_of_a_file_are_reported_in_its_order():
    text = (
        "rules:\n  - {id: r, priority: high, when: is_prismatic, then: {segment: bem, certainty: 2, "
        "because: '{slendernes:.1f} {fill:x} {fill.__class__} {'}}" + DEFAULT
    )
    assert problems_in(text) == [
        "r.yaml:2:23: unknown priority 'high', expected one of default, general, specific, override",
        "r.yaml:2:65: unknown segment 'bem', did you mean 'beam'?",
        "r.yaml:2:81: a certainty of 2, expected above 0 and at most 1",
        "r.yaml:2:94: unknown name 'slendernes', did you mean 'slenderness'?",
        "r.yaml:2:111: the format 'x', expected one such as .1f, .3g, .0% or d",
        "r.yaml:2:120: the field '{fill.__class__}', expected a name such as {slenderness:.1f}",
        "r.yaml:2:137: a single '{', write {name} for a value or {{ for a brace",
    ]


def test_cases_that_are_wrong():
    text = (
        "rules:\n  - id: d\n    priority: default\n    then: {segment: brick, certainty: 0.5, because: x}\n    cases:\n"
        "      - {name: a, expect: bric, facts: {knd: block}}\n"
        "      - {name: b, expect: brick, tier: prism, facts: {slenderness: abc, wall_count: 1, is_named: 1}}\n"
        "      - {name: c, expect: brick, facts: {wall_count: 1.5, kind: blok}}\n"
        "      - {expect: brick}\n"
    )
    assert problems_in(text) == [
        "r.yaml:6:27: unknown answer 'bric', did you mean 'brick'?",
        "r.yaml:6:41: unknown fact 'knd', did you mean 'kind'?",
        "r.yaml:7:68: the fact 'slenderness' is a number, found 'abc'",
        "r.yaml:7:73: the fact 'wall_count' is of the tier walls, beyond the case's tier prism",
        "r.yaml:7:98: the fact 'is_named' is true or false, found '1'",
        "r.yaml:8:54: the fact 'wall_count' counts, found '1.5'",
        "r.yaml:8:65: unknown value 'blok', did you mean 'block'?",
        "r.yaml:9:9: a case needs either `facts` or `csg`",
        "r.yaml:9:9: a case without `name`, expected a few words that say what it shows",
    ]


def test_the_error_is_one_line_with_the_first_place_and_survives_pickling():
    text = "rules:\n  - {id: r}\n  - {id: s}"
    with pytest.raises(RuleError) as caught:
        rule_base_from_text(text, "r.yaml")
    error = caught.value
    assert isinstance(error, InputError)
    assert str(error).startswith("r.yaml:2:10: the rule 'r' has no `then`")
    assert str(error).endswith("(and 1 more problem)")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


def test_a_file_that_is_not_there(tmp_path):
    missing = tmp_path / "none.yaml"
    with pytest.raises(RuleError, match="cannot be read: No such file or directory"):
        load_rule_base(str(missing))


def test_a_folder_without_rules(tmp_path):
    with pytest.raises(RuleError, match=r"no rule files \(\*\.yaml\) in the folder"):
        load_rule_base(str(tmp_path))


def test_a_file_that_is_not_text(tmp_path):
    path = tmp_path / "r.yaml"
    path.write_bytes(b"rules: \xff\xfe")
    with pytest.raises(RuleError, match="is not UTF-8 at byte 7"):
        load_rule_base(str(path))
