"""Why: rules that fired, what was rejected and by how much, how near a threshold, conflicts."""

from __future__ import annotations

import json

import pytest
from rulegen import base_text, random_base, random_facts

from kernel.facts import Facts
from kernel.plan import Need
from rules.engine import load_rule_base, rule_base_from_text
from rules.explain import needs_review

BLOCK = {"kind": "block", "role": "root", "operand_count": 1, "component_count": 1, "is_prismatic": True}
NO_WALLS = {"wall_count": 0, "plane_wall_count": 0, "cylinder_wall_count": 0, "wall_share": 0.0, "neck_share": 0.0}


def block(length: float, side: float = 50.0) -> Facts:
    return Facts({**BLOCK, **NO_WALLS, "prism_length": length, "section_long": side}, "necks")


def test_the_reason_carries_its_numbers():
    answer = load_rule_base().decide(block(600.0))
    assert answer.because == "span 600 is 12.0 x the section's longer side (limit 10)"
    assert answer.rule == "slender-prism-is-beam"


def test_a_rejected_alternative_names_the_condition_that_failed():
    answer = load_rule_base().decide(block(499.0))
    rejected = {item.type: item for item in answer.rejected}
    assert answer.type == "brick"
    assert rejected["beam"].because == "span_ratio 9.98, needs >= 10 (beam_slenderness)"
    assert rejected["plates"].because == "wall_share 0, needs > 0.5 (mostly_walls)"
    assert rejected["cut"].because == "neck_share 0, needs > 0.3 (worth_cutting)"


def test_a_word_that_fails_says_what_keeps_its_rules_from_holding():
    facts = Facts(
        {**BLOCK, **NO_WALLS, "is_prismatic": False, "volume_deviation": 0.1, "sections_off": 4,
         "worst_section_off": 0.2, "prism_length": 12.0, "section_long": 1.0}, "necks"
    )  # fmt: skip
    rejected = {item.type: item for item in load_rule_base().decide(facts).rejected}
    assert rejected["beam"].because == (
        "swept no, needs yes (is_prismatic no, needs yes; volume_deviation 0.1, needs <= 0.03 (bolt_hole_volume) "
        "and sections_off 4, needs <= 3 (bolt_hole_sections))"
    )


@pytest.mark.parametrize(
    ("length", "type_", "margin"),
    [(499.0, "brick", 0.002), (500.0, "beam", 0.0), (520.0, "beam", 0.04), (600.0, "beam", 0.2), (400.0, "brick", 0.2)],
)
def test_the_margin_is_the_distance_to_the_nearest_threshold_as_a_share_of_it(length, type_, margin):
    answer = load_rule_base().decide(block(length))
    assert answer.type == type_
    assert answer.margin == pytest.approx(margin, abs=1e-12)
    assert needs_review(answer) == (margin < 0.05)


def test_a_decision_that_only_counts_made_has_no_margin():
    answer = load_rule_base().decide(Facts({"operand_count": 41, "role": "root"}, "intent"))
    assert answer.margin is None
    assert not needs_review(answer)


def test_a_conflict_asks_for_review_and_says_how_it_was_resolved():
    base = rule_base_from_text(
        "rules:\n  - {id: a, when: is_named, then: {segment: plate, certainty: 0.6, because: x}}\n"
        "  - {id: b, when: is_named, then: {segment: beam, certainty: 0.6, because: x}}\n"
        "  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: x}}"
    )
    explanation = base.explain(Facts({"is_named": True}, "necks"))
    assert explanation.review
    assert "conflict: beam (rule b) and plate (rule a) hold with the same priority" in explanation.to_text()
    assert "beam is preferred" in explanation.to_json()["answer"]["conflicts"][0]


def test_the_text_shows_every_rule_with_its_numbers():
    text = load_rule_base().explain(block(499.0)).to_text()
    assert text.startswith("brick, certainty 0.5, by the rule the-rest-is-brick: neither slender nor thin-walled")
    assert (
        "nearest threshold: 0.2% away, span_ratio 9.98, needs >= 10 (beam_slenderness) (rule slender-prism-is-beam)"
        "  REVIEW: within 5 % of it" in text
    )
    assert "  fails: slender-prism-is-beam (specific, beam 0.95)\n    holds: swept yes, needs yes" in text
    assert "    fails, by 0.2%: span_ratio 9.98, needs >= 10 (beam_slenderness)" in text
    assert "  prism_length = 499" in text


def test_the_json_is_plain_and_complete():
    explanation = load_rule_base().explain(block(600.0))
    data = json.loads(json.dumps(explanation.to_json()))
    assert data["answer"]["type"] == "beam"
    assert data["review"] is False
    rules = {rule["id"]: rule for rule in data["rules"]}
    assert len(rules) == len(load_rule_base().rules)
    assert rules["slender-prism-is-beam"]["state"] == "holds"
    assert rules["slender-prism-is-beam"]["conditions"][1] == {
        "condition": "span_ratio >= beam_slenderness",
        "found": "span_ratio 12, needs >= 10 (beam_slenderness)",
        "state": "holds",
        "strength": pytest.approx(0.2),
    }
    assert rules["exactly-swept"]["word"] == "swept"


def test_an_undecided_node_says_what_it_needs_and_what_is_not_measured():
    explanation = load_rule_base().explain(Facts({"operand_count": 1, "role": "root"}, "intent"))
    assert explanation.answer == Need("extents")
    text = explanation.to_text()
    assert text.startswith("undecided: needs the facts of extents")
    assert "not measured: component_count not measured (extents), needs > 1" in text
    assert explanation.to_json()["answer"] == {"need": "extents"}


def test_the_explanation_gives_the_same_answer_as_the_decision_for_any_base_and_node():
    import random

    random_ = random.Random(8)
    for _ in range(5):
        base = rule_base_from_text(base_text(random_base(random_)))
        for _ in range(40):
            facts = random_facts(random_)
            explanation = base.explain(facts)
            assert explanation.answer == base.decide(facts)
            assert explanation.to_text()
            json.dumps(explanation.to_json(), allow_nan=False)
            for report in explanation.rules:
                if report.state == "holds" and not report.is_word:
                    assert isinstance(explanation.answer, Need) or report.id


def test_moving_every_number_by_less_than_the_margin_keeps_the_decision():
    base = load_rule_base()
    answer = base.decide(block(540.0))
    assert answer.margin == pytest.approx(0.08)
    for factor in (0.93, 0.96, 1.0, 1.05):
        assert base.decide(block(540.0 * factor)).type == "beam"
    assert base.decide(block(540.0 * 0.92)).type == "brick"


def test_brace_and_unknown_values_in_a_reason():
    base = rule_base_from_text(
        "rules:\n  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, "
        "because: '{{set}} {kind} {is_named} {fill:.0%} {wall_count:d} {slenderness:+.1f} {depth}'}}"
    )
    facts = Facts({"kind": "block", "is_named": True, "fill": 0.5, "slenderness": 2.0, "depth": 3}, "necks")
    assert base.decide(facts).because == "{set} block yes 50% unknown +2.0 3"
