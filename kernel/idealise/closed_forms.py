"""What mid-surfaces count more than once where walls meet, in closed form.

On a curve of length L the walls that leave it, seen along the curve, are rays with half a thickness on either side; a
wall that goes on beyond the curve is two rays. In each sector between neighbouring rays, of opening a, the mid-surfaces
count

    L [ (t^2 + t'^2) cos a + 2 t t' ] / (8 sin a)

more than there is; in a sector of more than 180 degrees less, for there the solid has a mitre. Together that comes to 0
for a corner at any angle, to t t' L / (2 sin a) for a tee, to t t' L / sin a for a cross.

Pipes of one radius and thickness t whose axes cross are tangent in the ends of that curve, half an ellipse, and have no
such sectors. But their walls are cut by planes through the crossing: a pipe that ends at the height c r cos(phi) above
it is counted c t^3 / 12 times the integral of cos(phi) too long. A mitre comes to 0, a tee to 2 t^3 / (3 sin a).

A wall that ends on a bent curve reaches half the other's slab deep over an area other than L times the depth: this
comes on top. Where three walls meet in a point, the rows of their three curves count the piece that all have in common
wrongly, by a multiple of t t' t'' / |det(n, n', n'')|: an affine map makes any three slabs orthogonal, and there it is
found by counting cells. A corner of three corners: - 1/4; two webs that cross on a flange: - 1/2; three walls that
cross: - 1.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import shapely
from numpy.typing import NDArray

from kernel.idealise.carriers import Circle, Line
from kernel.idealise.crossings import slab_edges
from kernel.idealise.outlines import unwrapped
from kernel.idealise.sheets import CylinderSheet
from kernel.idealise.stars import star_excess, star_moment
from kernel.idealise.topology import BOUNDARY, Curve, Topology
from kernel.idealise.tube_curve import TubeCurve
from kernel.idealise.walls import CROSSING_SINE, Wall

Array = NDArray[np.float64]
Plane = tuple[int, float]
"""A sheet, and the thickness of the walls on it: what is level and equally thick is one wall here."""

Row = tuple[tuple[str, ...], str, float]
"""Segments, cause, volume."""

SAMPLES = 64
"""Steps along a curve in which the angle of its walls is measured."""

NEAR = 0.25
"""How far from a corner it is asked which walls are there, as a share of the thinnest."""

SAME = 1e-9
"""Walls are equally thick when their thicknesses agree to this share of the model's size."""

PIPES = "pipes of one radius"
"""Cause of what their mid-surfaces count twice."""

SQUARE = 1e-14
"""A line whose cosine with a plane's normal is 1 to within this stands square to the plane."""

_LINES = ((0, 1), (0, 2), (1, 2))

_QUADRANTS = np.array([(2 * i - 1, 2 * j - 1) for i in (0, 1) for j in (0, 1)], dtype=np.float64)
"""Which way a quadrant lies along each of the two lines that part a plane."""


def closed_forms(topology: Topology, curves: Sequence[Curve], walls: Sequence[Wall]) -> Iterator[Row]:
    """A row for each curve on which walls of several planes meet, and for each point where those of three do."""
    by_face = {wall.index: wall for wall in walls}
    meeting: dict[int, list[dict[Plane, list[int]]]] = {}
    joined: list[tuple[Curve, dict[Plane, list[int]]]] = []
    for curve in curves:
        planes = _planes(topology, curve, by_face)
        if len(planes) > 1:
            for vertex in curve.vertices:
                meeting.setdefault(vertex, []).append(planes)
            joined.append((curve, planes))
    straight = _on_lines(topology, joined, by_face)
    for place, (curve, planes) in enumerate(joined):
        row = straight[place] if place in straight else _on_curve(topology, curve, planes, by_face)
        if row is not None:
            yield row
    for vertex, found in sorted(meeting.items()):
        at_point: dict[Plane, list[int]] = {}
        for faces in found:
            for plane, numbers in faces.items():
                at_point.setdefault(plane, []).extend(numbers)
        if len(at_point) == 3 and all(len(faces) == 2 for faces in found):
            row = _in_point(topology.vertices.points[vertex], at_point, by_face)
            if row is not None:
                yield row


def _planes(topology: Topology, curve: Curve, by_face: dict[int, Wall]) -> dict[Plane, list[int]]:
    """The faces that use a curve, by plane."""
    found: dict[Plane, list[int]] = {}
    step = SAME * topology.carriers.reach
    for face in curve.uses:
        wall = by_face[face]
        found.setdefault((wall.sheet.surface_id, round(wall.thickness / step) * step), []).append(face)
    return dict(sorted(found.items()))


