"""Parts of two dimensions joined, each against the same all of solid elements, or against beam theory."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator

import numpy as np
import shapely

from kernel.connect.mass import section_axes
from kernel.connect.model import Model
from kernel.idealise.section import SectionProperties, section_properties
from verification.common import REENTRANT, E, G, Row, blank, built, converged, freedoms, rows, solved
from verification.loading import Case, Pick, at, held_at, nodes_where, pressed, spread, weights

COUPLINGS = ("distributing", "rigid", "work")


def mean(model: Model, pick: Pick, axis: int, displacements: np.ndarray) -> float:
    """Displacement along a global axis, the mean over what the picked nodes stand for."""
    share = weights(model, pick)
    return sum(displacements[node, axis] * w for node, w in share.items()) / sum(share.values())


# ---------------------------------------------------------------- half beam, half solid

BAR = "ROOT = BLO(200, 30, 40)\nREST = ROOT AT (MOVX=200)\nBAR = ROOT UN REST\nOUT BAR\n"
I_HALVES = """LOW = BLO(300, 60, 8)
PART = LOW UN (BLO(300, 6, 64) AT (MOVY=27, MOVZ=8)) UN (LOW AT (MOVZ=72))
ROOT = PART
REST = PART AT (MOVX=300)
BAR = ROOT UN REST
OUT BAR
"""
C_HALVES = """LOW = BLO(300, 40, 6)
PART = LOW UN (BLO(300, 6, 68) AT (MOVZ=6)) UN (LOW AT (MOVZ=74))
ROOT = PART
REST = PART AT (MOVX=300)
BAR = ROOT UN REST
OUT BAR
"""


def _half(text: str, coupling: str, size: float) -> tuple[Model, SectionProperties, np.ndarray]:
    """The model, the beam's section, and its axes as rows."""
    model = built(text, (("ROOT", "brick"), ("REST", "beam")), size=size, coupling=coupling).model
    (outline,) = [element.section.outline for element in model.properties if element.section is not None]
    (block,) = [block for block in model.mesh.blocks if block.orientation is not None]
    ends = model.mesh.nodes[block.connectivity[0]]
    (y,), (z,) = section_axes(ends[:1], ends[1:], block.orientation[:1])
    return model, section_properties(outline), np.stack([np.cross(y, z), y, z])


