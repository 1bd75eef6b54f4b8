"""The report: one self-contained HTML page, pictures and figures inside."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from app.answers import meshed_answer
from app.report.pictures import pictures
from app.report.quality_scene import RAMP
from app.report.scenes import COUPLING_COLOURS, segment_colours
from app.texts import measure_text, number, plural
from kernel.csg.tree import walk
from kernel.mesh.quality import element_quality

if TYPE_CHECKING:
    from app.pipeline import Meshed
    from app.schemas import MeshAnswer, SegmentAnswer

CAPTIONS = {
    "solid": "The solid, as the CSG tree describes it",
    "segments": "Its segments, as they were decided",
    "mesh": "The mesh: shells at their mid-surface, beams with their section",
    "quality": "The mesh by scaled Jacobian",
}

CALLED = {"plates": "several plates", "split": "what its operands are", "cut": "several pieces"}
"""Types that are no thing of their own."""

NEGLIGIBLE = 1e-12
"""Products of inertia smaller than this share of the largest moment show as 0."""

STYLE = """
body { font: 15px/1.45 system-ui, sans-serif; color: #1d2530; max-width: 1100px; margin: 2rem auto; padding: 0 1rem }
h1 { font-size: 1.5rem } h2 { font-size: 1.15rem; margin-top: 2rem; border-bottom: 1px solid #d5dbe2 }
table { border-collapse: collapse; width: 100% } th { text-align: left; font-weight: 600 }
td, th { padding: .3rem .6rem .3rem 0; border-bottom: 1px solid #e6eaee; vertical-align: top }
td.n, th.n { text-align: right; font-variant-numeric: tabular-nums } small { color: #5c6875 }
figure { margin: 1rem 0; display: inline-block; width: 100% } figcaption { color: #5c6875 }
figure img { width: 100%; border: 1px solid #e6eaee } .bad { color: #b3261e; font-weight: 600 }
.swatch { display: inline-block; width: .9em; height: .9em; margin-right: .4em; vertical-align: -.1em }
figure.half { width: auto; margin-right: 2rem }
"""

COUPLING_WORDS = {"rbe2": "rigid (RBE2)", "rbe3": "averages (RBE3)", "mpc": "equations (MPC)"}


def report_page(meshed: Meshed) -> str:
    """The page as HTML text."""
    answer = meshed_answer(meshed)
    colours = segment_colours([segment.id for segment in answer.segments])
    figures = {name: _figure(name, content, _extents(meshed)) for name, content in pictures(meshed).items()}
    parts = [
        f"<h1>{escape(answer.model)}</h1>",
        f"<p>{_summary(answer)}</p>",
        *(figure for name, figure in figures.items() if name != "quality"),
        *_couplings(answer),
        "<h2>Segments</h2>",
        _segments(answer, colours, {path: node.kind for path, node in walk(meshed.classified.csg.root)}),
        *_sizes(answer),
        "<h2>Joints</h2>",
        _table(("joint", "kind", "segments", "area"), [_joint(j) for j in answer.joints]) or "<p>None.</p>",
        "<h2>Element quality</h2>",
        figures["quality"],
        _legend(),
        _quality(meshed),
        "<h2>Mass and checks</h2>",
        _checks(answer),
    ]
    if answer.warnings:
        parts += ["<h2>Warnings</h2>", "<ul>", *(f"<li>{escape(w)}</li>" for w in answer.warnings), "</ul>"]
    parts += ["<h2>Seconds by stage</h2>", _seconds(answer.seconds)]
    head = f'<meta charset="utf-8"><title>csgmesh: {escape(answer.model)}</title><style>{STYLE}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head>\n<body>\n' + "\n".join(parts) + "\n</body></html>\n"


def _summary(answer: MeshAnswer) -> str:
    elements = ", ".join(f"{count} {kind}" for kind, count in answer.elements.items())
    components = plural(answer.components, "component")
    return escape(
        f"{plural(len(answer.segments), 'segment')}, {plural(answer.nodes, 'node')}, {elements}; {components}; "
        f"size {number(answer.size.value)} ({answer.size.because}); units {answer.units}; rule base {answer.rule_base}"
    )


def _sizes(answer: MeshAnswer) -> list[str]:
    """The segments whose elements have another size than the model's."""
    rows = [(each.segment, f"{each.size:.4g}", each.because) for each in answer.size.segments]
    return ["<h2>Sizes of their own</h2>", _table(("segment", "size", "why"), rows)] if rows else []


def _extents(meshed: Meshed) -> str:
    """The solid's overall dimensions along the user's axes: `1500 x 800 x 785 mm`."""
    evaluated = meshed.classified.evaluated
    sides = np.ptp(evaluated.solid.facets.vertices @ evaluated.frame.T, axis=0)
    return f"{' x '.join(number(float(side)) for side in sides)} {meshed.classified.units.length} along x, y, z"


def _figure(name: str, content: bytes, extents: str) -> str:
    data = base64.b64encode(content).decode()
    caption = f"{CAPTIONS[name]}; {extents}"
    image = f'<img alt="{escape(caption)}" src="data:image/png;base64,{data}">'
    return f'<figure id="{name}">{image}<figcaption>{escape(caption)}</figcaption></figure>'


def _segments(answer: MeshAnswer, colours: dict[str, tuple[int, int, int]], kinds: dict[str, str]) -> str:
    rows = []
    for segment in answer.segments:
        red, green, blue = colours[segment.id]
        swatch = f'<span class="swatch" style="background: rgb({red}, {green}, {blue})"></span>'
        words = (segment.node, segment.name, kinds.get(segment.node.partition("#")[0]))
        node = escape(" ".join(word for word in words if word))
        measures = ", ".join(words for words in (_measures(segment), answer.bricks.get(segment.id)) if words)
        cells = (swatch + escape(segment.id), node, escape(segment.type), escape(measures))
        rows.append(
            "<tr>"
            + "".join(f"<td>{cell}</td>" for cell in cells)
            + f'<td class="n">{number(segment.volume)}</td><td>{_why(segment)}</td></tr>'
        )
    head = "<tr><th>segment</th><th>node</th><th>type</th><th>measures</th><th class=n>volume</th><th>why</th></tr>"
    return f"<table>{head}{''.join(rows)}</table>"


def _why(segment: SegmentAnswer) -> str:
    """What was decided and why, then what spoke against the others; which rule said so comes last and small."""
    decision = segment.decision
    said = f"{_called(decision.by_rule)}: {decision.because}"
    if segment.origin == "rule":
        lines = [escape(f"It is {said}.")]
        if decision.review:
            lines.append('<span class="bad">This is near the limit: have a look.</span>')
    else:
        lines = [escape(f"It is {_called(segment.type)} by override. The rules would have {said}.")]
    small = [f"It is not {_called(other.type)}: {other.because}." for other in decision.rejected]
    small.append(f"Rule {decision.rule}, certainty {decision.certainty:g}.")
    return "<br>".join([*lines, *(f"<small>{escape(_in_words(text))}</small>" for text in small)])


def _in_words(text: str) -> str:
    """A condition as the rules write it, for reading: `span_ratio 4.2, needs >= 10` has blanks and signs of its own."""
    for written, read in (("_", " "), (">=", "≥"), ("<=", "≤"), ("==", "=")):
        text = text.replace(written, read)
    return text


def _called(kind: str) -> str:
    """A type as an analyst would call it."""
    return CALLED.get(kind, f"a {kind.replace('_', '-')}")


def _measures(segment: SegmentAnswer) -> str:
    measures = []
    for name in ("thickness", "length", "radius"):
        value = getattr(segment, name)
        if value is not None:
            measures.append(f"{name} {number(value)}")
    if segment.holes:
        measures.append(plural(segment.holes, "hole"))
    if segment.section is not None:
        section = segment.section
        measures.append(
            f"section {section.shape}, A {number(section.area)}, Iyy {number(section.iyy)}, "
            f"Izz {number(section.izz)}, J {number(section.j)}"
        )
    return ", ".join(measures)


def _joint(joint: Any) -> tuple[str, ...]:
    return (joint.id, joint.kind, " ".join(joint.segments), number(joint.area))


def _couplings(answer: MeshAnswer) -> list[str]:
    """What the lines of couplings in the picture of the mesh are."""
    shown = [
        f'<span class="swatch" style="background: rgb{COUPLING_COLOURS[kind]}"></span>{count} {COUPLING_WORDS[kind]}'
        for kind, count in answer.couplings.items()
    ]
    return [f"<p>Couplings: {', '.join(shown)}.</p>"] if shown else []


def _legend() -> str:
    """What the colours of the picture by quality mean."""
    swatches = "".join(
        f'<span class="swatch" style="background: rgb{colour}"></span>{place / 10:g} '
        for place, colour in enumerate(RAMP)
    )
    return f"<p><small>Scaled Jacobian from: {swatches}; line elements grey.</small></p>"


def _quality(meshed: Meshed) -> str:
    """The table of every measure, and a histogram of the one that matters for each kind."""
    rows = []
    for kind, measures in meshed.quality.items():
        for measure, values in measures.items():
            if isinstance(values, dict):
                numbers = [measure_text(values[key]) for key in ("min", "p5", "mean", "p95", "max")]
                rows.append((kind, measure.replace("_", " "), *numbers))
    mesh = meshed.model.mesh
    histograms = []
    for kind in meshed.quality:
        blocks = [block for block in mesh.blocks if block.kind == kind]
        measured = [element_quality(block, mesh.nodes) for block in blocks]
        if "scaled_jacobian" in measured[0]:
            values = np.concatenate([m["scaled_jacobian"] for m in measured])
            histograms.append(_histogram(f"{kind}: elements by scaled Jacobian", values))
    head = ("elements", "measure", "least", "5 %", "mean", "95 %", "most")
    return _table(head, rows) + "".join(histograms)


def _histogram(title: str, values: NDArray[np.float64]) -> str:
    """Bars as inline SVG, over 0..1 (or from -1 where elements are inverted)."""
    counts, edges = np.histogram(values, bins=20, range=(min(0.0, float(values.min())), 1.0))
    width, height = 440, 120
    step = width / len(counts)
    top = max(int(counts.max()), 1)
    bars = "".join(
        f'<rect x="{k * step + 1:.1f}" y="{height - height * c / top:.1f}" width="{step - 2:.1f}" '
        f'height="{height * c / top:.1f}" fill="#568cc8">'
        f"<title>{edges[k]:.3g} to {edges[k + 1]:.3g}: {c}</title></rect>"
        for k, c in enumerate(counts.tolist())
    )
    axis = (
        f'<line x1="0" y1="{height}" x2="{width}" y2="{height}" stroke="#5c6875"/>'
        f'<text x="0" y="{height + 16}" font-size="12">{edges[0]:.3g}</text>'
        f'<text x="{width}" y="{height + 16}" font-size="12" text-anchor="end">{edges[-1]:.3g}</text>'
    )
    picture = f'<svg width="{width}" height="{height + 22}" viewBox="0 0 {width} {height + 22}">{bars}{axis}</svg>'
    return f'<figure class="half">{picture}<figcaption>{escape(title)}</figcaption></figure>'


def _checks(answer: MeshAnswer) -> str:
    mass = answer.mass
    rows = [
        ("mass of the solid", number(mass.solid)),
        ("mass of the model", f"{number(mass.model)} (error {mass.error:.3%})"),
        *_moments(answer),
        ("components", str(answer.components)),
        ("volume of the segments", f"{number(answer.checks.volume_of_segments)} of {number(answer.volume)}"),
        *((kind, str(count)) for kind, count in answer.couplings.items()),
    ]
    checks = answer.checks.model_extra or {}
    for name, value in checks.items():
        if isinstance(value, bool | int | float | str) and name not in ("components", "passed"):
            rows.append((name.replace("_", " "), number(value)))
    failures = "".join(f'<p class="bad">{escape(failure)}</p>' for failure in checks.get("failures", []))
    ledger = [(" ".join(row["segments"]), row["cause"], number(row["volume"])) for row in answer.ledger]
    listed = _table(("segments", "counted more (+) or less (-) often than the solid has it", "volume"), ledger)
    return (
        (failures or "<p>All checks hold.</p>")
        + _table(("check", "value"), rows)
        + (f"<h2>Ledger</h2>{listed}" if ledger else "")
    )


def _moments(answer: MeshAnswer) -> list[tuple[str, str]]:
    """Centre of gravity and moments of inertia about it, of the solid and of the model."""
    checks = answer.checks.model_extra or {}
    rows = []
    for name, title in (("centre", "centre of gravity"), ("inertia", "inertia Ixx Iyy Izz Ixy Ixz Iyz")):
        for of in ("solid", "model") if name in checks else ():
            value = np.array(checks[name][of])
            if name == "inertia":
                value = value[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
                value = np.where(np.abs(value) < NEGLIGIBLE * np.abs(value).max(), 0.0, value)
            rows.append((f"{title} of the {of}", "  ".join(number(float(part)) for part in value)))
    return rows


def _seconds(seconds: dict[str, float]) -> str:
    return _table(("stage", "seconds"), [(stage, f"{value:.3f}") for stage, value in seconds.items()])


def _table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table of plain text; the empty text without rows."""
    if not rows:
        return ""
    first = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{first}</tr>{body}</table>"
