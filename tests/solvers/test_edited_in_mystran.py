"""The thesis's sequence (its figures 5.21 to 5.23 and 6.36): meshed apart, merged, connected; and nodes added.

The result bends as the mesh does whose plates shared their curves from the beginning.
"""

from pathlib import Path

import numpy as np
import pytest
from verification.loading import Case, held_at, mystran, nodes_where, spread

from app.pipeline import classify, mesh, read
from kernel.connect.checks import check_against
from kernel.connect.reference import reference_of
from kernel.edit.connecting import connect_model
from kernel.edit.edited import Edited
from kernel.edit.inserting import add_node
from kernel.edit.merging import merge_models
from kernel.mesh.options import MeshOptions

BRACKET = Path(__file__).parents[2] / "examples" / "bracket.csg"

pytestmark = pytest.mark.solver


def top_of_wall(places):
    return places[:, 2] > 139.9


def tip_of_base(places):
    return places[:, 0] > 159.9


def sag(model) -> float:
    """Mean deflection of the base's tip under 100 N, the wall held along its top."""
    solved = mystran(model, Case(held_at(model, top_of_wall), spread(model, tip_of_base, (0, 0, -100.0))))
    assert solved.epsilon < 1e-6
    return float(solved.displacements[nodes_where(model, tip_of_base), 2].mean())


@pytest.fixture(scope="module")
def bracket():
    return classify(read(str(BRACKET)))


@pytest.fixture(scope="module")
def shared(bracket):
    return sag(mesh(bracket, MeshOptions(size=8)).model)


def by_hand(bracket, sizes):
    edited = None
    for segment, size in zip(bracket.partition.segments, sizes, strict=True):
        part = mesh(bracket, MeshOptions(size=size), only=[segment.id])
        one = Edited.of(part.model, reference_of(part.assembly, bracket.evaluated))
        edited = one if edited is None else merge_models(edited, one).edited
    assert check_against(edited.model, edited.reference).components == 3
    edited = connect_model(edited)
    checks = check_against(edited.model, edited.reference)
    assert checks.passed and checks.components == 1, checks.failures
    return edited


@pytest.mark.parametrize("sizes, within", [((8, 8, 8), 0.005), ((9, 6, 7), 0.01)])
def test_plates_meshed_apart_merged_and_connected_bend_as_those_on_shared_curves(bracket, shared, sizes, within):
    assert sag(by_hand(bracket, sizes).model) == pytest.approx(shared, rel=within)


def test_a_node_more_changes_next_to_nothing(bracket, shared):
    meshed = mesh(bracket, MeshOptions(size=8))
    edited = Edited.of(meshed.model, reference_of(meshed.assembly, bracket.evaluated))
    edited = add_node(add_node(edited, (133.3, 51.7, 5.0)), (5.0, 31.3, 71.1))
    assert check_against(edited.model, edited.reference).passed
    assert sag(edited.model) == pytest.approx(shared, rel=0.002)
    assert np.linalg.norm(edited.model.mesh.nodes - (133.3, 51.7, 5.0), axis=1).min() < 1e-9


@pytest.mark.parametrize(
    ("name", "size", "axis", "way", "within"),
    [
        ("lap_of_two_plates", 15, 0, 2, 0.01),
        ("coplanar_step", 15, 0, 2, 0.005),
        ("rail_on_sheet", 20, 0, 2, 0.005),
        ("block_with_fin", 20, 0, 2, 0.005),
        ("pin_on_plate", 15, 2, 0, 0.005),
        ("ladder", 50, 2, 1, 0.015),
    ],
)
def test_what_touches_half_a_thickness_apart_bends_by_hand_as_meshed_together(name, size, axis, way, within):
    """Parts meshed alone with sizes of their own, connected; held at one end, loaded at the other."""
    base = classify(read(str(BRACKET.parents[1] / "tests" / "cases" / f"{name}.csg")))
    edited = None
    for number, segment in enumerate(base.partition.segments):
        part = mesh(base, MeshOptions(size=size * (1, 0.83)[number % 2]), only=[segment.id])
        one = Edited.of(part.model, reference_of(part.assembly, base.evaluated))
        edited = one if edited is None else merge_models(edited, one).edited
    assert deflection(connect_model(edited).model, axis, way) == pytest.approx(
        deflection(mesh(base, MeshOptions(size=size)).model, axis, way), rel=within
    )


def deflection(model, axis, way) -> float:
    along = model.mesh.nodes[:, axis]
    hair = 1e-3 * np.ptp(along)
    force = np.zeros(3)
    force[way] = -100.0

    def far(places):
        return places[:, axis] > along.max() - hair

    held = held_at(model, lambda places: places[:, axis] < along.min() + hair)
    solved = mystran(model, Case(held, spread(model, far, tuple(force))))
    assert solved.epsilon < 1e-6
    return float(solved.displacements[nodes_where(model, far), way].mean())
