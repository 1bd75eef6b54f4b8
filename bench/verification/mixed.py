"""Frames and models of several parts: a portal, half beam and half brick, the table, the bracket."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from kernel.connect.model import Model
from verification.common import E, G, Row, blank, built, converged, freedoms, rows, solved
from verification.joined import COUPLINGS, against_solid, mean
from verification.loading import Case, at, frequencies, held_at, spread

PORTAL_TEXT = """LEFT = BLO(40, 40, 1980)
RIGHT = BLO(40, 40, 1980) AT (MOVX=3000)
BEAM = BLO(3040, 40, 40) AT (MOVZ=1980)
PORTAL = LEFT UN RIGHT UN BEAM
OUT PORTAL
"""


def portal() -> Iterator[Row]:
    """Sway of a portal with clamped feet, by slope deflection on the members' axes (Kleinlogel, frame 46)."""
    second, height, span, force = 40**4 / 12, 2000.0, 3000.0, 1000.0
    # top: 4 theta / h - 6 d / h^2 + 6 theta / l = 0; storey: 2 E I (12 d / h^3 - 6 theta / h^2) = F
    turn = 6 / height**2 / (4 / height + 6 / span)  # theta / d
    reference = force / (2 * E * second * (12 / height**3 - 6 * turn / height**2))
    model = built(PORTAL_TEXT, size=100.0).model
    top = model.mesh.nodes[:, 2].max()
    case = Case(held_at(model, at(2, 0)), spread(model, lambda p: at(2, top)(p) & (p[:, 0] < 1.0), (force, 0, 0)))

    def sway(solver):
        return max(solved(solver, model, case).displacements[node, 0] for node in case.forces)

    row = blank("portal frame of three touching bars", "sway, mm", "beams", reference, 0.03)
    yield from rows(row, model, sway)


HALVES_TEXT = """ROOT = BLO(200, 30, 40)
REST = BLO(200, 30, 40) AT (MOVX=200)
BAR = ROOT UN REST
OUT BAR
"""


def halves() -> Iterator[Row]:
    """A cantilever whose root is a brick and whose rest is a beam, joined by each coupling (Timoshenko)."""
    second, area, length = 30 * 40**3 / 12, 1200.0, 400.0
    reference = 1000 * length**3 / (3 * E * second) + 1000 * length / (G * 5 / 6 * area)
    for coupling in COUPLINGS:
        meshed = built(HALVES_TEXT, (("ROOT", "brick"), ("REST", "beam")), size=10.0, coupling=coupling)
        model = meshed.model
        case = Case(held_at(model, at(0, 0)), spread(model, at(0, length), (0, 0, -1000.0)))

        def tip(solver, model=model, case=case):
            (node,) = case.forces
            return -solved(solver, model, case).displacements[node, 2]

        row = blank("half brick, half beam", "tip, mm", coupling, reference, 0.02)
        yield from rows(row, model, tip)


TABLE_TEXT = """TOP = BLO(800, 500, 20) AT (MOVZ=680)
LEG = BLO(40, 40, 680)
LEGS = LEG UN (LEG AT (MOVX=760)) UN (LEG AT (MOVY=460)) UN (LEG AT (MOVX=760, MOVY=460))
TABLE = TOP UN LEGS
OUT TABLE
"""
_TABLE_OF_BRICKS = (("TOP", "brick"), ("LEGS", "brick"))


def table() -> Iterator[Row]:
    """Mean sag of a table's top under 2000 N, beams and plate against the same table all of quadratic bricks."""
    solids = {size: built(TABLE_TEXT, _TABLE_OF_BRICKS, size=size, order=2).model for size in (10.0, 7.0)}
    mixed = {f"distributing, {size:g} mm": built(TABLE_TEXT, size=size).model for size in (50.0, 25.0, 12.5)}
    mixed |= {f"{kind}, 50 mm": built(TABLE_TEXT, size=50.0, coupling=kind).model for kind in ("work", "rigid")}

    def sag(model: Model, solver: str) -> float:
        top = at(2, model.mesh.nodes[:, 2].max(), 1e-3)
        case = Case(held_at(model, at(2, 0)), spread(model, top, (0, 0, -2000.0)))
        return -mean(model, top, 2, solved(solver, model, case).displacements)

    yield from against_solid("table under load", "mean sag, mm", 0.02, solids, mixed, sag)


def swaying() -> Iterator[Row]:
    """First frequencies of the same table, its feet held: beams and plate against all of quadratic bricks."""
    solids = {size: built(TABLE_TEXT, _TABLE_OF_BRICKS, size=size, order=2).model for size in (20.0, 10.0)}
    modes = {size: frequencies(model, held_at(model, at(2, 0)), "CalculiX", 4) for size, model in solids.items()}
    mixed = built(TABLE_TEXT, size=50.0).model
    for k in range(3):
        reference = converged((20.0, 10.0), (modes[20.0][k], modes[10.0][k]))

        def mode(solver, k=k):
            return frequencies(mixed, held_at(mixed, at(2, 0)), solver, 4)[k]

        row = blank("table", f"mode {k + 1}, Hz", "plate and beams", reference, 0.03)
        for found in rows(row, mixed, mode):
            yield replace(found, note=f"all solid: {freedoms(solids[10.0]):,} freedoms")


BRACKET_TEXT = """BASE = BLO(120, 80, 3)
BACK = BLO(3, 80, 117) AT (MOVZ=3)
RIB = WED(100, 100, 3) AT (ROTX=90, MOVX=3, MOVY=41.5, MOVZ=3)
BRACKET = BASE UN BACK UN RIB
OUT BRACKET
"""


def bracket() -> Iterator[Row]:
    """Tip of a bracket with a rib, held at its upper edge, against the same bracket all of quadratic tetrahedra."""
    solids = {
        size: built(BRACKET_TEXT, (("/", "brick"),), size=size, order=2, volumes="tet").model for size in (5.0, 3.0)
    }
    mixed = {
        f"plates, {tee}, {size:g} mm": built(BRACKET_TEXT, (("/", "plates"),), size=size, tee=tee).model
        for size in (6.0, 3.0)
        for tee in ("extend", "arms")
    }

    def sunk(model: Model, solver: str) -> float:
        tip = at(0, 120.0, 1e-3)
        upper = at(2, model.mesh.nodes[:, 2].max(), 1e-3)
        case = Case(held_at(model, upper), spread(model, tip, (0, 0, -1000.0)))
        return -mean(model, tip, 2, solved(solver, model, case).displacements)

    yield from against_solid("bracket with a rib", "tip, mm", 0.035, solids, mixed, sunk)
