"""The CSG tree: frozen values, each with the place where the input wrote it.

A node is a primitive or a Boolean with at least two operands; placements, colours and groups of one child are
no nodes of their own. Readers push every placement down to the primitives, so a primitive's `placement` maps
its standard position straight into the model, and Booleans carry none.

    CsgNode
     +- Primitive: Block Cylinder Cone Wedge Sphere Torus Extrusion Revolution Polyhedron Hull
     +- Boolean: union, difference (first operand less the others), intersection
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kernel.errors import AmbiguousNameError, OverrideError, Place
from kernel.words import did_you_mean

Matrix = NDArray[np.float64]

IDENTITY: Matrix = np.eye(4)
IDENTITY.flags.writeable = False

BOOLEANS = ("union", "difference", "intersection")


def frozen_array(values: object, dtype: type = np.float64) -> NDArray:
    """A C-contiguous copy of `values` that cannot be written to."""
    array: NDArray = np.array(values, dtype=dtype, order="C")
    array.flags.writeable = False
    return array


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class CsgNode:
    """An item of the tree. `name`: what the input calls it, or None. `place`: where it stands, or None."""

    name: str | None = None
    place: Place | None = None

    kind = "node"

    @property
    def operands(self) -> tuple[CsgNode, ...]:
        """The operands of a Boolean; none for a primitive."""
        return ()


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Boolean(CsgNode):
    """Union, difference or intersection of two or more operands."""

    operation: str
    children: tuple[CsgNode, ...]

    @property
    def kind(self) -> str:  # type: ignore[override]
        """`union`, `difference` or `intersection`."""
        return self.operation

    @property
    def operands(self) -> tuple[CsgNode, ...]:
        """Two or more nodes, in the order of the input."""
        return self.children


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Primitive(CsgNode):
    """A solid in standard position, put into the model by `placement` ((4, 4), affine, last row 0 0 0 1)."""

    placement: Matrix = field(default_factory=lambda: IDENTITY)

    kind = "primitive"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Block(Primitive):
    """0..size in x, y, z."""

    size: tuple[float, float, float]
    kind = "block"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cylinder(Primitive):
    """Base on z=0, axis +z."""

    radius: float
    height: float
    kind = "cylinder"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Cone(Primitive):
    """Base on z=0, axis +z; one of the radii may be 0, and they differ."""

    bottom_radius: float
    top_radius: float
    height: float
    kind = "cone"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Wedge(Primitive):
    """The right triangle (0,0), (x,0), (0,y), extruded from z=0 to z."""

    size: tuple[float, float, float]
    kind = "wedge"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Sphere(Primitive):
    """Centred at the origin."""

    radius: float
    kind = "sphere"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Torus(Primitive):
    """Centred at the origin, axis z; minor radius less than major radius."""

    major_radius: float
    minor_radius: float
    kind = "torus"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Extrusion(Primitive):
    """A polygon in z=0 extruded to z=height, turned by `twist` degrees and then scaled on the way.

    loops: one or more (n, 2) arrays, filled by the even-odd rule; an outer loop counter-clockwise, holes clockwise.
    twist: degrees over the whole height, clockwise seen from above as OpenSCAD has it; 0 for a prism.
    scale: (x, y) factors at the top; (1, 1) for a prism, (0, 0) for a point.
    slices: number of layers when twisted.
    """

    loops: tuple[Matrix, ...]
    height: float
    twist: float = 0.0
    scale: tuple[float, float] = (1.0, 1.0)
    slices: int = 1
    kind = "extrusion"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Revolution(Primitive):
    """A polygon in the half-plane x >= 0, its y becoming z, turned about z by `angle` degrees (0 < angle <= 360).

    loops: as for Extrusion, x = radius, y = height. facets: flat sides of a full turn, or 0 for a true revolution.
    """

    loops: tuple[Matrix, ...]
    angle: float = 360.0
    facets: int = 0
    kind = "revolution"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Polyhedron(Primitive):
    """Closed surface of planar polygons. points: (n, 3); faces: tuples of point indices, clockwise from outside."""

    points: Matrix
    faces: tuple[tuple[int, ...], ...]
    kind = "polyhedron"


@dataclass(frozen=True, slots=True, eq=False, kw_only=True)
class Hull(Primitive):
    """Convex hull of `members` (trees of their own, already placed in the model: `placement` is the identity).

    The members are no nodes of the tree: they are not addressed by path.
    """

    members: tuple[CsgNode, ...]
    kind = "hull"


@dataclass(frozen=True, slots=True, eq=False)
class CsgModel:
    """What a reader gives.

    source: name of the file, "-" for standard input. language: "openscad", "padl" or "json".
    units: name of a unit set, or None where the input does not say. materials: name -> properties as written.
    """

    root: CsgNode
    source: str
    language: str
    units: str | None = None
    materials: dict[str, dict[str, float]] = field(default_factory=dict)


def walk(root: CsgNode) -> Iterator[tuple[str, CsgNode]]:
    """Every (path, node), parents first, operands in order. Not recursive: trees may be deep."""
    stack: list[tuple[str, CsgNode]] = [("/", root)]
    while stack:
        path, node = stack.pop()
        yield path, node
        stack.extend((child_path(path, index), operand) for index, operand in reversed(list(enumerate(node.operands))))


def child_path(path: str, index: int) -> str:
    """Path of operand `index` of the node at `path`."""
    return str(index) if path == "/" else f"{path}.{index}"


def find(root: CsgNode, address: str) -> tuple[str, CsgNode]:
    """The (path, node) that `address` means: a path ("/", "0.2.1") or a name that stands once.

    OverrideError: nothing has that address. AmbiguousNameError: a name stands more than once.
    """
    named: list[tuple[str, CsgNode]] = []
    for path, node in walk(root):
        if path == address:
            return path, node
        if node.name is not None and node.name.upper() == address.upper():
            named.append((path, node))
    if len(named) == 1:
        return named[0]
    if named:
        paths = ", ".join(path for path, _ in named)
        raise AmbiguousNameError(f"the name {address!r} stands {len(named)} times, expected one of the paths {paths}")
    names = [node.name for _, node in walk(root) if node.name is not None]
    raise OverrideError(
        f"no node {address!r} in the model, expected '/', a path such as '0.1', or a node's name"
        f"{did_you_mean(address, names)} (csgmesh tree shows them)"
    )
