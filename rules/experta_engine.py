"""The one place that knows experta (1.9.4, unmaintained since 2019): a safe import, and a small deterministic engine.

What experta needs to be trusted with decisions, each measured before this was written:
- its import needs names that Python 3.10 took out of `collections`; they are given back only while it runs;
- its import installs a handler on the root logger (taken off again) and swallows ImportError (checked for);
- its own strategy can fire a rule that was already invalidated, and orders equal salience by hash: ours does neither;
- joins and NOT are quadratic, so one fact is matched at a time, all conditions of a rule inside one predicate;
- its class-level caches keep every rule ever built alive: ours are taken out again once the network stands.
"""

from __future__ import annotations

import collections
import collections.abc
import importlib
import logging
import threading
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import lru_cache
from types import ModuleType
from typing import Any

from kernel.errors import DefectError
from rules.logic import TRUE, any_of
from rules.view import Match, View

_import_lock = threading.RLock()
_LENT_NAMES = (
    "Callable", "Hashable", "Iterable", "Iterator", "Mapping", "MutableMapping", "MutableSequence", "MutableSet",
    "Sequence", "Set",
)  # fmt: skip


@contextmanager
def _as_experta_expects() -> Iterator[None]:
    """`collections` with its old names, and a root logger that comes out as it went in."""
    lent = [name for name in _LENT_NAMES if not hasattr(collections, name)]
    handlers, level = list(logging.root.handlers), logging.root.level
    for name in lent:
        setattr(collections, name, getattr(collections.abc, name))
    try:
        yield
    finally:
        for name in lent:
            delattr(collections, name)
        for handler in [handler for handler in logging.root.handlers if handler not in handlers]:
            logging.root.removeHandler(handler)
            handler.close()
        logging.root.setLevel(level)


@lru_cache(maxsize=1)
def experta() -> ModuleType:
    """The module, imported so that nothing else notices."""
    with _import_lock, _as_experta_expects():
        module = importlib.import_module("experta")
        if not hasattr(module, "KnowledgeEngine"):
            raise DefectError("experta was imported without its KnowledgeEngine: one of its own imports failed")
        for name in module.watchers.ALL:
            logging.getLogger(f"experta.watchers.{name}").setLevel(logging.CRITICAL)
        return module


class EngineRule:
    """What the engine needs of a rule: its name, the level it is asked at, its condition, the word it concludes."""

    __slots__ = ("index", "level", "match", "name", "word")

    def __init__(self, index: int, name: str, level: int, match: Match, word: str | None) -> None:
        self.index = index
        self.name = name
        self.level = level
        self.match = match
        self.word = word


class Run:
    """One run's working memory: the view, what every rule asked so far came to, and the rules that fired, in order."""

    __slots__ = ("fired", "outcomes", "view")

    def __init__(self, view: View, known: Mapping[int, int]) -> None:
        self.view = view
        self.outcomes: dict[int, int] = dict(known)
        self.fired: list[int] = []


class ExpertaEngine:
    """A knowledge engine over one rule base. Belongs to one thread; neither pickled nor shared.

    One fact of a class of its own for each level: `Stage0(run)`, `Stage1(run)`, ... Each rule matches the stage of its
    level by one predicate, its condition over the whole view. A rule that holds fires and tells the run; when none
    is left at a level, the words of that level are decided and the next stage is declared. (Classes, not a field:
    experta tests a fact's class first, but its fields in an order that changes with the hash seed.)
    """

    def __init__(self, rules: Sequence[EngineRule]) -> None:
        self._engine, self._first_stage = _build(rules)

    def run(self, view: View, known: Mapping[int, int]) -> tuple[list[int], dict[int, int]]:
        """Indices of the rules that fired, and the outcome of every rule by index.

        known: outcomes that are the same for every node at this tier, and need not be found again.
        """
        engine = self._engine
        engine.memory = run = Run(view, known)
        try:
            engine.declare(self._first_stage(run=run))
            engine.run()
        finally:
            engine.forget()
        return run.fired, run.outcomes


def _build(rules: Sequence[EngineRule]) -> tuple[Any, Any]:
    """The engine instance, and the class of the first level's fact."""
    module = experta()
    checks = importlib.import_module("experta.matchers.rete.check")
    last = max((rule.level for rule in rules), default=0)
    stages = [type(f"Stage{level}", (module.Fact,), {}) for level in range(last + 1)]
    body: dict[str, Any] = {"__strategy__": _strategy(), "__matcher__": _matcher(), "forget": _forget, "memory": None}
    for rule in rules:
        body[f"rule_{rule.index}"] = module.Rule(stages[rule.level](run=module.P(_predicate(rule))))(_action(rule))
    for level in range(last):
        words: dict[str, list[int]] = {}
        for rule in rules:
            if rule.word is not None and rule.level == level:
                words.setdefault(rule.word, []).append(rule.index)
        body[f"stage_{level}"] = module.Rule(stages[level](), salience=-1)(_advance(level, words, stages))
    caches = [checks.TypeCheck, checks.FeatureCheck, checks.FactCapture, checks.WhereCheck]
    with _import_lock:
        before = [dict(cache._instances) for cache in caches]
        engine = type("RuleEngine", (module.KnowledgeEngine,), body)()
        for cache, instances in zip(caches, before, strict=True):
            cache._instances.clear()
            cache._instances.update(instances)
    engine.forget()
    return engine, stages[0]


