"""Corners of walls much longer than thick end on the joint curve, however their corners fall on the polygons' grid."""

import numpy as np
import pytest

from app.pipeline import classify, mesh
from kernel.csg.reader import read_model
from kernel.mesh.options import MeshOptions
from kernel.plan import Override

CHANNEL = """LOW = BLO({length}, 60, {t})
WEB = BLO({length}, {t}, 88) AT (MOVZ={t})
TOP = BLO({length}, 60, {t}) AT (MOVZ=88+{t})
BEAM = LOW UN WEB UN TOP
OUT BEAM
"""


@pytest.mark.parametrize("length", [1000.0, 1234.567, 2999.99])
@pytest.mark.parametrize("thickness", [6.0, 5.4321])
def test_a_channels_web_ends_on_the_mid_surfaces_of_its_flanges(length, thickness):
    text = CHANNEL.format(length=length, t=thickness)
    classified = classify(read_model(text, "c.csg"), overrides={"/": Override("plates")})
    meshed = mesh(classified, MeshOptions(size=100.0))
    nodes = meshed.model.mesh.nodes
    half = 0.5 * thickness
    assert np.ptp(nodes[:, 2]) == pytest.approx(88.0 + thickness)
    assert nodes[:, 2].min() == pytest.approx(half)
    assert nodes[:, 1].min() == pytest.approx(half)
    assert meshed.checks.passed
