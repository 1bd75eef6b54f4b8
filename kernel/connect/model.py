"""The connected finite element model: everything a deck needs, in the user's own frame and units."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.section import SectionProperties
from kernel.materials import Material
from kernel.mesh.mesh import Mesh


@dataclass(frozen=True, slots=True, eq=False)
class Property:
    """What the elements of one segment are made of.

    kind: "beam", "shell" or "solid". thickness for shells; section for beams (axes: y = the block's orientation
    vector `u`, z = direction x u). density_factor scales the density so that masses come out exact (1 = as is).
    """

    segment: str
    kind: str
    material: str
    thickness: float | None = None
    section: SectionProperties | None = None
    density_factor: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Rbe2:
    """dependent nodes follow `independent` rigidly in the components (1-6) listed."""

    independent: int
    dependent: NDArray[np.int64]
    components: str = "123456"


@dataclass(frozen=True, slots=True, eq=False)
class Rbe3:
    """`dependent` moves as the weighted average of the independent nodes' translations."""

    dependent: int
    independent: NDArray[np.int64]
    weights: NDArray[np.float64]
    components: str = "123456"
    independent_components: str = "123"


@dataclass(frozen=True, slots=True, eq=False)
class Mpc:
    """sum of coefficient * displacement = 0; the first term is the dependent one. components 1-6."""

    nodes: NDArray[np.int64]
    components: NDArray[np.int64]
    coefficients: NDArray[np.float64]


Coupling = Rbe2 | Rbe3 | Mpc


@dataclass(frozen=True, slots=True, eq=False)
class NamedSet:
    """Elements and nodes of a CSG node that the input names, or of a segment. element indices run over all blocks."""

    name: str
    nodes: NDArray[np.int64]
    elements: NDArray[np.int64]


@dataclass(frozen=True, slots=True, eq=False)
class Model:
    """A connected model, ready to be written and loaded.

    title, units (a unit set's name), rule_base: for the headers. mesh.nodes in the user's frame.
    properties: one per segment, same order as the segments.
    """

    title: str
    units: str
    rule_base: str
    mesh: Mesh
    properties: tuple[Property, ...]
    materials: dict[str, Material]
    couplings: tuple[Coupling, ...]
    sets: tuple[NamedSet, ...] = ()
    notes: tuple[str, ...] = field(default=())
