"""`csgmesh mesh`: from a model to a deck."""

from __future__ import annotations

import os
import sys
import time
from typing import Annotated

import typer

from app import texts
from app.cli_arguments import GapOption, JsonOption, ModelArgument, OverrideOption, RulesOption, UnitsOption, overrides
from app.output import check_writable, write_files
from kernel.errors import OptionError

EPILOG = "Example: csgmesh mesh bracket.csg -o bracket.bdf --size 8 --override 0.1=brick --report b.html"

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


def mesh(
    model: ModelArgument,
    output: Annotated[str, typer.Option("--output", "-o", metavar="DECK", help="The deck to write.")],
    deck_format: Annotated[str | None, typer.Option("--format", help=FORMATS_HELP)] = None,
    size: Annotated[
        float | None, typer.Option(help="Target length of an element's edge; automatic by default.")
    ] = None,
    size_of: Annotated[
        list[str] | None,
        typer.Option(metavar="NODE=SIZE", help="Size of one node or segment, as TOP=20; the deepest node wins."),
    ] = None,
    curve_size: Annotated[
        list[str] | None,
        typer.Option(metavar="CURVES=SIZE", help=f"Longest element along some curves, as HOLE=2. {CURVES_HELP}"),
    ] = None,
    seeds: Annotated[
        list[str] | None,
        typer.Option(metavar="CURVES=COUNT", help="Exactly so many elements on each of them, as TOP&LEG=8."),
    ] = None,
    growth: Annotated[
        float | None, typer.Option(help="Most that an element may be longer than its neighbour, as 1.2.")
    ] = None,
    per_circle: Annotated[int | None, typer.Option(help="Fewest elements round a full circle.")] = None,
    layers: Annotated[
        int | None, typer.Option(help="Fewest elements through a brick and across the walls of its section.")
    ] = None,
    order: Annotated[int, typer.Option(help="1: corner nodes only, 2: mid-side nodes too.")] = 1,
    faces: Annotated[str, typer.Option(help="Shells of: quad, tri.")] = "quad",
    volumes: Annotated[
        str,
        typer.Option(
            help="Bricks of: auto (hexes where they can be swept or turned, else tets), hex (or refuse), tet."
        ),
    ] = "auto",
    units: UnitsOption = None,
    rules: RulesOption = None,
    override: OverrideOption = None,
    material: Annotated[str | None, typer.Option(metavar="NAME|FILE", help=MATERIAL_HELP)] = None,
    material_of: Annotated[
        list[str] | None, typer.Option(metavar="NODE=NAME", help="Material of one node or segment, as TOP=aluminium.")
    ] = None,
    coupling: Annotated[str, typer.Option(help=COUPLING_HELP)] = "distributing",
    tee: Annotated[str, typer.Option(help=TEE_HELP)] = "extend",
    gap: GapOption = 0.0,
    joint: Annotated[
        list[str] | None,
        typer.Option(
            metavar="JOINT=HOW",
            help="Coupling or tee of one joint, as j3=rigid or j4=arms; j5=apart for no joint at all.",
        ),
    ] = None,
    apart: Annotated[
        bool, typer.Option("--apart", help="Mesh every segment apart: nothing is shared or coupled (see connect).")
    ] = False,
    only: Annotated[
        list[str] | None, typer.Option(metavar="NODE", help="Mesh this node or segment alone; may be repeated.")
    ] = None,
    mass: Annotated[str, typer.Option(help="plain: densities as given; exact: scaled to the solid's mass.")] = "plain",
    report: Annotated[str | None, typer.Option(metavar="FILE.html", help="Write a report with pictures too.")] = None,
    unchecked: Annotated[
        bool, typer.Option("--unchecked", help="Write the model even if it does not pass its own checks.")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Mesh MODEL and write the deck."""
    start = time.perf_counter()
    from app import pipeline
    from app.materialfile import with_material
    from app.meshoptions import by_name, check_names, counts, lengths, split_joints
    from app.pipeline import units_of
    from app.progress import progress_bar
    from kernel.connect.build import MASSES
    from kernel.connect.couplings import COUPLINGS
    from kernel.deck.deck import format_for
    from kernel.materials import choose_material
    from kernel.mesh.options import MeshOptions

    outputs = [output] if report is None else [output, report]
    if len({os.path.realpath(path) for path in outputs}) < len(outputs):
        raise OptionError(f"{output}: the deck and the report are one file, expected two")
    for path in outputs:
        check_writable(path)
    format_for(output, deck_format)
    if coupling not in COUPLINGS:
        raise OptionError(f"unknown coupling {coupling!r}, expected one of {', '.join(COUPLINGS)}")
    couplings, tees = split_joints(by_name(joint, "--joint", "JOINT=HOW", "j3=rigid"))
    if mass not in MASSES:
        raise OptionError(f"unknown mass {mass!r}, expected one of {', '.join(MASSES)}")
    options = MeshOptions(
        size=size,
        order=order,
        faces=faces,
        volumes=volumes,
        sizes=lengths(size_of, "--size-of", "NODE=SIZE", "TOP=20"),
        curve_sizes=lengths(curve_size, "--curve-size", "CURVES=SIZE", "HOLE=2"),
        seeds=counts(seeds, "--seeds", "CURVES=COUNT", "TOP&LEG=8"),
        growth=growth,
        per_circle=per_circle,
        layers=layers,
        tee=tee,
        joint_tees=tees,
    )
    pinned = overrides(override)
    csg, material = with_material(pipeline.read(model), material)
    choose_material(material, csg, units_of(csg, units))
    check_names(options, csg, only=only or (), joints=couplings)
    with progress_bar() as progress:
        classified = pipeline.classify(csg, overrides=pinned, rules=rules, units=units, gap=gap, progress=progress)
        meshed = pipeline.mesh(
            classified,
            options,
            material=material,
            coupling=coupling,
            joint_couplings=couplings,
            materials_of=by_name(material_of, "--material-of", "NODE=NAME", "TOP=aluminium"),
            mass=mass,
            apart=apart,
            only=only or (),
            progress=progress,
        )
        if not unchecked:
            pipeline.refuse_failed(meshed)
        contents = {output: pipeline.write_deck(meshed, output, deck_format)}
        if report is not None:
            from app.report.page import report_page

            contents[report] = report_page(meshed).encode()
    write_files(contents)
    from app.answers import meshed_answer

    answer = meshed_answer(meshed)
    for warning in (*(f"check failed: {failure}" for failure in meshed.checks.failures), *meshed.warnings):
        sys.stderr.write(f"warning: {warning}\n")
    seconds = time.perf_counter() - start
    segments = [each.segment for each in meshed.model.properties]
    texts.show(answer.model_dump_json(indent=1) if as_json else texts.mesh_text(answer, output, segments, seconds))
