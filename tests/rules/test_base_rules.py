"""The rules that come with csgmesh: their own cases, soundness, laziness, and their figures."""

from __future__ import annotations

import time

import pytest

from kernel.facts import Facts
from kernel.plan import Need
from rules.analysis import check, coverage, run_cases
from rules.engine import load_rule_base


def node(tier: str, **values: object) -> Facts:
    return Facts({"kind": "union", "role": "root", "operand_count": 1, **values}, tier)


def test_every_case_of_the_base_passes():
    report = run_cases(load_rule_base())
    assert report.ok, report.to_text()
    assert len(report.results) >= 20


def test_whole_models_of_the_base_get_the_expected_answers():
    from kernel.csg.reader import read_model
    from kernel.segment.partition import partition
    from kernel.solid.evaluate import evaluate

    report = run_cases(
        load_rule_base(), lambda text, decide: partition(evaluate(read_model(text, "case")), decide, {}).plan
    )
    assert report.not_run == ()
    assert report.ok, report.to_text()


def test_the_base_has_no_errors_and_no_warnings():
    report = check()
    assert report.ok
    assert [str(finding) for finding in report.findings if finding.severity != "note"] == []


def test_the_cases_of_the_base_exercise_every_condition_both_ways():
    report = coverage(load_rule_base())
    assert report.ok, report.to_text()


def test_every_parameter_has_a_range_a_meaning_and_a_source():
    for parameter in load_rule_base().parameters.values():
        assert parameter.range is not None, parameter.name
        assert parameter.meaning, parameter.name
        assert parameter.source, parameter.name


@pytest.mark.parametrize(
    ("facts", "tier"),
    [
        (node("intent"), "extents"),
        (node("extents", component_count=1), "prism"),
        (node("prism", component_count=1, is_prismatic=False), "walls"),
        (node("walls", component_count=1, is_prismatic=False, wall_count=0, wall_share=0.0), "necks"),
    ],
)
def test_a_node_is_asked_tier_by_tier(facts, tier):
    assert load_rule_base().decide(facts) == Need(tier)


@pytest.mark.parametrize(
    ("facts", "type_"),
    [
        (node("intent", operand_count=41), "split"),
        (node("extents", component_count=3), "split"),
        (node("prism", component_count=1, is_prismatic=True, prism_length=10.0, section_long=1.0), "beam"),
        (
            node("walls", component_count=1, is_prismatic=False, wall_count=5, plane_wall_count=5, wall_share=0.97),
            "plates",
        ),
        (node("walls", operand_count=5, component_count=1, is_prismatic=False, wall_count=1, wall_share=0.7), "split"),
    ],
)
def test_a_node_is_concluded_as_soon_as_nothing_could_change_it(facts, type_):
    assert load_rule_base().decide(facts).type == type_


def test_with_all_tiers_known_there_is_always_a_conclusion_even_of_no_facts_at_all():
    answer = load_rule_base().decide(Facts({}, "necks"))
    assert not isinstance(answer, Need)
    assert answer.type == "brick"


def test_loading_and_compiling_takes_less_than_a_third_of_a_second():
    load_rule_base()
    start = time.process_time()
    base = load_rule_base()
    base.decide(node("necks"))
    assert time.process_time() - start < 0.3
