"""How much of a section's area hangs on its circles: what chords cut off them, in place of arcs.

n chords to a turn, on an arc of radius r over the angle a, cut off r^2 a (2 pi / n)^2 / 12: outside of the material
they take area away, in a hole they add some. Where all circles are divided alike, an outline of area A loses the share
c (2 pi / n)^2 / 12 with c = |sum of +- r^2 a| / A: 2 for a disc, and for a tube however thin, whose two circles make up
for one another. A circle alone loses no more than with c = 2 pi r^2 / A.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from kernel.idealise.carriers import Circle
from kernel.idealise.outlines import Stretch
from kernel.idealise.sheets import PlaneSheet
from kernel.idealise.topology import Topology


def roundness(
    topology: Topology, sheet: PlaneSheet, outline: Sequence[Sequence[Stretch]], area: float
) -> dict[int, float]:
    """By carrier, the c of each circle that bounds the outline: its own or the whole outline's, the lesser."""
    total = 0.0
    found: dict[int, float] = {}
    for stretch in itertools.chain.from_iterable(outline):
        circle = topology.carrier(stretch.carrier)
        if isinstance(circle, Circle):
            is_around = stretch.forward == (float(circle.normal @ sheet.normal) > 0.0)  # material inside the circle
            swept = circle.radius * (stretch.end - stretch.start)
            total += swept if is_around else -swept
            found[stretch.carrier] = circle.radius * circle.period / area
    return {carrier: min(own, abs(total) / area) for carrier, own in found.items()}
