"""Abaqus and CalculiX input, and SAP IV cards."""

import re
from collections import Counter
from dataclasses import replace

import meshio
import numpy as np
import pytest
from handmade import (
    beam_property,
    cantilever,
    channel_outline,
    grid,
    line_block,
    model_of,
    shell_cantilever,
    solid_cantilever,
    whole_set,
)
from joined import block_on_plate, lap_of_plates, post_on_plate
from shapely import box

from kernel.connect.model import Property, Rbe2
from kernel.deck import abaqus, sapiv
from kernel.deck.deck import format_for
from kernel.errors import DeckError
from kernel.mesh.mesh import ElementBlock


@pytest.mark.parametrize("name", ["abaqus", "calculix"])
@pytest.mark.parametrize("kind", ["hex8", "hex20", "tet4", "tet10", "wedge6", "quad4", "tri3", "tri6", "quad8"])
def test_meshio_reads_back_counts_and_connectivity(tmp_path, name, kind):
    is_shell = kind in ("quad4", "tri3", "tri6", "quad8")
    model = shell_cantilever(kind, divisions=(3, 2)) if is_shell else solid_cantilever(kind, divisions=(2, 1, 1))
    path = tmp_path / "model.inp"
    path.write_bytes(format_for("model.inp", name).write(replace(model, sets=(whole_set(model, "ALL"),))))
    text = path.read_text()
    text = text.replace("TYPE=S6,", "TYPE=STRI65,")  # CalculiX's name for it is not known to meshio
    path.write_text(text)
    read = meshio.read(path)
    assert np.allclose(read.points, model.mesh.nodes)
    assert np.array_equal(read.cells[0].data, model.mesh.blocks[0].connectivity)


def keyword(text: bytes, name: str) -> list[list[str]]:
    """Data lines of each card of that name."""
    cards: list[list[str]] = []
    inside = False
    for line in text.decode().splitlines():
        if line.startswith("*"):
            inside = line.split(",")[0] == name
            if inside:
                cards.append([])
        elif inside:
            cards[-1].append(line)
    return cards


def test_abaqus_beams_keep_any_section():
    model = cantilever(channel_outline(), 100.0, 2)
    section = model.properties[0].section
    text = abaqus.write(model)
    ((data, direction, moduli),) = keyword(text, "*BEAM GENERAL SECTION")
    found = [float(value) for value in data.split(",")]
    assert found == pytest.approx([section.area, section.iyy, section.iyz, section.izz, section.j])
    assert direction == "0., 1., 0."
    assert float(moduli.split(",")[0]) == 210000
    assert len(keyword(text, "*SHEAR CENTER")) == 1


def test_abaqus_couplings_name_their_nodes_and_weights():
    text = abaqus.write(post_on_plate())
    (surface,) = keyword(text, "*SURFACE")
    assert len(surface) == 9
    assert len(keyword(text, "*DISTRIBUTING")) == 1
    rigid = abaqus.write(block_on_plate())
    assert len(keyword(rigid, "*KINEMATIC")) == 9
    assert all(card == ["1, 3"] for card in keyword(rigid, "*KINEMATIC"))


def sets_of(text: bytes, kind: str) -> list[str]:
    """The names that ELSET or NSET keywords, and elements and nodes, give to sets, in order."""
    heads = [line for line in text.decode().splitlines() if line.startswith(("*ELSET", "*NSET", "*ELEMENT,", "*NODE,"))]
    return [name for head in heads for name in re.findall(rf"\b{kind}=(\w+)", head)]


@pytest.mark.parametrize("name", ["abaqus", "calculix"])
@pytest.mark.parametrize("rigid", [False, True])
def test_no_named_node_adds_to_a_set_that_the_deck_has_itself(name, rigid):
    """A set that is written twice is the union of both: elements would get the section of another group."""
    model = block_on_plate() if rigid else post_on_plate()
    groups = ["s1_line2", "s1_quad4", "s2_quad4", "s2_hex8"]
    names = ["eall", "Nall", "knots", "knot_nodes", "beam middles", "coupling_1", "surface_1", *groups]
    writer = format_for("", name)
    plain = writer.write(model)
    text = writer.write(replace(model, sets=tuple(whole_set(model, each) for each in names)))
    for kind in ("ELSET", "NSET"):
        own = Counter(sets_of(plain, kind))
        own.subtract(sets_of(text, kind))
        assert all(count <= 0 for count in own.values())
        added = {each for each, count in own.items() if count < 0}
        assert len(added) == len(names)
        assert added.isdisjoint(sets_of(plain, kind))


@pytest.mark.parametrize("name", ["abaqus", "calculix"])
def test_segments_whose_names_clean_to_the_same_keep_their_own_sections(name):
    one = shell_cantilever("quad4", divisions=(2, 1))
    (block,), (element,) = one.mesh.blocks, one.properties
    halves = [
        replace(block, segment=segment, connectivity=block.connectivity[rows])
        for segment, rows in (("top-1", slice(0, 1)), ("top_1", slice(1, 2)))
    ]
    properties = (replace(element, segment="top-1"), replace(element, segment="top_1", thickness=9.0))
    model = replace(one, mesh=replace(one.mesh, blocks=tuple(halves)), properties=properties)
    text = format_for("", name).write(model).decode()
    assert re.findall(r"\*SHELL SECTION, ELSET=(\w+), MATERIAL=STEEL\n(.*)", text) == [
        ("TOP_1_QUAD4", "2."), ("TOP_1_QUAD4_2", "9."),
    ]  # fmt: skip
    assert re.findall(r"\*ELEMENT, TYPE=S4, ELSET=(\w+)\n(\d+),", text) == [
        ("TOP_1_QUAD4", "1"), ("TOP_1_QUAD4_2", "2"),
    ]  # fmt: skip


