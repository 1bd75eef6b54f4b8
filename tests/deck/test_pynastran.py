"""NASTRAN decks read back by pyNastran: nodes, elements, properties, materials, couplings, sets and mass."""

import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from cases_to_read import NAMES, model_named

from kernel.connect.mass import block_moments
from kernel.connect.model import Mpc, Rbe2, Rbe3
from kernel.deck.deck import format_for
from kernel.mesh.elements import ELEMENT_KINDS

READERS = Path(sys.prefix) / "readers" / ("Scripts" if sys.platform == "win32" else "bin") / "python"
SCRIPT = Path(__file__).parents[1] / "support" / "read_nastran.py"

pytestmark = pytest.mark.skipif(
    sys.version_info >= (3, 13), reason="pyNastran 1.4.1 needs numpy < 2, of which there is no wheel for Python 3.13"
)

CARDS = {
    "tri3": "CTRIA3", "tri6": "CTRIA6", "quad4": "CQUAD4", "quad8": "CQUAD8", "tet4": "CTETRA", "tet10": "CTETRA",
    "wedge6": "CPENTA", "wedge15": "CPENTA", "hex8": "CHEXA", "hex20": "CHEXA", "line2": "CBAR", "line3": "CBAR",
}  # fmt: skip

# between which corners each further node of a card lies: MSC Nastran Quick Reference Guide, bulk data entries
MIDSIDES = {
    "CTRIA6": [(1, 2), (2, 3), (3, 1)],
    "CQUAD8": [(1, 2), (2, 3), (3, 4), (4, 1)],
    "CTETRA": [(1, 2), (2, 3), (3, 1), (1, 4), (2, 4), (3, 4)],
    "CPENTA": [(1, 2), (2, 3), (3, 1), (1, 4), (2, 5), (3, 6), (4, 5), (5, 6), (6, 4)],
    "CHEXA": [
        (1, 2), (2, 3), (3, 4), (4, 1), (1, 5), (2, 6), (3, 7), (4, 8), (5, 6), (6, 7), (7, 8), (8, 5),
    ],
}  # fmt: skip


