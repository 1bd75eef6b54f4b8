"""Fins on faces that two bodies share: segments keep none of them, and lose nothing else."""

from __future__ import annotations

import numpy as np
import pytest
from solids import cube, placed, tube, turned, union

from app.pipeline import classify
from kernel.csg.reader import read_model
from kernel.solid.solid import Solid


def folds(solid: Solid) -> int:
    """Edges at which a triangle lies back on its neighbour, counted from both sides."""
    normals = solid.facets.normals
    return int((np.einsum("nkc,nc->nk", normals[solid.facets.neighbours], normals) < -0.999).sum())


@pytest.mark.parametrize("sunk", [0.1, 0.5, 3.0, 9.0])
@pytest.mark.parametrize(
    "turn", [None, turned("z", 37.0), turned("x", 31.0) @ turned("y", 17.0)], ids=["straight", "about its axis", "any"]
)
def test_a_lug_that_ends_in_the_wall_of_a_tube_keeps_no_sheet_of_its_facets(turn, sunk):
    text = placed(union(tube(40, 200, 190), cube(80, 20, 10, (110 + sunk, -10, 15))), turn=turn)
    (lug,) = [s for s in classify(read_model(text, "lug")).partition.segments if s.type == "brick"]
    assert folds(lug.solid) == 0
    end = 190 * np.arcsin(10 / 190)  # half the arc of its curved end
    section = 10 * np.sqrt(190**2 - 10**2) + 190 * end - 20 * (110 + sunk)
    sides = np.sqrt(190**2 - 10**2) - 110 - sunk
    assert lug.volume == pytest.approx(10 * section, rel=1e-6)
    assert lug.solid.facets.areas.sum() == pytest.approx(2 * section + 10 * (2 * sides + 20 + 2 * end), rel=2e-3)
