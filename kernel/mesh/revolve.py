"""Solids of revolution in hexahedra: a meshed profile turned about the axis, round a core swept along it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.errors import DefectError, MeshError
from kernel.idealise.revolved import RevolvedBrick
from kernel.mesh.elements import ELEMENT_KINDS
from kernel.mesh.line import LARGE_PER_TURN
from kernel.mesh.planar import mesh_region
from kernel.mesh.quality import scaled_jacobian
from kernel.mesh.region import Region, RegionMesh
from kernel.mesh.section import GOOD_ENOUGH, LEAST_QUALITY, MeshedSection, mesh_section
from kernel.mesh.seeding import SeedRules
from kernel.mesh.sweep import sweep

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

LINEAR_PER_TURN = 60
"""Linear elements to a turn at least: so many chords cut 0.18 % off a circle."""

PROFILE_LOSS = 1.6e-3
"""Share of the profile's area that chords may cut off: with what is lost round the axis under the 0.5 % to which the
mass is checked (of a ball the profile's loss counts one and a half times)."""

FINER = (1.0, 0.7, 0.5, 0.35)
"""Shares of the size that are tried for a profile until it has no poor element."""

ON_CUT = 1e-6
"""Points of the profile nearer to the cut than this share of the largest radius lie on it."""


@dataclass(frozen=True, slots=True, eq=False)
class RevolvedMesh:
    """nodes (n, 3), hexes (h, 8), wedges (w, 6); edges (e, 2) that are curved and middles (e, 3) on their curves.

    n_turn: elements to a turn.
    """

    nodes: Array
    hexes: Indices
    wedges: Indices
    edges: Indices
    middles: Array
    n_turn: int


def mesh_revolved(
    brick: RevolvedBrick, size: float, faces: str, order: int, rules: SeedRules | None = None
) -> RevolvedMesh:
    """The solid in elements of about `size`. order: that they will have. rules: what the user asks of the profile's
    layers and growth, and of the elements to a turn.

    MeshError: the profile cannot be meshed, or not well.
    """
    name = f"{brick.segment.id} ({brick.segment.node})"
    section = _profile(name, brick, size, faces, order, rules)
    usual = LINEAR_PER_TURN if order == 1 else LARGE_PER_TURN
    wanted = max(2 * math.pi * brick.largest / size, (rules and rules.per_circle) or usual)
    n_turn = 4 * math.ceil(wanted / 4 - 1e-6)
    turn = _Turn(brick)
    angles = 2 * math.pi * np.arange(n_turn) / n_turn
    nodes, hexes, wedges = sweep(section.mesh, turn.lift, angles, is_closed=True)
    edges, middles = _curved_edges(section, turn, brick, angles)
    if brick.core_radius > 0.0:
        cut = _points_on_cut(brick, section.mesh)
        around = cut[:, None] + len(section.mesh.points) * np.arange(n_turn)[None, :]
        core = _core(brick, turn, section.mesh.points[cut, 1], around, angles, len(nodes))
        nodes = np.concatenate([nodes, core.nodes])
        hexes = np.concatenate([hexes, core.hexes])
        edges, middles = np.concatenate([edges, core.edges]), np.concatenate([middles, core.middles])
    for kind, elements in (("hex8", hexes), ("wedge6", wedges)):
        if len(elements):
            quality = scaled_jacobian(ELEMENT_KINDS[kind], nodes[elements])
            worst = int(quality.argmin())
            if quality[worst] < LEAST_QUALITY:
                place = brick.section.topology.place_text(nodes[elements[worst]].mean(axis=0))
                raise MeshError(
                    f"turned about its axis it has an element of scaled Jacobian {quality[worst]:.2g} near {place}"
                )
    return RevolvedMesh(nodes, hexes, wedges, edges, middles, n_turn)


def _profile(
    name: str, brick: RevolvedBrick, size: float, faces: str, order: int, rules: SeedRules | None
) -> MeshedSection:
    """The profile's mesh. Of second order, finer where an element has two sides on one arc: bent, they are one line."""
    if order == 1:
        return mesh_section(name, brick.section, brick.sheet, size, faces, rules, PROFILE_LOSS)
    for share in FINER:
        section = mesh_section(name, brick.section, brick.sheet, share * size, faces, rules)
        if section.worst >= GOOD_ENOUGH:
            break
    return section


class _Turn:
    """From the profile's coordinates, or distances and heights, to places at an angle from the profile."""

    def __init__(self, brick: RevolvedBrick) -> None:
        axis, sheet = brick.axis, brick.sheet
        self.zero = brick.offset
        self.first, self.second = sheet.u, np.cross(axis.direction, sheet.u)
        self.along = axis.direction
        self.foot = axis.point - axis.direction * float(axis.point @ axis.direction)

    def lift(self, flat: Array, angle: float) -> Array:
        """Profile points (n, 2) turned by `angle`."""
        out = math.cos(angle) * self.first + math.sin(angle) * self.second
        return self.foot + (flat[:, :1] - self.zero) * out + flat[:, 1:] * self.along

    def place(self, across: Array, height: Array) -> Array:
        """Points (n, 2) across the axis at heights (n,)."""
        return self.foot + across[:, :1] * self.first + across[:, 1:] * self.second + height[:, None] * self.along


def _curved_edges(section: MeshedSection, turn: _Turn, brick: RevolvedBrick, angles: Array) -> tuple[Indices, Array]:
    """Edges round the axis, and those on the profile's curves in every position."""
    points, n_point, n_turn = section.mesh.points, len(section.mesh.points), len(angles)
    step = math.pi / n_turn
    flat = brick.sheet.flat(section.middles)
    edges, middles = [], []
    for k, angle in enumerate(angles.tolist()):
        here, there = k * n_point + np.arange(n_point), (k + 1) % n_turn * n_point + np.arange(n_point)
        edges += [np.stack([here, there], axis=1), section.edges + k * n_point]
        middles += [turn.lift(points, angle + step), turn.lift(flat, angle)]
    return np.concatenate(edges), np.concatenate(middles)


def _points_on_cut(brick: RevolvedBrick, mesh: RegionMesh) -> Indices:
    """The profile's points at the core's radius, lowest first."""
    off = np.abs(mesh.points[:, 0] - brick.offset - brick.core_radius)
    cut = np.flatnonzero(off < ON_CUT * brick.largest)
    return cut[np.argsort(mesh.points[cut, 1])]


def _core(
    brick: RevolvedBrick, turn: _Turn, heights: Array, around: Indices, angles: Array, first: int
) -> RevolvedMesh:
    """The core's own nodes (numbered from `first`), its hexes, and its edges on the two ends.

    heights: (n_level,) of the cut's points; around: (n_level, n_turn) their nodes in every position.
    """
    n_turn = len(angles)
    ring = brick.core_radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    numbers = np.arange(n_turn)
    region = Region(
        points=ring,
        edges=np.stack([numbers, np.roll(numbers, -1)], axis=1),
        is_boundary=np.ones(n_turn, bool),
        is_curved=np.ones(n_turn, bool),
    )
    disc = mesh_region(region, 2 * math.pi * brick.core_radius / n_turn, "quad")
    if len(disc.triangles):
        raise DefectError(f"the core's disc has {len(disc.triangles)} triangles, expected quads alone")
    inner = disc.points[n_turn:]
    low, high = brick.ends
    share = (heights - heights[0]) / (heights[-1] - heights[0])

    def level(across: Array, place: int) -> Array:
        distance = np.hypot(across[:, 0], across[:, 1])
        bottom, top = low.at(distance), high.at(distance)
        return turn.place(across, bottom + share[place] * (top - bottom))

    nodes = np.concatenate([level(inner, place) for place in range(len(heights))])
    own = first + np.arange(len(nodes)).reshape(len(heights), len(inner))
    at = np.concatenate([around, own], axis=1)
    hexes = np.concatenate([np.hstack([at[k][disc.quads], at[k + 1][disc.quads]]) for k in range(len(heights) - 1)])
    sides = np.stack([disc.quads, np.roll(disc.quads, -1, axis=1)], axis=2).reshape(-1, 2)
    sides = np.unique(np.sort(sides, axis=1), axis=0)
    middle = disc.points[sides].mean(axis=1)
    ends = (0, len(heights) - 1)
    edges = np.concatenate([at[place][sides] for place in ends])
    middles = np.concatenate([level(middle, place) for place in ends])
    return RevolvedMesh(nodes, hexes, np.empty((0, 6), np.int64), edges, middles, n_turn)
