"""Bars in any direction, turned about their axes at random: every deck says which way their sections stand."""

from __future__ import annotations

import numpy as np
import pytest
from handmade import beam_property, line_block, model_of
from shapely import box

from kernel.csg.reader import read_model
from kernel.deck.deck import format_for
from kernel.idealise.section import section_properties
from kernel.segment.partition import partition
from kernel.solid.evaluate import evaluate
from rules.engine import load_rule_base

N_BAR = 12
IYY, IZZ = 22500.0, 2500.0
"""Of 10 x 30, the 30 along z: the long side of the section is z = direction x y."""


def frame(seed=3):
    """Loose bars: the model, their directions and their sections' y axes, each (n, 3)."""
    rng = np.random.default_rng(seed)
    nodes, blocks, directions, sides = [], [], [], []
    for k in range(N_BAR):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        place = rng.uniform(-100, 100, 3)
        nodes += [place, place + 50 * turn[0]]
        blocks.append(line_block(f"s{k + 1}", [2 * k, 2 * k + 1], turn[1]))
        directions.append(turn[0])
        sides.append(turn[1])
    properties = [beam_property(block.segment, box(0, 0, 10, 30)) for block in blocks]
    return model_of(nodes, blocks, properties), np.array(directions), np.array(sides)


def deck_lines(model, name):
    return format_for("deck", name).write(model).decode().splitlines()


def numbers(text, sep=","):
    return [float(word) for word in text.split(sep) if word.strip()]


def nastran(lines):
    """v of CBAR; PBAR's I1 is for bending in the plane of v."""
    cards = [k for k, line in enumerate(lines) if line.startswith("CBAR*")]
    vectors = [[float(lines[k + 1][8 + 16 * i : 24 + 16 * i]) for i in range(3)] for k in cards]
    first = next(k for k, line in enumerate(lines) if line.startswith("PBAR*"))
    assert float(lines[first][56:72]) == IZZ
    return vectors


def calculix(lines):
    """A and b of RECT lie along the 1-direction, which is given, and across it."""
    first = [k for k, line in enumerate(lines) if line.startswith("*BEAM SECTION")]
    assert all(numbers(lines[k + 1]) == [10, 30] for k in first)
    return [numbers(lines[k + 2]) for k in first]


def abaqus(lines):
    """The 1-axis; A, I11 (about it), I12, I22."""
    first = [k for k, line in enumerate(lines) if line.startswith("*BEAM GENERAL SECTION")]
    assert all(numbers(lines[k + 1])[1:4] == [IYY, 0, IZZ] for k in first)
    return [numbers(lines[k + 2]) for k in first]


def sapiv(lines):
    """The K node lies in the plane of axes 1 and 2; I2 is about 2."""
    n_node = int(lines[1][:5])
    places = {
        int(line[1:5]): [float(line[35 + 10 * i : 45 + 10 * i]) for i in range(3)] for line in lines[2 : 2 + n_node]
    }
    sections = lines[2 + n_node + 2 : 2 + n_node + 2 + N_BAR]
    assert all(numbers(line[45:65], None) == [IYY, IZZ] for line in sections)
    rows = [line.split() for line in lines[2 + n_node + 2 + N_BAR + 3 :] if len(line.split()) > 10]
    return [np.subtract(places[int(row[3])], places[int(row[1])]) for row in rows[:N_BAR]]


def ansys5(lines):
    """The K node lies in the plane of x and z; IZZ, IYY."""
    assert all(numbers(line)[1:4] == [300, IZZ, IYY] for line in [ln[2:] for ln in lines if ln.startswith("R,")])
    places = {int(w[1]): np.array(w[2:5], float) for w in (ln.split(",") for ln in lines if ln.startswith("N,"))}
    rows = [[int(word) for word in ln.split(",")[2:5]] for ln in lines if ln.startswith("EN,")]
    return [places[k] - places[i] for i, _, k in rows]


def ansys(lines):
    """The K node lies in the plane of x and z; A, Iyy, Iyz, Izz."""
    assert all(numbers(ln[8:])[1:4] == [IYY, 0, IZZ] for ln in lines if ln.startswith("SECDATA"))
    start = next(k for k, line in enumerate(lines) if line.startswith("NBLOCK")) + 2
    places = {}
    while not lines[start].startswith("N,R"):
        line = lines[start]
        places[int(line[:9])] = np.array([float(line[27 + 21 * i : 48 + 21 * i]) for i in range(3)])
        start += 1
    start = next(k for k, line in enumerate(lines) if line.startswith("EBLOCK")) + 2
    rows = [lines[start + k].split() for k in range(N_BAR)]
    return [places[int(row[-1])] - places[int(row[-3])] for row in rows]


@pytest.mark.parametrize(
    ("read", "along"), [(nastran, "y"), (calculix, "y"), (abaqus, "y"), (sapiv, "y"), (ansys5, "z"), (ansys, "z")]
)
def test_the_deck_says_which_way_the_section_stands(read, along):
    model, directions, sides = frame()
    wanted = sides if along == "y" else np.cross(directions, sides)
    found = np.array(read(deck_lines(model, read.__name__)))
    found -= directions * np.einsum("ij,ij->i", found, directions)[:, None]
    found /= np.linalg.norm(found, axis=1)[:, None]
    assert np.abs(np.einsum("ij,ij->i", found, wanted)) == pytest.approx(
        np.ones(N_BAR), abs=1e-9 if read is not sapiv else 1e-6
    )


def test_bars_of_a_model_stand_as_they_were_drawn():
    rng = np.random.default_rng(11)
    bars, turns = [], []
    for k in range(N_BAR):
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        turn[:, 2] *= np.linalg.det(turn)
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = turn, (1000 * k, 0, 0)
        rows = ",".join(str(row) for row in matrix.tolist())
        bars.append(f"multmatrix([{rows}]){{cube(size=[300,10,30],center=false);}}")
        turns.append(turn)
    evaluated = evaluate(read_model("union(){" + "".join(bars) + "}", "test"))
    segments = partition(evaluated, load_rule_base().decide).segments
    assert [segment.type for segment in segments] == ["beam"] * N_BAR
    for segment in segments:
        shape, section = segment.shape, section_properties(segment.shape.outline)
        turn = turns[int(segment.node)]
        axis = evaluated.frame @ shape.direction
        y, z = evaluated.frame @ shape.u, evaluated.frame @ shape.v
        assert abs(axis @ turn[:, 0]) == pytest.approx(1, abs=1e-9)
        # the second moment about y is that of what lies along z
        moments = (
            section.iyy * np.outer(z, z)
            + section.izz * np.outer(y, y)
            + section.iyz * (np.outer(y, z) + np.outer(z, y))
        )
        assert turn[:, 2] @ moments @ turn[:, 2] == pytest.approx(IYY, rel=1e-9)
        assert turn[:, 1] @ moments @ turn[:, 1] == pytest.approx(IZZ, rel=1e-9)
