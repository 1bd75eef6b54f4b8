"""Cylinders side by side: what touches along a line is found on the true surfaces, and held there."""

from __future__ import annotations

import numpy as np
import pytest
from solids import cube, placed, rod, tube, turned, union
from test_catalogue import ASIDE, any_turn

from app.pipeline import Classified, Meshed, classify, mesh
from kernel.connect.side_by_side import neighbours
from kernel.connect.sides import sides_of
from kernel.csg.reader import read_model
from kernel.mesh.options import MeshOptions
from kernel.segment.faces import faces_of
from kernel.solid.lathe import SAGITTA


def classified_of(text: str, turn: np.ndarray | None = None, gap: float = 0.0) -> Classified:
    return classify(read_model(text if turn is None else placed(text, ASIDE, turn), "lines"), gap=gap)


def meshed_of(found: Classified, size: float = 20.0) -> Meshed:
    meshed = mesh(found, MeshOptions(size=size))
    assert meshed.checks.passed, meshed.checks.failures
    return meshed


@pytest.mark.parametrize("angle", [0, 33, 90, 180, 270])
@pytest.mark.parametrize(
    "other, at, bend", [(40.0, 100.3, 1 / 60 + 1 / 40), (30.0, 25.8, 1 / 30 - 1 / 56)], ids=["beside", "in the bore"]
)
def test_the_strip_within_reach_has_its_closed_form_on_both_cylinders(angle, other, at, bend):
    found = classified_of(
        placed(union(tube(200, 60, 56), tube(120, other, other - 3, (at, 0, 50))), turn=turned("z", angle))
    )
    faces = [faces_of(segment.solid) for segment in found.partition.segments]
    rows = [row for index, of_segment in enumerate(faces) for row in sides_of(index, of_segment)]
    table = found.evaluated.solid.surfaces
    (item,) = neighbours(rows, faces, table.surfaces, table.tolerance, 0.5, ())
    radii = [table.surfaces[row.surface].radius for row in item.faces]
    assert sorted(radii) == pytest.approx(sorted([other, 60 if other == 40 else 56]))
    gap = abs(at - (100 if other == 40 else 26))
    assert item.gap == pytest.approx(gap, abs=1e-9)
    half = np.sqrt(2 * (0.5 + SAGITTA * sum(radii) - gap) / bend)
    for radius, patch in zip(radii, item.patches):
        assert patch.area == pytest.approx(2 * radius * np.arcsin(half / radius) * 120, rel=1e-6)


@pytest.mark.parametrize("turn", [None, any_turn(8)], ids=["straight", "turned"])
@pytest.mark.parametrize("angle", [0, 10, 77, 143])
@pytest.mark.parametrize("bite", [0.0, 0.01, 0.03, 1.0])
def test_two_tubes_are_tied_along_the_line_in_the_plane_of_both_axes(angle, turn, bite):
    text = placed(union(tube(200, 60, 56), tube(160, 40, 37, (100 - bite, 0, 20))), turn=turned("z", angle))
    found = classified_of(text, turn)
    assert [joint.kind for joint in found.joints] == ["lap"]
    meshed = meshed_of(found)
    assert meshed.checks.components == 1
    tied = meshed.model.mesh.nodes[sorted({int(coupling.nodes[0]) for coupling in meshed.model.couplings})]
    tied = (tied if turn is None else (tied - ASIDE) @ turn) @ turned("z", angle)
    assert np.abs(tied[:, 1]).max() < 10  # in the contact
    on_line = tied[np.abs(tied[:, 1]) < 1e-6]
    assert on_line[:, 0] == pytest.approx(np.full(len(on_line), 100 - bite - 38.5), abs=1e-6)
    assert np.sort(on_line[:, 2]) == pytest.approx(np.linspace(20, 180, len(on_line)), abs=1e-6)
    assert len(on_line) >= 160 / 20


def test_tubes_a_little_apart_are_told_and_joined_by_the_gap_that_is_named():
    text = union(tube(300, 60, 56), tube(300, 40, 37, (0, 100.05, 0)))
    found = classified_of(text)
    assert found.joints == ()
    told = meshed_of(found).warnings
    assert any("0.05 apart" in line and "a stated gap of 0.05 would join them" in line for line in told)
    joined = classified_of(text, gap=0.051)
    assert [joint.gap for joint in joined.joints] == pytest.approx([0.05], abs=1e-9)
    assert meshed_of(joined).checks.components == 1


def test_fins_that_touch_share_nodes_with_the_tubes_on_both_sides():
    tubes = [tube(300, 25, 21, (150 * k, 0, 0)) for k in range(2)]
    meshed = meshed_of(classified_of(union(*tubes, cube(100, 6, 300, (25, -3, 0)))))
    nodes: dict[str, set[int]] = {}
    for block in meshed.model.mesh.blocks:
        nodes.setdefault(block.segment, set()).update(block.connectivity.ravel().tolist())
    kinds = {segment.id: segment.type for segment in meshed.classified.partition.segments}
    (fin,) = [name for name, kind in kinds.items() if kind == "plate"]
    shared = [len(nodes[fin] & own) for name, own in nodes.items() if name != fin]
    assert len(shared) == 2 and min(shared) >= 300 / 20
    assert meshed.model.couplings == ()


def test_what_touches_along_a_line_is_told():
    bar = union(tube(300, 60, 56), rod(260, 8, (68, 0, 20)))
    assert any(
        "touch along a line" in line and "as by a weld" in line for line in meshed_of(classified_of(bar)).warnings
    )


def test_solid_rods_that_touch_along_a_line_are_left_apart():
    found = classified_of(union(rod(60, 40), rod(60, 40, (80, 0, 0))))
    assert [segment.type for segment in found.partition.segments] == ["brick", "brick"]
    assert found.joints == ()
