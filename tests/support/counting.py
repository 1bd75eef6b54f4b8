"""How much an action does, told so that no busy machine changes it."""

import sys
from collections.abc import Callable


def python_calls(action: Callable[[], object]) -> int:
    """How many Python functions are called while `action` runs."""
    count = 0

    def note(_frame, event, _argument):
        nonlocal count
        count += event == "call"

    sys.setprofile(note)
    try:
        action()
    finally:
        sys.setprofile(None)
    return count
