"""Keys of kept meshes know the sources that made them."""

import shutil
from pathlib import Path

import pytest

import app
from app.api.context import question_key
from app.sources import MODULES, hash_of, sources_hash

ROOT = Path(app.__file__).resolve().parent.parent


@pytest.fixture
def copy(tmp_path):
    """A small part of the sources, in folders of the same names."""
    for folder in ("kernel", "rules", "app"):
        (tmp_path / folder).mkdir()
        shutil.copy(ROOT / folder / "__init__.py", tmp_path / folder)
    for module in MODULES:
        shutil.copy(ROOT / "app" / f"{module}.py", tmp_path / "app")
    return tmp_path


def test_the_same_sources_have_the_same_hash(copy):
    assert hash_of(copy) == hash_of(copy)
    assert sources_hash() == sources_hash() != hash_of(copy)


@pytest.mark.parametrize("changed", ["kernel/__init__.py", "app/pipeline.py", "kernel/new.py", "rules/base/new.yaml"])
def test_a_change_of_what_computes_changes_the_hash(copy, changed):
    before = hash_of(copy)
    path = copy / changed
    path.parent.mkdir(exist_ok=True)
    path.write_text((path.read_text() if path.exists() else "") + "# changed\n")
    assert hash_of(copy) != before


def test_a_change_of_the_page_does_not(copy):
    before = hash_of(copy)
    (copy / "app" / "texts.py").write_text("# changed\n")
    assert hash_of(copy) == before


def test_other_sources_ask_another_question(monkeypatch):
    before = question_key("mesh", {"text": "a"})
    monkeypatch.setattr("app.api.context.sources_hash", lambda: "other")
    assert question_key("mesh", {"text": "a"}) != before
