r"""Where two tubes of nearly equal radius meet: in closed form, for such curves bend sharply, or have corners.

    across both axes, n up            from above, along n, for equal radii:

          . - ~ - .   top             \    /      Along the smaller tube, at the angle phi from m towards n, the curve
        /   _____   \                  \  /       runs at the height
       |  /       \  |  n               \/
       | |    o    | |  ^               /\            s = (sign sqrt(R^2 - y^2) - r cos(phi) cos(a)) / sin(a)
       |  \ _____ /  |  |              /  \
        \           /   o--> m        /    \      with y = e + r sin(phi): e the distance of the axes, a their angle.
          ` - _ - `   bottom

The two signs are the two curves. They come near one another at the top and the bottom, where they bend; there they
touch, with corners, where the radii are equal.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kernel.solid.surfaces import CylinderSurface, Surface, cross

Array = NDArray[np.float64]

SHARP = 0.25
"""Tubes that meet somewhere at less than this sine (15 degrees) have their curve here, with vertices at its bends."""

LEAST_ANGLE = 0.17
"""Tubes whose axes are nearer than this sine (10 degrees) to parallel meet at no angle all along their curve."""

_STEPS = 40
"""Table steps by radian in the middle of a lobe; they are as dense as the curve bends at its ends."""

_NEWTON = 6

_NEAR_STOP = 0.4 * np.linspace(0.0, 1.0, 17) ** 2
"""Radians before a side of a slab comes to an end where it has its points: evenly along it, as it turns square."""

_TURN = 2 * np.pi

_GAUSS = np.polynomial.legendre.leggauss(6)


@dataclass(frozen=True, slots=True, eq=False)
class TubeFrame:
    """Two tubes whose axes cross at an angle, the smaller one inside the other where it passes through its wall.

    origin: (3,) the point of the small axis nearest to the large one. m, n, direction: unit vectors (3,), n along the
    common normal of the axes, direction along the small axis. offset: of the origin from the large axis, along n.
    gaps: by how much the large radius exceeds what the small tube takes, at its top and its bottom. pinch: by how much
    the large one was made smaller.
    """

    small: CylinderSurface
    large: CylinderSurface
    origin: Array
    m: Array
    n: Array
    direction: Array
    offset: float
    cosine: float
    sine: float
    gaps: tuple[float, float]
    pinch: float = 0.0

    def root(self, angles: Array) -> Array:
        """sqrt(R^2 - y^2) at angles (n,), without cancellation where it is small."""
        return np.asarray(np.sqrt(self._below(angles) * self._above(angles)))

    def _below(self, angles: Array) -> Array:
        """R - y."""
        return self.gaps[0] + 2 * self.small.radius * np.sin(0.5 * (0.5 * np.pi - angles)) ** 2

    def _above(self, angles: Array) -> Array:
        """R + y."""
        return self.gaps[1] + 2 * self.small.radius * np.sin(0.5 * (0.5 * np.pi + angles)) ** 2

    def place(self, angles: Array, along: Array, radius: float | None = None, depth: Array | None = None) -> Array:
        """Points (n, 3) at angles and heights on the small tube; on one of another `radius`, its n parts being `depth`.

        depth: along n from the large axis.
        """
        size = self.small.radius if radius is None else radius
        up = size * np.sin(angles) if depth is None else depth - self.offset
        flat = np.outer(size * np.cos(angles), self.m) + np.outer(up, self.n)
        return np.asarray(self.origin + flat + along[:, None] * self.direction)

    def angles(self, points: Array) -> Array:
        """Angles (n,) of points (n, 3) about the small axis, from the bottom round to it again."""
        relative = points - self.origin
        angle = np.arctan2(relative @ self.n, relative @ self.m)
        return np.asarray(np.mod(angle + 0.5 * np.pi, _TURN) - 0.5 * np.pi)

    def sign(self, points: Array) -> float:
        """The curve (1 or -1) to which points (n, 3) belong, taken together."""
        across = cross(self.n, self.large.axis.direction)
        return 1.0 if float(((points - self.large.axis.point) @ across).sum()) >= 0 else -1.0

    @property
    def least_sine(self) -> float:
        """Sine of the least angle at which the two meet, at the top or the bottom."""
        height = self.large.radius - min(self.gaps)
        return float(np.sqrt(max(0.0, 1.0 - (height / self.large.radius) ** 2)))


def tube_frame(a: Surface, b: Surface, tolerance: float) -> TubeFrame | None:
    """The frame of two cylinders, the first one being the smaller of two as large; None where none goes through."""
    if not isinstance(a, CylinderSurface) or not isinstance(b, CylinderSurface):
        return None
    small, large = (a, b) if a.radius <= b.radius + tolerance else (b, a)
    normal = cross(large.axis.direction, small.axis.direction)
    sine = float(np.linalg.norm(normal))
    if sine < LEAST_ANGLE:
        return None
    n = normal / sine
    apart = small.axis.point - large.axis.point
    offset = float(apart @ n)
    # the foot of the common normal on the small axis
    along = float(cross(apart, large.axis.direction) @ n) / -sine
    origin = small.axis.point - along * small.axis.direction
    gaps = [large.radius - small.radius - offset, large.radius - small.radius + offset]
    if min(gaps) < -tolerance:
        return None
    kept = [0.0 if gap <= tolerance else gap for gap in gaps]
    cosine = float(large.axis.direction @ small.axis.direction)
    m = cross(n, small.axis.direction)
    return TubeFrame(small, large, origin, m, n, small.axis.direction, offset, cosine, sine, (kept[0], kept[1]))


def pinched(frame: TubeFrame) -> TubeFrame:
    """The same with both radii equal and both axes in one plane, the large tube giving way."""
    large = CylinderSurface(frame.large.axis, frame.large.axis_id, frame.small.radius)
    return replace(frame, large=large, offset=0.0, gaps=(0.0, 0.0), pinch=max(frame.gaps))


@dataclass(frozen=True, slots=True, eq=False)
class TubeCurve:
    """One of the two curves of a frame, by length from the bottom of the small tube.

    angles, lengths: (k,) the table, whose middle entry is the top; speeds: (k - 1, 2) length by angle at both ends of
    each step. guide: (k - 1, 3) the points at the table's entries, the last one left out.
    """

    frame: TubeFrame
    side: float
    angles: Array
    lengths: Array
    speeds: Array
    guide: Array
    is_closed = True

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """Both tubes."""
        return (self.frame.small, self.frame.large)

    @property
    def period(self) -> float:
        """Length all round."""
        return float(self.lengths[-1])

    @property
    def bends(self) -> tuple[float, float]:
        """Parameters of the bottom and the top, where the curve bends sharply."""
        return 0.0, float(self.lengths[len(self.lengths) // 2])

    def is_bend(self, value: float, tolerance: float) -> bool:
        """Whether a parameter is that of a bend, in any turn."""
        away = np.array(self.bends) - value
        return bool(np.abs(away - self.period * np.round(away / self.period)).min() <= tolerance)

    def clear_of_bends(self, half: float) -> tuple[tuple[float, float], tuple[float, float]]:
        """By lobe, the parameters between which walls of thickness 2 half do not merge; of no length where they do."""
        bottom, top = self.bends
        found = []
        for low, high in ((bottom, top), (top, self.period)):
            values = np.concatenate([[low], self.breaks(low, high), [high]])
            angles = self.frame.angles(self.at(values))
            is_clear = np.minimum(self.frame._below(angles), self.frame._above(angles)) > half + self.frame.pinch
            ends = values[is_clear][[0, -1]] if is_clear.any() else np.full(2, 0.5 * (low + high))
            found.append((float(ends[0]), float(ends[1])))
        return found[0], found[1]

    def _at_angles(self, angles: Array) -> Array:
        frame = self.frame
        height = (self.side * frame.root(angles) - frame.small.radius * np.cos(angles) * frame.cosine) / frame.sine
        return frame.place(angles, height)

    def at(self, parameters: Array) -> Array:
        """Points (n, 3), on both tubes."""
        values = np.mod(np.asarray(parameters, float), self.lengths[-1])
        step = np.clip(np.searchsorted(self.lengths, values, side="right") - 1, 0, len(self.speeds) - 1)
        low, high = self.angles[step], self.angles[step + 1]
        angles = low + (high - low) * (values - self.lengths[step]) / (self.lengths[step + 1] - self.lengths[step])
        for _ in range(_NEWTON):
            length, speed = self._length(step, angles)
            angles = np.clip(angles - (length - values) / speed, low, high)
        return self._at_angles(angles)

    def parameters(self, points: Array) -> Array:
        """Parameters (n,) in [0, period) of the points of the curve at the angles of points (n, 3)."""
        angles = self.frame.angles(points)
        step = np.clip(np.searchsorted(self.angles, angles, side="right") - 1, 0, len(self.speeds) - 1)
        return np.asarray(np.mod(self._length(step, angles)[0], self.lengths[-1]))

    def _length(self, step: NDArray[np.int64], angles: Array) -> tuple[Array, Array]:
        """Length and speed (n,) at angles within steps of the table: cubics with the table's lengths and speeds."""
        width = self.angles[step + 1] - self.angles[step]
        share = (angles - self.angles[step]) / width
        rise = self.lengths[step + 1] - self.lengths[step]
        first, last = self.speeds[step, 0] * width, self.speeds[step, 1] * width
        square, cube = 3 * rise - 2 * first - last, first + last - 2 * rise
        length = self.lengths[step] + share * (first + share * (square + share * cube))
        return length, (first + share * (2 * square + share * 3 * cube)) / width

    def chord_deviation(self) -> float:
        """By how much a polyline through the table's points misses the curve at most."""
        after = np.roll(self.guide, -1, axis=0)
        amid = self._at_angles(0.5 * (self.angles[:-1] + self.angles[1:]))
        along = (after - self.guide) / np.linalg.norm(after - self.guide, axis=1, keepdims=True)
        return float(np.linalg.norm(np.cross(amid - self.guide, along), axis=1).max())

    def breaks(self, start: float, end: float) -> Array:
        """The table's own lengths between start and end."""
        period = self.period
        turns = range(int(np.floor(start / period)), int(np.floor(end / period)) + 1)
        values = np.concatenate([self.lengths[:-1] + turn * period for turn in turns])
        margin = 1e-6 * period
        return values[(values > start + margin) & (values < end - margin)]


