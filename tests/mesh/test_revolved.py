"""Solids of revolution as one brick: hexahedra turned about the axis, round a core that no element degenerates in."""

from __future__ import annotations

import numpy as np
import pytest
from assembling import RULES, WHOLE, assembled, audit, cube, difference, mesh_volume, placed, rod, turned, union
from test_second_order_cases import least_density, middles_off

from kernel.csg.reader import read_model
from kernel.errors import MeshError
from kernel.idealise.revolved import revolved_brick
from kernel.mesh.bricks import outer_faces
from kernel.mesh.quality import mesh_quality
from kernel.mesh.revolve import mesh_revolved
from kernel.plan import Override
from kernel.segment.partition import partition
from kernel.solid.evaluate import evaluate


def cone(height: float, bottom: float, top: float, at=(0.0, 0.0, 0.0)) -> str:
    return placed(f"cylinder($fn=0,$fa=3,$fs=.2,h={height},r1={bottom},r2={top},center=false);", at)


def ball(radius: float, at=(0.0, 0.0, 0.0)) -> str:
    return placed(f"sphere($fn=0,$fa=3,$fs=.2,r={radius});", at)


TORUS = (
    "rotate_extrude(angle=360,convexity=2,$fn=0,$fa=3,$fs=.2){multmatrix([[1,0,0,90],[0,1,0,0],[0,0,1,0],[0,0,0,1]])"
    "{circle($fn=0,$fa=3,$fs=.2,r=25);}}"
)
REVOLVED = {
    "a stub of a cone": cone(90, 60, 20),
    "a bored cone": difference(cone(40, 60, 40), rod(60, 20, (0, 0, -5))),
    "a chamfered shaft": union(rod(50, 20), cone(5, 20, 15, (0, 0, 50))),
    "a flange with a tapered hub": difference(
        union(rod(15, 80), cone(40, 50, 35, (0, 0, 15))), rod(100, 25, (0, 0, -1))
    ),
    "a ball": ball(50),
    "a dome": difference(ball(50), cube(200, 200, 100, (-100, -100, -100))),
    "a shaft with a round end": union(rod(60, 20), ball(20, (0, 0, 60))),
    "a ring": TORUS,
    "a stub, turned": placed(cone(90, 60, 20), (5, 6, 7), turned("x", 33) @ turned("y", 20)),
}


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("name", REVOLVED)
def test_a_solid_of_revolution_is_meshed_with_hexahedra_alone(name, order):
    assembly, evaluated = assembled(REVOLVED[name], {"/": "brick"}, volumes="hex", order=order)
    kind = "hex8" if order == 1 else "hex20"
    assert set(assembly.mesh.count()) == {kind}
    assert assembly.bricks["s1"].startswith("hexahedra turned about ")
    assert mesh_quality(assembly.mesh)[kind]["scaled_jacobian"]["min"] >= 0.5
    assert audit(assembly) == WHOLE
    if order == 1:
        assert mesh_volume(assembly) == pytest.approx(evaluated.solid.true_volume, rel=0.005)
        _, quads = outer_faces(assembly.mesh.blocks)
        edges = np.sort(np.stack([quads, np.roll(quads, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    else:
        assert least_density(assembly) > 0.1
        checked, off = middles_off(assembly, 1e-9 * evaluated.size)
        assert checked > 0 and off == 0
        assert not any("drawn back" in warning for warning in assembly.warnings)


@pytest.mark.parametrize("text", [cone(50, 30, 0), difference(ball(50), ball(30))], ids=["a tip", "a void on the axis"])
def test_what_has_no_core_is_refused_where_hexahedra_are_insisted_on(text):
    with pytest.raises(MeshError, match="hexahedra only: not a stack of prisms"):
        assembled(text, {"/": "brick"}, volumes="hex")


def test_a_solid_that_only_looks_turned_is_not():
    notched = difference(cone(90, 60, 20), cube(20, 20, 20, (40, -10, -1)))
    with pytest.raises(MeshError, match="hexahedra only"):
        assembled(notched, {"/": "brick"}, volumes="hex")


def test_a_solid_that_would_be_turned_badly_is_told_with_the_place(monkeypatch):
    monkeypatch.setattr("kernel.mesh.revolve.LEAST_QUALITY", 1.1)
    at, turn = np.array([500.0, -300, 200]), turned("x", 33)
    evaluated = evaluate(read_model(placed(cone(90, 60, 20), tuple(at), turn), "test"))
    (segment,) = partition(evaluated, RULES.decide, {"/": Override("brick")}).segments
    brick = revolved_brick(segment, 1e-6 * evaluated.size, evaluated.size, evaluated.frame)
    assert brick is not None
    with pytest.raises(MeshError, match=r"scaled Jacobian .* near \(") as refused:
        mesh_revolved(brick, 15.0, "quad", 1)
    place = np.array(str(refused.value).split("near (")[1].rstrip(")").split(","), float)
    along, across = (place - at) @ turn[:, 2], np.linalg.norm(np.cross(place - at, turn[:, 2]))
    assert 0 < along < 90 and across < 60
