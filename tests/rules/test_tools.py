"""A rule about how a tool stands to its part decides whole models: the example of rules/README.md."""

from __future__ import annotations

import textwrap
from pathlib import Path

import pytest

from app.rulework import plan_of
from rules.analysis import run_cases
from rules.engine import rule_base_from_text

README = Path(__file__).parents[2] / "rules" / "README.md"

ROD = "cylinder($fn = 0, h = {h}, r1 = {r}, r2 = {r}, center = false);"
RAISED = "multmatrix([[1, 0, 0, {x}], [0, 1, 0, {x}], [0, 0, 1, {z}], [0, 0, 0, 1]]) {{ {body} }}"


def example() -> str:
    """The rule as the README writes it, on top of the own rule base."""
    text = README.read_text(encoding="utf-8")
    start = text.rindex("    rules:\n", 0, text.index("bored-part-is-brick"))
    block = text[start : text.index("\n\n", start)]
    return "name: office\nextends: base\n" + textwrap.dedent(block) + "\n"


def bored(radius: float, x: float, z: float) -> str:
    """A short pipe, or what becomes of it when the bore stands elsewhere."""
    tool = RAISED.format(x=x, z=z, body=ROD.format(h=200, r=radius))
    return f"difference() {{ {ROD.format(h=150, r=60)} {tool} }}"


@pytest.mark.parametrize(
    ("model", "rule"),
    [
        (bored(56, 0, -1), "bored-part-is-brick"),
        (bored(56, 0, 4), "all-walls-are-plates"),  # a cup: coaxial, not through
        (bored(20, 10, -1), "the-rest-is-brick"),  # through, beside the axis
    ],
)
def test_the_rule_in_the_readme_decides_bored_parts_and_no_others(model, rule):
    (decision, *_) = plan_of(model, rule_base_from_text(example(), "office").decide).decisions
    assert decision.by_rule.rule == rule


def test_the_case_in_the_readme_passes():
    report = run_cases(rule_base_from_text(example(), "office"), plan_of)
    assert [result.passed for result in report.results if result.rule == "bored-part-is-brick"] == [True]
