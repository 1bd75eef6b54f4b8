"""What the commands print for people: plain text, a table where there are rows."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

from kernel.errors import OverrideError

if TYPE_CHECKING:
    from app.pipeline import Classified
    from app.schemas import MeshAnswer, SolidAnswer
    from kernel.csg.tree import CsgModel, CsgNode
    from kernel.idealise.section import SectionProperties
    from kernel.plan import Decision
    from kernel.segment.segments import Segment

MEASURES = {
    "block": ("size",),
    "wedge": ("size",),
    "cylinder": ("radius", "height"),
    "cone": ("bottom_radius", "top_radius", "height"),
    "sphere": ("radius",),
    "torus": ("major_radius", "minor_radius"),
    "extrusion": ("height",),
    "revolution": ("angle",),
}
"""Fields of a primitive that the tree shows."""

SHOWN_SHARE = 5e-5
"""A share of the mass below this is nought in two digits of per cent."""

MOST_SIZES = 6
"""Segments with a size of their own that are told of in a text; JSON and the report have them all."""

NOUGHT = 1e-12
"""A measure of an element smaller than this is rounding."""

REVIEW_MARGIN = 0.05
"""A decision nearer than this to a threshold is marked for review."""


def as_json(value: Any) -> str:
    """Indented JSON."""
    return json.dumps(value, indent=1, ensure_ascii=False)


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Left-justified columns, two blanks apart."""
    widths = [max(len(row[k]) for row in [head, *rows]) for k in range(len(head))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths)).rstrip() for row in [head, *rows]]
    return "\n".join(lines)


def tree_text(csg: CsgModel) -> str:
    """One node a line, indented by depth: path, name, kind, its sizes."""
    from kernel.csg.tree import walk

    lines = []
    for path, node in walk(csg.root):
        depth = 0 if path == "/" else path.count(".") + 1
        name = f" {node.name}" if node.name else ""
        lines.append(f"{'  ' * depth}{path}{name} {node.kind}{_measures(node)}")
    return "\n".join(lines)


def classification_text(classified: Classified) -> str:
    """One segment a line, then the joints."""
    unit = classified.units.length
    rows = []
    for segment in classified.partition.segments:
        measure = _measures_of(segment)
        node = f"{segment.node} {segment.name}" if segment.name else segment.node
        because = segment.decision.by_rule.because
        if segment.origin == "override":
            because = f"{_origin(segment.decision)}: {because}"
        elif needs_review(segment.decision):
            because += " (near the limit)"
        rows.append((segment.id, node, segment.type, number(segment.volume), measure, because))
    volume = classified.evaluated.solid.true_volume
    lines = [
        f"{os.path.basename(classified.csg.source)}: {plural(len(rows), 'segment')}, volume {number(volume)} {unit}^3, "
        f"all in {unit}",
        table(("segment", "node", "type", "volume", "measures", "because"), rows),
    ]
    if classified.joints:
        joints = [(j.id, j.kind, " ".join(j.segments), number(j.area)) for j in classified.joints]
        lines += ["", table(("joint", "kind", "segments", "area"), joints)]
    return "\n".join(lines)


def explanation(classified: Classified, node: str | None) -> dict[str, Any]:
    """Every decision with its facts; of one `node` (path or name) and its pieces also every rule, with its numbers.

    OverrideError: there is no such node, or it was not decided about.
    """
    decisions: Sequence[Decision] = classified.partition.plan.decisions
    if node is None:
        return {
            "model": os.path.basename(classified.csg.source),
            "decisions": [_explained(decision) for decision in decisions],
        }
    explain = classified.rule_base.explain
    kept = ("nearest", "rules")
    decided = [
        {**_explained(d), **{name: item for name, item in explain(d.facts).to_json().items() if name in kept}}
        for d in _about(classified, node)
    ]
    return {"model": os.path.basename(classified.csg.source), "decisions": decided}


