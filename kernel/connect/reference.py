"""What a model is checked against: the solid that it stands for, and the curves that its faces were meshed on."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from kernel.connect.audit import connected_components
from kernel.connect.mass import Moments, block_moments, solid_moments, total
from kernel.idealise.ledger import misfits
from kernel.idealise.ledger_row import LedgerRow
from kernel.mesh.assembly import Assembly
from kernel.mesh.elements import ELEMENT_KINDS

if TYPE_CHECKING:
    from kernel.connect.model import Model
    from kernel.mesh.mesh import Mesh
    from kernel.segment.segments import Segment
    from kernel.solid.evaluate import Evaluated

NEGLIGIBLE = 1e-12
"""Ledger rows smaller than this share of the volume are rounding."""


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """size: of the model, for tolerances. solid: volume moments (density 1) of what the model stands for.

    pieces: in how many the model is to be, as `pieces_of` is. solids: the same moments by segment id, where they are
    known: a part of the model can then be checked too. curve_uses, arms: as in assembly.Assembly.
    misfits: by segment id, what is wrong with its thickness (idealise/ledger.py), where the rules chose it.
    may_coincide: segments were meshed apart and are not connected yet, so that their nodes may lie on one another.
    joined: pairs of segments that have a joint; None where that is not known.
    """

    size: float
    pieces: int
    solid: Moments
    ledger: tuple[LedgerRow, ...]
    curve_uses: NDArray[np.int64]
    arms: NDArray[np.int64] = field(default_factory=lambda: np.empty((0, 4), np.int64))
    solids: Mapping[str, Moments] = field(default_factory=dict)
    pieces_of: str = "the solid"
    misfits: Mapping[str, str] = field(default_factory=dict)
    may_coincide: bool = False
    joined: frozenset[tuple[str, str]] | None = None


def reference_of(assembly: Assembly, evaluated: Evaluated) -> Reference:
    """Of a meshed model: its solid, or the solids of its segments where not all of them were meshed."""
    facets = evaluated.solid.facets
    frame = np.asarray(evaluated.frame)
    solid = solid_moments(facets.vertices @ frame.T, facets.triangles, evaluated.solid.true_volume)
    # parts that touch within the tolerance, or over a stated gap, are one though their solids are two
    pieces = min(evaluated.solid.count_components(), assembly.pieces)
    chosen = [segment for segment in assembly.segments if segment.origin != "override"]
    whole = Reference(
        size=float(evaluated.size),
        pieces=pieces,
        solid=solid,
        ledger=assembly.ledger,
        curve_uses=assembly.curve_uses,
        arms=assembly.arms,
        misfits=misfits(assembly.ledger, chosen),
        joined=frozenset(joint.segments for joint in assembly.joints),
    )
    if assembly.only is None and not assembly.apart:
        return whole
    apart = replace(whole, pieces=assembly.pieces, pieces_of="what is meshed apart", may_coincide=True)
    if assembly.only is None:
        return apart
    solids = {segment.id: segment_moments(segment, frame) for segment in assembly.segments}
    return part_of(replace(apart, solids=solids), list(solids))


def with_solids(reference: Reference, assembly: Assembly, evaluated: Evaluated) -> Reference:
    """The same with the moments of every segment that has elements, so that segments can be taken away later."""
    frame = np.asarray(evaluated.frame)
    return replace(reference, solids={segment.id: segment_moments(segment, frame) for segment in assembly.segments})


def segment_moments(segment: Segment, frame: NDArray[np.float64]) -> Moments:
    """Volume moments of a segment's own solid, in the user's frame."""
    facets = segment.solid.facets
    return solid_moments(facets.vertices @ frame.T, facets.triangles, segment.volume)


def part_of(reference: Reference, segments: Sequence[str]) -> Reference:
    """The reference of some segments alone; their solids must be known."""
    solid = total([reference.solids[name] for name in segments])
    kept = set(segments)
    rows = []
    for row in reference.ledger:
        shares = {name: share for name, share in row.shares.items() if name in kept}
        if abs(sum(shares.values())) > NEGLIGIBLE * solid.mass:
            rows.append(replace(row, volume=sum(shares.values()), shares=shares))
    solids = {name: moments for name, moments in reference.solids.items() if name in kept}
    odd = {name: text for name, text in reference.misfits.items() if name in kept}
    return replace(reference, solid=solid, ledger=tuple(rows), solids=solids, misfits=odd)


def own_reference(model: Model) -> Reference:
    """Of a model whose solid is not known (a deck that was read): what it is now is what it is to stay.

    Its edges that are not shared by just two shell elements are taken for its curves.
    """
    elements = {element.segment: element for element in model.properties}
    parts: dict[str, list[Moments]] = {}
    for block in model.mesh.blocks:
        moments = block_moments(block, model.mesh.nodes, replace(elements[block.segment], density_factor=1.0), 1.0)
        parts.setdefault(block.segment, []).append(moments)
    solids = {name: total(of_segment) for name, of_segment in parts.items()}
    return Reference(
        size=float(np.linalg.norm(np.ptp(model.mesh.nodes, axis=0))),
        pieces=connected_components(model),
        solid=total(list(solids.values())),
        ledger=(),
        curve_uses=curve_edges(model.mesh),
        solids=solids,
        pieces_of="it was before",
        may_coincide=True,
    )


def curve_edges(mesh: Mesh) -> NDArray[np.int64]:
    """(n, 3) rows (node, node, count) of the shell edges that are not shared by two elements."""
    sides = [
        np.sort(block.connectivity[:, list(edge)], axis=1)
        for block in mesh.blocks
        if ELEMENT_KINDS[block.kind].dimension == 2
        for edge in ELEMENT_KINDS[block.kind].edges
    ]
    if not sides:
        return np.empty((0, 3), np.int64)
    edges, counts = np.unique(np.concatenate(sides), axis=0, return_counts=True)
    return np.column_stack([edges, counts])[counts != 2]


def renumbered_arms(arms: NDArray[np.int64], numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """The rows in new node numbers, -1 for nodes that are gone: rows that have one go too."""
    rows = numbers[arms].reshape(-1, 4)
    return rows[(rows >= 0).all(axis=1)]


def joined_uses(mesh: Mesh, curve_uses: NDArray[np.int64], numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """The rows after nodes of the mesh have become one: each edge is used as often as all those that it now is.

    Edges of shells that have no row are used twice, as ones inside a face are: where the edge of a web has come to lie
    on such a one of its flange, the two are used three times.
    """
    sides = [
        np.sort(block.connectivity[:, list(edge)], axis=1)
        for block in mesh.blocks
        if ELEMENT_KINDS[block.kind].dimension == 2
        for edge in ELEMENT_KINDS[block.kind].edges
    ]
    if not sides:
        return renumbered(curve_uses, numbers)
    is_joined = (np.bincount(numbers) > 1)[numbers]
    edges = np.unique(np.concatenate([ends[is_joined[ends].all(axis=1)] for ends in sides]), axis=0)
    listed = {(a, b) for a, b in np.sort(curve_uses[:, :2], axis=1).tolist()}
    inside = [(a, b, 2) for a, b in edges.tolist() if (a, b) not in listed]
    return renumbered(np.vstack([curve_uses, np.array(inside, dtype=np.int64).reshape(-1, 3)]), numbers)


def renumbered(curve_uses: NDArray[np.int64], numbers: NDArray[np.int64]) -> NDArray[np.int64]:
    """The rows in new node numbers, edges that have become one with the sum of their uses.

    numbers: (n_node,) by old number, -1 where the node is gone: its edges go too.
    """
    rows = curve_uses.copy()
    rows[:, :2] = np.sort(numbers[rows[:, :2]], axis=1)
    rows = rows[rows[:, 0] >= 0]
    edges, index = np.unique(rows[:, :2], axis=0, return_inverse=True)
    counts = np.bincount(index.ravel(), weights=rows[:, 2], minlength=len(edges)).astype(np.int64)
    return np.column_stack([edges, counts]).reshape(-1, 3)
