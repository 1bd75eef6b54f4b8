"""Three-valued logic over what facts may still become.

A condition is true, false or missing (a fact it needs does not exist). While dearer facts are still to be measured
it may become any of several: an *outcome* is the set of what it may become, with the cheapest tier of facts that
would tell. An outcome is a small int, so that `and` and `or` are one table look-up:

    bits 0-2: may become true, false, missing          bits 3-5: tier that would tell, SETTLED for none

Within one value the tables are Kleene's strong ones (S. C. Kleene, Introduction to Metamathematics, 1952, par. 64).
"""

from __future__ import annotations

from collections.abc import Iterable

MAY_BE_TRUE, MAY_BE_FALSE, MAY_BE_MISSING = 1, 2, 4
SETTLED = 7
_TIER_SHIFT = 3
_OUTCOME_BITS = 6

TRUE = MAY_BE_TRUE | SETTLED << _TIER_SHIFT
FALSE = MAY_BE_FALSE | SETTLED << _TIER_SHIFT
MISSING = MAY_BE_MISSING | SETTLED << _TIER_SHIFT


def outcome(may_be: int, tier: int) -> int:
    """The outcome that may become `may_be`, told by `tier`; settled when it can become one thing only."""
    return may_be | (SETTLED if may_be in (1, 2, 4) else tier) << _TIER_SHIFT


def pending(tier: int) -> int:
    """Nothing is known until `tier` is measured."""
    return outcome(MAY_BE_TRUE | MAY_BE_FALSE | MAY_BE_MISSING, tier)


def tier_of(value: int) -> int:
    """The cheapest tier that would tell more about an outcome, or SETTLED."""
    return value >> _TIER_SHIFT


def _kleene_and(a: int, b: int) -> int:
    if MAY_BE_FALSE in (a, b):
        return MAY_BE_FALSE
    return MAY_BE_MISSING if MAY_BE_MISSING in (a, b) else MAY_BE_TRUE


def _swapped(may_be: int) -> int:
    return (may_be & MAY_BE_MISSING) | (may_be & MAY_BE_TRUE) << 1 | (may_be & MAY_BE_FALSE) >> 1


def _and(a: int, b: int) -> int:
    may_be = 0
    for one in (1, 2, 4):
        for other in (1, 2, 4):
            if a & one and b & other:
                may_be |= _kleene_and(one, other)
    return outcome(may_be, min(tier_of(a), tier_of(b)))


NOT = bytes(outcome(_swapped(value & 7), tier_of(value)) for value in range(1 << _OUTCOME_BITS))
"""NOT[a]"""

AND = bytes(_and(a, b) for a in range(1 << _OUTCOME_BITS) for b in range(1 << _OUTCOME_BITS))
"""AND[a << 6 | b]"""

OR = bytes(
    NOT[AND[NOT[a] << _OUTCOME_BITS | NOT[b]]] for a in range(1 << _OUTCOME_BITS) for b in range(1 << _OUTCOME_BITS)
)
"""OR[a << 6 | b]"""

PROVEN = bytes(
    outcome(value & MAY_BE_TRUE | (MAY_BE_FALSE if value & (MAY_BE_FALSE | MAY_BE_MISSING) else 0), tier_of(value))
    for value in range(1 << _OUTCOME_BITS)
)
"""PROVEN[a]: missing counts as false."""


def all_of(outcomes: Iterable[int]) -> int:
    """The conjunction; TRUE for none."""
    result = TRUE
    for value in outcomes:
        result = AND[result << 6 | value]
    return result


def any_of(outcomes: Iterable[int]) -> int:
    """The disjunction; FALSE for none."""
    result = FALSE
    for value in outcomes:
        result = OR[result << 6 | value]
    return result


def at_least(least: int, outcomes: Iterable[int]) -> int:
    """At least `least` of them are true."""
    values = list(outcomes)
    may_be = 0
    surely_true = sum(value & 7 == MAY_BE_TRUE for value in values)
    perhaps_true = sum(bool(value & MAY_BE_TRUE) for value in values)
    surely_not_false = sum(not value & MAY_BE_FALSE for value in values)
    perhaps_not_false = sum(bool(value & (MAY_BE_TRUE | MAY_BE_MISSING)) for value in values)
    if perhaps_true >= least:
        may_be |= MAY_BE_TRUE
    if surely_not_false < least:
        may_be |= MAY_BE_FALSE
    if surely_true < least <= perhaps_not_false and any(value & MAY_BE_MISSING for value in values):
        may_be |= MAY_BE_MISSING
    return outcome(may_be, min((tier_of(value) for value in values), default=SETTLED))
