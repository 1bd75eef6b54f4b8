"""What the user may say about the mesh. docs/meshing.md is the table of these options for analysts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from kernel.errors import OptionError

FACES = ("quad", "tri")
VOLUMES = ("auto", "hex", "tet")
TEES = ("extend", "arms")

LEAST_PER_CIRCLE = 4
"""Fewer elements than this do not go round a circle: three chords lose 59 % of a disc."""

MOST_COUNTED = 100_000
"""More elements than this along one curve, round one circle or across one wall are surely a mistake."""


@dataclass(frozen=True, slots=True)
class MeshOptions:
    """size: target element edge in model units, None for automatic. order: 1 or 2 (tetrahedra are always tet10).

    faces: shells of quads or of triangles. volumes: hexes where a brick can be swept or turned ("auto"), hexes or a
    refusal ("hex"), tetrahedra always ("tet"). sizes: target size by segment id, CSG node path or name; the deepest
    node wins, a segment's own id over both. curve_sizes, seeds: largest element edge along, and exact number of
    elements on, the curves that a text names (kernel/mesh/curve_choice.py). growth: most that an element may be larger
    than the one before it, away from small ones. per_circle: fewest elements round a full circle. layers: fewest
    elements across a brick, along its sweep and across the walls of its section. deadline: seconds that one tetrahedral
    mesh may take. tee: walls that end in another are carried on to its mid-surface ("extend"), or stop at its face and
    hang from it by rigid arms ("arms"). joint_tees: by joint id, where one differs.
    """

    size: float | None = None
    order: int = 1
    faces: str = "quad"
    volumes: str = "auto"
    sizes: Mapping[str, float] = field(default_factory=dict)
    curve_sizes: Mapping[str, float] = field(default_factory=dict)
    seeds: Mapping[str, int] = field(default_factory=dict)
    growth: float | None = None
    per_circle: int | None = None
    layers: int | None = None
    deadline: float = 300.0
    tee: str = "extend"
    joint_tees: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """OptionError where a value is outside its range."""
        if self.size is not None:
            _check_length("size", self.size)
        for address, size in self.sizes.items():
            _check_length(f"size of {address!r}", size)
        for curves, size in self.curve_sizes.items():
            _check_length(f"curve size of {curves!r}", size)
        for curves, count in self.seeds.items():
            _check_count(f"seeds of {curves!r}", count, 1)
        if self.order not in (1, 2):
            raise OptionError(f"order is {self.order}, expected 1 or 2")
        if self.faces not in FACES:
            raise OptionError(f"faces is {self.faces!r}, expected one of {', '.join(FACES)}")
        if self.volumes not in VOLUMES:
            raise OptionError(f"volumes is {self.volumes!r}, expected one of {', '.join(VOLUMES)}")
        for name, tee in [("tee", self.tee), *((f"tee of {name}", tee) for name, tee in self.joint_tees.items())]:
            if tee not in TEES:
                raise OptionError(f"{name} is {tee!r}, expected one of {', '.join(TEES)}")
        if self.growth is not None and not 1 < self.growth < math.inf:
            raise OptionError(f"growth is {self.growth:g}, expected a ratio above 1, such as 1.2")
        if self.per_circle is not None:
            _check_count("per_circle", self.per_circle, LEAST_PER_CIRCLE)
        if self.layers is not None:
            _check_count("layers", self.layers, 1)


def _check_length(what: str, value: float) -> None:
    if not 0 < value < math.inf:
        raise OptionError(f"{what} is {value:g}, expected a positive number")


def _check_count(what: str, value: int, least: int) -> None:
    if isinstance(value, bool) or not isinstance(value, int) or not least <= value <= MOST_COUNTED:
        raise OptionError(f"{what} is {value}, expected a whole number from {least} to {MOST_COUNTED}")
