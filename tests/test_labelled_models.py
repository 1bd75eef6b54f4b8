"""Every labelled model at its automatic size, tees extended and by arms: whole, uncracked, and as heavy as it is."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path

import pytest

from app.pipeline import Classified, Meshed, classify, mesh, read
from kernel.connect.mass import block_moments
from kernel.mesh.options import MeshOptions

CASES = Path(__file__).parent / "cases"
NAMES = sorted(json.loads((CASES / "expected.json").read_text()))

EXACT = 1e-12
"""Share by which a segment of exact mass may differ from its solid: rounding."""

MIXED = [
    "angle_bracket_drilled",
    "beam_between_plates",
    "bracket_two_gussets",
    "cantilever_in_block",
    "egg_crate_two_by_two",
    "i_between_blocks",
    "lap_of_two_plates",
    "pin_on_plate",
    "pipe_on_base_plate",
    "pipe_branch",
    "rail_on_sheet",
    "shaft_stepped_stout",
    "tank_with_nozzle_hole",
    "truss_triangle",
]
"""Beams, plates, cylinder-plates and bricks, alone and together, with couplings of every kind."""


@cache
def classified(name: str) -> Classified:
    return classify(read(str(CASES / f"{name}.csg")))


def is_whole(meshed: Meshed) -> None:
    checks = meshed.checks
    assert checks.passed, checks.failures
    assert checks.components == checks.solid_components
    assert (checks.free_nodes, checks.coincident_nodes, checks.cracks, checks.loose_arms) == (0, 0, 0, 0)
    assert abs(checks.accounted_mass_error) <= 5e-3
    odd = sum(abs(row.volume) for row in checks.ledger if row.kind == "unexplained")
    assert odd <= 2e-6 * meshed.classified.evaluated.solid.true_volume


@pytest.mark.parametrize("name", NAMES)
def test_a_labelled_model_is_whole_and_as_heavy_as_its_solid(name):
    is_whole(mesh(classified(name)))


@pytest.mark.parametrize("name", NAMES)
def test_a_labelled_model_is_so_with_its_tees_by_arms(name):
    if not any(segment.type in ("plate", "cylinder_plate") for segment in classified(name).partition.segments):
        assert not any(joint.kind == "tee" for joint in classified(name).joints)
        return
    meshed = mesh(classified(name), MeshOptions(tee="arms"))
    is_whole(meshed)
    assert not any(row.cause == "tee" for row in meshed.checks.ledger)


@pytest.mark.parametrize("name", NAMES)
def test_a_labelled_model_is_so_in_triangles_of_second_order_on_arms_and_coupled_by_work(name):
    is_whole(mesh(classified(name), MeshOptions(order=2, faces="tri", tee="arms"), coupling="work"))


@pytest.mark.parametrize("tee", ["extend", "arms"])
@pytest.mark.parametrize("name", MIXED)
def test_with_exact_mass_every_segment_weighs_what_its_solid_does(name, tee):
    meshed = mesh(classified(name), MeshOptions(tee=tee), mass="exact")
    model = meshed.model
    elements = {element.segment: element for element in model.properties}
    weights = dict.fromkeys(elements, 0.0)
    for block in model.mesh.blocks:
        element = elements[block.segment]
        density = model.materials[element.material].density
        weights[block.segment] += block_moments(block, model.mesh.nodes, element, density).mass
    for segment in meshed.assembly.segments:
        density = model.materials[elements[segment.id].material].density
        assert weights[segment.id] == pytest.approx(segment.volume * density, rel=EXACT)
    of_segments = sum(segment.volume for segment in meshed.assembly.segments)
    assert of_segments == pytest.approx(meshed.classified.evaluated.solid.true_volume, rel=1e-6)
    assert sum(weights.values()) == pytest.approx(meshed.checks.model_mass, rel=EXACT)
    assert meshed.checks.passed, meshed.checks.failures
