"""CalculiX solves our decks as MYSTRAN does, within what its beams and shells are."""

import numpy as np
import pytest
from handmade import cantilever, i_outline, shell_cantilever, solid_cantilever
from joined import block_on_plate, half_beam_half_solid, lap_of_plates, post_on_plate
from shapely import Point, affinity, box
from verification.solvers import run_calculix, run_mystran

from kernel.deck.calculix import calculix_self_weight, write
from kernel.deck.nastran import nastran_self_weight
from kernel.errors import DeckError

pytestmark = pytest.mark.solver

DISC = Point(0, 0).buffer(10, quad_segs=24)
BEAMS = {
    "rectangle": (box(0, 0, 10, 30), 0.01),
    "turned rectangle": (affinity.rotate(box(0, 0, 10, 30), 30), 0.02),
    "circle": (DISC, 0.025),
    "tube": (DISC - Point(0, 0).buffer(8, quad_segs=24), 0.012),
    "box": (box(0, 0, 40, 60) - box(1, 3, 39, 57), 0.025),
    "turned box": (affinity.rotate(box(0, 0, 40, 60) - box(1, 3, 39, 57), 90), 0.045),
}


def compare(model, held, folder):
    """Largest displacement of CalculiX over MYSTRAN's."""
    ccx = run_calculix(calculix_self_weight(model, held), folder, model.mesh.n_node)
    mystran = run_mystran(nastran_self_weight(model, held), folder, model.mesh.n_node)
    ratio = np.abs(ccx.displacements[:, :3]).max() / np.abs(mystran.displacements[:, :3]).max()
    worst = np.abs(ccx.displacements[:, :3] - mystran.displacements[:, :3]).max()
    return ratio, worst / np.abs(mystran.displacements[:, :3]).max()


@pytest.mark.parametrize("kind", ["line2", "line3"])
@pytest.mark.parametrize("name", BEAMS)
def test_beams_of_the_sections_that_ccx_knows(tmp_path, name, kind):
    outline, within = BEAMS[name]
    ratio, worst = compare(cantilever(outline, 1000.0, 20, kind), [0], tmp_path)
    assert ratio == pytest.approx(1, abs=within)
    assert worst < within


@pytest.mark.parametrize(
    ("kind", "within"), [("hex8", 0.015), ("hex20", 0.02), ("wedge6", 0.03), ("wedge15", 0.03), ("tet10", 1e-4)]
)
def test_solids(tmp_path, kind, within):
    model = solid_cantilever(kind, divisions=(20, 4, 4) if kind in ("hex8", "wedge6") else (10, 2, 2))
    held = np.flatnonzero(model.mesh.nodes[:, 0] == 0)
    assert compare(model, held, tmp_path)[0] == pytest.approx(1, abs=within)


def test_shells_of_quads(tmp_path):
    model = shell_cantilever("quad4")
    assert compare(model, np.flatnonzero(model.mesh.nodes[:, 0] == 0), tmp_path)[0] == pytest.approx(1, abs=0.01)


@pytest.mark.parametrize("kind", ["tri6", "quad8"])
def test_quadratic_shells_bend_as_beam_theory_says(tmp_path, kind):
    model = shell_cantilever(kind)
    held = np.flatnonzero(model.mesh.nodes[:, 0] == 0)
    solved = run_calculix(calculix_self_weight(model, held), tmp_path, model.mesh.n_node)
    sag = 7.85e-9 * 9806.65 * 20 * 100**4 / (8 * 210000 * 80 / 12)
    assert -solved.displacements[:, 2].min() == pytest.approx(sag, rel=0.025)


@pytest.mark.parametrize("kind", ["distributing", "rigid", "work"])
def test_half_beam_half_solid(tmp_path, kind):
    model = half_beam_half_solid(kind)
    held = np.flatnonzero(model.mesh.nodes[:, 0] == 0)
    ratio, worst = compare(model, held, tmp_path)
    assert ratio == pytest.approx(1, abs=0.002)
    assert worst < 0.005


@pytest.mark.parametrize("make", [post_on_plate, block_on_plate])
def test_what_stands_on_a_plate(tmp_path, make):
    model = make()
    nodes = model.mesh.nodes
    held = np.flatnonzero((nodes[:, 2] == 0) & np.isin(nodes[:, 0], (0, 100)))
    assert compare(model, held, tmp_path)[0] == pytest.approx(1, abs=0.06)


def test_lapped_plates(tmp_path):
    model = lap_of_plates()
    ratio, worst = compare(model, np.flatnonzero(model.mesh.nodes[:, 0] == 0), tmp_path)
    assert ratio == pytest.approx(1, abs=0.015)
    assert worst < 0.015


def test_a_section_that_ccx_does_not_know_is_refused_with_a_way_out():
    with pytest.raises(DeckError, match=r"segment s1: CalculiX's beams are .*, not i sections; expected another"):
        write(cantilever(i_outline(), 1000.0, 2))


def test_a_short_hollow_beam_is_named_with_how_much_too_stiff_its_shear_makes_it():
    pipe = Point(0, 0).buffer(60, quad_segs=24) - Point(0, 0).buffer(56, quad_segs=24)
    short = write(cantilever(pipe, 500.0, 5)).decode()
    assert (
        "** note: ccx shears beams over their whole area, which alone makes s1 4.7% too stiff as a cantilever" in short
    )
    assert "too stiff" not in write(cantilever(pipe, 5000.0, 5)).decode()
    assert "too stiff" not in write(cantilever(box(0, 0, 10, 30), 500.0, 5)).decode()
