"""`csgmesh merge`, `connect` and `edit`: finished meshes joined and changed by hand, over JSON decks.

JSON is the form that loses nothing (kernel/deck/jsonread.py); the result is written in any format.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from app import texts
from app.cli_arguments import JsonOption
from app.output import check_writable, write_files
from kernel.errors import OptionError

if TYPE_CHECKING:
    from app.editing import Subject

app = typer.Typer()

OutputOption = Annotated[str, typer.Option("--output", "-o", metavar="DECK", help="The deck to write, any format.")]
FormatOption = Annotated[str | None, typer.Option("--format", help="Instead of what DECK's ending means.")]
UncheckedOption = Annotated[
    bool, typer.Option("--unchecked", help="Write the model even if it does not pass its own checks.")
]
DeckArgument = Annotated[str, typer.Argument(metavar="DECK", help="A JSON deck (csgmesh mesh MODEL -o DECK.json).")]


@app.command(epilog="Example: csgmesh merge left.json right.json -o both.json")
def merge(
    decks: Annotated[list[str], typer.Argument(metavar="DECK...", help="JSON decks, two or more.")],
    output: OutputOption,
    deck_format: FormatOption = None,
    unchecked: UncheckedOption = False,
    as_json: JsonOption = False,
) -> None:
    """Lay the meshes of several decks beside each other in one; nothing is joined yet."""
    if len(decks) < 2:
        raise OptionError(f"merge {decks[0]}: one deck, expected two or more")
    _edit(decks[0], [{"op": "merge", "mesh": deck} for deck in decks[1:]], output, deck_format, unchecked, as_json)


@app.command(epilog="Example: csgmesh connect both.json -o model.bdf --tolerance 0.01")
def connect(
    deck: DeckArgument,
    output: OutputOption,
    tolerance: Annotated[
        float | None, typer.Option(help="Nodes nearer than this become one; 2e-6 of the model's size by default.")
    ] = None,
    segment: Annotated[
        list[str] | None, typer.Option(metavar="ID", help="Connect these segments only; may be repeated.")
    ] = None,
    deck_format: FormatOption = None,
    unchecked: UncheckedOption = False,
    as_json: JsonOption = False,
) -> None:
    """Join the segments of a deck where they touch: common nodes made one, hanging nodes tied to elements."""
    edit: dict[str, Any] = {"op": "connect", "tolerance": tolerance, "segments": segment or None}
    _edit(deck, [edit], output, deck_format, unchecked, as_json)


@app.command(epilog="Example: csgmesh edit model.json -o edited.json add_node=120,40,2.5 delete_segment=s3")
def edit(
    deck: DeckArgument,
    edits: Annotated[
        list[str],
        typer.Argument(
            metavar="EDIT...",
            help="In this order: add_node=X,Y,Z  move_node=X,Y,Z:X,Y,Z  delete_segment=ID  merge=DECK  connect or "
            "connect=TOLERANCE  or the path of a JSON file with a list of edits as the service takes them.",
        ),
    ],
    output: OutputOption,
    deck_format: FormatOption = None,
    unchecked: UncheckedOption = False,
    as_json: JsonOption = False,
) -> None:
    """Add nodes, move them, delete segments, merge and connect, one after the other."""
    wanted = [parsed for text in edits for parsed in _parsed(text)]
    _edit(deck, wanted, output, deck_format, unchecked, as_json)


def _edit(
    deck: str, wanted: list[dict[str, Any]], output: str, deck_format: str | None, unchecked: bool, as_json: bool
) -> None:
    from app.editing import apply_edits, checked, edited_answer, parse_edits
    from app.progress import progress_bar
    from kernel.deck.deck import format_for

    check_writable(output)
    chosen = format_for(output, deck_format)
    parsed = parse_edits(wanted)
    with progress_bar() as progress:
        subject = apply_edits(_read(deck), parsed, _read, progress)
        checks, quality = checked(subject, unchecked)
        write_files({output: chosen.write(subject.edited.model)})
    answer = edited_answer(subject, checks, quality)
    for warning in [*(f"check failed: {failure}" for failure in checks.failures), *answer["warnings"]]:
        if not warning.startswith("edited: "):
            sys.stderr.write(f"warning: {warning}\n")
    texts.show(texts.as_json(answer) if as_json else texts.edited_text(answer, output))


def _read(path: str) -> Subject:
    from app.editing import Subject
    from kernel.deck.jsonread import read_json_deck
    from kernel.edit.edited import Edited

    if not path.lower().endswith(".json"):
        raise OptionError(f"{path}: cannot be edited, expected a JSON deck, such as csgmesh mesh MODEL -o DECK.json")
    return Subject(Edited.of(read_json_deck(_bytes(path), path)))


def _bytes(path: str) -> bytes:
    try:
        return Path(path).read_bytes()
    except OSError as error:
        raise OptionError(f"{path}: cannot be read, {(error.strerror or str(error)).lower()}") from error


def _parsed(text: str) -> list[dict[str, Any]]:
    """The edits that one word of the command line stands for."""
    name, equals, value = text.partition("=")
    if not equals and name.lower().endswith(".json"):
        try:
            read = json.loads(_bytes(name))
        except (ValueError, RecursionError) as error:
            raise OptionError(f"{name}: is no JSON: {error}") from None
        return read if isinstance(read, list) else [read]
    match name, equals:
        case "add_node", "=":
            return [{"op": name, "at": _place(text, value)}]
        case "move_node", "=":
            at, colon, to = value.partition(":")
            if not colon:
                raise OptionError(f"{text}: expected move_node=X,Y,Z:X,Y,Z")
            return [{"op": name, "at": _place(text, at), "to": _place(text, to)}]
        case "delete_segment", "=":
            return [{"op": name, "segment": value}]
        case "merge", "=":
            return [{"op": name, "mesh": value}]
        case "connect", "":
            return [{"op": name}]
        case "connect", "=":
            return [{"op": name, "tolerance": _number(text, value)}]
    raise OptionError(
        f"{text}: expected add_node=X,Y,Z, move_node=X,Y,Z:X,Y,Z, delete_segment=ID, merge=DECK, connect or a JSON file"
    )


def _place(text: str, value: str) -> list[float]:
    numbers = [_number(text, word) for word in value.split(",")]
    if len(numbers) != 3:
        raise OptionError(f"{text}: {value!r} is {len(numbers)} numbers, expected three, as 10,20,0")
    return numbers


def _number(text: str, word: str) -> float:
    try:
        return float(word)
    except ValueError:
        raise OptionError(f"{text}: {word!r} is wrong, expected a number") from None
