"""Every joint of the catalogue, straight and turned: one piece, no crack, its joints called by what they are, and
carried by MYSTRAN.
"""

from __future__ import annotations

import numpy as np
import pytest
from catalogue import CATALOGUE, Joined
from solids import placed
from verification.solvers import run_mystran
from weighing import holding_nodes

from app.pipeline import Classified, Meshed, classify, mesh
from kernel.connect.joints import JOINT_KINDS
from kernel.csg.reader import read_model
from kernel.deck.nastran import nastran_self_weight
from kernel.mesh.options import MeshOptions
from kernel.plan import Override

GRAVITY = 9806.65

ASIDE = (31.7, -23.1, 11.3)


def any_turn(seed: int) -> np.ndarray:
    """A rotation (3, 3) about no axis in particular."""
    turn, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return turn * np.sign(np.linalg.det(turn))


def classified_of(case: Joined, turn: np.ndarray | None = None) -> Classified:
    text = case.text if turn is None else placed(case.text, ASIDE, turn)
    overrides = {path: Override(kind) for path, kind in case.overrides.items()}
    return classify(read_model(text, "catalogue"), overrides=overrides)


def meshed_of(case: Joined, turn: np.ndarray | None = None) -> Meshed:
    return mesh(classified_of(case, turn), MeshOptions(size=case.size))


def assert_joined(case: Joined, meshed: Meshed) -> None:
    classified: Classified = meshed.classified
    assert " ".join(sorted(segment.type for segment in classified.partition.segments)) == case.types
    assert " ".join(sorted({joint.kind for joint in classified.joints})) == case.kinds
    assert all(joint.area > 0 for joint in classified.joints)
    checks = meshed.checks  # free and coincident nodes, cracks, couplings against rigid motions, mass: all in there
    assert checks.passed, checks.failures
    assert checks.components == 1
    assert checks.cracks == 0
    assert checks.coupling_error < 1e-9
    assert abs(checks.accounted_mass_error) < 5e-3


@pytest.mark.parametrize("name", CATALOGUE)
def test_every_joint_of_the_catalogue_is_one_whole(name):
    assert_joined(CATALOGUE[name], meshed_of(CATALOGUE[name]))


@pytest.mark.solver
@pytest.mark.parametrize("name", CATALOGUE)
def test_turned_it_is_the_same_and_mystran_carries_its_weight(name, tmp_path):
    case = CATALOGUE[name]
    meshed = meshed_of(case, any_turn(5))
    assert_joined(case, meshed)
    model = meshed.model
    solved = run_mystran(nastran_self_weight(model, holding_nodes(model)), tmp_path, model.mesh.n_node)
    assert solved.epsilon < 1e-6
    weight = meshed.checks.model_mass * GRAVITY
    assert solved.reactions[:, 2].sum() == pytest.approx(weight, rel=1e-3)
    assert np.abs(solved.reactions[:, :2].sum(axis=0)).max() < 1e-3 * weight


def test_the_catalogue_holds_every_kind_of_joint():
    kinds = {kind for case in CATALOGUE.values() for kind in case.kinds.split()}
    assert kinds == set(JOINT_KINDS)


WAYS = {
    "coarse, rigid": (MeshOptions(size=45.0), "rigid"),
    "triangles on arms, work": (MeshOptions(size=13.0, faces="tri", tee="arms"), "work"),
    "second order": (MeshOptions(size=18.0, order=2), "distributing"),
}
"""Options with which each joint is to hold as well: one of every choice in at least one of them."""


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("name", CATALOGUE)
def test_every_joint_is_one_whole_in_other_ways_as_well(name, way):
    options, coupling = WAYS[way]
    meshed = mesh(classified_of(CATALOGUE[name]), options, coupling=coupling)
    assert meshed.checks.passed, meshed.checks.failures
