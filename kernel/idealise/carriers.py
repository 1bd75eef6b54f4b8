"""Carriers: the unbounded lines, circles and intersection curves on which the model's curves lie.

Every carrier is parametrised by length (a traced one by the length of its guide), so one tolerance serves all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kernel.idealise.implicit import project
from kernel.idealise.tube_curve import TubeCurve, TubeFrame, tube_curve
from kernel.solid.surfaces import Surface, plane_frame

Array = NDArray[np.float64]

_SWEEP = np.array([0.482963, 0.836516, 0.258819])
"""A direction in no special position, along which points are sorted to find neighbours."""

_SAMPLES_PER_TURN = 192

_FINEST = 10
"""Most times that a curve is shown more densely than usual, for walls that are thin beside its radius."""

_REFINEMENTS = 3
"""Steps from the guide's nearest point to the traced curve's."""


@dataclass(frozen=True, slots=True, eq=False)
class Line:
    """point: the foot of the origin; direction: unit, its first large component positive."""

    point: Array
    direction: Array
    period = None

    def at(self, parameters: Array) -> Array:
        """Points (n, 3)."""
        return self.point + np.asarray(parameters, float)[:, None] * self.direction

    def parameters(self, points: Array) -> Array:
        """Parameters (n,) of the nearest points."""
        return points @ self.direction

    def breaks(self, start: float, end: float) -> Array:
        """Parameters between start and end at which a polyline must have a point to show the curve's shape."""
        return np.empty(0)


@dataclass(frozen=True, slots=True, eq=False)
class Circle:
    """x, y: unit vectors with x cross y = normal; the parameter is radius times the angle from x.

    samples: points by which it is shown, to a turn.
    """

    centre: Array
    normal: Array
    radius: float
    x: Array
    y: Array
    samples: int = _SAMPLES_PER_TURN

    @property
    def period(self) -> float:
        """Circumference."""
        return 2 * np.pi * self.radius

    def at(self, parameters: Array) -> Array:
        """Points (n, 3)."""
        angles = np.asarray(parameters, float) / self.radius
        return self.centre + self.radius * (np.cos(angles)[:, None] * self.x + np.sin(angles)[:, None] * self.y)

    def parameters(self, points: Array) -> Array:
        """Parameters (n,) in [0, period) of the nearest points."""
        relative = points - self.centre
        return np.mod(np.arctan2(relative @ self.y, relative @ self.x), 2 * np.pi) * self.radius

    def breaks(self, start: float, end: float) -> Array:
        """Multiples of a fixed step between start and end, the same for whoever asks."""
        step = self.period / self.samples
        return step * np.arange(np.ceil(start / step + 1e-6), np.floor(end / step - 1e-6) + 1)


@dataclass(frozen=True, slots=True, eq=False)
class Traced:
    """Where two surfaces meet: `guide` (n, 3) lies on it, points between are brought onto both by Newton's method.

    is_closed: the last guide point is joined to the first (which is not repeated). lengths: of the guide up to each
    of its points, and in the end all round.
    """

    surfaces: tuple[Surface, ...]
    guide: Array
    is_closed: bool
    lengths: Array

    @property
    def period(self) -> float | None:
        """Length of a closed guide."""
        return float(self.lengths[-1]) if self.is_closed else None

    def _corners(self) -> Array:
        return np.vstack([self.guide, self.guide[:1]]) if self.is_closed else self.guide

    def at(self, parameters: Array) -> Array:
        """Points (n, 3), on both surfaces."""
        corners = self._corners()
        values = np.asarray(parameters, float)
        if self.is_closed:
            values = np.mod(values, self.lengths[-1])
        index = np.clip(np.searchsorted(self.lengths, values, side="right") - 1, 0, len(corners) - 2)
        span = self.lengths[index + 1] - self.lengths[index]
        share = ((values - self.lengths[index]) / span)[:, None]
        return project(corners[index] * (1 - share) + corners[index + 1] * share, self.surfaces)

    def parameters(self, points: Array) -> Array:
        """Parameters (n,) of the nearest points."""
        corners = self._corners()
        start, along = corners[:-1], np.diff(corners, axis=0)
        square = np.einsum("ij,ij->i", along, along)
        result = np.empty(len(points))
        heading = np.empty((len(points), 3))
        for row, point in enumerate(points):
            share = np.clip(np.einsum("ij,ij->i", point - start, along) / square, 0, 1)
            distance = np.linalg.norm(start + share[:, None] * along - point, axis=1)
            best = int(np.argmin(distance))
            result[row] = self.lengths[best] + share[best] * np.sqrt(square[best])
            heading[row] = along[best] / np.sqrt(square[best])
        for _ in range(_REFINEMENTS):  # the nearest point of the guide is not quite that of the curve
            result = result + np.einsum("ij,ij->i", points - self.at(result), heading)
            if not self.is_closed:
                result = np.clip(result, 0.0, self.lengths[-1])
        return np.mod(result, self.lengths[-1]) if self.is_closed else result

    def breaks(self, start: float, end: float) -> Array:
        """The guide's own points between start and end."""
        values = self.lengths
        if self.is_closed:
            period = self.lengths[-1]
            first, last = int(np.floor(start / period)), int(np.floor(end / period))
            values = np.concatenate([self.lengths[:-1] + turn * period for turn in range(first, last + 1)])
        margin = 1e-6 * float(self.lengths[-1])
        return values[(values > start + margin) & (values < end - margin)]


