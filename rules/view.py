"""The facts of one node as compiled conditions read them: what does not exist apart from what is not measured yet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import ClassVar, TypeAlias

from kernel.facts import RELATED, TIERS, Facts, Value
from rules.logic import MISSING, SETTLED, pending


class Unknown:
    """Stands for the value of an absent fact: to be told by `tier`, or never where it is SETTLED."""

    __slots__ = ("outcome", "tier")

    def __init__(self, tier: int) -> None:
        """outcome: what a condition on the value comes to."""
        self.tier = tier
        self.outcome = MISSING if tier == SETTLED else pending(tier)


NOTHING = Unknown(SETTLED)
UNKNOWN = tuple(Unknown(tier) for tier in range(len(TIERS)))
ABSENT = tuple(
    tuple(NOTHING if tier <= measured else UNKNOWN[tier] for tier in range(len(TIERS)))
    for measured in range(len(TIERS))
)
"""ABSENT[tier measured][tier of the fact]: what an absent fact is worth."""

ALL_MEASURED = ABSENT[-1]

Evaluated: TypeAlias = "Value | Unknown"


class View:
    """Facts as the closures read them, and the words decided so far."""

    __slots__ = ("absent", "items", "outer", "related", "strengths", "values", "words")

    NOWHERE: ClassVar[View]
    """A view of no facts, for expressions that need none."""

    def __init__(self, facts: Facts) -> None:
        self.values: Mapping[str, Value] = dict(facts)
        self.absent = ABSENT[TIERS.index(facts.tier)]
        self.related = facts.related
        self.items: dict[str, tuple[View, ...]] = {}
        self.words: dict[str, int] = {}
        self.strengths: dict[str, float | None] = {}
        self.outer: View | None = None

    def things(self, collection: str) -> tuple[View, ...] | Unknown:
        """Views of the related things; what is absent of them does not exist."""
        found = self.items.get(collection)
        if found is not None:
            return found
        if collection not in self.related:
            return self.absent[TIERS.index(RELATED[collection].tier)]
        views = tuple(View(facts) for facts in self.related[collection])
        for view in views:
            view.outer, view.absent = self, ALL_MEASURED
        self.items[collection] = views
        return views


View.NOWHERE = View(Facts({}, TIERS[-1]))

Evaluate = Callable[[View], Evaluated]
Match = Callable[[View], int]
Strength = Callable[[View], float | None]
