"""Finding the files of a rule base, and laying one that extends another over it, before anything is interpreted.

A rule base is a file, or a folder whose *.yaml files are one base. `extends: base` (or a relative path) puts another
below it: parameters, quantities and rules of the same name are replaced, `remove` takes rules away.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from kernel.errors import Place, RuleError
from rules.document import MAX_FILE_CHARACTERS, Item, Mapping, Scalar, Sequence, read_document
from rules.problems import Collector, did_you_mean

BASE_FOLDER = Path(__file__).with_name("base")
MAX_EXTENDS = 8
MAX_FILES = 200

TOP_KEYS = ("about", "cases", "extends", "name", "parameters", "quantities", "remove", "rules")


@dataclass(frozen=True, slots=True)
class SourceFile:
    """A rule file as read: its path as it is shown in places, and its text."""

    path: str
    text: str


@dataclass(slots=True)
class Merged:
    """All layers, the nearest winning, still as YAML items. parameters: the layers of each, farthest first."""

    name: str = ""
    about: str = ""
    parameters: dict[str, list[tuple[Place, Item]]] = field(default_factory=dict)
    quantities: dict[str, tuple[Place, Item]] = field(default_factory=dict)
    rules: dict[str, Mapping] = field(default_factory=dict)
    cases: list[Item] = field(default_factory=list)
    files: list[str] = field(default_factory=list)


def merge_path(path: str | None, problems: Collector) -> Merged:
    """The rule base at `path`, None for the one that comes with csgmesh."""
    root = BASE_FOLDER if path is None else Path(path)
    return _merge(read_files(root, str(path) if path is not None else "base"), root, problems, (root.resolve(),))


def merge_text(text: str, name: str, problems: Collector) -> Merged:
    """The rule base in `text`, which may extend `base` but no file."""
    return _merge([SourceFile(name, text)], None, problems, ())


def read_files(root: Path, shown: str) -> list[SourceFile]:
    """The rule files of a base, by name; RuleError where there are none or they cannot be read."""
    paths = sorted(root.glob("*.yaml")) if root.is_dir() else [root]
    if not paths:
        raise RuleError(f"no rule files (*.yaml) in the folder {shown}")
    if len(paths) > MAX_FILES:
        raise RuleError(f"{len(paths)} rule files in the folder {shown}, expected at most {MAX_FILES}")
    files = []
    for path in paths:
        label = f"{shown.rstrip('/')}/{path.name}" if root.is_dir() else shown
        try:
            if path.stat().st_size > 4 * MAX_FILE_CHARACTERS:
                raise RuleError(
                    f"rule file {label} of {path.stat().st_size} bytes, expected at most {4 * MAX_FILE_CHARACTERS}"
                )
            text = path.read_text(encoding="utf-8-sig")
        except UnicodeDecodeError as error:
            raise RuleError(f"rule file {label} is not UTF-8 at byte {error.start}") from None
        except OSError as error:
            raise RuleError(f"rule file {label} cannot be read: {error.strerror or error}") from None
        files.append(SourceFile(label, text))
    return files


def _merge(files: list[SourceFile], root: Path | None, problems: Collector, seen: tuple[Path, ...]) -> Merged:
    documents: list[tuple[SourceFile, Mapping]] = []
    for file in files:
        document = read_document(file.text, file.path)
        if document is None:
            continue
        if not isinstance(document, Mapping):
            problems.error(document.place, f"no keys at the top of the file, expected {', '.join(TOP_KEYS)}")
            continue
        for key, place in document.keys.items():
            if key not in TOP_KEYS:
                problems.error(place, f"unknown key {key!r}{did_you_mean(key, TOP_KEYS) or _expected(TOP_KEYS)}")
        documents.append((file, document))
    merged = Merged()
    heads: dict[str, Scalar] = {}
    for key in ("name", "about", "extends"):
        for _, document in documents:
            item = document.entries.get(key)
            if item is None:
                continue
            if not isinstance(item, Scalar) or not item.text.strip():
                problems.error(item.place, f"`{key}` needs a text")
            elif key in heads:
                problems.error(document.keys[key], f"`{key}` stands in two files, first in {heads[key].place}")
            else:
                heads[key] = item
    if "extends" in heads:
        merged = _extended(heads["extends"], root, problems, seen)
    if "name" in heads:
        merged.name = heads["name"].text.strip()
    elif files:
        merged.name = Path(files[0].path).stem if root is None or not root.is_dir() else root.name
    merged.about = heads["about"].text.strip() if "about" in heads else merged.about
    if documents:
        _lay_over(merged, documents, problems)
    merged.files.extend(file.path for file in files)
    return merged


def _extended(extends: Scalar, root: Path | None, problems: Collector, seen: tuple[Path, ...]) -> Merged:
    """The base that `extends` names, merged."""
    if extends.text == "base":
        target, shown = BASE_FOLDER, "base"
    elif root is None:
        problems.error(
            extends.place, f"extends {extends.text!r}, expected `base`: a rule base sent as text cannot reach files"
        )
        return Merged()
    else:
        folder = root if root.is_dir() else root.parent
        target, shown = folder / extends.text, str(folder / extends.text)
    if target.resolve() in seen:
        problems.error(extends.place, f"extends {extends.text!r}, which extends this one again")
        return Merged()
    if len(seen) >= MAX_EXTENDS:
        problems.error(extends.place, f"more than {MAX_EXTENDS} rule bases extend one another")
        return Merged()
    if not target.exists():
        problems.error(extends.place, f"extends {extends.text!r}, which does not exist (looked for {shown})")
        return Merged()
    return _merge(read_files(target, shown), target, problems, (*seen, target.resolve()))


def _lay_over(merged: Merged, documents: list[tuple[SourceFile, Mapping]], problems: Collector) -> None:
    """Put one layer's files over what is there."""
    own: dict[str, Place] = {}
    for _, document in documents:
        for item in _items(document, "remove", problems):
            if not isinstance(item, Scalar) or item.text not in merged.rules:
                text = item.text if isinstance(item, Scalar) else "?"
                problems.error(item.place, f"no rule {text!r} to remove{did_you_mean(text, merged.rules)}")
            else:
                del merged.rules[item.text]
    for _, document in documents:
        for name, place, item in _entries(document, "parameters", problems):
            if _is_new(f"parameter {name}", place, own, problems):
                merged.parameters.setdefault(name, []).append((place, item))
        for name, place, item in _entries(document, "quantities", problems):
            if _is_new(f"quantity {name}", place, own, problems):
                merged.quantities[name] = (place, item)
        for item in _items(document, "rules", problems):
            identity = item.entries.get("id") if isinstance(item, Mapping) else None
            if not isinstance(item, Mapping) or not isinstance(identity, Scalar) or not identity.text.strip():
                problems.error(item.place, "a rule without `id`, expected a short name that no other rule has")
            elif _is_new(f"rule {identity.text}", identity.place, own, problems):
                merged.rules[identity.text] = item
        merged.cases.extend(_items(document, "cases", problems))


def _is_new(what: str, place: Place, own: dict[str, Place], problems: Collector) -> bool:
    if what in own:
        problems.error(place, f"the {what} stands twice, first in {own[what]}")
        return False
    own[what] = place
    return True


def _entries(document: Mapping, key: str, problems: Collector) -> list[tuple[str, Place, Item]]:
    item = document.entries.get(key)
    if item is None:
        return []
    if not isinstance(item, Mapping):
        problems.error(item.place, f"`{key}` needs names with values")
        return []
    return [(name, item.keys[name], value) for name, value in item.entries.items()]


def _items(document: Mapping, key: str, problems: Collector) -> list[Item]:
    item = document.entries.get(key)
    if item is None:
        return []
    if not isinstance(item, Sequence):
        problems.error(item.place, f"`{key}` needs a list")
        return []
    return list(item.items)


def _expected(names: tuple[str, ...]) -> str:
    return f", expected one of {', '.join(names)}"
