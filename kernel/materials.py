"""Isotropic linear elastic materials: named ones with their source, or the user's own."""

from __future__ import annotations

from dataclasses import dataclass, replace

from kernel.errors import OptionError
from kernel.units import UnitSet


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
