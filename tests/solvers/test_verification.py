"""The quick cases of docs/verification.md hold on every run; `make verification` runs them all."""

import pytest
from verification import cases, common, joined, mixed
from verification.page import page

pytestmark = pytest.mark.solver


@pytest.mark.parametrize(
    "case", [cases.plates, mixed.portal, mixed.halves, cases.hole, joined.joint_stress], ids=lambda case: case.__name__
)
def test_csgmesh_and_two_solvers_agree_with_the_closed_form(case):
    rows = list(case())
    assert rows
    outside = [f"{row.case} {row.representation} {row.solver} {row.error:+.2%}" for row in rows if not row.holds]
    assert not outside


def test_the_page_shows_refusals_and_marks_what_is_outside():
    row = common.Row("bar", "tip, mm", "beam", "MYSTRAN", 1.2, 1.0, 0.1, 60)
    refused = common.Row("bar", "tip, mm", "beam", "CalculiX", None, 1.0, 0.1, 60, "refused: why")
    text = page({"cantilevers": [row, refused]})
    assert "+20.00% **outside**" in text
    assert "| refused |" in text
    assert "refused: why" in text
