"""Cylinder-plates: on plates, in one another, with plates along and across them."""

from __future__ import annotations

from joined_model import Joined
from solids import cube, difference, extrusion, intersection, placed, rod, tube, turned, union


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


def careless(braces: list[tuple[float, float, float]], along: float = 300.0) -> str:
    """A chord of radius 60 and braces (radius, angle, place), all tubes of their own, drawn to its axis."""
    return union(
        tube(along, 60, 56),
        *(tube(220, radius, radius - 3, (0, 0, z), turned("y", angle)) for radius, angle, z in braces),
    )


def rounded(width: float, depth: float, radius: float, height: float) -> str:
    """A bar whose four corners along z are rounded."""
    return union(
        cube(width, depth - 2 * radius, height, (-width / 2, radius - depth / 2, 0)),
        cube(width - 2 * radius, depth, height, (radius - width / 2, -depth / 2, 0)),
        *(
            rod(height, radius, (sx * (width / 2 - radius), sy * (depth / 2 - radius), 0))
            for sx in (-1, 1)
            for sy in (-1, 1)
        ),
    )


PIPE = tube(200, 60, 56)
TUBES = {
    "box section with rounded corners": Joined(
        difference(rounded(200, 120, 40, 300), placed(rounded(192, 112, 36, 302), (0, 0, -1))),
        "pipe",
        " ".join(["cylinder_plate"] * 4 + ["plate"] * 4),
    ),
    "brace drawn to a chord's axis": Joined(careless([(30, 60, 150)]), "pipe", "cylinder_plate cylinder_plate"),
    "braces drawn to a chord's axis, apart": Joined(
        careless([(20, 60, 70), (20, 120, 230)]), "pipe", "cylinder_plate cylinder_plate cylinder_plate"
    ),
    "braces drawn to one point of a chord's axis": Joined(
        careless([(25, 45, 150), (25, 135, 150)]), "pipe", "cylinder_plate cylinder_plate cylinder_plate"
    ),
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
        for r, a, o in ((30, 90, 0), (30, 45, 0), (25, 90, 20), (25, 60, 15), (50, 90, 0), (57, 90, 0))
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
        union(cube(240, 200, 8, (-120, 0, -62)), placed(PIPE, turn=turned("x", -90))), "lap", "cylinder_plate plate"
    ),
    "sleeve on a pipe": Joined(union(PIPE, tube(80, 64, 60, (0, 0, 60))), "lap", "cylinder_plate cylinder_plate"),
    "pipe that slides out of another": Joined(
        union(PIPE, tube(200, 56, 52, (0, 0, 120))), "lap", "cylinder_plate cylinder_plate"
    ),
    "sleeve let into a pipe": Joined(union(PIPE, tube(80, 66, 59, (0, 0, 60))), "lap", "cylinder_plate cylinder_plate"),
    "rings about a pipe": Joined(
        union(PIPE, *(tube(6, 90, 59, (0, 0, z)) for z in (40, 97, 150))), "pipe", "cylinder_plate plate plate plate"
    ),
    "frames about a shell": Joined(
        union(
            tube(300, 150, 146),
            *(tube(6, 190, 148, (0, 0, z)) for z in (70, 200)),
            *(tube(36, 196, 190, (0, 0, z - 15)) for z in (70, 200)),
        ),
        "pipe",
        " ".join(["cylinder_plate"] * 3 + ["plate"] * 2),
        size=30.0,
    ),
    "saddle on a pipe": Joined(union(PIPE, half(tube(80, 64, 60, (0, 0, 60)))), "lap", "cylinder_plate cylinder_plate"),
    **{
        f"plate on a pipe, {depth} deep in it": Joined(
            union(PIPE, cube(200, 6, 160, (-110, 60 - depth, 20))), "lap", "cylinder_plate plate"
        )
        for depth in (0, 0.01, 0.5, 2, 3.5)
    },
    "plate on a pipe by its edge": Joined(union(PIPE, cube(120, 6, 200, (0, 60, 0))), "lap", "cylinder_plate plate"),
    "pipe between two plates": Joined(
        union(PIPE, *(cube(300, 6, 200, (-150, y, 0)) for y in (60, -66))), "lap", "cylinder_plate plate plate"
    ),
    "pipes on a plate": Joined(
        union(cube(400, 6, 200, (-80, 60, 0)), PIPE, tube(200, 60, 56, (150, 0, 0))),
        "lap",
        "cylinder_plate cylinder_plate plate",
    ),
    **{
        f"saddle plate that ends {end} off a pipe's axis": Joined(
            union(PIPE, difference(cube(120 - end, 180, 6, (-120, -90, 100)), rod(40, 60, (0, 0, 80)))),
            "pipe",
            "cylinder_plate plate",
        )
        for end in (20, 48)
    },
    "gussets against a pipe": Joined(
        union(
            tube(300, 60, 56),
            *(cube(80, 6, 120, turned("z", a) @ (60, -3, 90), turned("z", a)) for a in (0, 77, 130, 240)),
        ),
        "pipe",
        "cylinder_plate plate plate plate plate",
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
