"""Words of messages."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """`, did you mean 'x'?` where one of the known names is near, else nothing."""
    by_lower = {candidate.lower(): candidate for candidate in sorted(known)}
    near = difflib.get_close_matches(name.lower(), by_lower, n=1, cutoff=0.6)
    return f", did you mean {by_lower[near[0]]!r}?" if near else ""


def is_writable(text: str) -> bool:
    r"""Whether an encoding has all of the text: JSON can spell half a surrogate pair (`\ud800`), which none has."""
    return not any("\ud800" <= letter <= "\udfff" for letter in text)