def explanation_text(classified: Classified, node: str | None) -> str:
    """The same for people."""
    lines = []
    for decision in classified.partition.plan.decisions if node is None else _about(classified, node):
        lines.append(f"{decision.node}: {decision.type} ({_origin(decision)})")
        if node is not None:
            lines += [f"  {line}" for line in classified.rule_base.explain(decision.facts).to_text().splitlines()]
            continue
        by_rule = decision.by_rule
        lines.append(f"  rule {by_rule.rule}, certainty {by_rule.certainty:g}: {by_rule.because}")
        if needs_review(decision):
            lines.append(f"  near a threshold ({by_rule.margin:.1%} of it away): review this one")
        lines += [f"  not {r.type} ({r.rule}): {r.because}" for r in by_rule.rejected]
        lines += [f"  conflict: {conflict}" for conflict in by_rule.conflicts]
    return "\n".join(lines)


def mesh_text(answer: MeshAnswer, deck: str, meshed: Sequence[str], seconds: float) -> str:
    """What was meshed, and the checks; meshed: segments that have elements; seconds: of the whole command."""
    of_all = "" if len(meshed) == len(answer.segments) else f" ({' '.join(meshed)}) of {len(answer.segments)}"
    elements = ", ".join(f"{count} {kind}" for kind, count in answer.elements.items())
    couplings = ", ".join(f"{count} {kind}" for kind, count in answer.couplings.items()) or "none"
    lines = [
        f"{deck}: {plural(answer.nodes, 'node')}, {elements}, in {plural(len(meshed), 'segment')}{of_all}",
        size_text(answer),
        *brick_lines(answer.bricks),
        f"couplings: {couplings}; components: {answer.components}",
        mass_text(answer),
    ]
    lines += quality_lines(answer.quality)
    lines.append(f"seconds: {seconds:.2f}")
    return "\n".join(lines)


def size_text(answer: MeshAnswer) -> str:
    """The size of the elements and what it comes from, and of the segments that have another one."""
    own = [f"{each.segment} {each.size:.4g} ({each.because})" for each in answer.size.segments]
    more = [f"{len(own) - MOST_SIZES} more"] if len(own) > MOST_SIZES else []
    general = f"{number(answer.size.value)} {answer.units} ({answer.size.because})"
    return "size: " + "; ".join([general, *own[:MOST_SIZES], *more])


def brick_lines(bricks: dict[str, str]) -> list[str]:
    """How the bricks were meshed and why: one line for all that were meshed alike."""
    alike: dict[str, list[str]] = {}
    for segment, how in bricks.items():
        alike.setdefault(how, []).append(segment)
    lines = []
    for how, segments in alike.items():
        more = f" and {len(segments) - MOST_SIZES} more" if len(segments) > MOST_SIZES else ""
        lines.append(f"{', '.join(segments[:MOST_SIZES])}{more}: {how}")
    return lines


def edited_text(answer: dict[str, Any], deck: str) -> str:
    """An edited mesh: what was done to it, what it is now, and its quality."""
    elements = ", ".join(f"{count} {kind}" for kind, count in answer["elements"].items())
    couplings = ", ".join(f"{count} {kind}" for kind, count in answer["couplings"].items()) or "none"
    lines = [
        *answer["history"],
        f"{deck}: {plural(answer['nodes'], 'node')}, {elements}",
        f"couplings: {couplings}; components: {answer['components']}",
        f"mass: {number(answer['mass']['model'])} (before {number(answer['mass']['solid'])})",
        *quality_lines(answer["quality"]),
    ]
    return "\n".join(lines)


