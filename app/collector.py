"""How often Python looks for objects in cycles: rarely, in processes that mesh."""

from __future__ import annotations

import gc

ALLOCATIONS = 200_000
"""Objects made between two looks at the young ones; Python's own 700 suit programs that hold little. A large model
holds millions, which are gone through again and again, and leaves next to none in cycles."""


def collect_rarely() -> None:
    """For the process that calls it. A tenth of the time of a model of 2,000 walls, for the same memory."""
    gc.set_threshold(ALLOCATIONS)