def tube_curve(frame: TubeFrame, side: float, finer: int = 1) -> TubeCurve:
    """The curve of that sign (1 or -1). finer: how many times more entries its table has than usual."""
    half = [_lobe(frame, finer, top) for top in (False, True)]
    angles = np.concatenate([half[0][0][:-1], half[0][1]])
    lengths = [np.zeros(1)]
    speeds = []
    for (low, high), facing in ((half[0], 1.0), (half[1], -1.0)):
        nodes = np.concatenate([low[:-1], high])
        steps = np.stack([nodes[:-1], nodes[1:]], axis=1)
        speeds.append(np.stack([_speed(frame, side, steps[:, end], facing) for end in (0, 1)], axis=1))
        at = steps[:, :1] + 0.5 * (1 + _GAUSS[0]) * np.diff(steps, axis=1)
        within = _speed(frame, side, at.ravel(), facing).reshape(at.shape)
        lengths.append(lengths[-1][-1] + np.cumsum(0.5 * np.diff(steps, axis=1)[:, 0] * (within @ _GAUSS[1])))
        if facing < 0:
            angles = np.concatenate([angles, nodes[1:]])
    curve = TubeCurve(frame, side, angles, np.concatenate(lengths), np.vstack(speeds), np.empty((0, 3)))
    return TubeCurve(frame, side, angles, curve.lengths, curve.speeds, curve._at_angles(angles[:-1]))


