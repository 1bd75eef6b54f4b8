"""What straight edges and flat elements leave out of walls: in the ledger to the last digit, and never much."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from solids import cube, difference, rod, tube, turned, union

from app.pipeline import Meshed, classify, mesh
from kernel.csg.reader import read_model
from kernel.mesh.options import MeshOptions

FLANGED = difference(union(rod(10, 100), rod(200, 60)), rod(300, 56, (0, 0, -50)))
DISC = rod(4, 150)
BOSS = union(cube(300, 300, 10), rod(60, 60, (150, 150, 10)))
LEANING = difference(
    union(cube(300, 240, 10), tube(250, 40, 36, (110, 120, -40), turned("y", 30))),
    cube(900, 900, 400, (-300, -300, -400)),
)
BRANCHED = difference(
    union(rod(300, 60), rod(150, 30, (0, 0, 130), turned("y", 60))),
    rod(400, 56, (0, 0, -50)),
    rod(200, 27, (0, 0, 130), turned("y", 60)),
)
WAYS = [
    MeshOptions(size=30.0, per_circle=12),
    MeshOptions(size=12.0),
    MeshOptions(size=17.0, faces="tri"),
    MeshOptions(size=25.0, order=2),
]


def meshed_of(text: str, options: MeshOptions) -> Meshed:
    return mesh(classify(read_model(text, "round")), options)


@pytest.mark.parametrize("options", WAYS, ids=["coarse", "quads", "triangles", "second order"])
@pytest.mark.parametrize("text", [FLANGED, DISC, BRANCHED], ids=["flanged", "disc", "branched"])
def test_the_ledger_closes_on_curved_walls(text, options):
    meshed = meshed_of(text, options)
    assert meshed.checks.accounted_mass_error == pytest.approx(0.0, abs=1e-9)
    assert any(row.kind == "chords" for row in meshed.assembly.ledger)


def test_twelve_chords_to_a_turn_cut_off_what_the_polygon_lacks_and_are_warned_of():
    options = MeshOptions(size=200.0, per_circle=12)
    meshed = meshed_of(DISC, options)
    (row,) = [row for row in meshed.assembly.ledger if row.kind == "chords"]
    polygon = 0.5 * 12 * np.sin(2 * np.pi / 12)
    assert row.volume == pytest.approx(4 * 150**2 * (polygon - np.pi), rel=1e-9)
    assert any("straight edges" in line and "-4.5%" in line for line in meshed.assembly.warnings)


def test_a_missing_element_is_no_chord():
    meshed = meshed_of(DISC, MeshOptions(size=12.0))
    whole = meshed.checks.accounted_mass_error
    (block,) = meshed.model.mesh.blocks
    torn = replace(meshed.model.mesh, blocks=(replace(block, connectivity=block.connectivity[1:]),))
    from kernel.connect.checks import check_model

    checks = check_model(replace(meshed.model, mesh=torn), meshed.assembly, meshed.classified.evaluated)
    assert abs(whole) < 1e-9 < abs(checks.accounted_mass_error)


@pytest.mark.parametrize("text", [FLANGED, BOSS, LEANING], ids=["flanged", "boss", "leaning"])
def test_coarse_sizes_keep_the_mass_by_more_elements_round_discs(text):
    meshed = meshed_of(text, MeshOptions(size=60.0))
    checks = meshed.checks
    lost = sum(row.volume for row in checks.ledger if row.kind == "chords")
    assert checks.passed, checks.failures
    assert abs(lost / meshed.classified.evaluated.solid.true_volume + checks.accounted_mass_error) < 5e-3


def test_small_discs_on_a_large_model_keep_the_usual_elements():
    text = union(cube(900, 900, 20), rod(30, 20, (450, 450, 20)))
    few = meshed_of(text, MeshOptions(size=60.0)).model.mesh
    alone = meshed_of(rod(30, 20), MeshOptions(size=60.0)).model.mesh

    def round_it(nodes: np.ndarray, centre: tuple[float, float], height: float) -> int:
        away = np.hypot(nodes[:, 0] - centre[0], nodes[:, 1] - centre[1])
        return int((np.isclose(away, 20.0, rtol=1e-6) & np.isclose(nodes[:, 2], height)).sum())

    top = [round_it(few.nodes, (450, 450), 50.0), round_it(alone.nodes, (0, 0), 30.0)]
    assert top[0] < 20 < top[1]