# ---------------------------------------------------------------- curves


def _on_lines(
    topology: Topology, joined: Sequence[tuple[Curve, dict[Plane, list[int]]]], by_face: dict[int, Wall]
) -> dict[int, Row | None]:
    """The rows of the straight curves, by place: all along such a curve the star of its walls is one."""
    stars: dict[int, list[tuple[int, Array, list[_Ray]]]] = {}
    for place, (curve, planes) in enumerate(joined):
        carrier = topology.carrier(curve.carrier)
        if isinstance(carrier, Line):
            rays = _rays(curve, planes, by_face, carrier.at(np.array([0.5 * (curve.start + curve.end)])))
            stars.setdefault(len(rays), []).append((place, carrier.direction, rays))
    rows: dict[int, Row | None] = {}
    for alike in stars.values():
        tangents = np.array([tangent for _, tangent, _ in alike])
        inward = np.array([[ray.normal * ray.sign for ray in rays] for _, _, rays in alike]).swapaxes(0, 1)
        thicknesses = np.array([[ray.thickness for ray in rays] for _, _, rays in alike]).T
        excess = star_excess(_angles(np.cross(inward, tangents), tangents), thicknesses)
        for (place, _, rays), area in zip(alike, excess.tolist(), strict=True):
            curve, planes = joined[place]
            rows[place] = None if math.isnan(area) else _row(planes, by_face, len(rays), curve.length * area)
    return rows


@dataclass(frozen=True, slots=True)
class _Ray:
    """A wall that leaves a curve: along sign * normal x tangent."""

    normal: Array
    sign: float
    thickness: float


def _rays(curve: Curve, planes: dict[Plane, list[int]], by_face: dict[int, Wall], middle: Array) -> list[_Ray]:
    """The rays of a straight curve; middle: the point (1, 3) amid it. A wall that goes on beyond it is two."""
    found = []
    for face in (face for faces in planes.values() for face in faces):
        wall, use = by_face[face], curve.uses[face]
        normal, sign = wall.sheet.normals(middle)[0], 1.0 if use.forward else -1.0
        found += [_Ray(normal, each, wall.thickness) for each in ((sign,) if use.role == BOUNDARY else (sign, -sign))]
    return found


def _row(planes: dict[Plane, list[int]], by_face: dict[int, Wall], n_ray: int, volume: float) -> Row:
    kind = {(2, 2): "corner", (2, 3): "tee", (2, 4): "cross"}.get((len(planes), n_ray), "walls on one line")
    return tuple(by_face[face].segment.id for faces in planes.values() for face in faces), kind, volume


def _on_curve(topology: Topology, curve: Curve, planes: dict[Plane, list[int]], by_face: dict[int, Wall]) -> Row | None:
    """The row of a bent curve; None where its walls meet at hardly any angle."""
    carrier = topology.carrier(curve.carrier)
    if isinstance(carrier, TubeCurve):
        return _on_tubes(carrier, curve, by_face)
    stations = np.linspace(curve.start, curve.end, 2 * SAMPLES + 1)
    points = carrier.at(stations)
    middles = points[1::2]
    steps = np.linalg.norm(points[2::2] - points[:-2:2], axis=1)
    if isinstance(carrier, Circle):
        steps = np.full(SAMPLES, curve.length / SAMPLES)
    tangents = (points[2::2] - points[:-2:2]) / np.linalg.norm(points[2::2] - points[:-2:2], axis=1, keepdims=True)
    rays: list[Array] = []
    thicknesses: list[float] = []
    ending: list[tuple[Wall, Array]] = []
    for faces in planes.values():
        for face in faces:
            wall, use = by_face[face], curve.uses[face]
            inward = np.cross(wall.sheet.normals(middles), tangents) * (1.0 if use.forward else -1.0)
            sides = (inward,) if use.role == BOUNDARY else (inward, -inward)
            rays += sides
            thicknesses += [wall.thickness] * len(sides)
            if use.role == BOUNDARY and len(faces) == 1:
                ending.append((wall, inward))
    excess = star_excess(_angles(np.stack(rays), tangents), np.array(thicknesses)[:, None])
    if np.isnan(excess).any():
        return None
    volume = float(steps @ excess)
    if len(planes) == 2:
        for wall, inward in ending:
            (other,) = (by_face[faces[0]] for faces in planes.values() if by_face[faces[0]].sheet is not wall.sheet)
            normals = other.sheet.normals(middles)
            depth = 0.5 * other.thickness / np.linalg.norm(np.cross(wall.sheet.normals(middles), normals), axis=1)
            side = float(np.sign(np.einsum("ni,ni->n", inward, normals).sum()))
            volume += wall.thickness * (strip_area(topology, curve, wall, other, side) - float(steps @ depth))
    return _row(planes, by_face, len(rays), volume)