def _lobe(frame: TubeFrame, finer: int, far: bool) -> tuple[Array, Array]:
    """Angles from one bend to the middle of a lobe, and from there to the other; far: of the lobe facing -m."""
    quarter = 0.5 * np.pi
    ends = []
    for gap in frame.gaps:  # top, bottom
        width = np.sqrt(gap / frame.small.radius) if gap else 1.0
        reach = np.arcsinh(quarter / width)
        steps = np.linspace(0.0, reach, finer * int(np.ceil(_STEPS * reach)) + 1)
        ends.append(np.minimum(width * np.sinh(steps), quarter))
        ends[-1][-1] = quarter
    top, bottom = ends
    if far:
        return quarter + top, 3 * quarter - bottom[::-1]
    return bottom - quarter, quarter - top[::-1]


def _speed(frame: TubeFrame, side: float, angles: Array, facing: float) -> Array:
    """Length of the curve by angle, at angles (n,) of the lobe that faces m (1) or away from it (-1)."""
    radius, (top, bottom) = frame.small.radius, frame.gaps
    below, above = frame._below(angles), frame._above(angles)
    # cos(phi) / sqrt(R - y) / sqrt(R + y), each factor of the cosine with the root that vanishes with it
    from_top, from_bottom = 0.5 * (0.5 * np.pi - angles), 0.5 * (0.5 * np.pi + angles)
    low = np.sqrt(0.5 / radius) if top == 0.0 else np.abs(np.sin(from_top)) / np.sqrt(below)
    high = np.sqrt(0.5 / radius) if bottom == 0.0 else np.abs(np.sin(from_bottom)) / np.sqrt(above)
    steep = facing * 2 * low * high * (frame.offset + radius * np.sin(angles)) * radius
    slope = (radius * np.sin(angles) * frame.cosine - side * steep) / frame.sine
    return np.asarray(np.hypot(radius, slope))


