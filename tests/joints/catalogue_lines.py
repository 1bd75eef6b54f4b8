"""Round things that touch along a line: tubes in a row, with fins between, in one another; bars on walls."""

from __future__ import annotations

from joined_model import Joined
from solids import cube, difference, intersection, rod, tube, turned, union

TWO = "cylinder_plate cylinder_plate"
PIPE = tube(200, 60, 56)


def row(count: int, pitch: float, height: float = 200.0) -> list[str]:
    """Tubes of radius 25 and wall 4, `pitch` from axis to axis."""
    return [tube(height, 25, 21, (pitch * k, 0, 0)) for k in range(count)]


def fins(count: int, pitch: float, into: float, height: float = 200.0) -> list[str]:
    """Fins of thickness 6 between them, each running `into` the tubes on both sides."""
    width = pitch - 50 + 2 * into
    return [cube(width, 6, height, (25 - into + pitch * k, -3, 0)) for k in range(count - 1)]


LINES = {
    **{
        f"two tubes, {bite} in one another": Joined(union(PIPE, tube(200, 60, 56, (120 - bite, 0, 0))), "lap", TWO)
        for bite in (0, 0.02, 1, 3)
    },
    "two tubes open to one another's walls": Joined(
        difference(
            union(rod(200, 60), rod(200, 60, (100, 0, 0))), rod(210, 56, (0, 0, -5)), rod(210, 56, (100, 0, -5))
        ),
        "pipe",
        TWO,
    ),
    "two tubes of other radii, one shorter": Joined(union(PIPE, tube(120, 40, 37, (0, 100, 50))), "lap", TWO),
    "tube on the bottom of another": Joined(union(PIPE, tube(200, 30, 27, (26, 0, 0))), "lap", TWO),
    "pipe in a half pipe that fits it": Joined(
        union(PIPE, intersection(tube(200, 64, 60), cube(200, 100, 200, (-100, 0, 0)))), "lap", TWO
    ),
    "row of tubes": Joined(union(*row(4, 50)), "lap", " ".join([TWO] * 2)),
    "bundle of three tubes": Joined(
        union(*row(2, 50), tube(200, 25, 21, (25, 25 * 3**0.5, 0))), "lap", "cylinder_plate " + TWO
    ),
    "membrane wall, fins into the tubes": Joined(
        union(*row(3, 80), *fins(3, 80, 1)), "pipe", "cylinder_plate " + TWO + " plate plate"
    ),
    "membrane wall, fins that touch": Joined(
        union(*row(3, 150), *fins(3, 150, 0)), "pipe", "cylinder_plate " + TWO + " plate plate"
    ),
    "membrane wall, fins that are bars": Joined(
        union(*row(3, 80, 300), *fins(3, 80, 0, 300)), "along", "beam beam cylinder_plate " + TWO
    ),
    "row of long tubes": Joined(union(*row(3, 50, 700)), "along", "beam beam beam"),
    "round bar on a plate": Joined(
        union(cube(300, 200, 8, (0, 0, -8)), rod(260, 8, (20, 100, 8), turned("y", 90))), "along", "beam plate"
    ),
    "round bar on a pipe": Joined(union(tube(300, 60, 56), rod(260, 8, (68, 0, 20))), "along", "beam cylinder_plate"),
    "square bar on a pipe": Joined(
        union(tube(300, 60, 56), cube(12, 12, 260, (60, -6, 20))), "along", "beam cylinder_plate"
    ),
}
