"""Places in space, as messages and reports show them."""

from __future__ import annotations

from collections.abc import Iterable

NOUGHT_DIGITS = 9
"""Digits after the point to which a coordinate is rounded first, so that none reads 1e-17 or -0."""


def place_text(point: Iterable[float]) -> str:
    """`(x, y, z)` to six significant digits. point: in the user's own frame."""
    return f"({', '.join(f'{round(float(value), NOUGHT_DIGITS) + 0.0:.6g}' for value in point)})"
