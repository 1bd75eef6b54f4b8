"""Pipework: tees, crosses, mitres and wyes of one radius, sleeves and pads, flanges and closing plates, reducers."""

from __future__ import annotations

from joined_model import Joined
from solids import cube, difference, intersection, placed, rod, tube, turned, union

TWO = "cylinder_plate cylinder_plate"


def tee(radius: float, angle: float, t: float = 4.0, run: float = 300.0, wall: float = 4.0) -> str:
    """A pipe of radius 60, and one of `radius` and wall t that leaves it at `angle`."""
    lean = turned("y", angle)
    return difference(
        union(rod(run, 60), rod(300, radius, (0, 0, run / 2), lean)),
        rod(run + 100, 60 - wall, (0, 0, -50)),
        rod(350, radius - t, (0, 0, run / 2), lean),
    )


def elbow(angle: float) -> str:
    """Two pipes of radius 60 that meet in a mitre; the second leaves at `angle` from the first one's direction."""
    legs, bores = [], []
    for low, lean in ((-1000, turned("y", 0)), (0, turned("y", angle))):
        side = cube(2000, 2000, 1000, (0, 0, 0))
        half = placed(placed(side, (-1000, -1000, low)), turn=turned("y", angle / 2))
        base = -300 if low else -120
        legs.append(intersection(placed(rod(420, 60, (0, 0, base)), turn=lean), half))
        bores.append(intersection(placed(rod(422, 56, (0, 0, base - 1)), turn=lean), half))
    return difference(union(*legs), *bores)


def mitre(angle: float) -> str:
    """Two tubes of radius 60, each cut by the plane between them, that touch there."""
    half, lean = turned("y", angle / 2), turned("y", angle)
    first, second = (placed(cube(1000, 1000, 1000, (-500, -500, low)), turn=half) for low in (-1000, 0))
    return union(
        intersection(tube(420, 60, 56, (0, 0, -300)), first),
        intersection(placed(tube(420, 60, 56, (0, 0, -120)), turn=lean), second),
    )


def wye(*angles: float) -> str:
    """Pipes of radius 60 that leave one point in a plane."""
    leans = [turned("y", angle) for angle in angles]
    return difference(union(*(rod(300, 60, turn=lean) for lean in leans)), *(rod(301, 56, turn=lean) for lean in leans))


def cross(angle: float) -> str:
    """Two pipes of radius 60 that go through one another."""
    through = ((0, 0, 0), turned("y", 0)), (-200 * turned("y", angle)[:, 2] + (0, 0, 200), turned("y", angle))
    bores = (rod(420, 56, at - 10 * lean[:, 2], lean) for at, lean in through)
    return difference(union(*(rod(400, 60, at, lean) for at, lean in through)), *bores)


def padded(pad: str) -> str:
    """A pipe with a nozzle of radius 30, and a pad of wall 4 around that."""
    nozzle = turned("y", 90)
    return difference(
        union(rod(300, 60), pad, rod(150, 30, (0, 0, 150), nozzle)),
        rod(400, 56, (0, 0, -50)),
        rod(200, 27, (0, 0, 150), nozzle),
    )


def flanged(angle: float, is_through: bool) -> str:
    """A pipe of radius 40 that leans by `angle` on a flange, or goes through it, open all the way."""
    lean = turned("y", angle)
    pipe = placed(rod(400, 40, (0, 0, -200)), turn=lean)
    if not is_through:
        pipe = difference(pipe, cube(900, 900, 400, (-450, -450, -400)))
    bore = placed(rod(500, 36, (0, 0, -250)), turn=lean)
    return difference(union(cube(300, 240, 10, (-150, -120, 0)), pipe), bore)


def cone(height: float, low: float, high: float, at: float) -> str:
    """A frustum along z."""
    text = f"cylinder($fn=0,$fa=3,$fs=.2,h={height},r1={low},r2={high},center=false);"
    return placed(text, (0, 0, at))


PIPE = tube(200, 60, 56)
PIPES = {
    **{f"pipe tee of one radius at {a}": Joined(tee(60, a, run=400), "pipe", TWO) for a in (90, 60, 45)},
    **{f"pipe tee of {share} of the radius": Joined(tee(60 * share, 90), "pipe", TWO) for share in (0.95, 0.99, 0.999)},
    "thin pipe tee of 0.98 of the radius": Joined(tee(58.8, 90, 2, wall=2), "pipe", TWO),
    "pipe tee of one outer radius, thinner branch": Joined(tee(60, 90, 3), "pipe", TWO),
    "pipe tee of one outer radius, thicker branch": Joined(tee(60, 75, 5), "pipe", TWO),
    **{f"pipes in a mitre of {a}": Joined(elbow(a), "pipe", TWO) for a in (90, 30)},
    "tubes cut to a mitre of 90": Joined(mitre(90), "pipe", TWO),
    **{f"pipe cross of one radius at {a}": Joined(cross(a), "pipe", TWO) for a in (90, 60)},
    "wye of a pipe and two legs": Joined(wye(180, 30, -30), "pipe", TWO + " cylinder_plate"),
    "wye of three pipes": Joined(wye(0, 120, 240), "pipe", TWO + " cylinder_plate"),
    "pipes in a sleeve, apart": Joined(
        union(tube(190, 60, 56), tube(190, 60, 56, (0, 0, 210)), tube(100, 64, 60, (0, 0, 150))),
        "lap",
        TWO + " cylinder_plate",
    ),
    "pipe in the end of another": Joined(union(PIPE, tube(100, 56, 52, (0, 0, 150))), "lap", TWO),
    "doubler over a quarter of a pipe": Joined(
        union(tube(300, 60, 56), intersection(tube(100, 64, 60, (0, 0, 100)), cube(200, 200, 400))), "lap", TWO
    ),
    "nozzle with a square pad": Joined(
        padded(intersection(rod(100, 64, (0, 0, 100)), cube(100, 90, 200, (0, -45, 100)))),
        "lap pipe",
        TWO + " cylinder_plate",
    ),
    "nozzle with a round pad": Joined(
        padded(intersection(rod(300, 64), rod(200, 50, (0, 0, 150), turned("y", 90)))),
        "lap pipe",
        TWO + " cylinder_plate",
    ),
    **{
        f"pipe leaning by {a} {how} a flange": Joined(flanged(a, how == "through"), "pipe", "cylinder_plate plate")
        for a, how in ((30, "through"), (45, "through"), (30, "on"))
    },
    "flange of the pipe's outer diameter": Joined(
        union(PIPE, tube(10, 60, 30, (0, 0, 200))), "pipe", "cylinder_plate plate", size=12.0
    ),
    "flange slipped over a pipe": Joined(union(PIPE, tube(10, 170, 60, (0, 0, 170))), "pipe", "cylinder_plate plate"),
    "plate that closes a pipe's end": Joined(
        union(PIPE, rod(8, 60, (0, 0, 200))), "pipe", "cylinder_plate plate", size=12.0
    ),
    "plate within a pipe's end": Joined(
        union(PIPE, rod(8, 56, (0, 0, 192))), "pipe", "cylinder_plate plate", size=12.0
    ),
    "wider plate on a pipe's end": Joined(
        union(PIPE, rod(8, 75, (0, 0, 200))), "pipe", "cylinder_plate plate", size=12.0
    ),
    "pipes with a reducer between": Joined(
        union(
            PIPE,
            difference(cone(80, 60, 40, 200), cone(80, 56, 36, 200)),
            tube(120, 40, 36, (0, 0, 280)),
        ),
        "face",
        "brick " + TWO,
    ),
}
