"""`csgmesh rules test`: every case of a rule base, run.

Cases in facts need only the rules. Cases in CSG need the kernel, which the caller lends:

    def describe(text: str, decide: Decide) -> Plan: ...        # read, evaluate, partition
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from kernel.errors import CsgmeshError
from kernel.facts import Facts
from kernel.plan import Conclusion, Decide, Need, Plan
from rules.definition import Case
from rules.engine import RuleBase

Describe = Callable[[str, Decide], Plan]
"""From a model's text and the deciding side to the plan, with every question and answer."""


@dataclass(frozen=True, slots=True)
class CaseResult:
    """One case. expected, found: one answer, or `path: answer, ...` for a model. message: what went wrong, if so."""

    name: str
    rule: str | None
    place: str
    passed: bool
    expected: str
    found: str
    message: str = ""


@dataclass(frozen=True, slots=True)
class CaseReport:
    """All cases of one base. not_run: cases in CSG where nobody could describe them."""

    name: str
    version: str
    results: tuple[CaseResult, ...]
    not_run: tuple[str, ...]

    @property
    def ok(self) -> bool:
        """Every case that was run gave what it expects."""
        return all(result.passed for result in self.results)

    def to_text(self) -> str:
        """For a terminal: failures in full, then the count."""
        lines = [
            f"{result.place}: {result.name}: expected {result.expected}, found {result.found}{result.message}"
            for result in self.results
            if not result.passed
        ]
        passed = sum(result.passed for result in self.results)
        lines.append(f"{self.name} {self.version}: {passed} of {len(self.results)} cases passed")
        if self.not_run:
            lines.append(f"not run, being models: {', '.join(self.not_run)}")
        return "\n".join(lines)

    def to_json(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "name": self.name,
            "version": self.version,
            "ok": self.ok,
            "cases": [
                {
                    "name": result.name,
                    "rule": result.rule,
                    "place": result.place,
                    "passed": result.passed,
                    "expected": result.expected,
                    "found": result.found,
                    "message": result.message.strip(" ;"),
                }
                for result in self.results
            ],
            "not_run": list(self.not_run),
        }


def facts_of(case: Case) -> Facts:
    """The facts of a case that is written in facts."""
    related = {name: tuple(Facts(item, case.tier) for item in items) for name, items in case.related.items()}
    return Facts(case.facts or {}, case.tier, related)


def said(answer: Conclusion | Need) -> str:
    """An answer as a case expects it."""
    return f"need {answer.tier}" if isinstance(answer, Need) else answer.type


def run_cases(base: RuleBase, describe: Describe | None = None) -> CaseReport:
    """Run all cases; those in CSG through `describe`, and not at all without it."""
    results, not_run = [], []
    for case in base.definition.cases:
        if case.facts is not None:
            results.append(_run_facts(base, case))
        elif describe is not None:
            results.append(_run_model(base, case, describe))
        else:
            not_run.append(case.name)
    return CaseReport(base.name, base.version, tuple(results), tuple(not_run))


def _run_facts(base: RuleBase, case: Case) -> CaseResult:
    answer = base.decide(facts_of(case))
    expected, found = case.expect["/"], said(answer)
    message = ""
    if found != expected and isinstance(answer, Conclusion):
        against = next((item.because for item in answer.rejected if item.type == expected), "")
        message = f" by {answer.rule} ({answer.because})" + (f"; {expected}: {against}" if against else "")
    return CaseResult(case.name, case.rule, str(case.place), found == expected, expected, found, message)


def _run_model(base: RuleBase, case: Case, describe: Describe) -> CaseResult:
    expected = _listed(case.expect)
    try:
        plan = describe(case.csg or "", base.decide)
    except CsgmeshError as error:
        return CaseResult(case.name, case.rule, str(case.place), False, expected, "an error", f": {error}")
    found = {}
    for path in case.expect:
        decision = plan.of(path)
        found[path] = decision.type if decision is not None else "not asked"
    return CaseResult(case.name, case.rule, str(case.place), found == dict(case.expect), expected, _listed(found))


def _listed(answers: Any) -> str:
    if list(answers) == ["/"]:
        return str(answers["/"])
    return ", ".join(f"{path}: {answer}" for path, answer in answers.items())
