"""Plates on plates: edges, corners, tees, crosses, laps and steps."""

from __future__ import annotations

import math

from joined_model import Joined
from shapely.geometry import LineString
from solids import cube, difference, extrusion, intersection, placed, rod, turned, union


def vee(angle: float, t: float = 6.0) -> str:
    """Two plates that meet at `angle`, mitred."""
    a = math.radians(angle)
    line = LineString([(100, 0), (0, 0), (100 * math.cos(a), 100 * math.sin(a))])
    outline = line.buffer(t / 2, cap_style="flat", join_style="mitre", mitre_limit=20)
    return extrusion(list(outline.exterior.coords)[:-1], 120)


def leaning_web(angle: float, t: float = 8.0) -> str:
    """A flange 10 thick, and a web that stands on it at `angle`."""
    below = cube(900, 900, 100, (-50, -300, -95))
    return union(cube(200, 300, 10), difference(cube(200, t, 180, (0, 130, -30), turned("x", angle - 90)), below))


def crossing(angle: float) -> str:
    """Two plates that run through one another."""
    return union(cube(160, 200, 6, (0, -100, -3)), placed(cube(160, 200, 8, (0, -100, -4)), turn=turned("x", angle)))


def box(x, y, z, t) -> str:
    return difference(cube(x, y, z), cube(x - 2 * t, y - 2 * t, z - 2 * t, (t, t, t)))


