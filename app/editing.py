"""Edits of finished meshes, as the command line and the service both take them: validated, then done one by one."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import Field, FiniteFloat, TypeAdapter, ValidationError

from app.schemas import Schema
from kernel.errors import CheckError, CsgmeshError, OptionError

if TYPE_CHECKING:
    from collections.abc import Mapping

    from kernel.connect.checks import Checks
    from kernel.edit.edited import Edited

Progress = Callable[[str, float], None]
PlaceField = tuple[FiniteFloat, FiniteFloat, FiniteFloat]
Length = Annotated[FiniteFloat, Field(gt=0)]

MOST_EDITS = 1000
"""Edits in one request."""

MOST_WORK = 20_000_000
"""Edits of one request times nodes of its meshes: an edit goes over the whole mesh a few times, so that this many take
some seventy seconds (24,000 quads of second order: .26 s each)."""


class MergeEdit(Schema):
    """Lay another mesh beside this one; nothing is joined yet. Segments whose ids are taken get new ones."""

    op: Literal["merge"]
    mesh: str = Field(description="id of the other mesh (on the command line: path of a JSON deck)")


class ConnectEdit(Schema):
    """Make one node of nodes at one place, and tie hanging nodes to the elements on which they lie."""

    op: Literal["connect"]
    tolerance: Length | None = Field(default=None, description="a length; 2e-6 of the model's size by default")
    segments: list[str] | None = Field(default=None, min_length=2, description="only these; all by default")


class AddNodeEdit(Schema):
    """Put a node into the mesh at a place on a beam's axis or a shell's mid-surface."""

    op: Literal["add_node"]
    at: PlaceField
    tolerance: Length | None = Field(default=None, description="how far the node may be moved onto the mesh")


class MoveNodeEdit(Schema):
    """Move the node at one place to another."""

    op: Literal["move_node"]
    at: PlaceField
    to: PlaceField


class DeleteSegmentEdit(Schema):
    """Take a segment out, with its own nodes and the couplings that need them."""

    op: Literal["delete_segment"]
    segment: str


Edit = Annotated[MergeEdit | ConnectEdit | AddNodeEdit | MoveNodeEdit | DeleteSegmentEdit, Field(discriminator="op")]
EDITS: TypeAdapter[list[Edit]] = TypeAdapter(list[Edit])
OPERATIONS = ("merge", "connect", "add_node", "move_node", "delete_segment")


def refuse_too_much(n_edit: int, n_node: int) -> None:
    """OptionError where so many edits of meshes with so many nodes together would take too long for one request."""
    most = max(1, MOST_WORK // n_node)
    if n_edit > most:
        raise OptionError(f"{n_edit} edits of {n_node} nodes, expected at most {most} in one request")


def parse_edits(value: Any) -> list[Edit]:
    """Edits from JSON's own types; OptionError says which one is wrong, and how."""
    try:
        return EDITS.validate_python(value)
    except ValidationError as error:
        raise OptionError(edit_message(error.errors()[0])) from None


def edit_message(wrong: Mapping[str, Any]) -> str:
    """The validator's first finding in our own words; its location starts with the edit's number."""
    location = [part for part in wrong["loc"] if part not in OPERATIONS]
    number = next((int(part) + 1 for part in location if isinstance(part, int)), 1)
    field = ".".join(str(part) for part in location[1:])
    given = wrong.get("input")
    if wrong["type"] in ("union_tag_invalid", "union_tag_not_found"):
        op = given.get("op") if isinstance(given, dict) else given
        return f"edit {number}: op is {op!r}, expected one of {', '.join(OPERATIONS)}"
    if wrong["type"] == "missing":
        return f"edit {number}: {field} is missing"
    if wrong["type"] == "extra_forbidden":
        return f"edit {number}: unknown field {field!r}"
    if wrong["type"] == "model_attributes_type":
        return f"edit {number}: {field or 'it'} is {given!r}, expected an object with op and what it asks for"
    expected = wrong["msg"].replace("Input should be", "").strip()
    return f"edit {number}: {field or 'it'} is {given!r}, expected {expected[:1].lower()}{expected[1:]}"


@dataclass(frozen=True, slots=True, eq=False)
class Subject:
    """A model under edit, and what `mesh --json` said of it: None for a deck, of which nobody knows the segments."""

    edited: Edited
    answer: dict[str, Any] | None = None


