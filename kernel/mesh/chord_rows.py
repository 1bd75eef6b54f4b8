"""Rows of the ledger for what straight edges and flat elements leave out of walls, or add to them.

In the sheet, a wall's elements fill the polygon of its nodes, where its region ends on true curves: the chords. On a
cylinder each element is smaller in space than the piece of the sheet that it stands for: the flattening. Both are
found from the curves and element by element, not as what is missing, so that a mesh with a hole in it has no row.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.ledger import NEGLIGIBLE, outline_area
from kernel.idealise.ledger_row import CHORDS, LedgerRow
from kernel.idealise.parts import Parts
from kernel.idealise.sheets import Sheet
from kernel.idealise.topology import BOUNDARY
from kernel.idealise.walls import Wall
from kernel.mesh.faces import CurvesByFace, SeededCurve
from kernel.mesh.mesh import ElementBlock, Mesh
from kernel.mesh.order import middle_nodes
from kernel.mesh.period import shortest_way
from kernel.mesh.shapes import integration_rule, jacobians, measures

Array = NDArray[np.float64]

CAUSE = "straight edges and flat elements in place of its curves"

DEPTH = ((0, 0), (0, 0), (0, 1))
"""Makes places in a sheet places in space."""

NOTABLE = 5e-3
"""Share of the model's volume from which on it is warned of: the limit on the mass."""


def chord_rows(parts: Parts, curves: CurvesByFace, mesh: Mesh) -> list[LedgerRow]:
    """A row for each wall whose elements do not have the volume of its region.

    curves: by face. mesh: of all segments, of either order.
    """
    middles: dict[tuple[int, int], int] = {}
    if any(block.kind in ("quad8", "tri6") for block in mesh.blocks):
        middles = middle_nodes(mesh)
    blocks: dict[str, list[ElementBlock]] = {}
    for block in mesh.blocks:
        blocks.setdefault(block.segment, []).append(block)
    rows = []
    for name, wall in parts.walls.items():
        own = curves[wall.index]
        if wall.sheet.turn is None and not any(seeded.is_curved for seeded in own):
            continue
        area = _enclosed(wall, own, mesh.nodes, middles) - outline_area(parts.topology, wall.sheet, wall.outline)
        if wall.sheet.turn is not None:
            area += sum(_flattening(wall.sheet, mesh.nodes[block.connectivity], block.kind) for block in blocks[name])
        volume = area * wall.thickness
        if abs(volume) > NEGLIGIBLE * wall.segment.volume:
            rows.append(LedgerRow((name,), CAUSE, volume, {name: volume}, CHORDS))
    return rows


def coarse_walls(rows: Sequence[LedgerRow], volume: float) -> list[str]:
    """A line where they come to much of the model's volume, with the wall that has most of it."""
    share = sum(row.volume for row in rows) / volume
    if abs(share) <= NOTABLE:
        return []
    worst = max(rows, key=lambda row: abs(row.volume)).segments[0]
    return [
        f"straight edges in place of curves change the volume by {share:+.1%}, most of it in {worst}; smaller "
        "elements, more of them round a circle or second order follow the curves better"
    ]


def _enclosed(wall: Wall, curves: Sequence[SeededCurve], nodes: Array, middles: Mapping[tuple[int, int], int]) -> float:
    """Area in the sheet within the wall's boundary edges: polygons, or pieces of parabolas of second order."""
    area = 0.0
    for seeded in curves:
        use = seeded.curve.uses[wall.index]
        if use.role != BOUNDARY:
            continue
        chain = seeded.nodes if use.forward else seeded.nodes[::-1]
        first, last = wall.sheet.flat(nodes[chain[:-1]]), wall.sheet.flat(nodes[chain[1:]])
        along = _way(wall.sheet, first, last)
        low = first + 0.5 * along
        area -= float((along[:, 0] * low[:, 1]).sum())
        if middles:
            pairs = zip(np.minimum(chain[:-1], chain[1:]).tolist(), np.maximum(chain[:-1], chain[1:]).tolist())
            bulge = _way(wall.sheet, low, wall.sheet.flat(nodes[[middles[pair] for pair in pairs]]))
            area -= 2 / 3 * float((along[:, 0] * bulge[:, 1] - along[:, 1] * bulge[:, 0]).sum())
    return area


def _flattening(sheet: Sheet, places: Array, kind: str) -> float:
    """Area of the elements (n, k, 3) in space less that in the sheet."""
    count = places.shape[1]
    flat = sheet.flat(places.reshape(-1, 3)).reshape(-1, count, 2)
    flat = flat[:, :1] + _way(sheet, np.repeat(flat[:, :1], count, axis=1), flat)
    rule = integration_rule(kind)
    in_space, in_sheet = (measures(jacobians(each, rule)) @ rule.weights for each in (places, np.pad(flat, DEPTH)))
    return float((in_space - in_sheet).sum())


def _way(sheet: Sheet, first: Array, last: Array) -> Array:
    """From one place to another in the sheet, (..., 2), the shorter way round."""
    along = last - first
    if sheet.turn is not None:
        along[..., 0] = shortest_way(along[..., 0], sheet.turn)
    return along
