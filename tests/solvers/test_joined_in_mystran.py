"""Labelled models with joints of every kind: connected, checked, and solved by MYSTRAN as one piece."""

from pathlib import Path

import numpy as np
import pytest
from verification.solvers import run_mystran

from app.pipeline import classify, mesh, read
from kernel.connect.model import Mpc, Rbe2
from kernel.deck.nastran import nastran_self_weight
from kernel.mesh.options import MeshOptions

CASES = Path(__file__).parents[1] / "cases"

JOINED = [
    "beam_between_plates", "block_with_fin", "boss_drilled", "cantilever_in_block",
    "collinear_two_sections", "coplanar_step", "four_bars_ring", "i_beside_column", "i_between_blocks", "ladder",
    "lap_of_two_plates", "pin_on_plate", "portal_oblique", "portal_overlapping", "rail_on_sheet",
    "shaft_stepped_slender", "stool_round", "table_legs_through", "table_touching",     "window_frame_cut",
]  # fmt: skip

COARSE = {"block_with_fin": 16.0, "i_between_blocks": 30.0}
"""Sizes of models that would take MYSTRAN long."""

pytestmark = pytest.mark.solver


def dependents(model) -> set[int]:
    nodes: set[int] = set()
    for coupling in model.couplings:
        if isinstance(coupling, Rbe2):
            nodes.update(coupling.dependent.tolist())
        else:
            nodes.add(int(coupling.nodes[0]) if isinstance(coupling, Mpc) else coupling.dependent)
    return nodes


@pytest.mark.parametrize("name", JOINED)
def test_mystran_carries_the_weight_through_every_joint(name, tmp_path):
    meshed = mesh(classify(read(str(CASES / f"{name}.csg"))), MeshOptions(size=COARSE.get(name)))
    model = meshed.model
    assert meshed.checks.passed, meshed.checks.failures
    assert meshed.checks.components == 1
    bound = dependents(model)
    low = model.mesh.nodes.min(axis=0) + 1e-6 * np.ptp(model.mesh.nodes, axis=0).max()
    ends = [set(np.flatnonzero(model.mesh.nodes[:, axis] <= low[axis]).tolist()) - bound for axis in range(3)]
    held = sorted(max((end for end in ends if len(end) < model.mesh.n_node / 2), key=len))
    solved = run_mystran(nastran_self_weight(model, held), tmp_path, model.mesh.n_node)
    assert solved.epsilon < 1e-6
    weight = meshed.checks.model_mass * 9806.65
    assert solved.reactions[:, 2].sum() == pytest.approx(weight, rel=1e-3)
