"""The model as built from examples: frame, sets, properties, materials, masses, couplings by joint."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from app.pipeline import Classified, classify
from kernel.connect.build import build_model, clean_coordinates
from kernel.connect.checks import check_model
from kernel.connect.model import Mpc, Rbe2, Rbe3
from kernel.csg.reader import read_model
from kernel.errors import OptionError
from kernel.materials import choose_material
from kernel.mesh.assemble import assemble
from kernel.mesh.assembly import Assembly
from kernel.mesh.options import MeshOptions
from kernel.units import unit_set

TABLE = """
UNITS mm
TOP = BLO(800, 500, 25)
LEG = BLO(40, 40, 700)
LEGS = LEG UN (LEG AT (MOVX=760)) UN (LEG AT (MOVY=460)) UN (LEG AT (MOVX=760, MOVY=460))
TABLE = (TOP AT (MOVZ=700)) UN LEGS
OUT TABLE
"""

ANGLE = """
BASE = BLO(100, 80, 6)
BACK = BLO(6, 80, 100)
CORNER = BASE UN BACK
OUT CORNER
"""


@cache
def parts(text: str) -> tuple[Classified, Assembly]:
    classified = classify(read_model(text, "model.csg"))
    options = MeshOptions(size=40.0 if "TABLE" in text else 20.0)
    assembly = assemble(classified.evaluated, classified.partition.segments, classified.joints, options)
    return classified, assembly


def build(text: str, **options):
    classified, assembly = parts(text)
    model = build_model(assembly, classified.evaluated, classified.csg, units=classified.units, **options)
    return model, check_model(model, assembly, classified.evaluated)


def test_named_nodes_become_sets_with_all_that_is_under_them():
    model, _ = build(TABLE)
    sets = {named.name: named for named in model.sets}
    assert {"TOP", "LEGS", "TABLE"} <= set(sets)
    assert len(sets["TABLE"].elements) == sum(model.mesh.count().values())
    assert len(sets["TOP"].elements) == model.mesh.count()["quad4"]
    assert len(sets["LEGS"].elements) == model.mesh.count()["line2"]
    z = model.mesh.nodes[sets["TOP"].nodes, 2]
    assert z == pytest.approx(712.5)


def test_a_name_that_stands_four_times_is_written_with_its_path():
    model, _ = build(TABLE)
    legs = [named.name for named in model.sets if named.name.startswith("LEG_")]
    assert len(legs) == len(set(legs)) == 4


def test_every_segment_has_a_property_and_a_set():
    model, _ = build(TABLE)
    ids = [segment.id for segment in parts(TABLE)[0].partition.segments]
    assert [element.segment for element in model.properties] == ids
    assert set(ids) <= {named.name for named in model.sets}
    assert [element.kind for element in model.properties].count("beam") == 4


def test_the_model_stands_in_the_users_frame():
    model, _ = build(TABLE)
    assert model.mesh.nodes.min(axis=0) == pytest.approx([0, 0, 0], abs=25)
    assert model.mesh.nodes[:, 2].max() == pytest.approx(712.5)


def test_a_turned_model_is_turned_back_beam_axes_and_all():
    turned = TABLE.replace("OUT TABLE", "OUT TURNED").replace(
        "OUT", "TURNED = TABLE AT (ROTX=30, ROTZ=50, MOVX=1000)\nOUT", 1
    )
    still, moved = build(TABLE)[0], build(turned)[0]
    c, s = np.cos(np.radians([30, 50])), np.sin(np.radians([30, 50]))
    turn_x = np.array([[1, 0, 0], [0, c[0], -s[0]], [0, s[0], c[0]]])
    turn_z = np.array([[c[1], -s[1], 0], [s[1], c[1], 0], [0, 0, 1]])
    turn = turn_z @ turn_x
    assert moved.mesh.count()["line2"] == still.mesh.count()["line2"]
    back = (moved.mesh.nodes - [1000, 0, 0]) @ turn
    assert np.ptp(back, axis=0) == pytest.approx(np.ptp(still.mesh.nodes, axis=0), abs=1e-6)
    for block in moved.mesh.blocks:
        if block.orientation is not None:
            ends = moved.mesh.nodes[block.connectivity]
            along = (ends[:, 1] - ends[:, 0]) @ turn
            assert np.abs(along[:, :2]).max() < 1e-6  # the legs are upright
            assert np.abs((block.orientation @ turn)[:, 2]).max() < 1e-9


def test_the_checks_pass_and_count_one_piece():
    _, checks = build(TABLE)
    assert checks.passed, checks.failures
    assert checks.components == checks.solid_components == 1
    assert checks.mass_error == pytest.approx(0, abs=1e-9)


def test_a_corner_that_two_plates_share_is_in_the_ledger():
    _, checks = build(ANGLE)
    assert checks.passed, checks.failures
    assert checks.mass_error == pytest.approx(0, abs=0.01)
    assert checks.accounted_mass_error == pytest.approx(0, abs=1e-9)
    text = checks.to_json()
    assert text["passed"] is True
    assert set(text["mass"]) == {"solid", "model", "error", "ledger", "accounted_error"}


def test_exact_mass_scales_the_density_of_each_segment():
    model, checks = build(ANGLE, mass="exact")
    assert checks.mass_error == pytest.approx(0, abs=1e-12)
    assert checks.passed, checks.failures
    assert len({element.density_factor for element in model.properties}) > 1 or model.properties[0].density_factor != 1


@pytest.mark.parametrize(("kind", "expected"), [("distributing", Rbe3), ("rigid", Rbe2), ("work", Mpc)])
def test_the_legs_are_coupled_as_asked(kind, expected):
    model, checks = build(TABLE, coupling=kind)
    assert {type(coupling) for coupling in model.couplings} == {expected}
    assert checks.passed, checks.failures
    assert checks.coupling_error < 1e-9


def test_one_joint_may_be_coupled_unlike_the_others():
    joint = parts(TABLE)[0].joints[1].id
    model, checks = build(TABLE, joint_couplings={joint: "rigid"})
    kinds = [type(coupling) for coupling in model.couplings]
    assert kinds.count(Rbe2) == 1 and kinds.count(Rbe3) == 3
    assert checks.passed, checks.failures


def test_unknown_joints_couplings_and_masses_are_refused():
    with pytest.raises(OptionError, match="no joint 'j99' in the model, expected one of j1"):
        build(TABLE, joint_couplings={"j99": "rigid"})
    with pytest.raises(OptionError, match="unknown coupling 'glue'"):
        build(TABLE, joint_couplings={"j1": "glue"})
    with pytest.raises(OptionError, match="unknown mass"):
        build(TABLE, mass="guessed")


def test_the_models_own_material_is_taken_and_the_users_wins():
    csg = read_model("MATERIAL BRASS(E=97000, NU=0.34, RHO=8.5e-9)\n" + ANGLE, "model.csg")
    units = unit_set("mm")
    assert choose_material(None, csg, units).elastic_modulus == 97000
    assert choose_material("brass", csg, units).density == 8.5e-9
    assert choose_material("aluminium", csg, units).elastic_modulus == 70000
    with pytest.raises(OptionError, match="unknown material 'cheese'"):
        choose_material("cheese", csg, units)


def test_without_a_word_it_is_steel():
    material = choose_material(None, read_model(ANGLE, "model.csg"), unit_set("m"))
    assert material.name == "steel"
    assert material.elastic_modulus == 210e9
    assert material.density == 7850


@pytest.mark.parametrize("units", ["mm", "in"])
def test_a_material_that_the_model_only_names_keeps_its_source(units):
    named = read_model(f"UNITS {units}\nMATERIAL Stainless\n{ANGLE}", "model.csg")
    assert choose_material(None, named, unit_set(units)).source.startswith("EN 1993-1-4")
    own = read_model(f"UNITS mm\nMATERIAL steel(E=200000, NU=0.3, RHO=7.85E-9)\n{ANGLE}", "model.csg")
    assert choose_material(None, own, unit_set("mm")).source == "the model"


@pytest.mark.parametrize(
    "values",
    [
        {"E": -1, "NU": 0.3, "RHO": 1},
        {"E": 1, "NU": 0.7, "RHO": 1},
        {"E": 1, "NU": 0.3, "RHO": -1},
        {"E": 1, "NU": 0.3},
    ],
)
def test_a_material_that_is_none_is_refused(values):
    csg = replace(read_model(ANGLE, "model.csg"), materials={"ODD": values})
    with pytest.raises(OptionError, match="material 'ODD'"):
        choose_material(None, csg, unit_set("mm"))


def test_coordinates_lose_the_rounding_of_rotations():
    points = np.array([[-1.8e-14, 1e-13, 333.33333333333337]])
    clean = clean_coordinates(points, 1000.0)
    assert clean[0, :2].tolist() == [0.0, 0.0]
    assert not np.signbit(clean[0, 0])
    assert clean[0, 2] == pytest.approx(1000 / 3, rel=1e-11)


FIN = """
BLOCK = BLO(120, 60, 60)
FIN = BLO(100, 4, 80) AT (MOVX=10, MOVY=28, MOVZ=60)
BODY = BLOCK UN FIN
OUT BODY
"""


@pytest.mark.parametrize("coupling", ["distributing", "rigid", "work"])
@pytest.mark.parametrize("order", [1, 2])
def test_a_plate_on_a_block_is_tied_along_its_edge(order, coupling):
    classified = classify(read_model(FIN, "model.csg"))
    options = MeshOptions(size=15.0, order=order)
    assembly = assemble(classified.evaluated, classified.partition.segments, classified.joints, options)
    model = build_model(assembly, classified.evaluated, classified.csg, units=classified.units, coupling=coupling)
    checks = check_model(model, assembly, classified.evaluated)
    assert checks.passed, checks.failures
    assert checks.components == 1
    if coupling == "work":
        assert any("only a beam's section" in note for note in model.notes)


def test_nodes_and_segments_may_have_materials_of_their_own():
    beams = [s.id for s in parts(TABLE)[0].partition.segments if s.type == "beam"]
    model, checks = build(TABLE, materials_of={"TOP": "aluminium", "LEGS": "titanium", beams[0]: "concrete"})
    by_segment = {element.segment: element.material for element in model.properties}
    assert by_segment[beams[0]] == "concrete"
    assert {by_segment[beam] for beam in beams[1:]} == {"titanium"}
    assert set(by_segment.values()) == {"concrete", "titanium", "aluminium"}
    assert set(model.materials) == set(by_segment.values())
    assert checks.passed, checks.failures


def test_the_deeper_node_decides_the_material():
    model, _ = build(TABLE, materials_of={"/": "stainless", "TOP": "aluminium"})
    assert [element.material for element in model.properties].count("stainless") == 4
    assert [element.material for element in model.properties].count("aluminium") == 1


def test_a_material_of_nothing_is_refused():
    with pytest.raises(OptionError, match="material of 'LID': no node 'LID'"):
        build(TABLE, materials_of={"LID": "steel"})


@pytest.mark.parametrize("mass", ["plain", "exact"])
def test_a_model_that_weighs_nothing_is_checked_by_its_volumes(mass):
    foam = TABLE.replace("UNITS mm", "UNITS mm\nMATERIAL FOAM(E=10, NU=0.3, RHO=0)")
    model, weightless = build(foam, mass=mass)
    _, of_steel = build(TABLE, mass=mass)
    assert {material.density for material in model.materials.values()} == {0.0}
    assert (weightless.solid_mass, weightless.model_mass, weightless.ledger_mass) == (0.0, 0.0, 0.0)
    assert not weightless.model_inertia.any()
    assert weightless.failures == ()
    assert weightless.mass_error == pytest.approx(of_steel.mass_error, abs=1e-12)
    assert weightless.accounted_mass_error == pytest.approx(of_steel.accounted_mass_error, abs=1e-12)
    assert weightless.model_centre == pytest.approx(of_steel.model_centre)
