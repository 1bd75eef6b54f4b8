"""What idealisation and meshing hand to connection: the meshed parts, and the places where they must be tied."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kernel.connect.joints import Joint
from kernel.idealise.ledger_row import LedgerRow
from kernel.idealise.section import SectionProperties
from kernel.mesh.mesh import Mesh
from kernel.mesh.size_field import Sizes
from kernel.segment.segments import Segment

Vector = NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class Tie:
    """A set of nodes that must follow another set; connect/couplings.py chooses the equations.

    kind:
      "beam_on_face"   dependent: one beam node; independent: the nodes of a shell or solid face patch, with `weights`
                       (areas) for each. By default a weighted average (RBE3), on request rigid (RBE2) or work.
      "rigid"          dependent nodes follow one independent node rigidly in all six (offset beams on plates, beam
                       end at a through beam, plate edge at a beam).
      "rigid_pairs"    dependent[k] follows independent[k] rigidly in translations only, arm included (brick on a
                       plate's face: brick nodes have no rotations; the independent shell node's rotations count).
      "interpolated"   dependent[k] lies on (or off by an arm from) the element face hosts[k] with shape-function
                       weights host_weights[k] (lap joints, brick on brick with meshes that differ).
    """

    kind: str
    joint: Joint | None
    dependent: NDArray[np.int64]
    independent: NDArray[np.int64] = field(default_factory=lambda: np.empty(0, np.int64))
    weights: NDArray[np.float64] = field(default_factory=lambda: np.empty(0))
    hosts: tuple[NDArray[np.int64], ...] = ()
    host_weights: tuple[NDArray[np.float64], ...] = ()
    has_rotations: bool = True
    """The dependent nodes have rotations to be tied (beam and shell nodes; not nodes of solids only)."""


@dataclass(frozen=True, slots=True, eq=False)
class Assembly:
    """The meshed parts of a model, still in the working frame.

    sections: by segment id, for beams. ties: what must be coupled. ledger: double-counted corners.
    curve_uses: for the crack audit: one row per mesh edge that lies on a shared curve or free curve,
        (n_edge, 3) int64: node, node, expected number of shell element edges there.
    bricks: how each was meshed and why, by segment id.
    arms: (n_edge, 4) int64: for each element edge that hangs by rigid arms its two nodes, and the two nodes of the
        joint curve from which these hang.
    warnings: one line each (near misses, small details removed, irregular seeds).
    apart: joints across which nothing is shared or tied; only: the segments that were meshed, None for all; pieces: in
        how many parts that leaves them.
    """

    segments: tuple[Segment, ...]
    joints: tuple[Joint, ...]
    mesh: Mesh
    sections: dict[str, SectionProperties]
    ties: tuple[Tie, ...]
    ledger: tuple[LedgerRow, ...] = ()
    curve_uses: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 3), np.int64))
    arms: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 4), np.int64))
    warnings: tuple[str, ...] = ()
    sizes: Sizes = field(default_factory=lambda: Sizes(0.0, "", {}))
    """The element sizes that were used, and what they come from."""
    bricks: Mapping[str, str] = field(default_factory=dict)
    apart: frozenset[str] = frozenset()
    only: frozenset[str] | None = None
    pieces: int = 1
