"""Beams on everything: end-on, along, through, crossing, in lap."""

from __future__ import annotations

from joined_model import Joined
from solids import cube, difference, extrusion, placed, rod, tube, turned, union


def i_bar(length, at=(0.0, 0.0, 0.0), turn=None) -> str:
    """An I of 40 by 60 along z."""
    outline = [(-20, -30), (20, -30), (20, -24), (3, -24), (3, 24), (20, 24), (20, 30), (-20, 30), (-20, 24),
               (-3, 24), (-3, -24), (-20, -24)]  # fmt: skip
    return extrusion(outline, length, at, turn)


SHEET = cube(300, 300, 10)
BLOCK = cube(120, 120, 120)
BEAMS = {
    "beams crossing askew": Joined(
        union(cube(900, 40, 40), cube(900, 30, 30, (170, -320, 40), turned("z", 50))), "along", "beam beam"
    ),
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
    "round post that touches a plate's edge": Joined(
        union(SHEET, rod(400, 15, (285, 135, 10))), "end_on", "beam plate"
    ),
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
    "stiffeners askew side by side": Joined(
        union(
            cube(625, 387, 6),
            cube(635, 34, 22, (-60, 125.775, 6), turned("z", 7)),
            cube(625, 39, 29, (0, 222.525, 6)),
        ),
        "along",
        "beam beam plate",
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
    "tee stiffeners of web and flange": Joined(
        union(
            cube(900, 400, 8),
            *(cube(900, 6, 70, (0, y - 3, 8)) for y in (100, 300)),
            *(cube(900, 60, 8, (0, y - 30, 78)) for y in (100, 300)),
        ),
        "along",
        "beam beam beam beam plate",
        size=40.0,
    ),
    "stiffeners through frames": Joined(
        union(
            cube(900, 400, 8),
            *(cube(900, 14, 30, (0, y - 7, 8)) for y in (100, 300)),
            *(cube(8, 400, 120, (x, 0, 8)) for x in (296, 596)),
        ),
        "along end_on tee",
        " ".join(["beam"] * 6 + ["plate"] * 3),
        size=40.0,
    ),
    "stringers on a shell": Joined(
        union(
            tube(900, 150, 146),
            *(cube(20, 12, 900, turned("z", a) @ (150, -6, 0), turned("z", a)) for a in (0, 77, 130, 240)),
        ),
        "along",
        "beam beam beam beam cylinder_plate",
        size=40.0,
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
    "tread on a leaning stringer": Joined(
        union(
            placed(cube(1200, 40, 60), turn=turned("y", -35)),
            cube(200, 400, 8, (400, 40, 300)),
        ),
        "end_on",
        "beam plate",
        {"0": "beam"},
    ),
    "bar across a pipe's wall, off its axis": Joined(
        union(tube(85, 42, 38, (0, 0, 0)), cube(300, 12, 12, (-333, 21, 30))),
        "end_on",
        "beam cylinder_plate",
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
