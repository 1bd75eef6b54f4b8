"""Loading, deciding by experta, and living with experta's habits."""

from __future__ import annotations

import logging
import pickle
import subprocess
import sys
import threading

import pytest
from rulegen import random_facts

from kernel.facts import Facts
from kernel.plan import Need
from rules.engine import load_rule_base, rule_base_from_text
from rules.experta_engine import experta

TWO_RULES = """
name: two
rules:
  - {id: long, priority: specific, when: slenderness >= 10, then: {segment: beam, certainty: 0.9, because: x}}
  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: x}}
"""


def python(code: str, **environment: str) -> str:
    import os

    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env={**os.environ, **environment}
    )
    return result.stdout.strip()


def test_importing_the_engine_imports_no_experta_and_loading_a_base_neither():
    code = "import sys, rules.engine as e; e.load_rule_base(); print('experta' in sys.modules)"
    assert python(code) == "False"


def test_importing_experta_leaves_the_root_logger_and_collections_alone():
    code = (
        "import logging, collections; from rules.experta_engine import experta; experta();"
        "print(logging.root.handlers, logging.root.level, hasattr(collections, 'Mapping'))"
    )
    assert python(code) == "[] 30 False"


def test_answers_do_not_hang_on_the_hash_seed():
    code = (
        "import random, sys; sys.path.insert(0, 'tests/rules'); from rulegen import *;"
        "from rules.engine import *; r = random.Random(5);"
        "b = rule_base_from_text(base_text(random_base(r))); f = [random_facts(r) for _ in range(60)];"
        "print(b.version, [str(b.decide(x)) for x in f])"
    )
    assert python(code, PYTHONHASHSEED="1") == python(code, PYTHONHASHSEED="2")


def test_experta_is_quiet_even_when_the_root_logger_is_not(caplog):
    experta()
    with caplog.at_level(logging.DEBUG):
        rule_base_from_text(TWO_RULES).decide(Facts({"slenderness": 12.0}, "necks"))
    assert caplog.records == []


def test_a_limit_that_is_met_exactly_is_met():
    base = rule_base_from_text(TWO_RULES)
    for slenderness, expected in ((10.0, "beam"), (9.999999, "beam"), (9.9999, "brick"), (10.0001, "beam")):
        assert base.decide(Facts({"slenderness": slenderness}, "necks")).type == expected


def test_facts_that_are_equal_in_what_rules_speak_of_are_answered_from_the_cache():
    base = rule_base_from_text(TWO_RULES)
    one = base.decide(Facts({"slenderness": 12.0, "depth": 1}, "necks"))
    assert base.decide(Facts({"depth": 2, "slenderness": 12.0}, "necks", {"tools": ()})) is one
    assert base.decide(Facts({"slenderness": 12.5, "depth": 1}, "necks")) is not one
    assert base.decide(Facts({"slenderness": 12.0, "depth": 1}, "walls")) is not one


def test_facts_of_related_things_are_part_of_the_question():
    base = rule_base_from_text(
        "rules:\n  - {id: r, priority: specific, when: [{some tool: kind == cylinder}], "
        "then: {segment: plate, certainty: 1, because: x}}\n"
        "  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: x}}"
    )
    tool = Facts({"kind": "cylinder"}, "necks")
    assert base.decide(Facts({}, "intent", {"tools": (tool,)})).type == "plate"
    assert base.decide(Facts({}, "intent", {"tools": ()})).type == "brick"
    assert base.decide(Facts({}, "intent")).type == "brick"


@pytest.mark.parametrize(
    ("condition", "expected"),
    [
        ("{some neighbour: extent_long > node.extent_long}", True),
        ("{every neighbour: extent_long > node.extent_long}", False),
        ("{no neighbour: extent_long > 3 * node.extent_long}", True),
        ("{at least 2 neighbours: extent_short <= node.extent_long}", True),
        ("{at most 1 neighbour: extent_short <= node.extent_long}", False),
        ("{some neighbour: [extent_long > node.extent_long, extent_short > node.extent_long]}", False),
    ],
)
def test_quantifiers_over_neighbours(condition, expected):
    base = rule_base_from_text(
        f"rules:\n  - {{id: r, priority: specific, when: [{condition}], "
        "then: {segment: plate, certainty: 1, because: x}}\n"
        "  - {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: x}}"
    )
    neighbours = (
        Facts({"extent_long": 20.0, "extent_short": 5.0}, "necks"),
        Facts({"extent_long": 8.0, "extent_short": 5.0}, "necks"),
    )
    related = {"neighbours": neighbours}
    assert base.decide(Facts({"extent_long": 10.0}, "extents")) == Need("prism")
    answer = base.decide(Facts({"extent_long": 10.0}, "prism", related))
    assert (answer.type == "plate") == expected


def test_an_exception_in_a_condition_does_not_break_the_next_run():
    base = rule_base_from_text(TWO_RULES)
    facts = Facts({"slenderness": 12.0}, "necks")
    bad = Facts({"slenderness": "long"}, "necks")
    with pytest.raises(TypeError):
        base.decide(bad)
    assert base._engine._engine.running is False
    assert base.decide(facts).type == "beam"


