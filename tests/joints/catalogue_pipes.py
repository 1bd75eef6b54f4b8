"""Cylinder-plates of one radius, or nearly so: tees, crosses, mitres and wyes of pipes."""

from __future__ import annotations

from joined_model import Joined
from solids import cube, difference, intersection, placed, rod, turned, union

TWO = "cylinder_plate cylinder_plate"


def tee(radius: float, angle: float, t: float = 4.0, run: float = 300.0) -> str:
    """A pipe of radius 60 and wall 4, and one of `radius` and wall t that leaves it at `angle`."""
    lean = turned("y", angle)
    return difference(
        union(rod(run, 60), rod(300, radius, (0, 0, run / 2), lean)),
        rod(run + 100, 56, (0, 0, -50)),
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


def wye(*angles: float) -> str:
    """Pipes of radius 60 that leave one point in a plane."""
    leans = [turned("y", angle) for angle in angles]
    return difference(union(*(rod(300, 60, turn=lean) for lean in leans)), *(rod(301, 56, turn=lean) for lean in leans))


PIPES = {
    **{f"pipe tee of one radius at {a}": Joined(tee(60, a, run=400), "pipe", TWO) for a in (90, 60, 45)},
    **{f"pipe tee of {share} of the radius": Joined(tee(60 * share, 90), "pipe", TWO) for share in (0.95, 0.99, 0.999)},
    "pipe tee of one outer radius, thinner branch": Joined(tee(60, 90, 3), "pipe", TWO),
    "pipe tee of one outer radius, thicker branch": Joined(tee(60, 75, 5), "pipe", TWO),
    **{f"pipes in a mitre of {a}": Joined(elbow(a), "pipe", TWO) for a in (90, 30)},
    "wye of three pipes": Joined(wye(0, 120, 240), "pipe", TWO + " cylinder_plate"),
}