def halves_in_six() -> Iterator[Row]:
    """Half brick, half beam, under each of a beam's six loads: F L / E A, Timoshenko's tip, T L / G J, M L / E I.

    The solid half is clamped: it does not contract there as a bar does, and is a little the stiffer.
    """
    length = 400.0
    for coupling in COUPLINGS:
        model, section, axes = _half(BAR, coupling, 6.0)
        (node,) = nodes_where(model, at(0, length))
        held = held_at(model, at(0, 0))
        bending = [length**3 / (3 * E * second) for second in (section.izz, section.iyy)]
        shear = [length / (G * area) for area in (section.shear_area_y, section.shear_area_z)]
        flexibilities = (
            ("pulled: stretch, mm/kN", length / (E * section.area)),
            ("force along y: tip, mm/kN", bending[0] + shear[0]),
            ("force along z: tip, mm/kN", bending[1] + shear[1]),
            ("torque: turn, mrad/Nm", length / (G * section.j)),
            ("moment about y: turn, mrad/Nm", length / (E * section.iyy)),
            ("moment about z: turn, mrad/Nm", length / (E * section.izz)),
        )
        for k, (quantity, flexibility) in enumerate(flexibilities):
            load = 1000.0 * axes[k % 3]
            case = Case(held, {node: load}) if k < 3 else Case(held, {}, {node: load})

            def moved(solver, model=model, case=case, node=node, k=k, axes=axes):
                found = solved(solver, model, case).displacements[node]
                return found[3 * (k // 3) : 3 * (k // 3) + 3] @ axes[k % 3] * (1.0 if k < 3 else 1000.0)

            reference = flexibility * 1000.0 * (1.0 if k < 3 else 1000.0)
            row = blank("half brick, half beam", quantity, coupling, reference, 0.02)
            yield from rows(row, model, moved, ("MYSTRAN",))


def joint_stress() -> Iterator[Row]:
    """Largest bending stress in the solid at the joint of half brick and half beam, over beam theory's M / W.

    What is over 1 is the coupling's own: a rigid face cannot contract, an average pulls where its nodes are.
    """
    nominal = 1000.0 * 200.0 / (30 * 40**2 / 6)
    for coupling in COUPLINGS:
        model, _, _ = _half(BAR, coupling, 5.0)
        (node,) = nodes_where(model, at(0, 400.0))
        case = Case(held_at(model, at(0, 0)), {node: np.array([0, 0, -1000.0])})
        face = set(nodes_where(model, at(0, 200.0)))

        def peak(solver, model=model, case=case, face=face):
            stresses = solved(solver, model, case, stress=True).stresses
            return max(abs(values[0]) for place, values in stresses.items() if place in face) / nominal

        limit = {"distributing": 0.15, "rigid": 0.25, "work": 0.03}[coupling]
        yield from rows(
            blank("half brick, half beam", "peak / nominal stress", coupling, 1.0, limit), model, peak, ("CalculiX",)
        )


def torsion() -> Iterator[Row]:
    """Half an open section of bricks, half a beam: the solid half, clamped, cannot warp at its root (Vlasov).

    T / G J (l1 - a tanh(l1 / a) + l2), a^2 = E C_w / G J, where the joint lets the face warp; l1 - 2 a tanh(l1 / 2 a)
    where it is rigid. C_w as in Roark's Formulas for Stress and Strain (Young, Budynas), table 10.2. A force through
    the channel's centroid twists the solid half as well, by its distance from the shear centre; a CBAR does not know
    that distance, so that the beam half only bends.
    """
    l1 = l2 = 300.0
    width, depth, flange, web = 40 - 3.0, 80 - 6.0, 6.0, 6.0
    warping = {
        "I": 72.0**2 * 60.0**3 * 8 / 24,
        "channel": depth**2 * width**3 * flange / 12 * (2 * depth * web + 3 * width * flange)
        / (depth * web + 6 * width * flange),
    }  # fmt: skip
    for name, text in (("I", I_HALVES), ("channel", C_HALVES)):
        for coupling in COUPLINGS:
            model, section, axes = _half(text, coupling, 8.0)
            (node,) = nodes_where(model, at(0, l1 + l2))
            held = held_at(model, at(0, 0))
            a = math.sqrt(E * warping[name] / (G * section.j))
            free = l1 - a * math.tanh(l1 / a) if coupling != "rigid" else l1 - 2 * a * math.tanh(l1 / 2 / a)
            case = Case(held, {}, {node: 1e5 * axes[0]})

            def turn(solver, model=model, case=case, node=node, axes=axes):
                return solved(solver, model, case).displacements[node, 3:] @ axes[0] * 1000

            reference = 1e5 * (free + l2) / (G * section.j) * 1000
            title = f"half brick, half beam, {name}"
            yield from rows(
                blank(title, "turn under 100 Nm, mrad", coupling, reference, 0.03), model, turn, ("MYSTRAN",)
            )
            if name == "I":
                continue
            length, arm = l1 + l2, max(map(abs, section.shear_centre))
            across = 1 if abs(section.shear_centre[0]) < 1e-6 * arm else 2
            second, area = (section.izz, section.shear_area_y) if across == 1 else (section.iyy, section.shear_area_z)
            straight = length**3 / (3 * E * second) + length / (G * area)
            sunk = 1000 * (straight + arm**2 * free / (G * section.j))
            case = Case(held, {node: 1000 * axes[across]})

            def tip(solver, model=model, case=case, node=node, axis=axes[across]):
                return solved(solver, model, case).displacements[node, :3] @ axis

            row = blank(title, "tip under 1000 N at the centroid, mm", coupling, sunk, 0.03)
            yield from rows(row, model, tip, ("MYSTRAN",))


# ---------------------------------------------------------------- against all solid


def against_solid(
    title: str, quantity: str, limit: float, solids: dict[float, Model], mixed: dict[str, Model],
    measure: Callable[[Model, str], float], solvers: tuple[str, ...] = ("MYSTRAN", "CalculiX"),
) -> Iterator[Row]:  # fmt: skip
    """Each mixed model against what the solid ones tend to; solids: two, by element size, the coarser first."""
    values = [measure(model, "CalculiX") for model in solids.values()]
    first, last = solids
    reference = converged((first, last), (values[0], values[1]))
    finer = f"{values[1] / reference - 1:+.2%}"
    sizes = ", ".join(f"{value:.5g} at {size:g} mm ({freedoms(solids[size]):,})" for size, value in zip(solids, values))
    fewer = ", ".join(f"{freedoms(solids[last]) / freedoms(model):.0f} ({name})" for name, model in mixed.items())
    note = (
        f"{title}, all solid: {sizes}; with order {REENTRANT} they tend to {reference:.5g}, from which the finer one "
        f"differs by {finer}. Freedoms are fewer than its by a factor of {fewer}."
    )
    for name, model in mixed.items():
        row = blank(title, quantity, name, reference, limit, note)
        yield from rows(row, model, lambda solver, model=model: measure(model, solver), solvers)


STIFFENED = """PLATE = BLO(400, 400, 5)
BAR = BLO(400, 8, 30) AT (MOVY=196, MOVZ=5)
PART = PLATE UN BAR
OUT PART
"""
STRIP = """PLATE = BLO(600, 50, 6)
BAR = BLO(600, 10, 40) AT (MOVY=20, MOVZ=6)
PART = PLATE UN BAR
OUT PART
"""


def stiffener() -> Iterator[Row]:
    """A bar welded along a plate: the tip of a strip of it by beam theory; a clamped plate against solids.

    The strip is a T with one neutral axis for both parts: F L^3 / 3 E I + F L / G A_s, A_s the T's own.
    """
    length = 600.0
    whole = section_properties(shapely.box(0, 0, 50, 6) | shapely.box(20, 6, 30, 46))
    reference = 1000 * (length**3 / (3 * E * whole.iyy) + length / (G * whole.shear_area_z))
    for kind, size in (("beam", 10.0), ("plate", 10.0), ("brick", 5.0)):
        pins = (("PART", "brick"),) if kind == "brick" else (("PLATE", "plate"), ("BAR", kind))
        model = built(STRIP, pins, size=size).model
        tip = at(0, length)
        case = Case(held_at(model, at(0, 0)), spread(model, tip, (0, 0, -1000.0)))

        def sunk(solver, model=model, case=case, tip=tip):
            return -mean(model, tip, 2, solved(solver, model, case).displacements)

        name = "brick" if kind == "brick" else f"plate and {kind}"
        yield from rows(blank("strip with a bar along it", "tip, mm", name, reference, 0.035), model, sunk)
    solids = {size: built(STIFFENED, (("PART", "brick"),), size=size, order=2).model for size in (20.0, 10.0)}
    mixed = {
        f"plate and {kind}, {size:g} mm": built(STIFFENED, (("PLATE", "plate"), ("BAR", kind)), size=size).model
        for size in (20.0, 10.0)
        for kind in ("beam", "plate")
    }

    def sag(model: Model, solver: str) -> float:
        lower = at(2, model.mesh.nodes[:, 2].min(), 1e-3)
        held = held_at(model, lambda p: (np.minimum(p[:, :2], 400 - p[:, :2]) < 1e-6).any(axis=1))
        case = Case(held, pressed(model, lower, lambda _: np.array([0, 0, -0.01])))
        return -mean(model, lower, 2, solved(solver, model, case).displacements)

    yield from against_solid("clamped plate with a bar across", "mean sag, mm", 0.02, solids, mixed, sag)


BOSSED = """PLATE = BLO(240, 240, 12)
BOSS = CYL(30, 60) AT (MOVX=120, MOVY=120, MOVZ=12)
PART = PLATE UN BOSS
OUT PART
"""


def boss() -> Iterator[Row]:
    """A clamped plate with a round boss that is pushed sideways at its top, against both of bricks."""
    solids = {size: built(BOSSED, (("PART", "brick"),), size=size, order=2).model for size in (12.0, 6.0)}
    pins = (("PLATE", "plate"), ("BOSS", "brick"))
    mixed = {f"plate and brick, {size:g} mm": built(BOSSED, pins, size=size).model for size in (12.0, 6.0)}

    def pushed(model: Model, solver: str) -> float:
        top = at(2, model.mesh.nodes[:, 2].max())
        held = held_at(model, lambda p: (np.minimum(p[:, :2], 240 - p[:, :2]) < 1e-6).any(axis=1))
        case = Case(held, spread(model, top, (10000.0, 0, 0)))
        return mean(model, top, 0, solved(solver, model, case).displacements)

    yield from against_solid("plate with a boss", "top of the boss, mm", 0.02, solids, mixed, pushed)


FIN = """BLOCK = BLO(60, 80, 60)
FIN = BLO(120, 80, 6) AT (MOVX=60, MOVZ=27)
PART = BLOCK UN FIN
OUT PART
"""


def fin() -> Iterator[Row]:
    """A plate whose edge stands on a block, bent at its free end, against both of bricks."""
    solids = {size: built(FIN, (("PART", "brick"),), size=size, order=2).model for size in (6.0, 4.0)}
    pins = (("BLOCK", "brick"), ("FIN", "plate"))
    mixed = {f"{coupling}, 12 mm": built(FIN, pins, size=12.0, coupling=coupling).model for coupling in COUPLINGS}
    mixed["distributing, block 3.5 mm"] = built(FIN, pins, size=12.0, sizes=(("BLOCK", 3.5),)).model

    def bent(model: Model, solver: str) -> float:
        tip = at(0, 180.0)
        case = Case(held_at(model, at(0, 0)), spread(model, tip, (0, 0, -100.0)))
        return -mean(model, tip, 2, solved(solver, model, case).displacements)

    yield from against_solid("plate on a block", "tip, mm", 0.02, solids, mixed, bent)
