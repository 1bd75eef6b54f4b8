"""Cases of one segment: each a CSG text, its representations by override, loads, and a closed form with its source."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kernel.connect.model import Model
from kernel.idealise.section import SectionProperties, section_properties
from verification.common import NU, RHO, SOLVERS, E, G, Row, blank, built, rows, solved
from verification.loading import Case, at, frequencies, held_at, nodes_where, pressed, spread

# ---------------------------------------------------------------- cantilevers

LENGTH = 1000.0
I_TEXT = """LOW = BLO({x}, 100, 8)
WEB = BLO({x}, 6, 84) AT (MOVY=47, MOVZ=8)
TOP = BLO({x}, 100, 8) AT (MOVZ=92)
BEAM = LOW UN WEB UN TOP
OUT BEAM
"""
C_TEXT = """LOW = BLO({x}, 60, 6)
WEB = BLO({x}, 6, 88) AT (MOVZ=6)
TOP = BLO({x}, 60, 6) AT (MOVZ=94)
BEAM = LOW UN WEB UN TOP
OUT BEAM
"""
BOX_TEXT = "BEAM = BLO({x}, 80, 100) DIF (BLO({x}, 72, 92) AT (MOVY=4, MOVZ=4))\nOUT BEAM\n"

PROFILES = {
    # text, which way the load goes, and which nodes of the tip carry it
    "I 100 x 100 x 6 x 8": (I_TEXT, 2, lambda p: np.abs(p[:, 1] - 50) < 3.1),
    "C 60 x 100 x 6": (C_TEXT, 1, lambda p: np.full(len(p), True)),
    "box 80 x 100 x 4": (BOX_TEXT, 2, lambda p: (p[:, 1] < 4.1) | (p[:, 1] > 75.9)),
}
REPRESENTATIONS = (("beam", 0.005), ("plates", 0.035), ("plates, arms", 0.035), ("brick", 0.03))


def _section(text: str) -> SectionProperties:
    (element,) = built(text.format(x=LENGTH), (("/", "beam"),)).model.properties
    assert element.section is not None
    return section_properties(element.section.outline)


def _stiffness(section: SectionProperties, axis: int, model: Model) -> tuple[float, float]:
    """Second moment and shear area for a load along global axis 1 or 2 (the section's own y may lie along either)."""
    (block,) = model.mesh.blocks
    along_y = abs(block.orientation[0][axis]) > 0.5
    return (section.izz, section.shear_area_y) if along_y else (section.iyy, section.shear_area_z)


def cantilevers() -> Iterator[Row]:
    """Tip deflection under 1000 N: F L^3 / 3 E I + F L / G A_s (Timoshenko, Strength of Materials I, 39)."""
    for name, (text, axis, carries) in PROFILES.items():
        second, shear = _stiffness(_section(text), axis, built(text.format(x=LENGTH), (("/", "beam"),)).model)
        reference = 1000 * LENGTH**3 / (3 * E * second) + 1000 * LENGTH / (G * shear)
        for representation, limit in REPRESENTATIONS:
            kind, _, arms = representation.partition(", ")
            if arms and not name.startswith("I"):
                continue  # walls that meet in corners have no tees
            size = {"beam": 50.0, "plates": 16.0, "brick": 10.0}[kind]
            model = built(text.format(x=LENGTH), (("/", kind),), size=size, tee=arms or "extend").model
            tip = at(0, LENGTH)

            def pick(places, tip=tip, carries=carries, beam=representation == "beam"):
                return tip(places) & (True if beam else carries(places))

            force = np.zeros(3)
            force[axis] = -1000.0
            case = Case(held_at(model, at(0, 0)), spread(model, pick, force))

            def measure(solver, model=model, case=case, axis=axis):
                moved = solved(solver, model, case).displacements
                share = {node: abs(f[axis]) for node, f in case.forces.items()}
                return sum(-moved[node, axis] * w for node, w in share.items()) / sum(share.values())

            yield from rows(blank(f"cantilever {name}", "tip, mm", representation, reference, limit), model, measure)


def vibrations() -> Iterator[Row]:
    """First frequency at 2.5 m: 3.516 / 2 pi sqrt(E I / rho A L^4), the weaker axis (Blevins, table 8-1)."""
    length = 2500.0
    for name, (text, _, _) in PROFILES.items():
        section = _section(text)
        weak = min(section.iyy, section.izz)
        reference = 3.5160 / (2 * math.pi) * math.sqrt(E * weak / (RHO * section.area * length**4))
        for representation in ("beam", "plates", "brick"):
            size = {"beam": 50.0, "plates": 25.0, "brick": 20.0}[representation]
            model = built(text.format(x=length), (("/", representation),), size=size).model
            held = held_at(model, at(0, 0))

            def measure(solver, model=model, held=held):
                return frequencies(model, held, solver, 3)[0]

            yield from rows(
                blank(f"cantilever {name}", "first mode, Hz", representation, reference, 0.03), model, measure
            )


STUB_TEXT = """LOW = BLO({x}, 120, 10)
WEB = BLO({x}, 8, 100) AT (MOVY=56, MOVZ=10)
TOP = BLO({x}, 120, 10) AT (MOVZ=110)
BEAM = LOW UN WEB UN TOP
OUT BEAM
"""


def tees() -> Iterator[Row]:
    """Tip of a short and of a long cantilever I 120 x 120 x 8 x 10 under 1000 N on its web, tees extended and by arms.

    Against Timoshenko as above; the solid shows what the closed form leaves out (shear lag, and the clamped root).
    """
    section = _section(STUB_TEXT)
    for length in (360.0, 1200.0):
        text = STUB_TEXT.format(x=length)
        second, shear = _stiffness(section, 2, built(STUB_TEXT.format(x=LENGTH), (("/", "beam"),)).model)
        reference = 1000 * length**3 / (3 * E * second) + 1000 * length / (G * shear)
        ways = {
            "plates, tees extended": ("plates", {"size": 10.0}, 0.035),
            "plates, tees by arms": ("plates", {"size": 10.0, "tee": "arms"}, 0.035),
            "brick": ("brick", {"size": 20.0, "order": 2}, 0.03),
        }
        for representation, (kind, options, limit) in ways.items():
            model = built(text, (("/", kind),), **options).model

            def pick(places, length=length):
                return at(0, length)(places) & (np.abs(places[:, 1] - 60) < 4.1)

            case = Case(held_at(model, at(0, 0)), spread(model, pick, (0, 0, -1000.0)))

            def tip(solver, model=model, case=case):
                moved = solved(solver, model, case).displacements
                share = {node: -force[2] for node, force in case.forces.items()}
                return sum(-moved[node, 2] * w for node, w in share.items()) / sum(share.values())

            row = blank(f"cantilever I 120, {length:g} long", "tip, mm", representation, reference, limit)
            yield from rows(row, model, tip, SOLVERS if kind == "plates" else ("CalculiX",))


# ---------------------------------------------------------------- plates

SIDE, THIN, PRESSURE = 400.0, 4.0, 0.01
RIGIDITY = E * THIN**3 / 12 / (1 - NU**2)
PLATE_TEXT = f"PLATE = BLO({SIDE}, {SIDE}, {THIN})\nOUT PLATE\n"


def _rim(places: np.ndarray) -> np.ndarray:
    return (np.minimum(places[:, :2], SIDE - places[:, :2]) < 1e-6).any(axis=1)


def plates() -> Iterator[Row]:
    """Centre under pressure: .00406 q a^4 / D simply supported, .00126 clamped (Timoshenko, Plates and Shells).

    Tables 8 and 35 there. First modes: 19.74 and 35.99 / a^2 sqrt(D / rho t) (Leissa, NASA SP-160, 4.1 and 4.2).
    """
    model = built(PLATE_TEXT, size=20.0).model
    simply = held_at(model, _rim, "3") | {nodes_where(model, at(0, 0))[0]: "123"}
    corner = nodes_where(model, lambda p: (p[:, 0] > SIDE - 1e-6) & (p[:, 1] < 1e-6))
    simply |= dict.fromkeys(corner, "23")
    first = nodes_where(model, lambda p: (p[:, 0] < 1e-6) & (p[:, 1] < 1e-6))
    simply |= dict.fromkeys(first, "123")
    forces = pressed(model, lambda p: np.full(len(p), True), lambda _: np.array([0, 0, -PRESSURE]))
    centre = int(np.argmin(np.linalg.norm(model.mesh.nodes[:, :2] - SIDE / 2, axis=1)))
    inertia = math.sqrt(RIGIDITY / (RHO * THIN)) / (2 * math.pi * SIDE**2)
    for name, held, factor, mode in (
        ("simply supported", simply, 0.00406235, 19.7392),
        ("clamped", held_at(model, _rim), 0.00126532, 35.985),
    ):
        case = Case(held, forces)
        reference = factor * PRESSURE * SIDE**4 / RIGIDITY

        def sag(solver, case=case):
            return -solved(solver, model, case).displacements[centre, 2]

        def first_mode(solver, held=held):
            return frequencies(model, held, solver, 3)[0]

        title = f"square plate 400 x 4, {name}"
        yield from rows(blank(title, "centre, mm", "plate", reference, 0.035), model, sag)
        yield from rows(blank(title, "first mode, Hz", "plate", mode * inertia, 0.03), model, first_mode)


def hole() -> Iterator[Row]:
    """Peak stress at a hole of a fifth of the width: 3.14 times the gross stress (Howland, 1930; Peterson, 4.1)."""
    width, diameter, thickness = 100.0, 20.0, 5.0
    text = (
        f"PLATE = BLO(240, {width}, {thickness}) DIF "
        f"(CYL({diameter / 2}, {3 * thickness}) AT (MOVX=120, MOVY={width / 2}, MOVZ={-thickness}))\nOUT PLATE\n"
    )
    for representation, size in (("plate", 2.5), ("brick", 5.0)):
        model = built(text, (("/", representation),), size=size, order=2).model
        nodes = model.mesh.nodes
        held = held_at(model, at(0, 0), "1")
        held |= dict.fromkeys(nodes_where(model, lambda p: at(0, 0)(p) & (np.abs(p[:, 1]) < 1e-6)), "12")
        held |= {node: held.get(node, "") + "3" for node in nodes_where(model, at(2, nodes[:, 2].min()))}
        case = Case(held, spread(model, at(0, 240), (100.0 * width * thickness, 0, 0)))

        def peak(solver, model=model, case=case):
            stresses = solved(solver, model, case, stress=True).stresses
            return max(values[0] for values in stresses.values()) / 100.0

        note = "MYSTRAN prints no stresses at the nodes of quadratic elements"
        row = blank("plate with a hole in tension", "peak stress / gross stress", representation, 3.14, 0.03, note)
        for found in rows(row, model, peak, ("CalculiX",)):
            yield replace(found, note="")


# ---------------------------------------------------------------- pipes

OUTER, WALL, PIPE_LENGTH = 60.0, 4.0, 500.0
INNER, MIDDLE = OUTER - WALL, OUTER - WALL / 2
PIPE_TEXT = f"PIPE = CYL({OUTER}, {PIPE_LENGTH}) DIF CYL({INNER}, {PIPE_LENGTH})\nOUT PIPE\n"


def pipes() -> Iterator[Row]:
    """Tip under 1000 N as Timoshenko has it (Cowper's shear coefficient); radius under pressure as Lame has it."""
    second = math.pi / 4 * (OUTER**4 - INNER**4)
    m = (INNER / OUTER) ** 2
    shear = math.pi * (OUTER**2 - INNER**2) * 6 * (1 + m) ** 2 / (7 * (1 + m) ** 2 + 20 * m)
    bending = 1000 * PIPE_LENGTH**3 / (3 * E * second) + 1000 * PIPE_LENGTH / (G * shear)
    for representation, limit in (("beam", 0.005), ("cylinder_plate", 0.035), ("brick", 0.03)):
        size = 8.0 if representation == "brick" else 12.0
        model = built(PIPE_TEXT, (("/", representation),), size=size).model
        case = Case(held_at(model, at(2, 0)), spread(model, at(2, PIPE_LENGTH), (1000.0, 0, 0)))

        def tip(solver, model=model, case=case):
            moved = solved(solver, model, case).displacements
            share = {node: force[0] for node, force in case.forces.items()}
            return sum(moved[node, 0] * w for node, w in share.items()) / sum(share.values())

        yield from rows(blank("pipe 120 x 4 in bending", "tip, mm", representation, bending, limit), model, tip)
    pressure = 5.0
    for representation, radius, size in (("cylinder_plate", MIDDLE, 12.0), ("brick", INNER, 8.0)):
        model = built(PIPE_TEXT, (("/", representation),), size=size).model
        # at mid-length, free of the ends; Lame: u = p ri^2 r / E (ro^2 - ri^2) (1 - nu + (1 + nu) ro^2 / r^2)
        spread_out = pressure * INNER**2 * radius / (E * (OUTER**2 - INNER**2))
        reference = spread_out * (1 - NU + (1 + NU) * OUTER**2 / radius**2)

        def inside(places, radius=radius):
            return np.abs(np.hypot(places[:, 0], places[:, 1]) - radius) < 0.05

        def push(place, radius=radius):
            return pressure * INNER / radius * np.array([place[0], place[1], 0]) / np.hypot(place[0], place[1])

        nodes = model.mesh.nodes
        base = nodes_where(model, at(2, 0))
        held = dict.fromkeys(base, "3")
        for node in base:  # no rigid motion: points on the axes do not move across them
            if abs(nodes[node, 1]) < 1e-6:
                held[node] += "2"
            if abs(nodes[node, 0]) < 1e-6:
                held[node] += "1"
        case = Case(held, pressed(model, inside, push))

        def growth(solver, model=model, case=case, inside=inside):
            moved = solved(solver, model, case).displacements
            middle = nodes_where(model, lambda p: inside(p) & (np.abs(p[:, 2] - PIPE_LENGTH / 2) < 60))
            unit = model.mesh.nodes[middle, :2] / np.hypot(*model.mesh.nodes[middle, :2].T)[:, None]
            return float((moved[middle, :2] * unit).sum(axis=1).mean())

        row = blank("pipe 120 x 4 under pressure", "radius grows by, mm", representation, reference, 0.03)
        yield from rows(row, model, growth)
