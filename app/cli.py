"""The command line. `main` is the console script; every command is a few lines over app/pipeline.py.

Imports here are late on purpose: `csgmesh tree` must not wait for numba, pydantic or the service's libraries.
"""

from __future__ import annotations

import os
import re
import signal
import sys
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from app import cli_rules, texts
from app.output import check_writable, write_files
from kernel.errors import CsgmeshError, OptionError

if TYPE_CHECKING:
    from app.pipeline import Classified
    from kernel.csg.tree import CsgModel
    from kernel.plan import Override

USAGE_STATUS = 2
PIPE_STATUS = 128 + getattr(signal, "SIGPIPE", 13)  # Windows has no such signal
ALL_NODES = "*"
"""What `--explain` means without a node."""

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
COUPLING_HELP = (
    "Where dimensions change: distributing (RBE3: a beam's end moves as the average of its patch), rigid (RBE2: the "
    "patch moves as the beam's end does), work (equations: forces do the same work on both sides)."
)

app = typer.Typer(
    name="csgmesh",
    help="CSG solids to connected finite element models of beams, plates, cylinder-plates and bricks, by rules.",
    no_args_is_help=False,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
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
JsonOption = Annotated[bool, typer.Option("--json", help="Print JSON instead of text.")]


@app.callback(invoke_without_command=True)
def root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False,
) -> None:
    """Options of csgmesh itself."""
    if version:
        from importlib.metadata import version as version_of

        typer.echo(f"csgmesh {version_of('csgmesh')}")
    elif context.invoked_subcommand is None:
        typer.echo(context.get_help())


