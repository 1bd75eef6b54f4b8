"""Hostile and treacherous YAML is refused, with a clear text, and with little work."""

from __future__ import annotations

import pytest
from counting import python_calls

from rules.document import MAX_FILE_CHARACTERS, Mapping, Scalar, number_of, read_document
from rules.engine import rule_base_from_text
from rules.problems import RuleProblems


def refusal(text: str) -> str:
    with pytest.raises(RuleProblems) as caught:
        read_document(text, "r.yaml")
    return str(caught.value).removeprefix("r.yaml:")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\na: 2", "2:1: the key 'a' stands twice, first in line 1"),
        ("x: &a 1", "1:4: an anchor (&a): anchors are refused, write the value out where it is needed"),
        ("a: *b", "1:4: an alias (*b): aliases are refused, write the value out"),
        ("<<: {a: 1}", "1:1: a merge key (<<): write the values out"),
        (
            "a: !!python/object:os.system x",
            "1:4: a tag (tag:yaml.org,2002:python/object:os.system): tags are refused, write the plain value",
        ),
        (
            "a: no",
            "1:4: 'no' is a truth value in YAML 1.1 and a text in others: "
            "write true, false or a plain number, or put it in quotes",
        ),
        (
            "a: 010",
            "1:4: '010' is an octal number in YAML 1.1: write true, false or a plain number, or put it in quotes",
        ),
        (
            "a: 1:30",
            "1:4: '1:30' is a number to base 60 in YAML 1.1: write true, false or a plain number, or put it in quotes",
        ),
        (
            "a: 1_000",
            "1:4: '1_000' is a number with underscores in YAML 1.1: "
            "write true, false or a plain number, or put it in quotes",
        ),
        (
            "a: 0x1f",
            "1:4: '0x1f' is a number to another base: write true, false or a plain number, or put it in quotes",
        ),
        ("a: ~", "1:4: '~' means nothing at all in YAML: write true, false or a plain number, or put it in quotes"),
        (
            "a: .inf",
            "1:4: '.inf' is no number that a rule can use: write true, false or a plain number, or put it in quotes",
        ),
        ("a: 1\n---\nb: 2", "2:1: a second document, expected one rule base in a file"),
        ("{[1]: 2}", "1:2: a key that is no plain word"),
        ("a: [\n", "2:1: not readable as YAML: while parsing a flow node did not find expected node content"),
        ("a: " + "[" * 25, "1:24: nested deeper than 20 levels"),
    ],
)
def test_what_is_refused(text, message):
    assert refusal(text) == message


def test_deep_nesting_is_refused_without_reading_it_all():
    calls = python_calls(lambda: refusal("[" * 100_000))
    assert "nested deeper than 20 levels" in refusal("[" * 100_000)
    assert calls < 1000


def test_a_large_file_is_refused():
    assert (
        refusal("#" * (MAX_FILE_CHARACTERS + 1)) == "1:1: a rule file of 1000001 characters, expected at most 1000000"
    )


def test_quoted_words_and_plain_numbers_are_what_they_look_like():
    document = read_document("a: 'no'\nb: 1e3\nc: .5\nd: -2\ne: \"010\"", "r.yaml")
    assert isinstance(document, Mapping)
    values = {key: item for key, item in document.entries.items() if isinstance(item, Scalar)}
    assert values["a"].text == "no"
    assert [number_of(values[key]) for key in "bcde"] == [1000.0, 0.5, -2.0, None]


def test_nothing_is_no_document():
    assert read_document("# only a comment\n", "r.yaml") is None


def test_quantities_that_double_one_another_are_refused():
    lines = ["quantities:", "  q0: fill + fill"]
    lines += [f"  q{k}: q{k - 1} + q{k - 1}" for k in range(1, 40)]
    lines += ["rules:", "  - {id: d, priority: default, then: {segment: brick, certainty: 1, because: x}}"]

    def refused():
        with pytest.raises(RuleProblems, match="the quantity 'q7' has more than 500 parts"):
            rule_base_from_text("\n".join(lines))

    assert python_calls(refused) < 2**20  # of the 2**39 parts that the last one stands for


def test_words_that_double_one_another_are_decided_once_each():
    from kernel.facts import Facts
    from rules.analysis import check_base

    def work_with(n_word: int) -> None:
        lines = ["rules:", "  - {id: a0, when: is_named, then: {word: w0, because: x}}"]
        for k in range(1, n_word):
            lines.append(
                f"  - {{id: a{k}, when: [w{k - 1}, {{not: {{not: w{k - 1}}}}}], then: {{word: w{k}, because: x}}}}"
            )
        last = n_word - 1
        lines.append(
            f"  - {{id: r, priority: specific, when: w{last}, then: {{segment: beam, certainty: 1, because: x}}}}"
        )
        lines.append("  - {id: d, priority: default, then: {segment: brick, certainty: 1, because: x}}")
        base = rule_base_from_text("\n".join(lines))
        assert base.decide(Facts({"is_named": True}, "necks")).type == "beam"
        assert check_base(base).ok
        assert base.explain(Facts({"is_named": False}, "necks")).answer.type == "brick"

    few = python_calls(lambda: work_with(20))
    assert python_calls(lambda: work_with(40)) < 3 * few


def test_powers_of_powers_do_not_grow_without_bound():
    from kernel.facts import Facts

    text = (
        "quantities: {a: operand_count ** 6, b: a ** 6, c: b ** 6, e: c ** 6}\n"
        "rules:\n  - {id: r, priority: specific, when: e > 1, then: {segment: beam, certainty: 1, because: x}}\n"
        "  - {id: d, priority: default, then: {segment: brick, certainty: 1, because: x}}"
    )
    assert rule_base_from_text(text).decide(Facts({"operand_count": 1000}, "necks")).type == "brick"
