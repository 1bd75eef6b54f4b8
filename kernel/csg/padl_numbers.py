"""Arithmetic of the PADL-2-like language: floats, angles in degrees, every result finite."""

from __future__ import annotations

import math
from collections.abc import Callable

from kernel.csg.placement import cosine, sine

CONSTANTS = {"PI": math.pi}


def _tangent(degrees: float) -> float:
    c = cosine(degrees)
    if c == 0.0:
        raise ArithmeticError(f"TAN({degrees:g}) has no value, expected an angle other than 90 degrees")
    return sine(degrees) / c


def _root(value: float) -> float:
    if value < 0:
        raise ArithmeticError(f"SQRT({value:g}) has no value, expected a number of 0 or more")
    return math.sqrt(value)


FUNCTIONS: dict[str, Callable[[float], float]] = {"SIN": sine, "COS": cosine, "TAN": _tangent, "SQRT": _root}


def combine(left: float, operator: str, right: float) -> float:
    """`left operator right` for + - * / **. ArithmeticError: there is no finite result, and why."""
    try:
        result = _combine(left, operator, right)
    except OverflowError:
        result = math.inf
    if not math.isfinite(result):
        raise ArithmeticError(f"{left:g} {operator} {right:g} is too large, expected a number under 1.8e308")
    return result


def _combine(left: float, operator: str, right: float) -> float:
    if operator == "+":
        return left + right
    if operator == "-":
        return left - right
    if operator == "*":
        return left * right
    if operator == "/":
        if right == 0.0:
            raise ArithmeticError(f"{left:g} is divided by 0, expected a divisor other than 0")
        return left / right
    try:
        return math.pow(left, right)
    except ValueError:
        raise ArithmeticError(
            f"{left:g} ** {right:g} has no value, expected a base over 0 or a whole exponent"
        ) from None