def apply_edit(subject: Subject, edit: Edit, fetch: Callable[[str], Subject]) -> Subject:
    """The subject after one edit. fetch: gives the other mesh of a merge."""
    from kernel.edit.connecting import connect_model
    from kernel.edit.inserting import add_node
    from kernel.edit.merging import merge_models
    from kernel.edit.moving import move_node
    from kernel.edit.removing import delete_segment

    edited = subject.edited
    match edit:
        case MergeEdit():
            other = fetch(edit.mesh)
            merged = merge_models(edited, other.edited)
            return Subject(merged.edited, _merged_answer(subject.answer, other.answer, merged.segments))
        case ConnectEdit():
            return replace(subject, edited=connect_model(edited, edit.tolerance, edit.segments))
        case AddNodeEdit():
            return replace(subject, edited=add_node(edited, np.array(edit.at), edit.tolerance))
        case MoveNodeEdit():
            return replace(subject, edited=move_node(edited, np.array(edit.at), np.array(edit.to)))
        case DeleteSegmentEdit():
            return Subject(delete_segment(edited, edit.segment), _answer_without(subject.answer, edit.segment))


def apply_edits(
    subject: Subject, edits: Sequence[Edit], fetch: Callable[[str], Subject], progress: Progress | None = None
) -> Subject:
    """All edits, one after the other; an error says which one it was."""
    for number, edit in enumerate(edits, start=1):
        if progress is not None:
            progress("edit", (number - 1) / len(edits))
        try:
            subject = apply_edit(subject, edit, fetch)
        except CsgmeshError as error:
            told = f"edit {number} ({edit.op}): {error.message}"
            raise type(error)(told if len(edits) > 1 else error.message, place=error.place) from error
    return subject


def _merged_answer(
    one: dict[str, Any] | None, other: dict[str, Any] | None, segments: Mapping[str, str]
) -> dict[str, Any] | None:
    if one is None or other is None:
        return None
    highest = max((int(j["id"][1:]) for j in one["joints"]), default=0)
    joints = [
        {**joint, "id": f"j{highest + number}", "segments": [segments[name] for name in joint["segments"]]}
        for number, joint in enumerate(other["joints"], start=1)
        if set(joint["segments"]) <= set(segments)
    ]
    added = [{**s, "id": segments[s["id"]]} for s in other["segments"] if s["id"] in segments]
    return {
        **one,
        "model": one["model"] if one["model"] == other["model"] else f"{one['model']} + {other['model']}",
        "volume": one["volume"] + other["volume"],
        "segments": [*one["segments"], *added],
        "joints": [*one["joints"], *joints],
    }


def _answer_without(answer: dict[str, Any] | None, segment: str) -> dict[str, Any] | None:
    if answer is None:
        return None
    volume = sum(s["volume"] for s in answer["segments"] if s["id"] == segment)
    return {
        **answer,
        "volume": answer["volume"] - volume,
        "segments": [s for s in answer["segments"] if s["id"] != segment],
        "joints": [joint for joint in answer["joints"] if segment not in joint["segments"]],
    }


def checked(subject: Subject, unchecked: bool) -> tuple[Checks, dict[str, Any]]:
    """All checks and the elements' quality; CheckError where a check fails, unless `unchecked`."""
    from kernel.connect.checks import check_against
    from kernel.mesh.quality import mesh_quality

    quality = mesh_quality(subject.edited.model.mesh)
    checks = check_against(subject.edited.model, subject.edited.reference)
    if checks.failures and not unchecked:
        failures = "; ".join(checks.failures)
        raise CheckError(f"the model does not pass its checks: {failures}; expected all to hold, or `unchecked`")
    return checks, quality


def edited_answer(subject: Subject, checks: Checks, quality: dict[str, Any]) -> dict[str, Any]:
    """What there is to say of an edited mesh: the members of `mesh --json` that follow from the mesh itself."""
    from app.answers import plain
    from kernel.connect.audit import component_segments

    model = subject.edited.model
    warnings = list(model.notes)
    if checks.components > 1:
        parts = " | ".join(" ".join(names) for names in component_segments(model))
        warnings.insert(0, f"the model is in {checks.components} parts that do not touch: {parts}")
    return {
        **(subject.answer or {"model": model.title, "units": model.units}),
        "rule_base": model.rule_base,
        "nodes": model.mesh.n_node,
        "elements": model.mesh.count(),
        "couplings": dict(sorted(Counter(type(c).__name__.lower() for c in model.couplings).items())),
        "components": checks.components,
        "quality": plain(quality),
        "mass": {"solid": checks.solid_mass, "model": checks.model_mass, "error": checks.mass_error},
        "ledger": plain(checks.to_json()["ledger"]),
        "checks": {
            "volume_of_segments": float(subject.edited.reference.solid.mass),
            "mass_error": checks.mass_error,
            **plain(checks.to_json()),
        },
        "warnings": warnings,
        "history": list(subject.edited.history),
    }
