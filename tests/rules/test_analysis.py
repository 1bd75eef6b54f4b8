"""What authors of rules are told: check, cases, coverage, diff, documentation."""

from __future__ import annotations

import json

import pytest

from kernel.errors import GeometryError
from kernel.facts import SPECS, Facts
from kernel.plan import Conclusion, Decision, Plan
from rules.analysis import (
    check,
    check_text,
    coverage,
    diff,
    diff_plans,
    run_cases,
    vocabulary_json,
    vocabulary_text,
)
from rules.engine import load_rule_base, rule_base_from_text

DEFAULT = "  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: x}}\n"


def findings(*rules: str, head: str = "") -> list[str]:
    report = check_text(f"{head}rules:\n" + "".join(f"  - {rule}\n" for rule in rules) + DEFAULT, "r.yaml")
    json.dumps(report.to_json())
    return [f"{finding.kind}: {finding.message}" for finding in report.findings if finding.severity != "note"]


def rule(identity: str, when: str, segment: str = "beam", certainty: float = 0.9, band: str = "specific") -> str:
    return (
        f"{{id: {identity}, priority: {band}, when: [{when}], "
        f"then: {{segment: {segment}, certainty: {certainty}, because: x}}}}"
    )


def test_errors_are_findings_with_their_place():
    report = check_text(
        "rules:\n  - {id: r, when: slendernes > 1, then: {segment: beam, certainty: 1, because: x}}", "r.yaml"
    )
    assert not report.ok
    assert report.to_text() == "1 error, 0 warnings, 0 notes\n" + str(report.findings[0])
    assert (
        str(report.findings[0]) == "r.yaml:2:19: error: error: unknown name 'slendernes', did you mean 'slenderness'?"
    )
    assert report.to_json()["findings"][0]["line"] == 2


def test_a_missing_file_is_a_finding():
    assert not check("/nowhere/at/all.yaml").ok


@pytest.mark.parametrize(
    "when",
    [
        "slenderness >= 10, slenderness < 10",
        "slenderness >= 10, {not: slenderness > 5}",
        "kind == block, 'kind in [cone, sphere]'",
        "is_named, {not: is_named}",
        "wall_count > 1, wall_count < 2",
        "wall_share > 1",
        "volume < 0",
        "extent_long > extent_short, extent_long <= extent_short",
        "free_length is known, free_length is unknown",
        "{any: [fill > 0.5 and fill < 0.2, wall_count < 0]}",
    ],
)
def test_a_rule_that_can_never_hold_is_unreachable(when):
    found = findings(rule("r", when))
    assert len(found) == 1
    assert found[0].startswith("unreachable: the rule 'r' never holds: ")


@pytest.mark.parametrize(
    "when",
    ["slenderness >= 10, slenderness <= 10", "kind != block, kind != cone", "wall_count >= 1, wall_count < 2"],
)
def test_a_rule_that_can_hold_is_left_alone(when):
    assert findings(rule("r", when)) == []


def test_a_rule_that_holds_only_where_a_stronger_one_does_is_shadowed():
    assert findings(
        rule("weak", "slenderness >= 20, is_named", "plate", 0.5), rule("strong", "slenderness >= 10", "beam", 0.9)
    ) == ["shadowed: whenever the rule 'weak' holds, the stronger rule 'strong' concludes something else"]


def test_a_rule_is_shadowed_through_the_words_that_it_uses():
    assert findings(
        "{id: w, when: slenderness >= 10, then: {word: slender, because: x}}",
        rule("weak", "slenderness >= 20", "plate", 0.5),
        rule("strong", "slender", "beam", 0.9),
    ) == ["shadowed: whenever the rule 'weak' holds, the stronger rule 'strong' concludes something else"]


def test_alternatives_are_shadowed_when_each_of_them_is():
    assert findings(
        rule("weak", "{any: [kind == cone, fill > 0.9]}", "plate", 0.5),
        rule("one", "'kind in [cone, sphere]'", "beam", 0.9),
        rule("two", "fill > 0.8", "beam", 0.8),
    ) == ["shadowed: whenever the rule 'weak' holds, the stronger rules 'one' and 'two' conclude something else"]


def test_a_rule_is_not_shadowed_where_the_stronger_ones_fact_may_be_missing():
    assert findings(rule("weak", "is_named", "plate", 0.5), rule("strong", "slenderness >= 0", "beam", 0.9)) == []


def test_a_rule_that_adds_nothing_is_redundant():
    assert findings(
        rule("weak", "slenderness >= 20", "beam", 0.5, "general"), rule("strong", "slenderness >= 10", "beam", 0.9)
    ) == ["redundant: whenever the rule 'weak' holds, the stronger rule 'strong' concludes the same"]


def test_rules_that_tie_and_conclude_different_things_are_contradictory():
    assert findings(rule("a", "slenderness >= 10", "beam"), rule("b", "flatness >= 3", "plate")) == [
        "contradictory: the rules 'a' (beam) and 'b' (plate) hold together with equal priority and certainty, "
        "e.g. flatness = 3, slenderness = 10; beam is preferred"
    ]
    assert findings(rule("a", "slenderness >= 10", "beam"), rule("b", "slenderness < 10", "plate")) == []


