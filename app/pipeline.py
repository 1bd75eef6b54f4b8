"""The main flow, from a CSG text to a deck: read it top-down.

    csg        = read("bracket.csg")                    text -> CSG tree
    classified = classify(csg)                          -> solid -> facts, rules -> segments, joints
    meshed     = mesh(classified, MeshOptions(size=8))  -> shared curves, elements -> connected model, checked
    deck       = write_deck(meshed, "bracket.bdf")      -> the bytes of a deck

Each stage is a function of the values before it; nothing here holds state. `seconds` says what each stage took.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from kernel.csg.tree import CsgModel, find
from kernel.deck.deck import format_for
from kernel.errors import CheckError, OptionError, OverrideError
from kernel.mesh.options import MeshOptions
from kernel.plan import OVERRIDES, Override
from kernel.units import UnitSet, unit_set

if TYPE_CHECKING:
    from kernel.connect.checks import Checks
    from kernel.connect.joints import Joint
    from kernel.connect.model import Model
    from kernel.mesh.assembly import Assembly
    from kernel.segment.partition import Partition
    from kernel.solid.evaluate import Evaluated
    from rules.engine import RuleBase

Progress = Callable[[str, float], None]
"""Called with a stage's name and the share of it that is done, 0..1."""

DEFAULT_MATERIAL = "steel"

APART = "apart"
"""The coupling of a joint across which segments are meshed apart."""


@dataclass(frozen=True, slots=True, eq=False)
class Classified:
    """A model broken into segments: what `csgmesh classify` shows."""

    csg: CsgModel
    units: UnitSet
    rule_base: RuleBase
    evaluated: Evaluated
    partition: Partition
    joints: tuple[Joint, ...]
    seconds: dict[str, float]


@dataclass(frozen=True, slots=True, eq=False)
class Meshed:
    """A connected model with its proof: what `csgmesh mesh` shows and writes."""

    classified: Classified
    options: MeshOptions
    assembly: Assembly
    model: Model
    checks: Checks
    quality: dict[str, Any]
    seconds: dict[str, float]

    @property
    def warnings(self) -> tuple[str, ...]:
        """One line each: what an analyst should look at, though the model holds."""
        from kernel.connect.audit import component_segments

        if self.checks.components == 1 or self.assembly.apart:
            return self.model.notes
        parts = " | ".join(" ".join(segments) for segments in component_segments(self.model))
        return f"the model is in {self.checks.components} parts that do not touch: {parts}", *self.model.notes


def read(path: str) -> CsgModel:
    """The CSG model in the file at `path`, "-" for standard input."""
    from kernel.csg.reader import read_file

    return read_file(path)


def classify(
    csg: CsgModel,
    *,
    overrides: Mapping[str, Override] | None = None,
    rules: str | RuleBase | None = None,
    units: str | None = None,
    gap: float = 0.0,
    progress: Progress | None = None,
) -> Classified:
    """Evaluate the solid, let the rules and the user's overrides decide, split it into segments and find their joints.

    overrides: by node path or name. rules: a rule base or the path of one, None for the base that comes with csgmesh.
    gap: faces no further apart than this, in model units, count as touching.
    units: for a model that names none; "mm" where nobody says anything. OptionError where the model says otherwise.
    """
    from kernel.connect.contacts import find_joints
    from kernel.segment.partition import partition
    from kernel.solid.evaluate import evaluate
    from rules.engine import load_rule_base

    clock = _Clock(progress)
    units_used = units_of(csg, units)
    pinned = resolve_overrides(csg, overrides or {})
    with clock("rules"):
        rule_base = load_rule_base(rules) if rules is None or isinstance(rules, str) else rules
        rule_base = rule_base.in_units(units_used.name)
    with clock("evaluate"):
        evaluated = evaluate(csg)
    with clock("segment"):
        parts = partition(evaluated, rule_base.decide, pinned)
    with clock("joints"):
        joints = find_joints(parts.segments, evaluated, gap)
    return Classified(csg, units_used, rule_base, evaluated, parts, joints, clock.seconds)


