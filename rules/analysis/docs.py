"""`csgmesh rules docs`: the vocabulary and a rule base, written out for people."""

from __future__ import annotations

from typing import Any

from kernel.facts import RELATED, TIERS, VOCABULARY
from rules.definition import BANDS, CONCLUSIONS, LENGTH_UNITS, PREFERENCE
from rules.engine import RuleBase
from rules.syntax import FUNCTIONS, number_text, text_of


def vocabulary_text(base: RuleBase | None = None) -> str:
    """The facts, tier by tier; with `base` also its parameters, quantities and rules."""
    lines = ["FACTS, from cheap to dear; a rule asks for a dearer tier only when it could change the answer", ""]
    for tier in TIERS:
        lines.append(f"{tier}:")
        for spec in VOCABULARY:
            if spec.tier == tier:
                choices = f" ({', '.join(spec.choices)})" if spec.choices else ""
                lines.append(f"  {spec.name:20} {spec.dimension:8} {spec.meaning}{choices}")
        for related in RELATED.values():
            if related.tier == tier:
                lines.append(f"  {related.name:20} {'things':8} {related.meaning}: `some {related.singular}: [...]`")
        lines.append("")
    lines += [
        f"segments and divisions: {', '.join(CONCLUSIONS)}",
        f"priorities, strongest first: {', '.join(reversed(BANDS))}",
        f"inside a priority the higher certainty wins; where that is equal, the first of {', '.join(PREFERENCE)}",
        f"functions: {', '.join(FUNCTIONS)}; units of parameters: 1, {', '.join(LENGTH_UNITS)}, with ^2 or ^3",
    ]
    if base is not None:
        lines += ["", *_base_lines(base)]
    return "\n".join(lines)


def _base_lines(base: RuleBase) -> list[str]:
    lines = [f"RULE BASE {base.name} {base.version}: {len(base.rules)} rules", base.definition.about, "", "parameters:"]
    for name, parameter in sorted(base.parameters.items()):
        limits = f", {number_text(parameter.range[0])} to {number_text(parameter.range[1])}" if parameter.range else ""
        lines.append(f"  {name} = {number_text(parameter.value)} [{parameter.unit}{limits}]  {parameter.meaning}")
        if parameter.source:
            lines.append(f"      source: {parameter.source}")
    if base.definition.quantities:
        lines += ["", "quantities:"]
        for name, quantity in sorted(base.definition.quantities.items()):
            lines.append(f"  {name} = {text_of(quantity.expression)}  {quantity.meaning}")
    for band in reversed(BANDS):
        rules = [rule for rule in base.rules if rule.band == band]
        if rules:
            lines += ["", f"rules, {band}:"]
        for rule in sorted(rules, key=lambda rule: (rule.segment is None, -rule.certainty, rule.id)):
            what = f"{rule.segment}, certainty {number_text(rule.certainty)}" if rule.segment else f"word {rule.word}"
            lines.append(f"  {rule.id} -> {what}")
            lines.append(f"      when {text_of(rule.condition)}")
            lines.append(f"      because {rule.because.source}")
            if rule.source:
                lines.append(f"      source: {rule.source}")
    return lines


def vocabulary_json(base: RuleBase | None = None) -> dict[str, Any]:
    """The same as plain values."""
    result: dict[str, Any] = {
        "facts": [
            {
                "name": spec.name,
                "tier": spec.tier,
                "dimension": spec.dimension,
                "meaning": spec.meaning,
                "choices": list(spec.choices),
            }
            for spec in VOCABULARY
        ],
        "related": [
            {"name": spec.name, "singular": spec.singular, "tier": spec.tier, "meaning": spec.meaning}
            for spec in RELATED.values()
        ],
        "conclusions": list(CONCLUSIONS),
        "priorities": list(BANDS),
    }
    if base is not None:
        result["rule_base"] = {
            "name": base.name,
            "version": base.version,
            "about": base.definition.about,
            "parameters": [
                {
                    "name": parameter.name,
                    "value": parameter.value,
                    "unit": parameter.unit,
                    "range": list(parameter.range) if parameter.range else None,
                    "meaning": parameter.meaning,
                    "source": parameter.source,
                }
                for _, parameter in sorted(base.parameters.items())
            ],
            "quantities": [
                {"name": quantity.name, "value": text_of(quantity.expression), "meaning": quantity.meaning}
                for _, quantity in sorted(base.definition.quantities.items())
            ],
            "rules": [
                {
                    "id": rule.id,
                    "priority": rule.band,
                    "when": text_of(rule.condition),
                    "segment": rule.segment,
                    "word": rule.word,
                    "certainty": rule.certainty,
                    "because": rule.because.source,
                    "evidence": rule.evidence,
                    "source": rule.source,
                    "place": str(rule.place),
                }
                for rule in base.rules
            ],
        }
    return result
