"""A strip of a stiffened panel held at one end bends under its weight as beam theory has it, whatever the stiffener."""

from __future__ import annotations

import numpy as np
import pytest
from solids import cube, union
from verification.loading import dependent_nodes
from verification.solvers import run_mystran

from app.pipeline import classify, mesh
from kernel.csg.reader import read_model
from kernel.deck.nastran import nastran_self_weight
from kernel.mesh.options import MeshOptions
from kernel.plan import Override

YOUNG, POISSON, DENSITY, GRAVITY = 210000.0, 0.3, 7.85e-9, 9806.65
LENGTH = 1200.0
SKIN, WEB, FLANGE = (200.0, 10.0), (8.0, 100.0), (80.0, 10.0)  # width and height of each, from below


def deflection() -> float:
    """Tip of the cantilever under its weight, with the shear of the web (Timoshenko)."""
    area = moment = inertia = height = 0.0
    for width, depth in (SKIN, WEB, FLANGE):
        area += width * depth
        moment += width * depth * (height + depth / 2)
        inertia += width * depth**3 / 12 + width * depth * (height + depth / 2) ** 2
        height += depth
    inertia -= moment**2 / area
    load = DENSITY * GRAVITY * area
    shear = YOUNG / (2 * (1 + POISSON)) * WEB[0] * WEB[1]
    return load * LENGTH**4 / (8 * YOUNG * inertia) + load * LENGTH**2 / (2 * shear)


@pytest.mark.solver
@pytest.mark.parametrize("stiffener, couplings", [("beam", True), ("plate", False)])
def test_a_tee_stiffener_acts_with_its_plate(stiffener, couplings, tmp_path):
    text = union(
        cube(LENGTH, SKIN[0], SKIN[1]),
        cube(LENGTH, WEB[0], WEB[1], (0, 96, 10)),
        cube(LENGTH, FLANGE[0], FLANGE[1], (0, 60, 110)),
    )
    overrides = {"0": Override("plate"), "1": Override(stiffener), "2": Override(stiffener)}
    meshed = mesh(classify(read_model(text, "panel"), overrides=overrides), MeshOptions(size=30.0))
    assert [s.type for s in meshed.classified.partition.segments].count(stiffener) >= 2
    assert bool(meshed.model.couplings) == couplings
    model = meshed.model
    along, bound = model.mesh.nodes[:, 0], dependent_nodes(model)
    held = [node for node in np.flatnonzero(along < 1e-6).tolist() if node not in bound]
    solved = run_mystran(nastran_self_weight(model, held), tmp_path, model.mesh.n_node)
    assert solved.epsilon < 1e-6
    tip = (along > LENGTH - 1e-6) & (model.mesh.nodes[:, 2] < 10.0)
    assert -solved.displacements[tip, 2].mean() == pytest.approx(deflection(), rel=0.01)
