"""The engine against the plain evaluator, and what must not change an answer."""

from __future__ import annotations

import random

import pytest
from rulegen import base_text, random_base, random_facts

from kernel.facts import TIERS, Facts
from kernel.plan import Need
from rules.engine import RuleBase, load_rule_base, rule_base_from_text
from rules.reference import answer


def said(base: RuleBase, facts: Facts) -> str:
    found = base.decide(facts)
    return f"need {found.tier}" if isinstance(found, Need) else found.type


@pytest.mark.parametrize("seed", range(10))
def test_engine_and_plain_evaluator_agree_on_1000_random_nodes_of_a_random_base(seed):
    random_ = random.Random(seed)
    base = rule_base_from_text(base_text(random_base(random_)))
    answers = set()
    for _ in range(1000):
        facts = random_facts(random_)
        found = said(base, facts)
        assert found == answer(base.definition, facts), dict(facts)
        answers.add(found)
    assert len(answers) > 3


def test_engine_and_plain_evaluator_agree_on_random_nodes_of_the_base():
    random_ = random.Random(99)
    base = load_rule_base()
    for _ in range(1000):
        facts = random_facts(random_)
        assert said(base, facts) == answer(base.definition, facts), dict(facts)


@pytest.mark.parametrize("seed", range(5))
def test_order_of_rules_does_not_change_any_answer(seed):
    random_ = random.Random(seed)
    items = random_base(random_)
    shuffled = random_.sample(items, len(items))
    one, other = rule_base_from_text(base_text(items)), rule_base_from_text(base_text(shuffled))
    assert one.version == other.version
    for _ in range(200):
        facts = random_facts(random_)
        assert one.decide(facts) == other.decide(facts)


@pytest.mark.parametrize("seed", range(5))
def test_order_of_facts_does_not_change_any_answer(seed):
    random_ = random.Random(seed)
    base = load_rule_base()
    for _ in range(100):
        facts = random_facts(random_)
        items = list(facts.items())
        random_.shuffle(items)
        assert base._decide(facts) == base._decide(Facts(dict(items), facts.tier, facts.related))


@pytest.mark.parametrize("seed", range(10))
def test_a_conclusion_from_cheap_facts_is_the_one_that_all_facts_give(seed):
    random_ = random.Random(1000 + seed)
    base = load_rule_base() if seed == 0 else rule_base_from_text(base_text(random_base(random_)))
    for _ in range(100):
        full = random_facts(random_, TIERS[-1])
        final = base.decide(full)
        assert not isinstance(final, Need)
        for tier in TIERS:
            found = base.decide(cut_to(full, tier))
            if isinstance(found, Need):
                assert TIERS.index(found.tier) > TIERS.index(tier)
            else:
                assert found.type == final.type


def cut_to(facts: Facts, tier: str) -> Facts:
    """The same node, measured up to `tier` only."""
    from kernel.facts import RELATED, SPECS

    reached = TIERS.index(tier)
    values = {name: value for name, value in facts.items() if TIERS.index(SPECS[name].tier) <= reached}
    related = {name: items for name, items in facts.related.items() if TIERS.index(RELATED[name].tier) <= reached}
    return Facts(values, tier, related)
