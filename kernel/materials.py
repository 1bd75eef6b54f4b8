"""Isotropic linear elastic materials: named ones with their source, or the user's own."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from kernel.errors import OptionError
from kernel.units import UnitSet

if TYPE_CHECKING:
    from kernel.csg.tree import CsgModel


@dataclass(frozen=True, slots=True)
class Material:
    """Elastic modulus and density in the model's unit set; `source` says where the numbers come from."""

    name: str
    elastic_modulus: float
    poisson_ratio: float
    density: float
    source: str

    @property
    def shear_modulus(self) -> float:
        """E / (2 (1 + nu))."""
        return self.elastic_modulus / (2 * (1 + self.poisson_ratio))


_SI = {
    "steel": Material("steel", 210e9, 0.3, 7850.0, "EN 1993-1-1:2005, 3.2.6; density EN 1991-1-1:2002, table A.4"),
    "stainless": Material("stainless", 200e9, 0.3, 7900.0, "EN 1993-1-4:2006, 2.1.3 (1.4301)"),
    "aluminium": Material("aluminium", 70e9, 0.3, 2700.0, "EN 1999-1-1:2007, 3.2.5"),
    "titanium": Material("titanium", 113.8e9, 0.342, 4430.0, "Ti-6Al-4V, MIL-HDBK-5J, table 5.4.1.0"),
    "concrete": Material("concrete", 33e9, 0.2, 2500.0, "C30/37, EN 1992-1-1:2004, table 3.1; EN 1991-1-1, table A.1"),
}

MATERIAL_NAMES = tuple(_SI)


def named_material(name: str, units: UnitSet) -> Material:
    """The named material in `units`; OptionError where there is none of that name."""
    try:
        si = _SI[name.lower()]
    except KeyError:
        raise OptionError(f"unknown material {name!r}, expected one of {', '.join(_SI)} or a file") from None
    return replace(
        si,
        elastic_modulus=units.stress_from_pascal(si.elastic_modulus),
        density=units.density_from_si(si.density),
    )


DEFAULT_MATERIAL = "steel"

_KEYS = {
    "elastic_modulus": ("E", "EX", "YOUNG"),
    "poisson_ratio": ("NU", "POISSON", "PR"),
    "density": ("RHO", "DENS", "DENSITY"),
}


def choose_material(option: str | None, csg: CsgModel, units: UnitSet) -> Material:
    """The material that the user asks for, else the one that the model's text defines, else steel.

    option: the name of a material of the model, or a named one. OptionError: unknown, or the model defines several.
    """
    own = {name.lower(): name for name in csg.materials}
    if option is not None:
        if option.lower() in own:
            name = own[option.lower()]
            return _material_of_model(name, csg.materials[name], units)
        return named_material(option, units)
    if len(own) > 1:
        names = ", ".join(sorted(csg.materials))
        raise OptionError(f"the model defines {len(own)} materials ({names}), expected one or the option --material")
    for name, values in csg.materials.items():
        return _material_of_model(name, values, units)
    return named_material(DEFAULT_MATERIAL, units)


def _material_of_model(name: str, values: Mapping[str, float], units: UnitSet) -> Material:
    """A `MATERIAL name(E=, NU=, RHO=)`, in the model's own units; `MATERIAL steel` alone, which a reader has given the
    named material's numbers, keeps that one's source. OptionError: a value is missing or out of range.
    """
    given = {key.upper(): float(value) for key, value in values.items()}
    found: dict[str, float] = {}
    for quantity, keys in _KEYS.items():
        present = [key for key in keys if key in given]
        if len(present) != 1:
            raise OptionError(f"material {name!r} gives {sorted(given)}, expected one value each of E, NU and RHO")
        found[quantity] = given[present[0]]
    own = checked_material(Material(name, source="the model", **found))
    if name.lower() in _SI:
        known = replace(named_material(name, units), name=name)
        if replace(own, source=known.source) == known:
            return known
    return own


def checked_material(material: Material) -> Material:
    """The material itself; OptionError where it is none (E > 0, -1 < nu < 0.5, density >= 0)."""
    if not 0 < material.elastic_modulus < float("inf"):
        raise OptionError(
            f"material {material.name!r} has E = {material.elastic_modulus:g}, expected a positive number"
        )
    if not -1 < material.poisson_ratio < 0.5:
        ratio = material.poisson_ratio
        raise OptionError(f"material {material.name!r} has NU = {ratio:g}, expected a number between -1 and 0.5")
    if not 0 <= material.density < float("inf"):
        raise OptionError(f"material {material.name!r} has RHO = {material.density:g}, expected a number not below 0")
    return material
