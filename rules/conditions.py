"""`when` and `unless`: lists and words of YAML around expressions.

when:
  - slenderness >= beam_slenderness
  - any: [is_prismatic, volume_deviation <= nearly_prismatic]
  - not: kind in [cone, sphere]
  - some tool: kind == cylinder
  - at least 3 neighbours: [extent_long > node.extent_short]
"""

from __future__ import annotations

import re

from kernel.facts import RELATED, TIERS
from rules.document import Item, Mapping, Scalar, Sequence
from rules.language import Scope, parse_condition
from rules.problems import Collector, did_you_mean
from rules.syntax import All, Any, Condition, Not, Proven, Quantified

_QUANTIFIER = re.compile(r"(some|every|no|at least \d{1,6}|at most \d{1,6}) ([a-z_]+)\Z")
_CONNECTIVES = ("all", "any", "not", "proven")
_SINGULAR = {spec.singular: spec for spec in RELATED.values()}


def read_condition(item: Item, scope: Scope, problems: Collector) -> Condition | None:
    """The condition that a YAML item says: a text, a list (all of them), or one word of the language over others."""
    if isinstance(item, Scalar):
        return parse_condition(item, scope, problems)
    if isinstance(item, Sequence):
        parts = _read_all(item, scope, problems)
        if len(parts) == 1:
            return parts[0]
        return All(tuple(parts), place=item.place)
    if len(item.entries) != 1:
        problems.error(
            item.place, f"{len(item.entries)} keys in one condition, expected one: any, all, not, or a quantifier"
        )
        return None
    ((key, inner),) = item.entries.items()
    return _read_keyed(item, key, inner, scope, problems)


def _read_all(item: Sequence, scope: Scope, problems: Collector) -> list[Condition]:
    parts = [read_condition(part, scope, problems) for part in item.items]
    return [part for part in parts if part is not None]


def _read_keyed(item: Mapping, key: str, inner: Item, scope: Scope, problems: Collector) -> Condition | None:
    place = item.keys[key]
    if key in ("any", "all"):
        if not isinstance(inner, Sequence) or not inner.items:
            problems.error(inner.place, f"`{key}` needs a list of conditions")
            return None
        parts = tuple(_read_all(inner, scope, problems))
        return Any(parts, place=place) if key == "any" else All(parts, place=place)
    if key in ("not", "proven"):
        condition = read_condition(inner, scope, problems)
        if condition is None:
            return None
        return Not(condition, place=place) if key == "not" else Proven(condition, place=place)
    match = _QUANTIFIER.match(key)
    if match is None:
        hint = did_you_mean(key, _CONNECTIVES) or ", expected any, all, not, proven, or one such as `some tool`"
        problems.error(place, f"unknown word {key!r} in a condition{hint}")
        return None
    quantifier, noun = match.groups()
    spec = _SINGULAR.get(noun) or RELATED.get(noun)
    if spec is None:
        known = [*_SINGULAR, *RELATED]
        hint = did_you_mean(noun, known) or f", expected one of {', '.join(known)}"
        problems.error(place, f"unknown thing {noun!r}{hint}")
        return None
    if scope.item is not None:
        problems.error(place, "a quantifier inside a quantifier, expected conditions on the item's own facts")
        return None
    condition = read_condition(inner, scope.inside(spec.name), problems)
    if condition is None:
        return None
    return _quantified(quantifier, spec.name, TIERS.index(spec.tier), condition, item, key)


def _quantified(
    quantifier: str, collection: str, tier: int, condition: Condition, item: Mapping, key: str
) -> Condition:
    place = item.keys[key]

    def at_least(least: int, inner: Condition) -> Condition:
        return Quantified(collection, tier, least, inner, place=place)

    if quantifier == "some":
        return at_least(1, condition)
    if quantifier == "no":
        return Not(at_least(1, condition), place=place)
    if quantifier == "every":
        return Not(at_least(1, Not(condition, place=place)), place=place)
    count = int(quantifier.rsplit(" ", 1)[1])
    return (
        at_least(count, condition)
        if quantifier.startswith("at least")
        else Not(at_least(count + 1, condition), place=place)
    )