Carrier = Line | Circle | Traced | TubeCurve


def distance_to(carrier: Carrier, points: Array) -> Array:
    """Distance (n,) of points (n, 3) from the carrier."""
    return np.linalg.norm(carrier.at(carrier.parameters(points)) - points, axis=1)


def is_curved(carrier: Carrier) -> bool:
    """Whether its pieces are no straight lines."""
    return not isinstance(carrier, Line)


class _Keys:
    """Keys of points along one direction, in cells of width `reach`; candidates for being the same are near a key."""

    def __init__(self, reach: float) -> None:
        self._reach = reach
        self._cells: dict[int, list[tuple[float, int]]] = {}

    def near(self, key: float) -> list[int]:
        """Indices whose keys are within `reach`, in order."""
        cell = math.floor(key / self._reach)
        return sorted(
            index
            for near in (cell - 1, cell, cell + 1)
            for value, index in self._cells.get(near, ())
            if abs(value - key) <= self._reach
        )

    def add(self, key: float, index: int) -> None:
        self._cells.setdefault(math.floor(key / self._reach), []).append((key, index))


class VertexTable:
    """Points merged when nearer than the tolerance; the first one of a group gives the position."""

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self.points: list[Array] = []
        self._keys = _Keys(tolerance)

    def add(self, point: Array) -> int:
        """Index of the vertex at `point` (3,)."""
        key = float(point @ _SWEEP)
        for index in self._keys.near(key):
            if np.linalg.norm(self.points[index] - point) <= self.tolerance:
                return index
        self.points.append(np.array(point, dtype=np.float64))
        self._keys.add(key, len(self.points) - 1)
        return len(self.points) - 1

    def copy(self, index: int) -> int:
        """Index of a new vertex at the same place, which no point finds."""
        self.points.append(self.points[index])
        return len(self.points) - 1


