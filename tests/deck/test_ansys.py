"""ANSYS archives and 5.0 commands: read back by mapdl-archive, and card by card."""

import math
from dataclasses import replace

import numpy as np
import pytest
from handmade import cantilever, channel_outline, i_outline, shell_cantilever, solid_cantilever, whole_set
from joined import half_beam_half_solid, lap_of_plates, post_on_plate
from mapdl_archive import Archive
from shapely import affinity

from kernel.deck import ansys, ansys5
from kernel.errors import DeckError
from kernel.idealise.section import principal_section, section_properties

TYPES = {
    "tri3": 181, "quad4": 181, "tri6": 281, "quad8": 281, "tet4": 185, "wedge6": 185, "hex8": 185, "tet10": 187,
    "wedge15": 186, "hex20": 186, "line2": 188, "line3": 189,
}  # fmt: skip


def model_of_kind(kind):
    if kind in ("tri3", "tri6", "quad4", "quad8"):
        return shell_cantilever(kind, 8.0, 2.0, 1.0, (2, 1))
    if kind in ("line2", "line3"):
        return cantilever(i_outline(), 100.0, 3, kind)
    return solid_cantilever(kind, (8.0, 2.0, 2.0), (2, 1, 1))


def archive(model, folder):
    path = folder / "model.cdb"
    path.write_bytes(ansys.write(model))
    return Archive(str(path), parse_vtk=False)


@pytest.mark.parametrize("kind", TYPES)
def test_mapdl_archive_reads_back_nodes_elements_and_components(tmp_path, kind):
    model = model_of_kind(kind)
    read = archive(replace(model, sets=(whole_set(model, "BRACKET"),)), tmp_path)
    count = model.mesh.count()[kind]
    assert len(read.elem) == count
    assert [int(row[1]) for row in read.ekey] == [TYPES[kind]]
    lines = count if kind.startswith("line") else 0
    assert len(read.nodes) == model.mesh.n_node + lines
    assert np.allclose(read.nodes[: model.mesh.n_node, :3], model.mesh.nodes)
    assert read.node_components["BRACKET_N"].tolist() == list(range(1, model.mesh.n_node + 1))
    assert read.element_components["BRACKET_E"].tolist() == list(range(1, count + 1))
    block = model.mesh.blocks[0]
    for element, row in zip(read.elem, block.connectivity):
        own = [int(n) - 1 for n in element[10:] if 0 < n <= model.mesh.n_node]
        assert set(own) == set(row.tolist())


def test_mixed_models_keep_their_sections_apart(tmp_path):
    read = archive(post_on_plate(), tmp_path)
    assert sorted({int(element[3]) for element in read.elem}) == [1, 2]
    assert [int(row[1]) for row in read.ekey] == [188, 181]


def commands(text: bytes, name: str) -> list[list[str]]:
    return [line.split(",") for line in text.decode().splitlines() if line.split(",")[0] == name]


def test_a_beams_section_is_complete():
    model = cantilever(channel_outline(), 100.0, 2)
    section = model.properties[0].section
    (data,) = commands(ansys.write(model), "SECDATA")
    found = [float(value) for value in data[1:]]
    expected = [section.area, section.iyy, section.iyz, section.izz, 0, section.j, 0, 0, *section.shear_centre]
    assert found == pytest.approx(expected)


def test_the_orientation_node_lies_along_the_sections_z_axis():
    model = cantilever(i_outline(), 100.0, 2)
    place = ansys.orientation_places(model.mesh.blocks[0], model.mesh.nodes)[0]
    assert place == pytest.approx([0, 0, 50])


def test_an_orientation_along_the_axis_is_no_number_and_refused():
    model = cantilever(i_outline(), 100.0, 2)
    (block,) = model.mesh.blocks
    along = replace(block, orientation=np.array([[1.0, 0.0, 0.0]] * 2))
    with np.errstate(invalid="ignore"), pytest.raises(DeckError, match="the number nan cannot be written"):
        ansys.write(replace(model, mesh=replace(model.mesh, blocks=(along,))))


def test_weights_follow_the_order_of_the_nodes():
    text = ansys.write(half_beam_half_solid("distributing"))
    (rbe3,) = commands(text, "RBE3")
    assert rbe3[2:] == ["ALL", "ALL", "WT1"]
    selected = [int(command[4]) for command in commands(text, "NSEL")]
    assert selected == sorted(selected)
    assert len([line for line in text.decode().splitlines() if line.startswith("WT1(")]) == len(selected)


def terms(text: bytes) -> list[list[str]]:
    """All CE commands, joined by equation."""
    equations: list[list[str]] = []
    for command in commands(text, "CE"):
        if command[1] == "NEXT":
            equations.append([])
        equations[-1] += command[3:]
    return equations


def test_equations_sum_to_nothing_in_a_translation():
    equations = terms(ansys.write(lap_of_plates()))
    assert equations
    for equation in equations:
        for label in ("UX", "UY", "UZ"):
            moved = [float(c) for name, c in zip(equation[1::3], equation[2::3]) if name == label]
            assert sum(moved) == pytest.approx(0, abs=1e-9)


def test_ansys_5_writes_every_coupling_as_equations():
    text = ansys5.write(post_on_plate())
    assert len(terms(text)) == 6
    assert not commands(text, "RBE3")
    assert not commands(text, "CERIG")


def test_ansys_5_takes_a_beams_principal_axes():
    outline = affinity.rotate(i_outline(), 30)
    model = cantilever(outline, 100.0, 1)
    (constants,) = commands(ansys5.write(model), "R")
    upright = section_properties(i_outline())
    assert [float(x) for x in constants[2:5]] == pytest.approx([upright.area, upright.izz, upright.iyy], rel=1e-6)
    nodes = commands(ansys5.write(model), "N")
    toward_z = np.array([float(x) for x in nodes[-1][2:]])
    assert toward_z == pytest.approx([0, -100 * math.sin(math.radians(30)), 100 * math.cos(math.radians(30))])


def test_ansys_5_pairs_shear_along_y_with_bending_about_z():
    model = cantilever(i_outline(), 100.0, 1)
    section = model.properties[0].section
    (more,) = commands(ansys5.write(model), "RMORE")
    along_y, along_z = section.area / section.shear_area_y, section.area / section.shear_area_z
    assert abs(along_y / along_z - 1) > 0.1
    assert [float(x) for x in more[3:5]] == pytest.approx([along_y, along_z], rel=1e-9)


def test_ansys_5_breaks_twenty_nodes_over_three_commands():
    text = ansys5.write(solid_cantilever("hex20", divisions=(1, 1, 1)))
    assert len(commands(text, "EN")) == 1
    assert [len(command) - 1 for command in commands(text, "EMORE")] == [8, 4]


def test_ansys_5_calls_no_component_by_a_word_of_its_own():
    model = shell_cantilever("quad4", divisions=(2, 1))
    text = ansys5.write(replace(model, sets=(whole_set(model, "all"), whole_set(model, "TOP"))))
    assert [command[1] for command in commands(text, "CM")] == ["ALL_2", "TOP"]


@pytest.mark.parametrize("angle", [0, 10, 30, 44, 60, 90, 130])
def test_principal_axes_lie_within_45_degrees_and_leave_no_product(angle):
    section = section_properties(affinity.rotate(channel_outline(), angle))
    turned, by = principal_section(section)
    assert abs(by) <= math.pi / 4 + 1e-9
    assert turned.iyz == 0
    assert turned.iyy + turned.izz == pytest.approx(section.iyy + section.izz)
    assert turned.iyy * turned.izz == pytest.approx(section.iyy * section.izz - section.iyz**2, rel=1e-6)
