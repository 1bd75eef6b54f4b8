"""Flat faces against cylinders: what touches is joined wherever the cylinder's facets lie, what nearly does is told."""

from __future__ import annotations

import re

import numpy as np
import pytest
from solids import cube, placed, rod, tube, turned, union
from test_catalogue import any_turn

from app.pipeline import Classified, Meshed, classify, mesh
from kernel.connect.contacts import find_joints
from kernel.connect.gaps import near_misses
from kernel.connect.sides import sides_of
from kernel.connect.tangents import tangents
from kernel.csg.reader import read_model
from kernel.mesh.options import MeshOptions
from kernel.segment.faces import faces_of
from kernel.solid.lathe import SAGITTA

ASIDE = (31.7, -23.1, 11.3)
ALL_ROUND = [(0, 90, 180, 270), (10, 100, 143, 200)]


def classified_of(text: str, turn: np.ndarray | None = None, gap: float = 0.0) -> Classified:
    return classify(read_model(text if turn is None else placed(text, ASIDE, turn), "tangents"), gap=gap)


def told(found: Classified) -> tuple[str, ...]:
    return near_misses(found.partition.segments, found.evaluated, found.joints)


def gussets(off: float, angles: tuple[float, ...], inside: bool = False) -> str:
    """A tube and plates about it whose flat ends stand `off` from where they would be tangent to it."""
    start = 394 - off - 60 if inside else 400 + off
    around = [cube(60, 8, 450, tuple(turned("z", a) @ (start, -4, 100)), turned("z", a)) for a in angles]
    return union(tube(900, 400, 394), *around)


def nodes_of(meshed: Meshed) -> dict[str, np.ndarray]:
    """Numbers of nodes by segment."""
    found: dict[str, list[np.ndarray]] = {}
    for block in meshed.model.mesh.blocks:
        found.setdefault(block.segment, []).append(block.connectivity.ravel())
    return {name: np.unique(np.concatenate(parts)) for name, parts in found.items()}


@pytest.mark.parametrize("turn", [None, any_turn(8)], ids=["straight", "turned"])
@pytest.mark.parametrize("angles", ALL_ROUND)
@pytest.mark.parametrize("off, inside", [(0.0, False), (-0.01, False), (-0.03, False), (-3.0, False), (0.01, True)])
def test_gussets_about_a_tube_are_joined_alike(angles, turn, off, inside):
    found = classified_of(gussets(off, angles, inside), turn)
    assert [joint.kind for joint in found.joints] == ["pipe"] * 4
    assert told(found) == ()
    meshed = mesh(found, MeshOptions(size=50.0))
    assert meshed.checks.passed, meshed.checks.failures
    assert meshed.checks.components == 1
    assert meshed.model.couplings == ()
    nodes = nodes_of(meshed)
    (shell,) = [segment.id for segment in found.partition.segments if segment.type == "cylinder_plate"]
    shared = [len(np.intersect1d(nodes[shell], own)) for name, own in nodes.items() if name != shell]
    assert shared == [11] * 4  # 450 / 50, made even, and one more


@pytest.mark.parametrize("turn", [None, any_turn(8)], ids=["straight", "turned"])
@pytest.mark.parametrize("angles", ALL_ROUND)
def test_gussets_a_little_off_a_tube_are_told_alike_and_joined_by_the_gap_that_is_named(angles, turn):
    text = gussets(0.5, angles)
    found = classified_of(text, turn)
    assert found.joints == ()
    lines = [re.search(r"are (\S+) apart .*a stated gap of (\S+) would join them", line) for line in told(found)]
    assert [(line[1], line[2]) for line in lines] == [("0.5", "0.5")] * 4
    joined = classified_of(text, turn, gap=0.51)
    assert [joint.gap for joint in joined.joints] == pytest.approx([0.5] * 4, abs=1e-6)
    meshed = mesh(joined, MeshOptions(size=50.0))
    assert meshed.checks.passed, meshed.checks.failures
    assert meshed.checks.components == 1


@pytest.mark.parametrize("off", [2.0, 10.0])
def test_gussets_far_from_a_tube_are_not_told(off):
    found = classified_of(gussets(off, (0, 77)))
    assert found.joints == ()
    assert told(found) == ()


def test_a_solid_tangent_to_a_tube_is_told_and_not_joined():
    found = classified_of(union(tube(200, 60, 56), cube(150, 120, 150, (-75, 60, 25))))
    assert sorted(segment.type for segment in found.partition.segments) == ["brick", "cylinder_plate"]
    assert found.joints == ()
    (line,) = told(found)
    assert "touch along a line of a cylinder: they are not joined" in line


@pytest.mark.parametrize("angle", [0, 33, 90, 180, 270])
@pytest.mark.parametrize("depth", [0.0, 0.4])
def test_a_plate_on_a_pipe_is_tied_along_the_line_of_contact(angle, depth):
    text = placed(union(tube(200, 60, 56), cube(240, 6, 160, (-120, 60 - depth, 20))), turn=turned("z", angle))
    meshed = mesh(classified_of(text), MeshOptions(size=15.0))
    assert [joint.kind for joint in meshed.classified.joints] == ["lap"]
    assert meshed.checks.passed, meshed.checks.failures
    assert meshed.checks.components == 1
    tied = meshed.model.mesh.nodes[sorted({int(coupling.nodes[0]) for coupling in meshed.model.couplings})]
    tied = tied @ turned("z", angle)
    assert tied[:, 0] == pytest.approx(np.zeros(len(tied)), abs=1e-6)
    assert tied[:, 1] == pytest.approx(np.full(len(tied), 63.0 - depth))
    assert np.sort(tied[:, 2]) == pytest.approx(np.linspace(20, 180, len(tied)))
    assert len(tied) >= 160 / 15


@pytest.mark.parametrize("angle", [0, 33, 90, 180, 270])
def test_the_strip_within_reach_has_its_closed_form_on_both_surfaces(angle):
    away, reach = 60.3, 0.5
    text = placed(union(rod(200, 60), cube(240, 40, 160, (-120, away, 20))), turn=turned("z", angle))
    found = classified_of(text)
    faces = [faces_of(segment.solid) for segment in found.partition.segments]
    rows = [row for index, of_segment in enumerate(faces) for row in sides_of(index, of_segment)]
    table = found.evaluated.solid.surfaces
    (item,) = tangents(rows, faces, table.surfaces, table.tolerance, lambda _: reach, ())
    half = np.sqrt((60 + reach) ** 2 - away**2)
    assert item.flat_patch.area == pytest.approx(2 * half * 160, rel=1e-6)
    assert item.round_patch.area == pytest.approx(2 * 60 * np.arctan(half / away) * 160, rel=1e-6)
    assert item.least == pytest.approx(away - 60, abs=1e-9)
    assert item.most == pytest.approx(reach, abs=1e-6)
    assert item.share == pytest.approx(2 * half / 240, rel=1e-6)


def test_joints_are_numbered_in_the_order_of_their_segments():
    found = classified_of(gussets(-0.03, (10, 100, 143, 200)))
    joints = find_joints(found.partition.segments, found.evaluated)
    assert [joint.segments for joint in joints] == sorted(joint.segments for joint in joints)
    areas = [joint.area for joint in joints]
    assert min(areas) > 8 * 450 * 0.1 and max(areas) < 8 * 450 * (1 + SAGITTA)
