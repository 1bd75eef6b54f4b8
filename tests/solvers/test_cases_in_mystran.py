"""Every labelled model of tests/cases, from its text to a deck that MYSTRAN solves under its own weight.

All of them mesh, hold together as their solids do, and are carried by their supports.
"""

import json
from pathlib import Path

import numpy as np
import pytest
from verification.solvers import run_mystran
from weighing import holding_nodes

from app.pipeline import classify, mesh, read
from kernel.connect.model import Model
from kernel.deck.nastran import nastran_self_weight
from kernel.mesh.options import MeshOptions

CASES = Path(__file__).parents[1] / "cases"
NAMES = sorted(json.loads((CASES / "expected.json").read_text()))

OPTIONS = {
    "ball": MeshOptions(size=40.0),
    "bar_embedded": MeshOptions(size=30.0),
    "block_with_fin": MeshOptions(size=16.0),
    "boss_square_two": MeshOptions(size=12.0),
    "cone_stout": MeshOptions(size=40.0),
    "cube": MeshOptions(size=12.0),
    "hexagon_nut_blank": MeshOptions(size=12.0),
    "i_between_blocks": MeshOptions(size=30.0),
    "pipe_thick": MeshOptions(size=20.0, order=2),
    "ring_torus": MeshOptions(size=50.0),
    "short_spans": MeshOptions(size=30.0),
    "stub_block": MeshOptions(size=16.0),
    "stub_cylinder": MeshOptions(size=20.0, order=2),
    "wedge_thick": MeshOptions(size=16.0),
}
"""Coarser than the automatic size where MYSTRAN would take long: bricks, round ones quadratic to keep their mass."""

GRAVITY = 9806.65

pytestmark = pytest.mark.solver


def test_no_labelled_model_is_left_out():
    assert sorted(path.stem for path in CASES.glob("*.csg")) == NAMES


@pytest.mark.parametrize("name", NAMES)
def test_mystran_carries_the_weight_of_the_labelled_model(name, tmp_path):
    meshed = mesh(classify(read(str(CASES / f"{name}.csg"))), OPTIONS.get(name))
    assert meshed.checks.passed, meshed.checks.failures
    model: Model = meshed.model
    solved = run_mystran(nastran_self_weight(model, holding_nodes(model)), tmp_path, model.mesh.n_node)
    assert solved.epsilon < 1e-6
    weight = meshed.checks.model_mass * GRAVITY
    assert solved.reactions[:, 2].sum() == pytest.approx(weight, rel=1e-3)
    assert np.abs(solved.reactions[:, :2].sum(axis=0)).max() < 1e-4 * weight
    assert 0 < np.abs(solved.displacements[:, :3]).max() < 0.02 * np.ptp(model.mesh.nodes, axis=0).max()
