"""Stacks and turned solids as hexahedra hang under their own weight as long as the closed form says, at both orders."""

from __future__ import annotations

import numpy as np
import pytest
from verification.solvers import run_calculix, run_mystran

from app.pipeline import classify, mesh
from kernel.csg.reader import read_model
from kernel.deck.calculix import calculix_self_weight
from kernel.deck.nastran import nastran_self_weight
from kernel.mesh.options import MeshOptions
from kernel.plan import Override

pytestmark = pytest.mark.solver

E, DENSITY, GRAVITY = 210000.0, 7.85e-9, 9806.65

STEPPED = "A = CYL(R=10, H=100) UN (CYL(R=6, H=100) AT (MOVZ=100))\nOUT A\n"
CONE = "A = CON(10, 6, 80)\nOUT A\n"


def stepped_stretch():
    """Held at its upper end, stretched by its weight: the thin part by its own and that of the thick one below it."""
    thick = DENSITY * GRAVITY * 100**2 / (2 * E)
    return thick + DENSITY * GRAVITY * 100**2 / (2 * E) + DENSITY * GRAVITY * 100 * (100 / 36) * 100 / E


def cone_stretch():
    """The integral of the weight below over E A, held where the radius is 6."""
    z = np.linspace(0, 80, 20001)
    radius = 10 - 4 * z / 80
    below = np.pi * (10**3 - radius**3) / 3 * (80 / 4)
    strain = DENSITY * GRAVITY * below / (E * np.pi * radius**2)
    return float((0.5 * (strain[1:] + strain[:-1]) * np.diff(z)).sum())


CASES = {
    "stepped shaft, hex8": (STEPPED, stepped_stretch(), 1, "hex8"),
    "stepped shaft, hex20": (STEPPED, stepped_stretch(), 2, "hex20"),
    "cone, hex20": (CONE, cone_stretch(), 2, "hex20"),
}


@pytest.mark.parametrize("name", CASES)
def test_a_hanging_shaft_is_stretched_by_its_weight(name, tmp_path):
    text, stretch, order, kind = CASES[name]
    options = MeshOptions(size=12.0, order=order, volumes="hex")
    meshed = mesh(classify(read_model(text, "test"), overrides={"/": Override("brick")}), options)
    assert set(meshed.model.mesh.count()) == {kind} and meshed.checks.passed
    model, nodes = meshed.model, meshed.model.mesh.nodes
    held = np.flatnonzero(nodes[:, 2] > nodes[:, 2].max() - 1e-6).tolist()
    mystran = run_mystran(nastran_self_weight(model, held), tmp_path, model.mesh.n_node)
    ccx = run_calculix(calculix_self_weight(model, held), tmp_path, model.mesh.n_node)
    low = np.flatnonzero(nodes[:, 2] < 1e-6)
    for solved in (mystran, ccx):
        assert -solved.displacements[low, 2].mean() == pytest.approx(stretch, rel=0.02)
