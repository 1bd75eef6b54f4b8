"""The command line. `main` is the console script; every command is a few lines over app/pipeline.py.

Imports here are late on purpose: `csgmesh tree` must not wait for numba, pydantic or the service's libraries.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, NoReturn

import typer

from app import cli_batch, cli_edits, cli_mesh, cli_rules, cli_token, texts
from app.cli_arguments import GapOption, JsonOption, ModelArgument, OverrideOption, RulesOption, UnitsOption, overrides
from app.collector import collect_rarely
from app.output import check_writable, write_files
from kernel.errors import CsgmeshError
from kernel.numeric.notice import when_compiling

if TYPE_CHECKING:
    from app.pipeline import Classified
    from kernel.csg.tree import CsgModel

USAGE_STATUS = 2
PIPE_STATUS = 128 + getattr(signal, "SIGPIPE", 13)  # Windows has no such signal
ALL_NODES = "*"
"""What `--explain` means without a node."""

app = typer.Typer(
    name="csgmesh",
    help="CSG solids to connected finite element models of beams, plates, cylinder-plates and bricks, by rules.",
    no_args_is_help=False,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
)


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


app.command(epilog=cli_mesh.EPILOG)(cli_mesh.mesh)
app.command(epilog=cli_batch.EPILOG)(cli_batch.batch)


@app.command(epilog="Example: csgmesh classify bracket.csg --explain 0.1")
def classify(
    model: ModelArgument,
    rules: RulesOption = None,
    override: OverrideOption = None,
    explain: Annotated[
        str | None, typer.Option(metavar="[NODE]", help="Facts, rules and rejected alternatives, of NODE or of all.")
    ] = None,
    units: UnitsOption = None,
    gap: GapOption = 0.0,
    as_json: JsonOption = False,
) -> None:
    """Show the segments of MODEL, and why each is what it is."""
    classified = _classified(model, rules, override, units, gap)
    if explain is not None:
        node = None if explain == ALL_NODES else explain
        explain_as = texts.explanation_text if not as_json else lambda *about: texts.as_json(texts.explanation(*about))
        texts.show(explain_as(classified, node))
        return
    if as_json:
        from app.answers import classification

        texts.show(classification(classified).model_dump_json(indent=1))
    else:
        texts.show(texts.classification_text(classified))


@app.command(epilog="Example: csgmesh tree bracket.csg")
def tree(model: ModelArgument, as_json: JsonOption = False) -> None:
    """Show the CSG tree of MODEL."""
    csg = _read(model)
    if as_json:
        from kernel.csg.treejson import tree_to_json

        texts.show(texts.as_json(tree_to_json(csg)))
    else:
        texts.show(texts.tree_text(csg))


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
    texts.show(answer.model_dump_json(indent=1) if as_json else texts.solid_text(answer, output))


@app.command(epilog="Example: csgmesh quality bracket.bdf --json")
def quality(
    deck: Annotated[
        str,
        typer.Argument(
            metavar="DECK",
            help="A NASTRAN (.bdf .nas .dat), Gmsh 4.1, VTU, CalculiX or Abaqus (.inp), .cdb or JSON deck.",
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
        texts.show(texts.as_json(answer))
    else:
        texts.show("\n".join([f"{deck}: {texts.plural(elements.n_node, 'node')}", *texts.quality_lines(measured)]))


app.add_typer(cli_edits.app)
app.add_typer(cli_rules.app)
app.add_typer(cli_token.app)


@app.command(epilog="Example: csgmesh serve --port 8931 --data ~/csgmesh")
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen at; 127.0.0.1 by default.")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen at; 8000 by default.")] = None,
    data: Annotated[str | None, typer.Option(metavar="FOLDER", help="Where models and meshes are kept.")] = None,
    database: Annotated[str | None, typer.Option(metavar="URL", help="SQLAlchemy URL; SQLite in FOLDER.")] = None,
    scheduler: Annotated[
        str | None, typer.Option(metavar="ADDRESS", help="A dask scheduler whose workers mesh, as tcp://host:8786.")
    ] = None,
) -> None:
    """Serve the same pipeline over HTTP, with a web page."""
    from app.api.server import run_server
    from app.settings import load_settings

    run_server(load_settings(host=host, port=port, data=data, database=database, scheduler=scheduler))


def main() -> None:
    """The console script."""
    signal.signal(signal.SIGTERM, _stop)
    when_compiling(_say_compiling)
    collect_rarely()
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


def _say_compiling() -> None:
    sys.stderr.write("compiling the meshers' kernels, once on this machine: up to half a minute\n")
    sys.stderr.flush()


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


def _read(model: str) -> CsgModel:
    from app import pipeline

    return pipeline.read(model)


def _classified(
    model: str, rules: str | None, override: list[str] | None, units: str | None, gap: float = 0.0
) -> Classified:
    from app import pipeline

    pinned = overrides(override)
    return pipeline.classify(pipeline.read(model), overrides=pinned, rules=rules, units=units, gap=gap)


if __name__ == "__main__":  # `python -m app.cli` does what the console script does
    main()