def mass_text(answer: MeshAnswer) -> str:
    """Mass of the solid and of the model with their unit, and what the ledger of corners explains of the error."""
    from kernel.units import unit_set

    unit, mass = unit_set(answer.units).mass, answer.mass
    extra = answer.checks.model_extra or {}
    counted = extra.get("mass", {}).get("ledger", 0.0) / mass.solid if mass.solid else 0.0
    why = ""
    if abs(counted) > SHOWN_SHARE:
        of = {kind: counted * share for kind, share in _shares_by_kind(extra.get("ledger", [])).items()}
        shapes, chords = of.get("shape", 0.0), of.get("chords", 0.0)
        parts = [
            (counted - shapes - chords, "counted twice where segments meet", "left out where segments meet"),
            (shapes, "more than the segments' own shapes", "less than the segments' own shapes"),
            (chords, "added by straight edges of round holes", "cut off by straight edges and flat elements"),
        ]
        told = [f"{part:+.2%} {more if part > 0 else less}" for part, more, less in parts if abs(part) > SHOWN_SHARE]
        if told:
            why = f", of which {', '.join(told)}: --mass exact makes up for it".replace("%", " %")
    error = f"{round(mass.error, 4) + 0.0:+.2%}".replace("%", " %")
    return f"mass: solid {number(mass.solid)} {unit}, model {number(mass.model)} {unit} ({error}{why})"


def _shares_by_kind(ledger: list[dict[str, Any]]) -> dict[str, float]:
    """What the ledger's rows of each kind count of all that its rows do."""
    whole = sum(row["volume"] for row in ledger)
    found: dict[str, float] = {}
    for row in ledger if whole else ():
        found[row["kind"]] = found.get(row["kind"], 0.0) + row["volume"] / whole
    return found


def quality_lines(quality: dict[str, Any]) -> list[str]:
    """One measure of one kind a line: worst, 5 % and so on."""
    rows = []
    for kind, measures in quality.items():
        for measure, value in measures.items():
            if isinstance(value, dict):
                numbers = [measure_text(value[key]) for key in ("min", "p5", "mean", "p95", "max") if key in value]
                rows.append((kind, measure.replace("_", " "), *numbers))
    return table(("elements", "measure", "min", "5 %", "mean", "95 %", "max"), rows).splitlines() if rows else []


def solid_text(answer: SolidAnswer, path: str) -> str:
    """Volume, surface and extents of the solid written."""
    low, high = answer.bounds
    sides = " x ".join(number(b - a) for a, b in zip(low, high))
    return (
        f"{path}: {plural(answer.triangles, 'triangle')}\n"
        f"volume {number(answer.volume)} {answer.units}^3, area {number(answer.area)} {answer.units}^2, extents {sides}"
    )


def show(text: str) -> None:
    """A result, on standard output."""
    sys.stdout.write(text.rstrip("\n") + "\n")


def record_text(record: dict[str, Any], folder: str) -> str:
    """One model of a batch that is meshed, in a line."""
    deck = os.path.join(folder, record["deck"])
    if record["kept"]:
        return f"{record['model']}: {deck} is there from an earlier run"
    elements = sum(record["elements"].values())
    return (
        f"{record['model']}: {deck}, {plural(record['nodes'], 'node')}, {plural(elements, 'element')} in "
        f"{plural(record['segments'], 'segment')}, {record['seconds']:.2f} s"
    )


def batch_text(records: Sequence[dict[str, Any]]) -> str:
    """The sum of a batch."""
    kept = sum(record["kept"] for record in records)
    failed = sum(record["status"] == "failed" for record in records)
    said = [f"{len(records) - kept - failed} meshed"]
    said += [f"{kept} kept"] if kept else []
    said += [f"{failed} failed"] if failed else []
    return f"{plural(len(records), 'model')}: {', '.join(said)}"


def of_model(message: str, model: str) -> str:
    """The message with the model's name in front, where it does not begin with it."""
    return message if message.startswith(f"{model}:") else f"{model}: {message}"


def number(value: Any) -> str:
    """Six significant digits; anything but a float as it is."""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def measure_text(value: float) -> str:
    """A measure of an element: rounding shows as 0."""
    return number(0.0 if abs(value) < NOUGHT else float(value))


def plural(count: int, noun: str) -> str:
    """`1 node`, `2 nodes`."""
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"


