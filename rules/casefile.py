"""Cases: examples with their expected answer, written beside the rules.

cases:
  - {name: just short, expect: brick, facts: {kind: block, slenderness: 9.98}}
  - {name: needs its walls, expect: need walls, tier: prism, facts: {operand_count: 5}}
  - {name: drilled, expect: plate, csg: "difference() { cube([100, 50, 4]); cylinder(h = 9, r = 5); }"}
"""

from __future__ import annotations

from kernel.facts import RELATED, SPECS, TIERS, FactSpec, Value
from rules.definition import CONCLUSIONS, Case
from rules.document import Item, Mapping, Scalar, Sequence, number_of
from rules.problems import Collector, did_you_mean

CASE_KEYS = ("about", "csg", "expect", "facts", "name", "tier")


def read_case(item: Item, rule: str | None, problems: Collector) -> Case | None:
    """One case; None, with the problems noted, where it is wrong."""
    if not isinstance(item, Mapping):
        problems.error(item.place, "a case, expected {name: ..., expect: ..., facts: {...}}")
        return None
    before = len(problems.problems)
    for key, place in item.keys.items():
        if key not in CASE_KEYS:
            problems.error(place, f"unknown key {key!r}{did_you_mean(key, CASE_KEYS) or _expected(CASE_KEYS)}")
    name = item.entries.get("name")
    name_text = name.text if isinstance(name, Scalar) else ""
    if not name_text.strip():
        problems.error(item.place, "a case without `name`, expected a few words that say what it shows")
    tier = _tier(item.entries.get("tier"), problems)
    facts_item, csg_item = item.entries.get("facts"), item.entries.get("csg")
    if (facts_item is None) == (csg_item is None):
        problems.error(item.place, "a case needs either `facts` or `csg`")
        return None
    facts, related = read_facts(facts_item, tier, problems) if facts_item is not None else (None, {})
    csg = csg_item.text if isinstance(csg_item, Scalar) else None
    if csg_item is not None and csg is None:
        problems.error(csg_item.place, "`csg` needs the text of a model")
    expect = _expect(item, csg is not None, problems)
    if len(problems.problems) > before:
        return None
    return Case(name_text, expect, facts, related, csg, tier, rule, item.place)


def _tier(item: Item | None, problems: Collector) -> str:
    if item is None:
        return TIERS[-1]
    text = item.text if isinstance(item, Scalar) else ""
    if text not in TIERS:
        problems.error(item.place, f"unknown tier {text!r}{did_you_mean(text, TIERS) or _expected(TIERS)}")
    return text


def _expect(case: Mapping, is_csg: bool, problems: Collector) -> dict[str, str]:
    """What the case expects, by node path ("/" where only one answer is given)."""
    item = case.entries.get("expect")
    if isinstance(item, Mapping) and is_csg:
        answers = list(item.entries.items())
    elif isinstance(item, Scalar):
        answers = [("/", item)]
    else:
        problems.error(case.place, "a case without `expect`, expected a conclusion such as beam, or need TIER")
        return {}
    expect = {}
    for path, answer in answers:
        text = answer.text if isinstance(answer, Scalar) else ""
        known = CONCLUSIONS if is_csg else (*CONCLUSIONS, *(f"need {tier}" for tier in TIERS))
        if text not in known:
            problems.error(answer.place, f"unknown answer {text!r}{did_you_mean(text, known) or _expected(known)}")
        expect[path] = text
    return expect


def read_facts(
    item: Item, tier: str, problems: Collector
) -> tuple[dict[str, Value], dict[str, tuple[dict[str, Value], ...]]]:
    """Facts as a case writes them, checked against the vocabulary, and those of related things."""
    values: dict[str, Value] = {}
    related: dict[str, tuple[dict[str, Value], ...]] = {}
    if not isinstance(item, Mapping):
        problems.error(item.place, "`facts` needs names with values")
        return values, related
    for name, inner in item.entries.items():
        if name in RELATED:
            if isinstance(inner, Sequence):
                related[name] = tuple(read_facts(part, tier, problems)[0] for part in inner.items)
            else:
                problems.error(inner.place, f"`{name}` needs a list of facts")
            continue
        spec = SPECS.get(name)
        if spec is None:
            problems.error(item.keys[name], f"unknown fact {name!r}{did_you_mean(name, [*SPECS, *RELATED])}")
        elif tier in TIERS and TIERS.index(spec.tier) > TIERS.index(tier):
            problems.error(
                item.keys[name], f"the fact {name!r} is of the tier {spec.tier}, beyond the case's tier {tier}"
            )
        else:
            value = _value(spec, inner, problems)
            if value is not None:
                values[name] = value
    return values, related


def _value(spec: FactSpec, item: Item, problems: Collector) -> Value | None:
    if not isinstance(item, Scalar):
        problems.error(item.place, f"the fact {spec.name!r} needs a single value")
        return None
    if spec.dimension == "text":
        if not spec.choices or item.text in spec.choices:
            return item.text
        hint = did_you_mean(item.text, spec.choices) or _expected(spec.choices)
        problems.error(item.place, f"unknown value {item.text!r}{hint}")
        return None
    if spec.dimension == "boolean":
        if item.is_plain and item.text in ("true", "false"):
            return item.text == "true"
        problems.error(item.place, f"the fact {spec.name!r} is true or false, found {item.text!r}")
        return None
    number = number_of(item)
    if number is None:
        problems.error(item.place, f"the fact {spec.name!r} is a number, found {item.text!r}")
        return None
    if spec.dimension == "count":
        if number >= 0 and number.is_integer():
            return int(number)
        problems.error(item.place, f"the fact {spec.name!r} counts, found {item.text!r}")
        return None
    return number


def _expected(names: tuple[str, ...]) -> str:
    return f", expected one of {', '.join(names)}"
