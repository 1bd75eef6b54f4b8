"""All cases, in the order of the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator

from verification.cases import cantilevers, hole, pipes, plates, tees, vibrations
from verification.common import Row
from verification.joined import boss, fin, halves_in_six, joint_stress, stiffener, torsion
from verification.mixed import bracket, halves, portal, swaying, table

ALL: tuple[Callable[[], Iterator[Row]], ...] = (
    cantilevers,
    tees,
    vibrations,
    plates,
    hole,
    pipes,
    portal,
    halves,
    halves_in_six,
    joint_stress,
    torsion,
    stiffener,
    fin,
    boss,
    table,
    swaying,
    bracket,
)
