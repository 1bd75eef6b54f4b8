"""Arguments and options that several commands have."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated

import typer

from kernel.errors import OptionError

if TYPE_CHECKING:
    from kernel.plan import Override

ModelArgument = Annotated[str, typer.Argument(metavar="MODEL", help="A .csg or .json file; - for standard input.")]
RulesOption = Annotated[str | None, typer.Option("--rules", metavar="FILE", help="Rule base instead of the own one.")]
OverrideOption = Annotated[
    list[str] | None,
    typer.Option(
        "--override",
        metavar="NODE=TYPE[:REASON]",
        help="Decide a node yourself, by path or name: beam, plate, plates, cylinder_plate, brick, split, auto.",
    ),
]
UnitsOption = Annotated[
    str | None,
    typer.Option(
        "--units",
        help="For a model that does not say; mm by default. Consistent sets: mm (mm-t-s-N-MPa), cm (cm-100 kg-s-N), "
        "m (m-kg-s-N-Pa), in (in-lbf-s-psi), ft (ft-slug-s-lbf-psf).",
    ),
]
GapOption = Annotated[
    float, typer.Option("--gap", help="Faces that look at one another over no more than this count as touching.")
]
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]


def overrides(texts_given: list[str] | None) -> dict[str, Override]:
    """NODE=TYPE or NODE=TYPE:REASON by node; OptionError where one is written otherwise or a node stands twice."""
    from kernel.plan import Override

    found: dict[str, Override] = {}
    for text in texts_given or []:
        written = re.fullmatch(r"(.+?)=([^=:]+)(?::(.*))?", text, re.DOTALL)
        if written is None:
            raise OptionError(f"--override {text!r}: expected NODE=TYPE or NODE=TYPE:REASON, such as 0.1=brick")
        node, kind, reason = written.groups()
        if node in found:
            raise OptionError(f"--override {text!r}: node {node} is overridden twice, expected once")
        found[node] = Override(kind, reason=(reason or "").strip())
    return found
