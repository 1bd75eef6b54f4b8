r"""Regions simple enough for a structured mesh: no irregular node, or the few that the shape asks for.

    four sides, opposite     three sides:        a disc: a square core        two rings of as many
    ones divided alike:      three blocks        in four blocks (O-grid)      edges: layers between
    +--+--+--+                     /\                 .-----.                    .-----.
    |  |  |  |                    /\/\               /\     /\                 / .---. \
    +--+--+--+                   /  |  \             |  +---+  |                | |   | |
    |  |  |  |                  /   |   \            |  +---+  |                 \ '---' /
    +--+--+--+                 +----+----+            \/     \/                   '-----'
                                                        '-----'
Every block is a transfinite interpolation of its four sides (Gordon and Hall 1973). A result is smoothed where that
helps and taken only if its worst quad is good; all else goes to the general mesher.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kernel.mesh.period import shortest_way
from kernel.mesh.region import Region, RegionMesh

Points = NDArray[np.float64]
Grid = NDArray[np.int64]

_LEAST_QUALITY = 0.6
"""Scaled Jacobian of the worst quad that a structured mesh may have."""
_SMOOTH_UNDER = 0.8
_CORNER = math.radians(40)
_ROUND_CORNER = math.radians(60)
"""A ring turns a corner where it turns by more than this; by the second where both edges belong to arcs."""
_MOST_ASPECT = 3.0
"""Layers of a tube may differ from the size by this factor before the general mesher does better."""
_CORE = 0.72
"""A disc's core has its corners at this share of the radius, and sides a third of the way from straight to round:
about 120 degrees in its corners, so that the three quads that meet there share the turn."""
_BULGE = 1 / 3
_LAYERED = 0.35
"""Mean share of the radius between core and circle."""


def structured_mesh(region: Region, size: float) -> RegionMesh | None:
    """The structured quad mesh of a simple region, None where there is none that is good."""
    if not region.is_boundary.all() or len(np.unique(region.edges)) != len(region.points):
        return None  # imprints or hard points
    rings = _rings(region)
    if rings is None or len(rings) > 2:
        return None
    if region.period is not None or len(rings) == 2:
        mesh = _layers(region, rings, size) if len(rings) == 2 else None
    else:
        mesh = _one_ring(region, rings[0], size)
    if mesh is None:
        return None
    if region.period is None and _worst(mesh, None) < _SMOOTH_UNDER:
        from kernel.mesh.smoothing import smooth

        smooth(mesh.points, mesh.quads, np.arange(len(mesh.points)) < len(region.points))
    return mesh if _worst(mesh, region.period) >= _LEAST_QUALITY else None


def _rings(region: Region) -> list[Grid] | None:
    """Points of each boundary ring in order, the region on the left; None where rings touch."""
    after = np.full(len(region.points), -1, np.int64)
    after[region.edges[:, 0]] = region.edges[:, 1]
    if (np.bincount(region.edges[:, 0], minlength=len(after)) != 1).any():
        return None
    rings: list[Grid] = []
    is_seen = np.zeros(len(after), np.bool_)
    while not is_seen.all() and len(rings) < 3:
        ring: list[int] = [int(is_seen.argmin())]
        while not is_seen[ring[-1]]:
            is_seen[ring[-1]] = True
            ring.append(int(after[ring[-1]]))
        rings.append(np.array(ring[:-1]))
    return rings


def _worst(mesh: RegionMesh, period: float | None) -> float:
    """Smallest sine of the quads' corners, negative where one is reflex."""
    x = mesh.points[mesh.quads]
    edge = np.roll(x, -1, 1) - x
    if period is not None:
        edge[..., 0] = shortest_way(edge[..., 0], period)
    back = np.roll(edge, 1, 1)
    cross = back[..., 0] * edge[..., 1] - back[..., 1] * edge[..., 0]
    return float((cross / (np.hypot(*edge.T) * np.hypot(*back.T)).T).min())


def _quads_of(grid: Grid) -> Grid:
    """Quads of a block of node numbers (rows, columns), counter-clockwise where rows run along x and columns y."""
    return np.column_stack([grid[:-1, :-1].ravel(), grid[1:, :-1].ravel(), grid[1:, 1:].ravel(), grid[:-1, 1:].ravel()])


