"""Numbers as decks write them: the shortest text that keeps most digits in a field."""

from __future__ import annotations

import math

from kernel.errors import DeckError


def fixed_field(value: float, width: int = 16) -> str:
    """A real that always carries a point and fits in the width, as exact as that allows (NASTRAN, SAP IV)."""
    value = float(value) + 0.0
    if not math.isfinite(value):
        raise DeckError(f"the number {value} cannot be written, expected a finite one")
    shortest = _with_point(repr(value))
    if len(shortest) <= width:
        return shortest
    best = ""
    for digits in range(17, 0, -1):
        text = _with_point(f"{value:.{digits}g}")
        if len(text) <= width:
            best = text
            break
    for digits in range(16, -1, -1):
        text = _with_point(f"{value:.{digits}e}")
        if len(text) <= width:
            if not best or abs(float(text) - value) < abs(float(best) - value):
                best = text
            break
    if not best:
        raise DeckError(f"the number {value!r} does not fit in {width} characters")
    return best


def _with_point(text: str) -> str:
    """`1e-05` as `1.E-5`, `5` as `5.`, `0.5` as `.5`, `10.0` as `10.`."""
    mantissa, _, exponent = text.partition("e")
    if "." in mantissa:
        mantissa = mantissa.rstrip("0")
    else:
        mantissa += "."
    if mantissa.startswith("0."):
        mantissa = mantissa[1:] if mantissa != "0." else mantissa
    elif mantissa.startswith("-0."):
        mantissa = "-" + mantissa[2:]
    return f"{mantissa}E{int(exponent)}" if exponent else mantissa


def free_field(value: float) -> str:
    """A real in free format: the shortest text that reads back the same, with a point or an exponent."""
    value = float(value) + 0.0
    if not math.isfinite(value):
        raise DeckError(f"the number {value} cannot be written, expected a finite one")
    text = repr(value)
    return text[:-1] if text.endswith(".0") else text