def _forget(engine: Any) -> None:
    """An empty working memory again, also after an exception in an action, which leaves experta `running`.

    Cheaper than retracting (which matches every rule again) and than `reset` (which looks its rules up by name each
    time), and as good: without joins only the conflict sets remember anything.
    """
    module = experta()
    engine.facts = module.factlist.FactList()
    engine.agenda = module.agenda.Agenda()
    engine.matcher.forget()
    engine.running = False
    engine.memory = None


def _predicate(rule: EngineRule) -> Callable[[Run], bool]:
    index, match = rule.index, rule.match

    def holds(run: Run) -> bool:
        found = run.outcomes.get(index)
        if found is None:
            found = run.outcomes[index] = match(run.view)
        return found == TRUE

    return holds


def _action(rule: EngineRule) -> Callable[[Any], None]:
    index = rule.index

    def report(engine: Any) -> None:
        engine.memory.fired.append(index)

    report.__name__ = rule.name
    return report


def _advance(level: int, words: dict[str, list[int]], stages: list) -> Callable[[Any], None]:
    def decide_words(engine: Any) -> None:
        run = engine.memory
        for word, makers in words.items():
            run.view.words[word] = any_of(run.outcomes[index] for index in makers)
        engine.declare(stages[level + 1](run=run))

    decide_words.__name__ = f"after level {level}"
    return decide_words


@lru_cache(maxsize=1)
def _strategy() -> type:
    """Conflict resolution that is the same in every run: by salience, then fact numbers, then the rule's name."""
    abstract = importlib.import_module("experta.abstract")

    class Ordered(abstract.Strategy):  # type: ignore[misc,name-defined]
        """Keeps the agenda sorted, best last, and takes out exactly what was invalidated."""

        def _update_agenda(self, agenda: Any, added: list, removed: list) -> None:
            if removed:
                gone = {_identity(activation) for activation in removed}
                agenda.activations = [kept for kept in agenda.activations if _identity(kept) not in gone]
            if added:
                for activation in added:
                    activation.key = _identity(activation)
                agenda.activations = sorted([*agenda.activations, *added], key=_identity)

    return Ordered


def _identity(activation: Any) -> tuple[int, tuple[int, ...], str]:
    numbers = tuple(sorted(fact["__factid__"] for fact in activation.facts))
    return (activation.rule.salience, numbers, activation.rule.__name__)


def _guard(node: Any) -> None:
    """Ask a rule's predicate before its node copies the token: most rules fail, and the copy costs more than that."""
    for position, child in enumerate(node.children):
        _guard(child.node)
        check = getattr(child.node, "matcher", None)
        predicate = getattr(getattr(check, "expected", None), "match", None)
        if predicate is not None:
            node.children[position] = child._replace(callback=_guarded(child.callback, predicate))


def _guarded(callback: Callable[[Any], None], predicate: Callable[[Run], bool]) -> Callable[[Any], None]:
    def activate(token: Any) -> None:
        (fact,) = token.data
        if predicate(fact["run"]):
            callback(token)

    return activate


@lru_cache(maxsize=1)
def _matcher() -> type:
    """The Rete matcher, which asks only those conflict sets that changed."""
    rete = importlib.import_module("experta.matchers.rete")

    class Matcher(rete.ReteMatcher):  # type: ignore[misc,name-defined]
        """Its own list of conflict sets: experta's is a cache that all engines of the process share."""

        def changes(self, adding: Any = None, deleting: Any = None) -> tuple[list, list]:
            for fact in deleting or ():
                self.root_node.remove(fact)
            for fact in adding or ():
                self.root_node.add(fact)
            added: list = []
            removed: list = []
            if not adding and not deleting:
                return added, removed
            for node in self._conflict_sets():
                if node.added or node.removed:
                    node_added, node_removed = node.get_activations()
                    added.extend(node_added)
                    removed.extend(node_removed)
            return added, removed

        def forget(self) -> None:
            for node in self._conflict_sets():
                node.memory = set()
                node.added = set()
                node.removed = set()

        def build_network(self) -> None:
            super().build_network()
            _guard(self.root_node)

        def _conflict_sets(self) -> list:
            if "_own_conflict_sets" not in self.__dict__:
                self._own_conflict_sets = list(self._find_conflict_sets(self.root_node))
            return self._own_conflict_sets

        def _find_conflict_sets(self, node: Any) -> Iterator[Any]:
            if type(node).__name__ == "ConflictSetNode":
                yield node
            for child in node.children:
                yield from self._find_conflict_sets(child.node)

    return Matcher
