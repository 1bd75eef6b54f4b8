"""Every example, in both languages: one meaningful number, and a sound model (solvers/ has MYSTRAN carry them)."""

from __future__ import annotations

from functools import cache
from math import pi
from pathlib import Path

import numpy as np
import pytest

from app.pipeline import Meshed, classify, mesh, read

EXAMPLES = Path(__file__).resolve().parent.parent / "examples"
LANGUAGES = ("csg", "padl.csg")
NAMES = ("plate_with_holes", "i_beam", "pipe", "pipe_with_holes", "bracket", "table")
EACH = [pytest.param(name, language, id=f"{name}.{language}") for name in NAMES for language in LANGUAGES]


@cache
def meshed(name: str, language: str) -> Meshed:
    return mesh(classify(read(str(EXAMPLES / f"{name}.{language}"))))


def only(name: str, language: str):
    (segment,) = meshed(name, language).classified.partition.segments
    return segment


def test_every_example_stands_in_both_languages_and_in_this_file():
    assert {path.name for path in EXAMPLES.glob("*.csg")} == {f"{n}.{ending}" for n in NAMES for ending in LANGUAGES}


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_drilled_plate_is_a_plate_with_six_holes(language):
    plate = only("plate_with_holes", language)
    assert (plate.type, plate.holes) == ("plate", 6)
    assert plate.thickness == pytest.approx(8, rel=1e-12)
    assert plate.volume == pytest.approx((240 * 120 - 6 * pi * 100) * 8, rel=1e-9)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_i_beam_is_one_beam_with_the_section_of_the_handbook(language):
    beam = only("i_beam", language)
    section = meshed("i_beam", language).assembly.sections[beam.id]
    assert section.shape == "i"
    assert section.area == pytest.approx(3200, rel=1e-12)
    strong = (120 * 120**3 - 112 * 100**3) / 12
    assert max(section.iyy, section.izz) == pytest.approx(strong, rel=1e-12)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_pipe_is_a_cylinder_plate_of_the_mid_radius(language):
    pipe = only("pipe", language)
    assert (pipe.type, pipe.holes) == ("cylinder_plate", 0)
    assert (pipe.radius, pipe.thickness) == (pytest.approx(58), pytest.approx(4))


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_drilled_pipe_keeps_its_three_holes_and_its_nodes_on_the_cylinder(language):
    pipe = only("pipe_with_holes", language)
    assert pipe.holes == 3
    nodes = meshed("pipe_with_holes", language).model.mesh.nodes
    assert np.abs(np.hypot(nodes[:, 0], nodes[:, 1]) - 58).max() < 1e-9 * 500


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_bracket_is_three_plates_on_shared_curves(language):
    result = meshed("bracket", language)
    assert sorted((s.thickness, s.holes) for s in result.classified.partition.segments) == [
        (pytest.approx(8), 0),
        (pytest.approx(10), 2),
        (pytest.approx(10), 2),
    ]
    assert result.model.couplings == ()


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_table_stands_on_four_beams_of_its_legs_length(language):
    segments = meshed("table", language).classified.partition.segments
    assert [s.length for s in segments if s.type == "beam"] == [pytest.approx(760)] * 4


@pytest.mark.parametrize(("name", "language"), EACH)
def test_each_example_is_one_sound_model(name, language):
    result = meshed(name, language)
    assert result.checks.failures == ()
    assert result.checks.components == 1
    assert abs(result.checks.accounted_mass_error) < 5e-3
