"""Bricks on plates, on their edges, on pipes and on one another."""

from __future__ import annotations

from catalogue_beams import SHEET
from catalogue_tubes import PIPE
from joined_model import Joined
from solids import cube, difference, placed, rod, tube, turned, union

HOUSING = difference(cube(400, 200, 150), cube(384, 184, 150, (8, 8, 8)))
RIM = difference(cube(460, 260, 10, (-30, -30, 140)), cube(384, 184, 30, (8, 8, 130)))
"""A flange round the open top of a housing, lapping its walls: it owns the corners, the walls run up beside it."""

BLADE = cube(140, 8, 70, (40, -4, -35))

BRICKS = {
    "flange round a housing": Joined(
        union(HOUSING, RIM), "along corner end_on face", "beam beam brick brick plate plate plate plate plate"
    ),
    "brick over a plate's edge": Joined(union(SHEET, cube(80, 80, 60, (260, 110, 10))), "face", "brick plate"),
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
    "round boss that touches a plate's edge": Joined(union(SHEET, rod(60, 35, (265, 150, 10))), "face", "brick plate"),
    "drilled boss on a drilled plate": Joined(
        difference(union(SHEET, rod(60, 50, (150, 150, 10))), rod(100, 20, (150, 150, -5))), "face", "brick plate"
    ),
    "lug against the inside of a rim": Joined(
        union(tube(40, 200, 190), cube(80, 20, 10, (110.5, -10, 15))), "face", "brick cylinder_plate", size=10.0
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
    "leaning rod in a brick": Joined(
        union(
            cube(150, 115, 120),
            rod(280, 12, (116, 73, 103), turned("z", 135) @ turned("x", 45)),
            cube(200, 10, 120, (150, 52, 0)),
        ),
        "end_on face",
        "beam brick plate",
        {"1": "beam"},
    ),
    "leaning bar beside a boss": Joined(
        union(
            cube(135, 91, 129),
            rod(80, 18, (30, 45, 129)),
            cube(17.6, 13.2, 340, (81, 60, 95), turned("z", -15) @ turned("x", 45)),
        ),
        "end_on face",
        "beam brick brick",
        {"0": "brick", "1": "brick"},
    ),
    "plate in the nook of two bricks": Joined(
        union(cube(184, 192, 109), cube(92, 192, 57, (184, 0, 0)), cube(180, 6, 109, (184, 90, 0))),
        "face",
        "brick brick plate",
        {"0": "brick", "1": "brick", "2": "plate"},
    ),
    "brick that meets another along a line": Joined(
        union(cube(180, 44, 66), cube(44, 200, 66, (60, 44, 0)), cube(90, 44, 60, (50, 0, 66))),
        "face",
        "brick brick brick",
        {"0": "brick", "1": "brick", "2": "brick"},
    ),
    "leaning blades around a hub": Joined(
        union(rod(80, 45), *(placed(BLADE, (0, 0, 40), turned("z", a) @ turned("x", 45)) for a in (0, 90, 180, 270))),
        "face",
        "brick plate plate plate plate",
        size=15.0,
    ),
}