class CarrierTable:
    """Every carrier once: one that coincides with an earlier one within the tolerance gets that one's index.

    tolerance: a length. reach: the model's size, over which nearly parallel lines must stay together. chord: by how
    much a polyline that shows a curve may miss it: curves are shown as densely as that takes, within reason.
    """

    def __init__(self, tolerance: float, reach: float, chord: float = np.inf) -> None:
        self.tolerance = tolerance
        self.reach = reach
        self.chord = chord
        self.carriers: list[Carrier] = []
        # Directions may differ by what displaces the far end by the tolerance.
        self._lines, self._circles = _Keys(8 * tolerance), _Keys(2 * tolerance)
        self._traced: dict[tuple[int, ...], list[int]] = {}
        self._tubes: dict[tuple[int, int, float, float], int] = {}
        self.of_planes: dict[tuple[int, int], int] = {}
        """Index of the line in which two planes meet, by their ids in the surface table, the smaller first."""

    def __getitem__(self, index: int) -> Carrier:
        return self.carriers[index]

    def finer(self, deviation: float) -> int:
        """By how many times more densely a curve is to be shown whose chords miss it by `deviation`."""
        return min(_FINEST, max(1, math.ceil(math.sqrt(deviation / self.chord))))

    def _append(self, carrier: Carrier) -> int:
        self.carriers.append(carrier)
        return len(self.carriers) - 1

    def line(self, point: Array, direction: Array) -> int:
        """The line through `point` along `direction` (any length but zero)."""
        unit = direction / np.linalg.norm(direction)
        unit = np.where(np.abs(unit) < 1e-12, 0.0, unit)
        unit /= np.linalg.norm(unit)
        if unit[int(np.argmax(np.abs(unit) > 1e-6))] < 0:
            unit = -unit
        foot = point - unit * (point @ unit)
        key = float(foot @ _SWEEP + self.reach * (unit @ _SWEEP))
        for index in self._lines.near(key):
            other = self.carriers[index]
            assert isinstance(other, Line)
            if (
                np.linalg.norm(other.point - foot) <= 2 * self.tolerance
                and np.abs(other.direction - unit).max() * self.reach <= 4 * self.tolerance
            ):
                return index
        index = self._append(Line(foot, unit))
        self._lines.add(key, index)
        return index

    def circle(self, centre: Array, normal: Array, radius: float) -> int:
        """The circle about `centre`, in the plane across `normal`."""
        unit = normal / np.linalg.norm(normal)
        if unit[int(np.argmax(np.abs(unit) > 1e-6))] < 0:
            unit = -unit
        key = float(centre @ _SWEEP)
        for index in self._circles.near(key):
            other = self.carriers[index]
            assert isinstance(other, Circle)
            if (
                np.linalg.norm(other.centre - centre) <= 2 * self.tolerance
                and abs(other.radius - radius) <= 2 * self.tolerance
                and np.abs(other.normal - unit).max() * radius <= 2 * self.tolerance
            ):
                return index
        frame = plane_frame(unit)
        count = _SAMPLES_PER_TURN * self.finer(radius * (1 - math.cos(math.pi / _SAMPLES_PER_TURN)))
        index = self._append(Circle(np.array(centre, float), unit, float(radius), frame.u, frame.v, count))
        self._circles.add(key, index)
        return index

    def _densely(self, points: Array, surfaces: Sequence[Surface], is_closed: bool) -> Array:
        """Points (n, 3) of a curve on surfaces with others between, where its chords miss it by more than they may."""
        after = np.roll(points, -1, axis=0) if is_closed else points[1:]
        before = points[: len(after)]
        middles = 0.5 * (before + after)
        missed = np.linalg.norm(project(middles, surfaces) - middles, axis=1).max(initial=0.0)
        count = self.finer(float(missed))
        if count == 1:
            return points
        shares = np.arange(count)[:, None] / count
        inner = before[:, None] * (1 - shares) + after[:, None] * shares
        found = project(inner.reshape(-1, 3), surfaces)
        return found if is_closed else np.vstack([found, points[-1:]])

    def find_traced(self, ids: tuple[int, ...], point: Array) -> int | None:
        """The traced curve of the surfaces `ids` that runs through `point` (3,), if there is one yet."""
        for index in self._traced.get(tuple(sorted(ids)), []):
            if float(distance_to(self.carriers[index], point[None])[0]) <= 4 * self.tolerance:
                return index
        return None

    def tube(self, ids: tuple[int, int], frame: TubeFrame, side: float) -> int:
        """The curve of that side (1 or -1) of two tubes whose ids in the surface table are `ids`."""
        key = (min(ids), max(ids), side, frame.pinch)
        if key not in self._tubes:
            curve = tube_curve(frame, side)
            finer = self.finer(curve.chord_deviation())
            self._tubes[key] = self._append(curve if finer == 1 else tube_curve(frame, side, finer))
        return self._tubes[key]

    def traced(self, ids: tuple[int, ...], surfaces: Sequence[Surface], guide: Array, is_closed: bool) -> int:
        """A new curve through `guide` (n, 3) on `surfaces`, whose ids in the surface table are `ids`."""
        points = self._densely(project(guide, surfaces), surfaces, is_closed)
        key = tuple(sorted(ids))
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        keep = np.ones(len(points), dtype=bool)
        keep[1:] = steps > min(4 * self.tolerance, 0.5 * float(steps.mean()))
        points = points[keep]
        if is_closed and np.linalg.norm(points[-1] - points[0]) <= 4 * self.tolerance:
            points = points[:-1]
        corners = np.vstack([points, points[:1]]) if is_closed else points
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
        index = self._append(Traced(tuple(surfaces), points, is_closed, lengths))
        self._traced.setdefault(key, []).append(index)
        return index
