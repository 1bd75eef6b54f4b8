"""What the user may say about the mesh."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from kernel.errors import OptionError

FACES = ("quad", "tri")
VOLUMES = ("auto", "hex", "tet")


@dataclass(frozen=True, slots=True)
class MeshOptions:
    """size: target element edge in model units, None for automatic. order: 1 or 2 (tetrahedra are always tet10).

    faces: shells of quads or of triangles. volumes: hexes where a brick can be swept ("auto"), hexes or a refusal
    ("hex"), tetrahedra always ("tet"). segment_sizes: target size by segment id or CSG node path.
    deadline: seconds that one tetrahedral mesh may take.
    """

    size: float | None = None
    order: int = 1
    faces: str = "quad"
    volumes: str = "auto"
    segment_sizes: Mapping[str, float] = field(default_factory=dict)
    deadline: float = 300.0

    def __post_init__(self) -> None:
        """OptionError where a value is outside its range."""
        sizes = [("size", self.size), *((f"size of {name}", size) for name, size in self.segment_sizes.items())]
        for name, size in sizes:
            if size is not None and not 0 < size < float("inf"):
                raise OptionError(f"{name} is {size}, expected a positive number")
        if self.order not in (1, 2):
            raise OptionError(f"order is {self.order}, expected 1 or 2")
        if self.faces not in FACES:
            raise OptionError(f"faces is {self.faces!r}, expected one of {', '.join(FACES)}")
        if self.volumes not in VOLUMES:
            raise OptionError(f"volumes is {self.volumes!r}, expected one of {', '.join(VOLUMES)}")
