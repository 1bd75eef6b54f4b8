"""Sweep a meshed region through levels: quads become hexes, triangles become wedges.

Node k * n_point + p stands at point p of the region on level k. Quad 0 1 2 3 of the region becomes the hex of its
corners on one level (the bottom) and on the next (the top), in elements.py's order; a triangle likewise. The region's
elements run counter-clockwise and levels rise along its normal; where the lift mirrors, elements are turned so that
volumes are positive.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kernel.errors import MeshError, OptionError
from kernel.idealise.shares import shared_out
from kernel.mesh.region import RegionMesh


class UnfitSweep(MeshError):
    """A section that is better not swept. at: (3,) where, in the working frame: whoever catches it tells the place."""

    def __init__(self, message: str, at: NDArray[np.float64]) -> None:
        super().__init__(message)
        self.args = (message, at)  # what pickle makes it from again
        self.at = at


Lift = Callable[[NDArray[np.float64], float], NDArray[np.float64]]
"""(points (n, 2), level) -> places (n, 3)."""

_CHUNK = 4096
"""Elements checked at once: their coordinates stay in the processor's cache."""

_MIRRORED_HEX = [0, 3, 2, 1, 4, 7, 6, 5]
_MIRRORED_WEDGE = [0, 2, 1, 3, 5, 4]

_SAME_LEVEL = 1e-9
"""Levels nearer to one another than this share of their whole range are one."""


def sweep(
    section: RegionMesh,
    lift: Lift,
    levels: NDArray[np.float64],
    *,
    present: NDArray[np.bool_] | None = None,
    is_closed: bool = False,
) -> tuple[NDArray[np.float64], NDArray[np.int64], NDArray[np.int64]]:
    """(nodes (n, 3), hexes (k, 8), wedges (m, 6)), layer by layer, in the order of the section's elements.

    levels: (n_level,) increasing or decreasing. Node k * n_point + p is point p at level k, unless `present` leaves
    some out. present: (n_level - 1, n_quad + n_triangle) False where a layer lacks an element of the section, as when
    stacked bodies share layers; nodes that nothing uses are then dropped, the others keep their order.
    is_closed: the last layer runs from the last level back to the first, without nodes of its own (full turns).
    UnfitSweep: an element would be flat or inverted.
    """
    levels = np.asarray(levels, dtype=np.float64)
    n_layer = len(levels) if is_closed else len(levels) - 1
    if n_layer < 1:
        raise MeshError(f"a sweep through {len(levels)} level(s), expected at least two")
    n_point = len(section.points)
    nodes = np.concatenate([np.asarray(lift(section.points, float(level)), np.float64) for level in levels])
    low = np.arange(n_layer) * n_point
    high = (np.arange(n_layer) + 1) % len(levels) * n_point
    hexes = _layers(section.quads, low, high)
    wedges = _layers(section.triangles, low, high)
    if present is not None:
        n_quad = len(section.quads)
        hexes = hexes[np.asarray(present)[:, :n_quad].ravel()]
        wedges = wedges[np.asarray(present)[:, n_quad:].ravel()]
        nodes, (hexes, wedges) = compacted(nodes, (hexes, wedges))
    of_hexes, hex_total = _corner_volumes(nodes, hexes)
    of_wedges, wedge_total = _corner_volumes(nodes, wedges)
    if hex_total + wedge_total < 0.0:
        hexes, wedges = hexes[:, _MIRRORED_HEX], wedges[:, _MIRRORED_WEDGE]
        of_hexes, of_wedges = -of_hexes[::-1], -of_wedges[::-1]
    _refuse_folded("hex8", nodes, hexes, of_hexes[0])
    _refuse_folded("wedge6", nodes, wedges, of_wedges[0])
    return nodes, hexes, wedges


@dataclass(frozen=True, slots=True)
class LevelWish:
    """Between start and end: `count` steps exactly, or at least `least`."""

    start: float
    end: float
    count: int | None = None
    least: int = 1


def divide_levels(
    breaks: Sequence[float] | NDArray[np.float64], size: float, wishes: Sequence[LevelWish] = ()
) -> NDArray[np.float64]:
    """(n_level,) increasing levels that hold every break, with even steps of about `size` between two breaks.

    wishes: for stretches between breaks; OptionError where one cannot be had.
    """
    ordered = np.unique(np.asarray(breaks, dtype=np.float64))
    if len(ordered) < 2 or not size > 0.0:
        raise MeshError(
            f"levels between {len(ordered)} break(s) at size {size:g}, expected two breaks and a size above 0"
        )
    apart = np.append(True, np.diff(ordered) > _SAME_LEVEL * (ordered[-1] - ordered[0]))
    ordered = ordered[apart]
    counts = _counts(np.diff(ordered), size, ordered, wishes)
    steps = [np.linspace(start, end, n, endpoint=False) for (start, end), n in zip(pairwise(ordered), counts)]
    return np.concatenate([*steps, ordered[-1:]])