@app.command(epilog="Example: csgmesh mesh bracket.csg -o bracket.bdf --size 8 --override 0.1=brick --report b.html")
def mesh(
    model: ModelArgument,
    output: Annotated[str, typer.Option("--output", "-o", metavar="DECK", help="The deck to write.")],
    deck_format: Annotated[str | None, typer.Option("--format", help=FORMATS_HELP)] = None,
    size: Annotated[
        float | None, typer.Option(help="Target length of an element's edge; automatic by default.")
    ] = None,
    order: Annotated[int, typer.Option(help="1: corner nodes only, 2: mid-side nodes too.")] = 1,
    faces: Annotated[str, typer.Option(help="Shells of: quad, tri.")] = "quad",
    volumes: Annotated[
        str, typer.Option(help="Bricks of: auto (hexes where they can be swept, else tets), hex (or refuse), tet.")
    ] = "auto",
    units: UnitsOption = None,
    rules: RulesOption = None,
    override: OverrideOption = None,
    material: Annotated[str | None, typer.Option(metavar="NAME|FILE", help=MATERIAL_HELP)] = None,
    material_of: Annotated[
        list[str] | None, typer.Option(metavar="NODE=NAME", help="Material of one node or segment, as TOP=aluminium.")
    ] = None,
    coupling: Annotated[str, typer.Option(help=COUPLING_HELP)] = "distributing",
    joint: Annotated[
        list[str] | None, typer.Option(metavar="JOINT=COUPLING", help="Coupling of one joint, as j3=rigid.")
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
    by_joint = _by_name(joint, "--joint", "JOINT=COUPLING", "j3=rigid")
    for name in (coupling, *by_joint.values()):
        if name not in COUPLINGS:
            raise OptionError(f"unknown coupling {name!r}, expected one of {', '.join(COUPLINGS)}")
    if mass not in MASSES:
        raise OptionError(f"unknown mass {mass!r}, expected one of {', '.join(MASSES)}")
    options = MeshOptions(size=size, order=order, faces=faces, volumes=volumes)
    pinned = _overrides(override)
    csg, material = with_material(pipeline.read(model), material)
    choose_material(material, csg, units_of(csg, units))
    with progress_bar() as progress:
        classified = pipeline.classify(csg, overrides=pinned, rules=rules, units=units, progress=progress)
        meshed = pipeline.mesh(
            classified,
            options,
            material=material,
            coupling=coupling,
            joint_couplings=by_joint,
            materials_of=_by_name(material_of, "--material-of", "NODE=NAME", "TOP=aluminium"),
            mass=mass,
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
    _print(answer.model_dump_json(indent=1) if as_json else texts.mesh_text(answer, output, seconds))


@app.command(epilog="Example: csgmesh classify bracket.csg --explain 0.1")
def classify(
    model: ModelArgument,
    rules: RulesOption = None,
    override: OverrideOption = None,
    explain: Annotated[
        str | None, typer.Option(metavar="[NODE]", help="Facts, rules and rejected alternatives, of NODE or of all.")
    ] = None,
    units: UnitsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Show the segments of MODEL, and why each is what it is."""
    classified = _classified(model, rules, override, units)
    if explain is not None:
        node = None if explain == ALL_NODES else explain
        explain_as = texts.explanation_text if not as_json else lambda *about: texts.as_json(texts.explanation(*about))
        _print(explain_as(classified, node))
        return
    if as_json:
        from app.answers import classification

        _print(classification(classified).model_dump_json(indent=1))
    else:
        _print(texts.classification_text(classified))


@app.command(epilog="Example: csgmesh tree bracket.csg")
def tree(model: ModelArgument, as_json: JsonOption = False) -> None:
    """Show the CSG tree of MODEL."""
    csg = _read(model)
    if as_json:
        from kernel.csg.treejson import tree_to_json

        _print(texts.as_json(tree_to_json(csg)))
    else:
        _print(texts.tree_text(csg))


@app.command(epilog="Example: csgmesh evaluate bracket.csg -o bracket.stl")
def evaluate(
    model: ModelArgument,
    output: Annotated[str, typer.Option("--output", "-o", metavar="SOLID", help="stl, glb, 3mf or ply.")],
    units: UnitsOption = None,
    as_json: JsonOption = False,
) -> None:
    """Write the solid of MODEL as a surface of triangles."""
    from app.pipeline import units_of
    from kernel.solid.evaluate import evaluate as evaluate_solid
    from kernel.solid.export import ending_of, solid_bytes

    ending = ending_of(output)
    check_writable(output)
    csg = _read(model)
    unit_name = units_of(csg, units).name
    evaluated = evaluate_solid(csg)
    write_files({output: solid_bytes(evaluated, ending)})
    from app.answers import solid_answer

    answer = solid_answer(csg, evaluated, unit_name)
    _print(answer.model_dump_json(indent=1) if as_json else texts.solid_text(answer, output))


@app.command(epilog="Example: csgmesh quality bracket.bdf --json")
def quality(
    deck: Annotated[
        str,
        typer.Argument(
            metavar="DECK", help="A NASTRAN (.bdf .nas .dat), Gmsh 4.1, VTU, CalculiX or Abaqus (.inp) or .cdb file."
        ),
    ],
    as_json: JsonOption = False,
) -> None:
    """Measure the elements of a deck."""
    from app.decks import read_deck
    from kernel.mesh.quality import mesh_quality

    elements = read_deck(deck)
    measured = mesh_quality(elements, allow_inverted=True)
    if as_json:
        answer = {"deck": deck, "nodes": elements.n_node, "elements": elements.count(), "quality": measured}
        _print(texts.as_json(answer))
    else:
        _print("\n".join([f"{deck}: {texts.plural(elements.n_node, 'node')}", *texts.quality_lines(measured)]))


app.add_typer(cli_rules.app)


@app.command(epilog="Example: csgmesh serve --port 8931 --data ~/csgmesh")
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen at; 127.0.0.1 by default.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen at; 8000 by default.")] = None,
    data: Annotated[str | None, typer.Option(metavar="FOLDER", help="Where models and meshes are kept.")] = None,
    database: Annotated[str | None, typer.Option(metavar="URL", help="SQLAlchemy URL; SQLite in FOLDER.")] = None,
) -> None:
    """Serve the same pipeline over HTTP, with a web page."""
    from app.api.server import run_server
    from app.settings import load_settings

    run_server(load_settings(host=host, port=port, data=data, database=database))


def main() -> None:
    """The console script."""
    signal.signal(signal.SIGTERM, _stop)
    sys.exit(run(sys.argv[1:]))


def run(arguments: Sequence[str]) -> int:
    """Run one command; gives the exit status. Every failure is one line on standard error."""
    # the bases of typer's own errors are click's, which some versions of typer bring along under another name
    usage_error = next(base for base in typer.BadParameter.__mro__ if base.__name__ == "ClickException")
    try:
        status = app(_with_explain(arguments), prog_name="csgmesh", standalone_mode=False)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return PIPE_STATUS
    except CsgmeshError as error:
        return _fail(f"defect: {error}" if error.exit_status == 1 else str(error), error.exit_status)
    except usage_error as error:  # type: ignore[misc]
        from app.usage import usage_message

        return _fail(usage_message(error, arguments), USAGE_STATUS)
    except (typer.Abort, KeyboardInterrupt):
        return _fail("interrupted", 130)
    except Exception as error:  # noqa: BLE001  the edge of the program: a defect is one line too, its traceback in a file
        return _defect(error)
    return status if isinstance(status, int) else 0


def _defect(error: Exception) -> int:
    from app.logs import record_defect

    if os.environ.get("CSGMESH_DEBUG"):
        import traceback

        traceback.print_exception(error)
    path = record_defect(error)
    where = f" (traceback in {path})" if path else ""
    return _fail(f"defect: {type(error).__name__}: {error}{where}", 1)


def _fail(message: str, status: int) -> int:
    sys.stderr.write(f"error: {' '.join(message.split())}\n")
    return status


def _stop(_signal: int, _frame: object) -> NoReturn:
    """SIGTERM as an exception, so that temporary files and child processes go too."""
    raise SystemExit(128 + signal.SIGTERM)


def _with_explain(arguments: Sequence[str]) -> list[str]:
    """`--explain` without a node, which typer cannot express, as `--explain *`."""
    given = list(arguments)
    for index, argument in enumerate(given):
        following = given[index + 1 : index + 2]
        if argument == "--explain" and (not following or following[0].startswith("-")):
            given[index] = f"--explain={ALL_NODES}"
    return given


def _print(text: str) -> None:
    sys.stdout.write(text.rstrip("\n") + "\n")


def _read(model: str) -> CsgModel:
    from app import pipeline

    return pipeline.read(model)


def _classified(model: str, rules: str | None, override: list[str] | None, units: str | None) -> Classified:
    from app import pipeline

    pinned = _overrides(override)
    return pipeline.classify(pipeline.read(model), overrides=pinned, rules=rules, units=units)


def _overrides(texts_given: list[str] | None) -> dict[str, Override]:
    """NODE=TYPE or NODE=TYPE:REASON by node; OptionError where one is written otherwise or a node stands twice."""
    from kernel.plan import Override

    overrides: dict[str, Override] = {}
    for text in texts_given or []:
        written = re.fullmatch(r"(.+?)=([^=:]+)(?::(.*))?", text, re.DOTALL)
        if written is None:
            raise OptionError(f"--override {text!r}: expected NODE=TYPE or NODE=TYPE:REASON, such as 0.1=brick")
        node, kind, reason = written.groups()
        if node in overrides:
            raise OptionError(f"--override {text!r}: node {node} is overridden twice, expected once")
        overrides[node] = Override(kind, reason=(reason or "").strip())
    return overrides


def _by_name(texts_given: list[str] | None, option: str, form: str, example: str) -> dict[str, str]:
    """NAME=VALUE by name; OptionError where one is written otherwise or a name stands twice."""
    found: dict[str, str] = {}
    for text in texts_given or []:
        name, equals, value = text.rpartition("=")
        if not equals or not name or not value:
            raise OptionError(f"{option} {text!r}: expected {form}, such as {example}")
        if name in found:
            raise OptionError(f"{option} {text!r}: {name} is given twice, expected once")
        found[name] = value
    return found
