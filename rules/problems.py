"""What is wrong in a rule file: every problem with its place, gathered, and raised as one RuleError."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field

from kernel.errors import Place, RuleError


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing that is wrong, where, and what was expected. severity: "error" or "warning"."""

    place: Place
    message: str
    severity: str = "error"

    def __str__(self) -> str:
        return f"{self.place}: {self.message}"


class RuleProblems(RuleError):
    """A rule base with one or more errors; the text is the first one's, `problems` are all of them, in file order."""

    def __init__(self, problems: Iterable[Problem]) -> None:
        self.problems = tuple(sorted(problems, key=lambda p: (p.place.file, p.place.line, p.place.column, p.message)))
        first = self.problems[0]
        more = len(self.problems) - 1
        suffix = f" (and {more} more {'problem' if more == 1 else 'problems'})" if more else ""
        super().__init__(first.message + suffix, place=first.place)

    def __reduce__(self) -> tuple[type, tuple[tuple[Problem, ...]]]:
        return type(self), (self.problems,)


@dataclass(slots=True)
class Collector:
    """Gathers problems while a rule base is read."""

    problems: list[Problem] = field(default_factory=list)

    def error(self, place: Place, message: str) -> None:
        """Note an error."""
        self.problems.append(Problem(place, message))

    def raise_if_any(self) -> None:
        """RuleProblems where there are any."""
        if self.problems:
            raise RuleProblems(self.problems)


def did_you_mean(word: str, known: Iterable[str]) -> str:
    """`, did you mean 'x'?` for the nearest of `known`, or nothing."""
    from difflib import get_close_matches

    near = get_close_matches(word.lower(), sorted(known), n=1, cutoff=0.6)
    return f", did you mean {near[0]!r}?" if near else ""
