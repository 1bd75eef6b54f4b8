"""ANSYS archives, Abaqus and CalculiX input, Gmsh and VTU read back by independent readers, on mixed models.

What mapdl-archive and meshio leave alone (sections, materials, couplings) is compared card by card.
"""

import os
import re
import subprocess
import sys
from collections import Counter

import gmsh
import meshio
import numpy as np
import pytest
from cases_to_read import HANDMADE, NAMES, ROOT, model_named
from mapdl_archive import Archive

from kernel.connect.mass import section_axes
from kernel.connect.model import Mpc, Rbe2, Rbe3
from kernel.deck.deck import format_for, formats
from kernel.deck.numbers import fixed_field, free_field
from kernel.errors import DeckError
from kernel.mesh.elements import ELEMENT_KINDS

ANSYS = {
    "tri3": 181, "quad4": 181, "tri6": 281, "quad8": 281, "tet4": 185, "wedge6": 185, "hex8": 185, "tet10": 187,
    "wedge15": 186, "hex20": 186, "line2": 188, "line3": 189,
}  # fmt: skip

# between which of its corners each further node lies: ANSYS Element Reference (I J K L M N O P = 0 to 7)
ANSYS_MIDSIDES = {
    281: [(0, 1), (1, 2), (2, 3), (3, 0)],
    187: [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)],
    186: [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)],
    189: [(0, 1)],
}
ANSYS_CORNERS = {181: 4, 281: 4, 185: 8, 186: 8, 187: 4, 188: 2, 189: 2}

MESHIO = {
    "line2": "line", "line3": "line3", "tri3": "triangle", "tri6": "triangle6", "quad4": "quad", "quad8": "quad8",
    "tet4": "tetra", "tet10": "tetra10", "wedge6": "wedge", "wedge15": "wedge15", "hex8": "hexahedron",
    "hex20": "hexahedron20",
}  # fmt: skip


@pytest.fixture(params=NAMES)
def model(request):
    return model_named(request.param)


def rows_of(model):
    """(block, nodes from 0) of every element, in order."""
    return [(block, row) for block in model.mesh.blocks for row in block.connectivity.tolist()]


def set_text(name):
    clean = re.sub(r"\W", "_", name).upper()
    return clean if clean[0].isalpha() else f"N{clean}"


def commands(text, name):
    return [line.split(",") for line in text.splitlines() if line.split(",")[0] == name]


# ---------------------------------------------------------------- ANSYS


@pytest.fixture
def archive(model, tmp_path):
    path = tmp_path / "model.cdb"
    path.write_bytes(format_for("", "ansys").write(model))
    return Archive(str(path), parse_vtk=False)


def test_an_archive_has_every_element_with_its_nodes_in_ansys_order(model, archive):
    types = dict(archive.ekey.tolist())
    assert np.allclose(archive.nodes[: model.mesh.n_node, :3], model.mesh.nodes, rtol=1e-12, atol=1e-9)
    expected = rows_of(model)
    assert len(archive.elem) == len(expected)
    orientation = model.mesh.n_node
    for read, (block, row) in zip(archive.elem, expected):
        kind = types[int(read[1])]
        assert kind == ANSYS[block.kind]
        nodes = [int(n) - 1 for n in read[10:]]
        if block.orientation is not None:
            assert nodes.pop() == orientation
            start, end = (model.mesh.nodes[[nodes[k]]] for k in (0, 1))
            _, z = section_axes(start, end, block.orientation[[row and block.connectivity.tolist().index(row)]])
            toward = archive.nodes[orientation, :3] - start[0]
            assert toward / np.linalg.norm(toward) == pytest.approx(z[0], abs=1e-9)
            orientation += 1
        assert set(nodes) == set(row)
        n_corner = ANSYS_CORNERS[kind]
        places = model.mesh.nodes[nodes]
        assert set(nodes[:n_corner]) == set(row[: ELEMENT_KINDS[block.kind].n_corner])
        for middle, (a, b) in zip(places[n_corner:], ANSYS_MIDSIDES.get(kind, ())):
            length = np.linalg.norm(places[a] - places[b])
            assert np.linalg.norm(middle - (places[a] + places[b]) / 2) <= 0.2 * length
    assert orientation == len(archive.nodes)


