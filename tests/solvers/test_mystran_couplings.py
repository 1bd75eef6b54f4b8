"""MYSTRAN takes every coupling: no error, no mechanism, reaction equals weight, and a stiffness in bounds."""

import numpy as np
import pytest
from handmade import STEEL
from joined import block_on_plate, half_beam_half_solid, lap_of_plates, post_on_plate
from verification.solvers import run_mystran

from kernel.deck.nastran import nastran_self_weight
from kernel.units import unit_set

GRAVITY = unit_set("mm").gravity

pytestmark = pytest.mark.solver


def solve(model, held, folder):
    solved = run_mystran(nastran_self_weight(model, held), folder, model.mesh.n_node)
    assert solved.epsilon < 1e-6
    return solved


@pytest.mark.parametrize("kind", ["distributing", "rigid", "work"])
def test_half_beam_half_solid_bends_like_one_cantilever(tmp_path, kind):
    model = half_beam_half_solid(kind)
    solved = solve(model, np.flatnonzero(model.mesh.nodes[:, 0] == 0), tmp_path)
    load, length = STEEL.density * GRAVITY * 600, 200
    bending = load * length**4 / (8 * STEEL.elastic_modulus * 20 * 30**3 / 12)
    shear = load * length**2 / (2 * STEEL.shear_modulus * 500)
    assert -solved.displacements[-1, 2] == pytest.approx(bending + shear, rel=0.025)
    assert solved.reactions[:, 2].sum() == pytest.approx(load * length, rel=1e-5)


@pytest.mark.parametrize("kind", ["distributing", "rigid", "work"])
def test_a_post_on_a_plate_stands(tmp_path, kind):
    model = post_on_plate(kind)
    nodes = model.mesh.nodes
    ends = np.flatnonzero((nodes[:, 2] == 0) & np.isin(nodes[:, 0], (0, 100)))
    solved = solve(model, ends, tmp_path)
    assert solved.reactions[:, 2].sum() == pytest.approx(STEEL.density * GRAVITY * (50000 + 20000), rel=1e-5)


def test_a_rigid_foot_is_stiffer_than_an_averaged_one(tmp_path):
    sag = {}
    for kind in ("distributing", "rigid"):
        model = post_on_plate(kind)
        nodes = model.mesh.nodes
        folder = tmp_path / kind
        folder.mkdir()
        ends = np.flatnonzero((nodes[:, 2] == 0) & np.isin(nodes[:, 0], (0, 100)))
        sag[kind] = -solve(model, ends, folder).displacements[-1, 2]
    assert sag["rigid"] < sag["distributing"]


def test_a_block_on_a_plate_does_not_hinge(tmp_path):
    model = block_on_plate()
    nodes = model.mesh.nodes
    solved = solve(model, np.flatnonzero((nodes[:, 2] == 0) & np.isin(nodes[:, 0], (0, 100))), tmp_path)
    assert solved.reactions[:, 2].sum() == pytest.approx(STEEL.density * GRAVITY * (50000 + 12000), rel=1e-5)


def test_lapped_plates_bend_as_one(tmp_path):
    model = lap_of_plates()
    solved = solve(model, np.flatnonzero(model.mesh.nodes[:, 0] == 0), tmp_path)
    assert solved.reactions[:, 2].sum() == pytest.approx(STEEL.density * GRAVITY * 32000, rel=1e-5)
    # more than a cantilever as thick as both all along, less than one of a single plate
    load, length = STEEL.density * GRAVITY * 40 * 4, 160
    single = load * length**4 / (8 * STEEL.elastic_modulus * 40 * 4**3 / 12)
    assert single / 8 < -solved.displacements[:, 2].min() < single * 1.2
