"""Arguments and options that several commands have."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING, Annotated

import typer

from kernel.errors import OptionError

if TYPE_CHECKING:
    from kernel.plan import Override

FORMATS_HELP = (
    "Instead of what DECK's ending means: nastran (.bdf .nas .dat), ansys (.cdb, blocked archive), ansys5 (.ans, "
    "commands of ANSYS 5.0), calculix (.inp), abaqus (no ending), sapiv (.sap), gmsh (.msh, 4.1), vtu (.vtu, VTK), "
    "json (.json)."
)
MATERIAL_HELP = (
    "Material of every segment, instead of what the model says, else steel: steel, stainless, aluminium, titanium "
    "(Ti-6Al-4V), concrete (C30/37), one that the model defines, or a YAML file {name: S355, E: 210000, NU: 0.3, "
    "RHO: 7.85e-9}."
)
CURVES_HELP = (
    "CURVES: a node (curves on its surfaces, the axis of a beam), a segment (its outline), A&B (what two share), or a "
    "point x,y,z (the curve nearest to it); docs/meshing.md has examples."
)
COUPLING_HELP = (
    "Where dimensions change: distributing (RBE3: a beam's end moves as the average of its patch), rigid (RBE2: the "
    "patch moves as the beam's end does), work (equations: forces do the same work on both sides)."
)
TEE_HELP = (
    "Where a wall ends within another: extend (it is carried on to the other's mid-surface, and shares nodes), arms "
    "(it stops at the other's face, and its nodes hang from the other's by rigid arms)."
)

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

FormatOption = Annotated[str | None, typer.Option("--format", help=FORMATS_HELP)]
SizeOption = Annotated[float | None, typer.Option(help="Target length of an element's edge; automatic by default.")]
SizeOfOption = Annotated[
    list[str] | None,
    typer.Option(metavar="NODE=SIZE", help="Size of one node or segment, as TOP=20; the deepest node wins."),
]
CurveSizeOption = Annotated[
    list[str] | None,
    typer.Option(metavar="CURVES=SIZE", help=f"Longest element along some curves, as HOLE=2. {CURVES_HELP}"),
]
SeedsOption = Annotated[
    list[str] | None,
    typer.Option(metavar="CURVES=COUNT", help="Exactly so many elements on each of them, as TOP&LEG=8."),
]
GrowthOption = Annotated[
    float | None, typer.Option(help="Most that an element may be longer than its neighbour, as 1.2.")
]
PerCircleOption = Annotated[int | None, typer.Option(help="Fewest elements round a full circle.")]
LayersOption = Annotated[
    int | None, typer.Option(help="Fewest elements through a brick and across the walls of its section.")
]
OrderOption = Annotated[int, typer.Option(help="1: corner nodes only, 2: mid-side nodes too.")]
FacesOption = Annotated[str, typer.Option(help="Shells of: quad, tri.")]
VolumesOption = Annotated[
    str,
    typer.Option(help="Bricks of: auto (hexes where they can be swept or turned, else tets), hex (or refuse), tet."),
]
MaterialOption = Annotated[str | None, typer.Option(metavar="NAME|FILE", help=MATERIAL_HELP)]
MaterialOfOption = Annotated[
    list[str] | None, typer.Option(metavar="NODE=NAME", help="Material of one node or segment, as TOP=aluminium.")
]
CouplingOption = Annotated[str, typer.Option(help=COUPLING_HELP)]
TeeOption = Annotated[str, typer.Option(help=TEE_HELP)]
MassOption = Annotated[str, typer.Option(help="plain: densities as given; exact: scaled to the solid's mass.")]
UncheckedOption = Annotated[
    bool, typer.Option("--unchecked", help="Write the model even if it does not pass its own checks.")
]


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