def test_an_archives_elements_lead_to_their_segments_section_and_material(model, archive, tmp_path):
    text = (tmp_path / "model.cdb").read_text()
    lines = text.splitlines()
    sections = {}
    for at, line in enumerate(lines):
        if line.startswith("SECTYPE,"):
            data = [float(word) for word in lines[at + 1].split(",")[1:]]
            sections[int(line.split(",")[1])] = (line.split(",")[2:4], data)
    materials = {(words[1], int(words[2])): float(words[3]) for words in commands(text, "MP")}
    by_segment = {element.segment: element for element in model.properties}
    for read, (block, _) in zip(archive.elem, rows_of(model)):
        element = by_segment[block.segment]
        material = model.materials[element.material]
        number = int(read[0])
        assert materials["EX", number] == pytest.approx(material.elastic_modulus)
        assert materials["NUXY", number] == pytest.approx(material.poisson_ratio)
        assert materials["DENS", number] == pytest.approx(material.density * element.density_factor)
        if element.kind == "shell":
            assert sections[int(read[3])][0][0] == "SHELL"
            assert sections[int(read[3])][1][0] == pytest.approx(element.thickness)
        elif element.kind == "beam":
            kind, data = sections[int(read[3])]
            s = element.section
            assert kind == ["BEAM", "ASEC"]
            wanted = [s.area, s.iyy, s.iyz, s.izz, 0, s.j, 0, 0, *s.shear_centre]
            assert data == pytest.approx(wanted, rel=1e-9, abs=1e-9 * s.iyy)


def test_an_archives_components_are_the_named_sets(model, archive):
    names = {set_text(named.name): named for named in model.sets}
    assert set(archive.node_components) == {f"{name}_N" for name in names}
    assert set(archive.element_components) == {f"{name}_E" for name in names}
    for name, named in names.items():
        assert archive.node_components[f"{name}_N"].tolist() == (named.nodes + 1).tolist()
        assert archive.element_components[f"{name}_E"].tolist() == (named.elements + 1).tolist()


def test_an_archives_couplings_are_the_models(model, tmp_path):
    text = format_for("", "ansys").write(model).decode()
    wanted = Counter()
    for coupling in model.couplings:
        if isinstance(coupling, Rbe2):
            label = "ALL" if coupling.components == "123456" else "UXYZ"
            wanted.update((coupling.independent + 1, node + 1, label) for node in coupling.dependent.tolist())
    assert Counter((int(w[1]), int(w[2]), w[3]) for w in commands(text, "CERIG")) == wanted
    averages = [coupling for coupling in model.couplings if isinstance(coupling, Rbe3)]
    given = commands(text, "RBE3")
    assert [int(words[1]) for words in given] == [coupling.dependent + 1 for coupling in averages]
    selected = re.split(r"^ALLSEL$", text, flags=re.M)
    for coupling, part in zip(averages, selected):
        nodes = [int(words[4]) - 1 for words in commands(part, "NSEL")]
        weights = [float(value) for value in re.findall(r"^WT\d+\(\d+\)=(\S+)$", part, re.M)]
        ours = dict(zip(coupling.independent.tolist(), coupling.weights / coupling.weights.mean()))
        assert dict(zip(nodes, weights)) == pytest.approx(ours, rel=1e-9)
    labels = ("UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ")
    equations: list[list[str]] = []
    for words in commands(text, "CE"):
        if words[1] == "NEXT":
            equations.append([])
        equations[-1] += words[3:]
    mpcs = [coupling for coupling in model.couplings if isinstance(coupling, Mpc)]
    assert len(equations) == len(mpcs)
    for terms, coupling in zip(equations, mpcs):
        assert [int(n) - 1 for n in terms[::3]] == coupling.nodes.tolist()
        assert [labels.index(label) + 1 for label in terms[1::3]] == coupling.components.tolist()
        assert [float(value) for value in terms[2::3]] == pytest.approx(coupling.coefficients.tolist(), rel=1e-9)


# ---------------------------------------------------------------- Abaqus and CalculiX