def test_engines_leave_nothing_behind_in_expertas_class_level_caches():
    from experta.matchers.rete import check

    base = rule_base_from_text(TWO_RULES)
    before = [len(cache._instances) for cache in (check.TypeCheck, check.FeatureCheck, check.FactCapture)]
    base.decide(Facts({"slenderness": 12.0}, "necks"))
    after = [len(cache._instances) for cache in (check.TypeCheck, check.FeatureCheck, check.FactCapture)]
    assert before == after


def test_a_rule_base_is_pickled_and_decides_the_same():
    import random

    base = load_rule_base()
    copy = pickle.loads(pickle.dumps(base))
    assert (copy.name, copy.version) == (base.name, base.version)
    random_ = random.Random(3)
    for _ in range(50):
        facts = random_facts(random_)
        assert copy.decide(pickle.loads(pickle.dumps(facts))) == base.decide(facts)


def test_threads_each_have_an_engine_of_their_own():
    import random

    base = load_rule_base()
    nodes = [random_facts(random.Random(seed)) for seed in range(200)]
    expected = [load_rule_base().decide(facts) for facts in nodes]
    found: dict[int, list] = {}

    def work(number: int) -> None:
        found[number] = [base._decide(facts) for facts in nodes]

    threads = [threading.Thread(target=work, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(answers == expected for answers in found.values())
    assert len(found) == 4


def test_lengths_in_parameters_are_turned_into_the_models_units():
    text = TWO_RULES.replace("rules:", "parameters: {thin: {value: 5, unit: mm}, wide: {value: 1, unit: cm^2}}\nrules:")
    text = text.replace("slenderness >= 10", "[thinnest_wall <= thin, section_area >= wide]")
    base = rule_base_from_text(text)
    assert base.decide(Facts({"thinnest_wall": 4.0, "section_area": 120.0}, "necks")).type == "beam"
    metres = base.in_units("m")
    assert metres.version == base.version
    assert metres.decide(Facts({"thinnest_wall": 0.004, "section_area": 1.2e-4}, "necks")).type == "beam"
    assert metres.decide(Facts({"thinnest_wall": 4.0, "section_area": 120.0}, "necks")).type == "brick"
    assert load_rule_base().in_units("m").parameters == load_rule_base().parameters


def test_a_base_may_extend_another_and_change_parameters_only(tmp_path):
    own = tmp_path / "own.yaml"
    own.write_text("name: own\nextends: base\nparameters: {beam_slenderness: 12}\n")
    base, standard = load_rule_base(str(own)), load_rule_base()
    assert (base.name, len(base.rules)) == ("own", len(standard.rules))
    assert base.version != standard.version
    assert base.parameters["beam_slenderness"].source == standard.parameters["beam_slenderness"].source
    facts = Facts(
        {"role": "root", "operand_count": 1, "component_count": 1, "is_prismatic": True, "prism_length": 11.0,
         "section_long": 1.0, "wall_share": 0.0, "neck_share": 0.0}, "necks"
    )  # fmt: skip
    assert (standard.decide(facts).type, base.decide(facts).type) == ("beam", "brick")


def test_a_base_may_add_replace_and_remove_rules_of_another_by_relative_path(tmp_path):
    (tmp_path / "one.yaml").write_text(TWO_RULES)
    folder = tmp_path / "two"
    folder.mkdir()
    (folder / "a.yaml").write_text(
        "extends: ../one.yaml\nremove: [long]\nrules:\n"
        "  - {id: short, priority: general, when: slenderness < 10, then: {segment: plate, certainty: 1, because: x}}\n"
    )
    (folder / "b.yaml").write_text(
        "rules:\n  - {id: d, priority: default, then: {segment: beam, certainty: 0.5, because: x}}\n"
    )
    base = load_rule_base(str(folder))
    assert [rule.id for rule in base.rules] == ["d", "short"]
    assert base.decide(Facts({"slenderness": 20.0}, "necks")).type == "beam"


def test_bases_that_extend_one_another_are_refused(tmp_path):
    (tmp_path / "a.yaml").write_text("extends: b.yaml\n")
    (tmp_path / "b.yaml").write_text("extends: a.yaml\n")
    from rules.problems import RuleProblems

    with pytest.raises(RuleProblems, match=r"extends 'a\.yaml', which extends this one again"):
        load_rule_base(str(tmp_path / "a.yaml"))


def test_the_version_is_that_of_the_meaning_not_of_the_text():
    spaced = TWO_RULES.replace("slenderness >= 10", "'slenderness  >=  10.0'") + "# a comment\n"
    changed = TWO_RULES.replace("slenderness >= 10", "slenderness > 10")
    base = rule_base_from_text(TWO_RULES)
    assert len(base.version) == 12
    assert rule_base_from_text(spaced).version == base.version
    assert rule_base_from_text(changed).version != base.version
