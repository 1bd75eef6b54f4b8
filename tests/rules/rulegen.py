"""Random rule bases and random nodes, for the properties that must hold for all of them."""

from __future__ import annotations

import random

from kernel.facts import RELATED, TIERS, VOCABULARY, Facts, FactSpec, Value
from rules.definition import CONCLUSIONS

NUMBERS = [spec for spec in VOCABULARY if spec.dimension in ("ratio", "count")]
LENGTHS = [spec for spec in VOCABULARY if spec.dimension == "length"]
BOOLEANS = [spec for spec in VOCABULARY if spec.dimension == "boolean"]
TEXTS = [spec for spec in VOCABULARY if spec.dimension == "text"]

HEAD = """
parameters:
  few: {value: 2, unit: 1}
  half: {value: 0.5, unit: 1}
  thin: {value: 3, unit: mm}
quantities:
  span: first(free_length, prism_length)
  span_ratio: span / section_long
"""


def random_base(random_: random.Random, n_rule: int = 12) -> list[str]:
    """The rules of a base, each as one YAML item, the default among them; words are concluded and used."""
    items = []
    for index in range(3):
        when = _conditions(random_, words=[f"word_{k}" for k in range(index)])
        items.append(f"- {{id: w{index}, when: {when}, then: {{word: word_{index}, because: x}}}}")
    for index in range(n_rule):
        when = _conditions(random_, words=["word_0", "word_1", "word_2"])
        band = random_.choice(["override", "specific", "general", "default"])
        certainty = random_.choice([0.3, 0.5, 0.7, 0.9, 1])
        evidence = f"evidence: {random_.choice('ab')}, " if random_.random() < 0.5 else ""
        unless = f"unless: {_conditions(random_, ['word_1'])}, " if random_.random() < 0.3 else ""
        then = f"then: {{segment: {random_.choice(CONCLUSIONS)}, certainty: {certainty}, because: x}}"
        items.append(f"- {{id: r{index}, priority: {band}, when: {when}, {unless}{evidence}{then}}}")
    items.append("- {id: d, priority: default, then: {segment: brick, certainty: 0.5, because: x}}")
    return items


def base_text(items: list[str]) -> str:
    """A rule file of these rules."""
    return f"name: random{HEAD}rules:\n" + "\n".join(f"  {item}" for item in items)


def _conditions(random_: random.Random, words: list[str]) -> str:
    return "[" + ", ".join(_condition(random_, words, 0) for _ in range(random_.randint(1, 3))) + "]"


def _condition(random_: random.Random, words: list[str], depth: int) -> str:
    kind = random_.randrange(12 if depth < 2 else 8)
    if kind <= 3:
        return f'"{_comparison(random_)}"'
    if kind == 4:
        return random_.choice(BOOLEANS).name
    if kind == 5:
        spec = random_.choice(TEXTS)
        some = ", ".join(random_.sample(spec.choices, 2))
        return f'"{spec.name} {random_.choice(["in", "not in"])} [{some}]"'
    if kind == 6 and words:
        return random_.choice(words)
    if kind <= 7:
        return f'"{random_.choice(NUMBERS + LENGTHS).name} is {random_.choice(["known", "unknown"])}"'
    if kind == 8:
        return f"{{{random_.choice(['any', 'all'])}: {_conditions(random_, words)}}}"
    if kind == 9:
        return f"{{{random_.choice(['not', 'proven'])}: {_condition(random_, words, depth + 1)}}}"
    if kind == 10:
        quantifier = random_.choice(["some", "every", "no", "at least 2", "at most 1"])
        noun = random_.choice(["tool", "child", "neighbour"])
        return f"{{{quantifier} {noun}: {_condition(random_, [], 9)}}}"
    return f'"{_comparison(random_)} {random_.choice(["and", "or"])} not {_comparison(random_)}"'


def _comparison(random_: random.Random) -> str:
    sign = random_.choice(["<", "<=", ">", ">=", "==", "!="])
    if random_.random() < 0.25:
        a, b = random_.sample(LENGTHS, 2)
        right = random_.choice(["thin", f"half * {b.name}", f"min({b.name}, thin)", f"{b.name} - {a.name}", b.name])
        return f"{a.name} {sign} {right}"
    a, b = random_.sample(NUMBERS, 2)
    limits = ["few", "half", "1", f"{b.name} / few", f"sqrt({b.name}) + 1", f"first({b.name}, few)", b.name]
    return f"{a.name} {sign} {random_.choice(limits)}"


def random_facts(random_: random.Random, tier: str | None = None) -> Facts:
    """A node measured up to a random tier; a fact in ten that could be there does not exist."""
    tier = tier or random_.choice(TIERS)
    reached = TIERS.index(tier)
    values = {
        spec.name: _value(random_, spec)
        for spec in VOCABULARY
        if TIERS.index(spec.tier) <= reached and random_.random() < 0.9
    }
    related = {
        name: tuple(_item(random_) for _ in range(random_.randrange(4)))
        for name, spec in RELATED.items()
        if TIERS.index(spec.tier) <= reached and random_.random() < 0.8
    }
    return Facts(values, tier, related)


def _item(random_: random.Random) -> Facts:
    return Facts({spec.name: _value(random_, spec) for spec in VOCABULARY if random_.random() < 0.7}, TIERS[-1])


def _value(random_: random.Random, spec: FactSpec) -> Value:
    """Few different values, so that limits are met exactly, and equal facts come up."""
    if spec.dimension == "boolean":
        return random_.random() < 0.5
    if spec.dimension == "text":
        return random_.choice(spec.choices)
    if spec.dimension == "count":
        return random_.randrange(4)
    return random_.choice([0.0, 0.5, 1.0, 2.0, 3.0, random_.random() * 4.0])
