"""The flow as a user of the library sees it."""

from __future__ import annotations

import json
import re
from collections import Counter
from pathlib import Path

import pytest

from app.cli import run
from app.pipeline import classify, mesh, read, resolve_overrides, write_deck
from kernel.errors import OptionError, OverrideError
from kernel.mesh.options import MeshOptions
from kernel.plan import Override

ROOT = Path(__file__).resolve().parent.parent
TABLE = str(ROOT / "examples" / "table.csg")


def types_of(classified) -> Counter:
    return Counter(segment.type for segment in classified.partition.segments)


def test_the_readme_shows_lines_that_run(monkeypatch, tmp_path):
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", (ROOT / "README.md").read_text(), re.DOTALL)
    names: dict = {}
    exec(compile(block, "README.md", "exec"), names)
    assert names["deck"].endswith(b"ENDDATA\n")
    assert (tmp_path / "bracket.bdf").read_bytes() == names["deck"]


def test_the_readmes_table_of_bricks_is_of_bricks_only(monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    text = (ROOT / "README.md").read_text().replace("\\\n", " ")
    (line,) = re.findall(r"\$ csgmesh (mesh .*-o bricks\.bdf.*)", text)
    assert run([*line.split(), "--json"]) == 0
    assert set(json.loads(capsys.readouterr().out)["elements"]) == {"hex8"}


def test_a_table_is_one_plate_and_four_beams_joined_as_one_component():
    meshed = mesh(classify(read(TABLE)))
    assert types_of(meshed.classified) == {"plate": 1, "beam": 4}
    assert meshed.checks.components == 1
    assert meshed.checks.failures == ()


def test_the_same_table_overridden_to_bricks_runs_and_costs_more():
    csg = read(TABLE)
    frame = mesh(classify(csg))
    addresses = {segment.node for segment in frame.classified.partition.segments}
    bricks = mesh(classify(csg, overrides={address: Override("brick") for address in addresses}))
    assert types_of(bricks.classified) == {"brick": 5}
    assert bricks.checks.components == 1
    assert bricks.checks.failures == ()
    assert abs(bricks.checks.mass_error) < 1e-9


def test_the_same_input_gives_the_same_bytes():
    decks = {write_deck(mesh(classify(read(TABLE)), MeshOptions(size=60)), "table.bdf") for _ in range(2)}
    assert len(decks) == 1


def test_progress_names_the_stages_in_their_order():
    seen: list[str] = []
    classify(read(TABLE), progress=lambda stage, share: seen.append(stage) if share == 0 else None)
    assert [stage for stage in seen if stage in ("rules", "evaluate", "segment", "joints")] == [
        "rules",
        "evaluate",
        "segment",
        "joints",
    ]


def test_an_override_may_name_the_node_but_not_twice():
    csg = read(str(ROOT / "examples" / "table.padl.csg"))
    resolved = resolve_overrides(csg, {"TOP": Override("brick")})
    (path,) = resolved
    assert resolved[path].type == "brick"
    with pytest.raises(OverrideError, match="are both of node"):
        resolve_overrides(csg, {"TOP": Override("brick"), path: Override("plate")})


def test_an_unknown_type_or_node_is_refused_by_name():
    csg = read(TABLE)
    with pytest.raises(OverrideError, match=r"override 0=slab: unknown type, expected one of beam, plate"):
        resolve_overrides(csg, {"0": Override("slab")})
    with pytest.raises(OverrideError, match=r"no node '7\.7' in the model"):
        resolve_overrides(csg, {"7.7": Override("beam")})


def test_auto_takes_an_override_back():
    assert resolve_overrides(read(TABLE), {"0": Override("auto")}) == {}


def test_tetrahedra_have_mid_side_nodes_whatever_the_order():
    csg = read(str(ROOT / "examples" / "bracket.csg"))
    bricks = classify(csg, overrides={"/": Override("brick")})
    meshed = mesh(bricks, MeshOptions(size=40, order=1))
    assert set(meshed.assembly.mesh.count()) == {"tet10"}
    assert meshed.checks.failures == ()
    assert abs(meshed.checks.mass_error) < 1e-3


def test_units_that_differ_from_the_models_are_refused_not_reinterpreted():
    csg = read(str(ROOT / "examples" / "table.padl.csg"))
    with pytest.raises(OptionError, match="the model says UNITS mm, but units m are asked for"):
        classify(csg, units="m")
    assert classify(csg, units="MM").units.name == "mm"
    assert classify(read(TABLE), units="m").units.name == "m"
