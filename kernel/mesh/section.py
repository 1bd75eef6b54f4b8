r"""The section of a group of swept bricks, meshed cell by cell on shared seeds: discs as O-grids, rings in layers.

Two circles about one centre with nothing between them are divided alike, so that the ring between them is meshed in
layers however narrow it is; other cells are seeded as faces are, finer beside narrow gaps.

      .-----.
     / .---. \
    | ( disc) |
     \ '---' /
      '-----'

The ring's circles take the seeds of the one that asks for more, by angle. Rings are tied to one another, the narrowest
first, as long as the largest circle is at most RING_RATIO times the smallest: beyond that the seeds of the one would be
too fine or too coarse for the other.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.brick import OwnSection
from kernel.idealise.carriers import Circle
from kernel.idealise.sheets import PlaneSheet
from kernel.idealise.topology import IMPRINT, Curve, Topology, Use
from kernel.mesh.chord_loss import least_on_circles
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.faces import FaceMesh, SeededCurve, curve_middles, curves_by_face, mesh_face, odd_seeds_note
from kernel.mesh.nodes import NodeTable
from kernel.mesh.quality import scaled_jacobian
from kernel.mesh.region import RegionMesh
from kernel.mesh.seeding import SeedRules, seed_curves
from kernel.mesh.sweep import UnfitSweep

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

GOOD_ENOUGH = 0.5
OTHER_SIZES = (1.0, 0.85, 1.15, 0.7)
"""A cell with an element of a scaled Jacobian under the first is meshed at these shares of its size until it has none:
a quad with two sides on one arc, a corner of 165 degrees, is seldom there twice."""

RING_RATIO = 2.0
"""Largest ratio of radii over which circles are divided alike."""

LEAST_QUALITY = 0.1
"""Scaled Jacobian under which a section's element is worse than tetrahedra: two curves nearly touch there."""

MOST_EXCESS = 20.0
"""A section may have this many times the elements that its area and its curves ask for; more, and curves of it run so
near to each other that the elements between them are of another scale than the size."""

SAME_ANGLE = 1e-6
"""Angles, in radians, and turns that differ by less are the same."""


@dataclass(frozen=True, slots=True, eq=False)
class MeshedSection:
    """A section in its sheet's frame. cell_of: (n_quad + n_triangle,) the cell of each element, quads first.

    edges: (e, 2) points on curves that are not straight, middles: (e, 3) places amid them, on the sheet. notes: for
    the user, one line each.
    """

    mesh: RegionMesh
    cell_of: Indices
    edges: Indices
    middles: Array
    notes: tuple[str, ...] = ()

    @property
    def worst(self) -> float:
        """The least scaled Jacobian of the section's elements."""
        flat = np.pad(self.mesh.points, ((0, 0), (0, 1)))
        return _worst(self.mesh.quads, self.mesh.triangles, flat)


def mesh_section(
    name: str,
    section: OwnSection,
    sheet: PlaneSheet,
    size: float,
    faces: str,
    rules: SeedRules | None = None,
    chord_loss: float | None = None,
) -> MeshedSection:
    """All cells meshed with elements of about `size`. name: of the bricks, for errors. faces: "quad" or "tri".

    rules: what the user asks beyond that, wishes by the place in the section's list of curves. chord_loss: share of the
    area of each outline that chords of its circles may cut off, None for elements that follow the circles.

    MeshError: a cell cannot be meshed; UnfitSweep: it can, but badly.
    """
    nodes = NodeTable()  # the section's own: they stay out of the model
    rules = rules or SeedRules()
    if chord_loss is not None:
        least = least_on_circles(section.topology, section.curves, section.roundness, chord_loss)
        rules = replace(rules, fewest=least)
    curves = _seeded(section, sheet, size, nodes, rules)
    by_cell = curves_by_face(curves)
    growth = rules.rate if rules.spreads else None
    widths = {ring.cell: ring.radii[1] - ring.radii[0] for ring in _tied_rings(section.topology, section.curves)}
    meshes = []
    for cell in range(len(section.cells)):
        own = by_cell.get(cell, [])
        across = size if rules.layers is None else min(size, _layer_size(cell, own, widths, rules.layers, nodes.points))
        meshes.append(_best_of_cell(name, cell, sheet, own, across, faces, nodes, growth, section.topology.frame))
    notes = odd_seeds_note(name, curves, faces, sum(len(mesh.triangles) for mesh in meshes), "columns of wedges")
    meshed = _joined(meshes, sheet, nodes.points, curve_middles(section.topology, curves), notes)
    asked = sum(cell.polygon.area for cell in section.cells) / size**2
    asked += sum(curve.length for curve in section.curves) / size
    _refuse_unfit(meshed.mesh, sheet, size, math.inf if rules.spreads else asked)
    return meshed


