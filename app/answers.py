"""From the pipeline's values to the JSON of app/schemas.py: the one place that knows both."""

from __future__ import annotations

import os
from collections import Counter
from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from app.schemas import (
    ChecksAnswer,
    Classification,
    DecisionAnswer,
    JointAnswer,
    MassAnswer,
    MeshAnswer,
    OverrideAnswer,
    RejectedAnswer,
    SectionAnswer,
    SegmentAnswer,
    SegmentSizeAnswer,
    SizeAnswer,
    SolidAnswer,
)
from app.texts import needs_review

if TYPE_CHECKING:
    from app.pipeline import Classified, Meshed
    from kernel.csg.tree import CsgModel
    from kernel.idealise.section import SectionProperties
    from kernel.plan import Decision
    from kernel.segment.segments import Segment
    from kernel.solid.evaluate import Evaluated


DIGITS = 12
"""Of lengths, areas and volumes that are told: what lies beyond is rounding."""


def classification(classified: Classified) -> Classification:
    """What `classify --json` gives."""
    return Classification(**_common(classified, {}))


def meshed_answer(meshed: Meshed) -> MeshAnswer:
    """What `mesh --json` gives."""
    checks = meshed.checks
    common = _common(meshed.classified, meshed.assembly.sections)
    common["checks"] = ChecksAnswer(
        volume_of_segments=common["checks"].volume_of_segments,
        mass_error=checks.mass_error,
        **plain(checks.to_json()),
    )
    return MeshAnswer(
        **common,
        size=size_answer(meshed),
        nodes=meshed.model.mesh.n_node,
        elements=meshed.model.mesh.count(),
        bricks=dict(meshed.assembly.bricks),
        couplings=dict(sorted(Counter(type(c).__name__.lower() for c in meshed.model.couplings).items())),
        components=checks.components,
        quality=plain(meshed.quality),
        mass=MassAnswer(solid=checks.solid_mass, model=checks.model_mass, error=checks.mass_error),
        ledger=[
            {"segments": list(row.segments), "cause": row.cause, "volume": float(row.volume), "kind": row.kind}
            for row in meshed.assembly.ledger
            if row.volume
        ],
        warnings=list(meshed.warnings),
        seconds={stage: round(seconds, 4) for stage, seconds in meshed.seconds.items()},
    )


def size_answer(meshed: Meshed) -> SizeAnswer:
    """The sizes that were used, and what they come from."""
    sizes = meshed.assembly.sizes
    return SizeAnswer(
        value=float(sizes.size),
        automatic=meshed.options.size is None,
        because=sizes.because,
        segments=[
            SegmentSizeAnswer(segment=name, size=float(sizes.by_segment[name]), because=reason)
            for name, reason in sizes.reasons.items()
        ],
    )


def solid_answer(csg: CsgModel, evaluated: Evaluated, units: str) -> SolidAnswer:
    """What `evaluate --json` gives; the bounds are in the user's frame."""
    solid = evaluated.solid
    points = solid.facets.vertices @ evaluated.frame.T
    return SolidAnswer(
        model=os.path.basename(csg.source),
        units=units,
        volume=float(solid.true_volume),
        area=float(solid.area),
        bounds=[points.min(axis=0).tolist(), points.max(axis=0).tolist()],
        triangles=len(solid.facets.triangles),
    )


def section_answer(section: SectionProperties) -> SectionAnswer:
    """A beam's section."""
    names = ("area", "iyy", "izz", "iyz", "j", "shear_area_y", "shear_area_z")
    return SectionAnswer(shape=section.shape, **{name: float(getattr(section, name)) for name in names})


def decision_answer(decision: Decision) -> DecisionAnswer:
    """Why a node is what it is."""
    by_rule, pinned = decision.by_rule, decision.override
    return DecisionAnswer(
        rule=by_rule.rule,
        certainty=by_rule.certainty,
        because=by_rule.because,
        rejected=[RejectedAnswer(type=r.type, rule=r.rule, because=r.because) for r in by_rule.rejected],
        by_rule=by_rule.type,
        margin=by_rule.margin,
        review=needs_review(decision),
        conflicts=list(by_rule.conflicts),
        override=None if pinned is None else OverrideAnswer(**asdict(pinned)),
    )


def segment_answer(segment: Segment, section: SectionProperties | None) -> SegmentAnswer:
    """One segment; `section` for beams."""
    return SegmentAnswer(
        id=segment.id,
        node=segment.node,
        name=segment.name,
        type=segment.type,
        origin=segment.origin,
        volume=_told(segment.volume),
        thickness=_maybe(segment.thickness),
        length=_maybe(segment.length),
        radius=_maybe(segment.radius),
        holes=segment.holes,
        section=None if section is None else section_answer(section),
        decision=decision_answer(segment.decision),
    )


def plain(value: Any) -> Any:
    """numpy's scalars and arrays, tuples and dataclasses' dicts as JSON's own types."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    if isinstance(value, np.ndarray):
        return value.tolist()
    if isinstance(value, np.generic):
        return value.item()
    return value


def _common(classified: Classified, sections: dict[str, SectionProperties]) -> dict[str, Any]:
    segments = classified.partition.segments
    volume = float(classified.evaluated.solid.true_volume)
    of_segments = float(sum(segment.volume for segment in segments))
    return {
        "model": os.path.basename(classified.csg.source),
        "units": classified.units.name,
        "volume": volume,
        "rule_base": f"{classified.rule_base.name} {classified.rule_base.version}",
        "segments": [segment_answer(s, _section(s, sections)) for s in segments],
        "joints": [
            JointAnswer(id=j.id, kind=j.kind, segments=list(j.segments), area=_told(j.area), gap=_told(j.gap))
            for j in classified.joints
        ],
        "checks": ChecksAnswer(
            volume_of_segments=of_segments, mass_error=abs(of_segments - volume) / volume if volume else 0.0
        ),
    }


def _section(segment: Segment, sections: dict[str, SectionProperties]) -> SectionProperties | None:
    from kernel.segment.segments import BeamShape

    if not isinstance(segment.shape, BeamShape):
        return None
    if segment.id in sections:
        return sections[segment.id]
    from kernel.idealise.section import section_properties

    return section_properties(segment.shape.outline)


def _maybe(value: float | None) -> float | None:
    return None if value is None else _told(value)


def _told(value: float) -> float:
    """Without the digits that are but rounding: a plate 10 thick is not 10.000000000000455 thick."""
    return float(f"{value:.{DIGITS}g}")
