"""NASTRAN decks, card by card."""

from dataclasses import replace

import numpy as np
import pytest
from handmade import cantilever, i_outline, shell_cantilever, solid_cantilever, whole_set

from kernel.connect.model import Mpc, NamedSet, Rbe2, Rbe3
from kernel.deck.deck import format_for
from kernel.deck.nastran import write
from kernel.errors import OptionError


def lines(model):
    return write(model).decode().splitlines()


def cards(model, name):
    """Cards of one name with their continuations, fields split."""
    found, current = [], None
    for line in lines(model):
        if line.startswith("$"):
            continue
        head = line[:8].strip()
        width = 16 if "*" in head else 8
        fields = [line[8 + k * width : 8 + (k + 1) * width].strip() for k in range(64 // width)]
        if head.rstrip("*") == name:
            current = list(fields)
            found.append(current)
        elif head in ("+", "*") and current is not None:
            current += fields
        else:
            current = None
    return found


def test_coordinates_stand_in_sixteen_character_fields():
    model = cantilever(i_outline(), 1000.0, 3)
    grids = [line for line in lines(model) if line.startswith("GRID*")]
    assert len(grids) == 4
    assert grids[1] == f"GRID*   {2:>16}{'':>16}{'333.333333333333':>16}{'0.':>16}"


def test_a_bar_has_section_and_orientation():
    model = cantilever(i_outline(), 1000.0, 1)
    (bar,) = cards(model, "CBAR")
    assert bar[:7] == ["1", "1", "1", "2", "0.", "1.", "0."]
    (prop,) = cards(model, "PBAR")
    section = model.properties[0].section
    numbers = [float(x) if x else None for x in prop]
    assert numbers[2:6] == pytest.approx([section.area, section.izz, section.iyy, section.j])
    assert numbers[16] == pytest.approx(section.shear_area_y / section.area)
    assert numbers[17] == pytest.approx(section.shear_area_z / section.area)


def test_a_beam_of_three_nodes_becomes_two_bars():
    model = cantilever(i_outline(), 1000.0, 2, "line3")
    model = replace(model, sets=(NamedSet("LAST", np.array([4]), np.array([1])),))
    assert [card[2:4] for card in cards(model, "CBAR")] == [["1", "2"], ["2", "3"], ["3", "4"], ["4", "5"]]
    assert "SET 1 = 3,4" in lines(model)


def test_sets_carry_the_names_of_csg_nodes():
    model = shell_cantilever("quad4", divisions=(4, 2))
    named = NamedSet("TOP", np.array([0, 1, 2, 7]), np.array([0, 1, 2, 3, 7]))
    text = lines(replace(model, sets=(named,)))
    assert "$ SET 1: elements of TOP; SET 2: its nodes" in text
    assert "SET 1 = 1 THRU 4,8" in text
    assert "SET 2 = 1 THRU 3,8" in text


def test_long_sets_stay_within_a_line():
    model = shell_cantilever("quad4", divisions=(100, 2))
    named = replace(whole_set(model, "ODD"), elements=np.arange(0, 200, 2))
    assert all(len(line) <= 72 for line in lines(replace(model, sets=(named,))) if line.startswith(("SET", "   ")))


def test_every_kind_of_solid_gets_the_integration_it_needs():
    assert cards(solid_cantilever("hex8", divisions=(2, 1, 1)), "PSOLID")[0][:6] == ["1", "1", "", "TWO", "", "REDUCED"]
    for kind in ("hex20", "wedge15", "tet4", "tet10"):
        assert cards(solid_cantilever(kind, divisions=(2, 1, 1)), "PSOLID")[0][2:6] == ["", "", "", ""]


def test_couplings_are_written_as_nastran_reads_them():
    model = shell_cantilever("quad4", divisions=(4, 2))
    couplings = (
        Rbe2(0, np.array([1, 2]), "123456"),
        Rbe3(3, np.array([4, 5, 6]), np.array([2.0, 1.0, 1.0])),
        Mpc(np.array([7, 8, 9]), np.array([1, 1, 2]), np.array([-1.0, 0.5, 0.25])),
    )
    model = replace(model, couplings=couplings)
    assert cards(model, "RBE2")[0][:5] == ["9", "1", "123456", "2", "3"]
    rbe3 = [field for field in cards(model, "RBE3")[0] if field]
    assert rbe3 == ["10", "4", "123456", "1.5", "123", "5", ".75", "123", "6", "7"]
    assert cards(model, "MPC")[0][:12] == ["1", "8", "1", "-1.", "9", "1", ".5", "", "", "10", "2", ".25"]
    assert "MPC = 1" in lines(model)


def test_a_scaled_density_is_a_material_of_its_own():
    model = shell_cantilever("quad4", divisions=(2, 1))
    scaled = replace(model, properties=(replace(model.properties[0], density_factor=0.5),))
    assert float(cards(scaled, "MAT1")[0][4]) == pytest.approx(7.85e-9 / 2)


def test_the_header_says_units_and_rule_base():
    text = write(cantilever(i_outline(), 1000.0, 1)).decode()
    assert "units: mm-t-s-N" in text
    assert "rule base: none 0" in text


@pytest.mark.parametrize("name", ["model.bdf", "model.NAS"])
def test_the_ending_chooses_the_format(name):
    assert format_for(name).name == "nastran"


def test_an_unknown_ending_is_refused_with_those_that_are_known():
    with pytest.raises(OptionError, match=r"expected one of nastran \(.bdf"):
        format_for("model.xyz")