def written(model, name):
    """The deck; None where CalculiX has no such beams, and says so."""
    if name == "calculix" and any(
        element.section is not None and element.section.shape not in ("rectangle", "circle", "tube", "box")
        for element in model.properties
    ):
        with pytest.raises(DeckError, match="CalculiX's beams are rectangles, circles, tubes and boxes, not"):
            format_for("", name).write(model)
        return None
    return format_for("", name).write(model).decode()


@pytest.mark.parametrize("name", ["abaqus", "calculix"])
def test_meshio_reads_counts_connectivity_and_sets_of_a_keyword_deck(model, tmp_path, name):
    path = tmp_path / "model.inp"
    text = written(model, name)
    if text is None or "TYPE=C3D15," in text:
        return  # refused; or a wedge of 15 nodes, which meshio has not: ccx runs it (tests/solvers)
    has_knots = "NSET=KNOT_NODES" in text
    for known, theirs in (("STRI65", "S6"), ("B32", "B32R")):  # names of CalculiX that meshio does not know
        text = text.replace(f"TYPE={theirs},", f"TYPE={known},")
    blocks = re.findall(r"^\*NODE, NSET=\w+\n((?:\d.*\n)*)", text, re.M)
    text = re.sub(r"^\*NODE, NSET=\w+\n(?:\d.*\n)*", "", text, flags=re.M)
    text = f"*NODE\n{''.join(blocks)}{text}"  # it takes one block of nodes only
    path.write_text(text)
    read = meshio.read(path)
    assert np.allclose(read.points[: model.mesh.n_node], model.mesh.nodes, rtol=1e-12, atol=1e-9)
    found = Counter()
    for cells in read.cells:
        found.update(tuple(sorted(n for n in row if n < model.mesh.n_node)) for row in cells.data.tolist())
    wanted = Counter(tuple(sorted(row)) for _, row in rows_of(model))
    extra = found - wanted
    assert wanted - found == Counter()
    assert not extra or (has_knots and all(len(nodes) == 1 for nodes in extra))  # the knots' own short beams
    for named in model.sets:
        assert sorted(read.point_sets[set_text(named.name)].tolist()) == named.nodes.tolist()


@pytest.mark.parametrize("name", ["abaqus", "calculix"])
def test_a_keyword_decks_sections_are_the_segments(model, name):
    text = written(model, name)
    if text is None:
        return
    densities = dict(re.findall(r"^\*MATERIAL, NAME=(\S+)\n(?:.*\n)*?\*DENSITY\n(\S+)$", text, re.M))
    for element in model.properties:
        kinds = {block.kind for block in model.mesh.blocks if block.segment == element.segment}
        for kind in kinds:
            elset = f"{element.segment}_{kind}".upper()
            card = {"shell": "SHELL", "solid": "SOLID", "beam": "BEAM"}[element.kind]
            found = re.findall(rf"^\*{card}(?: GENERAL)? SECTION, ELSET={elset}(?:_\d+)?, (.*)\n(.*)$", text, re.M)
            assert found
            for options, data in found:
                if element.kind == "shell":
                    assert float(data) == pytest.approx(element.thickness)
                if "MATERIAL=" in options:
                    density = float(densities[re.search(r"MATERIAL=(\w+)", options)[1]])
                    material = model.materials[element.material]
                    assert density == pytest.approx(material.density * element.density_factor)


# ---------------------------------------------------------------- Gmsh and VTU


@pytest.fixture
def session():
    gmsh.initialize()
    gmsh.option.setNumber("General.Terminal", 0)
    yield gmsh.model
    gmsh.finalize()


def test_gmsh_reads_every_element_and_the_groups_of_named_sets(session, model, tmp_path):
    path = tmp_path / "model.msh"
    path.write_bytes(format_for(path.name).write(model))
    gmsh.open(str(path))
    tags, places, _ = session.mesh.getNodes()
    order = np.argsort(tags)
    assert np.allclose(np.array(places).reshape(-1, 3)[order], model.mesh.nodes, rtol=1e-12, atol=1e-9)
    kinds, elements, nodes = session.mesh.getElements()
    found = Counter()
    for kind, numbers, flat in zip(kinds, elements, nodes):
        width = session.mesh.getElementProperties(kind)[3]
        assert len(flat) == width * len(numbers)
        found.update(tuple(sorted(row)) for row in (np.array(flat).reshape(-1, width) - 1).tolist())
        points, weights = session.mesh.getIntegrationPoints(kind, "Gauss4")
        assert min(session.mesh.getJacobians(kind, points)[1]) > 0
        assert len(weights) > 0
    assert found == Counter(tuple(sorted(row)) for _, row in rows_of(model))
    held = Counter()
    for dimension, tag in session.getPhysicalGroups():
        name = session.getPhysicalName(dimension, tag)
        for entity in session.getEntitiesForPhysicalGroup(dimension, tag):
            held[name] += sum(map(len, session.mesh.getElements(dimension, entity)[1]))
    assert held == {named.name: len(named.elements) for named in model.sets}


