"""Bands, certainty, evidence groups, preference, and what may still hold."""

from __future__ import annotations

import itertools

import pytest

from kernel.errors import DefectError
from kernel.facts import Facts
from kernel.plan import Conclusion, Need
from rules.definition import BANDS
from rules.engine import RuleBase, rule_base_from_text
from rules.resolve import resolve

DEFAULT = "  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: nothing else}}\n"


def base_of(*rules: str) -> RuleBase:
    return rule_base_from_text("rules:\n" + "".join(f"  - {rule}\n" for rule in rules) + DEFAULT)


def rule(identity: str, band: str, segment: str, certainty: float, when: str = "is_named", more: str = "") -> str:
    then = f"then: {{segment: {segment}, certainty: {certainty}, because: x}}"
    return f"{{id: {identity}, priority: {band}, when: {when}, {more}{then}}}"


NAMED = Facts({"is_named": True}, "necks")


@pytest.mark.parametrize(("weak", "strong"), list(itertools.combinations(BANDS, 2)))
def test_a_stronger_band_wins_whatever_the_certainty(weak, strong):
    base = base_of(rule("a", weak, "plate", 1), rule("b", strong, "beam", 0.01))
    assert base.decide(NAMED).type == "beam"


def test_inside_a_band_the_higher_certainty_wins_and_the_loser_is_named():
    answer = base_of(rule("a", "general", "plate", 0.6), rule("b", "general", "beam", 0.7)).decide(NAMED)
    assert (answer.type, answer.certainty, answer.conflicts) == ("beam", pytest.approx(0.7), ())
    assert ("plate", "a", "holds, but its certainty 0.6 is below 0.7") in [
        (item.type, item.rule, item.because) for item in answer.rejected
    ]


def test_equal_certainty_goes_by_type_not_by_order_and_is_recorded():
    rules = [rule("a", "general", "plates", 0.6), rule("b", "general", "beam", 0.6)]
    for order in (rules, rules[::-1]):
        answer = base_of(*order).decide(NAMED)
        assert answer.type == "beam"
        assert answer.conflicts == (
            "beam (rule b) and plates (rule a) hold with the same priority (general) and certainty (0.6): "
            "beam is preferred",
        )


def test_rules_of_one_type_add_up():
    base = base_of(
        rule("a", "general", "plate", 0.6), rule("b", "general", "plate", 0.5), rule("c", "general", "beam", 0.7)
    )
    answer = base.decide(NAMED)
    assert (answer.type, answer.certainty) == ("plate", pytest.approx(0.8))


def test_rules_of_one_evidence_group_count_once():
    same = "evidence: walls, "
    base = base_of(
        rule("a", "general", "plate", 0.6, more=same),
        rule("b", "general", "plate", 0.5, more=same),
        rule("c", "general", "beam", 0.7),
    )
    assert base.decide(NAMED).type == "beam"


def test_a_tier_is_needed_when_an_open_rule_could_win():
    base = base_of(rule("a", "general", "plate", 0.6), rule("b", "general", "beam", 0.7, "wall_count > 1"))
    assert base.decide(Facts({"is_named": True}, "intent")) == Need("walls")


def test_no_tier_is_needed_when_open_rules_could_not_win():
    base = base_of(rule("a", "general", "plate", 0.8), rule("b", "general", "beam", 0.7, "wall_count > 1"))
    assert base.decide(Facts({"is_named": True}, "intent")).type == "plate"


def test_open_rules_that_together_could_win_are_asked_for():
    base = base_of(
        rule("a", "general", "plate", 0.8),
        rule("b", "general", "beam", 0.7, "wall_count > 1"),
        rule("c", "general", "beam", 0.7, "wall_share > 0.5"),
    )
    assert base.decide(Facts({"is_named": True}, "intent")) == Need("walls")


def test_the_cheapest_tier_that_could_settle_it_is_asked_for():
    base = base_of(rule("a", "specific", "plate", 0.8, "[neck_share > 0.5, wall_count > 1, component_count == 1]"))
    assert base.decide(Facts({}, "intent")) == Need("extents")
    assert base.decide(Facts({"component_count": 1}, "extents")) == Need("walls")
    assert base.decide(Facts({"component_count": 2}, "extents")).type == "brick"


def test_an_open_rule_for_the_same_type_is_not_asked_for():
    base = base_of(rule("a", "general", "plate", 0.8), rule("b", "override", "plate", 1, "wall_count > 1"))
    assert base.decide(Facts({"is_named": True}, "intent")).type == "plate"


def test_a_fact_that_does_not_exist_settles_a_rule_once_its_tier_is_measured():
    base = base_of(rule("a", "specific", "plate", 0.8, "radius_ratio < 5"))
    assert base.decide(Facts({}, "prism")) == Need("walls")
    assert base.decide(Facts({}, "walls")).type == "brick"


def test_unless_holds_where_its_fact_does_not_exist_and_not_does_not():
    unless = base_of(rule("a", "specific", "plate", 0.8, more="unless: radius_ratio < 5, "))
    negated = base_of(rule("a", "specific", "plate", 0.8, "[is_named, {not: radius_ratio < 5}]"))
    assert unless.decide(NAMED).type == "plate"
    assert negated.decide(NAMED).type == "brick"


def test_with_nothing_at_all_there_is_no_answer_to_give():
    with pytest.raises(DefectError, match="no rule holds, not even a default"):
        resolve([], [])


def test_words_are_concluded_before_the_rules_that_use_them():
    base = base_of(
        "{id: w2, when: thin_one, then: {word: thin_two, because: x}}",
        "{id: w1, when: is_named, then: {word: thin_one, because: x}}",
        rule("a", "specific", "plate", 0.8, "[thin_two, {not: {all: [thin_one, is_prismatic]}}]"),
    )
    answer = base.decide(Facts({"is_named": True, "is_prismatic": False}, "necks"))
    assert isinstance(answer, Conclusion)
    assert answer.type == "plate"
    assert base.decide(Facts({"is_named": False, "is_prismatic": False}, "necks")).type == "brick"
    assert base.decide(Facts({"is_named": True}, "intent")) == Need("prism")