class _Blocks:
    """Nodes and quads of blocks that share their sides."""

    def __init__(self, points: Points) -> None:
        self.points = [points]
        self.quads: list[Grid] = []
        self.n_point = len(points)

    def add(self, points: Points) -> Grid:
        """Numbers of new nodes."""
        self.points.append(points)
        self.n_point += len(points)
        return np.arange(self.n_point - len(points), self.n_point)

    def line(self, a: int, b: int, n: int) -> Grid:
        """n + 1 node numbers on the straight line from node a to node b."""
        points = np.concatenate(self.points)
        t = np.arange(1, n)[:, None] / n
        return np.concatenate([[a], self.add(points[a] + t * (points[b] - points[a])), [b]])

    def fill(self, bottom: Grid, right: Grid, top: Grid, left: Grid) -> None:
        """A block: bottom and top from left to right, left and right from bottom to top."""
        points = np.concatenate(self.points)
        n, m = len(bottom) - 1, len(left) - 1
        u = (np.arange(n + 1) / n)[:, None, None]
        v = (np.arange(m + 1) / m)[None, :, None]
        low, high = points[bottom][:, None], points[top][:, None]
        west, east = points[left][None], points[right][None]
        a, b, c, d = (points[i] for i in (bottom[0], bottom[-1], top[-1], top[0]))
        inside = (1 - v) * low + v * high + (1 - u) * west + u * east
        inside = inside - ((1 - u) * (1 - v) * a + u * (1 - v) * b + u * v * c + (1 - u) * v * d)
        grid = np.empty((n + 1, m + 1), np.int64)
        grid[:, 0], grid[:, -1], grid[0, :], grid[-1, :] = bottom, top, left, right
        grid[1:-1, 1:-1] = self.add(inside[1:-1, 1:-1].reshape(-1, 2)).reshape(n - 1, m - 1)
        self.quads.append(_quads_of(grid))

    def mesh(self) -> RegionMesh:
        """All blocks."""
        return RegionMesh(np.concatenate(self.points), np.concatenate(self.quads), np.empty((0, 3), np.int64))


def _one_ring(region: Region, ring: Grid, size: float) -> RegionMesh | None:
    """A region of one ring: four sides, three sides, or a disc."""
    points = region.points[ring]
    forward = np.roll(points, -1, 0) - points
    backward = np.roll(forward, 1, 0)
    turn = np.arctan2(backward[:, 0] * forward[:, 1] - backward[:, 1] * forward[:, 0], (backward * forward).sum(axis=1))
    curved = np.zeros(len(region.points), np.bool_)
    curved[region.edges[:, 0]] = region.is_curved
    curved = curved[ring]
    limit = np.where(curved & np.roll(curved, 1), _ROUND_CORNER, _CORNER)
    corners = np.flatnonzero(turn > limit)
    if (turn < -limit).any():
        return None
    blocks = _Blocks(region.points)
    if len(corners) == 4:
        sides = _sides(ring, corners)
        if len(sides[0]) != len(sides[2]) or len(sides[1]) != len(sides[3]):
            return None
        blocks.fill(sides[0], sides[1], sides[2][::-1], sides[3][::-1])
    elif len(corners) == 3:
        if not _fill_triangle(blocks, _sides(ring, corners)):
            return None
    elif len(corners) == 0 and curved.all():
        if not _fill_disc(blocks, ring, size):
            return None
    else:
        return None
    return blocks.mesh()


def _sides(ring: Grid, corners: Grid) -> list[Grid]:
    """The ring's points from corner to corner, corners included."""
    turned = np.roll(ring, -corners[0])
    ends = [*(corners - corners[0]).tolist(), len(ring)]
    closed = np.append(turned, turned[0])
    return [closed[a : b + 1] for a, b in pairwise(ends)]


