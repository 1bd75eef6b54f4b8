"""From the merged YAML of a rule base to its Definition: every name, unit and key checked, all errors at once."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import islice

from kernel.errors import Place
from kernel.facts import SPECS, TIERS
from kernel.plan import DIVISIONS, SEGMENT_TYPES
from rules.casefile import read_case
from rules.conditions import read_condition
from rules.definition import BANDS, CONCLUSIONS, LENGTH_UNITS, Case, Definition, Parameter, Quantity, Rule
from rules.document import Item, Mapping, Scalar, Sequence, number_of
from rules.language import DIMENSIONS, Scope, Typed, parse_quantity
from rules.layers import Merged, merge_path, merge_text
from rules.problems import Collector, did_you_mean
from rules.syntax import (
    FUNCTIONS,
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
MAX_QUANTITY_PARTS = 500
"""Parts of a quantity when the quantities that it uses are put in: each may double the one before."""

PARAMETER_KEYS = ("meaning", "range", "source", "unit", "value")
QUANTITY_KEYS = ("meaning", "value")
RULE_KEYS = ("about", "applies_to", "cases", "evidence", "id", "priority", "source", "then", "unless", "when")
THEN_KEYS = ("because", "certainty", "segment", "word")
RESERVED = frozenset(
    ("and", "or", "not", "in", "is", "known", "unknown", "proven", "node", "true", "false", *SPECS, *FUNCTIONS)
)

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*\Z")
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


class _Loader:
    def __init__(self, merged: Merged, problems: Collector) -> None:
        self._merged = merged
        self._problems = problems
        self._error = problems.error

    def definition(self) -> Definition:
        parameters = {
            name: parameter
            for name, layers in self._merged.parameters.items()
            if (parameter := self._parameter(name, layers)) is not None
        }
        words = self._words()
        dimensions = {name: parameter.dimension for name, parameter in parameters.items()}
        quantities, typed = self._quantities(dimensions, words)
        scope = Scope(dimensions, typed, words)
        names: dict[str, Expression] = {name: FactRef(name, TIERS.index(spec.tier)) for name, spec in SPECS.items()}
        names |= {name: ParameterRef(name) for name in parameters}
        names |= {name: QuantityRef(name, value.expression) for name, value in typed.items()}
        if len(self._merged.rules) > MAX_RULES:
            first = next(iter(self._merged.rules.values())).place
            self._error(first, f"{len(self._merged.rules)} rules, expected at most {MAX_RULES}")
            self._problems.raise_if_any()
        drafts: list[Rule] = []
        cases: list[Case] = [
            case for item in self._merged.cases if (case := read_case(item, None, self._problems)) is not None
        ]
        for identity, item in sorted(self._merged.rules.items()):
            rule = self._rule(identity, item, scope, names)
            if rule is not None:
                drafts.append(rule)
            for case_item in self._listed(item, "cases"):
                if (case := read_case(case_item, identity, self._problems)) is not None:
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

    # ---- parameters and quantities

    def _parameter(self, name: str, layers: list[tuple[Place, Item]]) -> Parameter | None:
        """One parameter; a later layer says only what it changes."""
        entries: dict[str, Item] = {}
        place = layers[-1][0]
        self._check_name(name, layers[0][0])
        for layer_place, item in layers:
            if isinstance(item, Mapping):
                self._check_keys(item, PARAMETER_KEYS)
                entries |= item.entries
            elif isinstance(item, Scalar):
                entries["value"] = item
            else:
                self._error(layer_place, f"the parameter {name!r} is a list, expected a value")
        value = self._number(entries.get("value"), place, f"the parameter {name!r}")
        unit, dimension = self._unit(entries.get("unit"))
        limits = self._range(entries.get("range"))
        if value is None:
            return None
        if limits is not None and not limits[0] <= value <= limits[1]:
            value_place = entries["value"].place
            self._error(value_place, f"{name} = {value:g} is outside its range {limits[0]:g} to {limits[1]:g}")
        return Parameter(
            name,
            value,
            unit,
            dimension,
            limits,
            self._text(entries.get("meaning")),
            self._text(entries.get("source")),
            place,
        )

    def _unit(self, item: Item | None) -> tuple[str, float]:
        text = self._text(item) or "1"
        if text == "1":
            return text, 0.0
        base, _, power = text.partition("^")
        if base in LENGTH_UNITS and power in ("", "2", "3"):
            return text, float(power or 1)
        assert item is not None
        self._error(
            item.place, f"unknown unit {text!r}, expected 1 or one of {', '.join(LENGTH_UNITS)}, also with ^2 or ^3"
        )
        return "1", 0.0

    def _range(self, item: Item | None) -> tuple[float, float] | None:
        if item is None:
            return None
        if isinstance(item, Sequence) and len(item.items) == 2:
            low, high = (number_of(part) if isinstance(part, Scalar) else None for part in item.items)
            if low is not None and high is not None and low < high:
                return low, high
        self._error(item.place, "a range, expected two numbers such as [5, 30], the smaller first")
        return None

    def _quantities(self, dimensions: dict[str, float], words: frozenset[str]) -> tuple[dict, dict[str, Typed]]:
        """Quantities may use one another; each is read when those it names have been."""
        waiting = dict(sorted(self._merged.quantities.items()))
        sources: dict[str, tuple[Scalar, str]] = {}
        for name, (place, item) in list(waiting.items()):
            self._check_name(name, place)
            if name in dimensions:
                self._error(place, f"{name!r} is a parameter already, expected another name for the quantity")
            value: Item | None = item
            if isinstance(item, Mapping):
                self._check_keys(item, QUANTITY_KEYS)
                value = item.entries.get("value")
            if not isinstance(value, Scalar):
                self._error(place, f"the quantity {name!r} has no value, expected an expression")
                del waiting[name]
                continue
            meaning = self._text(item.entries.get("meaning")) if isinstance(item, Mapping) else ""
            sources[name] = (value, meaning)
        typed: dict[str, Typed] = {}
        quantities: dict[str, Quantity] = {}
        while waiting:
            ready = [name for name in waiting if not _mentions(sources[name][0].text, waiting.keys() - {name})]
            if not ready:
                name = next(iter(waiting))
                self._error(waiting[name][0], f"quantities define one another in a circle: {', '.join(waiting)}")
                break
            for name in ready:
                place, _ = waiting.pop(name)
                source, meaning = sources[name]
                read = parse_quantity(source, Scope(dimensions, dict(typed), words), self._problems)
                if read is None:
                    typed[name] = Typed(QuantityRef(name, FactRef("fill", 1)), 0.0)
                    continue
                if len(list(islice(walk(read.expression), MAX_QUANTITY_PARTS + 1))) > MAX_QUANTITY_PARTS:
                    self._error(place, f"the quantity {name!r} has more than {MAX_QUANTITY_PARTS} parts")
                    read = Typed(FactRef("fill", 1), 0.0)
                typed[name] = read
                assert not isinstance(read.dimension, str)
                quantities[name] = Quantity(name, read.expression, read.dimension, meaning, place)
        return quantities, typed

    # ---- rules

    def _words(self) -> frozenset[str]:
        words = set()
        for item in self._merged.rules.values():
            then = item.entries.get("then")
            word = then.entries.get("word") if isinstance(then, Mapping) else None
            if isinstance(word, Scalar):
                words.add(word.text)
                self._check_name(word.text, word.place)
        return frozenset(words)

    def _rule(self, identity: str, item: Mapping, scope: Scope, names: dict[str, Expression]) -> Rule | None:
        place = item.entries["id"].place
        self._check_keys(item, RULE_KEYS)
        if not _ID.match(identity):
            self._error(place, f"the id {identity!r}, expected letters, digits, - and _")
        before = len(self._problems.problems)
        band = self._choice(item, "priority", BANDS, "general")
        condition = self._condition(item, scope)
        then = item.entries.get("then")
        if not isinstance(then, Mapping):
            self._error(
                place, f"the rule {identity!r} has no `then`, expected {{segment: ..., certainty: ..., because: ...}}"
            )
            return None
        self._check_keys(then, THEN_KEYS)
        segment, word = self._concluded(then)
        certainty = 1.0
        if word is None:
            found = self._number(then.entries.get("certainty"), then.place, f"the certainty of the rule {identity!r}")
            certainty = found if found is not None else 1.0
            if not 0.0 < certainty <= 1.0:
                self._error(
                    then.entries["certainty"].place, f"a certainty of {certainty:g}, expected above 0 and at most 1"
                )
        elif "certainty" in then.entries:
            self._error(then.keys["certainty"], "a word is concluded without certainty, expected none here")
        because = self._because(then, names, identity)
        if len(self._problems.problems) > before:
            return None
        return Rule(
            identity,
            band,
            condition,
            segment,
            word,
            certainty,
            because,
            self._text(item.entries.get("evidence")) or f"rule {identity}",
            self._text(item.entries.get("source")),
            0,
            place,
        )

    def _concluded(self, then: Mapping) -> tuple[str | None, str | None]:
        given = [key for key in ("segment", "word") if key in then.entries]
        if len(given) != 1:
            self._error(then.place, "`then` needs either `segment` or `word`")
            return None, None
        item = then.entries[given[0]]
        if not isinstance(item, Scalar):
            self._error(item.place, f"`{given[0]}` needs a name")
            return None, None
        if given[0] == "word":
            return None, item.text
        if item.text not in CONCLUSIONS:
            hint = did_you_mean(item.text, CONCLUSIONS)
            types, divisions = ", ".join(SEGMENT_TYPES), ", ".join(DIVISIONS)
            self._error(item.place, f"unknown segment {item.text!r}{hint or f', expected one of {types}, {divisions}'}")
        return item.text, None

    def _because(self, then: Mapping, names: dict[str, Expression], identity: str) -> Template:
        item = then.entries.get("because")
        if isinstance(item, Scalar) and item.text.strip():
            return parse_template(item, names, self._problems)
        self._error(
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
            when = read_condition(item.entries["when"], scope, self._problems)
            if isinstance(when, All):
                parts.extend(when.conditions)
            elif when is not None:
                parts.append(when)
        if "unless" in item.entries:
            exception = read_condition(item.entries["unless"], scope, self._problems)
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
                self._error(part.place, f"unknown kind {text!r}{hint}")
            kinds.append(text)
        return tuple(sorted(set(kinds)))

    def _check_default(self, rules: list[Rule]) -> None:
        """There must be an answer for every node."""
        if self._problems.problems:
            return
        if not any(rule.band == "default" and rule.segment and rule.condition == All(()) for rule in rules):
            place = rules[0].place if rules else Place(self._merged.files[-1] if self._merged.files else "-", 1, 1)
            place = Place(place.file, 1, 1)
            self._error(
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
                self._error(makers[circle[0]][0].place, f"words conclude one another in a circle: {', '.join(circle)}")
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

    # ---- small things

    def _listed(self, item: Mapping, key: str) -> tuple[Item, ...]:
        found = item.entries.get(key)
        if found is None:
            return ()
        if isinstance(found, Sequence):
            return found.items
        self._error(found.place, f"`{key}` needs a list")
        return ()

    def _check_name(self, name: str, place: Place) -> None:
        if not _NAME.match(name):
            self._error(place, f"the name {name!r}, expected letters, digits and _")
        elif name in RESERVED:
            what = f"a fact ({DIMENSIONS[SPECS[name].dimension]})" if name in SPECS else "a word of the language"
            self._error(place, f"the name {name!r} is {what.split(' (')[0]}, expected another")

    def _check_keys(self, item: Mapping, known: tuple[str, ...]) -> None:
        for key, place in item.keys.items():
            if key not in known:
                hint = did_you_mean(key, known) or f", expected one of {', '.join(known)}"
                self._error(place, f"unknown key {key!r}{hint}")

    def _text(self, item: Item | None) -> str:
        if item is None:
            return ""
        if isinstance(item, Scalar):
            return " ".join(item.text.split())
        self._error(item.place, "expected a text")
        return ""

    def _number(self, item: Item | None, place: Place, what: str) -> float | None:
        if item is None:
            self._error(place, f"{what} is missing, expected a number")
            return None
        value = number_of(item) if isinstance(item, Scalar) else None
        if value is None or value in (float("inf"), float("-inf")):
            self._error(item.place, f"{what} is no number")
            return None
        return value

    def _choice(self, item: Mapping, key: str, known: tuple[str, ...], default: str) -> str:
        found = item.entries.get(key)
        if found is None:
            return default
        text = found.text if isinstance(found, Scalar) else ""
        if text not in known:
            hint = did_you_mean(text, known) or f", expected one of {', '.join(known)}"
            self._error(found.place, f"unknown {key} {text!r}{hint}")
        return text


def _mentions(text: str, names: set[str]) -> bool:
    return any(word in names for word in re.findall(r"[A-Za-z_][A-Za-z0-9_]*", text))
