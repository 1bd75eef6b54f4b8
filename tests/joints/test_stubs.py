"""Stubs of braces in the bore of a hollow chord: modelled where they stand alone, cut off where they collide."""

from __future__ import annotations

import numpy as np
import pytest
from catalogue_tubes import careless
from solids import difference, rod, tube, turned, union

from app.pipeline import Meshed, classify, mesh
from kernel.csg.reader import read_model
from kernel.mesh.options import MeshOptions


def meshed_of(text: str) -> Meshed:
    meshed = mesh(classify(read_model(text, "stubs")), MeshOptions(size=15.0))
    assert meshed.checks.passed, meshed.checks.failures
    assert meshed.checks.components == 1
    return meshed


def cut_off(meshed: Meshed) -> list[tuple[str, float]]:
    """Segments and volumes of the ledger's rows of stubs."""
    rows = [row for row in meshed.assembly.ledger if row.cause.startswith("a stub")]
    return [(row.segments[0], row.volume) for row in rows]


def nearest_to_axis(meshed: Meshed) -> float:
    return float(np.hypot(*meshed.model.mesh.nodes[:, :2].T).min())


@pytest.mark.parametrize("braces", [[(30, 90, 150)], [(20, 60, 70), (20, 120, 230)]], ids=["one", "two apart"])
def test_stubs_that_stand_alone_are_meshed(braces):
    meshed = meshed_of(careless(braces))
    assert cut_off(meshed) == []
    assert nearest_to_axis(meshed) < 30


def test_stubs_that_run_into_one_another_end_at_the_chord_and_stand_in_the_ledger():
    meshed = meshed_of(careless([(25, 45, 150), (25, 135, 150)]))
    assert nearest_to_axis(meshed) > 57
    found = cut_off(meshed)
    assert len(found) == 2
    for name, volume in found:
        # a tube of mid-radius 23.5 and wall 3 from a cylinder of radius 58 to the middle of its axis, at 45 degrees
        angles = np.linspace(0, 2 * np.pi, 721)[:-1]
        across, along = 23.5 * np.sin(angles), 23.5 * np.cos(angles)
        length = np.sqrt(2) * np.sqrt(58**2 - across**2) - along
        assert volume == pytest.approx(
            -3 * 23.5 * 2 * np.pi * length.mean(), rel=0.02
        )  # its region reaches into the other stub
        assert any(line.startswith(f"{name} goes on in the bore of") for line in meshed.warnings)
    assert abs(meshed.checks.accounted_mass_error) < 1e-6


def test_a_tube_right_through_a_chord_is_no_stub():
    through = tube(300, 30, 27, (-150, 0, 150), turned("y", 90))
    assert cut_off(meshed_of(union(tube(300, 60, 56), through, tube(200, 20, 17, (0, 0, 60), turned("y", 90))))) == []


def test_open_joints_have_no_stubs():
    leans = [turned("y", angle) for angle in (45, 135)]
    braces = [rod(220, 25, (0, 0, 150), lean) for lean in leans]
    bores = [rod(222, 22, (0, 0, 150), lean) for lean in leans]
    assert cut_off(meshed_of(difference(union(rod(300, 60), *braces), rod(302, 56, (0, 0, -1)), *bores))) == []
