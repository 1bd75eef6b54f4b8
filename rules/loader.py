"""From the merged YAML of a rule base to its Definition: every name, unit and key checked, all errors at once."""

from __future__ import annotations

import re
from dataclasses import replace

from kernel.errors import Place
from kernel.facts import SPECS, TIERS
from kernel.plan import DIVISIONS, SEGMENT_TYPES
from rules.casefile import read_case
from rules.conditions import read_condition
from rules.definition import BANDS, CONCLUSIONS, Case, Definition, Rule
from rules.document import Item, Mapping, Scalar, Sequence
from rules.items import ItemReader
from rules.language import Scope
from rules.layers import Merged, merge_path, merge_text
from rules.numbers import NumberReader
from rules.problems import Collector, did_you_mean
from rules.syntax import (
    All,
    Condition,
    Expression,
    FactRef,
    Member,
    Not,
    ParameterRef,
    Proven,
    QuantityRef,
    WordRef,
    walk,
)
from rules.template import Template, parse_template

MAX_RULES = 1_000
RULE_KEYS = ("about", "applies_to", "cases", "evidence", "id", "priority", "source", "then", "unless", "when")
THEN_KEYS = ("because", "certainty", "segment", "word")
_ID = re.compile(r"[A-Za-z][A-Za-z0-9_-]*\Z")


def read_definition(path: str | None) -> Definition:
    """The rule base at `path` (a file or a folder), None for the one that comes with csgmesh.

    RuleProblems: all that is wrong with it.
    """
    problems = Collector()
    return _finished(merge_path(path, problems), problems)


def read_definition_text(text: str, name: str) -> Definition:
    """The rule base in `text`; `name` is shown in places. It may extend `base`, but no file."""
    problems = Collector()
    return _finished(merge_text(text, name, problems), problems)


def _finished(merged: Merged, problems: Collector) -> Definition:
    definition = _Loader(merged, problems).definition()
    problems.raise_if_any()
    return definition


