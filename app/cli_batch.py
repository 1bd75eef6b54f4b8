"""`csgmesh batch`: from many models to a folder of decks."""

from __future__ import annotations

import os
import sys
import tempfile
from contextlib import AbstractContextManager, closing
from pathlib import Path
from typing import Annotated

import typer

from app import texts
from app.cli_arguments import (
    CouplingOption,
    CurveSizeOption,
    FacesOption,
    GapOption,
    GrowthOption,
    JsonOption,
    LayersOption,
    MassOption,
    MaterialOfOption,
    MaterialOption,
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
from kernel.errors import OptionError

EPILOG = "Example: csgmesh batch parts/*.csg -o decks --size 5 --resume"


def batch(
    models: Annotated[list[str], typer.Argument(metavar="MODEL...", help="Files as `csgmesh mesh` reads them.")],
    output: Annotated[
        str, typer.Option("--output", "-o", metavar="FOLDER", help="Where the decks go; made where there is none.")
    ],
    deck_format: Annotated[
        str, typer.Option("--format", help="Of all decks: nastran, or another that `csgmesh mesh` writes.")
    ] = "nastran",
    resume: Annotated[
        bool, typer.Option("--resume", help="Leave what an earlier run did with the same model, options and csgmesh.")
    ] = False,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Models meshed at once on this machine; one a processor by default.")
    ] = None,
    scheduler: Annotated[
        str | None,
        typer.Option(metavar="ADDRESS", help="A dask scheduler whose workers do it, as tcp://host:8786."),
    ] = None,
    report: Annotated[bool, typer.Option("--report", help="Write a report with pictures beside each deck.")] = False,
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
    mass: MassOption = "plain",
    unchecked: UncheckedOption = False,
    as_json: JsonOption = False,
) -> int:
    """Mesh every MODEL and write the decks to FOLDER; what fails is told, and stops no other.

    What became of each stands in FOLDER/batch.jsonl. The exit status is 0 where all are meshed.
    """
    from app.batch import exit_status, local_doers, open_folder, plan, run
    from app.materialfile import asked_material
    from app.meshoptions import asked, by_name, check_coupling_and_mass, read_options
    from kernel.deck.deck import format_for
    from rules.engine import load_rule_base

    if scheduler is not None and workers is not None:
        raise OptionError("--workers is of this machine and --scheduler of others, expected one of them")
    check_coupling_and_mass(coupling, mass)
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
    )
    material, materials = asked_material(material)
    pinned = [
        {"node": node, "type": one.type, "author": one.author, "reason": one.reason}
        for node, one in overrides(override).items()
    ]
    request = {
        "format": deck_format,
        "report": report,
        "options": asked(options),
        "units": units,
        "rules": None if rules is None else load_rule_base(rules),
        "overrides": pinned,
        "material": material,
        "materials": materials,
        "materials_of": by_name(material_of, "--material-of", "NODE=NAME", "TOP=aluminium"),
        "coupling": coupling,
        "gap": gap,
        "mass": mass,
        "unchecked": unchecked,
    }
    written = format_for("", deck_format)
    tasks = plan(models, request, written.endings[0] if written.endings else ".inp")
    folder = open_folder(output)
    records = []
    with tempfile.TemporaryDirectory(prefix="csgmesh-batch-") as scratch:
        doers: AbstractContextManager
        if scheduler is None:
            doers = local_doers(min(workers or os.cpu_count() or 1, len(tasks)), Path(scratch))
        else:
            from app.cluster import cluster_doers

            doers = cluster_doers(scheduler, len(tasks))
        with doers as those, closing(run(tasks, folder, those, resume=resume)) as ended:
            for record in ended:
                records.append(record)
                _tell(record, output, as_json)
    if as_json:
        texts.show(texts.as_json(records))
    else:
        texts.show(texts.batch_text(records))
    return exit_status(records)


def _tell(record: dict, folder: str, as_json: bool) -> None:
    """What became of one model, as soon as all before it are told of."""
    if record["status"] == "failed":
        sys.stderr.write(f"error: {texts.of_model(record['problem']['message'], record['model'])}\n")
        sys.stderr.flush()
        return
    for warning in record["warnings"]:
        sys.stderr.write(f"warning: {record['model']}: {warning}\n")
    if not as_json:
        texts.show(texts.record_text(record, folder))