def _on_tubes(carrier: TubeCurve, curve: Curve, by_face: dict[int, Wall]) -> Row | None:
    """The row of pipes of one radius and thickness, whose curve is half an ellipse; None for others."""
    frame = carrier.frame
    uses = [(by_face[face], use) for face, use in curve.uses.items()]
    if max(frame.gaps) or frame.pinch or len({wall.thickness for wall, _ in uses}) > 1:
        return None
    ends = carrier.at(np.array([curve.start, 0.5 * (curve.start + curve.end), curve.end]))
    sines = (ends - frame.origin) @ frame.n / frame.small.radius
    tangent = carrier.at(np.array([0.5 * (curve.start + curve.end) + 1e-3 * curve.length]))[0] - ends[1]
    volume = 0.0
    for wall, use in uses:
        if use.role == BOUNDARY and isinstance(wall.sheet, CylinderSheet):
            axis = wall.sheet.axis.direction
            inward = np.cross(wall.sheet.normals(ends[1:2])[0], tangent) * (1.0 if use.forward else -1.0)
            slope = float((ends[1] - frame.origin) @ axis) / (wall.sheet.radius * np.sqrt(1 - sines[1] ** 2))
            volume += float(np.sign(inward @ axis)) * slope * abs(sines[2] - sines[0]) * wall.thickness**3 / 12
    return tuple(dict.fromkeys(wall.segment.id for wall, _ in uses)), PIPES, volume


def _angles(rays: Array, tangents: Array) -> Array:
    """Angles (ray, n) about the tangents (n, 3) of unit vectors (ray, n, 3) across them, from the first."""
    across = np.cross(tangents, rays[0])
    return np.arctan2(np.einsum("rni,ni->rn", rays, across), np.einsum("rni,ni->rn", rays, rays[0]))


def strip_area(topology: Topology, curve: Curve, wall: Wall, other: Wall, side: float) -> float:
    """Area of the wall's sheet between a joint curve and the other's face, on the side of its normal (1) or the far."""
    carrier = topology.carrier(curve.carrier)
    values = []
    for count in (SAMPLES, 2 * SAMPLES, 4 * SAMPLES):
        points = carrier.at(np.linspace(curve.start, curve.end, count + 1))
        edge = slab_edges(wall, other, points, 0.0, carrier)[0 if side > 0 else 1]
        inner, outer = unwrapped(wall.sheet, points), unwrapped(wall.sheet, edge)
        if wall.sheet.turn is not None:
            outer = outer + (wall.sheet.turn * np.round((inner[0, 0] - outer[0, 0]) / wall.sheet.turn), 0.0)
        x, y = np.vstack([inner, outer[::-1], inner[:1]]).T
        values.append(0.5 * abs(float(np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]))))
    coarse, medium, fine = values  # Richardson's extrapolation, twice
    return (16 * (4 * fine - medium) - (4 * medium - coarse)) / 45


# ---------------------------------------------------------------- points


def _in_point(point: Array, planes: dict[Plane, list[int]], by_face: dict[int, Wall]) -> Row | None:
    """The row of one point; None where two of its walls meet at hardly any angle."""
    groups = [[by_face[face] for face in dict.fromkeys(faces)] for _, faces in sorted(planes.items())]
    walls = [group[0] for group in groups]
    normals = np.stack([wall.sheet.normals(point[None])[0] for wall in walls])
    determinant = abs(float(np.linalg.det(normals)))
    if determinant < CROSSING_SINE**2:
        return None
    lines = np.linalg.inv(normals).T  # lines[k] lies in the two other planes, and leads to the side of normal k
    lines /= np.linalg.norm(lines, axis=1, keepdims=True)
    step = NEAR * min(wall.thickness for wall in walls)
    quadrants = np.zeros((3, 2, 2), dtype=bool)
    for place, group in enumerate(groups):
        first, second = (k for k in range(3) if k != place)
        flat = group[0].sheet.flat(point + step * (_QUADRANTS @ lines[[first, second]]))
        inside = [shapely.contains_xy(wall.region, flat[:, 0], flat[:, 1]) for wall in group]
        quadrants[place] = np.any(inside, axis=0).reshape(2, 2)
    names = tuple(dict.fromkeys(wall.segment.id for group in groups for wall in group))
    thicknesses = np.array([wall.thickness for wall in walls])
    volume = _known_share(quadrants.tobytes()) / determinant * float(thicknesses.prod())
    return names, "three walls in a point", volume + _slanted_ends(normals, lines, quadrants, thicknesses)