def _fill_triangle(blocks: _Blocks, sides: list[Grid]) -> bool:
    """Three blocks about a middle node; False where the sides' counts forbid it.

    ahead[k]: edges of side k up to its cut, which are as many as the spoke of side k - 1 has.
    """
    a, b, c = (len(side) - 1 for side in sides)
    if (a + b + c) % 2:
        return False
    ahead = ((a + b - c) // 2, (b + c - a) // 2, (c + a - b) // 2)
    if min(ahead) < 1:
        return False
    points = np.concatenate(blocks.points)
    cuts = [side[n] for side, n in zip(sides, ahead)]
    centre = int(blocks.add(points[cuts].mean(axis=0)[None])[0])
    spokes = [blocks.line(int(cuts[k]), centre, ahead[(k + 1) % 3]) for k in range(3)]
    for k in range(3):
        behind = sides[k - 1][ahead[k - 1] :][::-1]
        blocks.fill(sides[k][: ahead[k] + 1], spokes[k], spokes[k - 1], behind)
    return True


def _fill_disc(blocks: _Blocks, ring: Grid, size: float) -> bool:
    """A core of a by b quads in four blocks of layers; False for a ring too short or of an odd number."""
    n = len(ring)
    if n < 8 or n % 2:
        return False
    a = n // 4
    b = n // 2 - a
    points = np.concatenate(blocks.points)
    centre = points[ring].mean(axis=0)
    radius = float(np.hypot(*(points[ring] - centre).T).mean())
    first = int(((points[ring] - centre) @ [1.0, 1.0]).argmin())  # a core that stands upright
    sides = _sides(np.roll(ring, -first), np.array([0, a, a + b, 2 * a + b]))
    n_layer = max(1, round(_LAYERED * radius / size))
    numbers = blocks.add(centre + _CORE * (points[[side[0] for side in sides]] - centre))
    core = []
    for k, side in enumerate(sides):
        ends = numbers[k], numbers[(k + 1) % 4]
        core.append(np.concatenate([ends[:1], blocks.add(_core_side(points[side], centre)[1:-1]), ends[1:]]))
    spokes = [blocks.line(int(side[0]), int(number), n_layer) for side, number in zip(sides, numbers)]
    blocks.fill(core[0], core[1], core[2][::-1], core[3][::-1])
    for k in range(4):
        blocks.fill(sides[k], spokes[(k + 1) % 4], core[k], spokes[k])
    return True


def _core_side(arc: Points, centre: Points) -> Points:
    """The core's side below an arc of the circle."""
    t = (np.arange(len(arc)) / (len(arc) - 1))[:, None]
    straight = (1 - t) * arc[0] + t * arc[-1]
    return centre + _CORE * ((1 - _BULGE) * straight + _BULGE * arc - centre)


def _layers(region: Region, rings: list[Grid], size: float) -> RegionMesh | None:
    """Layers between two rings of as many edges: a tube's section, or a band round a cylinder."""
    outer, inner = rings
    if len(outer) != len(inner):
        return None
    inner = inner[::-1]
    points = region.points
    if region.period is None:
        if _area(points[outer]) < _area(points[inner]):
            outer, inner = inner[::-1], outer[::-1]
    elif _goes_left(points[outer], region.period):
        outer, inner = inner[::-1], outer[::-1]  # the lower ring, which runs to the right, first
    start = _nearest(points[outer[0]], points[inner], region.period)
    inner = np.roll(inner, -start)
    across = points[inner] - points[outer]
    if region.period is not None:
        across[:, 0] = shortest_way(across[:, 0], region.period)
    width = np.hypot(*across.T)
    n_layer = max(1, round(float(width.mean()) / size))
    if width.max() > _MOST_ASPECT * max(width.min(), 1e-300):
        return None
    blocks = _Blocks(points)
    rows = [outer]
    for layer in range(1, n_layer):
        row = points[outer] + across * (layer / n_layer)
        if region.period is not None:
            row[:, 0] %= region.period
            row[row[:, 0] >= region.period, 0] = 0.0
        rows.append(blocks.add(row))
    rows.append(inner)
    closed = np.column_stack([np.append(row, row[0]) for row in rows])
    blocks.quads.append(_quads_of(closed))
    return blocks.mesh()


def _area(points: Points) -> float:
    x, y = (points - points[0]).T
    return 0.5 * float((x * np.roll(y, -1) - np.roll(x, -1) * y).sum())


def _goes_left(points: Points, period: float) -> bool:
    return float(shortest_way(np.roll(points[:, 0], -1) - points[:, 0], period).sum()) < 0


def _nearest(point: Points, others: Points, period: float | None) -> int:
    away = others - point
    if period is not None:
        away[:, 0] = shortest_way(away[:, 0], period)
    return int((away**2).sum(axis=1).argmin())
