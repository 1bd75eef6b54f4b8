"""Numbers in fields."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from kernel.deck.header import set_names
from kernel.deck.numbers import fixed_field, free_field
from kernel.errors import DeckError

finite = st.floats(allow_nan=False, allow_infinity=False, min_value=-1e99, max_value=1e99).filter(
    lambda x: x == 0 or abs(x) > 1e-99
)


@given(finite)
def test_a_field_of_sixteen_keeps_ten_digits_and_a_point(value):
    text = fixed_field(value)
    assert len(text) <= 16
    assert "." in text
    assert math.isclose(float(text), value, rel_tol=1e-9, abs_tol=0)


@given(finite)
def test_free_format_loses_nothing(value):
    assert float(free_field(value)) == value


@pytest.mark.parametrize(
    ("value", "text"),
    [(0.0, "0."), (-0.0, "0."), (5.0, "5."), (0.5, ".5"), (-0.25, "-.25"), (7.85e-9, "7.85E-9"), (2.1e5, "210000.")],
)
def test_plain_numbers_look_plain(value, text):
    assert fixed_field(value) == text


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_what_is_no_number_is_refused(value):
    with pytest.raises(DeckError):
        fixed_field(value)


def test_set_names_are_made_unique_and_safe():
    assert set_names(["top plate", "top_plate", "1st", "ä"], 8) == ["TOP_PLAT", "TOP_PL_2", "N1ST", "N_"]


def test_set_names_leave_those_alone_that_the_deck_uses():
    assert set_names(["eall", "EALL", "top"], 60, ["EALL"]) == ["EALL_2", "EALL_3", "TOP"]