def _best_of_cell(
    name: str,
    cell: int,
    sheet: PlaneSheet,
    curves: Sequence[SeededCurve],
    size: float,
    faces: str,
    nodes: NodeTable,
    growth: float | None,
    frame: Array,
) -> FaceMesh:
    """The cell meshed; where an element is poor, again at sizes a little off, and the best of these."""
    best: tuple[float, FaceMesh] | None = None
    for share in OTHER_SIZES:
        mesh = mesh_face(name, cell, sheet, curves, share * size, faces, nodes, frame, growth)
        worst = _worst(mesh.quads, mesh.triangles, nodes.points)
        if best is None or worst > best[0]:
            best = worst, mesh
        if best[0] >= GOOD_ENOUGH:
            break
    assert best is not None
    return best[1]


def _worst(quads: Indices, triangles: Indices, points: Array) -> float:
    """The least scaled Jacobian. points: (n, 3)."""
    found = [
        float(scaled_jacobian(ELEMENT_KINDS[kind], points[block]).min())
        for block, kind in ((quads, "quad4"), (triangles, "tri3"))
        if len(block)
    ]
    return min(found, default=0.0)


def _layer_size(
    cell: int, curves: Sequence[SeededCurve], widths: Mapping[int, float], layers: int, points: Array
) -> float:
    """The size within a cell: of its layers in a ring, else no larger than the edges, which follow the gaps."""
    if cell in widths:
        return widths[cell] / layers
    return max(float(np.linalg.norm(np.diff(points[seeded.nodes], axis=0), axis=1).max()) for seeded in curves)


def _refuse_unfit(mesh: RegionMesh, sheet: PlaneSheet, size: float, asked: float) -> None:
    """UnfitSweep where elements are bad, or many more than the size asks for. asked: infinite for as many as come."""
    elements = [*mesh.quads, *mesh.triangles]
    if len(elements) > MOST_EXCESS * (asked + 100):
        areas = [np.abs(_doubled_area(mesh.points[element])) for element in elements]
        place = mesh.points[elements[int(np.argmin(areas))]].mean(axis=0)
        raise UnfitSweep(
            f"its section would take {len(elements)} elements of size {size:g} instead of some {asked:.0f}: curves of "
            "it run side by side",
            sheet.lift(place[None])[0],
        )
    for block, kind in ((mesh.quads, "quad4"), (mesh.triangles, "tri3")):
        if len(block):
            quality = scaled_jacobian(ELEMENT_KINDS[kind], sheet.lift(mesh.points)[block])
            worst = int(np.argmin(quality))
            if quality[worst] < LEAST_QUALITY:
                said = f"its section has an element of scaled Jacobian {quality[worst]:.2g}: curves of it nearly touch"
                raise UnfitSweep(said, sheet.lift(mesh.points[block[worst]].mean(axis=0)[None])[0])


def _doubled_area(points: Array) -> float:
    x, y = points.T
    return float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def _joined(
    meshes: Sequence[FaceMesh],
    sheet: PlaneSheet,
    points: Array,
    middles: tuple[Indices, Array],
    notes: Sequence[str],
) -> MeshedSection:
    used = np.unique(np.concatenate([mesh.nodes for mesh in meshes]))
    quads, triangles = ([getattr(mesh, kind) for mesh in meshes] for kind in ("quads", "triangles"))
    cells = np.arange(len(meshes))
    cell_of = np.concatenate([np.repeat(cells, [len(block) for block in blocks]) for blocks in (quads, triangles)])
    numbered = (np.searchsorted(used, np.concatenate(blocks)) for blocks in (quads, triangles))
    mesh = RegionMesh(sheet.flat(points[used]), *numbered)
    return MeshedSection(mesh, cell_of, np.searchsorted(used, middles[0]), middles[1], tuple(notes))


# ---------------------------------------------------------------- seeds


