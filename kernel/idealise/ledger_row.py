"""A row of the ledger: volume that the idealised model counts otherwise than the solid has it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

JOINT, SHAPE, UNEXPLAINED, BALANCE, CHORDS = "joint", "shape", "unexplained", "balance", "chords"


@dataclass(frozen=True, slots=True, eq=False)
class LedgerRow:
    """Volume that the idealised model counts more (+) or less (-) often than the solid has it, and why.

    kind: "joint" (walls that meet, in closed form), "shape" (a segment's own shape is not its idealised one),
    "unexplained" (joints of which no closed form is known), "balance" (volume 0: what the walls of a joint count of one
    another's material, which matters where one of them is taken away), "chords" (straight edges and flat elements in
    place of curves).
    shares: what each segment's own elements count of it, by segment id; they add up to the volume. Empty where the row
    is of the solid as a whole.
    """

    segments: tuple[str, ...]
    cause: str
    volume: float
    shares: Mapping[str, float]
    kind: str
