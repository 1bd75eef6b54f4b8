"""Merging: another model laid beside this one, in one deck; nothing is joined yet."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from kernel.connect.mass import total
from kernel.connect.merge import merge
from kernel.connect.model import Model, NamedSet
from kernel.connect.reference import Reference
from kernel.edit.edited import Edited, renumbered_coupling, segment_names, unique_name
from kernel.errors import OptionError
from kernel.materials import Material
from kernel.mesh.mesh import Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Merged:
    """edited: both in one. segments, materials: what those of the second model that had to be renamed are called."""

    edited: Edited
    segments: Mapping[str, str]
    materials: Mapping[str, str]


def merge_models(first: Edited, second: Edited) -> Merged:
    """Both in one: the first as it is, the second behind it, its segments renamed where their ids are taken.

    OptionError: the models are in different units.
    """
    one, other = first.model, second.model
    if one.units != other.units:
        raise OptionError(f"{one.title} is in {one.units} and {other.title} in {other.units}, expected the same units")
    segments = _segment_ids(one, other)
    materials = _material_names(one.materials, other.materials)
    renamed = tuple(replace(block, segment=segments[block.segment]) for block in other.mesh.blocks)
    mesh = merge([one.mesh, Mesh(other.mesh.nodes, renamed)])
    behind = np.arange(other.mesh.n_node) + one.mesh.n_node
    couplings = [renumbered_coupling(coupling, behind) for coupling in other.couplings]
    model = Model(
        title=one.title if one.title == other.title else f"{one.title} + {other.title}",
        units=one.units,
        rule_base=one.rule_base if one.rule_base == other.rule_base else f"{one.rule_base} + {other.rule_base}",
        mesh=mesh,
        properties=(
            *one.properties,
            *(
                replace(p, segment=segments[p.segment], material=materials.get(p.material, p.material))
                for p in other.properties
            ),
        ),
        materials={
            **one.materials,
            **{materials.get(n, n): replace(m, name=materials.get(n, n)) for n, m in other.materials.items()},
        },
        couplings=(*one.couplings, *(coupling for coupling in couplings if coupling is not None)),
        sets=_merged_sets(one, other, segments),
        notes=(*one.notes, *(note for note in other.notes if note not in one.notes)),
    )
    changed = {old: new for old, new in segments.items() if old != new}
    told = f", its {', '.join(f'{old} called {new}' for old, new in changed.items())}" if changed else ""
    reference = _merged_reference(first.reference, second.reference, one.mesh.n_node, segments)
    edited = first.done(model, reference, f"merged with {other.title} ({', '.join(segment_names(other))}){told}")
    return Merged(edited, segments, materials)


def _segment_ids(one: Model, other: Model) -> dict[str, str]:
    """The ids of the other's segments beside the first's: kept, or counted on from the highest of both."""
    taken = set(segment_names(one))
    known = taken | set(segment_names(other))
    highest = max((int(found[1]) for name in known if (found := re.fullmatch(r"s(\d+)", name))), default=0)
    ids = {}
    for name in segment_names(other):
        if name in taken:
            highest += 1
            ids[name] = f"s{highest}"
        else:
            ids[name] = name
        taken.add(ids[name])
    return ids


def _material_names(one: Mapping[str, Material], other: Mapping[str, Material]) -> dict[str, str]:
    """New names for those of the other's materials that are called as another one is."""
    renamed: dict[str, str] = {}
    for name, material in other.items():
        if name in one and one[name] != material:
            renamed[name] = unique_name(name, {*one, *other, *renamed.values()})
    return renamed


def _merged_sets(one: Model, other: Model, segments: Mapping[str, str]) -> tuple[NamedSet, ...]:
    """Sets of one name are one where both are parts of one model; else the second gets a number at its end."""
    n_element = sum(len(block.connectivity) for block in one.mesh.blocks)
    found = {named.name: named for named in one.sets}
    for named in other.sets:
        moved = NamedSet(
            segments.get(named.name, named.name), named.nodes + one.mesh.n_node, named.elements + n_element
        )
        if moved.name in found and one.title == other.title:
            before = found[moved.name]
            found[moved.name] = NamedSet(
                moved.name,
                np.concatenate([before.nodes, moved.nodes]),
                np.concatenate([before.elements, moved.elements]),
            )
        else:
            name = unique_name(moved.name, found)
            found[name] = replace(moved, name=name)
    return tuple(found.values())


def _merged_reference(one: Reference, other: Reference, n_node: int, segments: Mapping[str, str]) -> Reference:
    curves = other.curve_uses + np.array([n_node, n_node, 0])
    rows = (
        replace(
            row,
            segments=tuple(segments.get(name, name) for name in row.segments),
            shares={segments.get(name, name): share for name, share in row.shares.items()},
        )
        for row in other.ledger
    )
    return Reference(
        size=max(one.size, other.size),
        pieces=one.pieces + other.pieces,
        solid=total([one.solid, other.solid]),
        ledger=(*one.ledger, *rows),
        curve_uses=np.vstack([one.curve_uses, curves]),
        arms=np.vstack([one.arms, other.arms + n_node]),
        solids={**one.solids, **{segments.get(name, name): moments for name, moments in other.solids.items()}},
        pieces_of="the two were",
        misfits={**one.misfits, **{segments.get(name, name): misfit for name, misfit in other.misfits.items()}},
        may_coincide=True,
    )
