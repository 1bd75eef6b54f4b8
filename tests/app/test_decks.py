"""Decks read back: what our writers wrote is what our readers find."""

from pathlib import Path

import numpy as np
import pytest

from app.cli import run
from app.decks import read_deck
from kernel.connect.model import Model, Property
from kernel.deck.deck import format_for
from kernel.errors import OptionError, ReadError
from kernel.materials import named_material
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.quality import mesh_quality
from kernel.units import unit_set

TABLE = str(Path(__file__).resolve().parents[2] / "examples" / "table.csg")
CORNERS = {
    "tri": [(0, 0, 0), (1, 0, 0), (0, 1, 0)],
    "quad": [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)],
    "tet": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
    "wedge": [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 2), (1, 0, 2), (0, 1, 2)],
    "hex": [(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0), (0, 0, 1), (2, 0, 1), (2, 1, 1), (0, 1, 1)],
}


def one_of_each(order):
    """A model with one element of every surface and volume kind of an order, side by side, corners a little off."""
    generator = np.random.default_rng(3)
    nodes, blocks, properties = [], [], []
    for place, (family, corners) in enumerate(CORNERS.items()):
        kind = next(k for k in ELEMENT_KINDS.values() if k.name.startswith(family) and k.order == order)
        points = np.array(corners, float) + generator.uniform(-0.05, 0.05, (len(corners), 3)) + (10 * place, 0, 0)
        if order == 2:
            points = np.concatenate([points, [(points[a] + points[b]) / 2 for a, b in kind.edges]])
        blocks.append(ElementBlock(f"s{place}", kind.name, sum(map(len, nodes)) + np.arange(len(points))[None]))
        nodes.append(points)
        is_shell = kind.dimension == 2
        properties.append(Property(f"s{place}", "shell" if is_shell else "solid", "steel", 1.0 if is_shell else None))
    steel = named_material("steel", unit_set("mm"))
    mesh = Mesh(np.concatenate(nodes), tuple(blocks))
    return Model("one of each", "mm", "base", mesh, tuple(properties), {"steel": steel}, ())


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("ending", ["bdf", "msh", "vtu", "inp", "cdb", "json"])
def test_every_kind_comes_back_with_its_quality(tmp_path, ending, order):
    model = one_of_each(order)
    path = tmp_path / f"deck.{ending}"
    path.write_bytes(format_for(str(path)).write(model))
    read = read_deck(str(path))
    assert read.count() == model.mesh.count()
    written, found = mesh_quality(model.mesh), mesh_quality(read)
    for kind in written:
        assert found[kind]["scaled_jacobian"]["min"] == pytest.approx(written[kind]["scaled_jacobian"]["min"], rel=1e-9)


def test_small_and_free_fields_and_numbers_without_an_e_are_read(tmp_path):
    path = tmp_path / "deck.nas"
    path.write_text(
        "SOL 101\nBEGIN BULK\nGRID           1             0.0     0.0     0.0\nGRID,2,,1.0,0.0,0.0 $ a corner\n"
        "GRID,3,,0.0,10.-1,0.0\nCTRIA3         1       1       1       2       3\nENDDATA\n"
    )
    mesh = read_deck(str(path))
    assert mesh.nodes.tolist() == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]


@pytest.mark.parametrize(
    "name, text, complaint",
    [
        ("a.bdf", "GRID,1,,x,0.,0.\n", r"a\.bdf:1:1: GRID cannot be read"),
        ("a.bdf", "GRID,1,7,0.,0.,0.\n", "coordinate system 7"),
        ("a.bdf", "CTRIA3,1,1,1,2,3\n", "node 1, which is not there"),
        ("a.bdf", "hello\n", "no elements"),
        ("a.msh", "$MeshFormat\n2.2 0 8\n", r"not MSH 4\.1"),
        ("a.msh", "$MeshFormat\n4.1 0 8\n", "cannot be read"),
        ("a.vtu", "<VTKFile>", "cannot be read"),
        ("a.json", "[1]", r"a\.json"),
    ],
)
def test_what_is_no_deck_is_refused_by_place(tmp_path, name, text, complaint):
    (tmp_path / name).write_text(text)
    with pytest.raises(ReadError, match=complaint):
        read_deck(str(tmp_path / name))


def test_an_unknown_ending_and_a_missing_file_are_refused(tmp_path):
    with pytest.raises(OptionError, match="no deck is read"):
        read_deck("a.txt")
    with pytest.raises(OptionError, match="No such file"):
        read_deck(str(tmp_path / "a.bdf"))


@pytest.mark.parametrize("name, kinds", [("calculix", {"quad4", "line3"}), ("abaqus", {"quad4", "line2"})])
def test_the_elements_of_a_table_come_back_from_a_keyword_deck(tmp_path, name, kinds):
    path = tmp_path / "table.inp"
    assert run(["mesh", TABLE, "-o", str(path), "--format", name, "--size", "100"]) == 0
    assert set(read_deck(str(path)).count()) == kinds


def test_the_elements_of_a_table_come_back_from_an_ansys_archive(tmp_path):
    run(["mesh", TABLE, "-o", str(tmp_path / "table.cdb"), "--size", "100"])
    run(["mesh", TABLE, "-o", str(tmp_path / "table.bdf"), "--size", "100"])
    archive, bulk = (read_deck(str(tmp_path / f"table.{ending}")) for ending in ("cdb", "bdf"))
    assert archive.count() == bulk.count() and archive.n_node == bulk.n_node


@pytest.mark.parametrize(
    "name, text, told",
    [
        ("a.inp", "*NODE\n1, 0, 0, 0\n*ELEMENT, TYPE=S9\n1, 1\n", "a.inp:3:1: .*'S9' is not known"),
        ("a.inp", "*ELEMENT, TYPE=S3\n1, 1, 2\n", "2 nodes, expected 3"),
        ("a.cdb", "ET,1,999\nEBLOCK,19,SOLID,1,1\n(19i9)\n", "cannot be read"),
        ("a.cdb", "nothing\n", "no elements"),
    ],
)
def test_a_grouped_deck_that_is_wrong_says_where(tmp_path, name, text, told):
    (tmp_path / name).write_text(text)
    with pytest.raises(ReadError, match=told):
        read_deck(str(tmp_path / name))