def _about(classified: Classified, node: str) -> Sequence[Decision]:
    """The decisions about a node and its pieces."""
    from kernel.csg.tree import find

    decisions = classified.partition.plan.decisions
    path, _ = find(classified.csg.root, node.partition("#")[0])
    about = [d for d in decisions if d.node == node or ("#" not in node and d.node.partition("#")[0] == path)]
    if not about:
        asked = ", ".join(dict.fromkeys(d.node.partition("#")[0] for d in decisions))
        raise OverrideError(f"node {node} was not decided about, one above it was: expected one of {asked}")
    return about


def _explained(decision: Decision) -> dict[str, Any]:
    by_rule = decision.by_rule
    return {
        "node": decision.node,
        "type": decision.type,
        "origin": decision.origin,
        "because_of": _origin(decision),
        "rule": by_rule.rule,
        "certainty": by_rule.certainty,
        "because": by_rule.because,
        "by_rule": by_rule.type,
        "margin": by_rule.margin,
        "review": needs_review(decision),
        "rejected": [{"type": r.type, "rule": r.rule, "because": r.because} for r in by_rule.rejected],
        "conflicts": list(by_rule.conflicts),
        "override": None if decision.override is None else asdict(decision.override),
        "facts": {name: _plain(value) for name, value in decision.facts.items()},
    }


def _origin(decision: Decision) -> str:
    """Who decided, in words."""
    if decision.origin == "rule":
        return "by the rules"
    if decision.override is None or decision.type != decision.override.type:
        return f"a node in it is overridden; the rules say {decision.by_rule.type}"
    reason = f": {decision.override.reason}" if decision.override.reason else ""
    return f"override by {decision.override.author}{reason}; the rules say {decision.by_rule.type}"


def needs_review(decision: Decision) -> bool:
    """A number decided, and it is so near its limit that an analyst should look."""
    return decision.by_rule.margin is not None and decision.by_rule.margin < REVIEW_MARGIN


def _measures_of(segment: Segment) -> str:
    """What an analyst knows a segment by: thickness, length and section, or extents."""
    from kernel.segment.segments import BeamShape, BrickShape

    shape = segment.shape
    if isinstance(shape, BeamShape):
        from kernel.idealise.section import section_properties

        return f"length {number(segment.length)}, {section_text(section_properties(shape.outline))}"
    if isinstance(shape, BrickShape):
        low, high = segment.solid.bounds
        sides = " x ".join(number(float(side)) for side in sorted(high - low, reverse=True))
        return f"{sides}{', prismatic' if shape.sweep is not None else ''}"
    measures = [f"thickness {number(segment.thickness)}"]
    if segment.radius is not None:
        measures.append(f"radius {number(segment.radius)}")
    if segment.holes:
        measures.append(plural(segment.holes, "hole"))
    return ", ".join(measures)


def section_text(section: SectionProperties) -> str:
    """A section as a table of profiles names it: `rectangle 50 x 30, A 1500`, `tube D 60 t 4, A 703.7`."""
    sizes = {name: number(float(value)) for name, value in section.dimensions.items()}
    if "radius" in sizes:
        words = [f"D {number(2 * float(section.dimensions['radius']))}"]
        words += [f"t {sizes['thickness']}"] if "thickness" in sizes else []
    else:
        words = [f"{sizes['width']} x {sizes['height']}"] if "width" in sizes else []
        words += [f"{name} {sizes[name]}" for name in ("web", "flange") if name in sizes]
    return f"{' '.join([section.shape, *words])}, A {number(section.area)}"


def _measures(node: CsgNode) -> str:
    names = MEASURES.get(node.kind, ())
    shown = []
    for name in names:
        value = getattr(node, name)
        text = " x ".join(number(float(v)) for v in value) if isinstance(value, tuple) else number(float(value))
        shown.append(f"{name} {text}")
    return f" ({', '.join(shown)})" if shown else ""


def _plain(value: Any) -> Any:
    return value.item() if hasattr(value, "item") else value