def _counts(
    lengths: NDArray[np.float64], size: float, ordered: NDArray[np.float64], wishes: Sequence[LevelWish]
) -> list[int]:
    counts = np.maximum(1, np.rint(lengths / size)).astype(np.int64)
    slack = _SAME_LEVEL * (ordered[-1] - ordered[0])
    fixed = np.zeros(len(counts), dtype=bool)
    for wish in sorted(wishes, key=lambda wish: wish.count is None):
        inside = (ordered[:-1] >= wish.start - slack) & (ordered[1:] <= wish.end + slack)
        held = int(counts[inside].sum())
        if wish.count is None:
            free = inside & ~fixed
            if held < wish.least and free.any():
                shares = np.ceil(lengths[free] / (wish.end - wish.start) * wish.least - _SAME_LEVEL)
                counts[free] = np.maximum(counts[free], shares.astype(np.int64))  # another wish may need more
            continue
        if wish.count < inside.sum() or (fixed[inside].any() and held != wish.count):
            raise OptionError(
                f"seeds of an edge along a sweep: {wish.count} elements are asked for between levels that need "
                f"{held if fixed[inside].any() else int(inside.sum())}: others that stand beside it end there"
            )
        counts[inside] = shared_out(lengths[inside], wish.count)
        fixed |= inside
    return [int(count) for count in counts]


def compacted(
    nodes: NDArray[np.float64], elements: Sequence[NDArray[np.int64]]
) -> tuple[NDArray[np.float64], list[NDArray[np.int64]]]:
    """The nodes that the elements use, in their order, and the elements on those."""
    used = np.zeros(len(nodes), bool)
    for block in elements:
        used[block.ravel()] = True
    place = np.cumsum(used) - 1
    return nodes[used], [place[block] for block in elements]


def _layers(faces: NDArray[np.int64], low: NDArray[np.int64], high: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n_layer * n_face, 2 k) the faces between each low and high level."""
    k = faces.shape[1]
    bottom = faces[None, :, :] + low[:, None, None]
    top = faces[None, :, :] + high[:, None, None]
    return np.concatenate([bottom, top], axis=2).reshape(-1, 2 * k)


def _corner_volumes(nodes: NDArray[np.float64], elements: NDArray[np.int64]) -> tuple[NDArray[np.float64], float]:
    """The least and the greatest volume that an element's edges span at its corners, (2, n), and the sum of all.

    elements: hexes (n, 8) or wedges (n, 6), bottom ring before top ring.
    """
    n = elements.shape[1] // 2
    ranges = np.empty((2, len(elements)))
    total = 0.0
    for first in range(0, len(elements), _CHUNK):
        chunk = slice(first, first + _CHUNK)
        x, y, z = (np.ascontiguousarray(nodes[elements[chunk].T, k]) for k in range(3))
        least, greatest = np.full(x.shape[1], np.inf), np.full(x.shape[1], -np.inf)
        for k in range(2 * n):
            own, other = (0, n) if k < n else (n, 0)
            ahead, back, across = own + (k + 1) % n, own + (k - 1) % n, other + k % n
            if k >= n:
                ahead, back = back, ahead
            ax, ay, az = x[ahead] - x[k], y[ahead] - y[k], z[ahead] - z[k]
            bx, by, bz = x[back] - x[k], y[back] - y[k], z[back] - z[k]
            cx, cy, cz = x[across] - x[k], y[across] - y[k], z[across] - z[k]
            volume = (ay * bz - az * by) * cx + (az * bx - ax * bz) * cy + (ax * by - ay * bx) * cz
            np.minimum(least, volume, out=least)
            np.maximum(greatest, volume, out=greatest)
            total += float(volume.sum())
        ranges[:, chunk] = least, greatest
    return ranges, total


def _refuse_folded(
    kind: str, nodes: NDArray[np.float64], elements: NDArray[np.int64], least: NDArray[np.float64]
) -> None:
    """UnfitSweep where an element's least volume at a corner is not positive."""
    bad = np.flatnonzero(~(least > 0.0))
    if len(bad):
        raise UnfitSweep(
            f"{len(bad)} of {len(elements)} swept {kind} elements would be flat or inverted",
            nodes[elements[bad[0]]].mean(axis=0),
        )