def _slanted_ends(normals: Array, lines: Array, quadrants: NDArray[np.bool_], thicknesses: Array) -> float:
    """What comes on top where the third plane does not stand square to the line of two walls.

    Counting cells ends each line of two walls at a plane parallel to the third, but the rows of curves are as long as
    the curve itself: the first moment of their excess makes the difference.
    """
    volume = 0.0
    for axis in range(3):
        pair = [k for k in range(3) if k != axis]
        for side in (0, 1):
            along = (2 * side - 1) * lines[axis]
            if abs(float(normals[axis] @ along)) > 1.0 - SQUARE:
                continue  # the moment lies in the third plane
            rays, thick = [], []
            for wall in pair:
                (other,) = (k for k in pair if k != wall)
                inside = np.take(quadrants[wall], side, axis=[k for k in range(3) if k != wall].index(axis))
                for sign in (-1.0, 1.0):
                    if inside[int(sign > 0)]:
                        ray = sign * (lines[other] - (lines[other] @ along) * along)
                        rays.append(ray / np.linalg.norm(ray))
                        thick.append(thicknesses[wall])
            if len(rays) < 2:
                continue
            frame = np.stack([rays[0], np.cross(along, rays[0])])
            moment = star_moment(np.stack(rays) @ frame.T, np.array(thick)) @ frame
            volume += float(normals[axis] @ moment) / float(normals[axis] @ along)
    return volume


@lru_cache
def _known_share(quadrants: bytes) -> float:
    """corner_share of the bytes of its argument: corners of a model are of few kinds."""
    return corner_share(np.frombuffer(quadrants, dtype=bool).reshape(3, 2, 2))


def corner_share(quadrants: NDArray[np.bool_]) -> float:
    """What the curves' rows leave over in a point, as a multiple of the common piece of three orthogonal slabs.

    quadrants: (3, 2, 2) which quadrants of its plane each wall fills; the first wall lies across x and its quadrants
    are by the signs of y and z, the second across y (x, z), the third across z (x, y). Slabs of thickness 1 in a box
    from -1 to 1 are cut into cells at -1/2, 0 and 1/2, all of them equally large.
    """
    filled = np.zeros((4, 4, 4), dtype=bool)
    for place in range(3):
        first, second = (k for k in range(3) if k != place)
        for i, j in itertools.product((0, 1), repeat=2):
            if not quadrants[place, i, j]:
                continue
            # a wall that ends at another goes on to that one's far face
            more = (_is_on(quadrants, first, second, j), _is_on(quadrants, second, first, i))
            ranges: list[slice] = [slice(0, 4)] * 3
            ranges[place] = slice(1, 3)
            ranges[first] = _reach(i, more[0])
            ranges[second] = _reach(j, more[1])
            filled[tuple(ranges)] = True
    excess = float(quadrants.sum()) - filled.sum() / 8
    for one, other in _LINES:
        (along,) = {0, 1, 2} - {one, other}
        for side in (0, 1):
            halves = sorted(_count(quadrants, wall, along, side) for wall in (one, other))
            excess -= {(1, 2): 0.5, (2, 2): 1.0}.get((halves[0], halves[1]), 0.0)
    return excess


def _count(quadrants: NDArray[np.bool_], wall: int, axis: int, side: int) -> int:
    """How many quadrants of a wall lie on one side along an axis."""
    axes = [k for k in range(3) if k != wall]
    return int(np.take(quadrants[wall], side, axis=axes.index(axis)).sum())


def _is_on(quadrants: NDArray[np.bool_], wall: int, axis: int, side: int) -> bool:
    return _count(quadrants, wall, axis, side) > 0


def _reach(side: int, is_longer: bool) -> slice:
    """The cells of a half axis, and half a thickness more."""
    if side:
        return slice(1 if is_longer else 2, 4)
    return slice(0, 3 if is_longer else 2)
