"""MYSTRAN solves a cantilever of every element kind that it knows, as beam theory says, under its own weight."""

import numpy as np
import pytest
from handmade import STEEL, cantilever, channel_outline, i_outline, shell_cantilever, solid_cantilever
from shapely import affinity, box
from verification.solvers import run_mystran

from kernel.deck.nastran import nastran_self_weight
from kernel.units import unit_set

GRAVITY = unit_set("mm").gravity
EPSILON = 1e-6

pytestmark = pytest.mark.solver


def sag(weight_per_length: float, length: float, second_moment: float, shear_area: float) -> float:
    """Tip of a cantilever of Timoshenko's under a uniform load."""
    bending = weight_per_length * length**4 / (8 * STEEL.elastic_modulus * second_moment)
    return bending + weight_per_length * length**2 / (2 * STEEL.shear_modulus * shear_area)


@pytest.mark.parametrize("kind", ["line2", "line3"])
def test_a_cantilever_of_bars_sags_as_timoshenko_says(tmp_path, kind):
    model = cantilever(i_outline(), 1000.0, 20, kind)
    solved = run_mystran(nastran_self_weight(model, [0]), tmp_path, model.mesh.n_node)
    section = model.properties[0].section
    weight = STEEL.density * GRAVITY * section.area
    assert solved.epsilon < EPSILON
    assert solved.reactions[0, 2] == pytest.approx(weight * 1000, rel=1e-5)
    assert solved.displacements[:, 2].min() == pytest.approx(
        -sag(weight, 1000, section.iyy, section.shear_area_z), rel=2e-3
    )


def test_a_bar_bends_sideways_where_its_section_is_not_symmetric_to_the_load(tmp_path):
    model = cantilever(affinity.rotate(box(0, 0, 10, 40), 30), 1000.0, 20)
    solved = run_mystran(nastran_self_weight(model, [0]), tmp_path, model.mesh.n_node)
    section = model.properties[0].section
    load = np.linalg.inv([[section.izz, section.iyz], [section.iyz, section.iyy]]) @ [0, -1]
    ratio = load[0] / load[1]
    tip = solved.displacements[-1]
    assert tip[1] / tip[2] == pytest.approx(ratio, rel=0.01)


def test_a_channel_stands_on_its_orientation(tmp_path):
    model = cantilever(channel_outline(), 1000.0, 20)
    solved = run_mystran(nastran_self_weight(model, [0], direction=(0, -1, 0)), tmp_path, model.mesh.n_node)
    section = model.properties[0].section
    weight = STEEL.density * GRAVITY * section.area
    assert -solved.displacements[-1, 1] == pytest.approx(sag(weight, 1000, section.izz, section.shear_area_y), rel=3e-3)


@pytest.mark.parametrize(
    ("kind", "within"),
    [("hex8", 0.03), ("hex20", 0.025), ("wedge6", 0.09), ("wedge15", 0.025), ("tet4", 0.4), ("tet10", 0.03)],
)
def test_a_cantilever_of_solids_sags_as_timoshenko_says(tmp_path, kind, within):
    model = solid_cantilever(kind, divisions=(10, 2, 2) if kind in ("hex20", "wedge15", "tet10") else (20, 4, 4))
    held = np.flatnonzero(model.mesh.nodes[:, 0] == 0)
    solved = run_mystran(nastran_self_weight(model, held), tmp_path, model.mesh.n_node)
    weight = STEEL.density * GRAVITY * 100
    assert solved.epsilon < EPSILON
    assert solved.reactions[:, 2].sum() == pytest.approx(weight * 100, rel=1e-5)
    assert -solved.displacements[:, 2].min() == pytest.approx(sag(weight, 100, 1e4 / 12, 250 / 3), rel=within)


@pytest.mark.parametrize("kind", ["quad4", "tri3"])
def test_a_cantilever_of_shells_sags_as_timoshenko_says(tmp_path, kind):
    model = shell_cantilever(kind)
    held = np.flatnonzero(model.mesh.nodes[:, 0] == 0)
    solved = run_mystran(nastran_self_weight(model, held), tmp_path, model.mesh.n_node)
    weight = STEEL.density * GRAVITY * 20
    assert solved.epsilon < EPSILON
    assert solved.reactions[:, 2].sum() == pytest.approx(weight * 100, rel=1e-5)
    assert -solved.displacements[:, 2].min() == pytest.approx(sag(weight, 100, 80 / 12, 50 / 3), rel=0.02)
