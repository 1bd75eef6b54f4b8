"""`csgmesh rules`: what analysts ask about the rule bases that they write."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Protocol

import typer

from app import texts
from kernel.errors import RuleError

if TYPE_CHECKING:
    from rules.engine import RuleBase

OWN = "base"
"""How the rule base that comes with csgmesh is written where a FILE is wanted."""

app = typer.Typer(
    name="rules",
    help="Check, test, compare and document rule bases. FILE is a YAML file or folder; `base` is the own one.",
    no_args_is_help=False,
    rich_markup_mode=None,
)

FilesArgument = Annotated[list[str] | None, typer.Argument(metavar="FILE...", help="Rule bases; `base` by default.")]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]


class Report(Protocol):
    """What rules/analysis gives."""

    @property
    def ok(self) -> bool:
        """Nothing is wrong."""

    def to_text(self) -> str:
        """For a terminal."""

    def to_json(self) -> dict[str, Any]:
        """For JSON."""


@app.callback(invoke_without_command=True)
def root(context: typer.Context) -> None:
    """Without a command: the help."""
    if context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command(epilog="Example: csgmesh rules check rules.yaml")
def check(files: FilesArgument = None, as_json: JsonOption = False) -> None:
    """Names, units, unreachable, shadowed and contradictory rules, gaps; fails where there are errors."""
    from rules.analysis import check as check_rules

    named = files or [OWN]
    for name in named:
        if name != OWN and not Path(name).exists():
            raise RuleError(f"there is no rule base {name}, expected a YAML file, a folder of them, or `{OWN}`")
    wrong = [name for name in named if not _show(check_rules(_path(name)), as_json)]
    if wrong:
        raise RuleError(f"{', '.join(wrong)}: wrong, expected no errors")


@app.command("test", epilog="Example: csgmesh rules test rules.yaml")
def run_cases(files: FilesArgument = None, as_json: JsonOption = False) -> None:
    """Run every case that the rules bring along; fails where one gives another answer."""
    from app.rulework import plan_of
    from rules.analysis import run_cases as run

    wrong = [name for name in files or [OWN] if not _show(run(_load(name), plan_of), as_json)]
    if wrong:
        raise RuleError(f"{', '.join(wrong)}: cases failed, expected all to pass")


@app.command(epilog="Example: csgmesh rules coverage rules.yaml")
def coverage(files: FilesArgument = None, as_json: JsonOption = False) -> None:
    """Which conditions the cases exercise both ways."""
    from app.rulework import plan_of
    from rules.analysis import coverage as cover

    for name in files or [OWN]:
        _show(cover(_load(name), plan_of), as_json)


@app.command(epilog="Example: csgmesh rules diff base rules.yaml models/")
def diff(
    before: Annotated[str, typer.Argument(metavar="BEFORE", help="A rule base.")],
    after: Annotated[str, typer.Argument(metavar="AFTER", help="Another one.")],
    models: Annotated[
        list[str] | None, typer.Argument(metavar="MODEL...", help="Models, or folders of them; the cases by default.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Which nodes the two rule bases decide differently, and how."""
    from app.rulework import compare

    _show(compare(_load(before), _load(after), _texts(models or [])), as_json)


@app.command(epilog="Example: csgmesh rules docs base")
def docs(files: FilesArgument = None, as_json: JsonOption = False) -> None:
    """The facts that rules may use, and the parameters and rules of each FILE."""
    from rules.analysis import vocabulary_json, vocabulary_text

    for name in files or [OWN]:
        base = _load(name)
        _print(texts.as_json(vocabulary_json(base)) if as_json else vocabulary_text(base))


def _show(report: Report, as_json: bool) -> bool:
    _print(texts.as_json(report.to_json()) if as_json else report.to_text())
    return report.ok


def _path(name: str) -> str | None:
    return None if name == OWN and not Path(name).exists() else name


def _load(name: str) -> RuleBase:
    from rules.engine import load_rule_base

    return load_rule_base(_path(name))


def _texts(paths: list[str]) -> dict[str, str]:
    """Texts of models by path; a folder stands for the .csg files in it, and for those .json files that are trees."""
    texts_read = {}
    for path in map(Path, paths):
        if not path.is_dir():
            texts_read[str(path)] = _text(path)
            continue
        inside = {str(p): _text(p) for p in sorted(path.iterdir()) if p.suffix in (".csg", ".json")}
        models = {name: text for name, text in inside.items() if name.endswith(".csg") or _is_tree(text)}
        if not models:
            raise RuleError(f"{path}: no models in this folder, expected .csg files or trees in .json")
        texts_read.update(models)
    return texts_read


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise RuleError(f"{path}: cannot be read, expected a model: {error}") from error


def _is_tree(text: str) -> bool:
    """Whether JSON has the root of a tree; other JSON lies beside models too."""
    try:
        value = json.loads(text)
    except ValueError:
        return False
    return isinstance(value, dict) and "root" in value


def _print(text: str) -> None:
    sys.stdout.write(text.rstrip("\n") + "\n")
