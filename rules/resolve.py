"""From rules that hold, and rules that may still hold, to one answer: bands, certainty, evidence, preference.

1. A rule of a stronger band wins, whatever its certainty.
2. Inside a band the more certain type wins. Rules of one type add up (1 - product of 1 - c); rules of one evidence
   group count once, the most certain of them.
3. Equal: the type that stands first in PREFERENCE, and the conflict is recorded. Never the order of files.

While a rule may still hold that could change the type, the answer is the cheapest tier that would tell.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from kernel.errors import DefectError
from rules.definition import BANDS, PREFERENCE, Rule

EQUAL_CERTAINTY = 1e-9
"""Certainties nearer than this are equal."""


@dataclass(frozen=True, slots=True)
class Candidate:
    """A type with what speaks for it inside its band. rules: those that hold, most certain first."""

    type: str
    band: str
    certainty: float
    rules: tuple[Rule, ...]


@dataclass(frozen=True, slots=True)
class Verdict:
    """The answer. candidates: best first, the winner among them. conflicts: ties that were resolved."""

    winner: Candidate
    candidates: tuple[Candidate, ...]
    conflicts: tuple[str, ...]


def combined(rules: Iterable[Rule]) -> float:
    """Certainty of several rules for one type, each evidence group counted once."""
    groups: dict[str, float] = {}
    for rule in rules:
        groups[rule.evidence] = max(groups.get(rule.evidence, 0.0), rule.certainty)
    doubt = 1.0
    for _, certainty in sorted(groups.items()):
        doubt *= 1.0 - certainty
    return 1.0 - doubt


def resolve(holding: list[Rule], open_rules: list[tuple[Rule, int]]) -> Verdict | int:
    """The verdict, or the index of the tier that is needed first.

    holding: rules that hold. open_rules: rules that may still hold, each with the cheapest tier that would tell.
    """
    candidates = _ranked(holding)
    best = candidates[0] if candidates else None
    groups: dict[tuple[str, str], list[tuple[Rule, int]]] = {}
    for rule, tier in open_rules:
        if best is None or rule.concludes != best.type:
            groups.setdefault((rule.band, rule.concludes), []).append((rule, tier))
    needed = [
        min(tier for _, tier in members)
        for (band, type_), members in groups.items()
        if best is None or _could_beat(band, type_, [rule for rule, _ in members], best, holding)
    ]
    if needed:
        return min(needed)
    if best is None:
        raise DefectError("no rule holds, not even a default")
    return Verdict(best, tuple(candidates), tuple(_conflicts(candidates)))


def _ranked(holding: list[Rule]) -> list[Candidate]:
    groups: dict[tuple[str, str], list[Rule]] = {}
    for rule in holding:
        groups.setdefault((rule.band, rule.concludes), []).append(rule)
    candidates = [
        Candidate(type_, band, combined(rules), tuple(sorted(rules, key=lambda rule: (-rule.certainty, rule.id))))
        for (band, type_), rules in groups.items()
    ]
    candidates.sort(
        key=lambda c: (-BANDS.index(c.band), -round(c.certainty / EQUAL_CERTAINTY), PREFERENCE.index(c.type))
    )
    return candidates


def _could_beat(band: str, type_: str, members: list[Rule], best: Candidate, holding: list[Rule]) -> bool:
    """Whether `type_`, if all of the open `members` of the band came to hold, would take the place of `best`."""
    if band != best.band:
        return BANDS.index(band) > BANDS.index(best.band)
    allies = [rule for rule in holding if (rule.band, rule.concludes) == (band, type_)]
    highest = round(combined([*allies, *members]) / EQUAL_CERTAINTY)
    certainty = round(best.certainty / EQUAL_CERTAINTY)
    if highest != certainty:
        return highest > certainty
    return PREFERENCE.index(type_) < PREFERENCE.index(best.type)


def _conflicts(candidates: list[Candidate]) -> list[str]:
    """Types that tie with the winner, one line each."""
    best = candidates[0]
    lines = []
    for other in candidates[1:]:
        tied = other.band == best.band and abs(other.certainty - best.certainty) <= EQUAL_CERTAINTY
        if tied and other.type != best.type:
            lines.append(
                f"{best.type} (rule {best.rules[0].id}) and {other.type} (rule {other.rules[0].id}) hold with the same "
                f"priority ({best.band}) and certainty ({best.certainty:.3g}): {best.type} is preferred"
            )
    return lines
