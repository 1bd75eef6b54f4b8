"""The connected model, from the meshed parts: in the user's frame, with properties, materials, couplings and sets."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.couplings import make_couplings
from kernel.connect.mass import block_moments
from kernel.connect.model import Model, NamedSet, Property
from kernel.csg.tree import CsgModel, walk
from kernel.errors import DefectError, OptionError
from kernel.materials import Material, choose_material
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.segment.addresses import by_segment, is_under

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from kernel.mesh.assembly import Assembly
    from kernel.segment.segments import Segment
    from kernel.solid.evaluate import Evaluated
    from kernel.units import UnitSet

COORDINATE_DIGITS = 12
"""Digits, counted from the model's size, that a coordinate keeps: what a rotation's rounding adds is cut off."""

MASSES = ("plain", "exact")

_KINDS = {"beam": "beam", "plate": "shell", "cylinder_plate": "shell", "brick": "solid"}


def build_model(
    assembly: Assembly,
    evaluated: Evaluated,
    csg: CsgModel,
    *,
    units: UnitSet,
    material: str | None = None,
    coupling: str = "distributing",
    joint_couplings: Mapping[str, str] | None = None,
    materials_of: Mapping[str, str] | None = None,
    mass: str = "plain",
    title: str = "",
    rule_base: str = "",
) -> Model:
    """The model in the user's frame (`evaluated.frame` applied), every tie a coupling, every segment a property.

    material: a named material or one of the model's; None for what the model's text says, else steel.
    joint_couplings: by joint id, where a joint's coupling is to differ from `coupling`.
    materials_of: names of materials by segment id, CSG node path or name, where they differ from `material`; of two
    that hold for a segment the one of the deeper node wins, and its own id over both.
    mass: "exact" scales each segment's density so that its elements weigh what its solid does, corners that two
    mid-surfaces both count included; "plain" leaves the density as it is.
    OptionError: an unknown material, coupling, joint or mass. ConnectError: a tie that contradicts others.
    """
    if mass not in MASSES:
        raise OptionError(f"unknown mass {mass!r}, expected one of {', '.join(MASSES)}")
    chosen = _materials(material, materials_of or {}, csg, units, assembly.segments, evaluated)
    mesh = _in_frame(assembly.mesh, np.asarray(evaluated.frame, dtype=np.float64))
    by_joint = _by_joint(joint_couplings or {}, assembly)
    coupled = make_couplings(assembly.ties, mesh, mesh.nodes, coupling, assembly.sections, by_joint)
    properties = tuple(_property(segment, assembly, chosen[segment.id]) for segment in assembly.segments)
    if mass == "exact":
        properties = _weighed(properties, assembly.segments, mesh)
    return Model(
        title=title,
        units=units.name,
        rule_base=rule_base,
        mesh=mesh,
        properties=properties,
        materials={each.name: each for each in chosen.values()},
        couplings=coupled.couplings,
        sets=_sets(csg, assembly.segments, mesh),
        notes=(*assembly.warnings, *_lost_couplings(by_joint, assembly), *coupled.notes),
    )


def clean_coordinates(points: NDArray[np.float64], size: float) -> NDArray[np.float64]:
    """Coordinates rounded to COORDINATE_DIGITS of the size, never -0."""
    decimals = COORDINATE_DIGITS - int(np.ceil(np.log10(size))) if size > 0 else COORDINATE_DIGITS
    return np.round(points, decimals) + 0.0


def _in_frame(mesh: Mesh, frame: NDArray[np.float64]) -> Mesh:
    size = float(np.linalg.norm(np.ptp(mesh.nodes, axis=0))) if mesh.n_node else 0.0
    nodes = clean_coordinates(mesh.nodes @ frame.T, size)
    blocks = tuple(_block_in_frame(block, frame) for block in mesh.blocks)
    nodes.flags.writeable = False
    return Mesh(nodes, blocks)


def _block_in_frame(block: ElementBlock, frame: NDArray[np.float64]) -> ElementBlock:
    if block.orientation is None:
        return block
    return replace(block, orientation=clean_coordinates(block.orientation @ frame.T, 1.0))


def _property(segment: Segment, assembly: Assembly, material: Material) -> Property:
    kind = _KINDS[segment.type]
    section = assembly.sections.get(segment.id)
    if kind == "beam" and section is None:
        raise DefectError(f"beam {segment.id} has no section")
    return Property(
        segment=segment.id,
        kind=kind,
        material=material.name,
        thickness=segment.thickness if kind == "shell" else None,
        section=section if kind == "beam" else None,
    )


def _weighed(properties: Sequence[Property], segments: Sequence[Segment], mesh: Mesh) -> tuple[Property, ...]:
    """Density factors: the segment's true volume over its elements'."""
    meshed = dict.fromkeys((segment.id for segment in segments), 0.0)
    by_segment = {element.segment: element for element in properties}
    for block in mesh.blocks:
        meshed[block.segment] += block_moments(block, mesh.nodes, by_segment[block.segment], 1.0).mass
    return tuple(
        replace(element, density_factor=segment.volume / meshed[segment.id])
        for element, segment in zip(properties, segments)
    )


def _materials(
    general: str | None,
    wanted: Mapping[str, str],
    csg: CsgModel,
    units: UnitSet,
    segments: Sequence[Segment],
    evaluated: Evaluated,
) -> dict[str, Material]:
    """The material of each segment, by id."""
    found = {address: choose_material(name, csg, units) for address, name in wanted.items()}
    own = by_segment(found, evaluated, segments, "material")
    result = {name: material for name, (material, _) in own.items()}
    others = [segment.id for segment in segments if segment.id not in own]
    if others:
        result |= dict.fromkeys(others, choose_material(general, csg, units))
    return result


def _by_joint(wanted: Mapping[str, str], assembly: Assembly) -> Mapping[str, str]:
    known = [joint.id for joint in assembly.joints]
    for joint in wanted:
        if joint not in known:
            raise OptionError(f"no joint {joint!r} in the model, expected one of {', '.join(known) or 'none'}")
    return wanted


def _lost_couplings(wanted: Mapping[str, str], assembly: Assembly) -> list[str]:
    """A line where couplings are asked of joints that are apart."""
    lost = [f"{joint} ({kind})" for joint, kind in wanted.items() if joint in assembly.apart]
    if not lost:
        return []
    return [
        f"{', '.join(lost)}: no coupling, for what meets there is meshed apart; expected a coupling or apart, not both"
    ]


def _sets(csg: CsgModel, segments: Sequence[Segment], mesh: Mesh) -> tuple[NamedSet, ...]:
    """A set for each named CSG node that has segments at or under it, then one for each segment.

    A name that stands more than once in the tree is written with its path: FOOT_0_1.
    """
    named = [(node.name, path) for path, node in walk(csg.root) if node.name]
    counts: dict[str, int] = {}
    for name, _ in named:
        counts[name] = counts.get(name, 0) + 1
    wanted: list[tuple[str, list[str]]] = []
    for name, path in named:
        inside = [segment.id for segment in segments if is_under(segment.node, path)]
        if inside:
            unique = name if counts[name] == 1 else f"{name}_{'root' if path == '/' else path.replace('.', '_')}"
            wanted.append((unique, inside))
    wanted += [(segment.id, [segment.id]) for segment in segments]
    parts = _elements_and_nodes(mesh)
    return tuple(_named_set(name, [parts[segment] for segment in inside]) for name, inside in wanted)


def _elements_and_nodes(mesh: Mesh) -> dict[str, tuple[NDArray[np.int64], NDArray[np.int64]]]:
    """By segment: its elements, numbered over all blocks, and its nodes."""
    elements: dict[str, list[NDArray[np.int64]]] = {}
    nodes: dict[str, list[NDArray[np.int64]]] = {}
    start = 0
    for block in mesh.blocks:
        elements.setdefault(block.segment, []).append(np.arange(start, start + len(block.connectivity)))
        nodes.setdefault(block.segment, []).append(block.connectivity.ravel())
        start += len(block.connectivity)
    return {name: (np.concatenate(elements[name]), np.unique(np.concatenate(nodes[name]))) for name in elements}


def _named_set(name: str, parts: Sequence[tuple[NDArray[np.int64], NDArray[np.int64]]]) -> NamedSet:
    elements, nodes = zip(*parts)
    return NamedSet(name, np.unique(np.concatenate(nodes)), np.sort(np.concatenate(elements)))
