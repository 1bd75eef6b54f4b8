"""Three-valued logic: Kleene's tables, and what is still open."""

from __future__ import annotations

import itertools

import pytest

from rules.logic import (
    AND,
    FALSE,
    MAY_BE_FALSE,
    MAY_BE_MISSING,
    MAY_BE_TRUE,
    MISSING,
    NOT,
    OR,
    PROVEN,
    SETTLED,
    TRUE,
    all_of,
    any_of,
    at_least,
    outcome,
    pending,
    tier_of,
)

T, F, M = TRUE, FALSE, MISSING


@pytest.mark.parametrize(
    ("a", "b", "both", "either"),
    [(T, T, T, T), (T, F, F, T), (T, M, M, T), (F, F, F, F), (F, M, F, M), (M, M, M, M)],
)
def test_and_and_or_follow_kleenes_strong_tables_in_either_order(a, b, both, either):
    assert AND[a << 6 | b] == AND[b << 6 | a] == both
    assert OR[a << 6 | b] == OR[b << 6 | a] == either


def test_not_keeps_missing_and_proven_makes_it_false():
    assert [NOT[v] for v in (T, F, M)] == [F, T, M]
    assert [PROVEN[v] for v in (T, F, M)] == [T, F, F]


def test_what_is_pending_is_told_by_the_cheapest_tier():
    both = AND[pending(3) << 6 | pending(1)]
    assert both == pending(1)
    assert tier_of(both) == 1


def test_a_false_part_settles_a_conjunction_and_a_true_one_a_disjunction():
    assert AND[pending(2) << 6 | F] == F
    assert OR[pending(2) << 6 | T] == T
    assert tier_of(F) == SETTLED


def test_missing_and_pending_can_only_become_false_or_missing():
    assert AND[pending(2) << 6 | M] == outcome(MAY_BE_FALSE | MAY_BE_MISSING, 2)
    assert OR[pending(2) << 6 | M] == outcome(MAY_BE_TRUE | MAY_BE_MISSING, 2)


def test_tables_agree_with_all_that_their_parts_may_become():
    singles = {MAY_BE_TRUE: T, MAY_BE_FALSE: F, MAY_BE_MISSING: M}
    outcomes = [outcome(mask, 1) for mask in range(1, 8)]
    for a, b in itertools.product(outcomes, outcomes):
        expected = 0
        for bit_a, bit_b in itertools.product(singles, singles):
            if a & bit_a and b & bit_b:
                expected |= AND[singles[bit_a] << 6 | singles[bit_b]] & 7
        assert AND[a << 6 | b] & 7 == expected


def test_all_of_nothing_holds_and_any_of_nothing_fails():
    assert all_of([]) == TRUE
    assert any_of([]) == FALSE


@pytest.mark.parametrize(
    ("least", "outcomes", "expected"),
    [
        (1, [], F),
        (0, [], T),
        (2, [T, F, T], T),
        (2, [T, F, F], F),
        (2, [T, M, F], M),
        (2, [T, T, M], T),
        (2, [T, pending(3)], outcome(MAY_BE_TRUE | MAY_BE_FALSE | MAY_BE_MISSING, 3)),
        (1, [T, pending(3)], T),
        (3, [T, pending(3)], F),
    ],
)
def test_at_least_counts_what_is_true_and_what_may_be(least, outcomes, expected):
    assert at_least(least, outcomes) == expected