def test_calculix_names_a_beam_that_is_tied_all_along():
    nodes, cells = grid((0, 0, 0), (300, 0, 0), (0, 100, 0), 12, 4)
    n = len(nodes)
    rail = np.column_stack([np.linspace(0, 300, 13), np.full(13, 50.0), np.full(13, 20.0)])
    blocks = [ElementBlock("s1", "quad4", cells), line_block("s2", range(n, n + 13), (0, 1, 0))]
    properties = [Property("s1", "shell", "steel", thickness=10.0), beam_property("s2", box(0, 0, 20, 30))]
    arms = [
        Rbe2(int(np.flatnonzero((nodes == [x, 50, 0]).all(axis=1))[0]), np.array([n + k]))
        for k, x in enumerate(rail[:, 0])
    ]
    tied = model_of(np.vstack([nodes, rail]), blocks, properties, arms)
    assert "13 of the 13 nodes of s2 are knots" in format_for("m.inp").write(tied).decode()
    at_one_end = replace(tied, couplings=tuple(arms[:1]))
    assert "are knots" not in format_for("m.inp").write(at_one_end).decode()


def test_lines_of_abaqus_end_before_its_limit():
    names = [f"{'segment' * 7}_{number}" for number in range(8)]
    one = shell_cantilever("quad4", divisions=(8, 1))
    (block,), (element,) = one.mesh.blocks, one.properties
    blocks = [replace(block, segment=name, connectivity=block.connectivity[[k]]) for k, name in enumerate(names)]
    model = replace(
        one,
        mesh=replace(one.mesh, blocks=tuple(blocks)),
        properties=tuple(replace(element, segment=name) for name in names),
    )
    lines = [line for line in abaqus.write(model).decode().splitlines() if not line.startswith("**")]
    assert max(map(len, lines)) <= 256


def fields(line: str, widths: list[int]) -> list[str]:
    result, start = [], 0
    for width in widths:
        result.append(line[start : start + width].strip())
        start += width
    return result


def test_sap_cards_stand_in_their_columns():
    model = post_on_plate("rigid")
    lines = sapiv.write(model).decode().splitlines()
    assert max(map(len, lines)) <= 80
    control = [int(value) for value in fields(lines[1], [5] * 8)]
    n_node, n_group = control[:2]
    assert n_group == 2
    nodes = [fields(line, [1, 4, *[5] * 6, 10, 10, 10, 5, 10]) for line in lines[2 : 2 + n_node]]
    assert [int(card[1]) for card in nodes] == list(range(1, n_node + 1))
    assert float(nodes[10][8]) == pytest.approx(model.mesh.nodes[10, 0])
    beams = [int(value) for value in fields(lines[2 + n_node], [5] * 5)]
    assert beams == [2, 5 + 9, 2, 0, 2]  # five bars, nine stiff spokes of a material of their own
    stiff = fields(lines[2 + n_node + 2], [5, *[10] * 4])
    assert [float(value) for value in stiff[3:]] == [0, 0]  # that has no weight


def test_sap_beams_of_one_segment_in_several_blocks_are_turned_each_by_its_own():
    model = cantilever(box(-2, -5, 2, 5), 100.0, 2)
    (block,) = model.mesh.blocks
    turned = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    halves = tuple(replace(block, connectivity=block.connectivity[[k]], orientation=turned[[k]]) for k in range(2))
    lines = sapiv.write(replace(model, mesh=replace(model.mesh, blocks=halves))).decode().splitlines()
    elements = [fields(line, [5] * 6) for line in lines[-6:-4]]
    places = [fields(lines[2 + int(card[3]) - 1], [1, 4, *[5] * 6, 10, 10, 10])[8:] for card in elements]
    assert np.array(places, float) == pytest.approx(np.array([[0, 50, 0], [50, 0, 50]]))


def test_sap_nodes_of_solids_have_their_rotations_fixed_but_where_a_spoke_ends():
    model = block_on_plate()
    lines = sapiv.write(model).decode().splitlines()
    codes = [fields(line, [1, 4, *[5] * 6])[2:] for line in lines[2 : 2 + model.mesh.n_node]]
    top = int(np.argmax(model.mesh.nodes[:, 2]))
    tied = int(model.couplings[0].dependent[0])
    assert codes[top] == ["0", "0", "0", "1", "1", "1"]
    assert codes[tied] == ["0"] * 6
    assert codes[0] == ["0"] * 6


def test_sap_refuses_what_it_cannot_carry():
    with pytest.raises(DeckError, match="segment s1: SAP IV has no tet10 elements"):
        sapiv.write(solid_cantilever("tet10", divisions=(1, 1, 1)))
    with pytest.raises(DeckError, match="constraint equations"):
        sapiv.write(lap_of_plates())


def test_sap_refuses_numbers_that_are_wider_than_their_columns():
    """The number of a node stands in columns 2 to 5: a fifth digit would shift the card."""
    most = shell_cantilever("quad4", divisions=(3332, 2))
    assert most.mesh.n_node == 9999
    last = sapiv.write(most).decode().splitlines()[2 + 9998]
    assert fields(last, [1, 4, *[5] * 6])[1] == "9999"
    with pytest.raises(DeckError, match="SAP IV counts 9999 nodes at most, the model needs 10002"):
        sapiv.write(shell_cantilever("quad4", divisions=(3333, 2)))


@pytest.mark.parametrize("name", ["abaqus", "ansys", "ansys5", "calculix", "sapiv"])
def test_equal_models_give_equal_bytes(name):
    writer = format_for("", name)
    assert writer.write(post_on_plate()) == writer.write(post_on_plate())