def run_reader(paths):
    done = subprocess.run(
        [str(READERS), str(SCRIPT), *map(str, paths)], capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stderr[-2000:]
    return json.loads(done.stdout)


@pytest.fixture(scope="module")
def found(tmp_path_factory):
    """What pyNastran makes of each deck, by the model's name; all in one run."""
    assert READERS.exists(), f"no {READERS}: `make test` makes it (or `make readers`)"
    folder = tmp_path_factory.mktemp("decks")
    paths = [folder / f"{number}.bdf" for number in range(len(NAMES))]
    for path, name in zip(paths, NAMES):
        path.write_bytes(format_for("", "nastran").write(model_named(name)))
    return dict(zip(NAMES, run_reader(paths)))


@pytest.fixture(params=NAMES)
def case(request, found):
    return model_named(request.param), found[request.param]


def parts(block):
    """Rows of node ids, as many as the block makes cards: a line of three nodes is two bars."""
    if block.kind == "line3":
        return [row for a, b, m in (block.connectivity + 1).tolist() for row in ([a, m], [m, b])]
    return (block.connectivity + 1).tolist()


def cards_of(model):
    """(block, our nodes) of each element card, in the order of their ids."""
    return [(block, row) for block in model.mesh.blocks for row in parts(block)]


def test_nodes_are_where_they_were(case):
    model, read = case
    assert sorted(map(int, read["nodes"])) == list(range(1, model.mesh.n_node + 1))
    places = np.array([read["nodes"][str(n + 1)] for n in range(model.mesh.n_node)])
    size = np.ptp(model.mesh.nodes, axis=0).max()
    assert np.abs(places - model.mesh.nodes).max() <= 1e-9 * size


def test_every_element_has_its_nodes_in_nastrans_order(case):
    model, read = case
    expected = cards_of(model)
    assert sorted(map(int, read["elements"])) == list(range(1, len(expected) + 1))
    for number, (block, row) in enumerate(expected, start=1):
        card = read["elements"][str(number)]
        assert card["type"] == CARDS[block.kind]
        assert set(card["nodes"]) == set(row) and len(card["nodes"]) == len(row)
        kind = ELEMENT_KINDS[block.kind]
        if kind.dimension == 1:
            assert card["nodes"] == row
            continue
        places = model.mesh.nodes[np.array(card["nodes"]) - 1]
        corners = places[: kind.n_corner]
        for middle, (a, b) in zip(places[kind.n_corner :], MIDSIDES[card["type"]] if kind.order == 2 else ()):
            gaps = np.linalg.norm(middle - (corners[[a - 1]] + corners[[b - 1]]) / 2, axis=1)
            assert gaps < 0.2 * np.linalg.norm(corners[a - 1] - corners[b - 1])
        if kind.dimension == 3:
            up = {4: (1, 2, 3), 6: (1, 2, 3), 8: (1, 3, 4)}[kind.n_corner]
            assert np.linalg.det(corners[list(up)] - corners[0]) > 0
        else:
            ours = model.mesh.nodes[np.array(row) - 1]
            normals = [np.cross(p[1] - p[0], p[2] - p[0]) for p in (corners, ours)]
            assert normals[0] @ normals[1] > 0


def test_bars_have_their_orientation(case):
    model, read = case
    number = 1
    for block in model.mesh.blocks:
        per_row = 2 if block.kind == "line3" else 1
        for vector in block.orientation if block.orientation is not None else block.connectivity:
            for _ in range(per_row):
                if block.orientation is not None:
                    assert read["elements"][str(number)]["vector"] == pytest.approx(vector.tolist(), abs=1e-12)
                number += 1


def test_properties_and_materials_are_those_of_the_segment(case):
    model, read = case
    by_segment = {element.segment: element for element in model.properties}
    seen = {}
    for number, (block, _) in enumerate(cards_of(model), start=1):
        pid = read["elements"][str(number)]["pid"]
        solid = block.kind if by_segment[block.segment].kind == "solid" else ""
        assert seen.setdefault(pid, (block.segment, solid)) == (block.segment, solid)
    assert len(seen) == len(set(seen.values())) == len(read["properties"])
    for pid, (segment, kind) in seen.items():
        element, card = by_segment[segment], read["properties"][str(pid)]
        ours, material = model.materials[element.material], read["materials"][str(card["material"])]
        assert (material["e"], material["nu"]) == pytest.approx((ours.elastic_modulus, ours.poisson_ratio), rel=1e-9)
        assert material["rho"] == pytest.approx(ours.density * element.density_factor, rel=1e-9)
        if element.kind == "shell":
            assert card["type"] == "PSHELL" and card["t"] == pytest.approx(element.thickness, rel=1e-9)
            assert card["bending"] == card["shear"] == card["material"]
        elif element.kind == "solid":
            reduced = kind in ("hex8", "wedge6")
            assert (card["type"], card["isop"]) == ("PSOLID", "REDUCED" if reduced else None)
        else:
            section = element.section
            given = [card[name] for name in ("A", "i1", "i2", "i12", "j", "k1", "k2")]
            wanted = [section.area, section.izz, section.iyy, section.iyz, section.j]
            wanted += [section.shear_area_y / section.area, section.shear_area_z / section.area]
            assert card["type"] == "PBAR" and given == pytest.approx(wanted, rel=1e-9, abs=1e-9 * section.iyy)


def test_couplings_have_their_nodes_components_and_weights(case):
    model, read = case
    rigid = [coupling for coupling in model.couplings if isinstance(coupling, Rbe2)]
    assert [(c.independent + 1, (c.dependent + 1).tolist(), c.components) for c in rigid] == [
        (card["independent"], card["dependent"], card["components"]) for card in read["rbe2"]
    ]
    averages = [coupling for coupling in model.couplings if isinstance(coupling, Rbe3)]
    assert len(averages) == len(read["rbe3"])
    for coupling, card in zip(averages, read["rbe3"]):
        assert (card["dependent"], card["components"]) == (coupling.dependent + 1, coupling.components)
        assert {int(n) for n in card["weights"]} == set((coupling.independent + 1).tolist())
        given = np.array([card["weights"][str(n + 1)][0] for n in coupling.independent.tolist()])
        assert given / given.sum() == pytest.approx(coupling.weights / coupling.weights.sum(), rel=1e-9)
        assert {components for _, components in card["weights"].values()} == {coupling.independent_components}
    equations = [coupling for coupling in model.couplings if isinstance(coupling, Mpc)]
    assert len(equations) == len(read["mpc"])
    key = lambda one: (one[0][0], one[1][0])  # noqa: E731  by the dependent freedom
    ours = sorted(((c.nodes + 1).tolist(), c.components.tolist(), c.coefficients.tolist()) for c in equations)
    theirs = sorted(([int(n) for n in m["nodes"]], m["components"], m["coefficients"]) for m in read["mpc"])
    for one, other in zip(sorted(ours, key=key), sorted(theirs, key=key)):
        assert one[:2] == other[:2]
        assert one[2] == pytest.approx(other[2], rel=1e-9, abs=1e-12)


def test_sets_hold_the_elements_and_nodes_of_their_names(case):
    model, read = case
    text = format_for("", "nastran").write(model).decode()
    named = re.findall(r"^\$ SET (\d+): elements of (\S+); SET (\d+): its nodes$", text, re.M)
    assert len(named) == len(model.sets)
    first = np.cumsum([0, *(len(parts(block)) for block in model.mesh.blocks)])
    rows = np.cumsum([0, *(len(block.connectivity) for block in model.mesh.blocks)])
    for (elements, name, nodes), ours in zip(named, model.sets):
        assert name == re.sub(r"\W", "_", ours.name).upper()
        assert read["sets"][nodes] == (ours.nodes + 1).tolist()
        expected = []
        for index in ours.elements.tolist():
            block = int(np.searchsorted(rows, index, side="right")) - 1
            per = 2 if model.mesh.blocks[block].kind == "line3" else 1
            start = 1 + first[block] + (index - rows[block]) * per
            expected += range(start, start + per)
        assert read["sets"][elements] == expected


def test_the_mass_is_the_models(case):
    model, read = case
    elements = {element.segment: element for element in model.properties}
    ours = sum(
        block_moments(
            block, model.mesh.nodes, elements[block.segment], model.materials[elements[block.segment].material].density
        ).mass
        for block in model.mesh.blocks
    )
    is_curved = any(ELEMENT_KINDS[block.kind].order == 2 for block in model.mesh.blocks)
    assert read["mass"] == pytest.approx(ours, rel=0.02 if is_curved else 1e-3)  # it takes warped quads for flat
    assert read["unread"] == {}


def test_a_wrong_card_is_seen(tmp_path):
    """The reader refuses a node or a property that is not there, and a word for a number."""
    text = format_for("", "nastran").write(model_named("post on plate")).decode()
    card = next(line for line in text.splitlines() if line.startswith("CQUAD4"))
    broken = card[:24] + f"{99999:>8}" + card[32:]
    for old, new in ((card, broken), ("PSHELL*", "PSHELX*"), ("RBE3*  ", "RBE3*  x")):
        path = tmp_path / "wrong.bdf"
        path.write_text(text.replace(old, new, 1))
        done = subprocess.run(
            [str(READERS), str(SCRIPT), str(path)], capture_output=True, text=True, check=False, timeout=300
        )
        assert done.returncode != 0 or json.loads(done.stdout)[0]["unread"] != {}