def mesh(
    classified: Classified,
    options: MeshOptions | None = None,
    *,
    material: str | None = None,
    coupling: str = "distributing",
    joint_couplings: Mapping[str, str] | None = None,
    materials_of: Mapping[str, str] | None = None,
    mass: str = "plain",
    apart: bool = False,
    only: Collection[str] = (),
    progress: Progress | None = None,
) -> Meshed:
    """Idealise and mesh the segments on shared curves, couple them, and check the connected model.

    material: a named material for every segment, None for what the model's MATERIAL says, else steel.
    coupling: "distributing" (RBE3), "rigid" (RBE2) or "work" (equations), where dimensions change.
    materials_of: names of materials by segment id, node path or name, where they differ.
    joint_couplings: by joint id, where one is to differ; "apart" for neither coupling nor common nodes there.
    apart: the same at every joint. only: mesh these alone, each apart: segment ids, node paths or names.
    mass: "plain", or "exact" to scale densities so that every segment weighs what its solid does.
    """
    from kernel.connect.build import build_model
    from kernel.connect.checks import check_model
    from kernel.mesh.assemble import assemble
    from kernel.mesh.quality import mesh_quality

    clock = _Clock(progress)
    options = options or MeshOptions()
    csg, evaluated = classified.csg, classified.evaluated
    by_joint = joint_couplings or {}
    torn = [joint.id for joint in classified.joints] if apart else [j for j, kind in by_joint.items() if kind == APART]
    chosen = segments_of(classified, only) if only else None
    with clock("mesh"):
        segments = classified.partition.segments
        assembly = assemble(evaluated, segments, classified.joints, options, clock.part, apart=torn, only=chosen)
    with clock("quality"):
        in_frame = replace(assembly.mesh, nodes=assembly.mesh.nodes @ evaluated.frame.T)  # errors name places in it
        quality = mesh_quality(in_frame)
    with clock("connect"):
        model = build_model(
            assembly,
            evaluated,
            csg,
            units=classified.units,
            material=material,
            coupling=coupling,
            joint_couplings={joint: kind for joint, kind in by_joint.items() if kind != APART},
            materials_of=materials_of,
            mass=mass,
            title=Path(csg.source).name,  # a deck does not depend on the folder that its model lies in
            rule_base=f"{classified.rule_base.name} {classified.rule_base.version}",
        )
    with clock("check"):
        checks = check_model(model, assembly, evaluated)
    return Meshed(classified, options, assembly, model, checks, quality, {**classified.seconds, **clock.seconds})


def segments_of(classified: Classified, addresses: Collection[str]) -> list[str]:
    """Ids of the segments that the addresses mean, each a segment's id or a node's path or name, as for `sizes`.

    OptionError: an address of nothing, or of no segment.
    """
    from kernel.segment.addresses import by_segment

    found = by_segment(dict.fromkeys(addresses, True), classified.evaluated, classified.partition.segments, "only")
    return list(found)


def refuse_failed(meshed: Meshed) -> None:
    """CheckError where the model does not pass its own checks: such a model is not to be loaded unseen."""
    if meshed.checks.failures:
        failures = "; ".join(meshed.checks.failures)
        raise CheckError(f"the model does not pass its checks: {failures}; expected all to hold, or `unchecked`")


def write_deck(meshed: Meshed, path: str, deck_format: str | None = None) -> bytes:
    """The model as the bytes of a deck, in `deck_format` or the format that the ending of `path` means."""
    return format_for(path, deck_format).write(meshed.model)


def units_of(csg: CsgModel, asked: str | None) -> UnitSet:
    """The model's own unit set, else the one asked for, else mm; OptionError where the two differ.

    Asking for others would not convert the model's numbers but take them, its materials' included, for something else.
    """
    own = unit_set(csg.units) if csg.units else None
    wanted = unit_set(asked) if asked else None
    if own and wanted and own is not wanted:
        raise OptionError(
            f"the model says UNITS {own.name}, but units {wanted.name} are asked for, expected one of them"
        )
    return own or wanted or unit_set("mm")


def resolve_overrides(csg: CsgModel, overrides: Mapping[str, Override]) -> dict[str, Override]:
    """The overrides by canonical path, `auto` left out; OverrideError for an unknown node, type, or two of one node."""
    resolved: dict[str, Override] = {}
    named: dict[str, str] = {}
    for address, override in overrides.items():
        if override.type not in OVERRIDES:
            expected = ", ".join(OVERRIDES)
            raise OverrideError(f"override {address}={override.type}: unknown type, expected one of {expected}")
        path, _ = find(csg.root, address)
        if path in named:
            raise OverrideError(f"overrides {named[path]!r} and {address!r} are both of node {path}, expected one")
        named[path] = address
        if override.type != "auto":
            resolved[path] = override
    return resolved


class _Clock:
    """Times the stages of one call and passes their progress on."""

    def __init__(self, progress: Progress | None) -> None:
        self.seconds: dict[str, float] = {}
        self._progress = progress
        self._stage = ""

    @contextmanager
    def __call__(self, stage: str) -> Iterator[None]:
        """Time a block as `stage`."""
        self._stage = stage
        self.part(stage, 0.0)
        start = time.perf_counter()
        yield
        self.seconds[stage] = time.perf_counter() - start
        self.part(stage, 1.0)

    def part(self, what: str, share: float) -> None:
        """`share` of the current stage is done."""
        if self._progress is not None:
            self._progress(what or self._stage, share)
