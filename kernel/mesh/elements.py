"""The element kinds: how many nodes, which faces and edges, of what dimension. Node orders are VTK's.

line2  0---1                quad4  3---2      hex8: bottom 0 1 2 3, top 4 5 6 7 (counter-clockwise seen from +z)
line3  0-2-1                       |   |      wedge6: bottom 0 1 2, top 3 4 5 with the bottom's normal, by the
tri3   0 1 2                       0---1              right-hand rule, pointing to the top
Second order adds mid-side nodes: tri6 (01 12 20), quad8 (01 12 23 30), tet10 (01 12 20 03 13 23),
wedge15 (01 12 20, 34 45 53, 03 14 25), hex20 (01 12 23 30, 45 56 67 74, 04 15 26 37).
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ElementKind:
    """edges: corner pairs, in the order of the mid-side nodes. faces: corner loops, normals outward for volumes."""

    name: str
    dimension: int
    n_node: int
    n_corner: int
    edges: tuple[tuple[int, int], ...]
    faces: tuple[tuple[int, ...], ...]

    @property
    def order(self) -> int:
        """1 or 2."""
        return 1 if self.n_node == self.n_corner else 2


_LINE = ((0, 1),)
_TRI = ((0, 1), (1, 2), (2, 0))
_QUAD = ((0, 1), (1, 2), (2, 3), (3, 0))
_TET = ((0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3))
_WEDGE = ((0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5))
_HEX = ((0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
_TET_FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3))
_WEDGE_FACES = ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5))
_HEX_FACES = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))

ELEMENT_KINDS: dict[str, ElementKind] = {
    kind.name: kind
    for kind in (
        ElementKind("line2", 1, 2, 2, _LINE, ()),
        ElementKind("line3", 1, 3, 2, _LINE, ()),
        ElementKind("tri3", 2, 3, 3, _TRI, ((0, 1, 2),)),
        ElementKind("tri6", 2, 6, 3, _TRI, ((0, 1, 2),)),
        ElementKind("quad4", 2, 4, 4, _QUAD, ((0, 1, 2, 3),)),
        ElementKind("quad8", 2, 8, 4, _QUAD, ((0, 1, 2, 3),)),
        ElementKind("tet4", 3, 4, 4, _TET, _TET_FACES),
        ElementKind("tet10", 3, 10, 4, _TET, _TET_FACES),
        ElementKind("wedge6", 3, 6, 6, _WEDGE, _WEDGE_FACES),
        ElementKind("wedge15", 3, 15, 6, _WEDGE, _WEDGE_FACES),
        ElementKind("hex8", 3, 8, 8, _HEX, _HEX_FACES),
        ElementKind("hex20", 3, 20, 8, _HEX, _HEX_FACES),
    )
}

SECOND_ORDER: dict[str, str] = {
    "line2": "line3", "tri3": "tri6", "quad4": "quad8", "tet4": "tet10", "wedge6": "wedge15", "hex8": "hex20",
}  # fmt: skip
