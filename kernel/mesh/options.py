"""What the user may say about the mesh. docs/meshing.md is the table of these options for analysts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

from kernel.errors import OptionError

FACES = ("quad", "tri")
VOLUMES = ("auto", "hex", "tet")
TEES = ("extend", "arms")


@dataclass(frozen=True, slots=True)
class MeshOptions:
    """size: target element edge in model units, None for automatic. order: 1 or 2 (tetrahedra are always tet10).

    faces: shells of quads or of triangles. volumes: hexes where a brick can be swept ("auto"), hexes or a refusal
    ("hex"), tetrahedra always ("tet"). sizes: target size by segment id, CSG node path or name; the deepest node
    wins, a segment's own id over both. deadline: seconds that one tetrahedral mesh may take. tee: walls that end in
    another are carried on to its mid-surface ("extend"), or stop at its face and hang from it by rigid arms ("arms").
    joint_tees: by joint id, where one differs.
    """

    size: float | None = None
    order: int = 1
    faces: str = "quad"
    volumes: str = "auto"
    sizes: Mapping[str, float] = field(default_factory=dict)
    deadline: float = 300.0
    tee: str = "extend"
    joint_tees: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """OptionError where a value is outside its range."""
        if self.size is not None:
            _check_length("size", self.size)
        for address, size in self.sizes.items():
            _check_length(f"size of {address!r}", size)
        if self.order not in (1, 2):
            raise OptionError(f"order is {self.order}, expected 1 or 2")
        if self.faces not in FACES:
            raise OptionError(f"faces is {self.faces!r}, expected one of {', '.join(FACES)}")
        if self.volumes not in VOLUMES:
            raise OptionError(f"volumes is {self.volumes!r}, expected one of {', '.join(VOLUMES)}")
        for name, tee in [("tee", self.tee), *((f"tee of {name}", tee) for name, tee in self.joint_tees.items())]:
            if tee not in TEES:
                raise OptionError(f"{name} is {tee!r}, expected one of {', '.join(TEES)}")


def _check_length(what: str, value: float) -> None:
    if not 0 < value < math.inf:
        raise OptionError(f"{what} is {value:g}, expected a positive number")
