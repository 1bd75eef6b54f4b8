"""Loading a rule base, and deciding with it.

    base = load_rule_base()                     # the one that comes with csgmesh; or the path of a file or folder
    base.decide(facts)                          # Need(tier) or Conclusion
    base.explain(facts).to_text()

The rules are matched by experta (experta_engine.py); what they mean is compile.py's, who wins is resolve.py's.
"""

from __future__ import annotations

import hashlib
import threading
from functools import cached_property
from typing import TYPE_CHECKING

from kernel.facts import TIERS, Facts
from kernel.plan import Conclusion, Need
from kernel.units import unit_set
from rules.definition import Definition, Parameter, Rule
from rules.loader import read_definition, read_definition_text
from rules.syntax import Condition, Expression, FactRef, Quantified, WordRef, walk
from rules.template import Field

if TYPE_CHECKING:
    from collections.abc import Mapping

    from rules.compile import Compiler
    from rules.explain import Explanation
    from rules.resolve import Verdict
    from rules.view import Match, Strength, View

CACHE_ENTRIES = 50_000
"""Answers kept; the cache is emptied when it is full."""

VERSION_DIGITS = 12


class RuleBase:
    """A checked and compiled rule base. `decide` is a kernel.plan.Decide; safe to share between threads and to pickle.

    definition: what was read. units: the model's length unit, which gives length parameters their meaning.
    """

    def __init__(self, definition: Definition, units: str = "mm") -> None:
        self.definition = definition
        self.units = unit_set(units)
        self._answers: dict[tuple, Conclusion | Need] = {}
        self._local = threading.local()

    @property
    def name(self) -> str:
        """As the rule file says."""
        return self.definition.name

    @cached_property
    def version(self) -> str:
        """12 hexadecimal digits of a hash over all that matters for decisions, whatever order it was written in."""
        text = "\n".join(self.definition.canonical())
        return hashlib.sha256(text.encode()).hexdigest()[:VERSION_DIGITS]

    @property
    def rules(self) -> tuple[Rule, ...]:
        """All rules, by id."""
        return self.definition.rules

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The numbers that analysts tune."""
        return self.definition.parameters

    @cached_property
    def values(self) -> dict[str, float]:
        """The parameters' values in model units."""
        return {name: p.in_model_units(self.units.metre) for name, p in self.definition.parameters.items()}

    def in_units(self, units: str) -> RuleBase:
        """The same rule base for models in `units`; itself where that changes nothing."""
        has_lengths = any(parameter.dimension for parameter in self.parameters.values())
        if not has_lengths or unit_set(units) == self.units:
            return self
        return RuleBase(self.definition, units)

    def decide(self, facts: Facts) -> Conclusion | Need:
        """The conclusion, or the tier of facts that is needed first.

        Facts that are equal in all that any rule speaks of are answered from a cache.
        """
        names, collections = self._spoken_of
        key: tuple = (facts.tier, *map(facts.get, names))
        for name in collections:
            related = facts.related.get(name)
            key += (None if related is None else tuple(sorted((item.key for item in related), key=repr)),)
        answer = self._answers.get(key)
        if answer is None:
            answer = self._decide(facts)
            if len(self._answers) >= CACHE_ENTRIES:
                self._answers.clear()
            self._answers[key] = answer
        return answer

    @cached_property
    def _spoken_of(self) -> tuple[tuple[str, ...], tuple[str, ...]]:
        """The facts, and the collections of related things, that any rule's condition or reason speaks of."""
        parts: list[Expression | Condition] = []
        for rule in self.rules:
            parts += walk(rule.condition)
            for part in rule.because.parts:
                parts += walk(part.expression) if isinstance(part, Field) else ()
        names = {part.name for part in parts if isinstance(part, FactRef)}
        collections = {part.collection for part in parts if isinstance(part, Quantified)}
        return tuple(sorted(names)), tuple(sorted(collections))

    def _decide(self, facts: Facts) -> Conclusion | Need:
        from rules.explain import conclude

        verdict, view, outcomes = self.judge(facts)
        if isinstance(verdict, int):
            return Need(TIERS[verdict])
        return conclude(self, verdict, view, outcomes)

    def judge(self, facts: Facts) -> tuple[Verdict | int, View, dict[int, int]]:
        """The verdict or the tier needed, the view it was taken on, and the outcome of each rule by index."""
        from rules.logic import MAY_BE_TRUE, TRUE, tier_of
        from rules.resolve import resolve
        from rules.view import View

        view = View(facts)
        rules = self.definition.rules
        fired, outcomes = self._engine.run(view, self._unmeasured[facts.tier])
        holding = [rules[index] for index in sorted(fired) if rules[index].segment is not None]
        open_rules = [
            (rules[index], tier_of(outcome))
            for index, outcome in sorted(outcomes.items())
            if outcome & MAY_BE_TRUE and outcome != TRUE and rules[index].segment is not None
        ]
        return resolve(holding, open_rules), view, outcomes

    def explain(self, facts: Facts) -> Explanation:
        """Why the answer is what it is: every rule, with the numbers that made it hold or fail."""
        from rules.explain import explain

        return explain(self, facts)

    @cached_property
    def compiler(self) -> Compiler:
        """For texts and explanations: the value of an expression, the outcome of a condition, each compiled once."""
        from rules.compile import Compiler

        words = {
            word: tuple(rule.condition for rule in self.rules if rule.word == word) for word in self.definition.words
        }
        return Compiler(self.values, words)

    @cached_property
    def matches(self) -> tuple[Match, ...]:
        """Each rule's condition, compiled."""
        from rules.compile import compile_condition

        return tuple(compile_condition(rule.condition, self.values) for rule in self.rules)

    @cached_property
    def strengths(self) -> tuple[Strength, ...]:
        """By how much each rule holds or fails, compiled."""
        from rules.strength import compile_strength

        words: dict[str, list[Strength]] = {name: [] for name in self.definition.words}
        strengths: list[Strength | None] = [None] * len(self.rules)
        for index, rule in sorted(enumerate(self.rules), key=lambda pair: pair[1].level):
            strength = strengths[index] = compile_strength(rule.condition, self.values, words)
            if rule.word is not None:
                words[rule.word].append(strength)
        return tuple(strength for strength in strengths if strength is not None)

    @cached_property
    def _unmeasured(self) -> dict[str, dict[int, int]]:
        """By tier, the outcomes of rules that speak only of what is measured later: the same for every node."""
        from rules.view import View

        found: dict[str, dict[int, int]] = {}
        for reached, tier in enumerate(TIERS):
            nothing = View(Facts({}, tier))
            found[tier] = {
                index: self.matches[index](nothing)
                for index, rule in enumerate(self.rules)
                if not any(_is_told_by(part, reached) for part in walk(rule.condition))
            }
        return found

    @property
    def _engine(self):  # type: ignore[no-untyped-def]
        """The calling thread's experta engine: engines are not shared between threads."""
        engine = getattr(self._local, "engine", None)
        if engine is None:
            from rules.experta_engine import EngineRule, ExpertaEngine

            rules = [
                EngineRule(index, rule.id, rule.level, self.matches[index], rule.word)
                for index, rule in enumerate(self.rules)
            ]
            engine = self._local.engine = ExpertaEngine(rules)
        return engine

    def __reduce__(self) -> tuple:
        return RuleBase, (self.definition, self.units.name)

    def __repr__(self) -> str:
        return f"RuleBase({self.name!r}, {self.version}, {len(self.rules)} rules)"


def _is_told_by(part: Expression | Condition, tier: int) -> bool:
    """Whether facts up to `tier` may change what `part` comes to."""
    if isinstance(part, FactRef | Quantified):
        return part.tier <= tier
    return isinstance(part, WordRef)


def load_rule_base(path: str | None = None, *, units: str = "mm") -> RuleBase:
    """The rule base at `path`, a file or a folder of *.yaml files; None for the one that comes with csgmesh.

    RuleError, with the place of the first error and all of them in `problems`, for a rule base that is wrong.
    """
    return RuleBase(read_definition(path), units)


def rule_base_from_text(text: str, name: str = "-", *, units: str = "mm") -> RuleBase:
    """The rule base that `text` is; it may extend `base`, but reaches no files. RuleError as for load_rule_base."""
    return RuleBase(read_definition_text(text, name), units)
