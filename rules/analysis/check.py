"""`csgmesh rules check`: errors of the files, and what is sound but surely not meant.

- unreachable: a rule that holds for no node;
- shadowed: whenever it holds, a stronger rule holds that concludes something else;
- redundant: whenever it holds, a rule at least as strong holds that concludes the same;
- contradictory: two rules hold together with equal priority and certainty and conclude different things;
- unused: a parameter, quantity or word that no rule uses;
- gap: where no rule but a default speaks.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Any

from kernel.errors import Place, RuleError
from rules.analysis.regions import Box, Regions, TooManyBoxes
from rules.definition import BANDS, PREFERENCE, Rule
from rules.engine import RuleBase, load_rule_base, rule_base_from_text
from rules.problems import RuleProblems
from rules.resolve import EQUAL_CERTAINTY, combined
from rules.syntax import ParameterRef, QuantityRef, WordRef, text_of, walk
from rules.template import Field

MAX_GAPS = 12
MAX_GAP_BOXES = 3_000


@dataclass(frozen=True, slots=True)
class Finding:
    """One thing to look at. severity: error, warning or note."""

    kind: str
    severity: str
    place: Place | None
    message: str

    def __str__(self) -> str:
        where = f"{self.place}: " if self.place else ""
        return f"{where}{self.severity}: {self.kind}: {self.message}"


@dataclass(frozen=True, slots=True)
class CheckReport:
    """All findings of one rule base, errors first. name, version: empty where it could not be read."""

    name: str
    version: str
    n_rule: int
    findings: tuple[Finding, ...]

    @property
    def ok(self) -> bool:
        """No errors; warnings are for the author to judge."""
        return not any(finding.severity == "error" for finding in self.findings)

    def to_text(self) -> str:
        """For a terminal."""
        head = f"{self.name} {self.version}: {self.n_rule} rules, " if self.version else ""
        counts = ", ".join(_counted(self.findings, severity) for severity in ("error", "warning", "note"))
        return "\n".join([f"{head}{counts}", *map(str, self.findings)])

    def to_json(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "name": self.name,
            "version": self.version,
            "rules": self.n_rule,
            "ok": self.ok,
            "findings": [
                {
                    "kind": finding.kind,
                    "severity": finding.severity,
                    "file": finding.place.file if finding.place else None,
                    "line": finding.place.line if finding.place else None,
                    "column": finding.place.column if finding.place else None,
                    "message": finding.message,
                }
                for finding in self.findings
            ],
        }


def _counted(findings: tuple[Finding, ...], severity: str) -> str:
    count = sum(finding.severity == severity for finding in findings)
    return f"{count} {severity}{'' if count == 1 else 's'}"


def check(path: str | None = None) -> CheckReport:
    """Check the rule base at `path`; wrong files are findings, not exceptions."""
    try:
        return check_base(load_rule_base(path))
    except RuleError as error:
        return _unreadable(error)


def check_text(text: str, name: str = "-") -> CheckReport:
    """Check the rule base that `text` is."""
    try:
        return check_base(rule_base_from_text(text, name))
    except RuleError as error:
        return _unreadable(error)


def _unreadable(error: RuleError) -> CheckReport:
    if isinstance(error, RuleProblems):
        findings = tuple(
            Finding("error", problem.severity, problem.place, problem.message) for problem in error.problems
        )
    else:
        findings = (Finding("error", "error", error.place, error.message),)
    return CheckReport("", "", 0, findings)


def check_base(base: RuleBase) -> CheckReport:
    """Findings on a rule base that reads well."""
    findings = _unused(base)
    regions = Regions(base.compiler)
    boxes: dict[str, list[Box]] = {}
    for rule in base.rules:
        try:
            boxes[rule.id] = regions.boxes(rule.condition)
        except TooManyBoxes:
            findings.append(
                Finding("not analysed", "note", rule.place, f"the rule {rule.id!r} has too many alternatives")
            )
            continue
        if not boxes[rule.id]:
            findings.append(
                Finding(
                    "unreachable", "warning", rule.place, f"the rule {rule.id!r} never holds: {text_of(rule.condition)}"
                )
            )
    live = [rule for rule in base.rules if rule.segment is not None and boxes.get(rule.id)]
    findings += _shadowed(base, live, boxes)
    findings += _contradictory(live, boxes)
    findings += _gaps(live, boxes)
    order = {"error": 0, "warning": 1, "note": 2}
    findings.sort(key=lambda f: (order[f.severity], f.kind, str(f.place), f.message if f.kind != "gap" else ""))
    return CheckReport(base.name, base.version, len(base.rules), tuple(findings))


def _unused(base: RuleBase) -> list[Finding]:
    used: set[tuple[type, str]] = set()
    for rule in base.rules:
        parts = list(walk(rule.condition))
        parts += [part for field in rule.because.parts if isinstance(field, Field) for part in walk(field.expression)]
        used |= {(type(part), part.name) for part in parts if isinstance(part, ParameterRef | QuantityRef | WordRef)}
    findings = []
    for name, parameter in base.parameters.items():
        if (ParameterRef, name) not in used:
            findings.append(Finding("unused", "warning", parameter.place, f"no rule uses the parameter {name!r}"))
    for name, quantity in base.definition.quantities.items():
        if (QuantityRef, name) not in used:
            findings.append(Finding("unused", "warning", quantity.place, f"no rule uses the quantity {name!r}"))
    for word in base.definition.words:
        if (WordRef, word) not in used:
            place = next(rule.place for rule in base.rules if rule.word == word)
            findings.append(Finding("unused", "warning", place, f"no rule uses the word {word!r}"))
    return findings


def _shadowed(base: RuleBase, live: list[Rule], boxes: dict[str, list[Box]]) -> list[Finding]:
    """Rules that hold only where others hold that are surely stronger."""
    findings = []
    for rule in live:
        if any(box.is_part for box in boxes[rule.id]):
            continue
        stronger = [other for other in live if other.id != rule.id and _surely_beats(other, rule, live)]
        allies = [
            other
            for other in live
            if other.id != rule.id and other.segment == rule.segment and _at_least_as_strong(other, rule)
        ]
        for kind, others in (("shadowed", stronger), ("redundant", allies)):
            covering = _covering(boxes[rule.id], others, boxes)
            if covering:
                names = " and ".join(repr(name) for name in covering)
                rules, conclude = ("rules", "conclude") if len(covering) > 1 else ("rule", "concludes")
                what = "something else" if kind == "shadowed" else "the same"
                message = f"whenever the rule {rule.id!r} holds, the stronger {rules} {names} {conclude} {what}"
                findings.append(Finding(kind, "warning", rule.place, message))
                break
    return findings


def _covering(own: list[Box], others: list[Rule], boxes: dict[str, list[Box]]) -> list[str]:
    """Ids of rules of which one contains each of the boxes; empty where one box is in none of them."""
    covering = []
    for box in own:
        found = next((rule.id for rule in others if any(other.contains(box) for other in boxes[rule.id])), None)
        if found is None:
            return []
        covering.append(found)
    return sorted(set(covering))


def _surely_beats(other: Rule, rule: Rule, live: list[Rule]) -> bool:
    """Whether `other`, whenever it holds, keeps `rule`'s type from winning by this rule's band."""
    if other.segment == rule.segment:
        return False
    band, own_band = BANDS.index(other.band), BANDS.index(rule.band)
    if band != own_band:
        return band > own_band
    highest = combined(ally for ally in live if (ally.band, ally.segment) == (rule.band, rule.segment))
    if abs(other.certainty - highest) <= EQUAL_CERTAINTY:
        return PREFERENCE.index(other.concludes) < PREFERENCE.index(rule.concludes)
    return other.certainty > highest


def _at_least_as_strong(other: Rule, rule: Rule) -> bool:
    """Whether `rule` adds nothing where `other` holds: same evidence, or a stronger band."""
    if BANDS.index(other.band) != BANDS.index(rule.band):
        return BANDS.index(other.band) > BANDS.index(rule.band)
    if other.evidence != rule.evidence:
        return False
    return (other.certainty, other.id) > (rule.certainty, rule.id)


def _contradictory(live: list[Rule], boxes: dict[str, list[Box]]) -> list[Finding]:
    findings = []
    for one, other in combinations(live, 2):
        if one.band != other.band or one.segment == other.segment:
            continue
        if abs(one.certainty - other.certainty) > EQUAL_CERTAINTY:
            continue
        both = next((met for a in boxes[one.id] for b in boxes[other.id] if (met := a.meet(b)) is not None), None)
        if both is not None:
            preferred = min((one.concludes, other.concludes), key=PREFERENCE.index)
            message = (
                f"the rules {one.id!r} ({one.segment}) and {other.id!r} ({other.segment}) hold together with equal "
                f"priority and certainty, e.g. {both.example()}; {preferred} is preferred"
            )
            findings.append(Finding("contradictory", "warning", one.place, message))
    return findings


def _gaps(live: list[Rule], boxes: dict[str, list[Box]]) -> list[Finding]:
    """Where, with every fact known, only the rules of the default band speak."""
    speaking = [box for rule in live if rule.band != "default" for box in boxes[rule.id]]
    speaking.sort(key=lambda box: (len(box.extents), box.text()))
    left = [Box()]
    for box in speaking:
        left = [part for piece in left for part in piece.less(box)]
        if len(left) > MAX_GAP_BOXES:
            return [Finding("gap", "note", None, "the region where only the default speaks has too many parts to list")]
    left = [box for box in left if not any(other is not box and other.contains(box) for other in left)]
    left.sort(key=lambda box: (len(box.extents), box.text()))
    findings = [Finding("gap", "note", None, f"only the default speaks where {box.text()}") for box in left[:MAX_GAPS]]
    if len(left) > MAX_GAPS:
        findings.append(Finding("gap", "note", None, f"and in {len(left) - MAX_GAPS} more regions"))
    return findings
