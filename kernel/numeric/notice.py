"""Who is to hear that kernels are being compiled: a first mesh on a new machine waits some twenty seconds for it.

Apart from numba, so that a program can ask before it knows whether it will need any kernel at all.
"""

from __future__ import annotations

from collections.abc import Callable

_waiting: list[Callable[[], None]] = []


def when_compiling(tell: Callable[[], None]) -> None:
    """Have `tell` called once in this process, when the first kernel is compiled that no cache holds."""
    _waiting.append(tell)


def compiling() -> None:
    """Tell those who wait; they wait no longer."""
    while _waiting:
        _waiting.pop()()
