"""Gmsh and VTU decks, read back by gmsh and meshio themselves."""

import base64
import re
from dataclasses import replace
from xml.etree import ElementTree

import gmsh
import meshio
import numpy as np
import pytest
from handmade import STEEL, cantilever, i_outline, shell_cantilever, solid_cantilever, whole_set
from shapely import box

from kernel.connect.mass import block_moments
from kernel.connect.model import NamedSet, Rbe3
from kernel.deck.deck import format_for, formats

SOLIDS = ["hex8", "hex20", "wedge6", "wedge15", "tet4", "tet10"]
SHELLS = ["tri3", "tri6", "quad4", "quad8"]
MESHIO_NAMES = {
    "line2": "line", "line3": "line3", "tri3": "triangle", "tri6": "triangle6", "quad4": "quad", "quad8": "quad8",
    "tet4": "tetra", "tet10": "tetra10", "wedge6": "wedge", "wedge15": "wedge15", "hex8": "hexahedron",
    "hex20": "hexahedron20",
}  # fmt: skip


def model_with(kind):
    if kind in SOLIDS:
        model = solid_cantilever(kind, (8.0, 2.0, 2.0), (2, 1, 1))
    elif kind in SHELLS:
        model = shell_cantilever(kind, 8.0, 2.0, 1.0, (2, 1))
    else:
        model = cantilever(i_outline(), 100.0, 4, kind)
    return replace(model, sets=(whole_set(model, "BRACKET"), whole_set(model, "s1")))


@pytest.fixture
def session():
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh
    gmsh.finalize()


@pytest.mark.parametrize("kind", [*SOLIDS, *SHELLS, "line2", "line3"])
def test_gmsh_reads_back_every_kind_with_its_groups_and_volume(session, tmp_path, kind):
    model = model_with(kind)
    path = tmp_path / "model.msh"
    path.write_bytes(format_for(path.name).write(model))
    session.open(str(path))
    names = {session.model.getPhysicalName(*group) for group in session.model.getPhysicalGroups()}
    assert names == {"BRACKET", "s1"}
    types, tags, _ = session.model.mesh.getElements()
    assert sum(map(len, tags)) == sum(model.mesh.count().values())
    points, weights = session.model.mesh.getIntegrationPoints(types[0], "Gauss4")
    _, determinants, _ = session.model.mesh.getJacobians(types[0], points)
    assert min(determinants) > 0
    measured = float((np.array(determinants).reshape(-1, len(weights)) * np.array(weights)).sum())
    block, element = model.mesh.blocks[0], model.properties[0]
    cross = {"beam": element.section and element.section.area, "shell": element.thickness, "solid": 1.0}[element.kind]
    assert measured * cross == pytest.approx(block_moments(block, model.mesh.nodes, element, 1.0).mass)


# meshio has no dimension for wedge15 and cannot hold one
@pytest.mark.parametrize("ending", [".msh", ".vtu"])
@pytest.mark.parametrize("kind", sorted({*SOLIDS, *SHELLS, "line2", "line3"} - {"wedge15"}))
def test_meshio_reads_back_nodes_and_connectivity(tmp_path, kind, ending):
    model = model_with(kind)
    path = tmp_path / f"model{ending}"
    path.write_bytes(format_for(path.name).write(model))
    read = meshio.read(path)
    (cells,) = [block for block in read.cells if block.type == MESHIO_NAMES[kind]]
    assert len(cells.data) == model.mesh.count()[kind]
    written = model.mesh.nodes[model.mesh.blocks[0].connectivity]
    found = read.points[cells.data]
    assert np.allclose(np.sort(found.mean(axis=1), axis=0), np.sort(written.mean(axis=1), axis=0))
    if ending == ".vtu" and not kind.startswith("wedge"):
        assert np.array_equal(found, written)  # our node orders are VTK's
        assert read.cell_data["segment"][0].tolist() == [0] * len(written)


def test_vtu_turns_wedges_so_that_their_first_triangle_looks_outward():
    model = model_with("wedge15")
    text = format_for("", "vtu").write(model).decode()
    payload = re.search(r'Name="connectivity"[^>]*>([^<]*)<', text)[1]
    row = model.mesh.nodes[np.frombuffer(base64.b64decode(payload)[8:], "<i8").reshape(-1, 15)]
    normal = np.cross(row[:, 1] - row[:, 0], row[:, 2] - row[:, 0])
    assert ((normal * (row[:, 3] - row[:, 0])).sum(axis=1) < 0).all()
    edges = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]  # vtkQuadraticWedge
    for middle, (a, b) in enumerate(edges, start=6):
        assert np.allclose(row[:, middle], (row[:, a] + row[:, b]) / 2)


def test_vtu_marks_coupled_nodes(tmp_path):
    model = model_with("quad4")
    coupled = replace(model, couplings=(Rbe3(0, np.array([1, 2, 3]), np.ones(3)),))
    path = tmp_path / "model.vtu"
    path.write_bytes(format_for(path.name).write(coupled))
    assert meshio.read(path).point_data["coupled"].tolist()[:5] == [2, 1, 1, 1, 0]


@pytest.mark.parametrize("name", ["nastran", "gmsh", "vtu"])
def test_equal_models_give_equal_bytes(name):
    writer = format_for("", name)
    assert writer.write(model_with("hex8")) == writer.write(model_with("hex8"))


def test_a_title_beyond_ascii_does_not_break_a_header():
    model = replace(model_with("quad4"), title="Träger -- über\nzwei Zeilen")
    for name in ("nastran", "gmsh", "vtu"):
        assert format_for("", name).write(model).decode("ascii")


HOSTILE = 'Tr\u00e4ger "A"\nB -- <c> & \u5b57'


@pytest.mark.parametrize("name", [f.name for f in formats()])
def test_a_name_of_any_letters_is_written_by_every_format(name, tmp_path):
    model = cantilever(box(0, 0, 10, 20), 100.0, 4)
    steel = replace(STEEL, name=HOSTILE, source=HOSTILE)
    named = NamedSet(HOSTILE, np.arange(2), np.arange(1))
    model = replace(
        model,
        title=HOSTILE,
        properties=(replace(model.properties[0], material=HOSTILE),),
        materials={HOSTILE: steel},
        sets=(named,),
    )
    text = format_for("", name).write(model)
    assert text
    if name in ("gmsh", "vtu"):
        path = tmp_path / f"model.{'msh' if name == 'gmsh' else 'vtu'}"
        path.write_bytes(text)
        assert len(meshio.read(path).points) == 5


def test_a_vtu_is_xml_whatever_the_model_is_called(tmp_path):
    model = replace(shell_cantilever("quad4", divisions=(2, 1)), title="part---v2--.csg", notes=("--->",))
    path = tmp_path / "model.vtu"
    path.write_bytes(format_for(path.name).write(model))
    assert ElementTree.parse(path).getroot().tag == "VTKFile"
    assert len(meshio.read(path).points) == model.mesh.n_node
