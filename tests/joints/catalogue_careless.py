"""Plates drawn in a hurry: a hair apart, let into one another a little, overlapping where they should butt."""

from __future__ import annotations

from joined_model import Joined
from solids import cube, difference, extrusion, union

ANGLE = [(0, 0), (46, 0), (46, 4), (4, 4), (4, 46), (0, 46)]
CELL = union(
    difference(cube(400, 200, 250), cube(376, 176, 400, (12, 12, 12))),
    cube(376, 176, 10, (12, 12, 203)),
)

LEG, HEIGHT = 40.55202215855387, 227.89808538483032
"""With these the post's lower end lies in the mid-surface of the floor to the last digit."""

CARELESS = {
    "post of angle that ends in the mid-surfaces of two floors": Joined(
        union(
            cube(349, 319, 4),
            cube(349, 319, 4, (0, 0, HEIGHT)),
            extrusion([(0, 0), (LEG, 0), (LEG, 4), (4, 4), (4, LEG), (0, LEG)], HEIGHT, (313.4357233485638, 5, 2)),
        ),
        "corner tee",
        "plate plate plate plate",
    ),
    "webs let into their flange, one at its corner": Joined(
        union(cube(327, 346, 4), cube(327, 12, 100, (0, 173, 3.5)), cube(12, 346, 80, (326.5, 0, 3.5))),
        "corner tee",
        "plate plate plate",
    ),
    "doubled plate, each half longer on one side": Joined(
        union(cube(180, 150, 5), cube(180, 150, 6, (15, 0, 5.001)), cube(5, 150, 120, (0, 0, -60))),
        "lap tee",
        "plate plate plate",
    ),
    "doubled web, one half a hair into the other": Joined(
        union(cube(270, 190, 5), cube(270, 5, 100, (0, 95, 5)), cube(270, 5, 80, (0, 99.999, 5))),
        "step tee",
        "plate plate plate",
    ),
    "lap over a web, three plates round one corner": Joined(
        union(cube(300, 270, 5), cube(350, 240, 5, (20, 0, 4.999)), cube(5, 270, 80, (157, 0, 0))),
        "corner lap tee",
        "plate plate plate",
    ),
    "webs a hair apart, crossed by a third": Joined(
        union(
            cube(400, 400, 6),
            cube(400, 4, 100, (0, 199, 6)),
            cube(400, 4, 80, (0, 203.01, 6)),
            cube(4, 400, 80, (199, 0, 0)),
        ),
        "tee",
        "plate plate plate plate",
    ),
    "shelf let into another shelf but for a skin": Joined(
        union(CELL, cube(388, 188, 4, (6, 6, 209.015))), "corner tee", "plate plate plate plate plate plate"
    ),
    "back panel let half into shelves and sides": Joined(
        union(
            cube(467, 283, 10),
            *(cube(467, 263, 12, (5, 0, z)) for z in (250, 388)),
            *(cube(10, 276, 400, (x, 0, 0)) for x in (0, 467)),
            cube(477, 5, 400, (0, 260.5, 0)),
        ),
        "along corner end_on tee",
        "beam beam beam beam beam plate plate plate plate plate plate plate plate",
    ),
    "shelves let half into sides that go on behind": Joined(
        union(
            *(cube(4, 170, 400, (x, 0, 0)) for x in (0, 400)),
            *(cube(404, 160, 4, (0, 10, z)) for z in (0, 396)),
            cube(404, 3, 400, (0, 160, 0)),
            *(cube(404, 170, 4, (0, 0, z)) for z in (0, 396)),
        ),
        "along corner end_on",
        "beam beam beam beam plate plate plate plate plate",
    ),
    "post of angle cut along by a panel": Joined(
        union(
            cube(437, 158, 12, (0, 10, 0)),
            extrusion(ANGLE, 600, (5, 130, -30)),
            cube(437, 3, 500, (0, 156, 0)),
        ),
        "along corner cross end_on tee",
        "beam plate plate plate plate",
    ),
}