def test_meshio_reads_a_grid_with_its_properties_and_sets(model, tmp_path):
    if "wedge15" in model.mesh.count():
        return  # meshio cannot hold one; gmsh reads it above
    path = tmp_path / "model.vtu"
    path.write_bytes(format_for(path.name).write(model))
    read = meshio.read(path)
    assert np.array_equal(read.points, model.mesh.nodes)
    found = Counter()
    for cells, thickness in zip(read.cells, read.cell_data["thickness"]):
        found.update((cells.type, tuple(sorted(row)), t) for row, t in zip(cells.data.tolist(), thickness.tolist()))
    by_segment = {element.segment: element for element in model.properties}
    assert found == Counter(
        (MESHIO[block.kind], tuple(sorted(row)), by_segment[block.segment].thickness or 0.0)
        for block, row in rows_of(model)
    )
    assert not model.couplings or read.point_data["coupled"].max() == 2
    segments = np.concatenate(read.cell_data["segment"])
    for named in model.sets:
        inside = np.isin(segments, read.field_data[f"set {named.name}"])
        assert np.count_nonzero(inside) == len(named.elements)


def test_every_kind_and_every_coupling_is_among_the_models():
    kinds = {kind for name in NAMES for kind in model_named(name).mesh.count()}
    assert kinds == set(ELEMENT_KINDS)
    assert {type(c) for name in HANDMADE for c in model_named(name).couplings} == {Rbe2, Rbe3, Mpc}


# ---------------------------------------------------------------- what holds for every format


FORMATS = [known.name for known in formats()]


@pytest.mark.parametrize("name", FORMATS)
def test_each_segments_own_material_reaches_the_deck(name):
    model = model_named("table on titanium legs")
    text = format_for("", name).write(model).decode().lower()
    moduli = {material.elastic_modulus for material in model.materials.values()}
    assert len(moduli) == 2
    if name in ("gmsh", "vtu"):  # they hold no materials, but say where each comes from
        assert all(material.name in text for material in model.materials.values())
        return
    for modulus in moduli:
        assert any(form(modulus).lower() in text for form in (fixed_field, free_field, lambda e: fixed_field(e, 10)))


@pytest.mark.parametrize("name", FORMATS)
def test_the_head_names_model_units_and_rule_base(name):
    model = model_named("table")
    head = format_for("", name).write(model).decode()[:3000]
    if name == "sapiv":  # one heading of 72 characters is all that it has
        assert head.startswith("CSGMESH TABLE.CSG mm-t-s-N")
        return
    assert "model: table.csg" in head and "mm-t-s-N" in head and f"rule base: {model.rule_base}" in head


PROGRAM = """
import hashlib, sys
from app.pipeline import classify, mesh, read
from kernel.deck.deck import formats
from kernel.mesh.options import MeshOptions
model = mesh(classify(read(sys.argv[1])), MeshOptions(size=100)).model
print([(known.name, hashlib.sha256(known.write(model)).hexdigest()) for known in formats()])
"""


def test_decks_of_all_formats_are_the_same_whatever_the_hash_seed():
    """Two processes, so that nothing that hashing orders is shared between them."""
    table = str(ROOT / "examples" / "table.csg")
    told = set()
    for seed in ("1", "77"):
        environment = {**os.environ, "PYTHONHASHSEED": seed, "PYTHONPATH": str(ROOT)}
        command = [sys.executable, "-c", PROGRAM, table]
        done = subprocess.run(command, capture_output=True, text=True, env=environment, check=False)
        assert done.returncode == 0, done.stderr
        told.add(done.stdout)
    assert len(told) == 1
