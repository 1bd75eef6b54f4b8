"""The plan that the kernel accepts: conclusions, overrides, and the record of what was asked and answered."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Protocol

from kernel.facts import Facts

SEGMENT_TYPES = ("beam", "plate", "cylinder_plate", "brick")
"""A node that becomes one segment."""

DIVISIONS = ("plates", "split", "cut")
"""A node that others decide for: its walls, its operands, or its pieces after cuts at necks."""

OVERRIDES = (*SEGMENT_TYPES, "plates", "split", "auto")
"""What a user may say of a node; `auto` takes the override back."""


@dataclass(frozen=True, slots=True)
class Rejected:
    """An alternative that was not chosen: its type, the rule that proposes it, and what spoke against it."""

    type: str
    rule: str
    because: str


@dataclass(frozen=True, slots=True)
class Conclusion:
    """What the rules say of one node: one of SEGMENT_TYPES or DIVISIONS.

    certainty: 0..1. margin: distance to the nearest threshold as a share of it, or None where no number decided.
    conflicts: one line for each contradiction that was resolved, and how.
    """

    type: str
    rule: str
    certainty: float
    because: str
    rejected: tuple[Rejected, ...] = ()
    margin: float | None = None
    conflicts: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Need:
    """The rules cannot conclude yet: they need the facts of `tier`."""

    tier: str


class Decide(Protocol):
    """The deciding side, as the kernel sees it. Must be a function of the facts alone."""

    def __call__(self, facts: Facts) -> Conclusion | Need:
        """A conclusion, or the tier of facts that is needed first; with all tiers known, always a conclusion."""
        ...


@dataclass(frozen=True, slots=True)
class Override:
    """A user's decision, pinned beside the rules."""

    type: str
    author: str = "user"
    reason: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Decision:
    """One question and its answer.

    node: path of the CSG node, with "#n" behind it for the n-th piece of a node that was divided.
    origin: "rule" or "override". by_rule: what the rules say, also where an override stands.
    """

    node: str
    facts: Facts
    type: str
    origin: str
    by_rule: Conclusion
    override: Override | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Plan:
    """Every decision that was taken, in the order of the walk from the root."""

    decisions: tuple[Decision, ...]
    overrides: Mapping[str, Override] = field(default_factory=dict)

    def of(self, node: str) -> Decision | None:
        """The decision about `node`, or None where it was never asked about."""
        return next((decision for decision in self.decisions if decision.node == node), None)