class _Loader(ItemReader):
    def __init__(self, merged: Merged, problems: Collector) -> None:
        super().__init__(problems)
        self._merged = merged

    def definition(self) -> Definition:
        numbers = NumberReader(self.problems)
        parameters = numbers.parameters(self._merged)
        words = self._words()
        dimensions = {name: parameter.dimension for name, parameter in parameters.items()}
        quantities, typed = numbers.quantities(self._merged, dimensions, words)
        scope = Scope(dimensions, typed, words)
        names: dict[str, Expression] = {name: FactRef(name, TIERS.index(spec.tier)) for name, spec in SPECS.items()}
        names |= {name: ParameterRef(name) for name in parameters}
        names |= {name: QuantityRef(name, value.expression) for name, value in typed.items()}
        if len(self._merged.rules) > MAX_RULES:
            first = next(iter(self._merged.rules.values())).place
            self.error(first, f"{len(self._merged.rules)} rules, expected at most {MAX_RULES}")
            self.problems.raise_if_any()
        drafts: list[Rule] = []
        cases: list[Case] = [
            case for item in self._merged.cases if (case := read_case(item, None, self.problems)) is not None
        ]
        for identity, item in sorted(self._merged.rules.items()):
            rule = self._rule(identity, item, scope, names)
            if rule is not None:
                drafts.append(rule)
            for case_item in self.listed(item, "cases"):
                if (case := read_case(case_item, identity, self.problems)) is not None:
                    cases.append(case)
        self._check_default(drafts)
        word_levels, rules = self._levelled(drafts)
        return Definition(
            self._merged.name,
            self._merged.about,
            parameters,
            quantities,
            word_levels,
            tuple(rules),
            tuple(sorted(cases, key=lambda case: (case.rule or "", case.name))),
            tuple(self._merged.files),
        )

    # ---- rules

    def _words(self) -> frozenset[str]:
        words = set()
        for item in self._merged.rules.values():
            then = item.entries.get("then")
            word = then.entries.get("word") if isinstance(then, Mapping) else None
            if isinstance(word, Scalar):
                words.add(word.text)
                self.check_name(word.text, word.place)
        return frozenset(words)

    def _rule(self, identity: str, item: Mapping, scope: Scope, names: dict[str, Expression]) -> Rule | None:
        place = item.entries["id"].place
        self.check_keys(item, RULE_KEYS)
        if not _ID.match(identity):
            self.error(place, f"the id {identity!r}, expected letters, digits, - and _")
        before = len(self.problems.problems)
        band = self.choice(item, "priority", BANDS, "general")
        condition = self._condition(item, scope)
        then = item.entries.get("then")
        if not isinstance(then, Mapping):
            self.error(
                place, f"the rule {identity!r} has no `then`, expected {{segment: ..., certainty: ..., because: ...}}"
            )
            return None
        self.check_keys(then, THEN_KEYS)
        segment, word = self._concluded(then)
        certainty = 1.0
        if word is None:
            found = self.number(then.entries.get("certainty"), then.place, f"the certainty of the rule {identity!r}")
            certainty = found if found is not None else 1.0
            if not 0.0 < certainty <= 1.0:
                self.error(
                    then.entries["certainty"].place, f"a certainty of {certainty:g}, expected above 0 and at most 1"
                )
        elif "certainty" in then.entries:
            self.error(then.keys["certainty"], "a word is concluded without certainty, expected none here")
        because = self._because(then, names, identity)
        if len(self.problems.problems) > before:
            return None
        return Rule(
            identity,
            band,
            condition,
            segment,
            word,
            certainty,
            because,
            self.text(item.entries.get("evidence")) or f"rule {identity}",
            self.text(item.entries.get("source")),
            0,
            place,
        )

    def _concluded(self, then: Mapping) -> tuple[str | None, str | None]:
        given = [key for key in ("segment", "word") if key in then.entries]
        if len(given) != 1:
            self.error(then.place, "`then` needs either `segment` or `word`")
            return None, None
        item = then.entries[given[0]]
        if not isinstance(item, Scalar):
            self.error(item.place, f"`{given[0]}` needs a name")
            return None, None
        if given[0] == "word":
            return None, item.text
        if item.text not in CONCLUSIONS:
            hint = did_you_mean(item.text, CONCLUSIONS)
            types, divisions = ", ".join(SEGMENT_TYPES), ", ".join(DIVISIONS)
            self.error(item.place, f"unknown segment {item.text!r}{hint or f', expected one of {types}, {divisions}'}")
        return item.text, None

    def _because(self, then: Mapping, names: dict[str, Expression], identity: str) -> Template:
        item = then.entries.get("because")
        if isinstance(item, Scalar) and item.text.strip():
            return parse_template(item, names, self.problems)
        self.error(
            item.place if item else then.place, f"the rule {identity!r} has no `because`, expected the reason as a text"
        )
        return Template(())

    def _condition(self, item: Mapping, scope: Scope) -> Condition:
        """`applies_to`, `when` and `unless` as one."""
        parts: list[Condition] = []
        if "applies_to" in item.entries:
            kinds = self._kinds(item.entries["applies_to"])
            parts.append(Member(FactRef("kind", 0), kinds, place=item.keys["applies_to"]))
        if "when" in item.entries:
            when = read_condition(item.entries["when"], scope, self.problems)
            if isinstance(when, All):
                parts.extend(when.conditions)
            elif when is not None:
                parts.append(when)
        if "unless" in item.entries:
            exception = read_condition(item.entries["unless"], scope, self.problems)
            if exception is not None:
                place = item.keys["unless"]
                parts.append(Not(Proven(exception, place=place), place=place))
        return parts[0] if len(parts) == 1 else All(tuple(parts), place=item.place)

    def _kinds(self, item: Item) -> tuple[str, ...]:
        known = SPECS["kind"].choices
        items = item.items if isinstance(item, Sequence) else (item,)
        kinds = []
        for part in items:
            text = part.text if isinstance(part, Scalar) else ""
            if text not in known:
                hint = did_you_mean(text, known) or f", expected some of {', '.join(known)}"
                self.error(part.place, f"unknown kind {text!r}{hint}")
            kinds.append(text)
        return tuple(sorted(set(kinds)))

    def _check_default(self, rules: list[Rule]) -> None:
        """There must be an answer for every node."""
        if self.problems.problems:
            return
        if not any(rule.band == "default" and rule.segment and rule.condition == All(()) for rule in rules):
            place = rules[0].place if rules else Place(self._merged.files[-1] if self._merged.files else "-", 1, 1)
            place = Place(place.file, 1, 1)
            self.error(
                place,
                "no default, expected a rule with `priority: default` and no `when`, for nodes of which no rule speaks",
            )

    def _levelled(self, drafts: list[Rule]) -> tuple[dict[str, int], list[Rule]]:
        """Words are decided before the rules that use them."""
        uses = {rule.id: {part.name for part in walk(rule.condition) if isinstance(part, WordRef)} for rule in drafts}
        makers: dict[str, list[Rule]] = {}
        for rule in drafts:
            if rule.word:
                makers.setdefault(rule.word, []).append(rule)
        levels: dict[str, int] = {}
        waiting = set(makers)
        while waiting:
            ready = sorted(word for word in waiting if all(uses[rule.id] <= levels.keys() for rule in makers[word]))
            if not ready:
                circle = sorted(waiting)
                self.error(makers[circle[0]][0].place, f"words conclude one another in a circle: {', '.join(circle)}")
                return {}, drafts
            for word in ready:
                needed = [levels[name] + 1 for rule in makers[word] for name in uses[rule.id]]
                levels[word] = max(needed, default=0)
            waiting.difference_update(ready)
        rules = []
        for rule in drafts:
            if rule.word:
                level = levels[rule.word]
            else:
                level = max((levels.get(name, 0) + 1 for name in uses[rule.id]), default=0)
            rules.append(replace(rule, level=level))
        return dict(sorted(levels.items())), rules
