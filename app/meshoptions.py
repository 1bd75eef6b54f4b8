"""The options of a mesh in words: what the command line writes as text, and the service as JSON, as MeshOptions.

A mapping is written NAME=VALUE on the command line, once for each entry, and {"NAME": VALUE} in JSON.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from typing import Any

from kernel.csg.tree import CsgModel
from kernel.errors import OptionError
from kernel.mesh.curve_names import check_curve_names
from kernel.mesh.options import TEES, MeshOptions
from kernel.segment.addresses import check_addresses
from kernel.units import UnitSet

ASKED = tuple(field.name for field in fields(MeshOptions) if field.name not in ("deadline", "joint_tees"))
"""The options that a user may give, by the names that HTTP has for them; `joints` is for couplings and tees alike."""

_JOINT_ID = re.compile(r"j[1-9]\d*")


def asked(given: object) -> dict[str, Any]:
    """The mesh options among the attributes of a request, checked: OptionError where one is outside its range."""
    options = {name: getattr(given, name) for name in ASKED}
    MeshOptions(**options)
    return options


def split_joints(said: Mapping[str, str]) -> tuple[dict[str, str], dict[str, str]]:
    """What was said of single joints, by id: couplings ("apart" for none), and ways to make a tee.

    OptionError: neither of these.
    """
    from app.pipeline import APART
    from kernel.connect.couplings import COUPLINGS

    couplings = {joint: value for joint, value in said.items() if value not in TEES}
    for value in couplings.values():
        if value not in (*COUPLINGS, APART):
            raise OptionError(
                f"unknown coupling {value!r}, expected one of {', '.join((*COUPLINGS, APART))}, "
                f"or {' or '.join(TEES)} for a tee"
            )
    return couplings, {joint: value for joint, value in said.items() if value in TEES}


def read_options(
    *, size_of: Sequence[str] | None, curve_size: Sequence[str] | None, seeds: Sequence[str] | None, **plain: Any
) -> MeshOptions:
    """The mesh options that a command line asks for; plain: those that need no reading, by MeshOptions' own names."""
    return MeshOptions(
        sizes=lengths(size_of, "--size-of", "NODE=SIZE", "TOP=20"),
        curve_sizes=lengths(curve_size, "--curve-size", "CURVES=SIZE", "HOLE=2"),
        seeds=counts(seeds, "--seeds", "CURVES=COUNT", "TOP&LEG=8"),
        **plain,
    )


def check_coupling_and_mass(coupling: str, mass: str) -> None:
    """OptionError for a coupling or a way to weigh that there is none of."""
    from kernel.connect.build import MASSES
    from kernel.connect.couplings import COUPLINGS

    if coupling not in COUPLINGS:
        raise OptionError(f"unknown coupling {coupling!r}, expected one of {', '.join(COUPLINGS)}")
    if mass not in MASSES:
        raise OptionError(f"unknown mass {mass!r}, expected one of {', '.join(MASSES)}")


def check_materials(material: str | None, materials_of: Mapping[str, str], csg: CsgModel, units: UnitSet) -> None:
    """OptionError where a material that is asked for, of all segments or of some, is none.

    Where every segment may have one of its own, a model that defines several needs none for all.
    """
    from kernel.materials import choose_material

    for name in materials_of.values():
        choose_material(name, csg, units)
    if material is not None or not materials_of:
        choose_material(material, csg, units)


def check_names(
    options: MeshOptions,
    csg: CsgModel,
    *,
    only: Collection[str] = (),
    joints: Collection[str] = (),
    materials_of: Collection[str] = (),
    known: tuple[Sequence[str], Sequence[str]] | None = None,
) -> None:
    """OptionError for what is already known to be of no node, segment or joint: said before anything is computed.

    only, joints, materials_of: as they are asked for. known: ids of the segments and of the joints, None before the
    model is classified: then whatever looks like such an id passes, and is looked at once they are known.
    """
    segments = None if known is None else known[0]
    check_addresses(options.sizes, csg.root, "size", segments)
    check_addresses(only, csg.root, "only", segments)
    check_addresses(materials_of, csg.root, "material", segments)
    check_curve_names(options.curve_sizes, csg.root, "curve size", segments)
    check_curve_names(options.seeds, csg.root, "seeds", segments)
    for joint in (*joints, *options.joint_tees):
        if known is not None and joint not in known[1]:
            raise OptionError(f"no joint {joint!r} in the model, expected one of {', '.join(known[1]) or 'none'}")
        if not _JOINT_ID.fullmatch(joint):
            raise OptionError(f"no joint {joint!r}, expected an id such as j3")


def by_name(given: Sequence[str] | None, option: str, form: str, example: str) -> dict[str, str]:
    """NAME=VALUE by name; OptionError where one is written otherwise or a name stands twice."""
    found: dict[str, str] = {}
    for text in given or []:
        name, equals, value = (part.strip() for part in text.rpartition("="))
        if not equals or not name or not value:
            raise OptionError(f"{option} {text!r}: expected {form}, such as {example}")
        if name in found:
            raise OptionError(f"{option} {text!r}: {name} is given twice, expected once")
        found[name] = value
    return found


def lengths(given: Sequence[str] | None, option: str, form: str, example: str) -> dict[str, float]:
    """NAME=LENGTH by name."""
    read = by_name(given, option, form, example)
    return {name: _number(text, option, name, float, "a number") for name, text in read.items()}


def counts(given: Sequence[str] | None, option: str, form: str, example: str) -> dict[str, int]:
    """NAME=COUNT by name."""
    read = by_name(given, option, form, example)
    return {name: _number(text, option, name, int, "a whole number") for name, text in read.items()}


def _number(text: str, option: str, name: str, kind: type, wanted: str) -> Any:
    try:
        return kind(text)
    except ValueError:
        raise OptionError(f"{option} {name}={text}: {text!r} is wrong, expected {wanted}") from None