FLANGE = cube(200, 150, 10)
PLATES = {
    "web on a step": Joined(
        union(cube(150, 100, 8), cube(150, 100, 12, (150, 0, 0)), cube(8, 100, 80, (150, 0, 12))),
        "corner step",
        "plate plate plate",
    ),
    "round doubler": Joined(union(cube(300, 300, 8), rod(6, 70, (150, 150, 8))), "lap", "plate plate"),
    "doubler": Joined(union(cube(300, 200, 8), cube(120, 80, 6, (90, 60, 8))), "lap", "plate plate"),
    "lap, skew": Joined(
        union(cube(200, 100, 8), cube(200, 60, 6, (120, 30, 8), turned("z", 25))), "lap", "plate plate"
    ),
    "lap": Joined(union(cube(200, 100, 8), cube(200, 100, 6, (150, 0, 8))), "lap", "plate plate"),
    **{f"plates in a corner of {a}": Joined(vee(a), "corner", "plate plate") for a in (25, 45, 60, 90, 120, 135, 155)},
    **{f"tee at {a}": Joined(leaning_web(a), "tee", "plate plate") for a in (25, 45, 60, 90, 120, 155)},
    **{f"cross at {a}": Joined(crossing(a), "cross", "plate plate") for a in (30, 60, 90)},
    "butt": Joined(
        union(cube(100, 120, 8), cube(100, 80, 8, (100, 20, 0))), "edge", "plate plate", {"0": "plate", "1": "plate"}
    ),
    "butt, skew": Joined(
        union(
            extrusion([(0, 0), (100, 0), (140, 120), (0, 120)], 8),
            extrusion([(100, 0), (240, 0), (240, 120), (140, 120)], 8),
        ),
        "edge",
        "plate plate",
        {"0": "plate", "1": "plate"},
    ),
    "step, flush below": Joined(union(cube(150, 100, 8), cube(150, 100, 12, (150, 0, 0))), "step", "plate plate"),
    "step, mid-planes level": Joined(
        union(cube(150, 100, 8, (0, 0, 2)), cube(150, 100, 12, (150, 0, 0))), "edge", "plate plate"
    ),
    "step, a little contact": Joined(
        union(cube(150, 100, 8, (0, 0, 6)), cube(150, 100, 8, (150, 0, 0))),
        "step",
        "plate plate",
        {"0": "plate", "1": "plate"},
        10.0,
    ),
    "lap with a tee under it": Joined(
        union(cube(200, 100, 8), cube(200, 100, 6, (150, 0, 8)), cube(200, 8, 80, (0, 46, -80))),
        "lap tee",
        "plate plate plate",
    ),
    "thin flange": Joined(union(cube(200, 150, 3), cube(200, 12, 100, (0, 69, 3))), "tee", "plate plate"),
    "short post flush with the side of its flange": Joined(
        union(cube(900, 200, 12, (0, 0, 300)), cube(150, 10, 300)), "corner", "plate plate"
    ),
    "box column flush with the sides of its flange": Joined(
        union(cube(900, 200, 12, (0, 0, 300)), difference(cube(200, 200, 300), cube(180, 180, 400, (10, 10, -50)))),
        "corner tee",
        "plate plate plate plate plate",
    ),
    "lip": Joined(union(cube(200, 150, 8), cube(200, 8, 60, (0, 15, 8))), "tee", "plate plate"),
    "web longer than its flange": Joined(
        union(cube(200, 120, 10), cube(300, 8, 100, (-50, 56, 10))), "tee", "plate plate"
    ),
    "web shorter than its flange": Joined(union(FLANGE, cube(120, 8, 100, (40, 71, 10))), "tee", "plate plate"),
    "web askew": Joined(
        union(cube(240, 240, 10), placed(cube(150, 8, 100), (60, 40, 10), turned("z", 37))), "tee", "plate plate"
    ),
    "webs in line": Joined(
        union(FLANGE, cube(200, 8, 80, (0, 70, 10)), cube(200, 8, 80, (0, 70, -80))), "cross", "plate plate"
    ),
    **{
        f"webs face to face, {g} apart": Joined(
            union(FLANGE, cube(200, 8, 80, (0, 70, 10)), cube(200, 8, 80, (0, 70 + g, -80))), "tee", "plate plate plate"
        )
        for g in (0.3, 1, 3, 8)
    },
    "webs touching": Joined(
        union(FLANGE, cube(200, 8, 80, (0, 60, 10)), cube(200, 6, 60, (0, 68, 10))),
        "lap tee",
        "plate plate plate",
        {"0": "plate", "1": "plate", "2": "plate"},
    ),
    "three plates on one line": Joined(
        union(*(cube(100, 6, 120, tuple(turned("z", a) @ (0, -3, 0)), turned("z", a)) for a in (0, 120, 240))),
        "corner",
        "plate plate plate",
    ),
    "corner of three": Joined(
        union(cube(150, 120, 6), cube(150, 6, 100), cube(6, 120, 100)), "corner", "plate plate plate"
    ),
    "box": Joined(box(200, 150, 100, 6), "corner", " ".join(["plate"] * 6)),
    "partitioned box": Joined(
        union(box(200, 150, 100, 6), cube(6, 138, 88, (80, 6, 6))), "corner tee", " ".join(["plate"] * 7)
    ),
    "partitioned box, drilled through": Joined(
        difference(
            union(box(200, 150, 100, 6), cube(6, 138, 88, (80, 6, 6))), rod(300, 25, (-10, 75, 50), turned("y", 90))
        ),
        "corner tee",
        " ".join(["plate"] * 7),
    ),
    "egg-crate": Joined(
        union(
            *(cube(206, 6, 50, (0, 100 * i, 0)) for i in range(3)),
            *(cube(6, 206, 50, (100 * i, 0, 0)) for i in range(3)),
            cube(206, 206, 6),
        ),
        "corner cross tee",
        " ".join(["plate"] * 7),
    ),
    "gusset with a rat hole": Joined(
        union(
            cube(150, 120, 10),
            cube(150, 10, 120),
            extrusion([(15, 0), (80, 0), (0, 80), (0, 15)], 8, (71, 10, 10), turned("z", 90) @ turned("x", 90)),
        ),
        "corner tee",
        "plate plate plate",
    ),
    "gusset askew, cut square": Joined(
        union(cube(200, 200, 8), cube(8, 200, 120, (0, 0, 8)), cube(6, 100, 80, (8, 60, 8), turned("z", -30))),
        "corner tee",
        "plate plate plate",
    ),
    "fin by its length": Joined(union(cube(300, 150, 8), cube(300, 6, 60, (0, 72, 8))), "tee", "plate plate"),
    "hole across the joint": Joined(
        difference(union(FLANGE, cube(200, 8, 100, (0, 71, 10))), rod(30, 25, (100, 75, -10))), "tee", "plate plate"
    ),
    "plate through a slot": Joined(
        union(difference(cube(240, 160, 8), cube(120, 6, 8, (60, 77, 0))), cube(120, 6, 120, (60, 77, -60))),
        "cross",
        "plate plate",
    ),
    "brace of plate between two": Joined(
        union(
            cube(200, 150, 8),
            cube(8, 150, 150, (0, 0, 8)),
            intersection(cube(200, 150, 8, (0, 0, 90), turned("y", 40)), cube(400, 400, 400, (8, -100, 8))),
        ),
        "corner tee",
        "plate plate plate",
    ),
}