def slab_stations(curve: TubeCurve, on: Surface, half: float, start: float, end: float) -> Array:
    """Parameters from start to end at which `slab_sides` shows the bends of both sides, also where one stops short."""
    frame = curve.frame
    small, large = frame.small.radius, frame.large.radius
    angles = []
    for away in (-half - frame.pinch, half + frame.pinch):
        for end_sign in (1.0, -1.0):  # where a side comes to the line midway, at the top and the bottom
            reach = (
                (large + away - end_sign * frame.offset, small)
                if on is frame.small
                else (large - end_sign * frame.offset, small + away)
            )
            if reach[0] < reach[1]:
                stop = end_sign * np.arcsin(reach[0] / reach[1])
                inwards = stop - end_sign * _NEAR_STOP
                angles += [inwards, np.pi - inwards]
    places = curve.frame.place(np.concatenate([np.zeros(0), *angles]), np.zeros(sum(map(len, angles))))
    inner = curve.parameters(places)
    inner = inner + curve.period * np.ceil((start - inner) / curve.period)
    margin = 1e-9 * curve.period
    inner = inner[(inner > start + margin) & (inner < end - margin)]
    return np.unique(np.concatenate([[start], curve.breaks(start, end), inner, [end]]))


def slab_sides(curve: TubeCurve, on: Surface, points: Array, half: float) -> tuple[Array, Array]:
    """Where the tube `on` leaves the other one's wall of thickness 2 half, on its inner side and its outer.

    points: (n, 3) of the curve, each giving a point at the same angle. Where a side does not reach so far, the
    result runs on along the tube's line midway between the two curves, so that their slabs part the tube there. Of
    pinched tubes the slabs are thicker by as much, to hold the walls where they are and where they are taken to be.
    """
    frame = curve.frame
    angles = frame.angles(points)
    sides = []
    for away in (-half - frame.pinch, half + frame.pinch):
        if on is frame.small:
            reach = frame.large.radius + away
            depth = frame.offset + frame.small.radius * np.sin(angles)
            root = np.sqrt(np.maximum(reach * reach - depth * depth, 0.0))
            along = (curve.side * root - frame.small.radius * np.cos(angles) * frame.cosine) / frame.sine
            sides.append(frame.place(angles, along))
        else:
            radius = frame.small.radius + away
            large = frame.large.radius
            depth = np.clip(frame.offset + radius * np.sin(angles), -large, large)
            root = np.sqrt((large - depth) * (large + depth))
            along = (curve.side * root - radius * np.cos(angles) * frame.cosine) / frame.sine
            sides.append(frame.place(angles, along, radius, depth))
    return sides[0], sides[1]