def test_what_no_rule_uses_is_reported():
    head = "parameters: {p: {value: 1}}\nquantities: {q: fill + 1}\n"
    assert findings("{id: w, when: is_named, then: {word: named, because: x}}", head=head) == [
        "unused: no rule uses the parameter 'p'",
        "unused: no rule uses the quantity 'q'",
        "unused: no rule uses the word 'named'",
    ]


def test_gaps_are_where_only_the_default_speaks():
    report = check_text(
        "rules:\n" + f"  - {rule('a', 'slenderness >= 10, fill > 0.5')}\n  - {rule('b', 'slenderness < 5')}\n" + DEFAULT
    )
    gaps = [finding.message for finding in report.findings if finding.kind == "gap"]
    assert gaps == [
        "only the default speaks where fill <= 0.5 and slenderness >= 5",
        "only the default speaks where fill > 0.5 and slenderness >= 5 and slenderness < 10",
    ]


CASES = """
name: few
rules:
  - id: long
    priority: specific
    when: [slenderness >= 10, {not: is_named}]
    then: {segment: beam, certainty: 0.9, because: x}
    cases:
      - {name: long enough, expect: beam, facts: {slenderness: 10, is_named: false}}
      - {name: needs its prism, expect: need prism, tier: extents, facts: {is_named: false}}
      - {name: wrong on purpose, expect: beam, facts: {slenderness: 9, is_named: false}}
      - {name: a model, expect: {"/": split, "0": beam}, csg: "union() {}"}
  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: z}}
"""


def plan(**types: str) -> Plan:
    """A plan of nodes: `root` is "/", `p0` is "0"."""
    facts = Facts({"slenderness": 9.0}, "necks")
    return Plan(
        tuple(
            Decision("/" if key == "root" else key[1:], facts, type_, "rule", Conclusion(type_, "r", 1.0, "b"))
            for key, type_ in types.items()
        )
    )


def test_cases_that_fail_say_what_spoke_against_them():
    report = run_cases(rule_base_from_text(CASES, "r.yaml"))
    assert not report.ok
    assert [(result.name, result.passed) for result in report.results] == [
        ("long enough", True),
        ("needs its prism", True),
        ("wrong on purpose", False),
    ]
    assert report.not_run == ("a model",)
    assert report.to_text().splitlines()[0] == (
        "r.yaml:11:9: wrong on purpose: expected beam, found brick by d (z); beam: slenderness 9, needs >= 10"
    )
    assert report.to_json()["cases"][2]["found"] == "brick"


def test_models_are_described_by_whoever_can():
    base = rule_base_from_text(CASES, "r.yaml")
    passed = {r.name: r for r in run_cases(base, lambda text, decide: plan(root="split", p0="beam")).results}
    assert passed["a model"].passed
    failed = {r.name: r for r in run_cases(base, lambda text, decide: plan(root="split")).results}
    assert failed["a model"].found == "/: split, 0: not asked"

    def refuse(text, decide):
        raise GeometryError("empty union")

    broken = {r.name: r for r in run_cases(base, refuse).results}
    assert (broken["a model"].passed, broken["a model"].message) == (False, ": empty union")
    assert coverage(base, refuse).n_node == 3


def test_coverage_says_which_conditions_were_never_seen_one_way():
    report = coverage(rule_base_from_text(CASES, "r.yaml"))
    assert report.share == 0.5
    assert report.n_node == 3
    assert "  never failed: not is_named" in report.to_text()
    assert report.to_json()["rules"][1]["conditions"][0] == {
        "condition": "slenderness >= 10",
        "held": 1,
        "failed": 1,
        "both": True,
    }


def test_diff_names_the_nodes_that_change_and_how():
    a = rule_base_from_text(CASES)
    b = rule_base_from_text(CASES.replace("slenderness >= 10", "slenderness >= 5"))
    nodes = {f"n{k}": Facts({"slenderness": float(k), "is_named": False}, "necks") for k in (3, 7, 12)}
    report = diff(a, b, nodes)
    assert [(change.node, change.before, change.after) for change in report.changes] == [("n7", "brick", "beam")]
    assert (
        report.to_text()
        == f"few {a.version} -> few {b.version}: 1 of 3 nodes change\n  n7: brick (d) -> beam (long: x)"
    )
    assert diff(a, a, nodes).ok
    json.dumps(report.to_json())


def test_diff_of_plans_also_names_nodes_that_are_no_longer_asked_about():
    a = rule_base_from_text(CASES)
    report = diff_plans(a, a, {"m": (plan(root="split", p0="beam"), plan(root="brick"))})
    assert [(c.node, c.before, c.after) for c in report.changes] == [("m /", "split", "brick"), ("m 0", "beam", None)]
    assert "m 0: beam (r) -> not asked" in report.to_text()


def test_the_vocabulary_lists_every_fact_with_its_meaning():
    text = vocabulary_text()
    for spec in SPECS.values():
        assert spec.name in text
        assert spec.meaning in text


def test_the_documentation_of_a_base_has_its_parameters_quantities_and_rules():
    base = load_rule_base()
    text = vocabulary_text(base)
    assert "beam_slenderness = 10 [1, 4 to 30]" in text
    assert "span = first(free_length, prism_length)" in text
    assert "      when swept and span_ratio >= beam_slenderness" in text
    data = vocabulary_json(base)
    assert len(data["rule_base"]["rules"]) == len(base.rules)
    json.dumps(data)
