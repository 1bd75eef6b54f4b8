"""Consistent unit sets, and the tolerances that every stage shares (all relative to the model's size)."""

from __future__ import annotations

from dataclasses import dataclass

from kernel.errors import OptionError

MODEL_TOLERANCE = 1e-7
"""Two planes, axes or radii nearer than this times the model's size are one (6-digit input is mended before)."""

VERTEX_TOLERANCE = 2e-6
"""Idealised vertices nearer than this times the model's size are merged, once, before meshing."""

ANGLE_TOLERANCE = 2e-6
"""Unit vectors whose components differ by less are parallel: what six digits in a matrix can tell apart."""

RIGID_TOLERANCE = 1e-5
"""A matrix within this of a rotation is made one: OpenSCAD prints 6 significant digits."""

VOLUME_TOLERANCE = 1e-6
"""The segments' volumes add up to the solid's within this share of it."""


@dataclass(frozen=True, slots=True)
class UnitSet:
    """A consistent set: one unit each of length, mass, time and force.

    metre, kilogram: how many metres (kilograms) the set's length (mass) unit is; time is always the second.
    """

    name: str
    length: str
    mass: str
    force: str
    stress: str
    metre: float
    kilogram: float

    @property
    def gravity(self) -> float:
        """Standard gravity, 9.80665 m/s^2 (CGPM 1901), in this set."""
        return 9.80665 / self.metre

    def stress_from_pascal(self, value: float) -> float:
        """Pa = kg / (m s^2), in this set."""
        return value / self.kilogram * self.metre

    def density_from_si(self, value: float) -> float:
        """kg / m^3, in this set."""
        return value / self.kilogram * self.metre**3

    def __str__(self) -> str:
        return f"{self.length}-{self.mass}-s-{self.force}"


_POUND_FORCE_IN_NEWTON = 4.4482216152605
UNIT_SETS: dict[str, UnitSet] = {
    unit_set.name: unit_set
    for unit_set in (
        UnitSet("mm", "mm", "t", "N", "MPa", 1e-3, 1e3),
        UnitSet("cm", "cm", "100 kg", "N", "N/cm^2", 1e-2, 1e2),
        UnitSet("m", "m", "kg", "N", "Pa", 1.0, 1.0),
        UnitSet("in", "in", "lbf*s^2/in", "lbf", "psi", 0.0254, _POUND_FORCE_IN_NEWTON / 0.0254),
        UnitSet("ft", "ft", "slug", "lbf", "psf", 0.3048, _POUND_FORCE_IN_NEWTON / 0.3048),
    )
}


def unit_set(name: str) -> UnitSet:
    """The set whose length unit is `name`; OptionError where there is none."""
    try:
        return UNIT_SETS[name.lower()]
    except KeyError:
        raise OptionError(f"unknown units {name!r}, expected one of {', '.join(UNIT_SETS)}") from None
