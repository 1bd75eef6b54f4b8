"""A plain stand-in for the rule base, a short cut from text to segments, and how an answer is compared."""

from __future__ import annotations

from kernel.csg.reader import read_model
from kernel.facts import Facts
from kernel.plan import Conclusion, Need, Override
from kernel.segment.partition import Partition, partition
from kernel.segment.segments import BeamShape, Segment
from kernel.solid.evaluate import evaluate

TOLERANCE = {"length": 0.05}
"""Attributes hold to 1 %, a beam's length to 5 %."""


def attributes(segment: Segment) -> dict[str, float | str | None]:
    """What an expected answer may name."""
    area = segment.shape.outline.area if isinstance(segment.shape, BeamShape) else None
    return {
        "type": segment.type,
        "thickness": segment.thickness,
        "radius": segment.radius,
        "length": segment.length,
        "area": area,
        "holes": segment.holes,
    }


def fits(expected: dict, segment: Segment) -> bool:
    """Every attribute that is expected holds."""
    found = attributes(segment)
    for name, value in expected.items():
        if name in ("type", "holes"):
            if found[name] != value:
                return False
        elif found[name] is None or abs(found[name] - value) > TOLERANCE.get(name, 0.01) * abs(value):
            return False
    return True


def is_answer(expected: list[dict], partition: Partition) -> bool:
    """A one-to-one match of expected segments and found ones exists (search with backtracking)."""
    segments = list(partition.segments)
    if len(expected) != len(segments):
        return False
    options = [[index for index, segment in enumerate(segments) if fits(answer, segment)] for answer in expected]
    order = sorted(range(len(expected)), key=lambda k: len(options[k]))
    return _match(order, options, set())


def _match(order: list[int], options: list[list[int]], used: set[int]) -> bool:
    if not order:
        return True
    first, *rest = order
    return any(_match(rest, options, used | {index}) for index in options[first] if index not in used)


def told(partition: Partition) -> str:
    """The segments in one line, for a failing test."""
    rows = []
    for segment in partition.segments:
        values = {k: v for k, v in attributes(segment).items() if v is not None and k != "type"}
        inner = ", ".join(f"{k} {v:.6g}" for k, v in values.items())
        rows.append(f"{segment.node} {segment.type}({inner})")
    return "; ".join(rows)


def _concluded(type_: str, because: str) -> Conclusion:
    return Conclusion(type=type_, rule=f"plain-{type_}", certainty=1.0, because=because)


def plain_decide(facts: Facts) -> Conclusion | Need:
    """The order of decisions that classified the labelled sets, with closed limits."""
    if "volume" not in facts:
        return Need("extents")
    if facts["component_count"] > 1 or facts["operand_count"] > 40:
        return _concluded("split", "several solids")
    if "is_prismatic" not in facts:
        return Need("prism")
    nearly = facts["is_prismatic"] or (
        facts.get("volume_deviation", 1.0) <= 0.03
        and facts.get("sections_off", 9) <= 3
        and facts.get("worst_section_off", 1.0) <= 0.3
    )
    is_free = facts.get("free_length", 0.0) >= 4.0 * facts.get("section_long", 1.0)
    if nearly and is_free and facts["slenderness"] >= 10.0:
        return _concluded("beam", "slender")
    if "wall_share" not in facts:
        return Need("walls")
    is_lattice = facts.get("outline_fill", 1.0) < 0.5 and facts["strip_ratio"] < 3.0
    if facts["wall_share"] > 0.5 and not is_lattice and facts["operand_count"] > 1:
        if facts.tier == "walls":
            return Need("members")
        is_frame = facts["beam_share"] >= 0.3 and facts["beam_fill"] <= 0.6 and facts["cut_beam_count"] == 0
        if is_frame:
            return _concluded("split", "frame")
    if facts["wall_share"] >= 0.95 and not is_lattice:
        if facts["wall_count"] == 1:
            return _concluded("plate" if facts["plane_wall_count"] else "cylinder_plate", "one wall")
        return _concluded("plates", "walls")
    if facts["operand_count"] > 1:
        return _concluded("split", "operands decide")
    if facts["wall_share"] > 0.5 and not is_lattice:
        return _concluded("plates", "mostly walls")
    if "neck_share" not in facts:
        return Need("necks")
    if facts["neck_share"] > 0.3:
        return _concluded("cut", "necks")
    return _concluded("brick", "chunky")


def segmented(text: str, overrides: dict[str, str] | None = None, decide=plain_decide) -> Partition:
    """The partition of a model's text under overrides, path to type."""
    pinned = {path: Override(type_) for path, type_ in (overrides or {}).items()}
    return partition(evaluate(read_model(text, "model.csg")), decide, pinned)


def kinds(text: str, overrides: dict[str, str] | None = None) -> list[str]:
    """Segment types in alphabetical order."""
    return sorted(segment.type for segment in segmented(text, overrides).segments)