def _seeded(
    section: OwnSection, sheet: PlaneSheet, size: float, nodes: NodeTable, rules: SeedRules
) -> list[SeededCurve]:
    """The curves divided; those on the two circles of a tied ring alike, but for counts that the user asks for."""
    topology, curves = section.topology, section.curves
    tied = _tied_rings(topology, curves)
    rings = {ring.cell for ring in tied}
    free = range(-1, -1 - len(curves), -1)  # a face for each curve that only bounds tied rings: no gap is seen there
    plain = []
    for curve, alone in zip(curves, free):
        uses = {cell: use for cell, use in curve.uses.items() if cell not in rings}
        plain.append(replace(curve, uses=uses or {alone: Use(IMPRINT, True)}))
    numbers = (*range(len(section.cells)), *free)
    seeded = seed_curves(
        topology, plain, dict.fromkeys(numbers, sheet), dict.fromkeys(numbers, size), nodes, rules=rules
    )
    seeded = [replace(own, curve=curve) for own, curve in zip(seeded, curves, strict=True)]
    for group in _groups(tied):
        by_angle = [[place for place, curve in enumerate(curves) if curve.carrier == carrier] for carrier in group]
        for alike in zip(*by_angle, strict=True):
            finest = max(alike, key=lambda place: len(seeded[place].nodes))
            for place in alike:
                if place != finest and (place not in rules.wishes or rules.wishes[place].count is None):
                    seeded[place] = _divided_like(topology, seeded[place], seeded[finest], nodes)
    return seeded


def _divided_like(topology: Topology, own: SeededCurve, other: SeededCurve, nodes: NodeTable) -> SeededCurve:
    """The curve with seeds at the other's shares of its length."""
    shares = (other.parameters - other.curve.start) / other.curve.length
    parameters = own.curve.start + shares * own.curve.length
    between = nodes.add(topology.carrier(own.curve.carrier).at(parameters[1:-1]))
    return replace(own, nodes=np.concatenate([own.nodes[:1], between, own.nodes[-1:]]), parameters=parameters)


@dataclass(frozen=True, slots=True)
class _Ring:
    """A cell between two circles about one centre. carriers: of the circles, the inner one first; radii: theirs."""

    cell: int
    carriers: tuple[int, int]
    radii: tuple[float, float]


def _tied_rings(topology: Topology, curves: Sequence[Curve]) -> list[_Ring]:
    """The rings whose circles shall be divided alike."""
    by_cell: dict[int, list[Curve]] = {}
    for curve in curves:
        for cell in curve.uses:
            by_cell.setdefault(cell, []).append(curve)
    rings = [ring for cell, own in sorted(by_cell.items()) if (ring := _ring_of(topology, cell, own)) is not None]
    reach = {carrier: (radius, radius) for ring in rings for carrier, radius in zip(ring.carriers, ring.radii)}
    tied = []
    for ring in sorted(rings, key=lambda ring: (ring.radii[1] / ring.radii[0], ring.cell)):
        least = min(reach[carrier][0] for carrier in ring.carriers)
        most = max(reach[carrier][1] for carrier in ring.carriers)
        if most <= RING_RATIO * least:
            tied.append(ring)
            for group in _groups(tied):
                if ring.carriers[0] in group:
                    reach.update(dict.fromkeys(group, (least, most)))
    return tied


def _ring_of(topology: Topology, cell: int, curves: Sequence[Curve]) -> _Ring | None:
    """The cell as a ring, None where it is none, or where its circles are not cut at the same angles."""
    numbers = sorted({curve.carrier for curve in curves})
    if len(numbers) != 2 or any(curve.uses[cell].role == IMPRINT for curve in curves):
        return None
    circles = [carrier for number in numbers if isinstance(carrier := topology.carrier(number), Circle)]
    if len(circles) != 2 or np.linalg.norm(circles[0].centre - circles[1].centre) > 2 * topology.tolerance:
        return None
    angles = []
    for number, circle in zip(numbers, circles):
        own = [curve for curve in curves if curve.carrier == number]
        if sum(curve.length for curve in own) < (1 - SAME_ANGLE) * circle.period:
            return None
        angles.append(np.array([curve.start / circle.radius for curve in own]))
    if len(angles[0]) != len(angles[1]) or np.abs(angles[0] - angles[1]).max() > SAME_ANGLE:
        return None
    (inner, first), (outer, second) = sorted(zip((circle.radius for circle in circles), numbers))
    return _Ring(cell, (first, second), (inner, outer))


def _groups(rings: Sequence[_Ring]) -> list[list[int]]:
    """Circles that rings tie to one another, as lists of carriers."""
    groups: list[set[int]] = []
    for ring in rings:
        touched = [group for group in groups if not group.isdisjoint(ring.carriers)]
        groups = [group for group in groups if group not in touched] + [set(ring.carriers).union(*touched)]
    return [sorted(group) for group in groups]
