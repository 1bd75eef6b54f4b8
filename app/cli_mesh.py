"""`csgmesh mesh`: from a model to a deck."""

from __future__ import annotations

import os
import sys
import time
from typing import Annotated

import typer

from app import texts
from app.cli_arguments import (
    CouplingOption,
    CurveSizeOption,
    FacesOption,
    FormatOption,
    GapOption,
    GrowthOption,
    JsonOption,
    LayersOption,
    MassOption,
    MaterialOfOption,
    MaterialOption,
    ModelArgument,
    OrderOption,
    OverrideOption,
    PerCircleOption,
    RulesOption,
    SeedsOption,
    SizeOfOption,
    SizeOption,
    TeeOption,
    UncheckedOption,
    UnitsOption,
    VolumesOption,
    overrides,
)
from app.output import check_writable, write_files
from kernel.errors import OptionError

EPILOG = "Example: csgmesh mesh bracket.csg -o bracket.bdf --size 8 --override 0.1=brick --report b.html"


def mesh(
    model: ModelArgument,
    output: Annotated[str, typer.Option("--output", "-o", metavar="DECK", help="The deck to write.")],
    deck_format: FormatOption = None,
    size: SizeOption = None,
    size_of: SizeOfOption = None,
    curve_size: CurveSizeOption = None,
    seeds: SeedsOption = None,
    growth: GrowthOption = None,
    per_circle: PerCircleOption = None,
    layers: LayersOption = None,
    order: OrderOption = 1,
    faces: FacesOption = "quad",
    volumes: VolumesOption = "auto",
    units: UnitsOption = None,
    rules: RulesOption = None,
    override: OverrideOption = None,
    material: MaterialOption = None,
    material_of: MaterialOfOption = None,
    coupling: CouplingOption = "distributing",
    tee: TeeOption = "extend",
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
    mass: MassOption = "plain",
    report: Annotated[str | None, typer.Option(metavar="FILE.html", help="Write a report with pictures too.")] = None,
    unchecked: UncheckedOption = False,
    as_json: JsonOption = False,
) -> None:
    """Mesh MODEL and write the deck."""
    start = time.perf_counter()
    from app import pipeline
    from app.materialfile import with_material
    from app.meshoptions import (
        by_name,
        check_coupling_and_mass,
        check_materials,
        check_names,
        read_options,
        split_joints,
    )
    from app.pipeline import units_of
    from app.progress import progress_bar
    from kernel.deck.deck import format_for

    outputs = [output] if report is None else [output, report]
    if len({os.path.realpath(path) for path in outputs}) < len(outputs):
        raise OptionError(f"{output}: the deck and the report are one file, expected two")
    for path in outputs:
        check_writable(path)
    format_for(output, deck_format)
    check_coupling_and_mass(coupling, mass)
    couplings, tees = split_joints(by_name(joint, "--joint", "JOINT=HOW", "j3=rigid"))
    options = read_options(
        size=size,
        order=order,
        faces=faces,
        volumes=volumes,
        size_of=size_of,
        curve_size=curve_size,
        seeds=seeds,
        growth=growth,
        per_circle=per_circle,
        layers=layers,
        tee=tee,
        joint_tees=tees,
    )
    pinned = overrides(override)
    csg, material = with_material(pipeline.read(model), material)
    materials_of = by_name(material_of, "--material-of", "NODE=NAME", "TOP=aluminium")
    check_materials(material, materials_of, csg, units_of(csg, units))
    check_names(options, csg, only=only or (), joints=couplings, materials_of=materials_of)
    with progress_bar() as progress:
        classified = pipeline.classify(csg, overrides=pinned, rules=rules, units=units, gap=gap, progress=progress)
        meshed = pipeline.mesh(
            classified,
            options,
            material=material,
            coupling=coupling,
            joint_couplings=couplings,
            materials_of=materials_of,
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
