"""The catalogue: a small model for every way in which members meet, with the joints that it is to have."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from shapely.geometry import LineString
from solids import cube, difference, extrusion, intersection, placed, rod, tube, turned, union


@dataclass(frozen=True)
class Joined:
    """text: the model. kinds: of its joints, each once, in alphabetical order. types: of its segments, likewise.

    overrides: by node path. size: of the elements.
    """

    text: str
    kinds: str
    types: str
    overrides: Mapping[str, str] = field(default_factory=dict)
    size: float = 20.0


# ---------------------------------------------------------------- plates


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

# ---------------------------------------------------------------- beams


def i_bar(length, at=(0.0, 0.0, 0.0), turn=None) -> str:
    """An I of 40 by 60 along z."""
    outline = [(-20, -30), (20, -30), (20, -24), (3, -24), (3, 24), (20, 24), (20, 30), (-20, 30), (-20, 24),
               (-3, 24), (-3, -24), (-20, -24)]  # fmt: skip
    return extrusion(outline, length, at, turn)


SHEET = cube(300, 300, 10)
BLOCK = cube(120, 120, 120)
BEAMS = {
    "post on a plate": Joined(union(SHEET, cube(30, 30, 400, (135, 135, 10))), "end_on", "beam plate"),
    "round post on a plate": Joined(union(SHEET, rod(400, 15, (150, 150, 10))), "end_on", "beam plate"),
    "I post on a plate": Joined(union(SHEET, i_bar(800, (150, 150, 10))), "end_on", "beam plate"),
    "leaning post on a plate": Joined(
        union(
            SHEET,
            difference(cube(30, 30, 500, (100, 135, -20), turned("y", 25)), cube(900, 900, 410, (-300, -300, -400))),
        ),
        "end_on",
        "beam plate",
        {"1": "beam"},
    ),
    "post over a plate's edge": Joined(union(SHEET, cube(30, 30, 400, (285, 135, 10))), "end_on", "beam plate"),
    "post on a plate's corner": Joined(union(SHEET, cube(30, 30, 400, (285, 285, 10))), "end_on", "beam plate"),
    "post flush with a plate's edge": Joined(union(SHEET, cube(30, 30, 400, (270, 135, 10))), "end_on", "beam plate"),
    "post over a hole": Joined(
        union(difference(SHEET, rod(30, 12, (150, 150, -5))), cube(40, 40, 500, (130, 130, 10))), "end_on", "beam plate"
    ),
    "beam against a plate's edge": Joined(union(SHEET, cube(400, 30, 30, (300, 135, -10))), "end_on", "beam plate"),
    "post on a tee": Joined(
        union(cube(300, 200, 10), cube(300, 8, 100, (0, 96, -100)), cube(30, 30, 400, (135, 85, 10))),
        "end_on tee",
        "beam plate plate",
    ),
    "beam on a pipe": Joined(
        union(tube(300, 60, 56), difference(rod(500, 12, (0, 0, 150), turned("y", 90)), rod(400, 58, (0, 0, -50)))),
        "end_on",
        "beam cylinder_plate",
    ),
    "square beam on a pipe": Joined(
        union(tube(300, 60, 56), difference(cube(500, 24, 24, (0, -12, 138)), rod(400, 59, (0, 0, -50)))),
        "end_on",
        "beam cylinder_plate",
    ),
    "beam on a brick": Joined(union(BLOCK, cube(30, 30, 400, (45, 45, 120))), "end_on", "beam brick"),
    "beam over a brick's edge": Joined(union(BLOCK, cube(30, 30, 400, (105, 45, 120))), "end_on", "beam brick"),
    "beam set into a brick": Joined(union(BLOCK, cube(30, 30, 400, (45, 45, 80))), "end_on", "beam brick"),
    "beam through a brick": Joined(union(BLOCK, cube(30, 30, 800, (45, 45, -300))), "end_on", "beam beam brick"),
    "beam along a brick": Joined(union(cube(200, 120, 120), cube(500, 30, 30, (0, 45, 120))), "along", "beam brick"),
    "beam on a beam": Joined(union(cube(900, 40, 40), cube(30, 400, 30, (435, 40, 5))), "end_on", "beam beam"),
    "beam end to end": Joined(union(cube(400, 40, 40), cube(400, 30, 30, (400, 5, 5))), "end_on", "beam beam"),
    "beams end to end, eccentric": Joined(
        union(cube(400, 40, 40), cube(400, 30, 30, (400, 0, 0))), "end_on", "beam beam"
    ),
    "beams in an L": Joined(union(cube(900, 40, 40), cube(40, 800, 40, (0, 40, 0))), "end_on", "beam beam"),
    "beams in an L, mitred": Joined(
        extrusion([(0, 0), (500, 0), (500, 40), (40, 40), (40, 500), (0, 500)], 40), "end_on", "beam beam"
    ),
    "beams crossing in one plane": Joined(
        union(cube(900, 40, 40), cube(30, 800, 30, (235, -380, 5))), "end_on", "beam beam beam"
    ),
    "beams crossing in contact": Joined(
        union(cube(900, 40, 40), cube(40, 900, 40, (430, -430, 40))), "along", "beam beam"
    ),
    "beams in lap": Joined(union(cube(900, 40, 40), cube(600, 30, 30, (700, 5, 40))), "along", "beam beam"),
    "beams side by side": Joined(
        union(i_bar(800), i_bar(800, (40, 0, 0))), "along", "beam beam", {"0": "beam", "1": "beam"}
    ),
    "round bars crossing": Joined(
        union(rod(900, 20), rod(800, 15, (-400, 0, 450), turned("y", 90))), "end_on", "beam beam beam"
    ),
    "stiffener along a plate": Joined(union(cube(600, 200, 8), cube(600, 20, 20, (0, 90, 8))), "along", "beam plate"),
    "stiffener askew on a plate": Joined(
        union(cube(500, 300, 8), cube(400, 20, 20, (60, 60, 8), turned("z", 23))), "along", "beam plate"
    ),
    "stiffener past a plate's edge": Joined(
        union(cube(400, 200, 8), cube(500, 20, 20, (-50, 90, 8))), "along", "beam plate"
    ),
    "stiffener along a plate's edge": Joined(
        union(cube(500, 200, 10), cube(500, 20, 30, (0, 200, -10))), "along", "beam plate"
    ),
    "stiffeners on both faces": Joined(
        union(cube(500, 200, 8), cube(500, 20, 20, (0, 90, 8)), cube(500, 20, 20, (0, 90, -20))),
        "along",
        "beam beam plate",
    ),
    "stiffeners crossing a plate's tee": Joined(
        union(cube(500, 200, 8), cube(8, 200, 100, (246, 0, -100)), cube(500, 20, 20, (0, 90, 8))),
        "along tee",
        "beam plate plate",
    ),
    "bar through a plate": Joined(
        union(cube(200, 200, 10), cube(30, 30, 700, (85, 85, -300))), "end_on", "beam beam plate"
    ),
    "round bar through a plate": Joined(
        union(cube(200, 200, 10), rod(700, 12, (100, 100, -300))), "end_on", "beam beam plate"
    ),
    "brace through a plate": Joined(
        union(cube(240, 200, 10), cube(20, 20, 600, (20, 90, -250), turned("y", 25))), "end_on", "beam beam plate"
    ),
    "bar along a pipe": Joined(
        union(tube(300, 60, 56), difference(cube(24, 24, 300, (50, -12, 0)), rod(400, 58, (0, 0, -50)))),
        "along",
        "beam cylinder_plate",
    ),
    "bar in a pipe's axis": Joined(
        union(tube(300, 60, 56), rod(8, 60, (0, 0, 146)), rod(400, 10, (0, 0, 154))),
        "end_on pipe",
        "beam cylinder_plate plate",
    ),
}

# ---------------------------------------------------------------- tubes


def branch(radius: float, angle: float, off: float = 0.0, t: float = 3.0) -> str:
    """A pipe of radius 60 and one of `radius` that leaves it at `angle`, `off` its axis, open to one another."""
    lean = turned("y", angle)
    return difference(
        union(rod(300, 60), rod(150, radius, (0, off, 130), lean)),
        rod(400, 56, (0, 0, -50)),
        rod(200, radius - t, (0, off, 130), lean),
    )


def leaning_pipe(angle: float) -> str:
    """A pipe that stands on a plate at `angle` from upright."""
    pipe = difference(tube(250, 40, 36, (110, 120, -40), turned("y", angle)), cube(900, 900, 405, (-300, -300, -400)))
    return union(cube(300, 240, 10), pipe)


def half(text: str, low: float = 0.0) -> str:
    """What of it lies on y >= low."""
    return intersection(text, cube(1000, 500, 1000, (-500, low, -500)))


PIPE = tube(200, 60, 56)
TUBES = {
    "pipe on a plate": Joined(union(cube(240, 240, 8, (-120, -120, -8)), PIPE), "pipe", "cylinder_plate plate"),
    "pipe on a plate, off its axis": Joined(
        union(cube(300, 200, 8, (-100, -80, -8)), PIPE), "pipe", "cylinder_plate plate"
    ),
    "pipe on a pierced plate": Joined(
        union(difference(cube(240, 240, 8, (-120, -120, -8)), rod(20, 56, (0, 0, -10))), PIPE),
        "pipe",
        "cylinder_plate plate",
    ),
    "pipe with a flange at its end": Joined(
        difference(union(rod(10, 100), rod(200, 60)), rod(300, 56, (0, 0, -50))), "pipe", "cylinder_plate plate"
    ),
    "flange around a pipe": Joined(
        difference(union(rod(10, 100, (0, 0, 80)), rod(200, 60)), rod(300, 56, (0, 0, -50))),
        "pipe",
        "cylinder_plate plate",
    ),
    "pipe through a plate that closes it": Joined(
        union(cube(240, 240, 8, (-120, -120, 90)), PIPE), "pipe", "cylinder_plate plate"
    ),
    "pipe over a plate's edge": Joined(
        union(cube(200, 240, 8, (-180, -120, -8)), PIPE), "pipe", "cylinder_plate plate"
    ),
    **{
        f"pipe leaning by {a} on a plate": Joined(
            leaning_pipe(a), "pipe", "cylinder_plate plate", {"0": "plate", "1": "cylinder_plate"}
        )
        for a in (15, 30, 45)
    },
    "pipe leaning through a plate": Joined(
        union(cube(300, 240, 10), tube(250, 40, 36, (90, 120, -100), turned("y", 30))),
        "pipe",
        "cylinder_plate cylinder_plate plate",
        {"0": "plate", "1": "cylinder_plate"},
    ),
    **{
        f"branch of {r} at {a}, {o} off": Joined(branch(r, a, o), "pipe", "cylinder_plate cylinder_plate")
        for r, a, o in ((30, 90, 0), (25, 90, 20), (25, 60, 15), (50, 90, 0), (57, 90, 0))
    },
    "half pipe on a plate": Joined(
        union(half(PIPE), cube(240, 160, 8, (-120, -40, -8))), "pipe", "cylinder_plate plate"
    ),
    "half pipe lying on a plate": Joined(
        union(half(placed(PIPE, turn=turned("y", 90))), cube(200, 8, 200, (0, -8, -100))),
        "pipe",
        "cylinder_plate plate",
    ),
    "half pipe with flanges": Joined(
        union(half(PIPE), cube(60, 4, 200, (56, 0, 0)), cube(60, 4, 200, (-116, 0, 0))),
        "pipe",
        "cylinder_plate plate plate",
    ),
    "trough with tangent sides": Joined(
        union(difference(PIPE, cube(200, 100, 400, (-100, 0, -50))), *(cube(4, 80, 200, (x, 0, 0)) for x in (56, -60))),
        "pipe",
        "cylinder_plate plate plate",
    ),
    "pipes end to end": Joined(
        union(tube(150, 60, 56), tube(150, 60, 54, (0, 0, 150))), "pipe", "cylinder_plate cylinder_plate"
    ),
    "pipes end to end, inside flush": Joined(
        union(tube(150, 60, 56), tube(150, 62, 56, (0, 0, 150))), "pipe", "cylinder_plate cylinder_plate"
    ),
    "pipes end to end, mid-surfaces level": Joined(
        union(tube(150, 60, 56), tube(150, 61, 55, (0, 0, 150))), "pipe", "cylinder_plate cylinder_plate"
    ),
    "pipes with a ring between": Joined(
        union(
            tube(120, 60, 56),
            difference(rod(8, 80, (0, 0, 120)), rod(20, 40, (0, 0, 115))),
            tube(120, 44, 40, (0, 0, 128)),
        ),
        "pipe",
        "cylinder_plate cylinder_plate plate",
    ),
    "pipe sunk into a plate": Joined(
        union(cube(240, 200, 8, (-120, 0, -62)), placed(PIPE, turn=turned("x", -90))), "pipe", "cylinder_plate plate"
    ),
    "diaphragm": Joined(union(PIPE, rod(6, 56, (0, 0, 97))), "pipe", "cylinder_plate plate"),
    "half diaphragm": Joined(union(PIPE, half(rod(6, 56, (0, 0, 97)))), "pipe", "cylinder_plate plate"),
    "plate through a pipe": Joined(union(PIPE, cube(200, 6, 100, (-100, -3, 50))), "pipe", "cylinder_plate plate"),
    "plate part-way through a pipe": Joined(
        union(PIPE, cube(120, 6, 100, (0, -3, 50))), "pipe", "cylinder_plate plate"
    ),
    "fin along a pipe": Joined(union(PIPE, cube(80, 6, 120, (58, -3, 40))), "pipe", "cylinder_plate plate"),
    "partition in a pipe": Joined(
        union(PIPE, intersection(cube(120, 6, 200, (-60, -3, 0)), rod(200, 58))), "pipe", "cylinder_plate plate"
    ),
    "rib between a pipe and a plate": Joined(
        union(
            cube(280, 280, 8, (-140, -140, -8)),
            PIPE,
            extrusion([(58, 0), (120, 0), (58, 80)], 6, (0, 3, 0), turned("x", 90)),
        ),
        "pipe tee",
        "cylinder_plate plate plate",
    ),
    "spokes between two pipes": Joined(
        union(
            tube(60, 120, 115),
            tube(60, 30, 26),
            *(cube(90, 6, 60, turned("z", a) @ (28, -3, 0), turned("z", a)) for a in (0, 90, 180, 270)),
        ),
        "pipe",
        " ".join(["cylinder_plate"] * 2 + ["plate"] * 4),
    ),
    "tank": Joined(difference(rod(150, 80), rod(138, 75, (0, 0, 6))), "pipe", "cylinder_plate plate plate", size=12.0),
    "tank with a nozzle": Joined(
        difference(
            union(difference(rod(150, 80), rod(138, 75, (0, 0, 6))), rod(120, 25, (40, 0, 75), turned("y", 90))),
            rod(200, 22, (40, 0, 75), turned("y", 90)),
        ),
        "pipe",
        "cylinder_plate cylinder_plate plate plate",
        size=12.0,
    ),
}

# ---------------------------------------------------------------- bricks

BRICKS = {
    "brick on a plate": Joined(union(SHEET, cube(80, 80, 60, (110, 110, 10))), "face", "brick plate"),
    "brick on both faces": Joined(
        union(SHEET, cube(80, 80, 60, (110, 110, 10)), cube(60, 60, 60, (130, 130, -60))), "face", "brick brick plate"
    ),
    "brick against a plate's edge": Joined(
        union(cube(200, 120, 10), cube(80, 80, 80, (200, 20, -35))), "face", "brick plate"
    ),
    "plate's edge on a brick": Joined(
        union(cube(150, 120, 80), cube(150, 10, 150, (0, 55, 80))), "face", "brick plate"
    ),
    "plate's edge on a brick, askew": Joined(
        union(cube(150, 150, 80), cube(120, 8, 120, (30, 30, 80), turned("z", 30))), "face", "brick plate"
    ),
    "plate's edge on a brick, longer": Joined(
        union(cube(100, 100, 80), cube(200, 8, 120, (-50, 46, 80))), "face", "brick plate"
    ),
    "plate set into a brick": Joined(
        union(cube(150, 120, 80), cube(150, 10, 150, (0, 55, 40))), "face", "brick plate", {"0": "brick", "1": "plate"}
    ),
    "brick amid a plate": Joined(
        union(difference(cube(240, 240, 10), cube(80, 80, 10, (80, 80, 0))), cube(80, 80, 80, (80, 80, -35))),
        "face",
        "brick plate",
    ),
    "brick on a brick": Joined(
        union(cube(100, 100, 60), cube(100, 100, 50, (0, 0, 60))), "face", "brick brick", {"0": "brick", "1": "brick"}
    ),
    "small brick on a brick": Joined(union(cube(120, 120, 60), cube(50, 50, 50, (30, 40, 60))), "face", "brick brick"),
    "brick askew on a brick": Joined(
        union(cube(120, 120, 60), cube(60, 60, 50, (50, 20, 60), turned("z", 30))), "face", "brick brick"
    ),
    "brick over a brick's edge": Joined(
        union(cube(120, 120, 60), cube(60, 60, 60, (90, 30, 60))), "face", "brick brick", {"0": "brick", "1": "brick"}
    ),
    "bricks side by side": Joined(union(cube(100, 100, 60), cube(60, 60, 90, (100, 20, 0))), "face", "brick brick"),
    "round brick on a brick": Joined(union(cube(120, 120, 60), rod(50, 30, (60, 60, 60))), "face", "brick brick"),
    "peg in a brick": Joined(
        union(difference(cube(120, 120, 60), rod(80, 30, (60, 60, -10))), rod(60, 30, (60, 60, 0))),
        "face",
        "brick brick",
        {"0": "brick", "1": "brick"},
    ),
    "round boss on a plate": Joined(union(SHEET, rod(60, 35, (150, 150, 10))), "face", "brick plate"),
    "drilled boss on a drilled plate": Joined(
        difference(union(SHEET, rod(60, 50, (150, 150, 10))), rod(100, 20, (150, 150, -5))), "face", "brick plate"
    ),
    "pipe on a brick": Joined(union(cube(200, 200, 80, (-100, -100, -80)), PIPE), "face", "brick cylinder_plate"),
    "ball on a rod": Joined(
        union(rod(200, 6), placed("sphere($fn=0,$fa=6,$fs=2,r=25);", (0, 0, 220))), "end_on", "beam brick"
    ),
    "brick on a tee": Joined(
        union(cube(200, 150, 10), cube(200, 8, 80, (0, 71, -80)), cube(60, 60, 60, (70, 45, 10))),
        "face tee",
        "brick plate plate",
    ),
    "brick in a corner of plates": Joined(
        union(cube(150, 150, 8), cube(8, 150, 100, (0, 0, 8)), cube(60, 60, 60, (8, 45, 8))),
        "corner face",
        "brick plate plate",
    ),
}

CATALOGUE = {**PLATES, **BEAMS, **TUBES, **BRICKS}
