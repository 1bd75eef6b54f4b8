"""examples/: both languages describe the same solid, with the volume that its closed form gives."""

import math
from pathlib import Path

import numpy as np
import pytest
from csg_membership import holds

from kernel.csg.reader import read_file, read_model
from kernel.csg.tree import walk

EXAMPLES = Path(__file__).parents[2] / "examples"
NAMES = ("bracket", "i_beam", "pipe", "pipe_with_holes", "plate_with_holes", "table")
PARTS = {
    "bracket": {"BASE", "WALL", "GUSSET"},
    "i_beam": {"TOP", "WEB", "BOTTOM"},
    "pipe": {"OUTSIDE", "BORE"},
    "pipe_with_holes": {"THROUGH", "PORT"},
    "plate_with_holes": {"PLATE", "HOLES"},
    "table": {"TOP", "LEG1", "LEG2", "LEG3", "LEG4"},
}


def models(name):
    return read_file(str(EXAMPLES / f"{name}.csg")), read_file(str(EXAMPLES / f"{name}.padl.csg"))


@pytest.mark.parametrize("name", NAMES)
def test_both_languages_hold_the_same_points(name):
    openscad, padl = models(name)
    assert (openscad.language, padl.language, padl.units) == ("openscad", "padl", "mm")
    corners = np.array([np.eye(4)[:3, 3]] + [node.placement[:3, 3] for _, node in walk(padl.root) if not node.operands])
    reach = {"pipe": 70, "pipe_with_holes": 70}.get(name, 0)
    low, high = corners.min(axis=0) - 5 - reach, np.array([2410, 810, 800])
    points = np.random.default_rng(3).uniform(low, high, (20_000, 3))
    near = np.random.default_rng(4).uniform(low, (260, 130, 150), (20_000, 3))
    for sample in (points, near):
        found = holds(openscad.root, sample)
        assert np.array_equal(found, holds(padl.root, sample))
        assert found.any()


@pytest.mark.parametrize("name", NAMES)
def test_the_parts_have_names(name):
    _, padl = models(name)
    assert {node.name for _, node in walk(padl.root)} >= PARTS[name]


VOLUMES = {
    "bracket": 160 * 100 * 10 + 10 * 100 * 130 + 110 * 100 / 2 * 8 - 4 * math.pi * 49 * 10,
    "i_beam": 2400 * (2 * 120 * 10 + 8 * 100),
    "pipe": math.pi * (60**2 - 56**2) * 500,
    "plate_with_holes": (240 * 120 - 6 * math.pi * 100) * 8,
    "table": 1500 * 800 * 25 + 4 * 50 * 50 * 760,
}


@pytest.mark.parametrize("language", ["", ".padl"])
@pytest.mark.parametrize("name", VOLUMES)
def test_the_volume_is_that_of_the_closed_form(name, language):
    from kernel.solid.evaluate import evaluate

    evaluated = evaluate(read_file(str(EXAMPLES / f"{name}{language}.csg")))
    assert evaluated.solid.true_volume == pytest.approx(VOLUMES[name], rel=1e-6)


def documented(language):
    text = (EXAMPLES.parent / "docs" / "languages.md").read_text(encoding="utf-8")
    return read_model(text.split(f"```{language}\n")[1].split("```")[0], "languages.md")


def test_the_examples_of_the_documentation_are_what_it_says():
    table, json_plate, plate = (documented(language) for language in ("padl", "json", "openscad"))
    assert [model.language for model in (table, json_plate, plate)] == ["padl", "json", "openscad"]
    assert [child.name for child in table.root.operands] == ["TOP", "LEG1", "LEG2", "LEG3", "LEG4"]
    points = np.random.default_rng(5).uniform((-5, -5, -5), (60, 60, 15), (5000, 3))
    assert np.array_equal(holds(json_plate.root, points), holds(plate.root, points))
